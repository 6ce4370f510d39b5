/*
 * The ray cast of anti-aliased G-buffers: several rays a pixel, several surfaces a ray.
 *
 * The rays of a pixel pass through the N points of the Hammersley set,
 * ((i + 1/2) / N, van der Corput(i) + half a step), the same in every pixel: over a box of
 * one pixel their mean misses the area of any shape by O(log N / N), and two runs, or two
 * frames, agree to the bit. With N = 1 the point is the pixel's centre.
 *
 * Each surface i that a ray meets has one weight w_i, 1 or (through alpha) its alpha times
 * the transmittance of what lies before it, and every channel of the pixel is
 * sum(w_i c_i) / sum(w_i). All channels of a surface are summed in one loop, so that none
 * can have weights of its own. Sums are in double precision: N equal values give that
 * value back, to the bit.
 */
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/shade/cryptomatte.h"
#include "engine/shade/gbuffer_planes.h"

enum {
    TILE = 16,       /* pixels a side, the unit of work of a thread */
    LAYERS_MAX = 64, /* surfaces along one ray                      */
};

/* A ray that lets less than this through has met all that counts. */
#define TRANSMITTANCE_MIN 1e-3f
/* The next layer lies beyond the last by at least this share of its distance: Embree's
 * division may place a hit a unit in the last place before the triangle it is on. */
#define STEP 0x1p-21f

/* Where each channel lies among the values of one surface. */
enum {
    ALBEDO = 0,
    NORMAL = 3,
    GEOMETRIC = 6,
    POSITION = 9,
    EMISSION = 12,
    F0 = 15,
    SPECULAR = 18,
    ROUGHNESS,
    METALLIC,
    DEPTH,
    F90,
    AO,
    UV,
    MOTION = UV + 2,
    VALUES = MOTION + 2,
};

/* What a pixel has met of one object or material. */
struct share {
    uint32_t id, crypto;
    double weight;
};

struct tally {
    struct share *items;
    int count, room;
};

/* One pixel while it is summed. */
struct pixel {
    double sum[VALUES], weight;
    int surfaces;
};

/* What a thread keeps between pixels. */
struct bench {
    struct tally objects, materials;
    struct pbnds_cryptomatte_part *parts;
    int part_room;
    bool failed; /* no memory: the pixel and the image are lost */
};

struct job {
    const struct pbnds_scene *scene;
    const struct pbnds_accel *accel;
    struct pbnds_gbuffer *gbuffer;
    struct pbnds_camera_view view, previous_view;
    const struct pbnds_vec2 *pattern;
    const uint32_t *object_crypto, *material_crypto; /* a mesh; NULL: no Cryptomatte */
    struct bench *benches;
    size_t tiles_across;
    float footprint; /* of a ray: pixels */
    int samples;
    bool layers; /* walk through transparent surfaces */
};

static void make_pattern(struct pbnds_vec2 *pattern, int samples)
{
    int bits = 0;
    while (1 << bits < samples)
        ++bits;
    const float step = 1.0f / (float)(1 << bits);
    for (int i = 0; i < samples; ++i) {
        int reversed = 0;
        for (int b = 0; b < bits; ++b)
            reversed |= (i >> b & 1) << (bits - 1 - b);
        pattern[i].x = ((float)i + 0.5f) / (float)samples;
        pattern[i].y = ((float)reversed + 0.5f) * step;
    }
}

static bool grow(void **items, int *room, int needed, size_t size)
{
    if (needed <= *room) return true;
    const int wanted = needed < 16 ? 16 : 2 * needed;
    void *larger = realloc(*items, (size_t)wanted * size);
    if (!larger) return false;
    *items = larger;
    *room = wanted;
    return true;
}

static bool tally_add(struct tally *tally, uint32_t id, uint32_t crypto, double weight)
{
    for (int i = 0; i < tally->count; ++i) {
        if (tally->items[i].id != id) continue;
        tally->items[i].weight += weight;
        return true;
    }
    void *items = tally->items;
    const bool ok = grow(&items, &tally->room, tally->count + 1, sizeof *tally->items);
    tally->items = items;
    if (!ok) return false;
    tally->items[tally->count++] = (struct share){id, crypto, weight};
    return true;
}

/* The id of the greatest weight; among equals the one met first. */
static uint32_t tally_best(const struct tally *tally)
{
    int best = 0;
    for (int i = 1; i < tally->count; ++i) {
        if (tally->items[i].weight > tally->items[best].weight) best = i;
    }
    return tally->items[best].id;
}

static void put3(float *values, struct pbnds_vec3 v)
{
    values[0] = v.x;
    values[1] = v.y;
    values[2] = v.z;
}

static void gather(const struct job *job, const struct pbnds_hit *hit,
                   const struct pbnds_surface *s, float values[VALUES])
{
    const struct pbnds_vec3 f0 = pbnds_lerp(s->f0, s->base_color, s->metallic);
    put3(values + ALBEDO, s->base_color);
    put3(values + NORMAL, s->n);
    put3(values + GEOMETRIC, s->ng);
    put3(values + POSITION, s->position);
    put3(values + EMISSION, s->emission);
    put3(values + F0, f0);
    values[SPECULAR] = pbnds_luminance(f0);
    values[ROUGHNESS] = s->roughness;
    values[METALLIC] = s->metallic;
    values[DEPTH] = pbnds_dot(pbnds_sub(s->position, job->view.eye), job->view.forward);
    values[F90] = s->f90 + s->metallic * (1.0f - s->f90);
    values[AO] = s->occlusion;
    values[UV] = s->uv.x;
    values[UV + 1] = s->uv.y;
    values[MOTION] = values[MOTION + 1] = 0.0f;
    if (job->gbuffer->motion[0]) {
        const struct pbnds_vec2 m =
            pbnds_image_motion(&job->view, &job->previous_view, s->position,
                               pbnds_scene_previous(job->scene, hit));
        values[MOTION] = m.x;
        values[MOTION + 1] = m.y;
    }
}

static struct pbnds_surface look_at(const struct job *job, const struct pbnds_ray *ray,
                                    const struct pbnds_hit *hit)
{
    const float depth = hit->t * pbnds_dot(ray->direction, job->view.forward);
    const float size = job->view.pixel * (job->view.orthographic ? 1.0f : depth);
    struct pbnds_surface s;
    pbnds_scene_surface(job->scene, hit, pbnds_scale(ray->direction, -1.0f),
                        size * job->footprint, &s);
    return s;
}

static void add_surface(const struct job *job, struct bench *bench, struct pixel *pixel,
                        const struct pbnds_hit *hit, const struct pbnds_surface *s,
                        float weight)
{
    float values[VALUES];
    gather(job, hit, s, values);
    /* The first is stored, not added to zero, which would turn a -0 into 0. */
    const bool first = pixel->surfaces == 0;
    for (int k = 0; k < VALUES; ++k) {
        const double part = (double)weight * (double)values[k];
        pixel->sum[k] = first ? part : pixel->sum[k] + part;
    }
    pixel->weight += (double)weight;
    ++pixel->surfaces;
    const uint32_t object = job->object_crypto ? job->object_crypto[hit->mesh] : 0;
    const uint32_t material = job->object_crypto ? job->material_crypto[hit->mesh] : 0;
    const double w = (double)weight;
    if (!tally_add(&bench->objects, s->object_id, object, w) ||
        !tally_add(&bench->materials, (uint32_t)s->material, material, w)) {
        bench->failed = true;
    }
}

/* Every layer of one ray, nearest first. */
static void add_layers(const struct job *job, struct bench *bench, struct pixel *pixel,
                       const struct pbnds_ray *ray)
{
    struct pbnds_query query = {.max_t = INFINITY, .blend_solid = true, .cull = true};
    struct pbnds_hit hit, last = {0.0f, 0.0f, 0.0f, UINT32_MAX, 0};
    float through = 1.0f;
    for (int layer = 0; layer < LAYERS_MAX && through >= TRANSMITTANCE_MIN; ++layer) {
        pbnds_accel_intersect_query(job->accel, ray, &query, &hit);
        if (hit.mesh == UINT32_MAX) return;
        query.min_t = hit.t + hit.t * STEP;
        if (hit.mesh == last.mesh && hit.triangle == last.triangle) continue;
        last = hit;
        const struct pbnds_surface s = look_at(job, ray, &hit);
        const struct pbnds_mesh *mesh = &job->scene->meshes[hit.mesh];
        const enum pbnds_alpha_mode mode =
            job->scene->materials[mesh->material].alpha_mode;
        /* A cut-out surface is there or not: the ray stopped, so it is there. */
        const float alpha =
            mode == PBNDS_ALPHA_BLEND ? pbnds_clamp(s.alpha, 0.0f, 1.0f) : 1.0f;
        add_surface(job, bench, pixel, &hit, &s, through * alpha);
        through *= 1.0f - alpha;
    }
}

static void store3(float *const planes[3], size_t i, struct pbnds_vec3 v)
{
    planes[0][i] = v.x;
    planes[1][i] = v.y;
    planes[2][i] = v.z;
}

static struct pbnds_vec3 mean3(const struct pixel *p, int k)
{
    return pbnds_vec3_make((float)(p->sum[k] / p->weight),
                           (float)(p->sum[k + 1] / p->weight),
                           (float)(p->sum[k + 2] / p->weight));
}

/* A mean direction, unit and facing the eye again. The mean of one is that one. */
static struct pbnds_vec3 mean_direction(const struct pixel *p, int k,
                                        struct pbnds_vec3 wo)
{
    const struct pbnds_vec3 n = mean3(p, k);
    if (p->surfaces == 1) return n;
    const float square = pbnds_dot(n, n);
    if (!(square > 1e-12f)) return wo; /* they cancel each other */
    return pbnds_face_eye(pbnds_scale(n, 1.0f / sqrtf(square)), wo);
}

static void store_mean(const struct job *job, const struct pixel *p, size_t i,
                       struct pbnds_vec3 wo)
{
    const struct pbnds_gbuffer *g = job->gbuffer;
    const double w = p->weight;
    store3(g->albedo, i, mean3(p, ALBEDO));
    store3(g->normal, i, mean_direction(p, NORMAL, wo));
    store3(g->geometric_normal, i, mean_direction(p, GEOMETRIC, wo));
    store3(g->position, i, mean3(p, POSITION));
    store3(g->emission, i, mean3(p, EMISSION));
    g->specular[i] = (float)(p->sum[SPECULAR] / w);
    g->roughness[i] = (float)(p->sum[ROUGHNESS] / w);
    g->metallic[i] = (float)(p->sum[METALLIC] / w);
    g->depth[i] = (float)(p->sum[DEPTH] / w);
    g->coverage[i] = fminf((float)(w / (double)job->samples), 1.0f);
    if (g->f90) {
        store3(g->f0, i, mean3(p, F0));
        g->f90[i] = (float)(p->sum[F90] / w);
    }
    if (g->ao) g->ao[i] = (float)(p->sum[AO] / w);
    for (int c = 0; c < 2 && g->uv[0]; ++c)
        g->uv[c][i] = (float)(p->sum[UV + c] / w);
    for (int c = 0; c < 2 && g->motion[0]; ++c)
        g->motion[c][i] = (float)(p->sum[MOTION + c] / w);
}

static void store_matte(const struct job *job, struct bench *bench, size_t i, int layer,
                        const struct tally *tally)
{
    void *parts = bench->parts;
    const bool ok = grow(&parts, &bench->part_room, tally->count, sizeof *bench->parts);
    bench->parts = parts;
    if (!ok) {
        bench->failed = true;
        return;
    }
    for (int k = 0; k < tally->count; ++k) {
        bench->parts[k].id = tally->items[k].crypto;
        bench->parts[k].share = (float)(tally->items[k].weight / (double)job->samples);
    }
    pbnds_cryptomatte_store(&job->gbuffer->cryptomatte->layers[layer], i, bench->parts,
                            tally->count);
}

/* The pixel is complete: into the planes with it, and ready for the next. */
static void finish(const struct job *job, struct bench *bench, struct pixel *pixel,
                   int x, int y)
{
    const struct pbnds_gbuffer *g = job->gbuffer;
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    if (pixel->weight > 0.0 && !bench->failed) {
        const struct pbnds_ray centre =
            pbnds_camera_view_ray(&job->view, (float)x + 0.5f, (float)y + 0.5f);
        store_mean(job, pixel, i, pbnds_scale(centre.direction, -1.0f));
        g->object_id[i] = tally_best(&bench->objects);
        if (g->material_id) g->material_id[i] = tally_best(&bench->materials);
        if (g->cryptomatte) {
            store_matte(job, bench, i, 0, &bench->objects);
            store_matte(job, bench, i, 1, &bench->materials);
        }
    } else {
        g->depth[i] = INFINITY;
        g->object_id[i] = UINT32_MAX;
        if (g->material_id) g->material_id[i] = UINT32_MAX;
    }
    *pixel = (struct pixel){.weight = 0.0};
    bench->objects.count = bench->materials.count = 0;
}

static struct pbnds_ray sample_ray(const struct job *job, int x, int y, int sample)
{
    const struct pbnds_vec2 p = job->pattern[sample];
    return pbnds_camera_view_ray(&job->view, (float)x + p.x, (float)y + p.y);
}

static void cast_row_layers(const struct job *job, struct bench *bench, int x0, int x1,
                            int y)
{
    struct pixel pixel = {.weight = 0.0};
    for (int x = x0; x < x1; ++x) {
        for (int s = 0; s < job->samples; ++s) {
            const struct pbnds_ray ray = sample_ray(job, x, y, s);
            add_layers(job, bench, &pixel, &ray);
        }
        finish(job, bench, &pixel, x, y);
    }
}

/* The samples of a row of pixels, one after the other, in packets. */
static void cast_row(const struct job *job, struct bench *bench, int x0, int x1, int y)
{
    struct pbnds_ray rays[PBNDS_PACKET];
    struct pbnds_hit hits[PBNDS_PACKET];
    struct pixel pixel = {.weight = 0.0};
    const int total = (x1 - x0) * job->samples;
    for (int first = 0; first < total; first += PBNDS_PACKET) {
        const int count = total - first < PBNDS_PACKET ? total - first : PBNDS_PACKET;
        for (int k = 0; k < count; ++k) {
            const int at = first + k;
            rays[k] = sample_ray(job, x0 + at / job->samples, y, at % job->samples);
        }
        pbnds_accel_intersect_packet(job->accel, rays, count, hits);
        for (int k = 0; k < count; ++k) {
            const int at = first + k;
            if (hits[k].mesh != UINT32_MAX) {
                const struct pbnds_surface s = look_at(job, &rays[k], &hits[k]);
                add_surface(job, bench, &pixel, &hits[k], &s, 1.0f);
            }
            if (at % job->samples == job->samples - 1)
                finish(job, bench, &pixel, x0 + at / job->samples, y);
        }
    }
}

static void cast_tile(void *context, size_t tile, int thread)
{
    const struct job *job = context;
    const struct pbnds_gbuffer *g = job->gbuffer;
    struct bench *bench = &job->benches[thread];
    const int x0 = (int)(tile % job->tiles_across) * TILE;
    const int y0 = (int)(tile / job->tiles_across) * TILE;
    const int x1 = x0 + TILE < g->width ? x0 + TILE : g->width;
    const int y1 = y0 + TILE < g->height ? y0 + TILE : g->height;
    for (int y = y0; y < y1 && !bench->failed; ++y) {
        if (job->layers) {
            cast_row_layers(job, bench, x0, x1, y);
        } else {
            cast_row(job, bench, x0, x1, y);
        }
    }
}

static void name_meshes(const struct pbnds_scene *scene, uint32_t *object,
                        uint32_t *material)
{
    char name[64];
    for (int i = 0; i < scene->mesh_count; ++i) {
        pbnds_cryptomatte_object_name(scene, &scene->meshes[i], name);
        object[i] = pbnds_cryptomatte_id(name);
        pbnds_cryptomatte_material_name(scene, &scene->meshes[i], name);
        material[i] = pbnds_cryptomatte_id(name);
    }
}

static enum pbnds_status prepare_mattes(const struct pbnds_scene *scene,
                                        struct pbnds_gbuffer *g,
                                        struct pbnds_error *error)
{
    PBNDS_TRY(pbnds_cryptomatte_create(g->width, g->height, &g->cryptomatte, error));
    return pbnds_cryptomatte_name(g->cryptomatte, scene, error);
}

static bool cast_all(struct job *job)
{
    const struct pbnds_gbuffer *g = job->gbuffer;
    const int threads = pbnds_threads();
    job->benches = calloc((size_t)threads, sizeof *job->benches);
    if (!job->benches) return false;
    job->tiles_across = ((size_t)g->width + TILE - 1) / TILE;
    const size_t tiles_down = ((size_t)g->height + TILE - 1) / TILE;
    pbnds_parallel_for(job->tiles_across * tiles_down, cast_tile, job);
    bool ok = true;
    for (int t = 0; t < threads; ++t) {
        ok = ok && !job->benches[t].failed;
        free(job->benches[t].objects.items);
        free(job->benches[t].materials.items);
        free(job->benches[t].parts);
    }
    free(job->benches);
    return ok;
}

bool pbnds_raycast_is_antialiased(const struct pbnds_accel *accel,
                                  const struct pbnds_raycast_options *options)
{
    return options->samples > 1 || (options->optional & PBNDS_OPTIONAL_CRYPTOMATTE) ||
           (options->through == PBNDS_THROUGH_ALPHA && pbnds_accel_blends(accel));
}

enum pbnds_status pbnds_gbuffer_raycast_antialiased(
    const struct pbnds_scene *scene, const struct pbnds_accel *accel,
    const struct pbnds_raycast_options *options, struct pbnds_gbuffer *gbuffer,
    struct pbnds_error *error)
{
    const bool mattes = (options->optional & PBNDS_OPTIONAL_CRYPTOMATTE) != 0;
    if (mattes) PBNDS_TRY(prepare_mattes(scene, gbuffer, error));
    const struct pbnds_camera *camera = &gbuffer->camera;
    const int samples = gbuffer->samples;
    const size_t meshes = (size_t)scene->mesh_count + 1;
    struct pbnds_vec2 *pattern = malloc((size_t)samples * sizeof *pattern);
    uint32_t *crypto = malloc(2 * meshes * sizeof *crypto);
    struct job job = {
        .scene = scene,
        .accel = accel,
        .gbuffer = gbuffer,
        .view = pbnds_camera_view(camera, gbuffer->width, gbuffer->height),
        .previous_view = pbnds_camera_view(
            options->previous_camera ? options->previous_camera : camera,
            gbuffer->width, gbuffer->height),
        .pattern = pattern,
        .object_crypto = mattes ? crypto : NULL,
        .material_crypto = mattes ? crypto + meshes : NULL,
        .footprint = 1.0f / sqrtf((float)samples),
        .samples = samples,
        .layers = options->through == PBNDS_THROUGH_ALPHA && pbnds_accel_blends(accel),
    };
    bool ok = pattern && crypto;
    if (ok) {
        make_pattern(pattern, samples);
        if (mattes) name_meshes(scene, crypto, crypto + meshes);
        ok = cast_all(&job);
    }
    free(pattern);
    free(crypto);
    if (pbnds_stop_requested()) return pbnds_fail_interrupted(error);
    if (ok) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                      "no memory to cast %d rays a pixel; use fewer", samples);
}
