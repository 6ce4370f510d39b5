/* LDR-FLIP: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and Fairchild 2020,
   "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM Comput. Graph.
   Interact. Tech. 3(2). What the eye sees of a colour at 67 pixels a degree (3840
   pixels on 0.7 m, from 0.7 m away) is compared, and the error raised where edges or
   points appear or vanish. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/color.h"
#include "engine/core/parallel.h"
#include "engine/core/report.h"
#include "neural/metrics/cielab.h"
#include "neural/metrics/metrics.h"

static const double PI = 3.14159265358979323846;
static const double PIXELS_PER_DEGREE = 67.0;

/* The paper's q_c, p_c, p_t, w and q_f. */
static const double COLOR_EXPONENT = 0.7;
static const double COLOR_KNEE = 0.4, COLOR_KNEE_ERROR = 0.95;
static const double FEATURE_WIDTH_DEGREES = 0.082;
static const float FEATURE_EXPONENT = 0.5f;

enum { RADIUS_MAX = 10, TAPS_MAX = 2 * RADIUS_MAX + 1 };

/* One axis of a separable filter. */
struct taps {
    int radius;
    float weight[TAPS_MAX]; /* at offset -radius ... radius */
};

/* Contrast sensitivity of the eye, per channel a sum of two Gaussians,
   g(x) = sum_i a_i sqrt(pi / b_i) exp(-pi^2 x^2 / b_i), x in degrees. */
static const struct {
    double a[2], b[2];
} SENSITIVITY[3] = {
    {{1.0, 0.0}, {0.0047, 1e-5}},  /* achromatic  */
    {{1.0, 0.0}, {0.0053, 1e-5}},  /* red-green   */
    {{34.1, 13.5}, {0.04, 0.025}}, /* blue-yellow */
};

enum { LAB_L, LAB_A, LAB_B, EDGE, POINT, IMAGE_PLANES };

/* All that is computed once or held between the passes over rows. */
struct flip {
    int width, height;
    struct taps sensitivity[3][2];
    int terms[3];                    /* Gaussians of each channel */
    struct taps smooth, edge, point; /* of the feature detectors */
    float rgb_from_xyz[3][3];
    float color_max;
    const struct pbnds_image *image; /* the one being prepared               */
    float *opponent[3];              /* its Y, Cx, Cz                        */
    float *across[3];                /* filtered along rows, not yet columns */
    float *planes[2][IMAGE_PLANES];  /* of test and reference                */
    float *scratch;                  /* 4 rows for each thread               */
    float *map;
    int which, channel, term; /* what the running pass works on       */
};

/* ----------------------------------------------------------------- filters */

static void build_sensitivity(struct flip *f)
{
    double widest = 0.0;
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 2; ++i)
            widest = fmax(widest, SENSITIVITY[c].b[i]);
    /* three standard deviations of the widest: 10 pixels */
    const int reach =
        (int)ceil(3.0 * sqrt(widest / (2.0 * PI * PI)) * PIXELS_PER_DEGREE);
    for (int c = 0; c < 3; ++c) {
        double axis[2][TAPS_MAX], scale[2], total = 0.0;
        f->terms[c] = SENSITIVITY[c].a[1] > 0.0 ? 2 : 1;
        for (int i = 0; i < f->terms[c]; ++i) {
            const double b = SENSITIVITY[c].b[i];
            double sum = 0.0;
            for (int t = 0; t <= 2 * reach; ++t) {
                const double x = (double)(t - reach) / PIXELS_PER_DEGREE;
                axis[i][t] = exp(-PI * PI * x * x / b);
                sum += axis[i][t];
            }
            scale[i] = SENSITIVITY[c].a[i] * sqrt(PI / b);
            total += scale[i] * sum * sum;
        }
        for (int i = 0; i < f->terms[c]; ++i) {
            /* taps too small for float to see are left out */
            int radius = reach;
            while (radius > 0 && axis[i][reach + radius] < 1e-10)
                --radius;
            f->sensitivity[c][i].radius = radius;
            for (int t = -radius; t <= radius; ++t)
                f->sensitivity[c][i].weight[t + radius] =
                    (float)(axis[i][reach + t] * sqrt(scale[i] / total));
        }
    }
}

/* Positive weights sum to 1, negative ones to -1; the sign depends on one axis only, so
   the detector stays separable. */
static void balance(struct taps *taps, const double *weight)
{
    double positive = 0.0, negative = 0.0;
    for (int t = 0; t <= 2 * taps->radius; ++t) {
        positive += fmax(weight[t], 0.0);
        negative -= fmin(weight[t], 0.0);
    }
    for (int t = 0; t <= 2 * taps->radius; ++t)
        taps->weight[t] = (float)(weight[t] / (weight[t] < 0.0 ? negative : positive));
}

/* First and second derivatives of a Gaussian as wide as the eye's edges.
 */
static void build_detectors(struct flip *f)
{
    const double deviation = 0.5 * FEATURE_WIDTH_DEGREES * PIXELS_PER_DEGREE;
    const int radius = (int)ceil(3.0 * deviation);
    double smooth[TAPS_MAX], edge[TAPS_MAX], point[TAPS_MAX], total = 0.0;
    for (int t = 0; t <= 2 * radius; ++t) {
        const double x = (double)(t - radius) / deviation;
        const double g = exp(-0.5 * x * x);
        smooth[t] = g;
        edge[t] = -x * g;
        point[t] = (x * x - 1.0) * g;
        total += g;
    }
    f->smooth.radius = f->edge.radius = f->point.radius = radius;
    for (int t = 0; t <= 2 * radius; ++t)
        f->smooth.weight[t] = (float)(smooth[t] / total);
    balance(&f->edge, edge);
    balance(&f->point, point);
}

/* dst[x] += weight * src[x + shift], the border repeated outwards. */
static void add_shifted(float *restrict dst, const float *restrict src, int n,
                        int shift, float weight)
{
    const int begin = shift < 0 ? (-shift < n ? -shift : n) : 0;
    const int end = shift > 0 ? (n - shift > 0 ? n - shift : 0) : n;
    for (int x = 0; x < begin; ++x)
        dst[x] += weight * src[0];
    for (int x = begin; x < end; ++x)
        dst[x] += weight * src[x + shift];
    for (int x = end; x < n; ++x)
        dst[x] += weight * src[n - 1];
}

static void filter_across(const struct taps *taps, const float *src, float *dst,
                          int width)
{
    memset(dst, 0, (size_t)width * sizeof *dst);
    for (int t = -taps->radius; t <= taps->radius; ++t)
        add_shifted(dst, src, width, t, taps->weight[t + taps->radius]);
}

/* Adds row y of the plane, filtered down its columns, to dst. */
static void add_down(const struct taps *taps, const float *plane, int width, int height,
                     int y, float *dst)
{
    for (int t = -taps->radius; t <= taps->radius; ++t) {
        const int row = y + t < 0 ? 0 : y + t < height ? y + t : height - 1;
        add_shifted(dst, plane + (size_t)row * (size_t)width, width, 0,
                    taps->weight[t + taps->radius]);
    }
}

/* --------------------------------------------------------- passes over rows */

/* Display sRGB to linear to the opponent space YCxCz. */
static void pass_opponent(void *context, size_t y, int thread)
{
    struct flip *f = context;
    (void)thread;
    const size_t offset = y * (size_t)f->width;
    for (int x = 0; x < f->width; ++x) {
        const float *p = f->image->data + 3 * (offset + (size_t)x);
        float rgb[3], xyz[3];
        for (int c = 0; c < 3; ++c)
            rgb[c] = pbnds_srgb_decode(fminf(fmaxf(p[c], 0.0f), 1.0f));
        for (int c = 0; c < 3; ++c)
            xyz[c] = (float)PBNDS_XYZ_FROM_RGB[c][0] * rgb[0] +
                     (float)PBNDS_XYZ_FROM_RGB[c][1] * rgb[1] +
                     (float)PBNDS_XYZ_FROM_RGB[c][2] * rgb[2];
        f->opponent[0][offset + (size_t)x] = 116.0f * xyz[1] - 16.0f;
        f->opponent[1][offset + (size_t)x] = 500.0f * (xyz[0] - xyz[1]);
        f->opponent[2][offset + (size_t)x] = 200.0f * (xyz[1] - xyz[2]);
    }
}

static void pass_sensitivity_across(void *context, size_t y, int thread)
{
    struct flip *f = context;
    (void)thread;
    const size_t offset = y * (size_t)f->width;
    filter_across(&f->sensitivity[f->channel][f->term],
                  f->opponent[f->channel] + offset, f->across[0] + offset, f->width);
}

static void pass_sensitivity_down(void *context, size_t y, int thread)
{
    struct flip *f = context;
    (void)thread;
    float *dst = f->planes[f->which][f->channel] + y * (size_t)f->width;
    if (f->term == 0) memset(dst, 0, (size_t)f->width * sizeof *dst);
    add_down(&f->sensitivity[f->channel][f->term], f->across[0], f->width, f->height,
             (int)y, dst);
}

/* L*a*b* with the Hunt effect: colour differences matter less in the
 * dark. */
static void hunt_lab(const float rgb[3], float lab[3])
{
    float root[3];
    for (int c = 0; c < 3; ++c)
        root[c] = pbnds_lab_root((float)PBNDS_XYZ_FROM_RGB[c][0] * rgb[0] +
                                 (float)PBNDS_XYZ_FROM_RGB[c][1] * rgb[1] +
                                 (float)PBNDS_XYZ_FROM_RGB[c][2] * rgb[2]);
    lab[0] = 116.0f * root[1] - 16.0f;
    lab[1] = 0.01f * lab[0] * 500.0f * (root[0] - root[1]);
    lab[2] = 0.01f * lab[0] * 200.0f * (root[1] - root[2]);
}

/* Filtered YCxCz back to linear colour, what a display can show of it, and to L*a*b*.
 */
static void pass_lab(void *context, size_t y, int thread)
{
    struct flip *f = context;
    (void)thread;
    float **planes = f->planes[f->which];
    for (size_t i = y * (size_t)f->width; i < (y + 1) * (size_t)f->width; ++i) {
        float xyz[3], rgb[3], lab[3];
        xyz[1] = (planes[LAB_L][i] + 16.0f) / 116.0f;
        xyz[0] = xyz[1] + planes[LAB_A][i] / 500.0f;
        xyz[2] = xyz[1] - planes[LAB_B][i] / 200.0f;
        for (int c = 0; c < 3; ++c) {
            const float *m = f->rgb_from_xyz[c];
            const float linear = m[0] * xyz[0] + m[1] * xyz[1] + m[2] * xyz[2];
            rgb[c] = fminf(fmaxf(linear, 0.0f), 1.0f);
        }
        hunt_lab(rgb, lab);
        planes[LAB_L][i] = lab[0];
        planes[LAB_A][i] = lab[1];
        planes[LAB_B][i] = lab[2];
    }
}

/* Features are looked for in the unfiltered luminance, scaled to [0, 1]. */
static void pass_features_across(void *context, size_t y, int thread)
{
    struct flip *f = context;
    const size_t offset = y * (size_t)f->width;
    float *luminance = f->scratch + (size_t)thread * 4 * (size_t)f->width;
    for (int x = 0; x < f->width; ++x)
        luminance[x] = (f->opponent[0][offset + (size_t)x] + 16.0f) / 116.0f;
    filter_across(&f->smooth, luminance, f->across[0] + offset, f->width);
    filter_across(&f->edge, luminance, f->across[1] + offset, f->width);
    filter_across(&f->point, luminance, f->across[2] + offset, f->width);
}

static void pass_features_down(void *context, size_t y, int thread)
{
    struct flip *f = context;
    const int w = f->width, h = f->height, row = (int)y;
    float *edge_x = f->scratch + (size_t)thread * 4 * (size_t)w;
    float *edge_y = edge_x + w, *point_x = edge_y + w, *point_y = point_x + w;
    memset(edge_x, 0, 4 * (size_t)w * sizeof *edge_x);
    add_down(&f->smooth, f->across[1], w, h, row, edge_x);
    add_down(&f->edge, f->across[0], w, h, row, edge_y);
    add_down(&f->smooth, f->across[2], w, h, row, point_x);
    add_down(&f->point, f->across[0], w, h, row, point_y);
    float *edge = f->planes[f->which][EDGE] + y * (size_t)w;
    float *point = f->planes[f->which][POINT] + y * (size_t)w;
    for (int x = 0; x < w; ++x) {
        edge[x] = sqrtf(edge_x[x] * edge_x[x] + edge_y[x] * edge_y[x]);
        point[x] = sqrtf(point_x[x] * point_x[x] + point_y[x] * point_y[x]);
    }
}

/* HyAB distance (city block in lightness, Euclidean in chroma), raised to q_c. */
static float color_distance(float dl, float da, float db)
{
    return powf(fabsf(dl) + sqrtf(da * da + db * db), (float)COLOR_EXPONENT);
}

/* [0, p_c c_max] takes up [0, p_t] of the error, the rest what remains.
 */
static float redistribute(float distance, float color_max)
{
    const float knee = (float)COLOR_KNEE * color_max, at_knee = (float)COLOR_KNEE_ERROR;
    if (distance < knee) return at_knee / knee * distance;
    return at_knee + (distance - knee) / (color_max - knee) * (1.0f - at_knee);
}

/* The colour error, amplified by the difference in edges and points. */
static void pass_combine(void *context, size_t y, int thread)
{
    struct flip *f = context;
    (void)thread;
    float **a = f->planes[0], **b = f->planes[1];
    for (size_t i = y * (size_t)f->width; i < (y + 1) * (size_t)f->width; ++i) {
        const float distance =
            color_distance(a[LAB_L][i] - b[LAB_L][i], a[LAB_A][i] - b[LAB_A][i],
                           a[LAB_B][i] - b[LAB_B][i]);
        const float color = fminf(redistribute(distance, f->color_max), 1.0f);
        const float difference =
            fmaxf(fabsf(a[EDGE][i] - b[EDGE][i]), fabsf(a[POINT][i] - b[POINT][i]));
        const float feature =
            fminf(powf(difference * 0.70710678f, FEATURE_EXPONENT), 1.0f);
        f->map[i] = powf(color, 1.0f - feature);
    }
}

/* -------------------------------------------------------------------- order */

static void prepare(struct flip *f, const struct pbnds_image *image, int which)
{
    const size_t rows = (size_t)f->height;
    f->image = image;
    f->which = which;
    pbnds_parallel_for(rows, pass_opponent, f);
    for (f->channel = 0; f->channel < 3; ++f->channel)
        for (f->term = 0; f->term < f->terms[f->channel]; ++f->term) {
            pbnds_parallel_for(rows, pass_sensitivity_across, f);
            pbnds_parallel_for(rows, pass_sensitivity_down, f);
        }
    pbnds_parallel_for(rows, pass_lab, f);
    pbnds_parallel_for(rows, pass_features_across, f);
    pbnds_parallel_for(rows, pass_features_down, f);
}

/* c_max: green against blue is the largest distance of the colour cube.
 */
static float largest_distance(void)
{
    static const float green_rgb[3] = {0.0f, 1.0f, 0.0f},
                       blue_rgb[3] = {0.0f, 0.0f, 1.0f};
    float green[3], blue[3];
    hunt_lab(green_rgb, green);
    hunt_lab(blue_rgb, blue);
    return color_distance(green[0] - blue[0], green[1] - blue[1], green[2] - blue[2]);
}

/* One block for all planes. @return it, or NULL */
static float *allocate(struct flip *f)
{
    const size_t n = (size_t)f->width * (size_t)f->height;
    const size_t planes = 3 + 3 + 2 * IMAGE_PLANES;
    const size_t scratch = (size_t)pbnds_threads() * 4 * (size_t)f->width;
    float *block = malloc((planes * n + scratch) * sizeof *block);
    if (!block) return NULL;
    float *next = block;
    for (int i = 0; i < 3; ++i, next += n)
        f->opponent[i] = next;
    for (int i = 0; i < 3; ++i, next += n)
        f->across[i] = next;
    for (int i = 0; i < 2 * IMAGE_PLANES; ++i, next += n)
        f->planes[i / IMAGE_PLANES][i % IMAGE_PLANES] = next;
    f->scratch = next;
    return block;
}

static enum pbnds_status check(const struct pbnds_image *test,
                               const struct pbnds_image *reference,
                               struct pbnds_error *error)
{
    if (!test->data || !reference->data || test->channels != 3 ||
        reference->channels != 3 || test->width != reference->width ||
        test->height != reference->height)
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "FLIP: images of %d x %d x %d and %d x %d x %d; give two of the "
            "same size with 3 channels",
            test->width, test->height, test->channels, reference->width,
            reference->height, reference->channels);
    const size_t n = 3 * (size_t)test->width * (size_t)test->height;
    for (size_t i = 0; i < n; ++i)
        if (!isfinite(test->data[i]) || !isfinite(reference->data[i]))
            return pbnds_fail(
                error, PBNDS_ERROR_FORMAT,
                "FLIP: pixel %zu, %zu is not a finite number; display images "
                "are in [0, 1]",
                i / 3 % (size_t)test->width, i / 3 / (size_t)test->width);
    return PBNDS_OK;
}

enum pbnds_status pbnds_flip(const struct pbnds_image *test,
                             const struct pbnds_image *reference,
                             struct pbnds_image *map, struct pbnds_error *error)
{
    *map = (struct pbnds_image){0};
    PBNDS_TRY(check(test, reference, error));
    struct flip f = {.width = test->width, .height = test->height};
    PBNDS_TRY(pbnds_image_init(map, f.width, f.height, 1, error));
    float *block = allocate(&f);
    if (!block) {
        pbnds_image_free(map);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "FLIP: no memory for %d x %d pixels; compare smaller images",
                          f.width, f.height);
    }
    double inverse[3][3];
    pbnds_rgb_from_xyz(inverse);
    for (int i = 0; i < 9; ++i)
        f.rgb_from_xyz[i / 3][i % 3] = (float)inverse[i / 3][i % 3];
    build_sensitivity(&f);
    build_detectors(&f);
    f.color_max = largest_distance();
    f.map = map->data;
    prepare(&f, test, 0);
    prepare(&f, reference, 1);
    pbnds_parallel_for((size_t)f.height, pass_combine, &f);
    free(block);
    if (!pbnds_stop_requested()) return PBNDS_OK;
    pbnds_image_free(map);
    return pbnds_fail_interrupted(error);
}
