/* SPDX-License-Identifier: Apache-2.0
 *
 * The command line itself: exit statuses, help, "did you mean", the man page. */
#include "cli/program.h"
#include "method/registry.h"

/* The last two are nephos-altered's, which a build need not have (-Dbugs=false). */
static const char *const commands[] = {"render", "plan",   "info",  "compare",  "merge",
                                       "bench",  "verify", "stage", "batch", "phase", "diagnose", "tolerance"};
enum { COMMANDS = sizeof commands / sizeof *commands, ALTERED = 2 };

/* How many of them this build runs. */
static int runnable(void) { return has_altered() ? COMMANDS : COMMANDS - ALTERED; }

START_TEST(the_version_names_vector_level_and_libraries) {
    const Ran *run = RUN("--version");
    ck_assert_int_eq(run->status, 0);
    ck_assert_int_eq(strncmp(run->out, "nephos ", 7), 0);
    ck_assert_ptr_nonnull(strstr(run->out, nph_version()));
    ck_assert(strstr(run->out, "base") || strstr(run->out, "avx2") || strstr(run->out, "avx512"));
    ck_assert_ptr_nonnull(strstr(run->out, "OpenEXR"));
}
END_TEST

START_TEST(help_lists_every_command_and_each_explains_itself_with_examples) {
    const Ran *run = RUN("--help");
    ck_assert_int_eq(run->status, 0);
    for (int i = 0, n = runnable(); i < n; i++) {
        char line[32];
        snprintf(line, sizeof line, "\n  %s ", commands[i]);
        ck_assert_msg(strstr(RUN("--help")->out, line) != NULL, "%s is not in --help", commands[i]);
        run = RUN(commands[i], "--help");
        ck_assert_int_eq(run->status, 0);
        ck_assert_str_eq(run->err, "");
        ck_assert_ptr_nonnull(strstr(run->out, "usage: nephos"));
        ck_assert_ptr_nonnull(strstr(run->out, "examples:\n  nephos "));
        ck_assert_ptr_nonnull(strstr(run->out, "--threads"));
        ck_assert_int_eq(RUN("help", commands[i])->status, 0);
    }
}
END_TEST

typedef struct Mistake {
    const char *words[8];
    const char *said; /* part of the message */
} Mistake;

START_TEST(every_mistake_on_the_command_line_is_named_and_exits_with_2) {
    static const Mistake mistakes[] = {
        {{NULL}, "no command"},
        {{"redner"}, "did you mean render?"},
        {{"xyzzy"}, "unknown command xyzzy"},
        {{"render"}, "too few files"},
        {{"render", "a.yaml"}, "-o OUT.exr"},
        {{"render", "a.yaml", "b.yaml", "-o", "c.exr"}, "what is 'b.yaml'?"},
        {{"render", "a.yaml", "-o"}, "needs a value"},
        {{"render", "a.yaml", "-o", "a.png"}, "name it *.exr"},
        {{"render", "a.yaml", "-o", "a.exr", "--part"}, "name it *.part"},
        {{"render", "a.yaml", "-o", "a.exr", "--sedd", "1"}, "did you mean --seed?"},
        {{"render", "a.yaml", "-o", "a.exr", "--spp", "0"}, "whole number from 1"},
        {{"render", "a.yaml", "-o", "a.exr", "--spp", "1.5"}, "whole number"},
        {{"render", "a.yaml", "-o", "a.exr", "--spp=16x"}, "whole number"},
        {{"render", "a.yaml", "-o", "a.exr", "--spp", "99999999999999999999"}, "whole number"},
        {{"render", "a.yaml", "-o", "a.exr", "--samples", "0:24"}, "multiples of 16"},
        {{"render", "a.yaml", "-o", "a.exr", "--samples", "32:16"}, "A < B"},
        {{"render", "a.yaml", "-o", "a.exr", "--samples", "16"}, "A:B"},
        {{"render", "a.yaml", "-o", "a.exr", "--samples=0:16", "--spp=16"}, "exclude each other"},
        {{"render", "a.yaml", "-o", "a.exr", "--samples=0:16", "--target-error=0.1"}, "exclude each other"},
        {{"render", "a.yaml", "-o", "a.exr", "--precision", "f16"}, "f32 or f64"},
        {{"render", "a.yaml", "-o", "a.exr", "--crop", "0,0,8"}, "X0,Y0,X1,Y1"},
        {{"render", "a.yaml", "-o", "a.exr", "--crop", "8,0,8,8"}, "X0 < X1"},
        {{"render", "a.yaml", "-o", "a.exr", "--plan", "half"}, "expected full"},
        {{"render", "a.yaml", "-o", "a.exr", "--target-error", "nan"}, "expected a number"},
        {{"render", "a.yaml", "-o", "a.exr", "--memory-limit", "2Q"}, "512M or 2G"},
        {{"render", "a.yaml", "-o", "a.exr", "--threads", "-1"}, "from 0 to 1024"},
        {{"render", "a.yaml", "-o", "a.exr", "--quiet=1"}, "takes no value"},
        {{"render", "a.yaml", "-o", "a.exr", "--png=a.jpg"}, "ends in .png"},
        {{"render", "a.yaml", "--only", "0,1,2"}, "FRAME,X,Y,SAMPLE"},
        {{"render", "a.yaml", "--only", "0,1,-2,0"}, "FRAME,X,Y,SAMPLE"},
        {{"plan"}, "which scene?"},
        {{"info"}, "too few files"},
        {{"info", "a", "b"}, "what is 'b'?"},
        {{"compare", "a.exr"}, "too few files"},
        {{"compare", "a.exr", "b.exr", "--alpha", "2"}, "from 1e-09 to 0.5"},
        {{"compare", "a.exr", "b.exr", "--flip", "sdr"}, "expected hdr or ldr"},
        {{"compare", "a.exr", "b.exr", "--exposure", "1:2"}, "START:STOP:COUNT"},
        {{"compare", "a.exr", "b.exr", "--exposure", "1:2:x"}, "START:STOP:COUNT"},
        {{"compare", "a.exr", "b.exr", "--exposure", "1:2:3:4"}, "START:STOP:COUNT"},
        {{"compare", "a.exr", "b.exr", "--exposure", "nan"}, "START:STOP:COUNT"},
        {{"compare", "a.exr", "b.exr", "--exposure", ""}, "START:STOP:COUNT"},
        {{"compare", "a.exr", "b.exr", "--exposure", "2:1:3"}, "START <= STOP"},
        {{"compare", "a.exr", "b.exr", "--exposure=-101"}, "within -100 to 100"},
        {{"compare", "a.exr", "b.exr", "--exposure", "1:2:0"}, "START <= STOP"},
        {{"compare", "a.exr", "b.exr", "--exposure", "1:2:1"}, "START <= STOP"},
        {{"compare", "a.exr", "b.exr", "--exposure", "1:2:4294967298"}, "2 to 512"},
        {{"compare", "a.exr", "b.exr", "--flip", "ldr", "--exposure", "1:2:3"}, "one number"},
        {{"compare", "a.exr", "b.exr", "--ppd", "0.5"}, "from 1 to 1000"},
        {{"compare", "a.exr", "b.exr", "--map", "look.jpg"}, "ends in .png"},
        {{"merge", "-o", "a.exr"}, "too few files"},
        {{"bench"}, "too few files"},
        {{"phase"}, "too few files"},
        {{"phase", "mei"}, "'mei' is no kind of phase function"},
        {{"phase", "mie"}, "needs --radius"},
        {{"phase", "mie", "--radius", "1", "--sizes", "gama"}, "expected single, lognormal"},
        {{"phase", "mie", "--radius", "1", "--sizes", "gamma"}, "needs --spread"},
        {{"phase", "mie", "--radius", "1", "--particle", "wine"}, "expected water, ice, soot"},
        {{"phase", "mie", "--radius", "1", "--wavelength", "5"}, "from 200 to 20000"},
        {{"phase", "hg"}, "needs --g"},
        {{"phase", "two_lobe", "--g", "0.5"}, "needs --g2"},
        {{"phase", "draine", "--g", "0.5"}, "needs --alpha"},
        {{"phase", "rayleigh", "-o", "a.jpg"}, "a chart in .svg or .png"},
        {{"phase", "rayleigh", "--plot", "bar"}, "linear, log or polar"},
        {{"phase", "rayleigh", "--rows", "1"}, "at least 2"},
    };
    char folder[] = "/tmp/nephos-cli-XXXXXX"; /* relative outputs land nowhere else */
    ck_assert_ptr_nonnull(mkdtemp(folder));
    ck_assert_int_eq(chdir(folder), 0);
    for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; i++) {
        const Ran *run = program_run(mistakes[i].words);
        ck_assert_msg(run->status == 2 && strstr(run->err, mistakes[i].said) && !*run->out,
                      "mistake %zu (%s): status %d\n%s%s", i, mistakes[i].said, run->status, run->err, run->out);
        ck_assert_ptr_nonnull(strstr(run->err, "--help"));
    }
    /* nothing was left behind */
    ck_assert_int_eq(rmdir(folder), 0);
}
END_TEST

START_TEST(an_unknown_vector_level_is_refused) {
    setenv("NEPHOS_ISA", "avx1024", 1);
    const Ran *run = RUN("info", program_path());
    ck_assert_int_eq(run->status, 2);
    ck_assert_ptr_nonnull(strstr(run->err, "avx2 or avx512"));
    ck_assert_int_eq(RUN("--version")->status, 2);
    setenv("NEPHOS_ISA", "base", 1);
    run = RUN("--version");
    ck_assert_int_eq(run->status, 0);
    ck_assert_ptr_nonnull(strstr(run->out, "vector level: base"));
}
END_TEST

/* Every "--name" of the options in a help text. */
static int next_option(const char **text, char name[40]) {
    for (const char *line = *text; line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL) {
        const char *dashes = line + 6;
        if (strncmp(line, "  ", 2) != 0 || strlen(line) < 8 || strncmp(dashes, "--", 2) != 0) continue;
        snprintf(name, 40, "%.*s", (int)strcspn(dashes, " \n"), dashes);
        *text = strchr(line, '\n');
        return 1;
    }
    return 0;
}

START_TEST(the_man_page_names_every_command_and_option) {
    static char page[PROGRAM_OUTPUT], plain[PROGRAM_OUTPUT];
    int options = 0;
    program_read(nph_test_path("man/nephos.1"), page);
    char *to = plain;
    for (const char *from = page; *from; from++)
        if (*from != '\\') *to++ = *from; /* roff writes \-\- */
    for (int i = 0; i < COMMANDS; i++) {
        char entry[64];
        snprintf(entry, sizeof entry, "nephos %s", commands[i]);
        ck_assert_msg(strstr(plain, entry) != NULL, "the man page lacks %s", entry);
    }
    for (int i = 0, n = runnable(); i < n; i++) {
        const char *help = RUN(commands[i], "--help")->out;
        char name[40];
        while (next_option(&help, name)) {
            options++;
            ck_assert_msg(strstr(plain, name) != NULL, "the man page lacks %s of %s", name, commands[i]);
        }
    }
    ck_assert_int_gt(options, 40);
}
END_TEST

START_TEST(help_and_man_page_name_every_method) {
    static char page[PROGRAM_OUTPUT];
    program_read(nph_test_path("man/nephos.1"), page);
    const char *names = RUN("render", "--help")->out;
    for (int m = 0; m < nph_method_count(); m++) {
        const char *name = nph_method(m)->name;
        ck_assert_msg(strstr(names, name) != NULL, "render --help lacks the method %s", name);
        ck_assert_msg(strstr(page, name) != NULL, "the man page lacks the method %s", name);
    }
}
END_TEST

static void fill(TCase *cases) {
    tcase_add_test(cases, the_version_names_vector_level_and_libraries);
    tcase_add_test(cases, help_lists_every_command_and_each_explains_itself_with_examples);
    tcase_add_test(cases, every_mistake_on_the_command_line_is_named_and_exits_with_2);
    tcase_add_test(cases, an_unknown_vector_level_is_refused);
    tcase_add_test(cases, the_man_page_names_every_command_and_option);
    tcase_add_test(cases, help_and_man_page_name_every_method);
}

int main(void) { return nph_test_main("cli_usage", fill); }
