/* SPDX-License-Identifier: Apache-2.0
 *
 * nephos diagnose: which known mistake explains a picture; --show renders one. */
#include <string.h>

#include "altered/diagnosis.h"
#include "cli/command.h"
#include "core/message.h"
#include "scene/model.h"

typedef struct DiagnoseCommand {
    Session session;
    TextList knobs;
    const char *show, *output;
    int64_t spp, seed, frame, a_samples;
    double time_budget_s;
    int list, json, spp_given, seed_given;
} DiagnoseCommand;

/* Its random numbers are not those that anybody would choose for a picture to be judged. */
enum { SEED = 1936946035 };

static void add_options(OptionTable *table, DiagnoseCommand *diagnose) {
    option_add(table, (Option){.name = "spp", .letter = 'n', .kind = OPTION_INT, .target = &diagnose->spp, .value_name = "N",
                               .min = 16, .max = 1 << 20, .given = &diagnose->spp_given,
                               .meaning = "at most so many samples per pixel of each picture, rounded up to 16; default: twice A's, "
                                          "128 to 4096. With --show: how many"});
    option_add(table, (Option){.name = "time-budget", .kind = OPTION_NUMBER, .target = &diagnose->time_budget_s, .value_name = "S",
                               .min = 0, .max = 1e9, .meaning = "no more samples after S seconds"});
    option_add(table, (Option){.name = "a-samples", .kind = OPTION_INT, .target = &diagnose->a_samples, .value_name = "N", .min = 1,
                               .max = 1 << 30,
                               .meaning = "A has no error bars: take those of nephos with N samples per pixel. Default: from the "
                                          "scatter of neighbouring pixels"});
    option_add(table, (Option){.name = "seed", .letter = 's', .kind = OPTION_INT, .target = &diagnose->seed, .value_name = "N",
                               .min = 0, .max = 4294967295.0, .given = &diagnose->seed_given,
                               .meaning = "of the pictures that are rendered; must not be A's"});
    option_add(table, (Option){.name = "frame", .letter = 'f', .kind = OPTION_INT, .target = &diagnose->frame, .value_name = "F",
                               .min = 0, .max = 16777215.0, .meaning = "the scene as of that frame"});
    option_add(table, (Option){.name = "define", .letter = 'D', .kind = OPTION_LIST, .target = &diagnose->knobs, .value_name = "K=V",
                               .meaning = "turns a knob of method path, which renders"});
    option_add(table, (Option){.name = "json", .kind = OPTION_FLAG, .target = &diagnose->json, .meaning = "as JSON on standard output"});
    option_add(table, (Option){.name = "list", .kind = OPTION_FLAG, .target = &diagnose->list, .meaning = "the known bugs; no picture"});
    option_add(table, (Option){.name = "show", .kind = OPTION_TEXT, .target = &diagnose->show, .value_name = "BUG",
                               .meaning = "render SCENE with that bug (number or name) to OUT.exr, to see what it does"});
    option_add(table, (Option){.name = "output", .letter = 'o', .kind = OPTION_TEXT, .target = &diagnose->output,
                               .value_name = "OUT.exr", .meaning = "of --show"});
    session_add_options(table, &diagnose->session);
}

static NphStatus list(void) {
    for (int i = 1; i < CANDIDATES; i++) printf("  %2d  %-24s %s\n", known_bugs[i].number, known_bugs[i].name, known_bugs[i].what);
    return NPH_OK;
}

static void fill_render(const DiagnoseCommand *diagnose, NphRenderOptions *options) {
    nph_render_options_default(options);
    options->seed_given = diagnose->seed_given;
    options->seed = (uint32_t)diagnose->seed;
    options->frame = (uint32_t)diagnose->frame;
    options->knob_count = diagnose->knobs.count;
    options->knobs = diagnose->knobs.items;
}

static NphStatus write_film(Session *session, const NphFilm *film, const char *path) {
    NphImage image = {0};
    NPH_TRY(nph_film_image(session->context, film, &image));
    NphStatus status = nph_exr_write(session->context, path, &image);
    nph_image_free(session->context, &image);
    return status;
}

static NphStatus show(DiagnoseCommand *diagnose, const char *scene_path) {
    Session *session = &diagnose->session;
    const KnownBug *bug = known_bug_find(diagnose->show);
    NphRenderOptions options;
    NphScene *scene = NULL;
    NphFilm *film = NULL;
    int failed = 0;
    if (!bug) return usage_error("diagnose", "--show %s: there is no such bug; --list tells numbers and names", diagnose->show);
    if (!diagnose->output) return usage_error("diagnose", "--show: where to? -o OUT.exr");
    NPH_TRY(check_writable(session, diagnose->output));
    fill_render(diagnose, &options);
    options.samples = diagnose->spp;
    NPH_TRY(nph_scene_load_frame(session->context, scene_path, options.frame, &scene));
    NphStatus status = diagnose_render(session, scene_path, scene, bug->number, &options, &film, &failed);
    nph_scene_free(session->context, scene);
    if (status == NPH_OK) status = write_film(session, film, diagnose->output);
    nph_film_free(session->context, film);
    if (status == NPH_OK && !session->quiet)
        printf("%s\n%s (bug %d): %s%s\n", diagnose->output, bug->name, bug->number, bug->what,
               failed ? "; the numeric checks of the run fail with it" : "");
    return status;
}

/* ---- the picture ---- */

/* Samples per pixel that A says it has, 0: unknown. */
static double samples_of(const NphImage *a) {
    const NphChannel *channel = nph_image_channel(a, "N");
    const NphAttribute *attribute = nph_image_attribute(a, "samples");
    double most = attribute && attribute->type != NPH_ATTRIBUTE_STRING ? attribute->number : 0.0;
    for (int64_t i = 0; channel && i < (int64_t)a->width * a->height; i++)
        if ((double)channel->pixels[i] > most) most = (double)channel->pixels[i];
    return most;
}

/* A power of two from least to most that is no less than wanted. */
static int64_t power_of_two(double wanted, int64_t least, int64_t most) {
    int64_t power = least;
    while (power < most && (double)power < wanted) power *= 2;
    return power;
}

static void choose_samples(const DiagnoseCommand *diagnose, Diagnosis *diagnosis) {
    double samples = diagnose->a_samples ? (double)diagnose->a_samples : samples_of(&diagnosis->a);
    diagnosis->a_samples = samples;
    diagnosis->samples_least = power_of_two(samples, 64, 128);
    diagnosis->samples_most = samples > 0.0 ? power_of_two(2.0 * samples, 128, 4096) : 512;
    if (diagnose->spp_given) diagnosis->samples_most = (diagnose->spp + 15) / 16 * 16;
    if (diagnosis->samples_least > diagnosis->samples_most) diagnosis->samples_least = diagnosis->samples_most;
}

/* Equal seeds would compare a picture with its own noise. */
static void choose_seed(Diagnosis *diagnosis) {
    const NphAttribute *seed = nph_image_attribute(&diagnosis->a, "seed");
    char text[32];
    if (!diagnosis->render.seed_given) diagnosis->render.seed = SEED;
    diagnosis->render.seed_given = 1;
    snprintf(text, sizeof text, "%u", diagnosis->render.seed);
    if (seed && seed->type == NPH_ATTRIBUTE_STRING && strcmp(seed->text, text) == 0) diagnosis->render.seed++;
}

static NphStatus check_window(const Diagnosis *diagnosis, const char *picture) {
    const NphImage *a = &diagnosis->a;
    const NphSensor *sensor = &diagnosis->scene->sensor;
    if (a->full_width == sensor->width && a->full_height == sensor->height && a->x0 >= 0 && a->y0 >= 0 &&
        a->x0 + a->width <= sensor->width && a->y0 + a->height <= sensor->height)
        return NPH_OK;
    return nph_error(diagnosis->session->context, NPH_BAD_INPUT,
                     "%s holds %d x %d pixels from (%d, %d) of a picture of %d x %d; %s renders %d x %d", picture, a->width, a->height,
                     a->x0, a->y0, a->full_width, a->full_height, diagnosis->scene_path, sensor->width, sensor->height);
}

static NphStatus diagnose_picture(const DiagnoseCommand *diagnose, Diagnosis *diagnosis, const char *picture) {
    const NphImage *a = &diagnosis->a;
    NPH_TRY(check_window(diagnosis, picture));
    diagnosis->render.crop_given = 1;
    const int crop[4] = {a->x0, a->y0, a->x0 + a->width, a->y0 + a->height};
    memcpy(diagnosis->render.crop, crop, sizeof crop);
    choose_samples(diagnose, diagnosis);
    choose_seed(diagnosis);
    return diagnose_search(diagnosis);
}

/* Factors that this scene suggests: albedos, forgotten or taken once too often. */
static int constants_of(const NphScene *scene, NphConstant *constants, int room) {
    int count = 0;
    for (int i = 0; i < scene->medium_count + scene->surface_count && count + 2 <= room; i++) {
        int medium = i < scene->medium_count;
        const double *albedo = medium ? scene->media[i].albedo : scene->surfaces[i - scene->medium_count].albedo;
        const char *name = medium ? scene->media[i].name : scene->surfaces[i - scene->medium_count].name;
        if (!(albedo[0] > 0.0 && albedo[1] > 0.0 && albedo[2] > 0.0) || (albedo[0] == 1.0 && albedo[1] == 1.0 && albedo[2] == 1.0)) continue;
        for (int inverse = 0; inverse < 2; inverse++) {
            NphConstant *constant = &constants[count++];
            snprintf(constant->name, sizeof constant->name, "%sthe albedo of %.50s", inverse ? "1 / " : "", name);
            for (int c = 0; c < 3; c++) constant->value[c] = inverse ? 1.0 / albedo[c] : albedo[c];
        }
    }
    return count;
}

static NphStatus diagnose_file(DiagnoseCommand *diagnose, const char *picture, const char *scene_path) {
    NphContext *context = diagnose->session.context;
    NphConstant constants[32];
    Diagnosis diagnosis;
    memset(&diagnosis, 0, sizeof diagnosis);
    diagnosis.session = &diagnose->session;
    diagnosis.scene_path = scene_path;
    diagnosis.time_budget_s = diagnose->time_budget_s;
    diagnosis.fit = (NphFitOptions){.alpha = 1e-4, .a_samples = (double)diagnose->a_samples, .constants = constants};
    fill_render(diagnose, &diagnosis.render);
    NphStatus status = nph_exr_read(context, picture, &diagnosis.a);
    if (status == NPH_OK) status = nph_scene_load_frame(context, scene_path, diagnosis.render.frame, &diagnosis.scene);
    if (status == NPH_OK) {
        diagnosis.fit.constant_count = constants_of(diagnosis.scene, constants, (int)(sizeof constants / sizeof constants[0]));
        status = diagnose_picture(diagnose, &diagnosis, picture);
    }
    if (status == NPH_INTERRUPTED) nph_error(context, status, "interrupted: no verdict");
    if (status == NPH_OK && diagnose->json) diagnose_json(&diagnosis, picture);
    else if (status == NPH_OK && !diagnose->session.quiet) diagnose_text(&diagnosis, picture);
    for (int i = 0; i < CANDIDATES; i++) diagnose_drop(&diagnosis, &diagnosis.candidates[i]);
    nph_scene_free(context, diagnosis.scene);
    nph_image_free(context, &diagnosis.a);
    return status == NPH_OK && diagnosis.verdict != DIAGNOSED_RIGHT ? NPH_DIFFERENT : status;
}

static NphStatus run(const Command *command, int argc, char **argv) {
    DiagnoseCommand diagnose;
    OptionTable table = {0};
    TextList files = {0};
    NphStatus status = NPH_OK;
    memset(&diagnose, 0, sizeof diagnose);
    add_options(&table, &diagnose);
    if (!command_begin(command, &table, argc, argv, &files, &status)) return status;
    int expected = diagnose.list ? 0 : diagnose.show ? 1 : 2;
    if (files.count != expected)
        return usage_error(command->name, "%d files, expected %s", files.count,
                           diagnose.list ? "none with --list" : diagnose.show ? "SCENE with --show" : "a picture and its scene");
    if (diagnose.output && !diagnose.show) return usage_error(command->name, "-o goes with --show; the diagnosis itself is told");
    if (diagnose.list) return list();
    NPH_TRY(session_open(&diagnose.session, command->name));
    status = diagnose.show ? show(&diagnose, files.items[0]) : diagnose_file(&diagnose, files.items[0], files.items[1]);
    return session_close(&diagnose.session, status);
}

const Command command_diagnose = {
    .name = "diagnose",
    .arguments = "A.exr SCENE [options]",
    .summary = "which known mistake explains a picture",
    .before = "Renders SCENE as it is and with each of the known bugs of renderers, and names those that explain picture A\n"
              "within its error bars, the likeliest first; also factors, mirrored, turned or shifted pictures, exchanged\n"
              "channels and encodings. Exit status 0 means that A is right, 1 that it is not. docs/diagnose.md.\n",
    .examples = "  nephos diagnose mine.exr cloud.yaml\n"
                "  nephos diagnose mine.exr cloud.yaml --a-samples 256      mine.exr has no error bars\n"
                "  nephos diagnose --list\n"
                "  nephos diagnose --show one_over_4_pi cloud.yaml -o look.exr --spp 64\n",
    .files_min = 0,
    .files_max = 2,
    .run = run,
};
