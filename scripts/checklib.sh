# shellcheck shell=bash
# SPDX-License-Identifier: Apache-2.0
#
# What scripts/check is made of: steps that are counted, builds, test runs, the summary. Sourced; works in build-check/.
work=build-check
results=$work/results-$$.txt

begin() {
    mkdir -p "$work"
    : >"$results"
    trap 'rm -f "$results"' EXIT
}

# record STATE SECONDS NAME
record() { printf '%s\t%s\t%s\n' "$@" >>"$results"; }

seconds_since() { awk -v a="$1" -v b="$(date +%s.%N)" 'BEGIN { printf "%.3f", b - a }'; }

# step NAME COMMAND...: one counted check; its output is shown.
step() {
    local name=$1 began state=passed
    shift
    echo "== $name"
    began=$(date +%s.%N)
    "$@" </dev/null || state=failed
    record $state "$(seconds_since "$began")" "$name"
    [ $state = passed ] || echo "FAILED: $name"
    [ $state = passed ]
}

skip() {
    echo "== $1: skipped, $2"
    record skipped 0 "$1: $2"
}

# build_tree DIR COMPILER SETUP_ARGUMENTS...: a build folder, made anew when its recipe changed.
build_tree() {
    local dir=$work/$1 compiler=$2
    # builds that differ in a few flags compile many files alike: once
    export CCACHE_DIR=${CCACHE_DIR:-$PWD/$work/ccache}
    ! command -v ccache >/dev/null || compiler="ccache $compiler"
    shift 2
    if [ "$(cat "$dir/recipe" 2>/dev/null)" != "$compiler $*" ]; then
        rm -rf "$dir"
        CC=$compiler CFLAGS='' LDFLAGS='' meson setup "$dir" "$@" >"$dir.log" 2>&1 || { cat "$dir.log"; return 1; }
        echo "$compiler $*" >"$dir/recipe"
    fi
    # quiet unless something is said
    ninja -C "$dir" >"$dir.log" 2>&1 || { grep -vE '^(\[[0-9]+/|ninja: Entering)' "$dir.log" | tail -n 60; return 1; }
}

# run_tests LABEL DIR [TIMEOUT_MULTIPLIER [SUITE...]]: every test program, or those of the suites, its cases counted one by one.
run_tests() {
    local label=$1 dir=$work/$2 multiplier=${3:-1} suites=()
    for suite in "${@:4}"; do suites+=(--suite "$suite"); done
    echo "== tests, $label"
    rm -rf "$dir/cases" "$dir/meson-logs/testlog.json"
    mkdir -p "$dir/cases"
    NEPHOS_TEST_LOGS=$PWD/$dir/cases meson test -C "$dir" --no-rebuild --timeout-multiplier "$multiplier" "${suites[@]}" \
        >"$dir.test.log" 2>&1 </dev/null
    scripts/test_report "$label" "$dir" "$dir/cases" "$results" "${@:4}" ||
        { [ -f "$dir/meson-logs/testlog.json" ] || { record failed 0 "$label tests did not start"; cat "$dir.test.log"; }; }
}

# The ten slowest, what failed, what was skipped, and the last line; the status to exit with.
summary() {
    local failed
    printf '\nThe ten slowest:\n'
    sort -t$'\t' -k2,2 -rg "$results" | awk -F'\t' '$3 != "" && n++ < 10 { printf "%9.3f s  %s\n", $2, $3 }'
    grep -q '^skipped' "$results" && printf '\nSkipped:\n' && awk -F'\t' '$1 == "skipped" { print "  " $3 }' "$results"
    grep -q '^failed' "$results" && printf '\nFailed:\n' && awk -F'\t' '$1 == "failed" { print "  " $3 }' "$results"
    printf '\n%d seconds\n' $SECONDS
    failed=$(grep -c '^failed' "$results")
    awk -F'\t' '{ n[$1]++ } END { printf "%d passed, %d failed, %d skipped\n",
        n["passed"] - n["retracted"], n["failed"], n["skipped"] }' "$results"
    [ "$failed" -eq 0 ]
}
