/* SPDX-License-Identifier: Apache-2.0
 *
 * NumPy's .npy: a magic word, a version, and a Python dictionary with the keys descr, fortran_order and shape; then the
 * elements. Reads versions 1 to 3, either byte order and either memory order; writes version 1.0, C order, the header
 * padded to a multiple of 64 bytes as NumPy does, so that equal arrays are equal files. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/file.h"
#include "io/printable.h"
#include "io/volume.h"

enum { MAGIC_BYTES = 6, PREAMBLE_BYTES = 10, PADDING = 64, HEADER_MAX = 512, START_MAX = 4096 };
static const char magic[] = "\x93NUMPY";

static const char codes[][3] = {"u1", "i1", "u2", "i2", "f2", "u4", "i4", "f4", "u8", "i8", "f8"}; /* as NphType */

typedef struct Header {
    NphContext *context;
    const char *path, *bytes, *at, *end; /* at walks through the dictionary */
    int has_descr, has_order, has_shape;
    NphType type;
    int swapped, fortran, rank;
    int64_t shape[NPH_MAX_RANK];
} Header;

static int machine_is_little_endian(void) {
    const uint16_t one = 1;
    unsigned char first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static NphStatus refuse(const Header *header, const char *what) {
    return nph_error(header->context, NPH_BAD_INPUT, "%s: byte %lld: %s", header->path,
                     (long long)(header->at - header->bytes), what);
}

static void skip_blanks(Header *header) {
    while (header->at < header->end && strchr(" \t\r\n", *header->at) && *header->at) header->at++;
}

/* Takes the character when it comes next, blanks aside. */
static int take(Header *header, char wanted) {
    skip_blanks(header);
    if (header->at == header->end || *header->at != wanted) return 0;
    header->at++;
    return 1;
}

static int take_word(Header *header, const char *word) {
    size_t length = strlen(word);
    skip_blanks(header);
    if ((size_t)(header->end - header->at) < length || memcmp(header->at, word, length) != 0) return 0;
    header->at += length;
    return 1;
}

/* A quoted string without escapes; [*begin, *end) is its inside. */
static int take_string(Header *header, const char **begin, const char **end) {
    skip_blanks(header);
    if (header->at == header->end || (*header->at != '\'' && *header->at != '"')) return 0;
    const char *close = memchr(header->at + 1, *header->at, (size_t)(header->end - header->at - 1));
    if (!close) return 0;
    *begin = header->at + 1;
    *end = close;
    header->at = close + 1;
    return 1;
}

static const char *kind_name(char kind) {
    switch (kind) {
    case 'O': return "Python objects";
    case 'c': return "complex numbers";
    case 'b': return "booleans";
    case 'S': case 'a': case 'U': return "text";
    case 'V': return "records";
    case 'M': case 'm': return "times";
    default: return "an unknown type";
    }
}

static NphStatus read_descr(Header *header) {
    const char *begin = NULL, *end = NULL;
    char shown[32];
    skip_blanks(header);
    if (header->at < header->end && *header->at == '[')
        return refuse(header, "the elements are structured records; save one plain array per file");
    if (!take_string(header, &begin, &end)) return refuse(header, "'descr' is not a text such as '<f4'");
    char order = end > begin ? *begin : '?';
    const char *code = begin + (strchr("<>=|", order) != NULL);
    for (int type = NPH_U8; type <= NPH_F64; type++) {
        if (end - code != 2 || memcmp(code, codes[type], 2) != 0) continue;
        size_t size = nph_type_size((NphType)type);
        if (order == '|' && size > 1) break;
        header->type = (NphType)type;
        header->swapped = size > 1 && order == (machine_is_little_endian() ? '>' : '<');
        return NPH_OK;
    }
    return nph_error(header->context, NPH_BAD_INPUT,
                     "%s: byte %lld: elements of type '%s' (%s) are not read; u1 to u8, i1 to i8, f2, f4 and f8 are",
                     header->path, (long long)(begin - header->bytes),
                     nph_printable(begin, (size_t)(end - begin), shown, sizeof shown),
                     kind_name(code < end ? *code : '?'));
}

static NphStatus read_shape(Header *header) {
    if (!take(header, '(')) return refuse(header, "'shape' is not a list of sizes in parentheses");
    while (!take(header, ')')) {
        skip_blanks(header);
        const char *begin = header->at;
        while (header->at < header->end && *header->at >= '0' && *header->at <= '9') header->at++;
        if (header->rank == NPH_MAX_RANK) return refuse(header, "the array has more than 6 dimensions");
        if (!nph_parse_int_range(begin, header->at, &header->shape[header->rank]))
            return refuse(header, "a size in 'shape' is not a number of at least 0");
        header->rank++;
        take(header, 'L'); /* as Python 2 wrote long numbers */
        if (take(header, ',')) continue;
        if (!take(header, ')')) return refuse(header, "'shape' is not closed");
        break;
    }
    return NPH_OK;
}

static NphStatus read_order(Header *header) {
    header->fortran = take_word(header, "True");
    if (!header->fortran && !take_word(header, "False")) return refuse(header, "'fortran_order' is not True or False");
    return NPH_OK;
}

static int is(const char *begin, const char *end, const char *word) {
    return (size_t)(end - begin) == strlen(word) && memcmp(begin, word, strlen(word)) == 0;
}

static NphStatus read_dictionary(Header *header) {
    if (!take(header, '{')) return refuse(header, "the header is not a dictionary");
    while (!take(header, '}')) {
        const char *key = NULL, *end = NULL;
        if (!take_string(header, &key, &end) || !take(header, ':'))
            return refuse(header, "the header's dictionary is damaged");
        if (is(key, end, "descr") && !header->has_descr++) NPH_TRY(read_descr(header));
        else if (is(key, end, "fortran_order") && !header->has_order++) NPH_TRY(read_order(header));
        else if (is(key, end, "shape") && !header->has_shape++) NPH_TRY(read_shape(header));
        else return refuse(header, "unknown or repeated key (descr, fortran_order and shape are known)");
        if (take(header, ',')) continue;
        if (!take(header, '}')) return refuse(header, "the header's dictionary is not closed");
        break;
    }
    skip_blanks(header);
    if (header->at != header->end) return refuse(header, "something follows the header's dictionary");
    if (!header->has_descr || !header->has_order || !header->has_shape)
        return refuse(header, "the header lacks descr, fortran_order or shape");
    return NPH_OK;
}

/* Magic, version and the header's extent, then the dictionary; leaves header->at at the first element. */
static NphStatus read_header(Header *header, size_t size) {
    const unsigned char *word = (const unsigned char *)header->bytes;
    if (size < PREAMBLE_BYTES || memcmp(word, magic, MAGIC_BYTES) != 0) return refuse(header, "is not a .npy file");
    unsigned major = word[6], minor = word[7];
    if (major < 1 || major > 3 || minor != 0)
        return nph_error(header->context, NPH_BAD_INPUT,
                         "%s: byte 6: version %u.%u of .npy is not read (1.0, 2.0 and 3.0 are)", header->path, major,
                         minor);
    size_t start = major == 1 ? PREAMBLE_BYTES : PREAMBLE_BYTES + 2, length = (size_t)word[8] | (size_t)word[9] << 8;
    header->at = header->bytes + 8;
    if (size < start) return refuse(header, "the file ends within its header");
    if (major > 1) length |= (size_t)word[10] << 16 | (size_t)word[11] << 24;
    if (length > size - start) return refuse(header, "the file ends within its header");
    header->at = header->bytes + start;
    header->end = header->at + length;
    return read_dictionary(header);
}

/* Elements against bytes, before anything is allocated. */
static NphStatus check_size(const Header *header, size_t bytes) {
    size_t element = nph_type_size(header->type), count = 1;
    int empty = 0, fits = 1;
    for (int axis = 0; axis < header->rank; axis++) empty |= header->shape[axis] == 0;
    for (int axis = 0; axis < header->rank && !empty; axis++) {
        fits = fits && (uint64_t)header->shape[axis] <= bytes / element / count;
        if (fits) count *= (size_t)header->shape[axis];
    }
    if (empty) count = 0;
    if (fits && count * element == bytes) return NPH_OK;
    return nph_error(header->context, NPH_BAD_INPUT,
                     "%s: byte %lld: %zu bytes follow the header, but its shape and type need %s%zu", header->path,
                     (long long)(header->at - header->bytes), bytes, fits ? "" : "more than ",
                     fits ? count * element : bytes);
}

static void copy_element(unsigned char *to, const unsigned char *from, size_t size, int swapped) {
    for (size_t i = 0; i < size; i++) to[i] = from[swapped ? size - 1 - i : i];
}

/* Fortran order: the first index is the fastest. Walks the file in its order, striding through the C-ordered array. */
static void copy_transposed(const Header *header, NphArray *array) {
    size_t size = nph_type_size(header->type);
    int64_t count = nph_array_count(array), index[NPH_MAX_RANK] = {0}, stride[NPH_MAX_RANK], place = 0, step = 1;
    for (int axis = header->rank - 1; axis >= 0; axis--) {
        stride[axis] = step;
        step *= header->shape[axis];
    }
    for (int64_t n = 0; n < count; n++) {
        copy_element((unsigned char *)array->data + (size_t)place * size,
                     (const unsigned char *)header->at + (size_t)n * size, size, header->swapped);
        for (int axis = 0; axis < header->rank; axis++) {
            place += stride[axis];
            if (++index[axis] < header->shape[axis]) break;
            place -= stride[axis] * header->shape[axis];
            index[axis] = 0;
        }
    }
}

static void copy_elements(const Header *header, NphArray *array, size_t bytes) {
    size_t size = nph_type_size(header->type);
    if (header->fortran && header->rank > 1) copy_transposed(header, array);
    else if (!header->swapped) memcpy(array->data, header->at, bytes);
    else
        for (size_t n = 0; n < bytes; n += size)
            copy_element((unsigned char *)array->data + n, (const unsigned char *)header->at + n, size, 1);
}

static NphStatus read_array(NphContext *context, const char *path, const char *bytes, size_t size, NphArray *array) {
    Header header = {.context = context, .path = path, .bytes = bytes, .at = bytes, .end = bytes};
    NphArray made = {0};
    NPH_TRY(read_header(&header, size));
    size_t left = size - (size_t)(header.at - bytes);
    NPH_TRY(check_size(&header, left));
    NPH_TRY(nph_array_new(context, header.type, header.rank, header.shape, path, &made));
    copy_elements(&header, &made, left);
    *array = made;
    return NPH_OK;
}

/* Of what begins at `offset`, as many bytes as its header asks for, or what there is. */
static NphStatus read_stretch(NphContext *context, const char *path, int64_t offset, char **bytes, size_t *size) {
    NPH_TRY(nph_file_read_stretch(context, path, offset, START_MAX, bytes, size));
    Header header = {.context = context, .path = path, .bytes = *bytes, .at = *bytes, .end = *bytes};
    NPH_TRY(read_header(&header, *size));
    size_t wanted = nph_type_size(header.type);
    for (int axis = 0; axis < header.rank; axis++) {
        size_t n = (size_t)header.shape[axis];
        wanted = n == 0 || wanted <= SIZE_MAX / 2 / n ? wanted * n : SIZE_MAX / 2;
    }
    wanted += (size_t)(header.at - *bytes);
    nph_free(context, *bytes);
    *bytes = NULL;
    return nph_file_read_stretch(context, path, offset, wanted, bytes, size);
}

/* The byte after '@' where an array begins, and the file's name before it; 0 where the name has none. */
static int split(const char *path, char file[4096], int64_t *offset) {
    const char *at = strrchr(path, '@');
    if (!at || at[1] < '0' || at[1] > '9' || !nph_parse_int(at + 1, offset)) return 0;
    return snprintf(file, 4096, "%.*s", (int)(at - path), path) < 4096;
}

NphStatus nph_npy_read(NphContext *context, const char *path, NphArray *array) {
    char file[4096], *bytes = NULL;
    size_t size = 0;
    int64_t offset = 0;
    NphStatus status = split(path, file, &offset) ? read_stretch(context, file, offset, &bytes, &size)
                                                  : nph_file_read(context, path, &bytes, &size);
    if (status == NPH_OK) status = read_array(context, path, bytes, size, array);
    nph_free(context, bytes);
    return status;
}

/* "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", blanks and a newline up to the padding. */
static size_t make_header(const NphArray *array, char header[HEADER_MAX]) {
    char order = nph_type_size(array->type) == 1 ? '|' : machine_is_little_endian() ? '<' : '>';
    size_t used = PREAMBLE_BYTES;
    used += (size_t)snprintf(header + used, HEADER_MAX - used,
                             "{'descr': '%c%s', 'fortran_order': False, 'shape': (", order, codes[array->type]);
    for (int axis = 0; axis < array->rank; axis++)
        used += (size_t)snprintf(header + used, HEADER_MAX - used, "%s%lld%s", axis ? ", " : "",
                                 (long long)array->shape[axis], array->rank == 1 ? "," : "");
    used += (size_t)snprintf(header + used, HEADER_MAX - used, "), }");
    size_t total = (used + 1 + PADDING - 1) / PADDING * PADDING, length = total - PREAMBLE_BYTES;
    memset(header + used, ' ', total - used);
    header[total - 1] = '\n';
    memcpy(header, magic, MAGIC_BYTES);
    header[6] = 1;
    header[7] = 0;
    header[8] = (char)(length & 255u);
    header[9] = (char)(length >> 8);
    return total;
}

NphStatus nph_npy_write(NphContext *context, const char *path, const NphArray *array) {
    char header[HEADER_MAX];
    size_t header_bytes = make_header(array, header);
    size_t bytes = (size_t)nph_array_count(array) * nph_type_size(array->type);
    NphWriter writer;
    NPH_TRY(nph_writer_open(context, path, &writer));
    fwrite(header, 1, header_bytes, writer.stream); /* the stream keeps its errors; the commit reports them */
    if (bytes) fwrite(array->data, 1, bytes, writer.stream);
    return nph_writer_commit(context, &writer);
}

NphStatus nph_array_read_npy(NphContext *context, const char *path, NphArray *array) { return nph_npy_read(context, path, array); }

NphStatus nph_array_write_npy(NphContext *context, const char *path, const NphArray *array) {
    return nph_npy_write(context, path, array);
}

NphStatus nph_npy_append(NphContext *context, NphAppender *file, const NphArray *array, int64_t stride, int64_t *size) {
    static const char gap[PADDING];
    char header[HEADER_MAX];
    size_t header_bytes = make_header(array, header), bytes = (size_t)nph_array_count(array) * nph_type_size(array->type);
    size_t total = header_bytes + (bytes + PADDING - 1) / PADDING * PADDING;
    int64_t rows = stride && bytes ? array->shape[0] : 1;
    NPH_TRY(nph_appender_add(context, file, header, header_bytes));
    for (int64_t r = 0; r < rows; r++)
        NPH_TRY(nph_appender_add(context, file, (const char *)array->data + r * stride, bytes / (size_t)rows));
    *size += (int64_t)total;
    return nph_appender_add(context, file, gap, total - header_bytes - bytes);
}
