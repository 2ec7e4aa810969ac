/* SPDX-License-Identifier: Apache-2.0
 *
 * See session.h. */
#include "cli/session.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "core/cpu.h"
#include "core/message.h"
#include "io/file.h"

/* A signal handler reaches the context through nothing but a global; the program has one context. */
static NphContext *volatile interruptible;

static void restore_signals(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = SIG_DFL;
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

static void stop_gently(int number) {
    (void)number;
    restore_signals();
    if (interruptible) nph_interrupt(interruptible);
}

/* A signal that the caller ignores (nohup, background jobs) stays ignored. */
static void catch_signal(int number) {
    struct sigaction action, before;
    memset(&action, 0, sizeof action);
    action.sa_handler = stop_gently;
    action.sa_flags = SA_RESTART;
    if (sigaction(number, NULL, &before) == 0 && before.sa_handler == SIG_IGN) return;
    sigaction(number, &action, NULL);
}

static void on_message(void *user, NphMessageLevel level, const char *text) {
    Session *session = user;
    if (!session->mute) progress_message(&session->progress, level, text);
}

static void on_progress(void *user, const char *task, double done, double total, double seconds_left) {
    progress_show(&((Session *)user)->progress, task, done, total, seconds_left);
}

void session_add_options(OptionTable *table, Session *session) {
    option_add(table, (Option){.name = "threads", .letter = 't', .kind = OPTION_INT, .target = &session->threads,
                               .value_name = "N", .min = 0, .max = 1024,
                               .meaning = "threads to use; 0, the default, is all that affinity and cgroup allow. "
                                          "The picture does not depend on it"});
    option_add(table, (Option){.name = "memory-limit", .kind = OPTION_BYTES, .target = &session->memory_limit_bytes,
                               .value_name = "BYTES", .meaning = "refuse up front (exit 6) what takes more, such as 2G"});
    option_add(table, (Option){.name = "quiet", .letter = 'q', .kind = OPTION_FLAG, .target = &session->quiet,
                               .meaning = "no progress and no summary; errors and warnings are still told"});
}

NphStatus session_open(Session *session, const char *command) {
    NphSettings settings;
    NphIsa level = NPH_ISA_BASE;
    const char *word = getenv("NEPHOS_ISA");
    if (word && !nph_isa_parse(word, &level))
        return usage_error(command, "environment variable NEPHOS_ISA=%s: expected base, avx2 or avx512", word);
    nph_settings_default(&settings);
    settings.threads = (int)session->threads;
    settings.memory_limit_bytes = session->memory_limit_bytes;
    settings.message = on_message;
    settings.progress = on_progress;
    settings.user = session;
    progress_open(&session->progress, session->quiet);
    NphStatus status = nph_context_open(&session->context, &settings);
    if (status != NPH_OK) {
        progress_close(&session->progress);
        fprintf(stderr, "nephos: error: no context: %s\n", nph_status_name(status));
        return status;
    }
    interruptible = session->context;
    catch_signal(SIGINT);
    catch_signal(SIGTERM);
    return NPH_OK;
}

NphStatus session_close(Session *session, NphStatus status) {
    restore_signals();
    interruptible = NULL;
    progress_close(&session->progress);
    nph_context_close(session->context);
    session->context = NULL;
    return status;
}

NphStatus check_writable(Session *session, const char *path) {
    NphWriter writer = {0};
    NPH_TRY(nph_writer_open(session->context, path, &writer));
    nph_writer_abandon(session->context, &writer);
    return NPH_OK;
}
