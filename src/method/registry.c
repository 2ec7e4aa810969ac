/* SPDX-License-Identifier: Apache-2.0
 *
 * One line per method. */
#include "method/registry.h"

#include <stdio.h>
#include <string.h>

#include "core/message.h"
#include "method/principal_ordinates/pop.h"
#include "method/temporal_photons/tpm.h"
#include "truth/light/light_tracing.h"
#include "truth/path/path.h"
#include "truth/photonmap/photonmap.h"
#include "truth/shdom/shdom.h"
#include "truth/single/single.h"

static const NphMethod *const methods[] = {
    &nph_path,
    &nph_light,
    &nph_single,
    &nph_photonmap,
    &nph_shdom,
    &nph_temporal_photons,
    &nph_principal_ordinates,
};

int nph_method_count(void) { return (int)(sizeof methods / sizeof *methods); }
const NphMethod *nph_method(int index) { return methods[index]; }

NphStatus nph_method_find(NphContext *context, const char *name, const NphMethod **method) {
    char known[512] = "";
    for (int m = 0; m < nph_method_count(); m++) {
        if (strcmp(methods[m]->name, name) == 0) {
            *method = methods[m];
            return NPH_OK;
        }
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", m ? ", " : "", methods[m]->name);
    }
    return nph_error(context, NPH_BAD_USAGE, "there is no method '%s'; there are: %s", name, known);
}

int nph_knob_count(void) {
    int count = 0;
    for (int m = 0; m < nph_method_count(); m++) count += methods[m]->knob_count;
    return count;
}

const NphKnob *nph_knob(int index) {
    for (int m = 0; m < nph_method_count(); m++) {
        if (index < methods[m]->knob_count) return &methods[m]->knobs[index];
        index -= methods[m]->knob_count;
    }
    return NULL;
}
