/* The camera of a foreign G-buffer; the equations are in import.h. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "engine/shade/import.h"

void pbnds_import_note(struct pbnds_import_notes *notes, const char *format, ...)
{
    const int room = (int)(sizeof notes->text / sizeof notes->text[0]);
    if (notes->count >= room) return;
    va_list arguments;
    va_start(arguments, format);
    char *text = notes->text[notes->count++];
    vsnprintf(text, sizeof notes->text[0], format, arguments);
    va_end(arguments);
}

struct pbnds_camera pbnds_import_camera(const struct pbnds_import_options *options)
{
    const struct pbnds_vec3 zero = {0.0f, 0.0f, 0.0f};
    const float degree = PBNDS_PI / 180.0f;
    struct pbnds_camera camera = pbnds_camera_framing(
        zero, zero, options->look_given ? options->yaw / degree : 0.0f,
        options->look_given ? options->pitch / degree : 0.0f, 40.0f, 1.0f);
    memset(camera.name, 0, sizeof camera.name);
    memcpy(camera.name, "imported", sizeof "imported");
    for (int i = 12; i < 15; ++i)
        camera.world_from_camera.m[i] = 0.0f;
    camera.yfov = options->yfov > 0.0f ? options->yfov : 40.0f * degree;
    camera.ymag = 1.0f;
    return camera;
}

/* The points of an image, whose pixel positions are counted in half heights. */
struct points {
    const float *const *position;
    const float *depth;
    int width, height;
};

enum { TERMS = 4 };

/* Solution of the least squares: one 3-vector a term. */
struct solution {
    double v[TERMS][3];
    bool ok;
};

static double side_x(const struct points *p, size_t i)
{
    const double x = (double)(i % (size_t)p->width) + 0.5;
    return (x - 0.5 * p->width) / (0.5 * p->height);
}

static double side_y(const struct points *p, size_t i)
{
    const double y = (double)(i / (size_t)p->width) + 0.5;
    return (0.5 * p->height - y) / (0.5 * p->height);
}

/* The factors of eye, a, b and c at a pixel. */
static bool factors(const struct points *p, bool orthographic, size_t i,
                    double f[TERMS])
{
    const double d = (double)p->depth[i];
    if (!isfinite(d)) return false;
    for (int c = 0; c < 3; ++c) {
        if (!isfinite(p->position[c][i])) return false;
    }
    const double scale = orthographic ? 1.0 : d;
    f[0] = 1.0;
    f[1] = scale * side_x(p, i);
    f[2] = scale * side_y(p, i);
    f[3] = d;
    return true;
}

/* Gauss elimination with pivoting on the normal equations, whose diagonal is scaled to 1
 * first. A pivot that vanishes beside it means that the points do not say. */
static bool solve(double m[TERMS][TERMS + 3], struct solution *s)
{
    double unit[TERMS];
    for (int r = 0; r < TERMS; ++r) {
        if (!(m[r][r] > 0.0)) return false;
        unit[r] = 1.0 / sqrt(m[r][r]);
    }
    for (int r = 0; r < TERMS; ++r) {
        for (int c = 0; c < TERMS + 3; ++c)
            m[r][c] *= unit[r] * (c < TERMS ? unit[c] : 1.0);
    }
    for (int k = 0; k < TERMS; ++k) {
        int best = k;
        for (int r = k + 1; r < TERMS; ++r) {
            if (fabs(m[r][k]) > fabs(m[best][k])) best = r;
        }
        if (fabs(m[best][k]) < 1e-9) return false;
        for (int c = 0; c < TERMS + 3; ++c) {
            const double kept = m[k][c];
            m[k][c] = m[best][c];
            m[best][c] = kept;
        }
        for (int r = 0; r < TERMS; ++r) {
            const double by = r == k ? 0.0 : m[r][k] / m[k][k];
            for (int c = k; c < TERMS + 3; ++c)
                m[r][c] -= by * m[k][c];
        }
    }
    for (int k = 0; k < TERMS; ++k) {
        for (int c = 0; c < 3; ++c)
            s->v[k][c] = unit[k] * m[k][TERMS + c] / m[k][k];
    }
    return true;
}

static struct solution fit(const struct points *p, bool orthographic)
{
    double m[TERMS][TERMS + 3], f[TERMS];
    struct solution s = {.ok = false};
    memset(m, 0, sizeof m);
    const size_t count = (size_t)p->width * (size_t)p->height;
    size_t used = 0;
    for (size_t i = 0; i < count; ++i) {
        if (!factors(p, orthographic, i, f)) continue;
        ++used;
        for (int r = 0; r < TERMS; ++r) {
            for (int c = 0; c < TERMS; ++c)
                m[r][c] += f[r] * f[c];
            for (int c = 0; c < 3; ++c)
                m[r][TERMS + c] += f[r] * (double)p->position[c][i];
        }
    }
    s.ok = used >= 16 && solve(m, &s);
    return s;
}

/* Mean square of what the solution leaves, in metres over the side of a pixel there. */
static double residual(const struct points *p, bool orthographic,
                       const struct solution *s)
{
    const size_t count = (size_t)p->width * (size_t)p->height;
    double sum = 0.0, f[TERMS], used = 0.0, pixel = 0.0;
    for (int c = 0; c < 3; ++c)
        pixel += s->v[1][c] * s->v[1][c];
    pixel = sqrt(pixel) / (0.5 * p->height);
    for (size_t i = 0; i < count; ++i) {
        if (!factors(p, orthographic, i, f)) continue;
        const double side = pixel * (orthographic ? 1.0 : f[3]);
        for (int c = 0; c < 3; ++c) {
            double off = (double)p->position[c][i];
            for (int k = 0; k < TERMS; ++k)
                off -= f[k] * s->v[k][c];
            sum += off * off / (side * side);
        }
        used += 1.0;
    }
    return sum / used;
}

static double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A camera of ours looks along -(right x up), has square pixels and a centred lens. */
static bool is_straight(const struct solution *s)
{
    const double *a = s->v[1], *b = s->v[2], *c = s->v[3];
    const double la = sqrt(dot3(a, a)), lb = sqrt(dot3(b, b)), lc = sqrt(dot3(c, c));
    return fabs(la / lb - 1.0) < 0.02 && fabs(dot3(a, b)) < 0.02 * la * lb &&
           fabs(lc - 1.0) < 0.05 && fabs(dot3(a, c)) < 0.02 * la &&
           fabs(dot3(b, c)) < 0.02 * lb;
}

static void to_camera(const struct solution *s, bool orthographic,
                      struct pbnds_camera *camera)
{
    const double *a = s->v[1], *b = s->v[2];
    const double la = sqrt(dot3(a, a)), lb = sqrt(dot3(b, b));
    double x[3], y[3], z[3];
    for (int c = 0; c < 3; ++c)
        x[c] = a[c] / la;
    const double along = dot3(b, x);
    for (int c = 0; c < 3; ++c)
        y[c] = b[c] - along * x[c];
    const double ly = sqrt(dot3(y, y));
    for (int c = 0; c < 3; ++c)
        y[c] /= ly;
    for (int c = 0; c < 3; ++c)
        z[c] = x[(c + 1) % 3] * y[(c + 2) % 3] - x[(c + 2) % 3] * y[(c + 1) % 3];
    float *m = camera->world_from_camera.m;
    for (int c = 0; c < 3; ++c) {
        m[c] = (float)x[c];
        m[4 + c] = (float)y[c];
        m[8 + c] = (float)z[c];
        m[12 + c] = (float)s->v[0][c];
    }
    camera->orthographic = orthographic;
    if (orthographic) {
        camera->ymag = (float)(0.5 * (la + lb));
    } else {
        camera->yfov = (float)(2.0 * atan(0.5 * (la + lb)));
    }
}

enum pbnds_camera_fit pbnds_import_fit_camera(const float *const position[3],
                                              const float *depth, int width, int height,
                                              struct pbnds_camera *camera, float *off)
{
    const struct points p = {position, depth, width, height};
    const struct solution wide = fit(&p, false), flat = fit(&p, true);
    if (!wide.ok && !flat.ok) return PBNDS_FIT_UNKNOWN;
    const double wide_off = wide.ok ? residual(&p, false, &wide) : (double)INFINITY;
    const double flat_off = flat.ok ? residual(&p, true, &flat) : (double)INFINITY;
    const bool orthographic = flat_off < wide_off;
    const struct solution *s = orthographic ? &flat : &wide;
    *off = (float)sqrt(orthographic ? flat_off : wide_off);
    /* Jitter alone stays well below a pixel; more is another kind of camera. */
    if (!is_straight(s) || !(*off < 2.0f)) return PBNDS_FIT_SKEWED;
    if (!(dot3(s->v[0], s->v[0]) < 1e30)) return PBNDS_FIT_UNKNOWN;
    to_camera(s, orthographic, camera);
    return PBNDS_FIT_DONE;
}
