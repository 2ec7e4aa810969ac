/* SPDX-License-Identifier: Apache-2.0
 *
 * Text inside XML: what marks have a meaning becomes references, what XML does not allow U+FFFD. */
#ifndef NPH_CORE_XML_H
#define NPH_CORE_XML_H

#include "core/json.h"

void nph_xml_text(NphTextFn write, void *user, const char *text);

#endif
