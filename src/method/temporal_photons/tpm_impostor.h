/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NPH_METHOD_TPM_IMPOSTOR_H
#define NPH_METHOD_TPM_IMPOSTOR_H

#include "method/temporal_photons/tpm.h"

/* Frames after which a picture is marched anew whatever else. */
int nph_tpm_impostor_life(const NphJob *job);

/* How many frames ago the picture was marched that the job's frame shows, 0: it is its own; and the scene at that frame, freed by the
 * caller, NULL where it is the job's. medium: that is marched. */
NphStatus nph_tpm_impostor(const NphJob *job, int medium, int *age, NphScene **scene);

#endif
