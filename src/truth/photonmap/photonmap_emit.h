/* SPDX-License-Identifier: Apache-2.0
 *
 * Where photons start (entry_lookup.h). A light is chosen with a probability near its share of the power that enters the box
 * around all media; the photon carries what it stands for, over that probability [Jensen98]: the mean over photons of carried
 * power is so the power that enters the box. */
#ifndef NPH_TRUTH_PHOTONMAP_EMIT_H
#define NPH_TRUTH_PHOTONMAP_EMIT_H

#include "transport/entry_lookup.h"
#include "truth/photonmap/photonmap_state.h"

static inline REntry r_emit(const RPhotonScene *scene, const RStream *stream) {
    const RScene *local = &scene->local;
    NphWords words = r_words(stream, 0);
    int number = r_cdf_find(scene->choose, local->light_count, nph_uniform(words.w0));
    return r_entry(local, number, scene->choose[number + 1] - scene->choose[number], &scene->from[number], words,
                   r_words(stream, 1));
}

#endif
