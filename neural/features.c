#include "neural/features.h"

#include <string.h>

#include "engine/core/parallel.h"

#define ROW(NAME, PLANE)                                                               \
    {                                                                                  \
        NAME, PBNDS_PLANE_##PLANE, 1.0f, 0.0f, PBNDS_TRANSFER_LINEAR                   \
    }
#define LIGHT(NAME, PLANE)                                                             \
    {                                                                                  \
        NAME, PBNDS_LIGHT_##PLANE, 1.0f, 0.0f, PBNDS_TRANSFER_LINEAR                   \
    }
#define HORIZON(K)                                                                     \
    {                                                                                  \
        "horizon" #K, PBNDS_PLANE_HORIZON + K, 1.0f, 0.0f, PBNDS_TRANSFER_LINEAR       \
    }

static const struct pbnds_feature TRANSPORT_VIEW[] = {
    ROW("albedo.R", ALBEDO_R),
    ROW("albedo.G", ALBEDO_G),
    ROW("albedo.B", ALBEDO_B),
    ROW("normal.X", NORMAL_X),
    ROW("normal.Y", NORMAL_Y),
    ROW("normal.Z", NORMAL_Z),
    ROW("specular", SPECULAR),
    ROW("roughness", ROUGHNESS),
    ROW("metallic", METALLIC),
    ROW("n.v", N_DOT_V),
    ROW("mask", MASK),
    ROW("log_depth", LOG_DEPTH),
    HORIZON(0),
    HORIZON(1),
    HORIZON(2),
    HORIZON(3),
    HORIZON(4),
    HORIZON(5),
    HORIZON(6),
    HORIZON(7),
};
static const struct pbnds_feature TRANSPORT_LIGHT[] = {
    LIGHT("n.l", N_DOT_L),
    LIGHT("n.l signed", N_DOT_L_SIGNED),
    LIGHT("l.x", X),
    LIGHT("l.y", Y),
    LIGHT("l.z", Z),
    LIGHT("march thin", MARCH_THIN),
    LIGHT("march thick", MARCH_THICK),
    LIGHT("horizon", HORIZON),
};

static const struct pbnds_feature PLUS_VIEW[] = {
    ROW("albedo.R", ALBEDO_R), ROW("albedo.G", ALBEDO_G),
    ROW("albedo.B", ALBEDO_B), ROW("normal.X", NORMAL_X),
    ROW("normal.Y", NORMAL_Y), ROW("normal.Z", NORMAL_Z),
    ROW("specular", SPECULAR), ROW("roughness", ROUGHNESS),
    ROW("v.x", WO_X),          ROW("v.y", WO_Y),
    ROW("v.z", WO_Z),
};
/* Radiance is unbounded: log1p keeps a sun within the reach of the encoding. */
static const struct pbnds_feature PLUS_LIGHT[] = {
    {"L.R n.l", PBNDS_LIGHT_RADIANCE_R, 1.0f, 0.0f, PBNDS_TRANSFER_LOG1P},
    {"L.G n.l", PBNDS_LIGHT_RADIANCE_G, 1.0f, 0.0f, PBNDS_TRANSFER_LOG1P},
    {"L.B n.l", PBNDS_LIGHT_RADIANCE_B, 1.0f, 0.0f, PBNDS_TRANSFER_LOG1P},
};

#define COUNT(A) ((int)(sizeof(A) / sizeof((A)[0])))

const struct pbnds_feature_table pbnds_features_transport = {
    TRANSPORT_VIEW, COUNT(TRANSPORT_VIEW), TRANSPORT_LIGHT, COUNT(TRANSPORT_LIGHT), 0};
const struct pbnds_feature_table pbnds_features_pbnds_plus = {
    PLUS_VIEW, COUNT(PLUS_VIEW), PLUS_LIGHT, COUNT(PLUS_LIGHT), 8};

int pbnds_features_view_channels(const struct pbnds_feature_table *table)
{
    return table->view_count * (1 + 2 * table->bands);
}

int pbnds_features_light_channels(const struct pbnds_feature_table *table)
{
    return table->light_count * (1 + 2 * table->bands);
}

static float transferred(const struct pbnds_feature *f, float value)
{
    const float x = (value - f->offset) * f->scale;
    return f->transfer == PBNDS_TRANSFER_LOG1P ? log1pf(fmaxf(x, 0.0f)) : x;
}

/* dst[0 .. count) holds the identity; appends the bands. sin and cos of twice the angle
 * follow from the last, so that only the first band costs a library call. */
static void encode(float *dst, int count, int bands)
{
    for (int j = 0; j < count && bands > 0; ++j) {
        float s = sinf(dst[j]), c = cosf(dst[j]);
        for (int k = 0; k < bands; ++k) {
            dst[count * (1 + 2 * k) + j] = s;
            dst[count * (2 + 2 * k) + j] = c;
            const float s2 = 2.0f * s * c;
            c = 1.0f - 2.0f * s * s;
            s = s2;
        }
    }
}

static int clamped(int x, int size)
{
    return x < 0 ? 0 : x >= size ? size - 1 : x;
}

struct feature_job {
    const struct pbnds_feature_table *table;
    const struct pbnds_view *view;
    const struct pbnds_march *march;
    struct pbnds_light_source light;
    struct pbnds_vec3 l; /* camera space */
    struct pbnds_window window;
    float *dst;
    int channels;
};

static size_t source_pixel(const struct feature_job *job, int x, size_t row)
{
    const struct pbnds_view *v = job->view;
    const int sx = clamped(job->window.x + x - v->x, v->width);
    const int sy = clamped(job->window.y + (int)row - v->y, v->height);
    return (size_t)sy * (size_t)v->width + (size_t)sx;
}

static void view_row(void *context, size_t row, int thread)
{
    (void)thread;
    const struct feature_job *job = context;
    float *dst = job->dst + row * (size_t)job->window.width * (size_t)job->channels;
    for (int x = 0; x < job->window.width; ++x, dst += job->channels) {
        const size_t i = source_pixel(job, x, row);
        for (int j = 0; j < job->table->view_count; ++j) {
            const struct pbnds_feature *f = &job->table->view[j];
            dst[j] = transferred(f, job->view->plane[f->plane][i]);
        }
        encode(dst, job->table->view_count, job->table->bands);
    }
}

void pbnds_features_view(const struct pbnds_feature_table *table,
                         const struct pbnds_view *view, struct pbnds_window window,
                         float *dst)
{
    struct feature_job job = {.table = table,
                              .view = view,
                              .window = window,
                              .dst = dst,
                              .channels = pbnds_features_view_channels(table)};
    pbnds_parallel_for((size_t)window.height, view_row, &job);
}

/* Where the light stands against the horizon at its azimuth in the image. */
static float horizon_visibility(const struct pbnds_view *v, size_t i,
                                struct pbnds_vec3 l, float n_dot_l)
{
    float azimuth = atan2f(-l.y, l.x) * (PBNDS_HORIZONS / (2.0f * PBNDS_PI));
    if (azimuth < 0.0f) azimuth += PBNDS_HORIZONS;
    const int a = (int)azimuth % PBNDS_HORIZONS, b = (a + 1) % PBNDS_HORIZONS;
    const float t = azimuth - floorf(azimuth);
    const float horizon = (1.0f - t) * v->plane[PBNDS_PLANE_HORIZON + a][i] +
                          t * v->plane[PBNDS_PLANE_HORIZON + b][i];
    return pbnds_clamp((n_dot_l - horizon) / 0.4f + 0.5f, 0.0f, 1.0f);
}

static void light_planes(const struct feature_job *job, size_t i,
                         float planes[PBNDS_LIGHT_PLANE_COUNT])
{
    const struct pbnds_view *v = job->view;
    memset(planes, 0, PBNDS_LIGHT_PLANE_COUNT * sizeof *planes);
    if (!(v->plane[PBNDS_PLANE_MASK][i] > 0.0f)) return;
    const struct pbnds_vec3 n = {v->plane[PBNDS_PLANE_NORMAL_X][i],
                                 v->plane[PBNDS_PLANE_NORMAL_Y][i],
                                 v->plane[PBNDS_PLANE_NORMAL_Z][i]};
    const float signed_cos = pbnds_dot(n, job->l), n_dot_l = fmaxf(signed_cos, 0.0f);
    planes[PBNDS_LIGHT_N_DOT_L] = n_dot_l;
    planes[PBNDS_LIGHT_N_DOT_L_SIGNED] = signed_cos;
    planes[PBNDS_LIGHT_X] = job->l.x;
    planes[PBNDS_LIGHT_Y] = job->l.y;
    planes[PBNDS_LIGHT_Z] = job->l.z;
    if (job->march) {
        const unsigned bit = (unsigned)job->light.bit;
        planes[PBNDS_LIGHT_MARCH_THIN] =
            1.0f - (float)(job->march->thin[i] >> bit & 1u);
        planes[PBNDS_LIGHT_MARCH_THICK] =
            1.0f - (float)(job->march->thick[i] >> bit & 1u);
        planes[PBNDS_LIGHT_HORIZON] = horizon_visibility(v, i, job->l, signed_cos);
    }
    planes[PBNDS_LIGHT_RADIANCE_R] = job->light.radiance.x * n_dot_l;
    planes[PBNDS_LIGHT_RADIANCE_G] = job->light.radiance.y * n_dot_l;
    planes[PBNDS_LIGHT_RADIANCE_B] = job->light.radiance.z * n_dot_l;
}

static void light_row(void *context, size_t row, int thread)
{
    (void)thread;
    const struct feature_job *job = context;
    float *dst = job->dst + row * (size_t)job->window.width * (size_t)job->channels;
    for (int x = 0; x < job->window.width; ++x, dst += job->channels) {
        float planes[PBNDS_LIGHT_PLANE_COUNT];
        light_planes(job, source_pixel(job, x, row), planes);
        for (int j = 0; j < job->table->light_count; ++j) {
            const struct pbnds_feature *f = &job->table->light[j];
            dst[j] = transferred(f, planes[f->plane]);
        }
        encode(dst, job->table->light_count, job->table->bands);
    }
}

void pbnds_features_light(const struct pbnds_feature_table *table,
                          const struct pbnds_view *view,
                          const struct pbnds_march *march,
                          const struct pbnds_light_source *light,
                          struct pbnds_window window, float *dst)
{
    struct feature_job job = {
        .table = table,
        .view = view,
        .march = march,
        .light = *light,
        .l = pbnds_camera_from_world_vector(&view->camera, light->wi),
        .window = window,
        .dst = dst,
        .channels = pbnds_features_light_channels(table)};
    pbnds_parallel_for((size_t)window.height, light_row, &job);
}
