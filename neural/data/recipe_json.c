/* Recipe files: JSON in, JSON out. A key that is not known is refused, since a typing
 * error would silently make another data set. */
#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "neural/data/recipe.h"

#define RECIPE_BYTES_MAX ((size_t)1 << 24)

enum kind { INTEGER, REAL, SEED, FLAG };

/* One number of the recipe: where it stands in the file, and in the struct. */
struct field {
    const char *section; /* NULL: at the top */
    const char *name;
    enum kind kind;
    size_t offset;
    double min, max;
};

#define AT(member) offsetof(struct pbnds_dataset_recipe, member)

static const struct field FIELDS[] = {
    {NULL, "world_share", REAL, AT(world_share), 0, 1},
    {NULL, "world_seed", SEED, AT(world_seed), 0, 0},
    {NULL, "sky_share", REAL, AT(sky_share), 0, 1},
    {NULL, "spp", INTEGER, AT(spp), 1, 1 << 20},
    {NULL, "seed", SEED, AT(seed), 0, 0},
    {NULL, "per_tar", INTEGER, AT(per_tar), 1, 1000000},
    {"materials", "randomize", REAL, AT(randomize_materials), 0, 1},
    {"materials", "swap_textures", REAL, AT(swap_textures), 0, 1},
    {"lights", "mix", REAL, AT(mix_lights), 0, 1},
    {"lights", "hard", REAL, AT(hard_lights), 0, 1},
    {"lights", "dark", REAL, AT(dark_lights), 0, 1},
    {"targets", "variance", FLAG, AT(variance), 0, 1},
    {"targets", "ao", FLAG, AT(ao), 0, 1},
    {"targets", "olat", INTEGER, AT(olat), 0, 32},
    {"targets", "olat_spp", INTEGER, AT(olat_spp), 0, 1 << 20},
    {"targets", "denoise", FLAG, AT(denoise), 0, 1},
};
enum { FIELD_COUNT = sizeof FIELDS / sizeof FIELDS[0] };

/* Exact in a double, as JSON's numbers are. */
#define SEED_MAX 9007199254740991.0

struct reader {
    const char *path;
    struct pbnds_dataset_recipe *recipe;
    struct pbnds_error *error;
};

static enum pbnds_status bad(const struct reader *in, const char *section,
                             const char *name, const char *wanted)
{
    return pbnds_fail(in->error, PBNDS_ERROR_FORMAT, "%s: %s%s%s is not %s", in->path,
                      section ? section : "", section ? "." : "",
                      name ? name : "an item", wanted);
}

static enum pbnds_status read_field(const struct reader *in, const struct field *f,
                                    const cJSON *item)
{
    char wanted[80];
    void *to = (char *)in->recipe + f->offset;
    if (f->kind == FLAG) {
        if (!cJSON_IsBool(item)) return bad(in, f->section, f->name, "true or false");
        *(bool *)to = cJSON_IsTrue(item) != 0;
        return PBNDS_OK;
    }
    const double max = f->kind == SEED ? SEED_MAX : f->max, x = item->valuedouble;
    const bool whole = f->kind == REAL || x == floor(x);
    if (!cJSON_IsNumber(item) || !(x >= f->min && x <= max) || !whole) {
        (void)snprintf(wanted, sizeof wanted, "a%s number from %g to %.17g",
                       f->kind == REAL ? "" : " whole", f->min, max);
        return bad(in, f->section, f->name, wanted);
    }
    switch (f->kind) {
    case INTEGER:
        *(int *)to = (int)x;
        break;
    case SEED:
        *(uint64_t *)to = (uint64_t)x;
        break;
    default:
        *(double *)to = x;
    }
    return PBNDS_OK;
}

static const struct field *find_field(const char *section, const char *name)
{
    for (int i = 0; i < FIELD_COUNT; ++i) {
        const struct field *f = &FIELDS[i];
        const bool same =
            section ? f->section && strcmp(f->section, section) == 0 : !f->section;
        if (same && strcmp(f->name, name) == 0) return f;
    }
    return NULL;
}

/* {"train": 10, "val": 2} */
static enum pbnds_status read_counts(const struct reader *in, const cJSON *item,
                                     int *to)
{
    if (!cJSON_IsObject(item)) {
        return bad(in, NULL, item->string, "an object of train, val and test");
    }
    const cJSON *child;
    cJSON_ArrayForEach(child, item)
    {
        int split = 0;
        while (split < PBNDS_SPLIT_COUNT &&
               strcmp(child->string, pbnds_split_name((enum pbnds_split)split)) != 0)
            ++split;
        if (split == PBNDS_SPLIT_COUNT)
            return bad(in, item->string, child->string, "train, val or test");
        const double x = child->valuedouble;
        if (!cJSON_IsNumber(child) || !(x >= 0 && x <= 1e6) || x != floor(x)) {
            return bad(in, item->string, child->string,
                       "a whole number from 0 to 1000000");
        }
        to[split] = (int)x;
    }
    return PBNDS_OK;
}

/* "a/b" below the root, unless it is absolute. */
static char *join(const char *root, const char *path)
{
    const size_t size = strlen(root) + strlen(path) + 2;
    char *joined = malloc(size);
    if (!joined) return NULL;
    const bool whole = path[0] == '/' || root[0] == 0;
    (void)snprintf(joined, size, "%s%s%s", whole ? "" : root, whole ? "" : "/", path);
    return joined;
}

/* ["folder", {"path": "folder", "share": 0.2}] */
static enum pbnds_status read_sources(const struct reader *in, const char *root,
                                      const cJSON *item,
                                      struct pbnds_dataset_source **sources, int *count)
{
    if (!cJSON_IsArray(item))
        return bad(in, NULL, item->string, "a list of paths or {path, share}");
    *sources = calloc((size_t)cJSON_GetArraySize(item) + 1, sizeof **sources);
    if (!*sources)
        return pbnds_fail(in->error, PBNDS_ERROR_MEMORY, "%s: no memory", in->path);
    const cJSON *child;
    cJSON_ArrayForEach(child, item)
    {
        const cJSON *path = child, *share = NULL;
        if (cJSON_IsObject(child)) {
            path = cJSON_GetObjectItemCaseSensitive(child, "path");
            share = cJSON_GetObjectItemCaseSensitive(child, "share");
            if (cJSON_GetArraySize(child) != (path ? 1 : 0) + (share ? 1 : 0))
                return bad(in, item->string, NULL, "a path or {path, share}");
        }
        const bool right =
            cJSON_IsString(path) && path->valuestring[0] &&
            (!share || (cJSON_IsNumber(share) && share->valuedouble >= 0.0 &&
                        share->valuedouble <= 1.0));
        if (!right) {
            return bad(in, item->string, NULL,
                       "a path or {path, share} with a share from 0 to 1");
        }
        struct pbnds_dataset_source *s = &(*sources)[*count];
        s->path = join(root, path->valuestring);
        if (!s->path)
            return pbnds_fail(in->error, PBNDS_ERROR_MEMORY, "%s: no memory", in->path);
        s->share = share ? share->valuedouble : 0.0;
        ++*count;
    }
    return PBNDS_OK;
}

static enum pbnds_status read_size(const struct reader *in, const cJSON *item)
{
    const cJSON *w = cJSON_GetArrayItem(item, 0), *h = cJSON_GetArrayItem(item, 1);
    if (!cJSON_IsArray(item) || cJSON_GetArraySize(item) != 2 || !cJSON_IsNumber(w) ||
        !cJSON_IsNumber(h) || !(w->valuedouble >= 8 && w->valuedouble <= 16384) ||
        !(h->valuedouble >= 8 && h->valuedouble <= 16384)) {
        return bad(in, NULL, item->string, "[width, height], 8 to 16384 pixels");
    }
    in->recipe->width = (int)w->valuedouble;
    in->recipe->height = (int)h->valuedouble;
    return PBNDS_OK;
}

static enum pbnds_status read_format(const struct reader *in, const cJSON *item)
{
    const char *name = cJSON_GetStringValue(item);
    if (name && strcmp(name, "folders") == 0) {
        in->recipe->format = PBNDS_DATASET_FOLDERS;
    } else if (name && strcmp(name, "tar") == 0) {
        in->recipe->format = PBNDS_DATASET_TAR;
    } else {
        return bad(in, NULL, item->string, "\"folders\" or \"tar\"");
    }
    return PBNDS_OK;
}

static enum pbnds_status read_section(const struct reader *in, const cJSON *item)
{
    if (!cJSON_IsObject(item)) return bad(in, NULL, item->string, "an object");
    const cJSON *child;
    cJSON_ArrayForEach(child, item)
    {
        const struct field *f = find_field(item->string, child->string);
        if (!f) return bad(in, item->string, child->string, "a key of a recipe");
        PBNDS_TRY(read_field(in, f, child));
    }
    return PBNDS_OK;
}

static enum pbnds_status read_item(const struct reader *in, const char *root,
                                   const cJSON *item)
{
    struct pbnds_dataset_recipe *r = in->recipe;
    const char *key = item->string;
    const struct field *f = find_field(NULL, key);
    if (f) return read_field(in, f, item);
    if (strcmp(key, "scenes") == 0 && !r->scenes)
        return read_sources(in, root, item, &r->scenes, &r->scene_count);
    if (strcmp(key, "envs") == 0 && !r->envs)
        return read_sources(in, root, item, &r->envs, &r->env_count);
    if (strcmp(key, "worlds") == 0) return read_counts(in, item, r->worlds);
    if (strcmp(key, "skies") == 0) return read_counts(in, item, r->skies);
    if (strcmp(key, "count") == 0) return read_counts(in, item, r->count);
    if (strcmp(key, "size") == 0) return read_size(in, item);
    if (strcmp(key, "format") == 0) return read_format(in, item);
    for (int i = 0; i < FIELD_COUNT; ++i) {
        if (FIELDS[i].section && strcmp(FIELDS[i].section, key) == 0)
            return read_section(in, item);
    }
    if (strcmp(key, "about") == 0 && cJSON_IsString(item)) return PBNDS_OK;
    return bad(in, NULL, key, "a key of a recipe, or is there twice");
}

enum pbnds_status pbnds_dataset_recipe_parse(const char *text, size_t size,
                                             const char *name, const char *root,
                                             struct pbnds_dataset_recipe *recipe,
                                             struct pbnds_error *error)
{
    pbnds_dataset_recipe_init(recipe);
    const struct reader in = {name, recipe, error};
    cJSON *json = cJSON_ParseWithLength(text, size);
    enum pbnds_status status = PBNDS_OK;
    if (!cJSON_IsObject(json)) {
        status =
            pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not a JSON object", name);
    } else {
        const cJSON *item;
        cJSON_ArrayForEach(item, json)
        {
            if (status == PBNDS_OK) status = read_item(&in, root, item);
        }
    }
    cJSON_Delete(json);
    if (status != PBNDS_OK) pbnds_dataset_recipe_free(recipe);
    return status;
}

enum pbnds_status pbnds_dataset_recipe_load(const char *path, const char *root,
                                            struct pbnds_dataset_recipe *recipe,
                                            struct pbnds_error *error)
{
    uint8_t *bytes;
    size_t size;
    *recipe = (struct pbnds_dataset_recipe){0};
    PBNDS_TRY(pbnds_file_read(path, RECIPE_BYTES_MAX, &bytes, &size, error));
    const enum pbnds_status status = pbnds_dataset_recipe_parse(
        (const char *)bytes, size, path, root, recipe, error);
    free(bytes);
    return status;
}

static void free_sources(struct pbnds_dataset_source *sources, int count)
{
    for (int i = 0; i < count; ++i)
        free(sources[i].path);
    free(sources);
}

void pbnds_dataset_recipe_free(struct pbnds_dataset_recipe *recipe)
{
    free_sources(recipe->scenes, recipe->scene_count);
    free_sources(recipe->envs, recipe->env_count);
    *recipe = (struct pbnds_dataset_recipe){0};
}

static void add_counts(cJSON *json, const char *name, const int *counts)
{
    cJSON *object = cJSON_AddObjectToObject(json, name);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        cJSON_AddNumberToObject(object, pbnds_split_name((enum pbnds_split)s),
                                counts[s]);
    }
}

static void add_field(const struct pbnds_dataset_recipe *recipe, const struct field *f,
                      cJSON *to)
{
    const void *from = (const char *)recipe + f->offset;
    switch (f->kind) {
    case INTEGER:
        cJSON_AddNumberToObject(to, f->name, *(const int *)from);
        break;
    case REAL:
        cJSON_AddNumberToObject(to, f->name, *(const double *)from);
        break;
    case SEED: {
        /* cJSON prints 15 digits where it thinks that they will do. */
        char digits[24];
        (void)snprintf(digits, sizeof digits, "%" PRIu64, *(const uint64_t *)from);
        cJSON_AddRawToObject(to, f->name, digits);
        break;
    }
    case FLAG:
        cJSON_AddBoolToObject(to, f->name, *(const bool *)from);
        break;
    }
}

void pbnds_dataset_recipe_describe(const struct pbnds_dataset_recipe *recipe,
                                   cJSON *json)
{
    add_counts(json, "worlds", recipe->worlds);
    add_counts(json, "skies", recipe->skies);
    cJSON *size = cJSON_AddArrayToObject(json, "size");
    cJSON_AddItemToArray(size, cJSON_CreateNumber(recipe->width));
    cJSON_AddItemToArray(size, cJSON_CreateNumber(recipe->height));
    cJSON_AddStringToObject(json, "format",
                            recipe->format == PBNDS_DATASET_TAR ? "tar" : "folders");
    for (int i = 0; i < FIELD_COUNT; ++i) {
        const struct field *f = &FIELDS[i];
        cJSON *to = json;
        if (f->section) {
            to = cJSON_GetObjectItemCaseSensitive(json, f->section);
            if (!to) to = cJSON_AddObjectToObject(json, f->section);
        }
        add_field(recipe, f, to);
    }
}
