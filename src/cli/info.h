/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos info, one function per kind of file: each reads the file whole, so that what is told has been decoded. */
#ifndef NPH_CLI_INFO_H
#define NPH_CLI_INFO_H

#include "cli/facts.h"
#include "nephos/context.h"

typedef struct Info {
    NphContext *context;
    const char *path;
    uint32_t frame; /* of a scene */
    Facts facts;
} Info;

NphStatus info_exr(Info *info);
NphStatus info_part(Info *info);
NphStatus info_nvdb(Info *info);
NphStatus info_vdb(Info *info);
NphStatus info_npy(Info *info);
NphStatus info_vol(Info *info);
NphStatus info_pbrt(Info *info);
NphStatus info_les(Info *info);
NphStatus info_phase(Info *info);
NphStatus info_scene(Info *info);

/* A folder, or its manifest.json. */
int info_is_dump(const char *path);
NphStatus info_dump(Info *info);

#endif
