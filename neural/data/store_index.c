#include "neural/data/store_index.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BLOCK = 512, EXTENDED_MAX = 1 << 16, NAME_MAX_BYTES = 4096 };

static const uint64_t member_max = (uint64_t)1 << 32;

/* A file being walked from header to header. */
struct walk {
    const char *path;
    int fd;
    uint64_t size, at;
    bool ended; /* two blocks of zeros, or one, where the file ends */
    struct pbnds_tar_member member;
};

static enum pbnds_status open_walk(struct walk *w, const char *path, uint64_t at,
                                   struct pbnds_error *error)
{
    *w = (struct walk){.path = path, .at = at};
    struct stat info;
    w->fd = open(path, O_RDONLY | O_CLOEXEC);
    if (w->fd < 0) {
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be opened: %s", path,
                          strerror(errno));
    }
    if (fstat(w->fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        (void)close(w->fd);
        return pbnds_fail(error, PBNDS_ERROR_IO, "%s: is not a file", path);
    }
    w->size = (uint64_t)info.st_size;
    return PBNDS_OK;
}

static enum pbnds_status read_at(int fd, const char *path, uint64_t offset, void *data,
                                 size_t size, struct pbnds_error *error)
{
    for (size_t done = 0; done < size;) {
        const ssize_t n =
            pread(fd, (char *)data + done, size - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) {
            return pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be read: %s", path,
                              strerror(errno));
        }
        if (n == 0) {
            return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is cut short", path);
        }
        done += (size_t)n;
    }
    return PBNDS_OK;
}

/* Octal digits, or the base-256 of GNU with the top bit set. */
static bool parse_number(const uint8_t *field, size_t size, uint64_t *value)
{
    uint64_t v = 0;
    if (field[0] & 0x80u) {
        v = field[0] & 0x7fu;
        for (size_t i = 1; i < size; ++i) {
            if (v >> 55) return false;
            v = v << 8 | field[i];
        }
        *value = v;
        return true;
    }
    size_t i = 0;
    while (i < size && field[i] == ' ')
        ++i;
    for (; i < size && field[i] >= '0' && field[i] <= '7'; ++i)
        v = v << 3 | (uint64_t)(field[i] - '0'); /* 12 digits: 36 bits */
    *value = v;
    return i == size || field[i] == 0 || field[i] == ' ';
}

static bool sum_holds(const uint8_t *h)
{
    uint64_t wanted = 0, sum = 0;
    for (int i = 0; i < BLOCK; ++i)
        sum += i >= 148 && i < 156 ? (uint8_t)' ' : h[i];
    return parse_number(h + 148, 8, &wanted) && wanted == sum;
}

static bool is_zero(const uint8_t *block)
{
    for (int i = 0; i < BLOCK; ++i) {
        if (block[i]) return false;
    }
    return true;
}

/* prefix/name of a ustar header. */
static void header_name(const uint8_t *h, char name[NAME_MAX_BYTES])
{
    size_t n = 0;
    if (memcmp(h + 257, "ustar", 5) == 0 && h[263] == '0') { /* GNU has other fields */
        for (size_t i = 0; i < 155 && h[345 + i]; ++i)
            name[n++] = (char)h[345 + i];
        if (n > 0) name[n++] = '/';
    }
    for (size_t i = 0; i < 100 && h[i]; ++i)
        name[n++] = (char)h[i];
    name[n] = 0;
}

/* What extended headers say of the member that follows. */
struct extended {
    char name[NAME_MAX_BYTES];
    bool named, sized;
    uint64_t size;
};

/* Records "LENGTH KEY=VALUE\n". */
static bool parse_pax(const char *text, size_t size, struct extended *x)
{
    for (size_t at = 0; at < size;) {
        size_t length = 0, i = at;
        for (; i < size && text[i] >= '0' && text[i] <= '9'; ++i) {
            length = 10 * length + (size_t)(text[i] - '0');
            if (length > size) return false;
        }
        if (i == at || i >= size || text[i] != ' ') return false;
        if (length <= i + 1 - at || length > size - at) return false;
        const char *key = text + i + 1, *end = text + at + length - 1;
        if (*end != '\n') return false;
        const char *value = memchr(key, '=', (size_t)(end - key));
        if (!value) return false;
        const size_t key_size = (size_t)(value - key);
        const size_t value_size = (size_t)(end - ++value);
        if (key_size == 4 && memcmp(key, "path", 4) == 0) {
            if (value_size >= sizeof x->name) return false;
            memcpy(x->name, value, value_size);
            x->name[value_size] = 0;
            x->named = true;
        } else if (key_size == 4 && memcmp(key, "size", 4) == 0) {
            if (value_size < 1 || value_size > 18) return false;
            x->size = 0;
            for (size_t k = 0; k < value_size; ++k) {
                if (value[k] < '0' || value[k] > '9') return false;
                x->size = 10 * x->size + (uint64_t)(value[k] - '0');
            }
            x->sized = true;
        }
        at += length;
    }
    return true;
}

static enum pbnds_status fail_damaged(const struct walk *w, uint64_t at,
                                      struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: is not a sound tar file (at byte %llu); remove it to have "
                      "its samples made again",
                      w->path, (unsigned long long)at);
}

static enum pbnds_status read_extended(struct walk *w, char type, uint64_t size,
                                       struct extended *x, struct pbnds_error *error)
{
    if (size > EXTENDED_MAX) return fail_damaged(w, w->at, error);
    char *text = malloc((size_t)size + 1);
    if (!text) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", w->path);
    enum pbnds_status status =
        read_at(w->fd, w->path, w->at + BLOCK, text, (size_t)size, error);
    text[size] = 0;
    if (status == PBNDS_OK && type == 'x' && !parse_pax(text, (size_t)size, x))
        status = fail_damaged(w, w->at, error);
    if (status == PBNDS_OK && type == 'L') {
        const size_t length = strlen(text);
        if (length < sizeof x->name) {
            memcpy(x->name, text, length + 1);
            x->named = true;
        } else {
            status = fail_damaged(w, w->at, error);
        }
    }
    free(text);
    return status;
}

/* One header at w->at; what follows its data is the next. Sets `regular` where it was one
 * of a member that we keep. */
static enum pbnds_status read_header(struct walk *w, const uint8_t *h,
                                     struct extended *x, uint64_t first, bool *regular,
                                     struct pbnds_error *error)
{
    uint64_t size = 0;
    if (!sum_holds(h) || !parse_number(h + 124, 12, &size))
        return fail_damaged(w, w->at, error);
    const char type = (char)h[156];
    const bool file = type == '0' || type == 0 || type == '7';
    const bool extends = type == 'x' || type == 'L' || type == 'g' || type == 'K';
    if (!extends && x->sized) size = x->size;
    if (!file && !extends && type != 'S' && type >= '1' && type <= '6') size = 0;
    if (size > w->size || w->at + BLOCK > w->size - size)
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is cut short", w->path);
    if (extends) PBNDS_TRY(read_extended(w, type, size, x, error));
    if (file) {
        char name[NAME_MAX_BYTES];
        header_name(h, name);
        const char *chosen = x->named ? x->name : name;
        if (strncmp(chosen, "./", 2) == 0) chosen += 2;
        *regular = chosen[0] && strlen(chosen) < sizeof w->member.name;
        if (*regular) {
            strcpy(w->member.name, chosen);
            w->member.header = first;
            w->member.offset = w->at + BLOCK;
            w->member.size = size;
        }
    }
    if (!extends) *x = (struct extended){.named = false};
    w->at += BLOCK + (size + BLOCK - 1) / BLOCK * BLOCK;
    return PBNDS_OK;
}

/* To the next regular member, or to the end. */
static enum pbnds_status step(struct walk *w, struct pbnds_error *error)
{
    struct extended x = {.named = false};
    uint64_t first = w->at;
    bool regular = false;
    while (!regular) {
        uint8_t block[BLOCK];
        if (w->size < BLOCK || w->at > w->size - BLOCK)
            return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is cut short", w->path);
        PBNDS_TRY(read_at(w->fd, w->path, w->at, block, BLOCK, error));
        if (is_zero(block)) {
            w->ended = true;
            return PBNDS_OK;
        }
        if (!x.named && !x.sized) first = w->at;
        PBNDS_TRY(read_header(w, block, &x, first, &regular, error));
    }
    return PBNDS_OK;
}

static bool append(struct pbnds_tar_index *index, const struct pbnds_tar_member *member)
{
    const unsigned count = (unsigned)index->count;
    if ((count & (count - 1u)) == 0) { /* a power of two: grow */
        const size_t capacity = count ? 2u * (size_t)count : 1u;
        if (count >= 1u << 30) return false;
        struct pbnds_tar_member *grown =
            realloc(index->members, capacity * sizeof *grown);
        if (!grown) return false;
        index->members = grown;
    }
    index->members[index->count++] = *member;
    return true;
}

static int by_name(const void *a, const void *b)
{
    const struct pbnds_tar_member *x = a, *y = b;
    const int order = strcmp(x->name, y->name);
    return order ? order : x->header < y->header ? -1 : x->header > y->header;
}

enum pbnds_status pbnds_tar_index_read(const char *path, struct pbnds_tar_index *index,
                                       struct pbnds_error *error)
{
    *index = (struct pbnds_tar_index){0};
    struct walk w;
    PBNDS_TRY(open_walk(&w, path, 0, error));
    enum pbnds_status status = step(&w, error);
    while (status == PBNDS_OK && !w.ended) {
        if (!append(index, &w.member)) {
            status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its list",
                                path);
        } else {
            status = step(&w, error);
        }
    }
    (void)close(w.fd);
    if (status != PBNDS_OK) {
        pbnds_tar_index_free(index);
    } else if (index->count > 0) {
        qsort(index->members, (size_t)index->count, sizeof *index->members, by_name);
    }
    return status;
}

void pbnds_tar_index_free(struct pbnds_tar_index *index)
{
    free(index->members);
    *index = (struct pbnds_tar_index){0};
}

/* Place of the first member whose name is not less. */
static int lower_bound(const struct pbnds_tar_index *index, const char *name)
{
    int lo = 0, hi = index->count;
    while (lo < hi) {
        const int middle = lo + (hi - lo) / 2;
        if (strcmp(index->members[middle].name, name) < 0) {
            lo = middle + 1;
        } else {
            hi = middle;
        }
    }
    return lo;
}

const struct pbnds_tar_member *pbnds_tar_find(const struct pbnds_tar_index *index,
                                              const char *name)
{
    const int at = lower_bound(index, name);
    const bool found = at < index->count && strcmp(index->members[at].name, name) == 0;
    return found ? &index->members[at] : NULL;
}

int pbnds_tar_find_key(const struct pbnds_tar_index *index, const char *key, int *count)
{
    char prefix[sizeof index->members->name];
    const int length = snprintf(prefix, sizeof prefix, "%s.", key);
    *count = 0;
    if (length >= (int)sizeof prefix) return 0;
    const int first = lower_bound(index, prefix);
    while (first + *count < index->count &&
           strncmp(index->members[first + *count].name, prefix, (size_t)length) == 0) {
        ++*count;
    }
    return first;
}

enum pbnds_status pbnds_tar_read(const char *path,
                                 const struct pbnds_tar_member *member, uint8_t **bytes,
                                 size_t *size, struct pbnds_error *error)
{
    *bytes = NULL;
    *size = 0;
    struct walk w;
    PBNDS_TRY(open_walk(&w, path, 0, error));
    enum pbnds_status status = PBNDS_OK;
    uint8_t *data = NULL;
    if (member->size > w.size || member->offset > w.size - member->size) {
        status = pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is cut short", path);
    } else if (member->size > member_max ||
               !(data = malloc((size_t)member->size + 1))) {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for %s of it",
                            path, member->name);
    } else {
        status = read_at(w.fd, path, member->offset, data, (size_t)member->size, error);
    }
    (void)close(w.fd);
    if (status != PBNDS_OK) {
        free(data);
        return status;
    }
    data[member->size] = 0;
    *bytes = data;
    *size = (size_t)member->size;
    return PBNDS_OK;
}

/* The members of one sample are neighbours: its hint saves the way there. */
static bool find_near(const char *path, uint64_t hint, const char *name,
                      struct pbnds_tar_member *member)
{
    struct walk w;
    const size_t key = strcspn(name, ".");
    bool found = false;
    if (open_walk(&w, path, hint, NULL) != PBNDS_OK) return false;
    while (!found && step(&w, NULL) == PBNDS_OK && !w.ended &&
           strncmp(w.member.name, name, key + 1) == 0) {
        found = strcmp(w.member.name, name) == 0;
    }
    (void)close(w.fd);
    if (found) *member = w.member;
    return found;
}

enum pbnds_status pbnds_tar_locate(const char *path, uint64_t hint, const char *name,
                                   struct pbnds_tar_member *member,
                                   struct pbnds_error *error)
{
    if (find_near(path, hint, name, member)) return PBNDS_OK;
    struct pbnds_tar_index index;
    PBNDS_TRY(pbnds_tar_index_read(path, &index, error));
    const struct pbnds_tar_member *at = pbnds_tar_find(&index, name);
    if (at) *member = *at;
    pbnds_tar_index_free(&index);
    if (at) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: has no member %s", path, name);
}
