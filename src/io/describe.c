/* SPDX-License-Identifier: Apache-2.0
 *
 * Binary formats are told by their signature; the text formats by the first lines that are neither blank nor comment:
 * LES text begins with three whole numbers, a phase function with two numbers, pbrt with a directive, a scene with a mapping ("key:", "{"). */
#include "io/describe.h"

#include <string.h>

#include "core/text.h"
#include "io/file.h"

static const struct {
    const char *bytes;
    size_t size;
    NphFileKind kind;
} signatures[] = {
    {"\x76\x2f\x31\x01", 4, NPH_FILE_EXR},
    {"\x89PNG\r\n\x1a\n", 8, NPH_FILE_PNG},
    {"NanoVDB", 7, NPH_FILE_NVDB}, /* an eighth byte 0, 1 or 2: first version, grid, file */
    {" BDV\0\0\0\0", 8, NPH_FILE_VDB},
    {"\x93NUMPY", 6, NPH_FILE_NPY},
    {"VOL\3", 4, NPH_FILE_VOL},
    {NPH_PART_MAGIC, 8, NPH_FILE_PART},
    {"#?RADIANCE", 10, NPH_FILE_HDR},
    {"#?RGBE", 6, NPH_FILE_HDR},
    {"PF\n", 3, NPH_FILE_PFM},
    {"Pf\n", 3, NPH_FILE_PFM},
};

static const char *const names[NPH_FILE_KINDS] = {
    [NPH_FILE_UNKNOWN] = "an unknown kind of file",
    [NPH_FILE_EMPTY] = "an empty file",
    [NPH_FILE_EXR] = "an OpenEXR image",
    [NPH_FILE_PNG] = "a PNG image",
    [NPH_FILE_NVDB] = "a NanoVDB volume (.nvdb)",
    [NPH_FILE_VDB] = "an OpenVDB volume (.vdb)",
    [NPH_FILE_NPY] = "an array (.npy)",
    [NPH_FILE_VOL] = "a Mitsuba grid volume (.vol)",
    [NPH_FILE_PBRT] = "a pbrt scene or medium (.pbrt)",
    [NPH_FILE_LES] = "a cloud as LES text",
    [NPH_FILE_PHASE] = "a table of a phase function",
    [NPH_FILE_SCENE] = "a scene (YAML)",
    [NPH_FILE_PART] = "a part of a picture",
    [NPH_FILE_HDR] = "a Radiance picture (.hdr)",
    [NPH_FILE_PFM] = "a portable float map (.pfm)",
};

const char *nph_file_kind_name(NphFileKind kind) { return names[kind]; }

static int is_digit(char c) { return c >= '0' && c <= '9'; }
static int is_blank(char c) { return c == ' ' || c == '\t'; }
static int is_word(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_' || c == '-';
}

/* Text holds no control characters but tab, line feed and carriage return; bytes above 127 may be UTF-8. */
static int is_text(const char *bytes, size_t size) {
    for (size_t i = 0; i < size; i++) {
        unsigned char c = (unsigned char)bytes[i];
        if ((c < 32 && c != '\t' && c != '\n' && c != '\r') || c == 127) return 0;
    }
    return 1;
}

/* Past blank lines and comments. */
static const char *skip_comments(const char *at, const char *end) {
    while (at < end) {
        while (at < end && (is_blank(*at) || *at == '\n' || *at == '\r')) at++;
        if (at == end || *at != '#') break;
        while (at < end && *at != '\n') at++;
    }
    return at;
}

/* "nx,ny,nz" or "nx ny nz", perhaps a comment, end of line. */
static int is_three_sizes(const char *at, const char *end) {
    for (int i = 0; i < 3; i++) {
        if (at == end || !is_digit(*at)) return 0;
        while (at < end && is_digit(*at)) at++;
        while (at < end && (is_blank(*at) || (*at == ',' && i < 2))) at++;
    }
    return at == end || *at == '\n' || *at == '\r' || *at == '#';
}

/* "angle value" or "angle,value", perhaps a comment, end of line. */
static int is_two_numbers(const char *at, const char *end) {
    for (int i = 0; i < 2; i++) {
        const char *begin = at;
        while (at < end && !is_blank(*at) && *at != ',' && *at != '\n' && *at != '\r' && *at != '#') at++;
        if (!nph_is_decimal(begin, at)) return 0;
        while (at < end && is_blank(*at)) at++;
        if (i == 0 && at < end && *at == ',') at++;
        while (at < end && is_blank(*at)) at++;
    }
    return at == end || *at == '\n' || *at == '\r' || *at == '#';
}

/* "{", or a plain or quoted key and a colon that is followed by a blank or the end of the line. */
static int is_mapping(const char *at, const char *end) {
    if (at < end && *at == '{') return 1;
    char quote = 0;
    if (at < end && (*at == '"' || *at == '\'')) quote = *at++;
    const char *key = at;
    while (at < end && (is_word(*at) || *at == '.' || *at == ' ')) at++;
    if (at == key) return 0;
    if (quote && (at == end || *at++ != quote)) return 0;
    if (at == end || *at++ != ':') return 0;
    return at == end || is_blank(*at) || *at == '\n' || *at == '\r';
}

/* A word that a pbrt file may begin with, then a blank, a quote or the end of the line. */
static int is_directive(const char *at, const char *end) {
    static const char *const words[] = {
        "MakeNamedMedium", "WorldBegin", "LookAt", "Camera", "Film", "Sampler", "Integrator", "Accelerator",
        "PixelFilter", "ColorSpace", "Option", "Scale", "Translate", "Rotate", "Transform", "ConcatTransform",
        "CoordSysTransform", "Identity", "AttributeBegin", "Attribute", "MediumInterface", "Include", "Import",
        "Texture", "MakeNamedMaterial", "Material", "LightSource", "Shape", "ObjectBegin", "TransformTimes"};
    const char *stop = at;
    while (stop < end && is_word(*stop)) stop++;
    if (stop < end && !is_blank(*stop) && *stop != '\n' && *stop != '\r' && *stop != '"') return 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strlen(words[i]) == (size_t)(stop - at) && memcmp(words[i], at, (size_t)(stop - at)) == 0) return 1;
    return 0;
}

static int begins(const char *at, const char *end, const char *word) {
    size_t size = strlen(word);
    return (size_t)(end - at) >= size && memcmp(at, word, size) == 0;
}

static NphFileKind kind_of_text(const char *at, const char *end) {
    if (begins(at, end, "\xef\xbb\xbf")) at += 3;
    at = skip_comments(at, end);
    if (is_three_sizes(at, end)) return NPH_FILE_LES;
    if (is_two_numbers(at, end)) return NPH_FILE_PHASE;
    if (is_directive(at, end)) return NPH_FILE_PBRT;
    while (begins(at, end, "%YAML") || begins(at, end, "---")) {
        while (at < end && *at != '\n') at++;
        at = skip_comments(at, end);
    }
    return is_mapping(at, end) ? NPH_FILE_SCENE : NPH_FILE_UNKNOWN;
}

NphFileKind nph_file_kind_of_bytes(const void *bytes, size_t size) {
    if (size == 0) return NPH_FILE_EMPTY;
    for (size_t i = 0; i < sizeof signatures / sizeof *signatures; i++)
        if (size >= signatures[i].size && memcmp(bytes, signatures[i].bytes, signatures[i].size) == 0)
            return signatures[i].kind;
    if (size > NPH_FILE_KIND_BYTES) size = NPH_FILE_KIND_BYTES;
    if (!is_text(bytes, size)) return NPH_FILE_UNKNOWN;
    return kind_of_text(bytes, (const char *)bytes + size);
}

NphStatus nph_file_kind(NphContext *context, const char *path, NphFileKind *kind) {
    char bytes[NPH_FILE_KIND_BYTES];
    size_t size = 0;
    NphStatus status = nph_file_read_start(context, path, bytes, sizeof bytes, &size);
    if (status == NPH_OK) *kind = nph_file_kind_of_bytes(bytes, size);
    return status;
}
