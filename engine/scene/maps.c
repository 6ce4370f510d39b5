#include "engine/scene/maps.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/large.h"
#include "engine/core/parallel.h"
#include "engine/core/report.h"
#include "engine/scene/scene.h"

static const uint64_t default_budget = (uint64_t)4 << 30;

/* Which channels of its texture a map keeps, in order; whether they are colours. */
struct kind {
    int channel[4];
    int count;
    bool srgb;
};

static const struct kind kinds[PBNDS_MAP_COUNT] = {
    [PBNDS_MAP_BASE_COLOR] = {{0, 1, 2, 3}, 3, true},
    [PBNDS_MAP_METALLIC_ROUGHNESS] = {{1, 2, 0, 0}, 2, false},
    [PBNDS_MAP_NORMAL] = {{0, 1, 2, 0}, 3, false},
    [PBNDS_MAP_EMISSIVE] = {{0, 1, 2, 0}, 3, true},
    [PBNDS_MAP_OCCLUSION] = {{0, 0, 0, 0}, 1, false},
    [PBNDS_MAP_SPECULAR] = {{3, 0, 0, 0}, 1, false},
    [PBNDS_MAP_SPECULAR_COLOR] = {{0, 1, 2, 3}, 3, true},
};

/* Planning: which maps go together. */

static const struct pbnds_texture_ref *map_ref(const struct pbnds_material *m, int map)
{
    const struct pbnds_texture_ref *const refs[PBNDS_MAP_COUNT] = {
        &m->base_color_texture,    &m->metallic_roughness_texture, &m->normal_texture,
        &m->emissive_texture,      &m->occlusion_texture,          &m->specular_texture,
        &m->specular_color_texture};
    return refs[map];
}

static int channels_kept(const struct pbnds_material *m, int map)
{
    const bool alpha =
        (map == PBNDS_MAP_BASE_COLOR && m->alpha_mode != PBNDS_ALPHA_OPAQUE) ||
        (map == PBNDS_MAP_SPECULAR_COLOR && m->specular_glossiness);
    return kinds[map].count + (alpha ? 1 : 0);
}

static bool can_bundle(const struct pbnds_scene *scene, const struct pbnds_material *m,
                       int map)
{
    const struct pbnds_texture_ref *ref = map_ref(m, map);
    if (ref->texture < 0 || scene->textures[ref->texture].nearest) return false;
    const struct pbnds_pixels *p = scene->textures[ref->texture].pixels;
    return p->width > 0 && p->height > 0 && (p->u8 || p->f32) &&
           !(map == PBNDS_MAP_EMISSIVE && !(pbnds_max3(m->emissive) > 0.0f));
}

static int channels_used(const struct pbnds_bundle *b)
{
    int used = 0;
    for (int map = 0; map < PBNDS_MAP_COUNT; ++map)
        used += b->kept[map];
    return used;
}

/* May the map join the bundle, or begin an empty one? */
static bool fits(const struct pbnds_bundle *b, const struct pbnds_texture *t,
                 const struct pbnds_texture_ref *ref, int kept)
{
    const int used = channels_used(b);
    if (used == 0) return true;
    return b->width[0] == t->pixels->width && b->height[0] == t->pixels->height &&
           b->wrap_u == t->wrap_u && b->wrap_v == t->wrap_v &&
           b->texcoord == ref->texcoord && b->transformed == ref->transformed &&
           (!ref->transformed ||
            memcmp(b->transform, ref->transform, sizeof b->transform) == 0) &&
           used + kept <= PBNDS_BUNDLE_CHANNELS;
}

static void empty_bundle(struct pbnds_bundle *b)
{
    *b = (struct pbnds_bundle){.texcoord = 0};
    for (int map = 0; map < PBNDS_MAP_COUNT; ++map)
        b->first[map] = b->texture[map] = -1;
}

static void join(struct pbnds_bundle *b, const struct pbnds_texture *t,
                 const struct pbnds_texture_ref *ref, int map, int kept)
{
    b->wrap_u = t->wrap_u;
    b->wrap_v = t->wrap_v;
    b->texcoord = ref->texcoord;
    b->transformed = ref->transformed;
    memcpy(b->transform, ref->transform, sizeof b->transform);
    b->width[0] = t->pixels->width;
    b->height[0] = t->pixels->height;
    b->first[map] = channels_used(b);
    b->kept[map] = kept;
    b->texture[map] = ref->texture;
}

/* The bundles of one material; `group` says which of them a map is in. */
static int plan(const struct pbnds_scene *scene, const struct pbnds_material *m,
                struct pbnds_bundle planned[PBNDS_MAP_COUNT],
                int group[PBNDS_MAP_COUNT])
{
    int count = 0;
    for (int map = 0; map < PBNDS_MAP_COUNT; ++map) {
        group[map] = -1;
        if (!can_bundle(scene, m, map)) continue;
        const struct pbnds_texture_ref *ref = map_ref(m, map);
        const struct pbnds_texture *t = &scene->textures[ref->texture];
        const int kept = channels_kept(m, map);
        int at = 0;
        while (at < count && !fits(&planned[at], t, ref, kept))
            ++at;
        if (at == count) empty_bundle(&planned[count++]);
        join(&planned[at], t, ref, map, kept);
        group[map] = at;
    }
    return count;
}

/* Sizes of the levels. @return bytes */
static uint64_t lay_out(struct pbnds_bundle *b)
{
    b->channels = (channels_used(b) + 3) / 4 * 4;
    const float *t = b->transform;
    const float scale = b->transformed ? fabsf(t[0] * t[4] - t[1] * t[3]) : 1.0f;
    b->density = (float)b->width[0] * (float)b->height[0] * scale;
    uint64_t texels = 0;
    int w = b->width[0], h = b->height[0];
    for (b->levels = 0; b->levels < PBNDS_MIP_LEVELS;) {
        b->width[b->levels] = w;
        b->height[b->levels] = h;
        b->at[b->levels++] = (uint32_t)texels;
        texels += (uint64_t)w * (uint64_t)h;
        if (w == 1 && h == 1) break;
        w = w > 1 ? w / 2 : 1;
        h = h > 1 ? h / 2 : 1;
    }
    return texels * (uint64_t)b->channels * sizeof *b->texels;
}

static bool same_plan(const struct pbnds_bundle *a, const struct pbnds_bundle *b)
{
    return memcmp(a->texture, b->texture, sizeof a->texture) == 0 &&
           memcmp(a->kept, b->kept, sizeof a->kept) == 0 && a->wrap_u == b->wrap_u &&
           a->wrap_v == b->wrap_v && a->texcoord == b->texcoord &&
           a->transformed == b->transformed &&
           (!a->transformed ||
            memcmp(a->transform, b->transform, sizeof a->transform) == 0);
}

/* Filling: every level in float from the one above, rounded once. */

struct filling {
    const struct pbnds_scene *scene;
    struct pbnds_bundle *bundle;
    float *above; /* the level before in float, from level 2 on */
    float *here;  /* receives this level in float, from level 1 on */
    int level;
};

static uint16_t round_unit(float x)
{
    return (uint16_t)(65535.0f * pbnds_clamp(x, 0.0f, 1.0f) + 0.5f);
}

/* The kept channels of one texel of the finest level. */
static void fetch(const struct filling *f, int x, int y, float *out)
{
    const struct pbnds_bundle *b = f->bundle;
    for (int map = 0; map < PBNDS_MAP_COUNT; ++map) {
        if (b->first[map] < 0) continue;
        const struct pbnds_pixels *p = f->scene->textures[b->texture[map]].pixels;
        const struct pbnds_vec4 v = pbnds_texel(p, x, y, kinds[map].srgb);
        const float rgba[4] = {v.x, v.y, v.z, v.w};
        for (int c = 0; c < b->kept[map]; ++c)
            out[b->first[map] + c] = rgba[kinds[map].channel[c]];
    }
}

/* Which source texels cover [i, i + 1) of a row that shrinks from `size` to `to`. */
struct span {
    int first, count;
    float
        weight[4]; /* sums to 1; a level is never less than a third of the one above */
};

static struct span span_of(int i, int size, int to)
{
    const double step = (double)size / (double)to;
    const double begin = step * (double)i, end = step * (double)(i + 1);
    struct span s = {.first = (int)begin, .count = 0};
    for (int k = s.first; k < size && s.count < 4 && (double)k < end - 1e-9; ++k) {
        const double lo = begin > (double)k ? begin : (double)k;
        const double hi = end < (double)(k + 1) ? end : (double)(k + 1);
        s.weight[s.count++] = (float)((hi - lo) / step);
    }
    return s;
}

/* One texel from those above it. */
static void average(const struct filling *f, const struct span *sx,
                    const struct span *sy, float *out)
{
    const struct pbnds_bundle *b = f->bundle;
    const int n = b->channels, base = b->first[PBNDS_MAP_BASE_COLOR];
    const bool alpha = base >= 0 && b->kept[PBNDS_MAP_BASE_COLOR] == 4;
    float color[3] = {0.0f, 0.0f, 0.0f}; /* weighed by alpha */
    for (int c = 0; c < n; ++c)
        out[c] = 0.0f;
    for (int j = 0; j < sy->count; ++j) {
        for (int i = 0; i < sx->count; ++i) {
            const float w = sy->weight[j] * sx->weight[i];
            const int x = sx->first + i, y = sy->first + j;
            float texel[PBNDS_BUNDLE_CHANNELS] = {0.0f};
            const float *p = texel;
            if (f->level == 1) /* the finest level is read twice, never held in float */
                fetch(f, x, y, texel);
            else
                p = f->above +
                    ((size_t)y * (size_t)b->width[f->level - 1] + (size_t)x) *
                        (size_t)n;
            for (int c = 0; c < n; ++c)
                out[c] += w * p[c];
            for (int c = 0; c < 3 && alpha; ++c)
                color[c] += w * p[base + 3] * p[base + c];
        }
    }
    for (int c = 0; c < 3 && alpha && out[base + 3] > 0.0f; ++c)
        out[base + c] = color[c] / out[base + 3];
}

static void fill_row(void *context, size_t y, int thread)
{
    (void)thread;
    const struct filling *f = context;
    struct pbnds_bundle *b = f->bundle;
    const int level = f->level, w = b->width[level], n = b->channels;
    struct span sy = {0};
    if (level > 0) sy = span_of((int)y, b->height[level - 1], b->height[level]);
    for (int x = 0; x < w; ++x) {
        float value[PBNDS_BUNDLE_CHANNELS] = {0.0f};
        if (level > 0) {
            const struct span sx = span_of(x, b->width[level - 1], w);
            average(f, &sx, &sy, value);
        } else {
            fetch(f, x, (int)y, value);
        }
        const size_t at = y * (size_t)w + (size_t)x;
        uint16_t *out = b->texels + (b->at[level] + at) * (size_t)n;
        for (int c = 0; c < n; ++c)
            out[c] = round_unit(value[c]);
        if (level > 0)
            memcpy(f->here + at * (size_t)n, value, (size_t)n * sizeof *value);
    }
}

/* Room for a level in float; of the last one where there are fewer. */
static float *level_room(const struct pbnds_bundle *b, int level)
{
    const int at = level < b->levels ? level : b->levels - 1;
    return malloc((size_t)b->width[at] * (size_t)b->height[at] * (size_t)b->channels *
                  sizeof(float));
}

static enum pbnds_status fill(const struct pbnds_scene *scene, struct pbnds_bundle *b,
                              uint64_t bytes, struct pbnds_error *error)
{
    b->texels = pbnds_large_alloc((size_t)bytes);
    struct filling f = {.scene = scene, .bundle = b};
    f.above = level_room(b, 2);
    f.here = level_room(b, 1);
    const bool ok = b->texels && f.above && f.here;
    for (f.level = 0; f.level < b->levels && ok; ++f.level) {
        pbnds_parallel_for((size_t)b->height[f.level], fill_row, &f);
        if (f.level == 0) continue;
        float *filled = f.here;
        f.here = f.above;
        f.above = filled;
    }
    free(f.above);
    free(f.here);
    if (ok) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                      "no memory for the mip maps of a %d x %d texture; use smaller "
                      "textures",
                      b->width[0], b->height[0]);
}

/* The bundle that does what is planned, made or found; -1: past the budget. */
static enum pbnds_status settle(const struct pbnds_scene *scene,
                                struct pbnds_maps *maps, struct pbnds_bundle *planned,
                                uint64_t *budget, int *index, struct pbnds_error *error)
{
    for (*index = 0; *index < maps->count; ++*index) {
        if (same_plan(&maps->bundles[*index], planned)) return PBNDS_OK;
    }
    const uint64_t bytes = lay_out(planned);
    if (bytes > *budget) {
        *index = -1;
        return PBNDS_OK;
    }
    *budget -= bytes;
    maps->bundles[maps->count++] = *planned;
    return fill(scene, &maps->bundles[*index], bytes, error);
}

static enum pbnds_status bundle_material(const struct pbnds_scene *scene,
                                         struct pbnds_maps *maps, int material,
                                         uint64_t *budget, struct pbnds_error *error)
{
    struct pbnds_bundle planned[PBNDS_MAP_COUNT];
    int group[PBNDS_MAP_COUNT], made[PBNDS_MAP_COUNT];
    const int count = plan(scene, &scene->materials[material], planned, group);
    for (int i = 0; i < count; ++i)
        PBNDS_TRY(settle(scene, maps, &planned[i], budget, &made[i], error));
    for (int map = 0; map < PBNDS_MAP_COUNT; ++map)
        maps->materials[material].bundle[map] = group[map] < 0 ? -1 : made[group[map]];
    return PBNDS_OK;
}

enum pbnds_status pbnds_scene_prefilter(struct pbnds_scene *scene, uint64_t max_bytes,
                                        struct pbnds_error *error)
{
    uint64_t budget = max_bytes ? max_bytes : default_budget;
    const size_t count = scene->material_count > 0 ? (size_t)scene->material_count : 1;
    struct pbnds_maps *maps = calloc(1, sizeof *maps);
    if (maps) maps->bundles = calloc(count * PBNDS_MAP_COUNT, sizeof *maps->bundles);
    if (maps) maps->materials = calloc(count, sizeof *maps->materials);
    enum pbnds_status status = PBNDS_OK;
    if (!maps || !maps->bundles || !maps->materials)
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "the mip maps: out of memory");
    for (int i = 0; i < scene->material_count && status == PBNDS_OK; ++i)
        status = bundle_material(scene, maps, i, &budget, error);
    if (status == PBNDS_OK && pbnds_stop_requested())
        status = pbnds_fail_interrupted(error);
    if (status != PBNDS_OK) {
        pbnds_maps_free(maps);
        return status;
    }
    pbnds_maps_free(scene->maps);
    scene->maps = maps;
    return PBNDS_OK;
}

struct pbnds_vec4 pbnds_map_value(const struct pbnds_bundle *bundle, int map,
                                  const float *values)
{
    float rgba[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    for (int c = 0; c < bundle->kept[map]; ++c)
        rgba[kinds[map].channel[c]] = values[bundle->first[map] + c];
    return (struct pbnds_vec4){rgba[0], rgba[1], rgba[2], rgba[3]};
}

void pbnds_maps_free(struct pbnds_maps *maps)
{
    if (!maps) return;
    for (int i = 0; i < maps->count; ++i)
        free(maps->bundles[i].texels);
    free(maps->bundles);
    free(maps->materials);
    free(maps);
}
