/* SPDX-License-Identifier: Apache-2.0
 *
 * The version of headers and library. */
#ifndef NEPHOS_VERSION_H
#define NEPHOS_VERSION_H

#ifdef __cplusplus
extern "C" {
#endif

#define NPH_VERSION "0.1.0"

/* The version the library was built as. */
const char *nph_version(void);

#ifdef __cplusplus
}
#endif
#endif
