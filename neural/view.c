#include "neural/view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"

enum { HORIZON_TAPS = 10, MARCH_TAPS = 32 };

/* Depth buffer to camera space and back, without a matrix: x right, y up, z = -depth.
 */
struct lens {
    float cx, cy,
        focal; /* pixels; focal is height / 2 / tan(yfov / 2), or pixels a metre */
    bool orthographic;
};

static struct lens lens_of(const struct pbnds_camera *camera, int width, int height)
{
    struct lens l = {0.5f * (float)width, 0.5f * (float)height, 0.0f,
                     camera->orthographic};
    const float half = camera->orthographic ? camera->ymag : tanf(0.5f * camera->yfov);
    l.focal = 0.5f * (float)height / half;
    return l;
}

static struct pbnds_vec3 unproject(const struct lens *l, float px, float py,
                                   float depth)
{
    const float scale = (l->orthographic ? 1.0f : depth) / l->focal;
    return pbnds_vec3_make((px - l->cx) * scale, (l->cy - py) * scale, -depth);
}

static void project(const struct lens *l, struct pbnds_vec3 p, float *px, float *py)
{
    const float scale = l->orthographic ? l->focal : l->focal / -p.z;
    *px = l->cx + p.x * scale;
    *py = l->cy - p.y * scale;
}

/* Half the height of what the image shows at that depth, metres: the unit of length for
 * everything in screen space, so that neither resolution nor scene scale matters. */
static float extent_at(const struct lens *l, int height, float depth)
{
    return 0.5f * (float)height / l->focal * (l->orthographic ? 1.0f : depth);
}

/* Floats ordered as unsigned integers. */
static uint32_t ordered(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits >> 31 ? ~bits : bits | 0x80000000u;
}

static float from_ordered(uint32_t key)
{
    const uint32_t bits = key >> 31 ? key & 0x7fffffffu : ~key;
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* By digits from the top: counts those of the values that share the digits found so far,
 * so that nothing is sorted or copied. */
float pbnds_view_median_depth(const struct pbnds_gbuffer *gbuffer)
{
    enum { DIGIT = 11, DIGITS = 3, BINS = 1 << DIGIT };
    const size_t pixels = (size_t)gbuffer->width * (size_t)gbuffer->height;
    uint32_t key = 0, known = 0; /* the digits found, and which bits they are */
    size_t rank = 0;
    for (int d = 0; d < DIGITS; ++d) {
        size_t bins[BINS] = {0}, total = 0;
        const int shift = d == 0 ? 21 : d == 1 ? 10 : 0;
        const uint32_t mask = d == DIGITS - 1 ? 0x3ffu : BINS - 1;
        for (size_t i = 0; i < pixels; ++i) {
            if (!isfinite(gbuffer->depth[i])) continue;
            const uint32_t k = ordered(gbuffer->depth[i]);
            if ((k & known) != key) continue;
            ++bins[k >> shift & mask];
            ++total;
        }
        if (total == 0) return 1.0f;
        if (d == 0) rank = total / 2;
        uint32_t b = 0;
        while (rank >= bins[b])
            rank -= bins[b++];
        key |= b << shift;
        known |= mask << shift;
    }
    return fmaxf(from_ordered(key), 1e-6f);
}

struct plane_job {
    const struct pbnds_gbuffer *gbuffer;
    struct pbnds_view *view;
    struct lens lens;
    float median;
};

static float horizon_towards(const struct plane_job *job, int x, int y,
                             struct pbnds_vec3 p, struct pbnds_vec3 n, float dx,
                             float dy)
{
    const struct pbnds_view *v = job->view;
    const float reach = 0.6f * 0.5f * (float)v->image_height;
    const float fade = 1.0f / (1.5f * extent_at(&job->lens, v->image_height, -p.z));
    float horizon = 0.0f;
    for (int k = 1; k <= HORIZON_TAPS; ++k) {
        const float s = (float)k / HORIZON_TAPS;
        const float r = fmaxf(reach * s * s, (float)k);
        const int qx = (int)floorf((float)x + 0.5f + dx * r);
        const int qy = (int)floorf((float)y + 0.5f + dy * r);
        if (qx < 0 || qy < 0 || qx >= v->image_width || qy >= v->image_height) break;
        const float depth = v->depth[(size_t)qy * (size_t)v->image_width + (size_t)qx];
        if (!isfinite(depth)) continue;
        const struct pbnds_vec3 q =
            unproject(&job->lens, (float)qx + 0.5f, (float)qy + 0.5f, depth);
        const struct pbnds_vec3 d = pbnds_sub(q, p);
        const float length = pbnds_length(d);
        if (!(length > 0.0f)) continue;
        const float weight = fmaxf(1.0f - length * fade, 0.0f);
        horizon = fmaxf(horizon, weight * pbnds_dot(d, n) / length);
    }
    return horizon;
}

static void copy_pixel(const struct pbnds_gbuffer *g, struct pbnds_view *v, size_t i,
                       size_t to, int x, int y, float median)
{
    const struct pbnds_camera *c = &g->camera;
    const struct pbnds_vec3 n = pbnds_camera_from_world_vector(
        c, pbnds_vec3_make(g->normal[0][i], g->normal[1][i], g->normal[2][i]));
    const struct pbnds_vec3 wo =
        pbnds_camera_from_world_vector(c, pbnds_gbuffer_wo(g, x, y));
    for (int k = 0; k < 3; ++k)
        v->plane[PBNDS_PLANE_ALBEDO_R + k][to] = g->albedo[k][i];
    v->plane[PBNDS_PLANE_NORMAL_X][to] = n.x;
    v->plane[PBNDS_PLANE_NORMAL_Y][to] = n.y;
    v->plane[PBNDS_PLANE_NORMAL_Z][to] = n.z;
    v->plane[PBNDS_PLANE_WO_X][to] = wo.x;
    v->plane[PBNDS_PLANE_WO_Y][to] = wo.y;
    v->plane[PBNDS_PLANE_WO_Z][to] = wo.z;
    v->plane[PBNDS_PLANE_SPECULAR][to] = g->specular[i];
    v->plane[PBNDS_PLANE_ROUGHNESS][to] = g->roughness[i];
    v->plane[PBNDS_PLANE_METALLIC][to] = g->metallic[i];
    v->plane[PBNDS_PLANE_N_DOT_V][to] = pbnds_dot(n, wo);
    v->plane[PBNDS_PLANE_MASK][to] = g->coverage[i];
    v->plane[PBNDS_PLANE_LOG_DEPTH][to] = logf(fmaxf(g->depth[i], 1e-6f) / median);
}

static void horizons(const struct plane_job *job, size_t i, int x, int y, float depth)
{
    const struct pbnds_view *v = job->view;
    const struct pbnds_vec3 p =
        unproject(&job->lens, (float)x + 0.5f, (float)y + 0.5f, depth);
    const struct pbnds_vec3 n = {v->plane[PBNDS_PLANE_NORMAL_X][i],
                                 v->plane[PBNDS_PLANE_NORMAL_Y][i],
                                 v->plane[PBNDS_PLANE_NORMAL_Z][i]};
    for (int k = 0; k < PBNDS_HORIZONS; ++k) {
        const float a = (float)k * (2.0f * PBNDS_PI / PBNDS_HORIZONS);
        v->plane[PBNDS_PLANE_HORIZON + k][i] =
            horizon_towards(job, x, y, p, n, cosf(a), sinf(a));
    }
}

static void plane_row(void *context, size_t row, int thread)
{
    (void)thread;
    const struct plane_job *job = context;
    struct pbnds_view *v = job->view;
    const int y = v->y + (int)row;
    for (int k = 0; k < v->width; ++k) {
        const int x = v->x + k;
        const size_t from = (size_t)y * (size_t)v->image_width + (size_t)x;
        const size_t to = row * (size_t)v->width + (size_t)k;
        if (!isfinite(v->depth[from])) continue;
        copy_pixel(job->gbuffer, v, from, to, x, y, job->median);
        horizons(job, to, x, y, v->depth[from]);
    }
}

size_t pbnds_view_bytes_a_pixel(void)
{
    return PBNDS_PLANE_COUNT * sizeof(float);
}

/* The planes of view's rectangle, with room for `more` floats behind them. */
static enum pbnds_status make_planes(const struct pbnds_gbuffer *gbuffer, float median,
                                     size_t more, struct pbnds_view *view,
                                     struct pbnds_error *error)
{
    const size_t count = (size_t)view->width * (size_t)view->height;
    view->image_width = gbuffer->width;
    view->image_height = gbuffer->height;
    view->camera = gbuffer->camera;
    view->depth = gbuffer->depth;
    view->storage = calloc(count * PBNDS_PLANE_COUNT + more, sizeof(float));
    if (!view->storage) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "no memory for the feature planes of a %d x %d image",
                          view->width, view->height);
    }
    for (int k = 0; k < PBNDS_PLANE_COUNT; ++k) {
        view->plane[k] = view->storage + (size_t)k * count;
    }
    struct plane_job job = {
        gbuffer, view, lens_of(&view->camera, gbuffer->width, gbuffer->height), median};
    pbnds_parallel_for((size_t)view->height, plane_row, &job);
    return PBNDS_OK;
}

enum pbnds_status pbnds_view_create(const struct pbnds_gbuffer *gbuffer,
                                    struct pbnds_view *view, struct pbnds_error *error)
{
    const size_t count = (size_t)gbuffer->width * (size_t)gbuffer->height;
    *view = (struct pbnds_view){.width = gbuffer->width, .height = gbuffer->height};
    PBNDS_TRY(
        make_planes(gbuffer, pbnds_view_median_depth(gbuffer), count, view, error));
    float *depth = view->storage + (size_t)PBNDS_PLANE_COUNT * count;
    memcpy(depth, gbuffer->depth, count * sizeof(float));
    view->depth = depth;
    return PBNDS_OK;
}

/* [*first, *first + *count) cut to [0, size). */
static void cut(int *first, int *count, int size)
{
    const int end = *first + *count < size ? *first + *count : size;
    *first = *first > 0 ? *first : 0;
    *count = end - *first;
}

enum pbnds_status pbnds_view_create_part(const struct pbnds_gbuffer *gbuffer,
                                         struct pbnds_window window, float median_depth,
                                         struct pbnds_view *view,
                                         struct pbnds_error *error)
{
    cut(&window.x, &window.width, gbuffer->width);
    cut(&window.y, &window.height, gbuffer->height);
    *view = (struct pbnds_view){
        .width = window.width, .height = window.height, .x = window.x, .y = window.y};
    if (window.width < 1 || window.height < 1) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "a part of a view must meet its %d x %d image",
                          gbuffer->width, gbuffer->height);
    }
    return make_planes(gbuffer, median_depth, 0, view, error);
}

void pbnds_view_free(struct pbnds_view *view)
{
    free(view->storage);
    *view = (struct pbnds_view){0};
}

struct march_job {
    const struct pbnds_view *view;
    struct lens lens;
    struct pbnds_vec3 l[32]; /* camera space */
    int count;
    struct pbnds_march *march;
};

/* Walks along l with steps that grow quadratically; bit 0: blocked thin, bit 1: thick.
 */
static unsigned march_pixel(const struct march_job *job, struct pbnds_vec3 p,
                            float jitter, struct pbnds_vec3 l)
{
    const struct pbnds_view *v = job->view;
    const float extent = extent_at(&job->lens, v->image_height, -p.z);
    const float first =
        extent * 3.0f / (float)v->image_height; /* one and a half pixels */
    const float reach = 1.5f * extent;
    const float bias = 0.004f * extent, thin = 0.1f * extent, thick = 0.7f * extent;
    unsigned blocked = 0;
    for (int k = 0; k < MARCH_TAPS && blocked != 3u; ++k) {
        const float s = ((float)k + jitter) / MARCH_TAPS;
        const struct pbnds_vec3 q = pbnds_mad(p, l, first + reach * s * s);
        if (-q.z <= 1e-6f) break;
        float fx, fy;
        project(&job->lens, q, &fx, &fy);
        if (!(fx >= 0.0f && fy >= 0.0f && fx < (float)v->image_width &&
              fy < (float)v->image_height)) {
            break;
        }
        const float depth = v->depth[(size_t)fy * (size_t)v->image_width + (size_t)fx];
        const float behind = -q.z - depth; /* -inf over the background */
        if (behind <= bias) continue;
        if (behind < thin) blocked |= 1u;
        if (behind < thick) blocked |= 2u;
    }
    return blocked;
}

static void march_row(void *context, size_t row, int thread)
{
    (void)thread;
    const struct march_job *job = context;
    const struct pbnds_view *v = job->view;
    /* 4x4 ordered dither: neighbours sample other distances, which hides banding. */
    static const unsigned char BAYER[4][4] = {
        {0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    const int y = v->y + (int)row;
    for (int k = 0; k < v->width; ++k) {
        const int x = v->x + k;
        const size_t i = row * (size_t)v->width + (size_t)k;
        const float depth = v->depth[(size_t)y * (size_t)v->image_width + (size_t)x];
        uint32_t thin = 0, thick = 0;
        if (isfinite(depth)) {
            const struct pbnds_vec3 p =
                unproject(&job->lens, (float)x + 0.5f, (float)y + 0.5f, depth);
            const struct pbnds_vec3 n = {v->plane[PBNDS_PLANE_NORMAL_X][i],
                                         v->plane[PBNDS_PLANE_NORMAL_Y][i],
                                         v->plane[PBNDS_PLANE_NORMAL_Z][i]};
            const float jitter = ((float)BAYER[y & 3][x & 3] + 0.5f) / 16.0f;
            for (int j = 0; j < job->count; ++j) {
                if (pbnds_dot(n, job->l[j]) <= 0.0f)
                    continue; /* faces away: no march */
                const unsigned blocked = march_pixel(job, p, jitter, job->l[j]);
                thin |= (blocked & 1u) << j;
                thick |= (blocked >> 1) << j;
            }
        }
        job->march->thin[i] = thin;
        job->march->thick[i] = thick;
    }
}

void pbnds_view_march(const struct pbnds_view *view, const struct pbnds_vec3 *wi,
                      int count, struct pbnds_march *march)
{
    struct march_job job = {
        .view = view,
        .lens = lens_of(&view->camera, view->image_width, view->image_height),
        .count = count,
        .march = march};
    for (int k = 0; k < count; ++k) {
        job.l[k] = pbnds_camera_from_world_vector(&view->camera, wi[k]);
    }
    pbnds_parallel_for((size_t)view->height, march_row, &job);
}
