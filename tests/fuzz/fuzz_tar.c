/* libFuzzer target: any bytes as a tar file of samples: its index, every member, and the
 * way to a sample from a hint that is wrong. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "neural/data/store_index.h"
#include "neural/data/store_read.h"
#include "tests/fuzz/scratch.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What the index promises: names in order, and bytes that are in the file. */
static void check_members(const char *path, const struct pbnds_tar_index *index,
                          const uint8_t *data, size_t size)
{
    for (int i = 0; i < index->count; ++i) {
        const struct pbnds_tar_member *m = &index->members[i];
        uint8_t *bytes;
        size_t read;
        if (i > 0 && strcmp(index->members[i - 1].name, m->name) > 0) abort();
        if (m->size > size || m->offset > size - m->size) abort();
        if (m->header >= m->offset) abort();
        if (!pbnds_tar_find(index, m->name)) abort();
        if (i > 32) continue; /* opens the file each time */
        if (pbnds_tar_read(path, m, &bytes, &read, NULL) != PBNDS_OK) abort();
        if (read != m->size || memcmp(bytes, data + m->offset, read) != 0) abort();
        free(bytes);
    }
}

static void find_sample(const char *path, const uint8_t *data, size_t size)
{
    uint64_t hint = 0;
    memcpy(&hint, data, size < sizeof hint ? size : sizeof hint);
    char sample[128];
    struct pbnds_store_bytes bytes;
    struct pbnds_store_names names;
    (void)snprintf(sample, sizeof sample, "%s#000001@%llu", path,
                   (unsigned long long)hint);
    if (pbnds_store_read(sample, "sample.json", &bytes, NULL) == PBNDS_OK)
        free(bytes.data);
    if (pbnds_store_files(sample, &names, NULL) == PBNDS_OK)
        pbnds_store_names_free(&names);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[64];
    struct pbnds_tar_index index;
    struct pbnds_error error;
    if (!scratch_write(path, sizeof path, ".tar", data, size)) return 0;
    if (pbnds_tar_index_read(path, &index, &error) == PBNDS_OK) {
        check_members(path, &index, data, size);
        pbnds_tar_index_free(&index);
    }
    find_sample(path, data, size);
    (void)unlink(path);
    return 0;
}
