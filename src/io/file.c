/* SPDX-License-Identifier: Apache-2.0
 *
 * Whole files in, whole files out. The writer works on a temporary name beside its target: write, flush, fsync, close,
 * rename, fsync of the folder. Every one of these calls can report a full disk, so every one is checked; on failure the
 * temporary is removed and the target is as it was. */
#define _XOPEN_SOURCE 700 /* realpath */
#include "io/file.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/memory.h"
#include "core/message.h"

enum { REASON_BYTES = 128, NAME_ATTEMPTS = 1000, BLOCK_BYTES = 1 << 18 /* stays in a core's cache */ };

/* "PATH: DOING: the system's reason" */
static NphStatus fail(NphContext *context, NphStatus status, const char *path, const char *doing, int error) {
    char reason[REASON_BYTES];
    if (strerror_r(error, reason, sizeof reason) != 0) snprintf(reason, sizeof reason, "system error %d", error);
    return nph_error(context, status, "%s: %s: %s", path, doing, reason);
}

/* Opens what can be read whole; *descriptor is the caller's to close. */
static NphStatus open_regular(NphContext *context, const char *path, int *descriptor, size_t *size) {
    int opened = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK); /* a pipe must not block the open */
    if (opened < 0) return fail(context, NPH_BAD_INPUT, path, "cannot read", errno);
    struct stat facts;
    NphStatus status = NPH_OK;
    if (fstat(opened, &facts) != 0)
        status = fail(context, NPH_BAD_INPUT, path, "cannot read", errno);
    else if (S_ISDIR(facts.st_mode))
        status = nph_error(context, NPH_BAD_INPUT, "%s: is a folder; a file is needed", path);
    else if (!S_ISREG(facts.st_mode))
        status = nph_error(context, NPH_BAD_INPUT,
                           "%s: is not a regular file (but a pipe, device or socket); copy it to a file first", path);
    if (status != NPH_OK) {
        close(opened);
        return status;
    }
    *descriptor = opened;
    *size = (size_t)facts.st_size;
    return NPH_OK;
}

static NphStatus read_all(NphContext *context, const char *path, int descriptor, char *bytes, size_t size) {
    size_t done = 0;
    while (done < size) {
        ssize_t got = read(descriptor, bytes + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return fail(context, NPH_BAD_INPUT, path, "cannot read", errno);
        if (got == 0)
            return nph_error(context, NPH_BAD_INPUT, "%s: became shorter while it was read (%zu of %zu bytes)", path,
                             done, size);
        done += (size_t)got;
    }
    return NPH_OK;
}

NphStatus nph_file_read(NphContext *context, const char *path, char **bytes, size_t *size) {
    return nph_file_read_stretch(context, path, 0, SIZE_MAX - 1, bytes, size);
}

NphStatus nph_file_read_stretch(NphContext *context, const char *path, int64_t offset, size_t most, char **bytes, size_t *size) {
    int descriptor = -1;
    size_t expected = 0;
    char *buffer = NULL;
    NPH_TRY(open_regular(context, path, &descriptor, &expected));
    NphStatus status = NPH_OK;
    if (offset < 0 || (uint64_t)offset > expected)
        status = nph_error(context, NPH_BAD_INPUT, "%s: has %zu bytes, none at %lld", path, expected, (long long)offset);
    else if (offset > 0 && lseek(descriptor, (off_t)offset, SEEK_SET) < 0)
        status = fail(context, NPH_BAD_INPUT, path, "cannot read", errno);
    if (status == NPH_OK) {
        expected -= (size_t)offset;
        if (expected > most) expected = most;
        status = nph_alloc(context, expected + 1, 1, path, (void **)&buffer);
    }
    if (status == NPH_OK) status = read_all(context, path, descriptor, buffer, expected);
    close(descriptor);
    if (status != NPH_OK) {
        nph_free(context, buffer);
        return status;
    }
    *bytes = buffer;
    *size = expected;
    return NPH_OK;
}

NphStatus nph_file_read_start(NphContext *context, const char *path, char *bytes, size_t room, size_t *size) {
    int descriptor = -1;
    size_t expected = 0;
    NPH_TRY(open_regular(context, path, &descriptor, &expected));
    if (expected > room) expected = room;
    NphStatus status = read_all(context, path, descriptor, bytes, expected);
    close(descriptor);
    if (status == NPH_OK) *size = expected;
    return status;
}

/* The file that a symbolic link stands for, so that the link stays; refuses what a rename would destroy (/dev/null). */
static NphStatus resolve_target(NphContext *context, const char *path, char **resolved) {
    struct stat facts;
    char followed[PATH_MAX];
    if (lstat(path, &facts) != 0) {
        if (errno == ENOENT) return nph_strdup(context, path, resolved); /* open says what is missing, if anything */
        return fail(context, NPH_BAD_OUTPUT, path, "cannot write", errno);
    }
    if (S_ISLNK(facts.st_mode)) {
        if (!realpath(path, followed) || stat(followed, &facts) != 0)
            return fail(context, NPH_BAD_OUTPUT, path, "cannot write through this symbolic link", errno);
        path = followed;
    }
    if (S_ISDIR(facts.st_mode)) return nph_error(context, NPH_BAD_OUTPUT, "%s: cannot write: is a folder", path);
    if (!S_ISREG(facts.st_mode))
        return nph_error(context, NPH_BAD_OUTPUT,
                         "%s: cannot write: is not a regular file (but a pipe, device or socket)", path);
    return nph_strdup(context, path, resolved);
}

/* Six letters from the process id and the attempt; O_EXCL decides, so they need not be unguessable. */
static void name_temporary(const char *path, size_t bytes, unsigned attempt, char *name) {
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz234567";
    char random[7] = "";
    uint32_t word = ((uint32_t)getpid() * 1000u + attempt) * 2654435761u;
    for (int i = 0; i < 6; i++) random[i] = letters[word >> (5 * i) & 31];
    snprintf(name, bytes, "%s.%s.tmp", path, random);
}

static NphStatus open_temporary(NphContext *context, NphWriter *writer) {
    assert(writer->path); /* for the static analyser, which cannot see that nph_error hands its status on */
    size_t bytes = strlen(writer->path) + sizeof ".XXXXXX.tmp";
    NPH_TRY(NPH_NEW(context, bytes, "file name", &writer->temporary));
    int descriptor = -1;
    for (unsigned attempt = 0; attempt < NAME_ATTEMPTS; attempt++) {
        name_temporary(writer->path, bytes, attempt, writer->temporary);
        descriptor = open(writer->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor >= 0 || errno != EEXIST) break;
    }
    if (descriptor < 0) return fail(context, NPH_BAD_OUTPUT, writer->path, "cannot write a file in its folder", errno);
    writer->stream = fdopen(descriptor, "w+b");
    if (writer->stream) return NPH_OK;
    int error = errno;
    close(descriptor);
    unlink(writer->temporary);
    return fail(context, NPH_BAD_OUTPUT, writer->path, "cannot write", error);
}

static void forget(NphContext *context, NphWriter *writer) {
    nph_free(context, writer->path);
    nph_free(context, writer->temporary);
    memset(writer, 0, sizeof *writer);
}

NphStatus nph_writer_open(NphContext *context, const char *path, NphWriter *writer) {
    NphWriter made = {0};
    NPH_TRY(resolve_target(context, path, &made.path));
    NphStatus status = open_temporary(context, &made);
    if (status != NPH_OK) {
        forget(context, &made);
        return status;
    }
    *writer = made;
    return NPH_OK;
}

/* stdio keeps the fact, not the reason, of an earlier failed write: two more writes to the doomed file show it (the
 * first may just fill the last page). */
static int reason_of_failed_write(FILE *stream) {
    static const char zeros[8192];
    int descriptor = fileno(stream);
    if (lseek(descriptor, 0, SEEK_END) < 0) return errno;
    for (int i = 0; i < 2; i++)
        if (write(descriptor, zeros, sizeof zeros) < 0) return errno;
    return EIO;
}

/* Everything before the rename; 0 or the error number. */
static int finish_stream(FILE *stream, int sync) {
    int error = fflush(stream) != 0 ? errno : 0;
    if (!error && ferror(stream)) error = reason_of_failed_write(stream);
    if (!error && sync && fsync(fileno(stream)) != 0) error = errno;
    if (fclose(stream) != 0 && !error) error = errno;
    return error;
}

/* Makes the rename last; folders that cannot be opened or synced (rights, some network file systems) are let be. */
static int sync_folder(const char *path, char *scratch) {
    const char *slash = strrchr(path, '/');
    size_t length = slash == path ? 1 : slash ? (size_t)(slash - path) : 1;
    memcpy(scratch, slash ? path : ".", length);
    scratch[length] = 0;
    int descriptor = open(scratch, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return 0;
    int error = fsync(descriptor) != 0 && errno != EINVAL ? errno : 0;
    close(descriptor);
    return error;
}

static NphStatus commit(NphContext *context, NphWriter *writer, int sync) {
    const char *doing = "cannot write";
    int error = finish_stream(writer->stream, sync);
    writer->stream = NULL;
    if (!error && rename(writer->temporary, writer->path) != 0) {
        error = errno;
        doing = "cannot rename the written file to it";
    }
    NphStatus status = NPH_OK;
    if (error) {
        unlink(writer->temporary);
        status = fail(context, NPH_BAD_OUTPUT, writer->path, doing, error);
    } else if (sync && (error = sync_folder(writer->path, writer->temporary)) != 0) {
        status = fail(context, NPH_BAD_OUTPUT, writer->path, "written, but its folder cannot be synced", error);
    }
    forget(context, writer);
    return status;
}

NphStatus nph_writer_commit(NphContext *context, NphWriter *writer) { return commit(context, writer, 1); }

NphStatus nph_writer_commit_unsynced(NphContext *context, NphWriter *writer) { return commit(context, writer, 0); }

void nph_writer_abandon(NphContext *context, NphWriter *writer) {
    if (writer->stream) fclose(writer->stream);
    if (writer->temporary) unlink(writer->temporary);
    forget(context, writer);
}

NphStatus nph_appender_open(NphContext *context, int file, const char *path, NphAppender *appender) {
    NphAppender made = {.file = file, .path = path};
    NPH_TRY(NPH_NEW(context, BLOCK_BYTES, path, &made.block));
    *appender = made;
    return NPH_OK;
}

/* All of them, however often the system takes only a part. */
static NphStatus write_all(NphContext *context, const NphAppender *appender, const char *bytes, size_t count) {
    while (count > 0) {
        ssize_t written = write(appender->file, bytes, count);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return fail(context, NPH_BAD_OUTPUT, appender->path, "cannot be written", errno);
        bytes += written;
        count -= (size_t)written;
    }
    return NPH_OK;
}

NphStatus nph_appender_flush(NphContext *context, NphAppender *appender) {
    size_t count = appender->used;
    appender->used = 0;
    return write_all(context, appender, appender->block, count);
}

NphStatus nph_appender_add(NphContext *context, NphAppender *appender, const void *bytes, size_t count) {
    const char *from = bytes;
    while (count > 0) {
        size_t whole = appender->used ? 0 : count / BLOCK_BYTES * BLOCK_BYTES, room = BLOCK_BYTES - appender->used;
        size_t part = whole ? whole : count < room ? count : room;
        if (whole) NPH_TRY(write_all(context, appender, from, whole));
        else memcpy(appender->block + appender->used, from, part);
        if (!whole) appender->used += part;
        if (appender->used == BLOCK_BYTES) NPH_TRY(nph_appender_flush(context, appender));
        from += part;
        count -= part;
    }
    return NPH_OK;
}

void nph_appender_close(NphContext *context, NphAppender *appender) {
    nph_free(context, appender->block);
    memset(appender, 0, sizeof *appender);
}
