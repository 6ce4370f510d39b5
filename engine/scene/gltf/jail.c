#include "engine/scene/gltf/jail.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A pipe opens without a writer, a terminal does not become ours. */
enum { READ_FILE = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC };
enum { READ_FOLDER = O_RDONLY | O_DIRECTORY | O_CLOEXEC };

/** RFC 3986, 4.2: a relative reference has no colon in its first segment. */
static bool has_scheme(const char *path)
{
    return memchr(path, ':', strcspn(path, "/")) != NULL;
}

static bool is_inside(const char *path)
{
    /* Backslashes separate nothing here, but would on a machine that shares the file. */
    if (path[0] == '/' || strchr(path, '\\')) return false;
    for (const char *p = path; *p;) {
        const size_t part = strcspn(p, "/");
        if (part == 2 && p[0] == '.' && p[1] == '.') return false;
        p += part;
        while (*p == '/')
            ++p;
    }
    return true;
}

static char *join(const char *folder, const char *path)
{
    const size_t size = strlen(folder) + strlen(path) + 2;
    char *out = malloc(size);
    if (out) (void)snprintf(out, size, "%s/%s", folder, path);
    return out;
}

/** Opens a name that has no slash, in an open folder, if it is a regular file now and
 * when it has been opened. */
static enum pbnds_jail open_regular(int folder, const char *name, int flags, int *fd)
{
    struct stat info;
    const int links = flags & O_NOFOLLOW ? AT_SYMLINK_NOFOLLOW : 0;
    if (fstatat(folder, name, &info, links) != 0) return PBNDS_JAIL_MISSING;
    if (S_ISLNK(info.st_mode)) return PBNDS_JAIL_OUTSIDE;
    if (!S_ISREG(info.st_mode)) return PBNDS_JAIL_SPECIAL;
    const int opened = openat(folder, name, flags);
    if (opened < 0) {
        return errno == ELOOP ? PBNDS_JAIL_OUTSIDE : PBNDS_JAIL_MISSING;
    }
    if (fstat(opened, &info) != 0 || !S_ISREG(info.st_mode)) {
        (void)close(opened);
        return PBNDS_JAIL_SPECIAL;
    }
    *fd = opened;
    return PBNDS_JAIL_OPEN;
}

/** Walks down a path that holds no link and no .. (or did, when it was resolved). */
static enum pbnds_jail walk(const char *folder, char *path, int *fd)
{
    int at = open(folder, READ_FOLDER);
    char *name = path;
    for (char *slash = strchr(name, '/'); at >= 0 && slash; slash = strchr(name, '/')) {
        *slash = 0;
        const int next = openat(at, name, READ_FOLDER | O_NOFOLLOW);
        (void)close(at);
        at = next;
        name = slash + 1;
    }
    if (at < 0) {
        return errno == ELOOP || errno == ENOTDIR ? PBNDS_JAIL_OUTSIDE
                                                  : PBNDS_JAIL_MISSING;
    }
    const enum pbnds_jail result = open_regular(at, name, READ_FILE | O_NOFOLLOW, fd);
    (void)close(at);
    return result;
}

/** `root` and `real` are resolved: what is left of `real` below `root`, or NULL. */
static char *below(const char *root, char *real)
{
    const size_t length = strcmp(root, "/") == 0 ? 0 : strlen(root);
    if (strncmp(real, root, length) != 0 || real[length] != '/') return NULL;
    return real[length + 1] ? real + length + 1 : NULL;
}

static enum pbnds_jail open_below(const char *folder, const char *path, int *fd)
{
    char *joined = join(folder, path);
    char *root = realpath(folder, NULL);
    char *real = joined ? realpath(joined, NULL) : NULL;
    enum pbnds_jail result = PBNDS_JAIL_MISSING;
    if (root && real && strcmp(root, real) == 0) {
        result = PBNDS_JAIL_SPECIAL; /* "." */
    } else if (root && real) {
        char *rest = below(root, real);
        result = rest ? walk(root, rest, fd) : PBNDS_JAIL_OUTSIDE;
    }
    free(joined);
    free(root);
    free(real);
    return result;
}

enum pbnds_jail pbnds_jail_open(const char *folder, const char *path, size_t length,
                                bool external, int *fd)
{
    *fd = -1;
    if (length == 0 || strlen(path) != length || has_scheme(path)) {
        return PBNDS_JAIL_SCHEME;
    }
    if (!external) {
        return is_inside(path) ? open_below(folder, path, fd) : PBNDS_JAIL_OUTSIDE;
    }
    if (path[0] == '/') return open_regular(AT_FDCWD, path, READ_FILE, fd);
    char *joined = join(folder, path);
    const enum pbnds_jail result =
        joined ? open_regular(AT_FDCWD, joined, READ_FILE, fd) : PBNDS_JAIL_MISSING;
    free(joined);
    return result;
}
