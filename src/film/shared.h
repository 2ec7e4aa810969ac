/* SPDX-License-Identifier: Apache-2.0
 *
 * The coarser films of pictures whose pixels share samples. Seen by film/ only. */
#ifndef NPH_FILM_SHARED_H
#define NPH_FILM_SHARED_H

#include "film/tree.h"

/* Layout of a level (regions.h) of this film, with as many slots. */
void nph_shared_lay_out(const NphFilm *film, int level, NphFilm *layout);

/* Makes all levels, empty; what was made is freed with the film. */
NphStatus nph_shared_make(NphContext *context, NphFilm *film);
void nph_shared_free(NphContext *context, NphFilm *film);

/* A film tile's sums over regions, from its sample buffer. */
void nph_shared_add_tile(const NphFilm *film, int64_t tile, int precision, const void *samples);

#endif
