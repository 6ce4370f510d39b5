/* Light at infinity: lookup and importance sampling of an equirect map. */
#include "engine/scene/envmap.h"

#include <stdlib.h>
#include <string.h>

#include "engine/image/oiio.h"
#include "engine/scene/envmap_map.h"

static const double PI = 3.14159265358979323846;

/* Far above any light, and low enough that sums and products stay finite. */
static const float RADIANCE_MAX = 1e20f;

/* u_image = u_gltf + turn; u_gltf itself is 0.5 + atan2(z, x) / 2 pi. */
static const struct {
    const char *name;
    double turn;
} CONVENTIONS[] = {
    [PBNDS_ENV_GLTF] = {"gltf", 0.0},
    [PBNDS_ENV_OPENEXR] = {"openexr", -0.25},
    [PBNDS_ENV_FALCOR] = {"falcor", 0.25},
    [PBNDS_ENV_PBNDS] = {"pbnds", 0.5},
};
enum { CONVENTION_COUNT = sizeof CONVENTIONS / sizeof CONVENTIONS[0] };

int pbnds_env_convention_parse(const char *name, enum pbnds_env_convention *convention)
{
    for (int i = 0; name && i < CONVENTION_COUNT; ++i) {
        if (strcmp(name, CONVENTIONS[i].name) != 0) continue;
        *convention = (enum pbnds_env_convention)i;
        return 1;
    }
    return 0;
}

const char *pbnds_env_convention_name(enum pbnds_env_convention convention)
{
    const int i = (int)convention;
    return i >= 0 && i < CONVENTION_COUNT ? CONVENTIONS[i].name : "unknown";
}

/* ---------------------------------------------------------------- creation */

static enum pbnds_status check_arguments(const char *name,
                                         enum pbnds_env_convention convention,
                                         float yaw_deg, float strength,
                                         struct pbnds_error *error)
{
    if ((int)convention < 0 || (int)convention >= CONVENTION_COUNT)
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: environment convention %d does not exist; take gltf, "
                          "openexr, falcor or pbnds",
                          name, (int)convention);
    if (!isfinite(yaw_deg))
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: the yaw of the light map is not a finite number of "
                          "degrees; give one",
                          name);
    if (!isfinite(strength) || strength < 0.0f)
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "%s: the strength of the light map is negative or not finite; "
            "give a number of 0 or more",
            name);
    return PBNDS_OK;
}

/* L(w) = L_map(R_y(-yaw) w), and R_y(-yaw) adds yaw to atan2(z, x). */
static double u_offset_of(enum pbnds_env_convention convention, float yaw_deg)
{
    const double turn = 0.5 + CONVENTIONS[convention].turn + (double)yaw_deg / 360.0;
    const double offset = turn - floor(turn);
    return offset < 1.0 ? offset : 0.0;
}

static float clean(float x, float strength)
{
    if (!(x > 0.0f)) return 0.0f; /* NaN too */
    const float scaled = x * strength;
    return scaled < RADIANCE_MAX ? scaled : isnan(scaled) ? 0.0f : RADIANCE_MAX;
}

static bool allocate(struct pbnds_envmap *m, int width, int height)
{
    const size_t n = (size_t)width * (size_t)height;
    m->width = width;
    m->height = height;
    m->texels = calloc(n, sizeof *m->texels);
    m->columns = calloc(n, sizeof *m->columns);
    m->rows = calloc((size_t)height, sizeof *m->rows);
    m->cos_theta = calloc((size_t)height + 1, sizeof *m->cos_theta);
    return m->texels && m->columns && m->rows && m->cos_theta;
}

static void copy_texels(struct pbnds_envmap *m, const struct pbnds_image *image,
                        float strength)
{
    const size_t n = (size_t)m->width * (size_t)m->height;
    for (size_t i = 0; i < n; ++i) {
        const float *p = image->data + 3 * i;
        m->texels[i] = pbnds_vec3_make(clean(p[0], strength), clean(p[1], strength),
                                       clean(p[2], strength));
    }
    for (int y = 0; y <= m->height; ++y)
        m->cos_theta[y] = cos(PI * (double)y / (double)m->height);
}

/* Running sums to probabilities. The last weighted entry becomes exactly 1, and entries
   without weight have no width, so that the search below never returns one. */
static void normalise(float *cdf, const double *sums, int count)
{
    const double total = sums[count - 1];
    const double scale = total > 0.0 ? 1.0 / total : 0.0;
    for (int i = 0; i < count; ++i)
        cdf[i] = sums[i] >= total && total > 0.0 ? 1.0f : (float)(sums[i] * scale);
}

/* P(row) P(column | row). Within a row sin theta is common, so only the rows carry the
   solid angle, integrated exactly over each: cos(theta_y) - cos(theta_y+1). Then the
   density of a texel is its luminance over the integral of luminance. */
static bool build_distribution(struct pbnds_envmap *m)
{
    const int longest = m->width > m->height ? m->width : m->height;
    double *sums = calloc(2 * (size_t)longest, sizeof *sums);
    if (!sums) return false;
    double *row_sums = sums + longest;
    double luminance = 0.0, mean[3] = {0.0, 0.0, 0.0};
    for (int y = 0; y < m->height; ++y) {
        const struct pbnds_vec3 *row = m->texels + (size_t)y * (size_t)m->width;
        double sum = 0.0, r = 0.0, g = 0.0, b = 0.0;
        for (int x = 0; x < m->width; ++x) {
            sum += (double)pbnds_luminance(row[x]);
            r += (double)row[x].x;
            g += (double)row[x].y;
            b += (double)row[x].z;
            sums[x] = sum;
        }
        normalise(m->columns + (size_t)y * (size_t)m->width, sums, m->width);
        /* share of the sphere of one texel of this row */
        const double share = 0.5 * (m->cos_theta[y] - m->cos_theta[y + 1]) / m->width;
        luminance += sum * share;
        row_sums[y] = luminance;
        mean[0] += r * share;
        mean[1] += g * share;
        mean[2] += b * share;
    }
    normalise(m->rows, row_sums, m->height);
    free(sums);
    m->mean = pbnds_vec3_make((float)mean[0], (float)mean[1], (float)mean[2]);
    /* Below 1e-30 the densities would leave the range of float: black to the eye. */
    m->pdf_scale = luminance > 1e-30 ? (float)(1.0 / (4.0 * PI * luminance)) : 0.0f;
    return true;
}

enum pbnds_status pbnds_envmap_create(const struct pbnds_image *image,
                                      enum pbnds_env_convention convention,
                                      float yaw_deg, float strength,
                                      struct pbnds_envmap **envmap,
                                      struct pbnds_error *error)
{
    *envmap = NULL;
    if (!image || !image->data || image->channels != 3 || image->width < 1 ||
        image->height < 1 || image->width > 65535 || image->height > 65535)
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "light map: the image has %d channels and %d x %d pixels; give "
            "one of 3 channels",
            image ? image->channels : 0, image ? image->width : 0,
            image ? image->height : 0);
    PBNDS_TRY(check_arguments("light map", convention, yaw_deg, strength, error));
    struct pbnds_envmap *m = calloc(1, sizeof *m);
    if (m && allocate(m, image->width, image->height)) {
        m->u_offset = u_offset_of(convention, yaw_deg);
        copy_texels(m, image, strength);
        if (build_distribution(m) && pbnds_envmap_build_levels(m)) {
            *envmap = m;
            return PBNDS_OK;
        }
    }
    pbnds_envmap_free(m);
    return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                      "light map: no memory for %d x %d texels; use a smaller map",
                      image->width, image->height);
}

enum pbnds_status pbnds_envmap_load(const char *path,
                                    enum pbnds_env_convention convention, float yaw_deg,
                                    float strength, struct pbnds_envmap **envmap,
                                    struct pbnds_error *error)
{
    *envmap = NULL;
    PBNDS_TRY(check_arguments(path, convention, yaw_deg, strength, error));
    struct pbnds_image image;
    PBNDS_TRY(pbnds_image_read_rgb(path, &image, error));
    const enum pbnds_status status =
        pbnds_envmap_create(&image, convention, yaw_deg, strength, envmap, error);
    pbnds_image_free(&image);
    return status;
}

void pbnds_envmap_free(struct pbnds_envmap *envmap)
{
    if (!envmap) return;
    for (int i = 1; i < envmap->level_count; ++i)
        free(envmap->levels[i].texels);
    free(envmap->texels);
    free(envmap->columns);
    free(envmap->rows);
    free(envmap->cos_theta);
    free(envmap);
}

/* ------------------------------------------------------------------ lookup */

static int index_in(double t, int count)
{
    const double x = t * (double)count;
    if (!(x > 0.0)) return 0; /* NaN too */
    return x < (double)count ? (int)x : count - 1;
}

static size_t texel_of(const struct pbnds_envmap *m, struct pbnds_vec3 w)
{
    double u, v;
    pbnds_envmap_uv(m, w, &u, &v);
    return (size_t)index_in(v, m->height) * (size_t)m->width +
           (size_t)index_in(u, m->width);
}

struct pbnds_vec3 pbnds_envmap_eval(const struct pbnds_envmap *envmap,
                                    struct pbnds_vec3 w)
{
    return envmap->texels[texel_of(envmap, w)];
}

float pbnds_envmap_pdf(const struct pbnds_envmap *envmap, struct pbnds_vec3 w)
{
    return pbnds_luminance(envmap->texels[texel_of(envmap, w)]) * envmap->pdf_scale;
}

struct pbnds_vec3 pbnds_envmap_mean(const struct pbnds_envmap *envmap)
{
    return envmap->mean;
}

/* ---------------------------------------------------------------- sampling */

/* First entry with cdf[i] > x; *t is where x lies between its neighbours, in [0, 1].
   The halving has no branch to mispredict. */
static int search(const float *cdf, int count, float x, float *t)
{
    int lo = 0;
    for (int n = count; n > 1;) {
        const int half = n / 2;
        lo += cdf[lo + half - 1] > x ? 0 : half;
        n -= half;
    }
    const float below = lo > 0 ? cdf[lo - 1] : 0.0f;
    const float width = cdf[lo] - below;
    *t = width > 0.0f ? pbnds_clamp((x - below) / width, 0.0f, 1.0f) : 0.5f;
    return lo;
}

/* The point (s, t) in [0, 1]^2 of texel (x, y), uniform in solid angle. */
static struct pbnds_vec3 direction_in(const struct pbnds_envmap *m, int x, int y,
                                      float s, float t)
{
    const double c =
        m->cos_theta[y] + (m->cos_theta[y + 1] - m->cos_theta[y]) * (double)t;
    const float sin_theta = (float)sqrt((1.0 - c) * (1.0 + c));
    double turn = ((double)x + (double)s) / (double)m->width - m->u_offset;
    turn = turn < -0.5 ? turn + 1.0 : turn > 0.5 ? turn - 1.0 : turn;
    const float phi = (float)(2.0 * PI * turn);
    return pbnds_vec3_make(sin_theta * cosf(phi), (float)c, sin_theta * sinf(phi));
}

/* Rounding moves a direction by some 1e-7 of a turn: by a thousandth of a texel. */
static bool near_edge(const struct pbnds_envmap *m, float s, float t)
{
    const float margin = 1.0f / 64.0f;
    return s < margin || s > 1.0f - margin || t < margin || t > 1.0f - margin ||
           m->width > 8192 || m->height > 4096;
}

struct pbnds_env_sample pbnds_envmap_sample(const struct pbnds_envmap *envmap, float u1,
                                            float u2)
{
    const float below_one = 1.0f - 0x1p-24f;
    float s, t;
    const int y = search(envmap->rows, envmap->height, fminf(u1, below_one), &t);
    const size_t row = (size_t)y * (size_t)envmap->width;
    const int x =
        search(envmap->columns + row, envmap->width, fminf(u2, below_one), &s);
    const size_t texel = row + (size_t)x;
    struct pbnds_env_sample sample;
    sample.wi = direction_in(envmap, x, y, s, t);
    /* A point rounded over the edge would be looked up next door: take the centre. */
    if (near_edge(envmap, s, t) && texel_of(envmap, sample.wi) != texel)
        sample.wi = direction_in(envmap, x, y, 0.5f, 0.5f);
    sample.radiance = envmap->texels[texel];
    sample.pdf = pbnds_luminance(sample.radiance) * envmap->pdf_scale;
    return sample;
}
