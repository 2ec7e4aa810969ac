/* SPDX-License-Identifier: Apache-2.0
 *
 * The layout of a part file, shared by its writer and its reader; docs/files.md describes it byte by byte. */
#ifndef NPH_FILM_PART_H
#define NPH_FILM_PART_H

#define NPH_PART_MAGIC "NPHPART1"

/* Byte offsets of the header's fields, and sizes. */
enum {
    NPH_PART_CHANNELS = 8, NPH_PART_SHARED = 10, NPH_PART_TEXT_COUNT = 12, NPH_PART_WIDTH = 16, NPH_PART_HEIGHT = 20, NPH_PART_CROP = 24,
    NPH_PART_BEGIN = 40, NPH_PART_END = 48, NPH_PART_TEXT_BYTES = 56, NPH_PART_TILES = 64, NPH_PART_FILE_BYTES = 72,
    NPH_PART_HEADER_BYTES = 80, NPH_PART_TILE_BYTES = 32, NPH_PART_DIGEST_BYTES = 16
};

#endif
