/* SPDX-License-Identifier: Apache-2.0
 *
 * The sections "transport" and "media" of a manifest: what a port needs besides buffers. docs/oracle.md lists their members. */
#ifndef NPH_ORACLE_DUMP_FACTS_H
#define NPH_ORACLE_DUMP_FACTS_H

#include "core/json.h"
#include "pipeline/method.h"

/* Writes both as members of the open object; nothing where the method tells none. */
NphStatus nph_json_facts(NphJson *json, const NphMethod *method, const NphJob *job);

#endif
