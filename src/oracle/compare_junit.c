/* SPDX-License-Identifier: Apache-2.0
 *
 * A comparison as JUnit XML, the form that build servers read: https://github.com/testmoapp/junitxml. Verdicts in the
 * words of the text. */
#include <string.h>

#include "core/text.h"
#include "core/xml.h"
#include "oracle/compare_report.h"

typedef struct Xml {
    NphTextFn write;
    void *user;
} Xml;

static void put(const Xml *xml, const char *text) { xml->write(xml->user, text, strlen(text)); }

static void put_escaped(const Xml *xml, const char *text) { nph_xml_text(xml->write, xml->user, text); }

static void put_attribute(const Xml *xml, const char *name, const char *value) {
    put(xml, " ");
    put(xml, name);
    put(xml, "=\"");
    put_escaped(xml, value);
    put(xml, "\"");
}

static void put_property(const Xml *xml, const char *name, double value) {
    char text[NPH_DOUBLE_TEXT];
    put(xml, "      <property");
    put_attribute(xml, "name", name);
    put_attribute(xml, "value", nph_format_double(value, text));
    put(xml, "/>\n");
}

static void put_properties(const Xml *xml, NphReport report) {
    put(xml, "    <properties>\n");
    put_property(xml, "relative_bias", report.comparison->relative_bias);
    put_property(xml, "relative_rmse", report.comparison->relative_rmse);
    if (report.flip) put_property(xml, "flip_mean", report.flip->mean);
    if (report.flip && !report.flip->noise_unknown) put_property(xml, "flip_noise_mean", report.flip->noise_mean);
    put(xml, "    </properties>\n");
}

typedef struct Verdict {
    const char *suite, *name, *words;
    NphVerdict verdict;
} Verdict;

static void put_case(const Xml *xml, Verdict found) {
    put(xml, "    <testcase");
    put_attribute(xml, "classname", found.suite);
    put_attribute(xml, "name", found.name);
    if (found.verdict == NPH_SAME) {
        put(xml, "/>\n");
        return;
    }
    put(xml, ">\n      <failure");
    put_attribute(xml, "type", nph_verdict_name(found.verdict));
    put_attribute(xml, "message", found.words);
    put(xml, "/>\n    </testcase>\n");
}

static void put_counts(const Xml *xml, const NphComparison *comparison) {
    char text[NPH_DOUBLE_TEXT];
    int failures = comparison->verdict != NPH_SAME;
    for (int i = 0; i < comparison->level_count; i++) failures += comparison->levels[i].verdict != NPH_SAME;
    put_attribute(xml, "tests", nph_format_double(1.0 + comparison->level_count, text));
    put_attribute(xml, "failures", nph_format_double(failures, text));
    put_attribute(xml, "errors", "0");
}

static void put_line(void *user, const char *line) {
    put_escaped(user, line);
    put(user, "\n");
}

void nph_comparison_junit(NphReport report, const char *suite, NphTextFn write, void *user) {
    Xml xml = {write, user};
    const NphComparison *comparison = report.comparison;
    put(&xml, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite");
    put_attribute(&xml, "name", suite);
    put_counts(&xml, comparison);
    put(&xml, ">\n");
    put_properties(&xml, report);
    put_case(&xml, (Verdict){suite, "verdict", comparison->reason, comparison->verdict});
    for (int i = 0; i < comparison->level_count; i++) {
        char words[NPH_LEVEL_WORDS];
        const NphCompareLevel *level = &comparison->levels[i];
        put_case(&xml, (Verdict){suite, level->name, nph_level_words(level, words), level->verdict});
    }
    put(&xml, "    <system-out>\n");
    nph_comparison_text(report, put_line, &xml);
    put(&xml, "    </system-out>\n  </testsuite>\n</testsuites>\n");
}
