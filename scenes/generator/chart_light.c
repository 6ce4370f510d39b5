/* The chart's light map: six coloured directions with their names. */
#include <math.h>

#include "scenes/generator/chart.h"

/* Strokes of the glyphs, in a box of 1 x 2 about the origin: x0 y0 x1 y1. */
struct stroke {
    float x0, y0, x1, y1;
};

static const struct stroke glyph_x[] = {{-0.5f, -1, 0.5f, 1}, {-0.5f, 1, 0.5f, -1}};
static const struct stroke glyph_y[] = {
    {-0.5f, 1, 0, 0}, {0.5f, 1, 0, 0}, {0, 0, 0, -1}};
static const struct stroke glyph_z[] = {
    {-0.5f, 1, 0.5f, 1}, {0.5f, 1, -0.5f, -1}, {-0.5f, -1, 0.5f, -1}};
static const struct stroke glyph_plus[] = {{-0.5f, 0, 0.5f, 0}, {0, -0.5f, 0, 0.5f}};
static const struct stroke glyph_minus[] = {{-0.5f, 0, 0.5f, 0}};

struct glyph {
    const struct stroke *strokes;
    int count;
};

static const struct glyph axes[] = {{glyph_x, 2}, {glyph_y, 3}, {glyph_z, 3}};
static const struct glyph signs[] = {{glyph_plus, 2}, {glyph_minus, 1}};

static const float colors[2][3][3] = {
    {{1.0f, 0.1f, 0.1f}, {0.1f, 1.0f, 0.1f}, {0.1f, 0.1f, 1.0f}},
    {{0.1f, 1.0f, 1.0f}, {1.0f, 0.1f, 1.0f}, {1.0f, 1.0f, 0.1f}},
};

static float distance_to(const struct stroke *s, float x, float y)
{
    const float dx = s->x1 - s->x0, dy = s->y1 - s->y0;
    const float t = pbnds_clamp(
        ((x - s->x0) * dx + (y - s->y0) * dy) / (dx * dx + dy * dy), 0.0f, 1.0f);
    return hypotf(x - s->x0 - t * dx, y - s->y0 - t * dy);
}

/* x, y in glyph heights from its middle; the box is 1 wide and 2 high. */
static bool on_glyph(const struct glyph *g, float x, float y)
{
    for (int i = 0; i < g->count; ++i)
        if (distance_to(&g->strokes[i], x, y) < 0.16f) return true;
    return false;
}

/* Right and up as seen from the middle of the cube, looking at the face. */
static void face_frame(int axis, int sign, struct pbnds_vec3 *right,
                       struct pbnds_vec3 *up)
{
    const float s = sign ? -1.0f : 1.0f;
    *up = pbnds_vec3_make(0.0f, 1.0f, 0.0f);
    if (axis == 0) *right = pbnds_vec3_make(0.0f, 0.0f, s);
    if (axis == 2) *right = pbnds_vec3_make(-s, 0.0f, 0.0f);
    if (axis == 1) {
        *right = pbnds_vec3_make(1.0f, 0.0f, 0.0f);
        *up = pbnds_vec3_make(0.0f, 0.0f, s);
    }
}

static void radiance(struct pbnds_vec3 w, float *rgb)
{
    const float c[3] = {w.x, w.y, w.z};
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (fabsf(c[i]) > fabsf(c[axis])) axis = i;
    const int sign = c[axis] < 0.0f;
    struct pbnds_vec3 right, up;
    face_frame(axis, sign, &right, &up);
    const float x = pbnds_dot(w, right) / fabsf(c[axis]) / 0.3f,
                y = pbnds_dot(w, up) / fabsf(c[axis]) / 0.3f;
    const bool label =
        on_glyph(&signs[sign], x + 0.8f, y) || on_glyph(&axes[axis], x - 0.6f, y);
    for (int i = 0; i < 3; ++i)
        rgb[i] = label ? 2.0f : colors[sign][axis][i];
}

void gen_chart_light(int width, int height, float *rgb)
{
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float u = ((float)x + 0.5f) / (float)width,
                        v = ((float)y + 0.5f) / (float)height;
            const float phi = (u - 0.5f) * 2.0f * PBNDS_PI, theta = v * PBNDS_PI;
            const struct pbnds_vec3 w = {sinf(theta) * cosf(phi), cosf(theta),
                                         sinf(theta) * sinf(phi)};
            radiance(w, rgb + 3 * ((size_t)y * (size_t)width + (size_t)x));
        }
}
