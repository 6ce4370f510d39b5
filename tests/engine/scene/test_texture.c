#include <stdlib.h>
#include <string.h>

#include "engine/core/color.h"
#include "engine/core/rng.h"
#include "engine/scene/texture.h"
#include "tests/test.h"

/* The naive twin: wraps a texel index by walking, decodes by the formula, filters in
 * double. */
static int twin_wrap(enum pbnds_wrap wrap, int i, int n)
{
    int at = 0, step = 1;
    if (wrap == PBNDS_WRAP_CLAMP) return i < 0 ? 0 : (i >= n ? n - 1 : i);
    if (wrap == PBNDS_WRAP_REPEAT) {
        while (i < 0)
            i += n;
        while (i >= n)
            i -= n;
        return i;
    }
    /* Mirrored: walk there texel by texel, turning round at the ends. */
    if (i < 0) i = -1 - i; /* the picture is even about 0 */
    while (i-- > 0) {
        if (at + step < 0 || at + step >= n)
            step = -step; /* the end texel repeats */
        else
            at += step;
    }
    return at;
}

static double twin_texel(const struct pbnds_texture *t, int x, int y, int c, bool srgb)
{
    const struct pbnds_pixels *p = t->pixels;
    const int tx = twin_wrap(t->wrap_u, x, p->width);
    const int ty = twin_wrap(t->wrap_v, y, p->height);
    const size_t at = ((size_t)ty * (size_t)p->width + (size_t)tx) * 4 + (size_t)c;
    const double v = p->u8 ? p->u8[at] / 255.0 : (double)p->f32[at];
    if (!srgb || c == 3) return v;
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static double twin_sample(const struct pbnds_texture *t, double u, double v, int c,
                          bool srgb)
{
    const double x = u * t->pixels->width, y = v * t->pixels->height;
    if (t->nearest) return twin_texel(t, (int)floor(x), (int)floor(y), c, srgb);
    const int x0 = (int)floor(x - 0.5), y0 = (int)floor(y - 0.5);
    const double fx = x - 0.5 - x0, fy = y - 0.5 - y0;
    return (1 - fy) * ((1 - fx) * twin_texel(t, x0, y0, c, srgb) +
                       fx * twin_texel(t, x0 + 1, y0, c, srgb)) +
           fy * ((1 - fx) * twin_texel(t, x0, y0 + 1, c, srgb) +
                 fx * twin_texel(t, x0 + 1, y0 + 1, c, srgb));
}

static void compare_with_twin(const struct pbnds_pixels *pixels)
{
    struct pbnds_rng rng = pbnds_rng_make(7, (uint64_t)pixels->width, 0);
    for (int mode = 0; mode < 36; ++mode) {
        const struct pbnds_texture t = {pixels, (enum pbnds_wrap)(mode % 3),
                                        (enum pbnds_wrap)(mode / 3 % 3),
                                        mode / 9 % 2 == 1};
        const bool srgb = mode / 18 == 1;
        for (int i = 0; i < 300; ++i) {
            const struct pbnds_vec2 uv = {8.0f * pbnds_rng_float(&rng) - 4.0f,
                                          8.0f * pbnds_rng_float(&rng) - 4.0f};
            /* Nearest jumps at texel borders: leave what float could put on either
             * side. */
            const double x = (double)uv.x * pixels->width,
                         y = (double)uv.y * pixels->height;
            if (t.nearest && (fabs(x - round(x)) < 1e-4 || fabs(y - round(y)) < 1e-4)) {
                continue;
            }
            const struct pbnds_vec4 got = pbnds_texture_sample(&t, uv, srgb);
            const float channel[4] = {got.x, got.y, got.z, got.w};
            for (int c = 0; c < 4; ++c) {
                assert_near((double)channel[c],
                            twin_sample(&t, (double)uv.x, (double)uv.y, c, srgb), 2e-5);
            }
        }
    }
}

static void random_pixels(struct pbnds_pixels *p, int width, int height, bool wide)
{
    struct pbnds_rng rng = pbnds_rng_make(3, (uint64_t)width, (uint64_t)height);
    const size_t count = (size_t)width * (size_t)height * 4;
    *p = (struct pbnds_pixels){.width = width, .height = height, .channels = 4};
    if (wide)
        p->f32 = malloc(count * sizeof *p->f32);
    else
        p->u8 = malloc(count);
    for (size_t i = 0; i < count; ++i) {
        if (wide)
            p->f32[i] = pbnds_rng_float(&rng);
        else
            p->u8[i] = (uint8_t)(pbnds_rng_u64(&rng) & 255u);
    }
}

static void agrees_with_a_naive_twin(void **state)
{
    (void)state;
    static const int sizes[][2] = {{1, 1}, {2, 3}, {5, 4}, {7, 1}, {16, 16}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        for (int wide = 0; wide < 2; ++wide) {
            struct pbnds_pixels p;
            random_pixels(&p, sizes[i][0], sizes[i][1], wide == 1);
            compare_with_twin(&p);
            free(p.u8);
            free(p.f32);
        }
    }
}

static void decodes_srgb_before_filtering(void **state)
{
    (void)state;
    /* Black beside white, alpha 0 beside 255: half way is linear 0.5 in both, not the
     * linear value of code 127.5 (0.21). */
    uint8_t texels[8] = {0, 0, 0, 0, 255, 255, 255, 255};
    const struct pbnds_pixels p = {2, 1, 4, texels, NULL};
    const struct pbnds_texture t = {&p, PBNDS_WRAP_CLAMP, PBNDS_WRAP_CLAMP, false};
    const struct pbnds_vec4 c =
        pbnds_texture_sample(&t, (struct pbnds_vec2){0.5f, 0.5f}, true);
    assert_near((double)c.x, 0.5, 1e-6);
    assert_near((double)c.w, 0.5, 1e-6);
    const struct pbnds_vec4 end =
        pbnds_texture_sample(&t, (struct pbnds_vec2){1.0f, 0.0f}, true);
    assert_true(end.x == 1.0f && end.y == 1.0f && end.z == 1.0f && end.w == 1.0f);
}

static void every_code_value_decodes(void **state)
{
    (void)state;
    for (int i = 0; i < 256; ++i) {
        uint8_t texel[4] = {(uint8_t)i, (uint8_t)i, (uint8_t)i, (uint8_t)i};
        const struct pbnds_pixels p = {1, 1, 4, texel, NULL};
        const struct pbnds_texture t = {&p, PBNDS_WRAP_REPEAT, PBNDS_WRAP_REPEAT, true};
        const struct pbnds_vec2 uv = {0.3f, 0.3f};
        const struct pbnds_vec4 srgb = pbnds_texture_sample(&t, uv, true);
        const struct pbnds_vec4 linear = pbnds_texture_sample(&t, uv, false);
        assert_near((double)srgb.y, (double)pbnds_srgb_decode((float)i / 255.0f), 3e-7);
        assert_true(linear.z == (float)i / 255.0f && srgb.w == linear.w);
    }
}

static void texel_centres_are_exact(void **state)
{
    (void)state;
    struct pbnds_pixels p;
    random_pixels(&p, 8, 4, false);
    for (int mode = 0; mode < 6; ++mode) {
        const enum pbnds_wrap wrap = (enum pbnds_wrap)(mode % 3);
        const struct pbnds_texture t = {&p, wrap, wrap, mode >= 3};
        for (int i = 0; i < 32; ++i) {
            const int x = i % 8, y = i / 8;
            const struct pbnds_vec2 uv = {((float)x + 0.5f) / 8.0f,
                                          ((float)y + 0.5f) / 4.0f};
            const struct pbnds_vec4 c = pbnds_texture_sample(&t, uv, false);
            assert_true(c.x == (float)p.u8[4 * i] / 255.0f);
            assert_true(c.w == (float)p.u8[4 * i + 3] / 255.0f);
        }
    }
    free(p.u8);
}

static void any_coordinate_is_survived(void **state)
{
    (void)state;
    static const float odd[] = {NAN,    INFINITY, -INFINITY, 1e30f,      -1e30f, 3e9f,
                                1e6f,   -1e6f,    999999.f,  -1e-30f,    1.0f,   0.0f,
                                -1e-9f, 2.0f,     -0.0f,     0.99999994f};
    const size_t count = sizeof odd / sizeof odd[0];
    struct pbnds_pixels p;
    random_pixels(&p, 3, 5, false);
    for (size_t i = 0; i < count * count; ++i) {
        for (int mode = 0; mode < 18; ++mode) {
            const struct pbnds_texture t = {&p, (enum pbnds_wrap)(mode % 3),
                                            (enum pbnds_wrap)(mode / 3 % 3), mode >= 9};
            const struct pbnds_vec2 uv = {odd[i % count], odd[i / count]};
            const struct pbnds_vec4 c = pbnds_texture_sample(&t, uv, true);
            assert_true(c.x >= 0.0f && c.x <= 1.0f && c.w >= 0.0f && c.w <= 1.0f);
        }
    }
    free(p.u8);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_a_naive_twin),
        cmocka_unit_test(decodes_srgb_before_filtering),
        cmocka_unit_test(every_code_value_decodes),
        cmocka_unit_test(texel_centres_are_exact),
        cmocka_unit_test(any_coordinate_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
