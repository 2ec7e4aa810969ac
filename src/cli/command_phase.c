/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos phase: computes phase functions, tells what they are like, writes tables and charts of them. */
#include <string.h>

#include "cli/command.h"
#include "cli/facts.h"
#include "cli/phase_columns.h"
#include "cli/session.h"
#include "core/fmath.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/text.h"
#include "io/phase_rows.h"
#include "optics/air.h"
#include "optics/cie.h"
#include "optics/crystal.h"
#include "optics/index.h"
#include "optics/legendre.h"
#include "optics/mie_table.h"
#include "scene/scene_keys.h"

#define KINDS "mie|ice|snow|isotropic|hg|two_lobe|rayleigh|draine"
enum { MIE, ICE, SNOW, ISOTROPIC, HG, TWO_LOBE, RAYLEIGH, DRAINE, FROM_FILE = -1 };

static const double MOLECULES_PER_M3 = 2.546899e25, SNOW_TILT = 0.3; /* of nph_rayleigh_per_m's air; [Macke96] */
static const uint8_t palette[][3] = {{31, 119, 180}, {214, 39, 40}, {44, 160, 44}, {148, 103, 189}, {255, 127, 14}, {23, 190, 207}, {140, 86, 75}, {90, 90, 90}};
enum { PALETTE = (int)(sizeof palette / sizeof palette[0]) };

typedef struct PhaseCommand {
    Session session;
    Facts facts;
    const char *what;               /* the argument */
    int kind, json;
    const char *particle, *sizes_word, *plot;
    TextList wavelengths, outputs;
    double radius_um, spread, alpha, gamma, tolerance;
    double g[2], weight;
    double length_um, edge_um, tilt;
    int64_t rays, seed, times, rows;
    int alpha_given, spread_given, radius_given, g_given, g2_given, weight_given, tilt_given;
    int chart;
    double nm[NPH_MIE_WAVELENGTHS];
    NphSizes sizes;
    int material;                   /* or -1: index */
    double index[2];
    char title[160];
    PhaseColumns columns;
} PhaseCommand;

/* ---- options ---- */

static NphStatus read_wavelengths(PhaseCommand *command) {
    for (int i = 0; i < command->wavelengths.count; i++) {
        double *nm = &command->nm[i];
        if (i >= NPH_MIE_WAVELENGTHS || !nph_parse_double(command->wavelengths.items[i], nm) || !(*nm >= 200.0 && *nm <= 20000.0))
            return usage_error("phase", "--wavelength %s: a wavelength is a number of nanometres from 200 to 20000", command->wavelengths.items[i]);
    }
    if (command->wavelengths.count > 0) return NPH_OK;
    command->wavelengths.count = 1;
    command->nm[0] = 550.0;
    return NPH_OK;
}

/* water | ice | soot, or n,k. */
static NphStatus read_particle(PhaseCommand *command) {
    char text[64];
    command->material = nph_words_index(NPH_MATERIAL_WORDS, command->particle);
    if (command->material >= 0) return NPH_OK;
    const char *comma = strchr(command->particle, ',');
    if (comma && (size_t)(comma - command->particle) < sizeof text) {
        snprintf(text, sizeof text, "%.*s", (int)(comma - command->particle), command->particle);
        if (nph_parse_double(text, &command->index[0]) && nph_parse_double(comma + 1, &command->index[1])) return NPH_OK;
    }
    return usage_error("phase", "--particle %s: expected water, ice, soot, or a refractive index N,K such as 1.5,0.01", command->particle);
}

static NphStatus read_sizes(PhaseCommand *command) {
    int kind = nph_words_index(NPH_SIZES_WORDS, command->sizes_word);
    if (kind < 0) return usage_error("phase", "--sizes %s: expected single, lognormal, gamma or modified_gamma", command->sizes_word);
    if (!command->radius_given) return usage_error("phase", "mie needs --radius UM");
    if ((kind == NPH_SIZES_LOGNORMAL || kind == NPH_SIZES_GAMMA) && !command->spread_given)
        return usage_error("phase", "--sizes %s needs --spread S", command->sizes_word);
    if (kind == NPH_SIZES_MODIFIED_GAMMA && !command->alpha_given) return usage_error("phase", "--sizes modified_gamma needs --alpha A");
    command->sizes = (NphSizes){(NphSizesKind)kind, command->radius_um, command->spread, command->alpha, command->gamma};
    const char *mistake = nph_sizes_mistake(&command->sizes);
    return mistake ? usage_error("phase", "%s", mistake) : NPH_OK;
}

static NphStatus read_options(PhaseCommand *command) {
    const char *slash = strpbrk(command->what, "./");
    command->kind = nph_words_index(KINDS, command->what);
    if (command->kind < 0 && !slash)
        return usage_error("phase", "'%s' is no kind of phase function: mie, ice, snow, isotropic, hg, two_lobe, rayleigh, draine, or the file of a table",
                           command->what);
    command->chart = nph_words_index("linear|log|polar", command->plot);
    if (command->chart < 0) return usage_error("phase", "--plot %s: expected linear, log or polar", command->plot);
    if (command->rows == 1) return usage_error("phase", "--rows 1: a table has at least 2");
    NPH_TRY(read_wavelengths(command));
    NPH_TRY(read_particle(command));
    if (command->kind == MIE) NPH_TRY(read_sizes(command));
    if ((command->kind == HG || command->kind == TWO_LOBE || command->kind == DRAINE) && !command->g_given)
        return usage_error("phase", "%s needs --g G", command->what);
    if (command->kind == TWO_LOBE && !(command->g2_given && command->weight_given)) return usage_error("phase", "two_lobe needs --g2 G and --weight W");
    if (command->kind == DRAINE && !command->alpha_given) return usage_error("phase", "draine needs --alpha A");
    if (command->times > 1 && command->wavelengths.count > 1) return usage_error("phase", "--times goes with one wavelength");
    for (int i = 0; i < command->outputs.count; i++) NPH_TRY(phase_file_check("phase", command->outputs.items[i]));
    return NPH_OK;
}

/* ---- what they are like ---- */

static NphPhase *add_column(PhaseCommand *command, const char *name, const uint8_t rgb[3]) {
    PhaseColumns *columns = &command->columns;
    int c = columns->count++;
    snprintf(columns->names[c], sizeof columns->names[c], "%s", name);
    memcpy(columns->rgb[c], rgb, 3);
    columns->phases[c] = (NphPhase){.kind = NPH_PHASE_ISOTROPIC};
    return &columns->phases[c];
}

static double forward_part(const NphPhase *phase) {
    enum { STEPS = 4096 };
    if (phase->table) return phase->table->half[0].part[phase->table->half[0].count];
    double sum = 0.0; /* Simpson's rule in s, cos = 1 - s^4: narrow peaks are spread out */
    for (int i = 0; i <= STEPS; i++) {
        double s = (double)i / STEPS, weight = i == 0 || i == STEPS ? 1.0 : i % 2 ? 4.0 : 2.0;
        sum += weight * 4.0 * s * s * s * nph_phase_value(phase, 1.0 - s * s * s * s);
    }
    return 2.0 * 3.14159265358979323846 * sum / (3.0 * STEPS);
}

static void tell_phase(Facts *facts, const NphPhase *phase) {
    facts_number(facts, "mean_cosine", nph_phase_mean_cosine(phase));
    facts_number(facts, "forward_part", forward_part(phase));
    facts_numbers(facts, "at_0_90_180_degrees_per_sr", 3,
                  (double[]){nph_phase_value(phase, 1.0), nph_phase_value(phase, 0.0), nph_phase_value(phase, -1.0)});
}

static void tell_mie(Facts *facts, const NphMieTable *table) {
    const NphMieTotals *t = &table->totals;
    facts_number(facts, "extinction_efficiency", t->extinction_um2 / t->geometric_um2);
    facts_number(facts, "albedo", t->scattering_um2 / t->extinction_um2);
    facts_number(facts, "asymmetry", t->asymmetry);
    facts_number(facts, "extinction_per_particle_um2", t->extinction_um2);
    facts_number(facts, "absorption_per_particle_um2", t->absorption_um2);
    facts_number(facts, "effective_radius_um", t->effective_radius_um);
    facts_number(facts, "effective_variance", t->effective_variance);
    facts_integer(facts, "sizes", table->sizes);
    facts_integer(facts, "rows", table->rows.shape[0]);
    facts_numbers(facts, "changed_by_the_last_halving_of_sizes_and_angles", 2, (double[]){table->size_error, table->angle_error});
    facts_number(facts, "norm_before_normalising", table->norm);
}

static void tell_crystal(Facts *facts, const NphCrystalTable *table) {
    const NphCrystalRays *rays = &table->rays;
    facts_number(facts, "extinction_efficiency", 2.0);
    facts_number(facts, "albedo", table->albedo);
    facts_numbers(facts, "asymmetry_and_standard_error", 2, (double[]){table->asymmetry, table->asymmetry_error});
    facts_number(facts, "extinction_per_particle_um2", table->extinction_um2);
    facts_integer(facts, "rays_that_met_it", rays->hits);
    facts_numbers(facts, "mean_cosine_of_rays_and_standard_error", 2, (double[]){rays->mean_cosine, rays->mean_cosine_error});
    facts_numbers(facts, "projected_area_um2_its_standard_error_and_exact", 3,
                  (double[]){rays->projected_um2, rays->projected_error_um2, 0.5 * table->extinction_um2});
    facts_numbers(facts, "parts_straight_on_absorbed_lost", 3, (double[]){rays->straight, rays->absorbed, rays->lost});
    facts_integer(facts, "rows", table->rows.shape[0]);
}

/* The colour of a wavelength; palette where it is hardly seen. */
static void colour_of(double nm, int number, uint8_t rgb[3]) {
    memcpy(rgb, palette[number % PALETTE], 3);
    if (!(nm >= 400.0 && nm <= 700.0)) return;
    double seen[3], most = 0.0;
    nph_rgb_from_xyz(nph_cie1931[(int)nm - NPH_CIE_FIRST_NM], seen);
    for (int c = 0; c < 3; c++) most = seen[c] > most ? seen[c] : most;
    for (int c = 0; c < 3; c++) rgb[c] = (uint8_t)(220.0 * nph_sqrt(seen[c] > 0.0 ? seen[c] / most : 0.0));
}

/* ---- making them ---- */

static NphStatus index_for(PhaseCommand *command, int material, double um, double index[2]) {
    if (material >= 0 && nph_index_at((NphMaterial)material, um, index)) return NPH_OK;
    if (material < 0) {
        memcpy(index, command->index, sizeof command->index);
        return NPH_OK;
    }
    return nph_error(command->session.context, NPH_BAD_INPUT, "%s has no refractive index in the table at %g nm", nph_index_tables[material].name, 1e3 * um);
}

static NphStatus make_mie(PhaseCommand *command, double um, NphPhase *phase) {
    NphContext *context = command->session.context;
    NphMieRequest request = {.sizes = command->sizes, .wavelength_count = 1, .wavelength_um = {um}, .tolerance = command->tolerance};
    NphMieTable table = {.rows = {.rank = 0}};
    NPH_TRY(index_for(command, command->material, um, request.index[0]));
    NPH_TRY(nph_mie_table(context, &request, "mie", &table));
    NphStatus status = nph_phase_tabulate(context, &table.rows, "mie", phase);
    if (status == NPH_OK) {
        facts_numbers(&command->facts, "refractive_index", 2, request.index[0]);
        tell_mie(&command->facts, &table);
    }
    nph_mie_table_free(context, &table);
    return status;
}

static NphStatus make_crystal(PhaseCommand *command, double um, NphPhase *phase) {
    NphContext *context = command->session.context;
    NphCrystal crystal = {.length_um = command->length_um, .edge_um = command->edge_um, .tilt = command->tilt_given ? command->tilt : command->kind == SNOW ? SNOW_TILT : 0.0,
                          .wavelength_um = um, .rays = command->rays, .seed = (uint32_t)command->seed};
    NphCrystalTable table = {.rows = {.rank = 0}};
    NPH_TRY(index_for(command, NPH_ICE, um, crystal.index));
    NPH_TRY(nph_crystal_table(context, &crystal, command->what, &table));
    NphStatus status = nph_phase_tabulate(context, &table.rows, command->what, phase);
    if (status == NPH_OK) {
        facts_numbers(&command->facts, "refractive_index", 2, crystal.index);
        tell_crystal(&command->facts, &table);
    }
    nph_crystal_table_free(context, &table);
    return status;
}

static NphStatus make_file(PhaseCommand *command, NphPhase *phase) {
    NphArray rows = {.rank = 0};
    NphContext *context = command->session.context;
    NPH_TRY(nph_phase_rows_read(context, command->what, &rows));
    NphStatus status = nph_phase_tabulate(context, &rows, command->what, phase);
    nph_array_free(context, &rows);
    return status;
}

static void make_closed(PhaseCommand *command, NphPhase *phase) {
    static const NphPhaseKind kinds[] = {[ISOTROPIC] = NPH_PHASE_ISOTROPIC, [HG] = NPH_PHASE_HG, [TWO_LOBE] = NPH_PHASE_TWO_LOBE,
                                         [RAYLEIGH] = NPH_PHASE_RAYLEIGH, [DRAINE] = NPH_PHASE_DRAINE};
    *phase = (NphPhase){.kind = kinds[command->kind], .g = {command->g[0], command->g[1]}, .weight = command->weight, .alpha = command->alpha};
}

/* Cross section and coefficient of air at sea level at each wavelength; the phase function is one. */
static void tell_rayleigh(PhaseCommand *command) {
    for (int i = 0; i < command->wavelengths.count; i++) {
        char name[48];
        snprintf(name, sizeof name, "%g nm", command->nm[i]);
        facts_item(&command->facts, name);
        if (command->nm[i] < 250.0 || command->nm[i] > 850.0) facts_text(&command->facts, "scattering", "not known beyond 250 to 850 nm");
        else {
            double per_m = nph_rayleigh_per_m(command->nm[i]);
            facts_number(&command->facts, "scattering_per_m", per_m);
            facts_number(&command->facts, "cross_section_m2", per_m / MOLECULES_PER_M3);
        }
        facts_end(&command->facts);
    }
}

static NphStatus make_one(PhaseCommand *command, int wavelength) {
    char name[48];
    uint8_t rgb[3];
    double nm = command->nm[wavelength];
    snprintf(name, sizeof name, "%g nm", nm);
    colour_of(nm, wavelength, rgb);
    NphPhase *phase = add_column(command, name, rgb);
    facts_item(&command->facts, name);
    NphStatus status = command->kind == MIE ? make_mie(command, 1e-3 * nm, phase) : make_crystal(command, 1e-3 * nm, phase);
    if (status == NPH_OK) tell_phase(&command->facts, phase);
    facts_end(&command->facts);
    return status;
}

static NphStatus make_columns(PhaseCommand *command) {
    int spectral = command->kind == MIE || command->kind == ICE || command->kind == SNOW;
    if (!spectral) {
        NphPhase *phase = add_column(command, command->what, palette[0]);
        if (command->kind == FROM_FILE) NPH_TRY(make_file(command, phase));
        else make_closed(command, phase);
        tell_phase(&command->facts, phase);
    }
    if (!spectral && command->kind != RAYLEIGH) return NPH_OK;
    facts_list(&command->facts, "wavelengths");
    NphStatus status = NPH_OK;
    if (!spectral) tell_rayleigh(command);
    for (int i = 0; i < command->wavelengths.count && spectral && status == NPH_OK; i++) status = make_one(command, i);
    facts_end(&command->facts);
    return status;
}

/* After 1, 2, ... scatterings in place of the function itself. */
static NphStatus make_times(PhaseCommand *command) {
    NphContext *context = command->session.context;
    NphConvolutions made = {.count = 0};
    double *moment = NULL;
    int count = 0;
    if (command->times == 0) return NPH_OK;
    NPH_TRY(nph_phase_all_moments(context, &command->columns.phases[0], 1e-8, &count, &moment));
    NphStatus status = nph_phase_convolve(context, count, moment, (int)command->times, command->what, &made);
    nph_free(context, moment);
    NPH_TRY(status);
    phase_columns_free(context, &command->columns);
    facts_integer(&command->facts, "moments", count);
    facts_list(&command->facts, "scatterings");
    for (int i = 0; i < made.count; i++) {
        char name[48];
        uint8_t rgb[3];
        for (int c = 0; c < 3; c++) rgb[c] = (uint8_t)(palette[0][c] + (palette[1][c] - palette[0][c]) * i / (made.count > 1 ? made.count - 1 : 1));
        snprintf(name, sizeof name, "%d", i + 1);
        *add_column(command, name, rgb) = made.after[i];
        made.after[i].table = NULL; /* moved */
        facts_item(&command->facts, name);
        tell_phase(&command->facts, &command->columns.phases[i]);
        facts_end(&command->facts);
    }
    facts_end(&command->facts);
    nph_convolutions_free(context, &made);
    return NPH_OK;
}

static void make_title(PhaseCommand *command) {
    char *title = command->title;
    size_t size = sizeof command->title;
    if (command->kind == MIE)
        snprintf(title, size, "mie, %s, %s, radius %g um", command->particle, command->sizes_word, command->radius_um);
    else if (command->kind == ICE || command->kind == SNOW)
        snprintf(title, size, "%s, prism of length %g um, edge %g um", command->what, command->length_um, command->edge_um);
    else if (command->kind == HG) snprintf(title, size, "hg, g %g", command->g[0]);
    else snprintf(title, size, "%s", command->what);
    size_t used = strlen(title);
    if (command->times > 0) snprintf(title + used, size - used, ", after 1 to %d scatterings", (int)command->times);
    command->columns.title = title;
}

static NphStatus write_files(PhaseCommand *command) {
    NphArray rows = {.rank = 0};
    NphContext *context = command->session.context;
    if (command->outputs.count == 0) return NPH_OK;
    NphStatus status = phase_columns_rows(context, &command->columns, command->rows, &rows);
    for (int i = 0; i < command->outputs.count && status == NPH_OK; i++)
        status = phase_file_write(context, &command->columns, &rows, (ChartKind)command->chart, command->outputs.items[i]);
    nph_array_free(context, &rows);
    return status;
}

static NphStatus compute(PhaseCommand *command) {
    for (int i = 0; i < command->outputs.count; i++) NPH_TRY(check_writable(&command->session, command->outputs.items[i]));
    NPH_TRY(facts_begin(&command->facts, command->json));
    make_title(command);
    facts_text(&command->facts, "phase_function", command->title);
    NphStatus status = make_columns(command);
    if (status == NPH_OK) status = make_times(command);
    for (int c = 0; c < command->columns.count && status == NPH_OK; c++) command->columns.forward[c] = forward_part(&command->columns.phases[c]);
    if (status == NPH_OK) status = write_files(command);
    phase_columns_free(command->session.context, &command->columns);
    return facts_finish(&command->facts, status);
}

/* ---- the command ---- */

static void number_option(OptionTable *table, const char *name, double *target, const char *value_name, double min, double max, int *given, const char *meaning) {
    option_add(table, (Option){.name = name, .kind = OPTION_NUMBER, .target = target, .value_name = value_name, .min = min, .max = max, .given = given,
                               .meaning = meaning});
}

static void add_particle_options(OptionTable *table, PhaseCommand *command) {
    option_add(table, (Option){.name = "wavelength", .letter = 'w', .kind = OPTION_LIST, .target = &command->wavelengths, .value_name = "NM",
                               .meaning = "550; may be given several times, each a column"});
    option_add(table, (Option){.name = "particle", .kind = OPTION_TEXT, .target = &command->particle, .value_name = "P",
                               .meaning = "mie: water (default), ice, soot, or a refractive index N,K"});
    option_add(table, (Option){.name = "sizes", .kind = OPTION_TEXT, .target = &command->sizes_word, .value_name = "S",
                               .meaning = "mie: single (default), lognormal, gamma or modified_gamma"});
    number_option(table, "radius", &command->radius_um, "UM", NPH_SIZES_LEAST_UM, NPH_SIZES_MOST_UM, &command->radius_given,
                  "mie: radius, median radius, effective radius or most frequent radius");
    number_option(table, "spread", &command->spread, "S", 1e-4, 5, &command->spread_given, "mie: geometric standard deviation (lognormal) or effective variance (gamma)");
    number_option(table, "alpha", &command->alpha, "A", 0, 1000, &command->alpha_given, "of modified_gamma or draine");
    number_option(table, "gamma", &command->gamma, "G", 0.1, 10, NULL, "of modified_gamma; 1");
    number_option(table, "tolerance", &command->tolerance, "T", 1e-4, 0.5, NULL, "mie: relative, of the sum over sizes and between rows; 0.01");
    number_option(table, "length", &command->length_um, "UM", 1e-3, 1e6, NULL, "ice, snow: length of the prism; 100");
    number_option(table, "edge", &command->edge_um, "UM", 1e-3, 1e6, NULL, "ice, snow: edge of its hexagon, half its width; 50");
    number_option(table, "tilt", &command->tilt, "T", 0, 0.99, &command->tilt_given, "ice, snow: roughness; 0 for ice, 0.3 for snow");
    option_add(table, (Option){.name = "rays", .kind = OPTION_INT, .target = &command->rays, .value_name = "N", .min = 1, .max = (double)NPH_CRYSTAL_MOST_RAYS,
                               .meaning = "ice, snow; 1048576"});
    option_add(table, (Option){.name = "seed", .letter = 's', .kind = OPTION_INT, .target = &command->seed, .value_name = "N", .min = 0, .max = 4294967295.0,
                               .meaning = "of the rays; 1"});
}

static void add_options(OptionTable *table, PhaseCommand *command) {
    option_add(table, (Option){.name = "output", .letter = 'o', .kind = OPTION_LIST, .target = &command->outputs, .value_name = "FILE",
                               .meaning = "table (.txt .csv .npy .h .glsl .wgsl) or chart (.svg .png); several times"});
    option_add(table, (Option){.name = "plot", .kind = OPTION_TEXT, .target = &command->plot, .value_name = "K", .meaning = "charts: log (default), linear or polar"});
    option_add(table, (Option){.name = "rows", .kind = OPTION_INT, .target = &command->rows, .value_name = "N", .min = 0, .max = 1 << 20,
                               .meaning = "evenly spaced angles; default: those the function needs"});
    option_add(table, (Option){.name = "times", .kind = OPTION_INT, .target = &command->times, .value_name = "N", .min = 0, .max = CHART_MOST_CURVES,
                               .meaning = "what 1, 2, ... N scatterings make of it, a column each"});
    add_particle_options(table, command);
    number_option(table, "g", &command->g[0], "G", -0.99999, 0.99999, &command->g_given, "hg, two_lobe, draine: mean cosine of the (first) lobe");
    number_option(table, "g2", &command->g[1], "G", -0.99999, 0.99999, &command->g2_given, "two_lobe: of the second one");
    number_option(table, "weight", &command->weight, "W", 0, 1, &command->weight_given, "two_lobe: share of the first one");
    option_add(table, (Option){.name = "json", .kind = OPTION_FLAG, .target = &command->json, .meaning = "as JSON on standard output"});
    session_add_options(table, &command->session);
}

static NphStatus run(const Command *command, int argc, char **argv) {
    static PhaseCommand phase;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    phase = (PhaseCommand){.particle = "water", .sizes_word = "single", .plot = "log", .gamma = 1.0, .tolerance = 0.01, .length_um = 100.0, .edge_um = 50.0,
                           .rays = 1 << 20, .seed = 1};
    add_options(&table, &phase);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    phase.what = files.items[0];
    NPH_TRY(read_options(&phase));
    NPH_TRY(session_open(&phase.session, command->name));
    return session_close(&phase.session, compute(&phase));
}

const Command command_phase = {
    .name = "phase",
    .arguments = "KIND|TABLE [options]",
    .summary = "phase functions: Mie, ice crystals, closed forms; tables, charts",
    .before = "Computes a phase function and tells its mean cosine, efficiencies and albedo; -o writes tables that scenes read\n"
              "(phase: {type: tabulated, file: ...}), arrays in C, GLSL and WGSL, and charts. Kinds:\n"
              "  mie        spheres of one size or many            isotropic, hg, two_lobe, rayleigh, draine   closed forms\n"
              "  ice, snow  hexagonal prisms by geometric optics   a file: a table as scenes read it\n",
    .examples = "  nephos phase mie --sizes gamma --radius 10 --spread 0.1 -w 650 -w 515 -w 440 -o cloud.svg\n"
                "  nephos phase ice --length 100 --edge 50 -o ice.txt -o ice.png\n"
                "  nephos phase hg --g 0.88 --times 26 --plot polar -o hg.svg\n",
    .files_min = 1,
    .files_max = 1,
    .run = run,
};
