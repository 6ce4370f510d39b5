/* A colour map for error images in the manner of magma: a path through CIE L*a*b* from
   black over violet and orange to cream. Lightness only rises, so that the order
   survives in grey, and equal steps of the value are equal steps along the path, so
   that they look alike. */
#include <math.h>
#include <stddef.h>

#include "engine/core/color.h"
#include "neural/metrics/cielab.h"
#include "neural/metrics/metrics.h"

enum { ANCHORS = 6, STEPS = 256, FINE = 64 };

/* L*, a*, b*: black, indigo, violet, raspberry, orange, cream. All are colours of sRGB.
 */
static const double PATH[ANCHORS][3] = {
    {0.0, 0.0, 0.0},    {18.0, 25.0, -30.0}, {38.0, 51.0, -24.0},
    {57.0, 57.0, 14.0}, {77.0, 17.0, 40.0},  {96.0, -4.0, 19.0},
};

/* Catmull-Rom through the anchors; t in [0, ANCHORS - 1]. */
static void path_at(double t, double lab[3])
{
    int i = (int)t;
    if (i > ANCHORS - 2) i = ANCHORS - 2;
    const double s = t - i;
    const double *p1 = PATH[i], *p2 = PATH[i + 1];
    for (int c = 0; c < 3; ++c) {
        /* at the ends the line is continued */
        const double p0 = i > 0 ? PATH[i - 1][c] : 2.0 * p1[c] - p2[c];
        const double p3 = i + 2 < ANCHORS ? PATH[i + 2][c] : 2.0 * p2[c] - p1[c];
        lab[c] = p1[c] + 0.5 * s *
                             (p2[c] - p0 +
                              s * (2.0 * p0 - 5.0 * p1[c] + 4.0 * p2[c] - p3 +
                                   s * (3.0 * (p1[c] - p2[c]) + p3 - p0)));
    }
}

static double lab_unroot(double f)
{
    return f > 6.0 / 29.0 ? f * f * f : (f - 4.0 / 29.0) * (108.0 / 841.0);
}

static void display_of_lab(const double lab[3], double inverse[3][3], float rgb[3])
{
    const double fy = (lab[0] + 16.0) / 116.0;
    const double xyz[3] = {lab_unroot(fy + lab[1] / 500.0), lab_unroot(fy),
                           lab_unroot(fy - lab[2] / 200.0)};
    for (int c = 0; c < 3; ++c)
        rgb[c] =
            pbnds_srgb_encode((float)(inverse[c][0] * xyz[0] + inverse[c][1] * xyz[1] +
                                      inverse[c][2] * xyz[2]));
}

/* table[i] is the colour at i / STEPS of the path's length. */
static void build_table(float table[STEPS + 1][3])
{
    enum { N = (ANCHORS - 1) * FINE };
    double length[N + 1], before[3], here[3], inverse[3][3];
    pbnds_rgb_from_xyz(inverse);
    length[0] = 0.0;
    path_at(0.0, before);
    for (int i = 1; i <= N; ++i) {
        path_at((double)i / FINE, here);
        double square = 0.0;
        for (int c = 0; c < 3; ++c) {
            square += (here[c] - before[c]) * (here[c] - before[c]);
            before[c] = here[c];
        }
        length[i] = length[i - 1] + sqrt(square);
    }
    int i = 0;
    for (int k = 0; k <= STEPS; ++k) {
        const double wanted = length[N] * k / STEPS;
        while (i < N - 1 && length[i + 1] < wanted)
            ++i;
        const double s = (wanted - length[i]) / (length[i + 1] - length[i]);
        path_at((i + s) / FINE, here);
        display_of_lab(here, inverse, table[k]);
    }
}

enum pbnds_status pbnds_colorize(const struct pbnds_image *map,
                                 struct pbnds_image *image, struct pbnds_error *error)
{
    *image = (struct pbnds_image){0};
    if (!map->data || map->channels != 1)
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "colour map: the image has %d channels; give one of 1 channel",
            map->channels);
    PBNDS_TRY(pbnds_image_init(image, map->width, map->height, 3, error));
    float table[STEPS + 1][3];
    build_table(table);
    const size_t n = (size_t)map->width * (size_t)map->height;
    for (size_t i = 0; i < n; ++i) {
        const float x = map->data[i];
        const float t = x > 0.0f ? fminf(x, 1.0f) * STEPS : 0.0f; /* NaN is black */
        const int k = t < STEPS ? (int)t : STEPS - 1;
        for (int c = 0; c < 3; ++c)
            image->data[3 * i + (size_t)c] =
                table[k][c] + (t - (float)k) * (table[k + 1][c] - table[k][c]);
    }
    return PBNDS_OK;
}
