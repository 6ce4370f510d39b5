#include "engine/shade/cryptomatte.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t rotate(uint32_t x, int by)
{
    return x << by | x >> (32 - by);
}

/* One word of the key, scrambled. */
static uint32_t scramble(uint32_t k)
{
    return rotate(k * 0xcc9e2d51u, 15) * 0x1b873593u;
}

uint32_t pbnds_murmur3_32(const void *bytes, size_t size, uint32_t seed)
{
    const uint8_t *at = bytes;
    uint32_t h = seed, k = 0;
    size_t left = size;
    for (; left >= 4; left -= 4, at += 4) {
        k = (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 |
            (uint32_t)at[3] << 24;
        h = rotate(h ^ scramble(k), 13) * 5u + 0xe6546b64u;
    }
    k = 0;
    for (size_t i = left; i > 0; --i)
        k = k << 8 | at[i - 1];
    h ^= scramble(k); /* of no bytes is 0 */
    h ^= (uint32_t)size;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

uint32_t pbnds_cryptomatte_id(const char *name)
{
    const uint32_t hash = pbnds_murmur3_32(name, strlen(name), 0);
    uint32_t exponent = hash >> 23 & 0xffu;
    if (exponent < 1u) exponent = 1u;
    if (exponent > 254u) exponent = 254u;
    return (hash & 0x807fffffu) | exponent << 23;
}

void pbnds_cryptomatte_object_name(const struct pbnds_scene *scene,
                                   const struct pbnds_mesh *mesh, char out[64])
{
    const uint32_t i = mesh->object_id;
    const char *name = scene->objects && i < (uint32_t)scene->object_count
                           ? scene->objects[i].name
                           : "";
    if (name[0]) {
        snprintf(out, 64, "%.63s", name);
    } else {
        snprintf(out, 64, "node_%lu", (unsigned long)i);
    }
}

void pbnds_cryptomatte_material_name(const struct pbnds_scene *scene,
                                     const struct pbnds_mesh *mesh, char out[64])
{
    const char *name = scene->materials[mesh->material].name;
    if (name[0]) {
        snprintf(out, 64, "%.63s", name);
    } else {
        snprintf(out, 64, "material_%d", mesh->material);
    }
}

enum pbnds_status pbnds_cryptomatte_create(int width, int height,
                                           struct pbnds_cryptomatte **cryptomatte,
                                           struct pbnds_error *error)
{
    const size_t planes =
        (size_t)2 * PBNDS_CRYPTOMATTE_LAYERS * PBNDS_CRYPTOMATTE_RANKS;
    const size_t count = (size_t)width * (size_t)height;
    struct pbnds_cryptomatte *c = calloc(1, sizeof *c);
    if (c && count <= SIZE_MAX / planes / sizeof(float))
        c->storage = calloc(count * planes, sizeof(float));
    *cryptomatte = c;
    if (!c || !c->storage) {
        pbnds_cryptomatte_free(c);
        *cryptomatte = NULL;
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "Cryptomatte of %d x %d pixels does not fit into memory; use "
                          "a smaller size",
                          width, height);
    }
    static const char *const names[] = {"CryptoObject", "CryptoMaterial"};
    c->width = width;
    c->height = height;
    float *at = c->storage;
    for (int l = 0; l < PBNDS_CRYPTOMATTE_LAYERS; ++l) {
        snprintf(c->layers[l].name, sizeof c->layers[l].name, "%s", names[l]);
        for (int r = 0; r < PBNDS_CRYPTOMATTE_RANKS; ++r) {
            c->layers[l].id[r] = at;
            c->layers[l].share[r] = at + count;
            at += 2 * count;
        }
    }
    return PBNDS_OK;
}

void pbnds_cryptomatte_free(struct pbnds_cryptomatte *cryptomatte)
{
    if (!cryptomatte) return;
    for (int l = 0; l < PBNDS_CRYPTOMATTE_LAYERS; ++l)
        free(cryptomatte->layers[l].manifest);
    free(cryptomatte->storage);
    free(cryptomatte);
}

/* Manifests. */

typedef void (*name_of)(const struct pbnds_scene *, const struct pbnds_mesh *, char *);

struct text {
    char *data;
    size_t used;
};

static void put(struct text *t, const char *bytes)
{
    const size_t n = strlen(bytes);
    memcpy(t->data + t->used, bytes, n + 1);
    t->used += n;
}

/* A JSON string takes at most six bytes for one of the name's. */
enum { ENTRY_MAX = 6 * 64 + 16 };

static void put_entry(struct text *t, const char *name)
{
    char piece[16];
    put(t, t->used > 1 ? ",\"" : "\"");
    for (const unsigned char *at = (const unsigned char *)name; *at; ++at) {
        const char *form = *at < 0x20                  ? "\\u%04x"
                           : *at == '"' || *at == '\\' ? "\\%c"
                                                       : "%c";
        snprintf(piece, sizeof piece, form, *at);
        put(t, piece);
    }
    snprintf(piece, sizeof piece, "\":\"%08lx\"",
             (unsigned long)pbnds_cryptomatte_id(name));
    put(t, piece);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

static char *manifest(const struct pbnds_scene *scene, name_of name)
{
    const size_t count = (size_t)scene->mesh_count;
    char(*names)[64] = calloc(count + 1, sizeof *names);
    struct text t = {malloc(count * ENTRY_MAX + 3), 0};
    if (!names || !t.data) {
        free(names);
        free(t.data);
        return NULL;
    }
    for (size_t i = 0; i < count; ++i)
        name(scene, &scene->meshes[i], names[i]);
    qsort(names, count, sizeof *names, by_name);
    put(&t, "{");
    for (size_t i = 0; i < count; ++i) {
        if (i == 0 || strcmp(names[i], names[i - 1]) != 0) put_entry(&t, names[i]);
    }
    put(&t, "}");
    free(names);
    char *exact = realloc(t.data, t.used + 1);
    return exact ? exact : t.data;
}

enum pbnds_status pbnds_cryptomatte_name(struct pbnds_cryptomatte *cryptomatte,
                                         const struct pbnds_scene *scene,
                                         struct pbnds_error *error)
{
    static const name_of names[] = {pbnds_cryptomatte_object_name,
                                    pbnds_cryptomatte_material_name};
    for (int l = 0; l < PBNDS_CRYPTOMATTE_LAYERS; ++l) {
        cryptomatte->layers[l].manifest = manifest(scene, names[l]);
        if (!cryptomatte->layers[l].manifest) {
            return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                              "no memory for the names of %d meshes",
                              scene->mesh_count);
        }
    }
    return PBNDS_OK;
}

/* Adds up parts of one id; returns how many are left. */
static int merge(struct pbnds_cryptomatte_part *parts, int count)
{
    int kept = 0;
    for (int i = 0; i < count; ++i) {
        int k = 0;
        while (k < kept && parts[k].id != parts[i].id)
            ++k;
        if (k < kept) {
            parts[k].share += parts[i].share;
        } else {
            parts[kept++] = parts[i];
        }
    }
    return kept;
}

void pbnds_cryptomatte_store(const struct pbnds_cryptomatte_layer *layer, size_t i,
                             struct pbnds_cryptomatte_part *parts, int count)
{
    count = merge(parts, count);
    for (int r = 0; r < PBNDS_CRYPTOMATTE_RANKS && r < count; ++r) {
        int best = r;
        for (int k = r + 1; k < count; ++k) {
            if (parts[k].share > parts[best].share) best = k;
        }
        const struct pbnds_cryptomatte_part first = parts[best];
        memmove(parts + r + 1, parts + r, (size_t)(best - r) * sizeof *parts);
        parts[r] = first;
        memcpy(layer->id[r] + i, &first.id, sizeof first.id);
        layer->share[r][i] = first.share;
    }
}
