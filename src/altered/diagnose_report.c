/* SPDX-License-Identifier: Apache-2.0
 *
 * What a diagnosis found, as text and as JSON. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "altered/diagnosis.h"
#include "core/json.h"
#include "core/text.h"

/* One explanation: a bug or a transform. */
typedef struct Row {
    const Candidate *bug;
    const NphTransform *transform;
    const NphFit *fit;
} Row;

enum { MAX_ROWS = CANDIDATES + NPH_MAX_TRANSFORMS, WORDS = 512 };

/* How far a row is behind the first one, and the noise of that. Pictures that were not rendered alike are compared by their scores. */
static double behind(const Row *row, const Row *first, double *noise) {
    if (row->bug && first->bug && first->bug->behind.score == 0.0) {
        *noise = row->bug->behind.noise;
        return row->bug->behind.score;
    }
    *noise = hypot(first->fit->score_noise, row->fit->score_noise);
    return first->fit->score - row->fit->score;
}

static int is_far_ahead(const NphFit *a, const NphFit *b) {
    return diagnose_leads(a->score - b->score, hypot(a->score_noise, b->score_noise));
}

/* Bugs, the likeliest first; a transform stands behind all bugs that it is not far ahead of. */
static int rows_of(const Diagnosis *diagnosis, Row rows[MAX_ROWS]) {
    int count = 0;
    for (int k = 0; k < diagnosis->ranked; k++) {
        const Candidate *candidate = &diagnosis->candidates[diagnosis->ranking[k]];
        if (candidate->bug->number) rows[count++] = (Row){candidate, NULL, &candidate->fit};
    }
    for (int t = 0; t < diagnosis->transform_count; t++) {
        const NphTransform *transform = &diagnosis->transforms[t];
        int at = count++;
        for (; at > 0 && rows[at - 1].bug && is_far_ahead(&transform->fit, rows[at - 1].fit); at--) rows[at] = rows[at - 1];
        rows[at] = (Row){NULL, transform, &transform->fit};
    }
    return count;
}

/* "12.57 +- 0.04" */
static void add_measure(char words[WORDS], const char *before, double value, double error) {
    char number[2][NPH_DOUBLE_TEXT];
    size_t used = strlen(words);
    snprintf(words + used, WORDS - used, "%s%s +- %s", before, nph_format_rounded(value, 5, number[0]), nph_format_rounded(error, 2, number[1]));
}

static int has_colours(const double value[3], const double error[3]) {
    for (int c = 0; c < 3; c += 2)
        if (fabs(value[c] - value[1]) > 3.0 * (error[c] + error[1])) return 1;
    return 0;
}

static void add_factors(char words[WORDS], const double value[4], const double error[4]) {
    static const char *const names[3] = {"R ", ", G ", ", B "};
    if (!has_colours(value, error)) {
        add_measure(words, "", value[3], error[3]);
        return;
    }
    for (int c = 0; c < 3; c++) add_measure(words, names[c], value[c], error[c]);
}

static const char *pixels_words(const NphShift *shift, char words[WORDS]) {
    snprintf(words, WORDS, "%s", "by (");
    add_measure(words, "", shift->pixels[0], shift->error[0]);
    add_measure(words, ", ", shift->pixels[1], shift->error[1]);
    size_t used = strlen(words);
    snprintf(words + used, WORDS - used, ") pixels right and down");
    return words;
}

/* Names of the candidates in a state, those with one as twin only for state CANDIDATE_TWIN; "" when there are none. */
static const char *names_of(const Diagnosis *diagnosis, CandidateState state, int twin, char words[WORDS * 2]) {
    words[0] = 0;
    for (int i = 1; i < CANDIDATES; i++) {
        const Candidate *candidate = &diagnosis->candidates[i];
        if (candidate->state != state || (state == CANDIDATE_TWIN && candidate->twin != twin)) continue;
        size_t used = strlen(words);
        snprintf(words + used, WORDS * 2 - used, "%s%s", used ? ", " : "", candidate->bug->name);
    }
    return words;
}

static void put_bug(const Diagnosis *diagnosis, const Candidate *candidate, const NphFit *right) {
    char words[WORDS] = "", names[WORDS * 2];
    printf("%s (bug %d): %s\n", candidate->bug->name, candidate->bug->number, candidate->bug->what);
    add_factors(words, candidate->factor, candidate->factor_error);
    printf("        its mean over the right picture's: %s\n", words);
    words[0] = 0;
    add_factors(words, right->ratio, right->ratio_error);
    printf("        A's mean over the right picture's: %s\n", words);
    if (candidate->moved) printf("        it moves the picture %s\n", pixels_words(&candidate->shift, words));
    if (candidate->failed) printf("        with it a run fails its numeric checks\n");
    if (names_of(diagnosis, CANDIDATE_TWIN, candidate->bug->number, names)[0]) printf("        the same bytes in this scene: %s\n", names);
}

/* "a factor 12.57 +- 0.03: 4 pi" */
static const char *transform_words(const NphTransform *transform, char words[WORDS]) {
    char pixels[WORDS];
    snprintf(words, WORDS, "%s", transform->name);
    if (transform->shifted) snprintf(words, WORDS, "%s %.400s", transform->name, pixels_words(&transform->shift, pixels));
    if (transform->factors == 1) add_measure(words, strcmp(transform->name, "a factor") ? ", and a factor " : " ", transform->factor[0], transform->factor_error[0]);
    for (int c = 0; transform->factors == 3 && c < 3; c++)
        add_measure(words, c == 0 ? " R " : c == 1 ? ", G " : ", B ", transform->factor[c], transform->factor_error[c]);
    size_t used = strlen(words);
    if (transform->known[0]) snprintf(words + used, WORDS - used, ": %s", transform->known);
    return words;
}

static void put_rows(const Diagnosis *diagnosis) {
    Row rows[MAX_ROWS];
    char words[WORDS], number[2][NPH_DOUBLE_TEXT];
    int count = rows_of(diagnosis, rows);
    for (int i = 0; i < count; i++) {
        double noise, gap = -behind(&rows[i], &rows[0], &noise);
        printf("  %2d  ", i + 1);
        if (rows[i].bug) put_bug(diagnosis, rows[i].bug, &diagnosis->candidates[0].fit);
        else printf("%s (of the finished picture)\n", transform_words(rows[i].transform, words));
        if (i) printf("        ln of its odds against 1: %s, where noise makes %s\n", nph_format_rounded(gap, 3, number[0]), nph_format_rounded(noise, 2, number[1]));
    }
}

static void put_headline(const Diagnosis *diagnosis, const char *picture) {
    char words[WORDS] = "";
    Row rows[MAX_ROWS];
    if (diagnosis->verdict == DIAGNOSED_KNOWN) {
        rows_of(diagnosis, rows);
        printf("wrong: %s looks like %s\n", picture, rows[0].bug ? rows[0].bug->bug->name : transform_words(rows[0].transform, words));
        return;
    }
    if (diagnosis->verdict == DIAGNOSED_UNKNOWN) printf("none of the known ones: %s is wrong, and no known bug explains it\n", picture);
    else printf("none: %s is right within its error bars\n", picture);
    add_factors(words, diagnosis->candidates[0].fit.ratio, diagnosis->candidates[0].fit.ratio_error);
    printf("      A's mean over the right picture's: %s\n", words);
}

/* The excluded candidate that comes nearest, NULL: none. */
static const Candidate *nearest(const Diagnosis *diagnosis) {
    const Candidate *best = NULL;
    for (int i = 1; i < CANDIDATES; i++) {
        const Candidate *candidate = &diagnosis->candidates[i];
        if (candidate->state != CANDIDATE_EXCLUDED || !isfinite(candidate->fit.score)) continue;
        if (!best || candidate->fit.score > best->fit.score) best = candidate;
    }
    return best;
}

static const char *bars_words(const Diagnosis *diagnosis) {
    if (!diagnosis->candidates[0].fit.lent) return "its own";
    if (diagnosis->fit.a_samples > 0.0) return "those that nephos would have with --a-samples";
    return "none; as from the scatter of neighbouring pixels about nephos' picture";
}

static void put_open(const Diagnosis *diagnosis) {
    char words[WORDS], names[WORDS * 2], number[NPH_DOUBLE_TEXT];
    int first = 1;
    for (int k = 0; k < diagnosis->ranked; k++) {
        const Candidate *candidate = &diagnosis->candidates[diagnosis->ranking[k]];
        if (candidate->bug->number == 0) continue;
        if (first) printf("within A's error bars too:\n");
        first = 0;
        words[0] = 0;
        add_factors(words, candidate->factor, candidate->factor_error);
        printf("      %s (bug %d), mean over the right picture's: %s\n", candidate->bug->name, candidate->bug->number, words);
        double needed = diagnose_samples_needed(candidate);
        if (needed > 1.0) printf("        to tell it, A would need at least %s times its samples\n", nph_format_rounded(needed, 2, number));
        if (names_of(diagnosis, CANDIDATE_TWIN, candidate->bug->number, names)[0]) printf("        the same bytes: %s\n", names);
    }
}

void diagnose_text(const Diagnosis *diagnosis, const char *picture) {
    char names[WORDS * 2];
    const Candidate *right = &diagnosis->candidates[0], *near = nearest(diagnosis);
    put_headline(diagnosis, picture);
    if (diagnosis->verdict == DIAGNOSED_KNOWN) put_rows(diagnosis);
    if (diagnosis->verdict == DIAGNOSED_RIGHT) put_open(diagnosis);
    if (diagnosis->verdict == DIAGNOSED_UNKNOWN && near) printf("      nearest: %s, but %s\n", near->bug->name, near->fit.reason);
    if (diagnosis->verdict != DIAGNOSED_RIGHT)
        printf("right picture: %s\n", right->state == CANDIDATE_EXCLUDED ? right->fit.reason : "not excluded by itself, but far less likely");
    if (names_of(diagnosis, CANDIDATE_HIDDEN, 0, names)[0]) printf("cannot show in this scene: %s\n", names);
    printf("A's error bars: %s\n", bars_words(diagnosis));
    printf("%lld samples per pixel of seed %u%s\n", (long long)diagnosis->samples, diagnosis->render.seed,
           diagnosis->clear || diagnosis->verdict == DIAGNOSED_RIGHT ? "" : "; more (--spp) may tell the first ones apart");
}

/* ---- JSON ---- */

static void put_bug_json(const Diagnosis *diagnosis, const Candidate *candidate, NphJson *json) {
    nph_json_text(json, "kind", "bug");
    nph_json_text(json, "name", candidate->bug->name);
    nph_json_integer(json, "number", candidate->bug->number);
    nph_json_text(json, "what", candidate->bug->what);
    nph_json_numbers(json, "factor", 4, candidate->factor);
    nph_json_numbers(json, "factor_error", 4, candidate->factor_error);
    if (candidate->moved) nph_json_numbers(json, "pixels", 2, candidate->shift.pixels);
    if (candidate->moved) nph_json_numbers(json, "pixels_error", 2, candidate->shift.error);
    nph_json_boolean(json, "numeric_checks_fail", candidate->failed);
    nph_json_array(json, "same_bytes");
    for (int i = 1; i < CANDIDATES; i++)
        if (diagnosis->candidates[i].state == CANDIDATE_TWIN && diagnosis->candidates[i].twin == candidate->bug->number)
            nph_json_text(json, NULL, known_bugs[i].name);
    nph_json_close(json);
}

static void put_transform_json(const NphTransform *transform, NphJson *json) {
    nph_json_text(json, "kind", "picture");
    nph_json_text(json, "name", transform->name);
    if (transform->factors) {
        nph_json_numbers(json, "factor", 3, transform->factor);
        nph_json_numbers(json, "factor_error", 3, transform->factor_error);
        nph_json_text(json, "known", transform->known[0] ? transform->known : NULL);
    }
    if (transform->shifted) {
        nph_json_numbers(json, "pixels", 2, transform->shift.pixels);
        nph_json_numbers(json, "pixels_error", 2, transform->shift.error);
    }
}

static void put_explanations(const Diagnosis *diagnosis, NphJson *json) {
    Row rows[MAX_ROWS];
    int count = rows_of(diagnosis, rows);
    nph_json_array(json, diagnosis->verdict == DIAGNOSED_RIGHT ? "not_excluded" : "explanations");
    for (int i = 0; i < count; i++) {
        double noise, gap = -behind(&rows[i], &rows[0], &noise);
        nph_json_object(json, NULL);
        if (rows[i].bug) put_bug_json(diagnosis, rows[i].bug, json);
        else put_transform_json(rows[i].transform, json);
        nph_json_number(json, "ln_odds", gap);
        nph_json_number(json, "ln_odds_noise", noise);
        double needed = rows[i].bug ? diagnose_samples_needed(rows[i].bug) : 0.0;
        if (needed > 0.0) nph_json_number(json, "times_its_samples_needed", needed);
        nph_json_close(json);
    }
    nph_json_close(json);
}

static void put_names_json(const Diagnosis *diagnosis, CandidateState state, const char *key, NphJson *json) {
    nph_json_array(json, key);
    for (int i = 1; i < CANDIDATES; i++)
        if (diagnosis->candidates[i].state == state) nph_json_text(json, NULL, known_bugs[i].name);
    nph_json_close(json);
}

void diagnose_json(const Diagnosis *diagnosis, const char *picture) {
    static const char *const verdicts[] = {"none", "known", "none of the known ones"};
    const Candidate *right = &diagnosis->candidates[0];
    NphJson json;
    nph_json_begin(&json, nph_json_to_file, stdout);
    nph_json_object(&json, NULL);
    nph_json_text(&json, "picture", picture);
    nph_json_text(&json, "scene", diagnosis->scene_path);
    nph_json_text(&json, "verdict", verdicts[diagnosis->verdict]);
    put_explanations(diagnosis, &json);
    nph_json_object(&json, "right_picture");
    nph_json_boolean(&json, "excluded", right->state == CANDIDATE_EXCLUDED);
    nph_json_text(&json, "reason", right->fit.reason);
    nph_json_numbers(&json, "factor", 4, right->fit.ratio);
    nph_json_numbers(&json, "factor_error", 4, right->fit.ratio_error);
    nph_json_close(&json);
    put_names_json(diagnosis, CANDIDATE_EXCLUDED, "excluded", &json);
    put_names_json(diagnosis, CANDIDATE_HIDDEN, "cannot_show", &json);
    nph_json_text(&json, "error_bars", !right->fit.lent ? "own" : diagnosis->fit.a_samples > 0.0 ? "a_samples" : "estimated");
    nph_json_integer(&json, "samples", diagnosis->samples);
    nph_json_integer(&json, "seed", diagnosis->render.seed);
    nph_json_boolean(&json, "clear", diagnosis->clear);
    nph_json_close(&json);
}
