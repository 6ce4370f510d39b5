#include "neural/data/store_pack.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "neural/data/store_manifest.h"
#include "neural/data/store_read.h"

static enum pbnds_status add_hashes(cJSON *files, const char *folder,
                                    struct pbnds_error *error)
{
    struct pbnds_store_names names;
    PBNDS_TRY(pbnds_store_list(folder, &names, error));
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < names.count && status == PBNDS_OK; ++i) {
        if (strcmp(names.items[i], "sample.json") == 0) continue;
        struct pbnds_store_bytes bytes;
        status = pbnds_store_read(folder, names.items[i], &bytes, error);
        if (status != PBNDS_OK) break;
        pbnds_manifest_file(files, names.items[i], bytes.data, bytes.size);
        free(bytes.data);
    }
    pbnds_store_names_free(&names);
    return status;
}

enum pbnds_status pbnds_sample_seal(const char *folder, struct pbnds_error *error)
{
    struct pbnds_store_bytes bytes;
    PBNDS_TRY(pbnds_store_read(folder, "sample.json", &bytes, error));
    cJSON *json = cJSON_ParseWithLength((const char *)bytes.data, bytes.size);
    free(bytes.data);
    cJSON_DeleteItemFromObjectCaseSensitive(json, "files");
    cJSON *files = cJSON_AddObjectToObject(json, "files");
    enum pbnds_status status = PBNDS_OK;
    char *text = NULL;
    if (!files)
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", bytes.name);
    if (status == PBNDS_OK) status = add_hashes(files, folder, error);
    if (status == PBNDS_OK && !(text = cJSON_Print(json)))
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", bytes.name);
    if (status == PBNDS_OK)
        status = pbnds_file_write(bytes.name, text, strlen(text), error);
    free(text);
    cJSON_Delete(json);
    return status;
}

bool pbnds_sample_is_sound(const char *folder)
{
    struct pbnds_store_bytes bytes;
    if (pbnds_store_read(folder, "sample.json", &bytes, NULL) != PBNDS_OK) return false;
    cJSON *json = cJSON_ParseWithLength((const char *)bytes.data, bytes.size);
    free(bytes.data);
    const cJSON *said = cJSON_GetObjectItemCaseSensitive(json, "files");
    cJSON *found = cJSON_CreateObject();
    const bool sound = cJSON_IsObject(said) &&
                       add_hashes(found, folder, NULL) == PBNDS_OK &&
                       cJSON_Compare(said, found, true);
    cJSON_Delete(found);
    cJSON_Delete(json);
    return sound;
}

enum pbnds_status pbnds_pack_folder(struct pbnds_tar_writer *writer, const char *folder,
                                    int index, struct pbnds_error *error)
{
    struct pbnds_store_names names;
    PBNDS_TRY(pbnds_store_list(folder, &names, error));
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < names.count && status == PBNDS_OK; ++i) {
        char name[300];
        struct pbnds_store_bytes bytes;
        (void)snprintf(name, sizeof name, "%06d.%s", index, names.items[i]);
        status = pbnds_store_read(folder, names.items[i], &bytes, error);
        if (status != PBNDS_OK) break;
        status = pbnds_tar_writer_add(writer, name, bytes.data, bytes.size, error);
        free(bytes.data);
    }
    pbnds_store_names_free(&names);
    return status;
}

enum pbnds_status pbnds_pack_members(struct pbnds_tar_writer *writer, const char *tar,
                                     const struct pbnds_tar_index *members, int index,
                                     struct pbnds_error *error)
{
    char key[32];
    int count;
    (void)snprintf(key, sizeof key, "%06d", index);
    const int first = pbnds_tar_find_key(members, key, &count);
    for (int i = first; i < first + count; ++i) {
        uint8_t *bytes;
        size_t size;
        PBNDS_TRY(pbnds_tar_read(tar, &members->members[i], &bytes, &size, error));
        const enum pbnds_status status =
            pbnds_tar_writer_add(writer, members->members[i].name, bytes, size, error);
        free(bytes);
        PBNDS_TRY(status);
    }
    return PBNDS_OK;
}
