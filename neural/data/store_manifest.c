#include "neural/data/store_manifest.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "neural/data/store_read.h"

#define JSON_BYTES_MAX ((size_t)1 << 31)

/* One line a sample. */
struct lines {
    FILE *file;
    char *text;
    size_t size;
    int count;
};

struct pbnds_manifest {
    char dataset[17]; /* hash of dataset.json */
    struct lines samples, quarantined;
};

static bool open_lines(struct lines *lines)
{
    lines->file = open_memstream(&lines->text, &lines->size);
    return lines->file != NULL;
}

static void close_lines(struct lines *lines)
{
    if (lines->file) (void)fclose(lines->file);
    free(lines->text);
}

void pbnds_manifest_free(struct pbnds_manifest *manifest)
{
    if (!manifest) return;
    close_lines(&manifest->samples);
    close_lines(&manifest->quarantined);
    free(manifest);
}

enum pbnds_status pbnds_manifest_begin(const char *dir,
                                       struct pbnds_manifest **manifest,
                                       struct pbnds_error *error)
{
    *manifest = NULL;
    struct pbnds_store_bytes claim;
    PBNDS_TRY(pbnds_store_read(dir, "dataset.json", &claim, error));
    struct pbnds_manifest *m = calloc(1, sizeof *m);
    if (m) pbnds_store_hash(claim.data, claim.size, m->dataset);
    free(claim.data);
    if (!m || !open_lines(&m->samples) || !open_lines(&m->quarantined)) {
        pbnds_manifest_free(m);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its manifest",
                          dir);
    }
    *manifest = m;
    return PBNDS_OK;
}

void pbnds_manifest_file(cJSON *files, const char *name, const void *bytes, size_t size)
{
    char hash[17];
    pbnds_store_hash(bytes, size, hash);
    cJSON *item = cJSON_AddObjectToObject(files, name);
    cJSON_AddNumberToObject(item, "bytes", (double)size);
    cJSON_AddStringToObject(item, "xxh64", hash);
}

/* Takes `item` over. */
static bool add_line(struct lines *lines, cJSON *item)
{
    char *text = cJSON_PrintUnformatted(item);
    cJSON_Delete(item);
    const bool ok =
        text && fprintf(lines->file, "%s\n%s", lines->count++ > 0 ? "," : "", text) > 0;
    cJSON_free(text);
    return ok;
}

/* A sample.json without hashes: those of its files. */
static enum pbnds_status hash_files(cJSON *files, const char *path,
                                    struct pbnds_error *error)
{
    struct pbnds_store_names names;
    PBNDS_TRY(pbnds_store_files(path, &names, error));
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < names.count && status == PBNDS_OK; ++i) {
        struct pbnds_store_bytes bytes;
        if (strcmp(names.items[i], "sample.json") == 0) continue;
        status = pbnds_store_read(path, names.items[i], &bytes, error);
        if (status != PBNDS_OK) break;
        pbnds_manifest_file(files, names.items[i], bytes.data, bytes.size);
        free(bytes.data);
    }
    pbnds_store_names_free(&names);
    return status;
}

enum pbnds_status pbnds_manifest_sample(struct pbnds_manifest *manifest,
                                        enum pbnds_split split, int index,
                                        const char *path, struct pbnds_error *error)
{
    struct pbnds_store_bytes bytes;
    PBNDS_TRY(pbnds_store_read(path, "sample.json", &bytes, error));
    cJSON *json = cJSON_ParseWithLength((const char *)bytes.data, bytes.size);
    cJSON *files = cJSON_DetachItemFromObjectCaseSensitive(json, "files");
    enum pbnds_status status = PBNDS_OK;
    if (!json) {
        status = pbnds_fail(error, PBNDS_ERROR_FORMAT,
                            "%s: is not JSON; remove the sample to have it made again",
                            bytes.name);
    } else if (!cJSON_IsObject(files)) {
        cJSON_Delete(files);
        files = cJSON_CreateObject();
        status = hash_files(files, path, error);
    }
    if (status == PBNDS_OK) {
        pbnds_manifest_file(files, "sample.json", bytes.data, bytes.size);
        cJSON *item = cJSON_CreateObject();
        cJSON_AddStringToObject(item, "split", pbnds_split_name(split));
        cJSON_AddNumberToObject(item, "index", index);
        (void)cJSON_AddItemToObject(item, "files", files);
        files = NULL;
        if (!add_line(&manifest->samples, item))
            status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", bytes.name);
    }
    cJSON_Delete(files);
    cJSON_Delete(json);
    free(bytes.data);
    return status;
}

enum pbnds_status pbnds_manifest_quarantined(struct pbnds_manifest *manifest,
                                             const char *path,
                                             struct pbnds_error *error)
{
    uint8_t *text;
    size_t size;
    PBNDS_TRY(pbnds_file_read(path, (size_t)1 << 20, &text, &size, error));
    cJSON *json = cJSON_ParseWithLength((const char *)text, size);
    free(text);
    if (!json) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: is not JSON; remove it to have its sample made", path);
    }
    if (add_line(&manifest->quarantined, json)) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
}

static bool holds(const char *path, const char *text, size_t size)
{
    uint8_t *old;
    size_t old_size;
    if (pbnds_file_read(path, JSON_BYTES_MAX, &old, &old_size, NULL) != PBNDS_OK)
        return false;
    const bool same = size == old_size && memcmp(old, text, size) == 0;
    free(old);
    return same;
}

enum pbnds_status pbnds_manifest_write(struct pbnds_manifest *manifest, const char *dir,
                                       struct pbnds_error *error)
{
    struct lines body = {0}, all = {0};
    char path[PBNDS_STORE_PATH_MAX], hash[17];
    (void)snprintf(path, sizeof path, "%s/manifest.json", dir);
    bool ok = fflush(manifest->samples.file) == 0 &&
              fflush(manifest->quarantined.file) == 0 && open_lines(&body) &&
              open_lines(&all);
    if (ok) {
        ok = fprintf(body.file,
                     "\"dataset\": \"%s\",\n\"samples\": [%s],\n\"quarantined\": "
                     "[%s]}\n",
                     manifest->dataset, manifest->samples.text,
                     manifest->quarantined.text) > 0 &&
             fflush(body.file) == 0;
    }
    if (ok) {
        pbnds_store_hash(body.text, body.size, hash);
        ok = fprintf(all.file, "{\"hash\": \"%s\",\n%s", hash, body.text) > 0 &&
             fflush(all.file) == 0;
    }
    enum pbnds_status status = PBNDS_OK;
    if (!ok) {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    } else if (!holds(path, all.text, all.size)) {
        status = pbnds_file_write(path, all.text, all.size, error);
        /* where there are no locks, another process may have been faster */
        if (status != PBNDS_OK && holds(path, all.text, all.size)) status = PBNDS_OK;
    }
    close_lines(&body);
    close_lines(&all);
    return status;
}

enum pbnds_status pbnds_manifest_read(const char *dir, cJSON **json,
                                      struct pbnds_error *error)
{
    char path[PBNDS_STORE_PATH_MAX], hash[17];
    uint8_t *bytes;
    size_t size;
    *json = NULL;
    (void)snprintf(path, sizeof path, "%s/manifest.json", dir);
    PBNDS_TRY(pbnds_file_read(path, JSON_BYTES_MAX, &bytes, &size, error));
    const char *body = memchr(bytes, '\n', size);
    if (body) {
        ++body;
        pbnds_store_hash(body, size - (size_t)(body - (const char *)bytes), hash);
        *json = cJSON_ParseWithLength((const char *)bytes, size);
    }
    free(bytes);
    const cJSON *said = cJSON_GetObjectItemCaseSensitive(*json, "hash");
    if (cJSON_IsString(said) && strcmp(said->valuestring, hash) == 0) return PBNDS_OK;
    cJSON_Delete(*json);
    *json = NULL;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: was changed, or is damaged: it is not what its hash says",
                      path);
}
