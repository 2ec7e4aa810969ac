/* SPDX-License-Identifier: Apache-2.0
 *
 * Pictures with a known bug. */
#include <math.h>
#include <string.h>

#include "altered/altered.h"
#include "altered/diagnosis.h"
#include "core/message.h"
#include "core/text.h"

#define ROW(number, name, what) {number, name, what},
const KnownBug known_bugs[CANDIDATES] = {{0, "right", "no bug"}, NPH_KNOWN_BUGS(ROW)};

const KnownBug *known_bug_find(const char *word) {
    int64_t number = 0;
    if (nph_parse_int(word, &number)) return number > 0 && number <= KNOWN_BUGS ? &known_bugs[number] : NULL;
    for (int i = 1; i < CANDIDATES; i++)
        if (strcmp(known_bugs[i].name, word) == 0) return &known_bugs[i];
    return NULL;
}

static int changes_scene(int bug) { return strncmp(known_bugs[bug].what, "scene:", 6) == 0; }

/* The library's words about a picture that is meant to be wrong are not told. */
NphStatus diagnose_render(Session *session, const char *scene_path, const NphScene *scene, int bug, const NphRenderOptions *options,
                          NphFilm **film, int *failed) {
    NphScene *changed = NULL;
    NphStatus status = NPH_OK;
    session->mute = bug != 0;
    nph_bug_number = bug;
    if (changes_scene(bug)) {
        status = nph_scene_load_frame(session->context, scene_path, options->frame, &changed);
        if (status == NPH_OK) altered_change_scene(changed);
    }
    if (status == NPH_OK) status = nph_render(session->context, changed ? changed : scene, options, film, NULL);
    nph_scene_free(session->context, changed);
    nph_bug_number = 0;
    session->mute = 0;
    *failed = bug && status == NPH_BAD_NUMBER;
    if (*failed) return NPH_OK;
    if (status != NPH_OK) {
        nph_film_free(session->context, *film);
        *film = NULL;
    }
    if (status != NPH_OK && status != NPH_INTERRUPTED && bug)
        return nph_error(session->context, status, "the scene cannot be rendered with bug %d (%s)", bug, known_bugs[bug].name);
    return status;
}

void diagnose_drop(Diagnosis *diagnosis, Candidate *candidate) {
    nph_film_free(diagnosis->session->context, candidate->film);
    candidate->film = NULL;
    nph_image_free(diagnosis->session->context, &candidate->image);
    candidate->samples = 0;
}

/* More samples of a film, which is replaced. */
static NphStatus join(Diagnosis *diagnosis, NphFilm *more, NphFilm **film) {
    NphContext *context = diagnosis->session->context;
    static const char *const names[2] = {"earlier samples", "later samples"};
    NphFilm *parts[2] = {*film, more}, *joined = NULL;
    if (!*film) {
        *film = more;
        return NPH_OK;
    }
    NphStatus status = nph_film_merge(context, 2, parts, names, &joined);
    nph_film_free(context, more);
    if (status != NPH_OK) return status;
    nph_film_free(context, *film);
    *film = joined;
    return NPH_OK;
}

NphStatus diagnose_extend(Diagnosis *diagnosis, Candidate *candidate, int64_t samples) {
    NphContext *context = diagnosis->session->context;
    NphRenderOptions options = diagnosis->render;
    NphFilm *more = NULL;
    int failed = 0;
    if (candidate->samples >= samples) return NPH_OK;
    options.sample_begin = candidate->samples;
    options.sample_end = samples;
    NPH_TRY(diagnose_render(diagnosis->session, diagnosis->scene_path, diagnosis->scene, candidate->bug->number, &options, &more, &failed));
    candidate->failed |= failed;
    NPH_TRY(join(diagnosis, more, &candidate->film));
    candidate->samples = samples;
    nph_image_free(context, &candidate->image);
    return nph_film_image(context, candidate->film, &candidate->image);
}
