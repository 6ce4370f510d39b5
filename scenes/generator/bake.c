#include "scenes/generator/bake.h"

#include <stdlib.h>

#include "engine/core/color.h"
#include "scenes/generator/noise.h"

/* What the layers mix to at each texel. */
struct fields {
    struct pbnds_vec3 *color;
    float *roughness, *metallic, *height;
};

static float mix(float a, float b, float t)
{
    return a + (b - a) * t;
}

static uint8_t code(float x)
{
    return (uint8_t)lrintf(255.0f * pbnds_clamp(x, 0.0f, 1.0f));
}

static struct gen_layer blend(struct gen_layer a, struct gen_layer b, float t)
{
    const struct gen_layer l = {pbnds_lerp(a.color, b.color, t),
                                mix(a.metallic, b.metallic, t),
                                mix(a.roughness, b.roughness, t)};
    return l;
}

static bool mark_covers(const struct gen_mark *m, float u, float v, uint32_t seed)
{
    const float c = cosf(m->slant), s = sinf(m->slant);
    const float x = (c * (u - m->x) + s * (v - m->y)) / m->half_x;
    const float y = (c * (v - m->y) - s * (u - m->x)) / m->half_y;
    if (m->kind == 0) return x * x + y * y < 1.0f;
    if (m->kind == 1) {
        const float d = x * x + y * y;
        return d < 1.0f && d > 0.55f;
    }
    if (fabsf(x) >= 1.0f || fabsf(y) >= 1.0f) return false;
    if (m->kind == 2) return true;
    const struct gen_pattern writing = {GEN_TEXT, 3, 0, 0.1f, 0.0f, 0.5f, seed};
    return gen_pattern_value(&writing, 0.5f + 0.5f * x, 0.5f + 0.5f * y) > 0.5f;
}

static void mix_texel(const struct gen_bake *k, const struct fields *f, size_t i,
                      float u, float v)
{
    const struct gen_texel t = gen_pattern_at(&k->pattern, u, v);
    struct gen_layer l = blend(k->a, k->b, t.value);
    float grain = 0.0f, height = k->depth * t.value;
    l.color = pbnds_scale(l.color, 1.0f + k->variety * (t.id - 0.5f));
    for (int m = 0; m < k->mark_count; ++m) {
        if (mark_covers(&k->marks[m], u, v, k->seed + (uint32_t)m))
            l.color = k->marks[m].color;
    }
    if (k->has_wear) {
        const float worn = gen_pattern_value(&k->worn, u, v);
        l = blend(l, k->wear, worn);
        height += 0.3f * k->depth * worn;
    }
    if (k->grain > 0.0f || k->bump > 0.0f) {
        const float n = (float)k->grain_frequency;
        grain = gen_fbm(pbnds_vec3_make(u * n, v * n, 0.5f), 3, k->grain_frequency,
                        k->seed);
    }
    f->color[i] = pbnds_scale(l.color, 1.0f + k->grain * grain);
    f->metallic[i] = l.metallic;
    f->roughness[i] = fmaxf(l.roughness + 0.3f * k->grain * grain, 0.02f);
    f->height[i] = height + k->bump * grain;
}

static void bake_color(const struct gen_bake *k, const struct fields *f, uint8_t *rgb)
{
    for (int i = 0; i < k->size * k->size; ++i) {
        rgb[3 * i] = code(pbnds_srgb_encode(f->color[i].x));
        rgb[3 * i + 1] = code(pbnds_srgb_encode(f->color[i].y));
        rgb[3 * i + 2] = code(pbnds_srgb_encode(f->color[i].z));
    }
}

static void bake_surface(const struct gen_bake *k, const struct fields *f, uint8_t *rgb)
{
    for (int i = 0; i < k->size * k->size; ++i) {
        rgb[3 * i] = 255; /* occlusion lives here in other people's files: none */
        rgb[3 * i + 1] = code(f->roughness[i]);
        rgb[3 * i + 2] = code(f->metallic[i]);
    }
}

/* Slope of the height field, wrapping; green points up, against v. */
static void bake_normal(const struct gen_bake *k, const struct fields *f, uint8_t *rgb)
{
    const int n = k->size;
    const float scale = 0.5f * (float)n, *h = f->height;
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const int east = y * n + (x + 1) % n, west = y * n + (x + n - 1) % n;
            const int south = (y + 1) % n * n + x, north = (y + n - 1) % n * n + x;
            const float du = scale * (h[east] - h[west]);
            const float dv = scale * (h[south] - h[north]);
            const struct pbnds_vec3 m = pbnds_normalize(pbnds_vec3_make(
                pbnds_clamp(-du, -1.5f, 1.5f), pbnds_clamp(dv, -1.5f, 1.5f), 1.0f));
            uint8_t *out = rgb + 3 * (y * n + x);
            out[0] = code(0.5f + 0.5f * m.x);
            out[1] = code(0.5f + 0.5f * m.y);
            out[2] = code(0.5f + 0.5f * m.z);
        }
    }
}

static bool varies(const struct gen_bake *k)
{
    const struct pbnds_vec3 d = pbnds_sub(k->a.color, k->b.color);
    return k->grain > 0.0f || k->variety > 0.0f || k->has_wear || k->mark_count > 0 ||
           pbnds_dot(d, d) > 0.0f;
}

static void write_images(struct gen_world *w, const struct gen_bake *k,
                         const struct fields *f, uint8_t *rgb, struct gen_material *m)
{
    if (varies(k)) {
        bake_color(k, f, rgb);
        m->color_image = gen_world_texture(w, rgb, k->size, k->size);
        if (m->color_image >= 0) m->base_color = pbnds_splat(1.0f);
    }
    if (k->a.roughness != k->b.roughness || k->a.metallic != k->b.metallic ||
        k->has_wear || k->grain > 0.2f) {
        bake_surface(k, f, rgb);
        m->surface_image = gen_world_texture(w, rgb, k->size, k->size);
        if (m->surface_image >= 0) m->metallic = m->roughness = 1.0f;
    }
    if (k->depth != 0.0f || k->bump > 0.0f) {
        bake_normal(k, f, rgb);
        m->normal_image = gen_world_texture(w, rgb, k->size, k->size);
    }
}

void gen_bake_images(struct gen_world *w, const struct gen_bake *k,
                     struct gen_material *m)
{
    const size_t texels = (size_t)k->size * (size_t)k->size;
    struct fields f = {malloc(texels * sizeof *f.color), malloc(texels * sizeof(float)),
                       malloc(texels * sizeof(float)), malloc(texels * sizeof(float))};
    uint8_t *rgb = malloc(texels * 3);
    if (!f.color || !f.roughness || !f.metallic || !f.height || !rgb) {
        w->failed = true;
    } else {
        for (int y = 0; y < k->size; ++y) {
            for (int x = 0; x < k->size; ++x) {
                mix_texel(k, &f, (size_t)(y * k->size + x),
                          ((float)x + 0.5f) / (float)k->size,
                          ((float)y + 0.5f) / (float)k->size);
            }
        }
        write_images(w, k, &f, rgb, m);
    }
    free(f.color);
    free(f.roughness);
    free(f.metallic);
    free(f.height);
    free(rgb);
}
