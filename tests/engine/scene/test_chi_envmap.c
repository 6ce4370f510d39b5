/* Directions drawn from a light map against their density. */
#include "engine/scene/envmap.h"
#include "tests/engine/shade/chi_squared.h"

static double pdf(const void *self, struct pbnds_vec3 w)
{
    return (double)pbnds_envmap_pdf(self, w);
}

static bool sample(const void *self, struct pbnds_rng *rng, struct pbnds_vec3 *w)
{
    const float u1 = pbnds_rng_float(rng), u2 = pbnds_rng_float(rng);
    const struct pbnds_env_sample s = pbnds_envmap_sample(self, u1, u2);
    *w = s.wi;
    return s.pdf > 0.0f;
}

/* A sky of noise, some of it black, with a sun 100 times as bright. */
static struct pbnds_vec3 sky(int x, int y, int width, int height)
{
    const uint64_t h = pbnds_mix64((uint64_t)(y * width + x));
    const float noise = (float)(h >> 40) * 0x1p-24f;
    if (h & 1u) return pbnds_splat(0.0f);
    const bool sun = abs(8 * x - 3 * width) < 4 && abs(4 * y - height) < 2;
    return pbnds_vec3_make(noise, 1.0f - noise, sun ? 100.0f : 0.5f);
}

static struct pbnds_envmap *map_of(int width, int height,
                                   enum pbnds_env_convention convention, float yaw)
{
    struct pbnds_error error;
    struct pbnds_image image;
    struct pbnds_envmap *map;
    assert_int_equal(pbnds_image_init(&image, width, height, 3, &error), PBNDS_OK);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const struct pbnds_vec3 l = sky(x, y, width, height);
            float *out = pbnds_image_at(&image, x, y);
            out[0] = l.x, out[1] = l.y, out[2] = l.z;
        }
    assert_int_equal(pbnds_envmap_create(&image, convention, yaw, 2.0f, &map, &error),
                     PBNDS_OK);
    pbnds_image_free(&image);
    return map;
}

struct shape {
    int width, height;
    enum pbnds_env_convention convention;
    float yaw;
};

enum { SHAPES = 4 };

/* Texels as fine as the bins, a few large ones, more than the bins can tell, and one whose
 * edges lie nowhere near the bins'. */
static void directions_follow_the_luminance(void **state)
{
    (void)state;
    const struct shape shapes[SHAPES] = {{160, 80, PBNDS_ENV_GLTF, 0.0f},
                                         {16, 8, PBNDS_ENV_OPENEXR, 0.0f},
                                         {320, 160, PBNDS_ENV_PBNDS, 9.0f},
                                         {20, 11, PBNDS_ENV_FALCOR, 33.3f}};
    for (int i = 0; i < SHAPES; ++i) {
        const struct shape *s = &shapes[i];
        struct pbnds_envmap *map = map_of(s->width, s->height, s->convention, s->yaw);
        const struct chi_sampler sampler = {
            .self = map, .pdf = pdf, .sample = sample, .pole = {0.0f, 1.0f, 0.0f}};
        char what[64];
        (void)snprintf(what, sizeof what, "%d x %d texels", s->width, s->height);
        assert_chi_squared(&sampler, (uint64_t)i, SHAPES, what);
        pbnds_envmap_free(map);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directions_follow_the_luminance),
    };
    return cmocka_run_group_tests_name("engine/scene/chi_envmap", tests, NULL, NULL);
}
