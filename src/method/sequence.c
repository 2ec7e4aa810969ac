/* SPDX-License-Identifier: Apache-2.0
 *
 * Frames one after another, and what a method keeps between them. */
#include "core/memory.h"
#include "core/message.h"
#include "method/job.h"

struct NphSequence {
    NphContext *context;
    const NphScene *scene;
    NphRenderOptions options;
    const NphMethod *method;
    void *carry;
};

NphStatus nph_sequence_open(NphContext *context, const NphScene *scene, const NphRenderOptions *options, NphSequence **sequence) {
    const NphMethod *method = NULL;
    NphSequence *made = NULL;
    NphJob job;
    NPH_TRY(nph_job_make(context, scene, options, &method, &job));
    NPH_TRY(NPH_NEW(context, 1, "sequence of frames", &made));
    *made = (NphSequence){.context = context, .scene = scene, .options = *options, .method = method};
    made->options.sequence = 1;
    *sequence = made;
    return NPH_OK;
}

static void forget(NphSequence *sequence) {
    if (sequence->carry && sequence->method->drop) sequence->method->drop(sequence->context, sequence->carry);
    sequence->carry = NULL;
}

NphStatus nph_sequence_render(NphSequence *sequence, uint32_t frame, NphFilm **film, NphRenderStatistics *statistics) {
    NphContext *context = sequence->context;
    const NphScene *scene = sequence->scene;
    NphScene *other = NULL;
    if (nph_scene_is_animated(scene)) NPH_TRY(nph_scene_at_frame(context, scene, frame, &other));
    sequence->options.frame = frame;
    NphStatus status = nph_render_carried(context, other ? other : scene, &sequence->options, NULL, sequence->method->drop ? &sequence->carry : NULL,
                                          film, statistics);
    nph_scene_free(context, other);
    if (status != NPH_OK) forget(sequence);
    return status;
}

void nph_sequence_close(NphSequence *sequence) {
    if (!sequence) return;
    forget(sequence);
    nph_free(sequence->context, sequence);
}
