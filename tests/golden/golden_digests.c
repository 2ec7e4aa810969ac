/* SPDX-License-Identifier: Apache-2.0
 *
 * Writes reference/golden/digests anew (scripts/golden_digests): rows whose digest is as before keep the release since when it
 * holds. Says what has moved, and which lines CHANGELOG.md must have. */
#include <stdio.h>
#include <string.h>

#include "core/memory.h"
#include "core/message.h"
#include "io/file.h"
#include "pinned.h"

static void tell(void *user, NphMessageLevel level, const char *text) {
    (void)user;
    if (level == NPH_MESSAGE_ERROR) fprintf(stderr, "%s\n", text);
}

/* Since when the digest holds, and the last release with another. A digest of a release that moves has that of the newest release
 * before it; one that was never released is replaced. */
static void date_row(const char *changelog, const PinnedRow *old, PinnedRow *now) {
    int released = 0;
    snprintf(now->since, sizeof now->since, "%s", nph_version());
    now->before[0] = 0;
    if (!old) return;
    if (strcmp(old->row.digest, now->row.digest) == 0 || (changelog_section(changelog, old->since, &released) && !released)) {
        snprintf(now->since, sizeof now->since, "%s", old->since);
        snprintf(now->before, sizeof now->before, "%s", old->before);
        return;
    }
    changelog_newest(changelog, now->before);
}

static void say_moved(const char *changelog, const char *scene, const PinnedRow *old, const PinnedRow *now) {
    char text[1024];
    if (old && strcmp(old->row.digest, now->row.digest) == 0) return;
    if (!old) {
        printf("%s %s %s %s: new\n", scene, now->method, now->row.stage, now->row.buffer);
        return;
    }
    pinned_difference(old, now, text, sizeof text);
    printf("%s %s\n", scene, text);
    if (!changelog_tells(changelog, now))
        printf("    CHANGELOG.md, %s, must say: - Other digests: %s of %s; the last release with the old ones is %s.\n", now->since,
               now->row.stage, now->method, now->before);
}

static NphStatus renew(NphContext *context, const char *root, const char *changelog, const char *scene) {
    Pinned old = {0}, now;
    NPH_TRY(pinned_take(context, root, scene, &now));
    if (pinned_read(context, root, scene, &old) != NPH_OK) old = (Pinned){0}; /* a new scene */
    for (int r = 0; r < now.count; r++) {
        const PinnedRow *before = pinned_find(&old, &now.rows[r]);
        date_row(changelog, before, &now.rows[r]);
        say_moved(changelog, scene, before, &now.rows[r]);
    }
    NphStatus status = pinned_write(context, root, scene, &now);
    nph_free(context, old.rows);
    nph_free(context, now.rows);
    return status;
}

static NphStatus renew_all(NphContext *context, const char *root) {
    char names[PINNED_SCENES][DIGEST_NAME], path[1024], *changelog = NULL;
    size_t size;
    int released = 0;
    snprintf(path, sizeof path, "%s/CHANGELOG.md", root);
    NPH_TRY(nph_file_read(context, path, &changelog, &size));
    NphStatus status = NPH_OK;
    if (!changelog_section(changelog, nph_version(), &released) || released)
        status = nph_error(context, NPH_BAD_USAGE, "CHANGELOG.md: %s has no section that is not released yet: raise the version first",
                           nph_version());
    int count = pinned_scenes(root, names);
    for (int s = 0; s < count && status == NPH_OK; s++) status = renew(context, root, changelog, names[s]);
    nph_free(context, changelog);
    return status;
}

int main(int count, char **arguments) {
    NphContext *context = NULL;
    NphSettings settings;
    if (count != 2) {
        fprintf(stderr, "usage: golden_digests SOURCE_ROOT\n");
        return 2;
    }
    nph_settings_default(&settings);
    settings.message = tell;
    NphStatus status = nph_context_open(&context, &settings);
    if (status == NPH_OK) status = renew_all(context, arguments[1]);
    nph_context_close(context);
    return status == NPH_OK ? 0 : 1;
}
