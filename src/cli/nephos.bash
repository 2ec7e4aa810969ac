# SPDX-License-Identifier: Apache-2.0
#
# Completion for bash: commands, the options that `nephos COMMAND --help` lists, and files.
_nephos()
{
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} program=${COMP_WORDS[0]}
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        mapfile -t COMPREPLY < <(compgen -W "$("$program" --help 2>/dev/null |
            sed -n 's/^  \([a-z]\{3,9\}\)  .*/\1/p') --help --version" -- "$word")
        return
    fi
    case "$before" in
    --precision) mapfile -t COMPREPLY < <(compgen -W "f32 f64" -- "$word"); return ;;
    --plan) mapfile -t COMPREPLY < <(compgen -W "full" -- "$word"); return ;;
    --method) mapfile -t COMPREPLY < <(compgen -W "path light single photonmap shdom temporal_photons principal_ordinates" -- "$word"); return ;;
    --interface) mapfile -t COMPREPLY < <(compgen -W "opencl cuda cuda_fast vulkan webgpu" -- "$word"); return ;;
    --plot) mapfile -t COMPREPLY < <(compgen -W "log linear polar" -- "$word"); return ;;
    --particle) mapfile -t COMPREPLY < <(compgen -W "water ice soot" -- "$word"); return ;;
    --sizes) mapfile -t COMPREPLY < <(compgen -W "single lognormal gamma modified_gamma" -- "$word"); return ;;
    phase) mapfile -t COMPREPLY < <(compgen -fW "mie ice snow isotropic hg two_lobe rayleigh draine" -- "$word"); return ;;
    --flip) mapfile -t COMPREPLY < <(compgen -W "hdr ldr" -- "$word"); return ;;
    --show) mapfile -t COMPREPLY < <(compgen -W "$("$program" diagnose --list 2>/dev/null | awk '{print $2}')" -- "$word"); return ;;
    esac
    case "$word" in
    -*)
        mapfile -t COMPREPLY < <(compgen -W "$("$program" "${COMP_WORDS[1]}" --help 2>/dev/null |
            sed -n 's/^  .\{4\}\(--[a-z-]*\).*/\1/p')" -- "$word")
        ;;
    *) mapfile -t COMPREPLY < <(compgen -f -- "$word") ;;
    esac
}
complete -o filenames -F _nephos nephos
