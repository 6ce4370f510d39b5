/* libFuzzer target: what loads is cast into a G-buffer and shaded. Geometry, materials
 * and lights of any kind must give planes that keep the contract and finite light. Uses
 * the corpus of fuzz_gltf. */
#include <math.h>
#include <stdlib.h>

#include "engine/shade/shader.h"
#include "tests/fuzz/gltf_input.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { SIDE = 6 };

static void demand(bool holds)
{
    if (!holds) abort();
}

static void check(const struct pbnds_gbuffer *g)
{
    for (size_t i = 0; i < (size_t)SIDE * SIDE; ++i) {
        const bool hit = g->coverage[i] > 0.0f;
        demand(g->coverage[i] >= 0.0f && g->coverage[i] <= 1.0f);
        demand(hit == (g->depth[i] < INFINITY));
        for (int c = 0; c < 3; ++c) {
            demand(g->albedo[c][i] >= 0.0f && g->albedo[c][i] <= 1.0f);
            demand(isfinite(g->position[c][i]) && isfinite(g->emission[c][i]));
        }
        demand(g->roughness[i] >= 0.0f && g->roughness[i] <= 1.0f);
        demand(g->metallic[i] >= 0.0f && g->metallic[i] <= 1.0f);
        demand(g->specular[i] >= 0.0f && g->specular[i] <= 1.0f);
        const struct pbnds_vec3 n = {g->normal[0][i], g->normal[1][i], g->normal[2][i]};
        demand(!hit || fabsf(pbnds_length(n) - 1.0f) < 1e-3f);
    }
}

/** A light map of two rows, a bright sky over a dim ground. */
static struct pbnds_envmap *sky(void)
{
    static struct pbnds_envmap *map;
    struct pbnds_image image;
    struct pbnds_error error;
    if (map || pbnds_image_init(&image, 4, 2, 3, &error) != PBNDS_OK) return map;
    for (size_t i = 0; i < (size_t)4 * 2 * 3; ++i)
        image.data[i] = i < 12 ? 2.0f : 0.25f;
    if (pbnds_envmap_create(&image, PBNDS_ENV_GLTF, 0.0f, 1.0f, &map, &error) !=
        PBNDS_OK)
        map = NULL;
    pbnds_image_free(&image);
    return map; /* for as long as the process runs */
}

static void shade(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                  const struct pbnds_gbuffer *g)
{
    static const char *const names[] = {"blinn-phong", "ggx", "reference"};
    for (size_t k = 0; k < sizeof names / sizeof names[0]; ++k) {
        const struct pbnds_shade_job job = {.gbuffer = g,
                                            .envmap = sky(),
                                            .scene = scene,
                                            .accel = accel,
                                            .spp = 2,
                                            .lights = 4,
                                            .shadows = -1};
        struct pbnds_image radiance;
        struct pbnds_error error;
        if (pbnds_shade(pbnds_shader_find(names[k]), &job, &radiance, &error) !=
            PBNDS_OK)
            continue;
        for (size_t i = 0; i < (size_t)SIDE * SIDE * 3; ++i)
            demand(radiance.data[i] >= 0.0f && isfinite(radiance.data[i]));
        pbnds_image_free(&radiance);
    }
}

static void cast(const struct pbnds_scene *scene,
                 const struct pbnds_raycast_options *options)
{
    struct pbnds_error error;
    struct pbnds_accel *accel = NULL;
    struct pbnds_gbuffer g;
    if (pbnds_accel_create(scene, &accel, &error) != PBNDS_OK) return;
    struct pbnds_camera camera =
        scene->camera_count
            ? scene->cameras[0]
            : pbnds_camera_framing(scene->lo, scene->hi, 30.0f, 20.0f, 40.0f, 1.0f);
    if (pbnds_gbuffer_raycast(scene, accel, &camera, SIDE, SIDE, options, &g, &error) ==
        PBNDS_OK) {
        check(&g);
        shade(scene, accel, &g);
        pbnds_gbuffer_free(&g);
    }
    pbnds_accel_free(accel);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const struct pbnds_gltf_options plain = fuzz_options(),
                                    moving = fuzz_options_moving();
    struct pbnds_scene scene;
    struct pbnds_raycast_options cases[2] = {
        {.samples = 1, .through = PBNDS_THROUGH_FIRST},
        {.optional = PBNDS_OPTIONAL_AO | PBNDS_OPTIONAL_UV | PBNDS_OPTIONAL_MOTION |
                     PBNDS_OPTIONAL_MATERIAL_ID | PBNDS_OPTIONAL_CRYPTOMATTE,
         .samples = 3,
         .through = PBNDS_THROUGH_ALPHA}};
    enum pbnds_status status = fuzz_load(data, size, &moving, &scene);
    if (status != PBNDS_OK) status = fuzz_load(data, size, &plain, &scene);
    if (status == PBNDS_OK && scene.triangle_count > 0 && scene.triangle_count < 5000) {
        if (scene.camera_count) cases[1].previous_camera = scene.previous_cameras;
        cast(&scene, &cases[0]);
        cast(&scene, &cases[1]);
    }
    pbnds_scene_free(&scene);
    return 0;
}
