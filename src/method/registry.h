/* SPDX-License-Identifier: Apache-2.0
 *
 * The list of methods: the published ones and the references. */
#ifndef NPH_METHOD_REGISTRY_H
#define NPH_METHOD_REGISTRY_H

#include "pipeline/method.h"

int nph_method_count(void);
const NphMethod *nph_method(int index);

/* The method of that name; reports NPH_BAD_USAGE naming those there are. */
NphStatus nph_method_find(NphContext *context, const char *name, const NphMethod **method);

#endif
