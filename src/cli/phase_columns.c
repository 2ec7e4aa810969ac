/* SPDX-License-Identifier: Apache-2.0
 *
 * See phase_columns.h. Text is what scenes read (one column); code holds the same numbers as arrays of single precision. */
#include "cli/phase_columns.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "cli/options.h"
#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/file.h"

enum { EVEN_ROWS = 1801 };

static const char *const endings[] = {".txt", ".csv", ".npy", ".h", ".glsl", ".wgsl", ".svg", ".png"};
enum { TXT, CSV, NPY, C_HEADER, GLSL, WGSL, SVG, PNG, ENDINGS };

void phase_columns_free(NphContext *context, PhaseColumns *columns) {
    for (int c = 0; c < columns->count; c++) nph_phase_free(context, &columns->phases[c]);
    columns->count = 0;
}

static int compare_numbers(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Degrees of a table's rows, by their distances from the poles. */
static int64_t own_angles(const NphPhaseTable *table, double *degrees) {
    int64_t used = 0;
    for (int h = 0; h < 2; h++)
        for (int i = 0; i <= table->half[h].count - (table->half[h].x[table->half[h].count] >= 1.0); i++) {
            double angle = 2.0 * nph_asin(nph_sqrt(0.5 * table->half[h].x[i])) * (180.0 / 3.14159265358979323846);
            degrees[used++] = h ? 180.0 - angle : angle;
        }
    return used;
}

static NphStatus gather_angles(NphContext *context, const PhaseColumns *columns, double **degrees, int64_t *count) {
    int64_t most = 3, used = 0;
    for (int c = 0; c < columns->count; c++)
        for (int h = 0; h < 2 && columns->phases[c].table; h++) most += columns->phases[c].table->half[h].count + 1;
    NPH_TRY(NPH_NEW(context, most, "angles", degrees));
    (*degrees)[used++] = 0.0;
    (*degrees)[used++] = 90.0;
    (*degrees)[used++] = 180.0;
    for (int c = 0; c < columns->count; c++)
        if (columns->phases[c].table) used += own_angles(columns->phases[c].table, *degrees + used);
    qsort(*degrees, (size_t)used, sizeof **degrees, compare_numbers);
    int64_t kept = 0;
    for (int64_t i = 0; i < used; i++) /* equal but for rounding */
        if (kept == 0 || (*degrees)[i] - (*degrees)[kept - 1] > 1e-9) (*degrees)[kept++] = (*degrees)[i];
    if ((*degrees)[kept - 1] > 180.0 - 1e-8) (*degrees)[kept - 1] = 180.0;
    *count = kept;
    return NPH_OK;
}

static double value_at(const NphPhase *phase, double degrees) {
    double sine, cosine;
    nph_sincos2pi(degrees / 360.0, &sine, &cosine);
    if (phase->kind != NPH_PHASE_TABULATED) return nph_phase_value(phase, cosine);
    /* by the distance from the nearer pole, which keeps its digits */
    const NphPhaseHalf *half = &phase->table->half[degrees > 90.0];
    nph_sincos2pi((degrees > 90.0 ? 180.0 - degrees : degrees) / 720.0, &sine, &cosine);
    double x = 2.0 * sine * sine;
    int low = 0, high = half->count;
    while (high - low > 1) *(half->x[(low + high) / 2] <= x ? &low : &high) = (low + high) / 2;
    double along = (x - half->x[low]) / (half->x[high] - half->x[low]);
    along = along < 1.0 ? along : 1.0;
    return half->value[low] + along * (half->value[high] - half->value[low]);
}

NphStatus phase_columns_rows(NphContext *context, const PhaseColumns *columns, int64_t rows, NphArray *array) {
    double *degrees = NULL;
    int64_t count = rows;
    int tables = 0;
    for (int c = 0; c < columns->count; c++) tables += columns->phases[c].table != NULL;
    if (rows == 0 && tables == 0) count = EVEN_ROWS;
    NphStatus status = rows == 0 && tables > 0 ? gather_angles(context, columns, &degrees, &count) : NPH_OK;
    if (status == NPH_OK) status = nph_array_new(context, NPH_F64, 2, (int64_t[]){count, columns->count + 1}, "table", array);
    for (int64_t i = 0; i < count && status == NPH_OK; i++) {
        double *row = (double *)array->data + i * (columns->count + 1);
        row[0] = degrees ? degrees[i] : 180.0 * (double)i / (double)(count - 1);
        for (int c = 0; c < columns->count; c++) row[1 + c] = value_at(&columns->phases[c], row[0]);
    }
    nph_free(context, degrees);
    return status;
}

static int ending_of(const char *path) {
    const char *dot = strrchr(path, '.');
    for (int i = 0; i < ENDINGS && dot; i++)
        if (strcmp(dot, endings[i]) == 0) return i;
    return -1;
}

NphStatus phase_file_check(const char *command, const char *path) {
    if (ending_of(path) >= 0) return NPH_OK;
    return usage_error(command, "-o %s: a table ends in .txt, .csv, .npy, .h, .glsl or .wgsl, a chart in .svg or .png", path);
}

/* nephos_phase, or what the file is called, as a name in code. */
static void code_name(const char *path, char name[64]) {
    const char *slash = strrchr(path, '/'), *at = slash ? slash + 1 : path;
    size_t used = 0;
    if (!isalpha((unsigned char)*at)) name[used++] = 'p';
    for (; *at && *at != '.' && used < 60; at++) name[used++] = (char)(isalnum((unsigned char)*at) ? tolower((unsigned char)*at) : '_');
    name[used] = 0;
}

static void write_text(FILE *out, const PhaseColumns *columns, const NphArray *rows, const char *separator) {
    char text[NPH_DOUBLE_TEXT];
    fprintf(out, "# %s\n# scattering angle [degrees]%svalue [1/sr]", columns->title, separator);
    for (int c = 0; c < columns->count && columns->count > 1; c++) fprintf(out, "%s%s", c ? separator : ": ", columns->names[c]);
    fputc('\n', out);
    const double *at = rows->data;
    for (int64_t i = 0; i < rows->shape[0]; i++)
        for (int64_t c = 0; c < rows->shape[1]; c++)
            fprintf(out, "%s%s", nph_format_double(*at++, text), c + 1 < rows->shape[1] ? separator : "\n");
}

/* One array: `open`, numbers of a column with a point or an exponent, `close`. */
static void write_array(FILE *out, const NphArray *rows, int64_t column, const char *close) {
    for (int64_t i = 0; i < rows->shape[0]; i++) {
        char text[48];
        snprintf(text, sizeof text, "%.9g", ((const double *)rows->data)[i * rows->shape[1] + column]);
        const char *point = strpbrk(text, ".e") ? "" : ".0";
        fprintf(out, "%s%s%s", i == 0 ? "" : i % 8 ? ", " : ",\n    ", text, point);
        if (strcmp(close, "};\n") == 0) fputc('f', out);
    }
    fputs(close, out);
}

/* What of each column is scattered forwards. */
static void write_forward(FILE *out, const PhaseColumns *columns, int kind, const char *name) {
    int count = columns->count;
    fputs("// part of each in front of 90 degrees\n", out);
    if (kind == C_HEADER) fprintf(out, "static const float %s_forward[%d] = {", name, count);
    if (kind == GLSL) fprintf(out, "const float %s_forward[%d] = float[%d](", name, count, count);
    if (kind == WGSL) fprintf(out, "const %s_forward = array<f32, %d>(", name, count);
    for (int c = 0; c < count; c++) fprintf(out, "%s%.9f%s", c ? ", " : "", columns->forward[c], kind == C_HEADER ? "f" : "");
    fputs(kind == C_HEADER ? "};\n" : ");\n", out);
}

static void write_code(FILE *out, const PhaseColumns *columns, const NphArray *rows, int kind, const char *path) {
    char name[64];
    long long count = (long long)rows->shape[0];
    code_name(path, name);
    fprintf(out, "// %s\n// Scattering angles in degrees and values in 1/sr, linear in the cosine between them.\n",
            columns->title);
    if (kind == C_HEADER) fprintf(out, "#ifndef %s_h\n#define %s_h\n\nenum { %s_count = %lld };\n\n", name, name, name, count);
    if (kind == GLSL) fprintf(out, "const int %s_count = %lld;\n\n", name, count);
    if (kind == WGSL) fprintf(out, "const %s_count : i32 = %lld;\n\n", name, count);
    for (int64_t c = 0; c < rows->shape[1]; c++) {
        char what[16] = "degrees";
        if (c > 0) snprintf(what, sizeof what, columns->count > 1 ? "per_sr_%d" : "per_sr", (int)c);
        if (c > 0 && columns->count > 1) fprintf(out, "// %s\n", columns->names[c - 1]);
        if (kind == C_HEADER) fprintf(out, "static const float %s_%s[%lld] = {\n    ", name, what, count);
        if (kind == GLSL) fprintf(out, "const float %s_%s[%lld] = float[%lld](\n    ", name, what, count, count);
        if (kind == WGSL) fprintf(out, "const %s_%s = array<f32, %lld>(\n    ", name, what, count);
        write_array(out, rows, c, kind == C_HEADER ? "};\n" : ");\n");
    }
    write_forward(out, columns, kind, name);
    if (kind == C_HEADER) fputs("\n#endif\n", out);
}

static NphStatus write_chart(NphContext *context, const PhaseColumns *columns, const NphArray *rows, ChartKind kind, const char *path) {
    ChartCurve curves[CHART_MOST_CURVES];
    int64_t count = rows->shape[0], wide = rows->shape[1];
    double *numbers = NULL;
    NPH_TRY(NPH_NEW(context, count * wide, "chart", &numbers));
    for (int64_t i = 0; i < count; i++)
        for (int64_t c = 0; c < wide; c++) numbers[c * count + i] = ((const double *)rows->data)[i * wide + c];
    for (int c = 0; c < columns->count; c++) {
        curves[c] = (ChartCurve){.name = columns->names[c], .count = (int)count, .degrees = numbers, .value = numbers + (c + 1) * count};
        memcpy(curves[c].rgb, columns->rgb[c], 3);
    }
    Chart chart = {kind, columns->title, columns->count, curves};
    NphStatus status = chart_write(context, &chart, path);
    nph_free(context, numbers);
    return status;
}

NphStatus phase_file_write(NphContext *context, const PhaseColumns *columns, const NphArray *rows, ChartKind kind, const char *path) {
    int ending = ending_of(path);
    NphWriter writer = {0};
    if (ending == SVG || ending == PNG) return write_chart(context, columns, rows, kind, path);
    if (ending == NPY) return nph_array_write_npy(context, path, rows);
    NPH_TRY(nph_writer_open(context, path, &writer));
    if (ending == TXT || ending == CSV) write_text(writer.stream, columns, rows, ending == CSV ? "," : " ");
    else write_code(writer.stream, columns, rows, ending, path);
    return nph_writer_commit(context, &writer);
}
