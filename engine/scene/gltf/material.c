#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/scene/gltf/load.h"

/* Textures and images of the file are numbered anew: only those that a material samples
 * are decoded and kept. */
struct remap {
    int *texture; /* of the document -> of the scene, -1: not used (yet) */
    int *image;
};

/** One image to decode, on any thread. */
struct decode_job {
    const uint8_t *bytes;
    uint64_t size;
    char name[512];
    enum pbnds_status status;
    struct pbnds_error error;
    struct pbnds_pixels *pixels;
};

/* What all images together may take once decoded. */
/* Far above any lamp, and far enough below FLT_MAX for the sums of a path. */
static const double EMISSION_MAX = 1e20;

static const uint64_t max_decoded = (uint64_t)8 << 30;

static float unit(double x)
{
    return x > 0.0 ? (x < 1.0 ? (float)x : 1.0f) : 0.0f;
}

static enum pbnds_wrap wrap_of(int gl)
{
    return gl == 33071 ? PBNDS_WRAP_CLAMP
                       : (gl == 33648 ? PBNDS_WRAP_MIRROR : PBNDS_WRAP_REPEAT);
}

/** The scene's number of a texture of the document; -1 when it has no image. */
static int add_texture(struct pbnds_gltf_load_state *g, struct remap *map,
                       int64_t index)
{
    if (index < 0) return -1;
    if (map->texture[index] >= 0) return map->texture[index];
    const struct pbnds_gltf_texture *source = &g->doc.textures[index];
    if (source->image < 0) return -1; /* e.g. only in a format of an extension */
    int *image = &map->image[source->image];
    if (*image < 0) *image = g->scene->image_count++;
    struct pbnds_texture *texture = &g->scene->textures[g->scene->texture_count];
    texture->pixels = &g->scene->images[*image];
    texture->wrap_u = texture->wrap_v = PBNDS_WRAP_REPEAT;
    if (source->sampler >= 0) {
        const struct pbnds_gltf_sampler *s = &g->doc.samplers[source->sampler];
        texture->wrap_u = wrap_of(s->wrap_s);
        texture->wrap_v = wrap_of(s->wrap_t);
        texture->nearest = s->mag_filter == 9728;
    }
    return map->texture[index] = g->scene->texture_count++;
}

static struct pbnds_texture_ref make_ref(struct pbnds_gltf_load_state *g,
                                         struct remap *map,
                                         const struct pbnds_gltf_texture_info *info)
{
    struct pbnds_texture_ref ref = {.texture = -1};
    if (info->index >= 0 && (info->texcoord < 0 || info->texcoord > 1)) {
        pbnds_warn(
            g->report,
            "%s: a texture uses TEXCOORD_%lld and is left out, only 0 and 1 are read",
            g->name, (long long)info->texcoord);
        return ref;
    }
    ref.texture = add_texture(g, map, info->index);
    if (ref.texture >= 0) ref.texcoord = (int)info->texcoord;
    return ref;
}

/** Reflectance at normal incidence. KHR_materials_ior: an ior of 0 stands for infinity.
 */
static float ior_f0(double ior)
{
    const double r = ior > 0.0 ? (ior - 1.0) / (ior + 1.0) : 1.0;
    return unit(r * r);
}

static enum pbnds_status convert_factors(struct pbnds_gltf_load_state *g, size_t index,
                                         struct pbnds_material *m)
{
    const struct pbnds_gltf_material *s = &g->doc.materials[index];
    pbnds_gltf_name(m->name, s->name, "material", index);
    m->base_color = (struct pbnds_vec4){unit(s->base_color[0]), unit(s->base_color[1]),
                                        unit(s->base_color[2]), unit(s->base_color[3])};
    m->metallic = unit(s->metallic);
    m->roughness = unit(s->roughness);
    m->ior_f0 = ior_f0(s->ior);
    m->specular = unit(s->specular);
    float emissive[3];
    for (int i = 0; i < 3; ++i) {
        const double e = s->emissive[i] * s->emissive_strength;
        if (!(e >= 0.0 && e <= EMISSION_MAX)) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                              "%s: material %zu emits %g, which is not a radiance",
                              g->name, index, e);
        }
        emissive[i] = (float)e;
    }
    m->emissive = pbnds_vec3_make(emissive[0], emissive[1], emissive[2]);
    m->normal_scale = fabs(s->normal_scale) < 1e6 ? (float)s->normal_scale : 1.0f;
    m->alpha_cutoff =
        s->alpha_cutoff >= 0.0 && s->alpha_cutoff < 1e6 ? (float)s->alpha_cutoff : 0.5f;
    m->double_sided = s->double_sided;
    g->more_specular = g->more_specular || s->more_specular;
    if (strcmp(s->alpha_mode, "OPAQUE") == 0)
        m->alpha_mode = PBNDS_ALPHA_OPAQUE;
    else if (strcmp(s->alpha_mode, "MASK") == 0)
        m->alpha_mode = PBNDS_ALPHA_MASK;
    else if (strcmp(s->alpha_mode, "BLEND") == 0)
        m->alpha_mode = PBNDS_ALPHA_BLEND;
    else {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: material %zu has an unknown alphaMode", g->name, index);
    }
    return PBNDS_OK;
}

static enum pbnds_status convert_material(struct pbnds_gltf_load_state *g,
                                          struct remap *map, size_t index,
                                          struct pbnds_material *m)
{
    const struct pbnds_gltf_material *s = &g->doc.materials[index];
    *m = pbnds_material_default();
    PBNDS_TRY(convert_factors(g, index, m));
    m->base_color_texture = make_ref(g, map, &s->base_color_texture);
    m->metallic_roughness_texture = make_ref(g, map, &s->metallic_roughness_texture);
    m->normal_texture = make_ref(g, map, &s->normal_texture);
    m->emissive_texture = make_ref(g, map, &s->emissive_texture);
    return PBNDS_OK;
}

/** The encoded bytes of an image: a buffer view or what its URI names. */
static enum pbnds_status find_image(struct pbnds_gltf_load_state *g, size_t index,
                                    struct decode_job *job)
{
    struct pbnds_gltf_payload *payload = &g->source.images[index];
    const int64_t view = g->doc.image_views[index];
    (void)snprintf(job->name, sizeof job->name, "%.400s, image %zu", g->name, index);
    if (view >= 0 || !payload->uri) {
        return pbnds_gltf_view_bytes(g, view, "an image", &job->bytes, &job->size);
    }
    if (strncmp(payload->uri, "data:", 5) != 0) {
        (void)snprintf(job->name, sizeof job->name, "%.300s, image \"%.180s\"", g->name,
                       payload->uri);
    }
    PBNDS_TRY(pbnds_gltf_resolve(&g->source, payload, "image", index, g->error));
    job->bytes = payload->data;
    job->size = payload->size;
    return PBNDS_OK;
}

static void decode_one(void *context, size_t i, int thread)
{
    (void)thread;
    struct decode_job *job = (struct decode_job *)context + i;
    job->status = pbnds_pixels_decode(job->bytes, (size_t)job->size, job->name,
                                      job->pixels, &job->error);
}

/** Bytes that decoded pixels take. */
static uint64_t pixels_size(const struct pbnds_pixels *p)
{
    return (uint64_t)p->width * (uint64_t)p->height * (p->f32 ? 16u : 4u);
}

static enum pbnds_status decode_images(struct pbnds_gltf_load_state *g,
                                       const struct remap *map)
{
    const size_t count = (size_t)g->scene->image_count;
    struct decode_job *jobs = calloc(count + 1, sizeof *jobs);
    if (!jobs)
        return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory", g->name);
    enum pbnds_status status = PBNDS_OK;
    for (size_t i = 0; i < g->doc.image_count && status == PBNDS_OK; ++i) {
        if (map->image[i] < 0) continue;
        struct decode_job *job = &jobs[map->image[i]];
        job->pixels = &g->scene->images[map->image[i]];
        status = find_image(g, i, job);
    }
    /* A few at a time, so that a bomb is seen before it fills the memory. */
    uint64_t decoded = 0;
    for (size_t i = 0; i < count && status == PBNDS_OK;) {
        const size_t threads = (size_t)pbnds_threads();
        const size_t batch = count - i < threads ? count - i : threads;
        pbnds_parallel_for(batch, decode_one, jobs + i);
        for (size_t end = i + batch; i < end && status == PBNDS_OK; ++i) {
            status = jobs[i].status;
            if (status != PBNDS_OK && g->error) *g->error = jobs[i].error;
            decoded += pixels_size(jobs[i].pixels);
        }
        pbnds_progress(g->report, "textures", (double)i, (double)count);
        if (status == PBNDS_OK && pbnds_stop_requested()) {
            status = pbnds_fail_interrupted(g->error);
        }
        if (status == PBNDS_OK && decoded > max_decoded) {
            status = pbnds_fail(g->error, PBNDS_ERROR_MEMORY,
                                "%s: its textures take more than 8 GiB", g->name);
        }
    }
    free(jobs);
    return status;
}

static bool make_room(struct pbnds_gltf_load_state *g, struct remap *map)
{
    const struct pbnds_gltf_document *d = &g->doc;
    g->scene->materials = calloc(d->material_count + 1, sizeof *g->scene->materials);
    g->scene->textures = calloc(d->texture_count + 1, sizeof *g->scene->textures);
    g->scene->images = calloc(d->image_count + 1, sizeof *g->scene->images);
    map->texture = malloc((d->texture_count + 1) * sizeof *map->texture);
    map->image = malloc((d->image_count + 1) * sizeof *map->image);
    if (!g->scene->materials || !g->scene->textures || !g->scene->images ||
        !map->texture || !map->image) {
        return false;
    }
    for (size_t i = 0; i < d->texture_count; ++i)
        map->texture[i] = -1;
    for (size_t i = 0; i < d->image_count; ++i)
        map->image[i] = -1;
    return true;
}

enum pbnds_status pbnds_gltf_materials(struct pbnds_gltf_load_state *g)
{
    struct remap map = {0};
    enum pbnds_status status = PBNDS_OK;
    if (!make_room(g, &map)) {
        status = pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for materials",
                            g->name);
    }
    for (size_t i = 0; i < g->doc.material_count && status == PBNDS_OK; ++i) {
        status = convert_material(g, &map, i, &g->scene->materials[i]);
        ++g->scene->material_count;
    }
    if (status == PBNDS_OK) {
        g->scene->materials[g->scene->material_count++] = pbnds_material_default();
        status = decode_images(g, &map);
    }
    free(map.texture);
    free(map.image);
    return status;
}
