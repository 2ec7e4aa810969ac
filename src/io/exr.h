/* SPDX-License-Identifier: Apache-2.0
 *
 * What the image container, the reader and the writer of OpenEXR files agree on. */
#ifndef NPH_IO_EXR_H
#define NPH_IO_EXR_H

/* Data and display windows stay within +-2^30, so that sums of two coordinates fit an int. */
enum { NPH_EXR_MAX_COORDINATE = 1 << 30 };

/* Attribute names that the format itself uses (dataWindow, type, ...): not read as attributes, refused for writing. */
int nph_exr_reserved_name(const char *name);

#endif
