/** G-buffers and light maps in memory for the tests of the neural module. */
#ifndef PBNDS_TESTS_NEURAL_FIXTURE_H
#define PBNDS_TESTS_NEURAL_FIXTURE_H

#include <stdlib.h>
#include <string.h>

#include "tests/test.h"

#include "engine/core/rng.h"
#include "engine/scene/envmap.h"
#include "engine/shade/gbuffer.h"

/** A camera at the origin that looks down -z. */
static inline struct pbnds_camera fixture_camera(void)
{
    return (struct pbnds_camera){.world_from_camera = pbnds_mat4_identity(),
                                 .yfov = 0.8f};
}

static inline void fixture_pixel(struct pbnds_gbuffer *g, int x, int y, float depth,
                                 struct pbnds_vec3 n)
{
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    const struct pbnds_ray ray = pbnds_camera_ray(&g->camera, g->width, g->height,
                                                  (float)x + 0.5f, (float)y + 0.5f);
    const float t = depth / -ray.direction.z; /* the fixture's camera looks down -z */
    const struct pbnds_vec3 p = pbnds_mad(ray.origin, ray.direction, t);
    const float *v[3] = {&p.x, &p.y, &p.z}, *m[3] = {&n.x, &n.y, &n.z};
    for (int c = 0; c < 3; ++c) {
        g->position[c][i] = *v[c];
        g->normal[c][i] = *m[c];
        g->geometric_normal[c][i] = *m[c];
        g->albedo[c][i] = 0.2f + 0.2f * (float)c;
    }
    g->specular[i] = 0.04f;
    g->roughness[i] = 0.6f;
    g->depth[i] = depth;
    g->coverage[i] = 1.0f;
    g->object_id[i] = 0;
}

/** A wall at depth 4 that faces the eye, with a smaller one at depth 3 before its
 * middle third; the outermost two pixels show nothing; materials vary over the image.
 */
static inline struct pbnds_gbuffer fixture_walls(int width, int height)
{
    struct pbnds_gbuffer g;
    assert_int_equal(pbnds_gbuffer_init(&g, width, height, NULL), PBNDS_OK);
    g.camera = fixture_camera();
    const struct pbnds_vec3 n = {0.0f, 0.0f, 1.0f};
    for (int y = 2; y < height - 2; ++y) {
        for (int x = 2; x < width - 2; ++x) {
            const bool near = x > width / 3 && x < 2 * width / 3 && y > height / 3 &&
                              y < 2 * height / 3;
            fixture_pixel(&g, x, y, near ? 3.0f : 4.0f, n);
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            g.roughness[i] = 0.1f + 0.8f * (float)x / (float)width;
            g.metallic[i] = y > height / 2 ? 0.8f : 0.0f;
            g.specular[i] = g.metallic[i] * 0.4f + 0.04f;
        }
    }
    return g;
}

/** A light map of a dim gradient and one lamp; scale multiplies all of it. */
static inline struct pbnds_envmap *fixture_env(float scale, uint64_t seed)
{
    struct pbnds_image image;
    assert_int_equal(pbnds_image_init(&image, 32, 16, 3, NULL), PBNDS_OK);
    struct pbnds_rng rng = pbnds_rng_make(seed, 0, 0);
    for (size_t i = 0; i < 32u * 16u * 3u; ++i)
        image.data[i] = scale * pbnds_rng_float(&rng);
    float *lamp = pbnds_image_at(&image, (int)(seed % 32u), 4);
    for (int c = 0; c < 3; ++c)
        lamp[c] = scale * 60.0f;
    struct pbnds_envmap *env;
    assert_int_equal(
        pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, NULL), PBNDS_OK);
    pbnds_image_free(&image);
    return env;
}
#endif /* PBNDS_TESTS_NEURAL_FIXTURE_H */
