/* A light map as a few distant lights: Debevec 2005, "A Median Cut Algorithm for Light
   Probe Sampling", with a summed-area table as in Viriyothai and Debevec 2009. */
#include <stdlib.h>

#include "engine/scene/envmap_map.h"

static const double PI = 3.14159265358979323846;

/* Texels [x0, x1) x [y0, y1). */
struct region {
    int x0, y0, x1, y1;
    double energy;   /* integral of luminance */
    double priority; /* energy times the longer side in radians; 0: cannot be cut */
};

/* table[y][x], (height + 1) x (width + 1): integral of luminance over rows < y and
   columns < x. */
struct cutter {
    const struct pbnds_envmap *map;
    double *table;
    double negligible; /* differences of the table below this are mostly rounding */
};

static double texel_solid_angle(const struct pbnds_envmap *m, int y)
{
    return 2.0 * PI / m->width * (m->cos_theta[y] - m->cos_theta[y + 1]);
}

static bool build_table(struct cutter *c, const struct pbnds_envmap *m)
{
    const size_t stride = (size_t)m->width + 1;
    c->map = m;
    c->table = calloc(stride * ((size_t)m->height + 1), sizeof *c->table);
    if (!c->table) return false;
    for (int y = 0; y < m->height; ++y) {
        const struct pbnds_vec3 *row = m->texels + (size_t)y * (size_t)m->width;
        const double *above = c->table + (size_t)y * stride;
        double *here = c->table + (size_t)(y + 1) * stride;
        const double solid_angle = texel_solid_angle(m, y);
        double sum = 0.0;
        for (int x = 0; x < m->width; ++x) {
            sum += solid_angle * (double)pbnds_luminance(row[x]);
            here[x + 1] = above[x + 1] + sum;
        }
    }
    c->negligible = 1e-9 * c->table[stride * ((size_t)m->height + 1) - 1];
    return true;
}

static double energy_by_table(const struct cutter *c, int x0, int y0, int x1, int y1)
{
    const size_t stride = (size_t)c->map->width + 1;
    const double *top = c->table + (size_t)y0 * stride;
    const double *bottom = c->table + (size_t)y1 * stride;
    return (bottom[x1] - bottom[x0]) - (top[x1] - top[x0]);
}

static double energy_by_texels(const struct cutter *c, int x0, int y0, int x1, int y1)
{
    double sum = 0.0;
    for (int y = y0; y < y1; ++y) {
        const struct pbnds_vec3 *row =
            c->map->texels + (size_t)y * (size_t)c->map->width;
        double row_sum = 0.0;
        for (int x = x0; x < x1; ++x)
            row_sum += (double)pbnds_luminance(row[x]);
        sum += row_sum * texel_solid_angle(c->map, y);
    }
    return sum;
}

/* Sides in radians; the width at the middle latitude, as Debevec weighs it. */
static double region_width(const struct pbnds_envmap *m, const struct region *r)
{
    const double middle = PI * 0.5 * (double)(r->y0 + r->y1) / m->height;
    return 2.0 * PI * (double)(r->x1 - r->x0) / m->width * sin(middle);
}
static double region_height(const struct pbnds_envmap *m, const struct region *r)
{
    return PI * (double)(r->y1 - r->y0) / m->height;
}

static struct region make_region(const struct cutter *c, int x0, int y0, int x1, int y1)
{
    struct region r = {x0, y0, x1, y1, 0.0, 0.0};
    r.energy = energy_by_table(c, x0, y0, x1, y1);
    if (r.energy < c->negligible) r.energy = energy_by_texels(c, x0, y0, x1, y1);
    if ((x1 - x0 > 1 || y1 - y0 > 1) && r.energy > 0.0)
        r.priority =
            r.energy * fmax(region_width(c->map, &r), region_height(c->map, &r));
    return r;
}

/* Cuts across the longer side where the halves are closest in energy; among equals at
   the one closest to the middle, so that a lone sun is closed in on by bisection. */
static void cut(const struct cutter *c, const struct region *r, struct region half[2])
{
    const int nx = r->x1 - r->x0, ny = r->y1 - r->y0;
    const bool across_x =
        ny == 1 || (nx > 1 && region_width(c->map, r) >= region_height(c->map, r));
    const int begin = across_x ? r->x0 : r->y0, end = across_x ? r->x1 : r->y1;
    int best = begin + 1;
    double best_score = HUGE_VAL;
    for (int i = begin + 1; i < end; ++i) {
        const double first = across_x ? energy_by_table(c, r->x0, r->y0, i, r->y1)
                                      : energy_by_table(c, r->x0, r->y0, r->x1, i);
        const double centre =
            fabs((double)(2 * i - begin - end)) / (double)(end - begin);
        const double score = fabs(2.0 * first - r->energy) + 1e-9 * r->energy * centre;
        if (!(score < best_score)) continue;
        best_score = score;
        best = i;
    }
    half[0] = across_x ? make_region(c, r->x0, r->y0, best, r->y1)
                       : make_region(c, r->x0, r->y0, r->x1, best);
    half[1] = across_x ? make_region(c, best, r->y0, r->x1, r->y1)
                       : make_region(c, r->x0, best, r->x1, r->y1);
}

/* Cuts until there are `count` regions that hold energy, or none can be cut. */
static int cut_all(const struct cutter *c, int count, struct region *regions)
{
    int n = 0;
    regions[0] = make_region(c, 0, 0, c->map->width, c->map->height);
    if (regions[0].energy > 0.0) n = 1;
    while (n > 0 && n < count) {
        int next = 0;
        for (int i = 1; i < n; ++i)
            if (regions[i].priority > regions[next].priority) next = i;
        if (!(regions[next].priority > 0.0)) break;
        struct region half[2];
        cut(c, &regions[next], half);
        if (half[0].energy > 0.0 && half[1].energy > 0.0) {
            regions[next] = half[0];
            regions[n++] = half[1];
        } else {
            regions[next] = half[0].energy > 0.0 ? half[0] : half[1];
        }
    }
    return n;
}

/* World direction at image coordinates in texels. */
static void direction_at(const struct pbnds_envmap *m, double x, double y,
                         double out[3])
{
    const double theta = PI * y / m->height;
    const double phi = 2.0 * PI * (x / m->width - m->u_offset);
    out[0] = sin(theta) * cos(phi);
    out[1] = cos(theta);
    out[2] = sin(theta) * sin(phi);
}

/* Integral of sin^2 theta over [0, theta]. */
static double sin2_integral(double theta)
{
    return 0.5 * theta - 0.25 * sin(2.0 * theta);
}

/* Power and mean direction of a region; both integrals are exact over each texel:
   int w domega = (int sin^2 dtheta int cos dphi, int sin cos dtheta int dphi, ...). */
static struct pbnds_env_light light_of(const struct pbnds_envmap *m,
                                       const struct region *r)
{
    const double dphi = 2.0 * PI / m->width;
    /* int cos phi over a texel = cos(centre) * chord */
    const double chord = 2.0 * sin(0.5 * dphi);
    double power[3] = {0.0, 0.0, 0.0}, mean[3] = {0.0, 0.0, 0.0};
    for (int y = r->y0; y < r->y1; ++y) {
        const struct pbnds_vec3 *row = m->texels + (size_t)y * (size_t)m->width;
        double sum[3] = {0.0, 0.0, 0.0}, flat[2] = {0.0, 0.0}, luminance = 0.0;
        /* cos and sin of the column centres, by rotation */
        double c = cos(2.0 * PI * ((r->x0 + 0.5) / m->width - m->u_offset));
        double s = sin(2.0 * PI * ((r->x0 + 0.5) / m->width - m->u_offset));
        const double turn_c = cos(dphi), turn_s = sin(dphi);
        for (int x = r->x0; x < r->x1; ++x) {
            const double l = (double)pbnds_luminance(row[x]);
            sum[0] += (double)row[x].x;
            sum[1] += (double)row[x].y;
            sum[2] += (double)row[x].z;
            luminance += l;
            flat[0] += l * c;
            flat[1] += l * s;
            const double turned = c * turn_c - s * turn_s;
            s = s * turn_c + c * turn_s;
            c = turned;
        }
        const double theta0 = PI * y / m->height, theta1 = PI * (y + 1) / m->height;
        const double solid_angle = texel_solid_angle(m, y);
        const double level = sin2_integral(theta1) - sin2_integral(theta0);
        const double lift = m->cos_theta[y] + m->cos_theta[y + 1]; /* 2 x mean cos */
        for (int i = 0; i < 3; ++i)
            power[i] += sum[i] * solid_angle;
        mean[0] += flat[0] * chord * level;
        mean[1] += luminance * solid_angle * 0.5 * lift;
        mean[2] += flat[1] * chord * level;
    }
    double length = sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]);
    if (length < 1e-3 * r->energy) { /* the light cancels: take the region's centre */
        direction_at(m, 0.5 * (r->x0 + r->x1), 0.5 * (r->y0 + r->y1), mean);
        length = 1.0;
    }
    struct pbnds_env_light light;
    light.wi = pbnds_vec3_make((float)(mean[0] / length), (float)(mean[1] / length),
                               (float)(mean[2] / length));
    light.power = pbnds_vec3_make((float)power[0], (float)power[1], (float)power[2]);
    return light;
}

int pbnds_envmap_cluster(const struct pbnds_envmap *envmap, int count,
                         struct pbnds_env_light *lights)
{
    if (count < 1 || !(envmap->pdf_scale > 0.0f)) return 0;
    const size_t texels = (size_t)envmap->width * (size_t)envmap->height;
    if ((size_t)count > texels) count = (int)texels;
    struct cutter cutter = {0};
    struct region *regions = malloc((size_t)count * sizeof *regions);
    int n = 0;
    if (regions && build_table(&cutter, envmap)) {
        n = cut_all(&cutter, count, regions);
        for (int i = 0; i < n; ++i)
            lights[i] = light_of(envmap, &regions[i]);
    } else { /* no memory to cut in: one light still carries all the power */
        struct region whole = {0, 0, envmap->width, envmap->height, 0.0, 0.0};
        whole.energy = 4.0 * PI * (double)pbnds_luminance(envmap->mean);
        lights[0] = light_of(envmap, &whole);
        n = 1;
    }
    free(cutter.table);
    free(regions);
    return n;
}
