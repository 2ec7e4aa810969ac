/* SPDX-License-Identifier: Apache-2.0
 *
 * Every known bug (core/bug.h) is found by the suite: its tests run against kernels that make it, and one must fail. For
 * each bug the table names the test that is tried first, the quickest that is known to find it; when that one passes all
 * others are tried. Without a bug the same programs pass. */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/bug.h"
#include "harness.h"

typedef struct Known {
    int number;
    const char *name, *what;
} Known;
#define ROW(number, name, what) {number, name, what},
static const Known known[] = {NPH_KNOWN_BUGS(ROW)};
enum { BUGS = sizeof known / sizeof known[0] };

typedef struct Trial {
    const char *program, *title;
} Trial;

#define TRANSMITTANCE {"closed_forms", "transmittance_through_analytic_densities_is_beer_lamberts"}
#define SINGLE {"closed_forms", "single_scattering_of_a_slab_is_the_closed_form"}
#define SIX_WAYS {"closed_forms", "one_medium_written_six_ways_is_one_picture"}
#define KNOBS {"estimators", "no_knob_changes_the_mean"}
#define CHANNELS {"estimators", "each_channel_of_chromatic_media_has_the_mean_of_grey_media"}
#define WHITE_MAP {"furnace", "a_white_map_found_by_light_samples_and_by_chance_is_a_furnace"}
#define BEAM {"half_space", "a_half_space_under_a_beam_is_chandrasekhars"}
#define PLANE_ALBEDO {"half_space", "the_plane_albedo_of_a_half_space_is_chandrasekhars"}
#define SUN {"lights", "a_sun_gives_its_irradiance_times_cosine_and_transmittance"}
#define DISC {"lights", "a_suns_disc_has_its_irradiance_over_pi_sin_squared"}
#define POINT {"lights", "a_point_light_falls_off_with_the_square_of_its_distance"}
#define HALVES {"lights", "half_of_the_sky_gives_pi_to_a_sensor_that_faces_it_and_nothing_to_one_that_does_not"}

/* By number of the bug. */
static const Trial first[] = {
    [0] = SINGLE, [1] = SIX_WAYS, [2] = WHITE_MAP, [3] = SINGLE, [4] = BEAM, [5] = BEAM, [6] = BEAM, [7] = WHITE_MAP,
    [8] = TRANSMITTANCE, [9] = TRANSMITTANCE, [10] = TRANSMITTANCE, [11] = TRANSMITTANCE,
    [12] = {"extremes", "light_from_1e_minus_30_to_1e30_scales_the_picture"}, [13] = TRANSMITTANCE, [14] = CHANNELS,
    [15] = TRANSMITTANCE, [16] = KNOBS, [17] = DISC, [18] = POINT, [19] = HALVES, [20] = POINT, [21] = KNOBS,
    [22] = CHANNELS, [23] = KNOBS, [24] = KNOBS, [25] = CHANNELS, [26] = HALVES, [27] = {"lights", "what_is_above_is_drawn_above_and_what_is_right_to_the_right"}, [28] = SUN,
    [29] = TRANSMITTANCE, [30] = KNOBS,
    [31] = {"estimators", "a_layer_of_a_millionth_keeps_its_digits"},
};
static const char *const programs[] = {"lights", "half_space", "extremes", "closed_forms", "estimators", "furnace", "slab"};
enum { PROGRAMS = sizeof programs / sizeof programs[0] };

/* Runs a program (one title, or all when NULL); 0 when its tests pass, else `failed` tells which one did not. */
static int run(int bug, const char *program, const char *title, char failed[256]) {
    char command[2048], line[4096], only[300] = "";
    if (title) snprintf(only, sizeof only, "NEPHOS_TEST_ONLY=%s ", title);
    snprintf(command, sizeof command, "unset NEPHOS_TEST_LOGS; NEPHOS_BUG=%d NEPHOS_ISA=base %s'%s/tests/bugs/bugged_%s' 2>&1", bug,
             only, getenv("NEPHOS_PROGRAM_ROOT"), program);
    FILE *pipe = popen(command, "r");
    ck_assert_ptr_nonnull(pipe);
    int ran = 0;
    snprintf(failed, 256, "%s", "");
    while (fgets(line, sizeof line, pipe)) {
        int checks, failures, errors;
        if (sscanf(line, "%*d%%: Checks: %d, Failures: %d, Errors: %d", &checks, &failures, &errors) == 3) ran = checks;
        /* file:line:F:tcase:test:iteration: message */
        const char *mark = strstr(line, ":F:") ? strstr(line, ":F:") : strstr(line, ":E:");
        const char *test = mark && !failed[0] ? strchr(mark + 3, ':') : NULL;
        if (test) snprintf(failed, 256, "%.*s", (int)strcspn(test + 1, ":"), test + 1);
    }
    int status = pclose(pipe);
    ck_assert_msg(ran > 0, "no test ran in: %s", command);
    ck_assert_msg((status == 0) == (failed[0] == 0), "status %d, failed '%s': %s", status, failed, command);
    return status;
}

/* The first test that fails with the bug. */
static int is_caught(int bug, char failed[256]) {
    if (run(bug, first[bug].program, first[bug].title, failed)) return 1;
    for (int p = 0; p < PROGRAMS; p++)
        if (run(bug, programs[p], NULL, failed)) return 1;
    return 0;
}

static int is_wanted(void) {
    if (!nph_test_statistics("known bugs")) return 0;
#ifdef NPH_HAVE_BUGGED
    return 1;
#else
    nph_test_skip("known bugs (built without them, -Dbugs=false)");
    return 0;
#endif
}

START_TEST(every_known_bug_is_caught) {
    if (!is_wanted()) return;
    int missed = 0;
    for (int i = 0; i < BUGS; i++) {
        char failed[256];
        ck_assert_int_eq(known[i].number, i + 1);
        int caught = is_caught(known[i].number, failed);
        missed += !caught;
        printf("    %2d %-22s %s: %s\n", known[i].number, known[i].name, known[i].what, caught ? failed : "NOT FOUND");
        fflush(stdout);
    }
    ck_assert_msg(missed == 0, "%d known bugs pass the suite", missed);
}
END_TEST

START_TEST(without_a_bug_the_same_tests_pass) {
    if (!is_wanted()) return;
    for (int i = 0; i <= BUGS; i++) {
        char failed[256];
        int seen = 0;
        for (int k = 0; k < i; k++) seen |= strcmp(first[k].title, first[i].title) == 0;
        if (!seen) ck_assert_msg(run(0, first[i].program, first[i].title, failed) == 0, "%s fails without a bug", failed);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, every_known_bug_is_caught);
    tcase_add_test(cases, without_a_bug_the_same_tests_pass);
}

int main(void) { return nph_test_main("known_bugs", fill); }
