#include "neural/light_cache.h"

#include <stdlib.h>
#include <string.h>

#include <xxhash.h>

#include "engine/core/parallel.h"
#include "neural/backend/dtype.h"
#include "neural/transport_pass.h"

/* --- identity --------------------------------------------------------------------- */

static uint64_t weights_hash(const struct pbnds_shader_neural *s)
{
    const uint64_t version = (uint64_t)s->model->version * 2 +
                             (pbnds_net_dtype(s->net) == PBNDS_BF16 ? 1 : 0);
    return XXH64(pbnds_net_params(s->net),
                 pbnds_net_param_count(s->net) * sizeof(float), version);
}

static uint64_t gbuffer_hash(const struct pbnds_gbuffer *g)
{
    const size_t bytes = (size_t)g->width * (size_t)g->height * sizeof(float);
    const float *const planes[] = {
        g->albedo[0], g->albedo[1],   g->albedo[2],   g->normal[0],  g->normal[1],
        g->normal[2], g->specular,    g->roughness,   g->depth,      g->metallic,
        g->coverage,  g->position[0], g->position[1], g->position[2]};
    const struct pbnds_camera *c = &g->camera;
    const float lens[] = {c->orthographic ? 1.0f : 0.0f, c->yfov, c->ymag,
                          (float)g->width, (float)g->height};
    uint64_t hash = XXH64(lens, sizeof lens, 0);
    hash = XXH64(&c->world_from_camera, sizeof c->world_from_camera, hash);
    for (size_t i = 0; i < sizeof planes / sizeof *planes; ++i)
        hash = XXH64(planes[i], bytes, hash);
    return hash;
}

static enum pbnds_status check_model(const struct pbnds_shader *shader,
                                     struct pbnds_error *error)
{
    if (strcmp(shader->ops->name, "transport") == 0) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                      "'%s' is not linear in light, so nothing of it can be kept for "
                      "another light; take transport",
                      shader->ops->name);
}

enum pbnds_status pbnds_light_cache_check(const char *name,
                                          const struct pbnds_light_cache *cache,
                                          const struct pbnds_shader *shader,
                                          const struct pbnds_gbuffer *gbuffer,
                                          struct pbnds_error *error)
{
    PBNDS_TRY(check_model(shader, error));
    const bool view = cache->width == gbuffer->width &&
                      cache->height == gbuffer->height &&
                      cache->gbuffer == gbuffer_hash(gbuffer);
    const bool weights =
        cache->weights == weights_hash((const struct pbnds_shader_neural *)shader);
    if (view && weights) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: is the light cache of %s; name another file, or delete this "
                      "one to have it made anew",
                      name,
                      view ? "other weights or another precision" : "another G-buffer");
}

/* --- directions ------------------------------------------------------------------- */

struct pbnds_vec3 pbnds_light_cache_direction(int j, int directions)
{
    const float golden = 2.39996322972865332f; /* pi (3 - sqrt 5) */
    const float y = 1.0f - (2.0f * (float)j + 1.0f) / (float)directions;
    const float r = sqrtf(fmaxf(1.0f - y * y, 0.0f)), phi = golden * (float)j;
    return pbnds_vec3_make(r * cosf(phi), y, r * sinf(phi));
}

/* Adds what comes from w to the directions around it. */
static void distribute(const struct pbnds_vec3 *wi, int count, struct pbnds_vec3 w,
                       struct pbnds_vec3 power, float *g, struct pbnds_vec3 *to)
{
    const float sharpness = 2.0f * (float)count / PBNDS_PI;
    float nearest = -1.0f, sum = 0.0f;
    for (int j = 0; j < count; ++j) {
        g[j] = pbnds_dot(w, wi[j]);
        nearest = fmaxf(nearest, g[j]);
    }
    for (int j = 0; j < count; ++j) {
        const float x = sharpness * (g[j] - nearest);
        g[j] = x > -12.0f ? expf(x) : 0.0f;
        sum += g[j];
    }
    for (int j = 0; j < count; ++j) {
        if (g[j] > 0.0f) to[j] = pbnds_mad(to[j], power, g[j] / sum);
    }
}

enum pbnds_status pbnds_light_cache_project(const struct pbnds_envmap *envmap,
                                            int directions,
                                            struct pbnds_vec3 *irradiance,
                                            struct pbnds_error *error)
{
    enum { W = 128, H = 64 };
    memset(irradiance, 0, (size_t)directions * sizeof *irradiance);
    if (!envmap) return PBNDS_OK;
    struct pbnds_image map;
    struct pbnds_vec3 wi[PBNDS_CACHE_DIRECTIONS_MAX];
    float g[PBNDS_CACHE_DIRECTIONS_MAX];
    PBNDS_TRY(pbnds_envmap_bake(envmap, W, H, &map, error));
    for (int j = 0; j < directions; ++j)
        wi[j] = pbnds_light_cache_direction(j, directions);
    for (int y = 0; y < H; ++y) {
        const float top = PBNDS_PI * (float)y / H,
                    bottom = PBNDS_PI * (float)(y + 1) / H;
        const float solid_angle = 2.0f * PBNDS_PI / W * (cosf(top) - cosf(bottom));
        const float theta = 0.5f * (top + bottom);
        for (int x = 0; x < W; ++x) {
            const float *texel = pbnds_image_at(&map, x, y);
            const float phi = 2.0f * PBNDS_PI * (((float)x + 0.5f) / W - 0.5f);
            const struct pbnds_vec3 w = {sinf(theta) * cosf(phi), cosf(theta),
                                         sinf(theta) * sinf(phi)};
            const struct pbnds_vec3 power = {
                texel[0] * solid_angle, texel[1] * solid_angle, texel[2] * solid_angle};
            if (power.x + power.y + power.z > 0.0f)
                distribute(wi, directions, w, power, g, irradiance);
        }
    }
    pbnds_image_free(&map);
    return PBNDS_OK;
}

/* --- making ----------------------------------------------------------------------- */

struct make {
    struct pbnds_light_cache *cache;
    const struct pbnds_camera *camera;
    const struct pbnds_vec3 *wi;
    uint32_t *rank; /* of every pixel among the covered ones */
    uint16_t *kept; /* [own pixels of a tile, directions, 3], bfloat16 */
    const struct pbnds_transport_tile *tile;
};

static void keep_row(void *context, size_t row, int thread)
{
    (void)thread;
    const struct make *m = context;
    const struct pbnds_transport_tile *t = m->tile;
    const size_t stride = (size_t)t->at.window.width * (size_t)t->at.window.height;
    const size_t directions = (size_t)m->cache->directions;
    struct pbnds_vec3 wi[PBNDS_CHUNK_MAX];
    for (int k = 0; k < t->count; ++k)
        wi[k] = pbnds_camera_from_world_vector(m->camera, m->wi[t->first + k]);
    const int y = t->at.own.y + (int)row;
    for (int x = t->at.own.x; x < t->at.own.x + t->at.own.width; ++x) {
        const size_t own = pbnds_transport_own(t, x, y);
        if (!t->pixels[own].covered) continue;
        const size_t i = pbnds_transport_in_window(t, x, y);
        uint16_t *kept = m->kept + (own * directions + (size_t)t->first) * 3;
        for (int k = 0; k < t->count; ++k, kept += 3) {
            const struct pbnds_vec3 r = pbnds_transport_outgoing(
                &t->pixels[own], wi[k],
                t->lights + ((size_t)k * stride + i) * PBNDS_OUT_COUNT);
            kept[0] = pbnds_f32_to_bf16(fmaxf(r.x, 0.0f));
            kept[1] = pbnds_f32_to_bf16(fmaxf(r.y, 0.0f));
            kept[2] = pbnds_f32_to_bf16(fmaxf(r.z, 0.0f));
        }
    }
}

static enum pbnds_status keep_lights(void *context,
                                     const struct pbnds_transport_tile *tile,
                                     struct pbnds_error *error)
{
    struct make *m = context;
    m->tile = tile;
    if (!m->kept) {
        const size_t pixels =
            (size_t)tile->at.window.width * (size_t)tile->at.window.height;
        m->kept = malloc(pixels * (size_t)m->cache->directions * 3 * sizeof *m->kept);
        if (!m->kept) {
            return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                              "light cache: no memory for a tile, use --max-memory");
        }
    }
    pbnds_parallel_for((size_t)tile->at.own.height, keep_row, m);
    return PBNDS_OK;
}

static void quantise(struct pbnds_light_cache *c, size_t rank, const uint16_t *kept)
{
    const size_t block = rank / PBNDS_CACHE_BLOCK, lane = rank % PBNDS_CACHE_BLOCK;
    for (size_t channel = 0; channel < 3; ++channel) {
        float most = 0.0f;
        for (int j = 0; j < c->directions; ++j)
            most = fmaxf(most, pbnds_bf16_to_f32(kept[3 * (size_t)j + channel]));
        /* infinite where a network's answer is: nothing can be kept of that */
        const bool sound = most > 0.0f && isfinite(most);
        const float scale = sound ? 1.0f / most : 0.0f;
        c->scale[(block * 3 + channel) * PBNDS_CACHE_BLOCK + lane] =
            sound ? most / (255.0f * 255.0f) : 0.0f;
        for (int j = 0; j < c->directions; ++j) {
            const float t = pbnds_bf16_to_f32(kept[3 * (size_t)j + channel]) * scale;
            c->transport[((block * (size_t)c->directions + (size_t)j) * 3 + channel) *
                             PBNDS_CACHE_BLOCK +
                         lane] = (uint8_t)(255.0f * sqrtf(fminf(t, 1.0f)) + 0.5f);
        }
    }
}

/* Weights are the looks' luminances in 8 bits; the lobe's colour is their mean. */
static void keep_looks(const struct pbnds_transport_pixel *pixel, float occlusion,
                       const struct pbnds_transport_look *looks, int count,
                       struct pbnds_cache_gloss *gloss)
{
    float each[PBNDS_CACHE_LOOKS] = {0.0f}, most = 0.0f, sum = 0.0f;
    struct pbnds_vec3 colour = pbnds_splat(0.0f);
    for (int k = 0; k < count; ++k) {
        const struct pbnds_vec3 f = pbnds_scale(looks[k].f, looks[k].factor);
        each[k] = pbnds_luminance(f);
        most = fmaxf(most, each[k]);
        colour = pbnds_add(colour, f);
    }
    for (int k = 0; k < count; ++k) {
        const struct pbnds_env_place place =
            pbnds_envmap_place(looks[k].wi, looks[k].solid_angle);
        const float turn = (place.turn + 0.5f) * 65536.0f + 0.5f;
        gloss->turn[k] = (uint16_t)((uint32_t)fmaxf(turn, 0.0f) & 0xffffu);
        gloss->v[k] = (uint16_t)(pbnds_clamp(place.v, 0.0f, 1.0f) * 65535.0f + 0.5f);
        gloss->size[k] =
            (uint8_t)(pbnds_clamp((place.log2_texel + 22.0f) * 10.0f, 0.0f, 255.0f) +
                      0.5f);
        gloss->weight[k] =
            (uint8_t)(most > 0.0f ? 255.0f * each[k] / most + 0.5f : 0.0f);
        sum += (float)gloss->weight[k];
    }
    const float scale = sum > 0.0f ? (1.0f - pixel->cluster_weight) * occlusion /
                                         ((float)PBNDS_CACHE_LOOKS * sum)
                                   : 0.0f;
    gloss->scale[0] = colour.x * scale;
    gloss->scale[1] = colour.y * scale;
    gloss->scale[2] = colour.z * scale;
}

static void end_row(void *context, size_t row, int thread)
{
    (void)thread;
    const struct make *m = context;
    const struct pbnds_transport_tile *t = m->tile;
    struct pbnds_light_cache *c = m->cache;
    const int y = t->at.own.y + (int)row;
    for (int x = t->at.own.x; x < t->at.own.x + t->at.own.width; ++x) {
        const size_t own = pbnds_transport_own(t, x, y);
        const struct pbnds_transport_pixel *pixel = &t->pixels[own];
        if (!pixel->covered) continue;
        const size_t i = (size_t)y * (size_t)c->width + (size_t)x;
        quantise(c, m->rank[i], m->kept + own * (size_t)c->directions * 3);
        struct pbnds_transport_look looks[PBNDS_CACHE_LOOKS];
        const int count =
            pbnds_transport_looks(pixel, m->camera, PBNDS_CACHE_LOOKS, looks);
        struct pbnds_cache_gloss *gloss = &c->gloss[m->rank[i]];
        gloss->pixel = count > 0 ? (uint32_t)i : UINT32_MAX;
        if (count > 0) {
            keep_looks(pixel,
                       pbnds_transport_occlusion(
                           t->occlusion[pbnds_transport_in_window(t, x, y)]),
                       looks, count, gloss);
        }
    }
}

static enum pbnds_status end_tile(void *context,
                                  const struct pbnds_transport_tile *tile,
                                  struct pbnds_error *error)
{
    (void)error;
    struct make *m = context;
    m->tile = tile;
    pbnds_parallel_for((size_t)tile->at.own.height, end_row, m);
    return PBNDS_OK;
}

/* Covered as transport_pixel() has it. */
static bool is_covered(const struct pbnds_gbuffer *g, size_t i)
{
    return isfinite(g->depth[i]) && g->coverage[i] > 0.0f;
}

/* A lobe for every covered pixel to begin with: which have one is seen while shading. */
static enum pbnds_status begin(const struct pbnds_gbuffer *g, struct make *m,
                               struct pbnds_error *error)
{
    struct pbnds_light_cache *c = m->cache;
    const size_t pixels = (size_t)g->width * (size_t)g->height;
    m->rank = malloc(pixels * sizeof *m->rank);
    if (!m->rank || pixels >= UINT32_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "light cache: no memory for a %d x %d image", g->width,
                          g->height);
    }
    for (size_t i = 0; i < pixels; ++i) {
        m->rank[i] = (uint32_t)c->covered;
        c->covered += is_covered(g, i);
    }
    c->glossy = c->covered;
    PBNDS_TRY(pbnds_light_cache_allocate(c, error));
    memset(c->pixel, 0xff, c->blocks * PBNDS_CACHE_BLOCK * sizeof *c->pixel);
    for (size_t i = 0; i < pixels; ++i) {
        if (is_covered(g, i)) c->pixel[m->rank[i]] = (uint32_t)i;
    }
    return PBNDS_OK;
}

static void drop_dull(struct pbnds_light_cache *c)
{
    size_t n = 0;
    for (size_t i = 0; i < c->glossy; ++i) {
        if (c->gloss[i].pixel != UINT32_MAX) c->gloss[n++] = c->gloss[i];
    }
    c->size -= (c->glossy - n) * sizeof *c->gloss;
    c->glossy = n;
    uint8_t *less = realloc(c->storage, c->size);
    if (less && less != c->storage) {
        const ptrdiff_t moved = less - c->storage;
        c->pixel = (uint32_t *)(void *)((uint8_t *)c->pixel + moved);
        c->scale = (float *)(void *)((uint8_t *)c->scale + moved);
        c->transport += moved;
        c->gloss = (struct pbnds_cache_gloss *)(void *)((uint8_t *)c->gloss + moved);
        c->storage = less;
    }
}

enum pbnds_status pbnds_light_cache_make(const struct pbnds_shader *shader,
                                         const struct pbnds_shade_job *job,
                                         int directions,
                                         struct pbnds_light_cache *cache,
                                         struct pbnds_error *error)
{
    *cache = (struct pbnds_light_cache){.width = job->gbuffer->width,
                                        .height = job->gbuffer->height,
                                        .directions = directions};
    PBNDS_TRY(check_model(shader, error));
    if (directions < 1 || directions > PBNDS_CACHE_DIRECTIONS_MAX) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "light cache: %d directions; give 1 to %d", directions,
                          (int)PBNDS_CACHE_DIRECTIONS_MAX);
    }
    const struct pbnds_shader_neural *neural =
        (const struct pbnds_shader_neural *)shader;
    struct pbnds_vec3 wi[PBNDS_CACHE_DIRECTIONS_MAX];
    for (int j = 0; j < directions; ++j)
        wi[j] = pbnds_light_cache_direction(j, directions);
    struct make make = {.cache = cache, .camera = &job->gbuffer->camera, .wi = wi};
    const struct pbnds_transport_pass pass = {.shader = neural,
                                              .job = job,
                                              .wi = wi,
                                              .count = directions,
                                              .bytes_a_pixel = (size_t)directions * 3 *
                                                               sizeof(uint16_t),
                                              .context = &make,
                                              .lights = keep_lights,
                                              .end = end_tile};
    enum pbnds_status status = begin(job->gbuffer, &make, error);
    if (status == PBNDS_OK) status = pbnds_transport_run(&pass, error);
    free(make.rank);
    free(make.kept);
    if (status != PBNDS_OK) {
        pbnds_light_cache_free(cache);
        return status;
    }
    drop_dull(cache);
    cache->weights = weights_hash(neural);
    cache->gbuffer = gbuffer_hash(job->gbuffer);
    return PBNDS_OK;
}

/* --- relighting ------------------------------------------------------------------- */

enum { STRIP = 64 }; /* blocks, or so many times 64 lobes, a piece of work */

struct relight {
    const struct pbnds_light_cache *cache;
    const struct pbnds_shade_job *job;
    struct pbnds_image *radiance;
    float irradiance[PBNDS_CACHE_DIRECTIONS_MAX][3];
};

/* sum_j E_j q_j^2 of one block. */
PBNDS_KERNEL
static void sum_block(const uint8_t *restrict q, const float (*restrict e)[3],
                      int directions, float sum[3][PBNDS_CACHE_BLOCK])
{
    float r[PBNDS_CACHE_BLOCK] = {0.0f}, g[PBNDS_CACHE_BLOCK] = {0.0f},
          b[PBNDS_CACHE_BLOCK] = {0.0f};
    for (int j = 0; j < directions; ++j, q += 3 * PBNDS_CACHE_BLOCK) {
        PBNDS_SIMD
        for (int i = 0; i < PBNDS_CACHE_BLOCK; ++i) {
            const float x = (float)q[i], y = (float)q[PBNDS_CACHE_BLOCK + i],
                        z = (float)q[2 * PBNDS_CACHE_BLOCK + i];
            r[i] += e[j][0] * (x * x);
            g[i] += e[j][1] * (y * y);
            b[i] += e[j][2] * (z * z);
        }
    }
    memcpy(sum[0], r, sizeof r);
    memcpy(sum[1], g, sizeof g);
    memcpy(sum[2], b, sizeof b);
}

static void sum_strip(void *context, size_t strip, int thread)
{
    (void)thread;
    const struct relight *l = context;
    const struct pbnds_light_cache *c = l->cache;
    const size_t a_block = (size_t)c->directions * 3 * PBNDS_CACHE_BLOCK;
    float *const *emission = l->job->gbuffer->emission;
    for (size_t b = strip * STRIP; b < (strip + 1) * STRIP && b < c->blocks; ++b) {
        float sum[3][PBNDS_CACHE_BLOCK];
        sum_block(c->transport + b * a_block,
                  (const float(*)[3])(const void *)l->irradiance, c->directions, sum);
        const float *scale = c->scale + b * 3 * PBNDS_CACHE_BLOCK;
        for (size_t i = 0; i < PBNDS_CACHE_BLOCK; ++i) {
            const size_t rank = b * PBNDS_CACHE_BLOCK + i;
            if (rank >= c->covered) break;
            const size_t p = c->pixel[rank];
            float *r = l->radiance->data + 3 * p;
            for (size_t k = 0; k < 3; ++k) {
                r[k] = sum[k][i] * scale[k * PBNDS_CACHE_BLOCK + i] + emission[k][p];
            }
        }
    }
}

static void gloss_strip(void *context, size_t strip, int thread)
{
    (void)thread;
    const struct relight *l = context;
    const struct pbnds_light_cache *c = l->cache;
    const size_t first = strip * STRIP * PBNDS_CACHE_BLOCK;
    const size_t end = first + (size_t)STRIP * PBNDS_CACHE_BLOCK;
    for (size_t i = first; i < end && i < c->glossy; ++i) {
        const struct pbnds_cache_gloss *g = &c->gloss[i];
        struct pbnds_vec3 sum = pbnds_splat(0.0f);
        for (int k = 0; k < PBNDS_CACHE_LOOKS; ++k) {
            if (g->weight[k] == 0) continue;
            const struct pbnds_env_place place = {(float)g->turn[k] * 0x1p-16f - 0.5f,
                                                  (float)g->v[k] / 65535.0f,
                                                  (float)g->size[k] * 0.1f - 22.0f};
            sum = pbnds_mad(sum, pbnds_envmap_eval_place(l->job->envmap, place),
                            (float)g->weight[k]);
        }
        float *r = l->radiance->data + 3 * (size_t)g->pixel;
        r[0] += sum.x * g->scale[0];
        r[1] += sum.y * g->scale[1];
        r[2] += sum.z * g->scale[2];
    }
}

enum pbnds_status pbnds_light_cache_shade(const struct pbnds_light_cache *cache,
                                          const struct pbnds_shade_job *job,
                                          struct pbnds_image *radiance,
                                          struct pbnds_error *error)
{
    *radiance = (struct pbnds_image){0};
    if (cache->width != job->gbuffer->width || cache->height != job->gbuffer->height) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "light cache: is of %d x %d pixels, the G-buffer has %d x %d",
                          cache->width, cache->height, job->gbuffer->width,
                          job->gbuffer->height);
    }
    struct pbnds_vec3 e[PBNDS_CACHE_DIRECTIONS_MAX];
    struct relight l = {.cache = cache, .job = job, .radiance = radiance};
    PBNDS_TRY(pbnds_light_cache_project(job->envmap, cache->directions, e, error));
    for (int j = 0; j < cache->directions; ++j) {
        l.irradiance[j][0] = e[j].x;
        l.irradiance[j][1] = e[j].y;
        l.irradiance[j][2] = e[j].z;
    }
    PBNDS_TRY(pbnds_image_init(radiance, cache->width, cache->height, 3, error));
    pbnds_parallel_for((cache->blocks + STRIP - 1) / STRIP, sum_strip, &l);
    const size_t piece = (size_t)STRIP * PBNDS_CACHE_BLOCK;
    if (job->envmap)
        pbnds_parallel_for((cache->glossy + piece - 1) / piece, gloss_strip, &l);
    if (!pbnds_stop_requested()) return PBNDS_OK;
    pbnds_image_free(radiance);
    return pbnds_fail_interrupted(error);
}
