/* The reference against the naive path tracer: transparent layers, lights of the file,
 * unlit surfaces. */
#include "tests/engine/shade/z_scene.h"

static void set_lights(struct z_scene *z, const struct pbnds_light *lights, int count)
{
    z->f.scene.lights = must_alloc((size_t)count, sizeof *lights);
    memcpy(z->f.scene.lights, lights, (size_t)count * sizeof *lights);
    z->f.scene.light_count = count;
}

/* One of each kind, with range and cone, beside an emitter and the sky; two bodies throw
 * shadows. */
static void lights_of_the_file(void **state)
{
    (void)state;
    struct z_scene z = {.naive_samples = 3000, .spp = 1024, .most_error = 0.03};
    struct pbnds_material m[4] = {matte(0.6f), matte(0.9f), matte(0.1f), matte(0.5f)};
    m[0].ior_f0 = 0.04f;
    m[0].roughness = 0.5f;
    m[1].metallic = 1.0f;
    m[1].roughness = 0.5f;
    m[2].emissive = pbnds_vec3_make(1.5f, 1.0f, 1.0f);
    const struct pbnds_mesh meshes[4] = {
        floor_at(0.0f, 3.0f, 0), cube(0.4f, 1),
        quad(pbnds_vec3_make(-1.6f, 0.0f, -1.0f), pbnds_vec3_make(0.8f, 0.0f, -0.4f),
             pbnds_vec3_make(0.0f, 1.5f, 0.0f), 2),
        quad(pbnds_vec3_make(0.9f, 0.1f, 0.5f), pbnds_vec3_make(0.5f, 0.0f, -0.7f),
             pbnds_vec3_make(0.0f, 0.8f, 0.1f), 3)};
    const struct pbnds_light lights[3] = {{.kind = PBNDS_LIGHT_POINT,
                                           .position = {1.8f, 1.5f, 0.8f},
                                           .intensity = {3.0f, 2.0f, 1.0f},
                                           .range = 4.0f},
                                          {.kind = PBNDS_LIGHT_SPOT,
                                           .position = {-1.0f, 2.5f, 1.0f},
                                           .direction = {0.3713907f, -0.9284767f, 0.0f},
                                           .intensity = {2.0f, 6.0f, 4.0f},
                                           .range = INFINITY,
                                           .cos_inner = 0.97f,
                                           .cos_outer = 0.9f},
                                          {.kind = PBNDS_LIGHT_DIRECTIONAL,
                                           .direction = {-0.6f, -0.8f, 0.0f},
                                           .intensity = {0.8f, 0.8f, 1.2f}}};
    fixture_scene(&z.f, meshes, 4, m, 4);
    set_lights(&z, lights, 3);
    z_scene_sky(&z, 4, z_soft_sky);
    fixture_view(&z.f, pbnds_vec3_make(0.5f, 2.2f, 3.4f),
                 pbnds_vec3_make(0.0f, 0.3f, 0.0f), 7, 7);
    z_scene_check(&z, 3);
    fixture_free(&z.f);
}

/* Panes that let light through: before the camera, before the sky, one that glows, one
 * between a light and the floor; one cut out by its mask. */
static void panes_before_everything(void **state)
{
    (void)state;
    struct z_scene z = {.naive_samples = 8000, .spp = 2048, .most_error = 0.03};
    struct pbnds_material m[6] = {matte(0.7f), matte(0.8f), matte(0.4f),
                                  matte(0.5f), matte(0.0f), matte(0.9f)};
    for (int i = 1; i < 4; ++i)
        m[i].alpha_mode = PBNDS_ALPHA_BLEND;
    m[1].base_color.w = 0.3f;
    m[2].base_color.w = 0.6f;
    m[2].emissive = pbnds_vec3_make(1.0f, 2.0f, 1.5f);
    m[3].base_color.w = 0.5f;
    m[4].emissive = pbnds_vec3_make(3.0f, 3.0f, 2.0f);
    m[5].alpha_mode = PBNDS_ALPHA_MASK;
    m[5].base_color.w = 0.4f;
    const struct pbnds_mesh meshes[6] = {
        floor_at(0.0f, 2.0f, 0),
        quad(pbnds_vec3_make(-0.9f, 0.4f, 1.5f), pbnds_vec3_make(1.0f, 0.0f, 0.1f),
             pbnds_vec3_make(0.0f, 1.6f, 0.1f), 1),
        quad(pbnds_vec3_make(-0.5f, 0.1f, 0.0f), pbnds_vec3_make(1.2f, 0.0f, 0.1f),
             pbnds_vec3_make(0.1f, 1.9f, 0.0f), 2),
        floor_at(1.2f, 0.9f, 3),
        floor_at(1.7f, 0.8f, 4),
        quad(pbnds_vec3_make(-2.0f, 0.0f, 0.9f), pbnds_vec3_make(4.0f, 0.0f, 0.1f),
             pbnds_vec3_make(0.0f, 2.0f, 0.0f), 5)};
    const struct pbnds_light light = {.kind = PBNDS_LIGHT_POINT,
                                      .position = {0.4f, 2.4f, 0.6f},
                                      .intensity = {4.0f, 4.0f, 6.0f},
                                      .range = INFINITY};
    fixture_scene(&z.f, meshes, 6, m, 6);
    set_lights(&z, &light, 1);
    z_scene_sky(&z, 4, z_soft_sky);
    fixture_view(&z.f, pbnds_vec3_make(0.2f, 1.1f, 4.0f),
                 pbnds_vec3_make(0.0f, 0.8f, 0.0f), 7, 7);
    z_scene_check(&z, 3);
    fixture_free(&z.f);
}

/* An unlit wall shines on the floor, for all that no light sampling knows of it. */
static void an_unlit_wall(void **state)
{
    (void)state;
    struct z_scene z = {.naive_samples = 8000, .spp = 2048, .most_error = 0.03};
    struct pbnds_material m[3] = {matte(0.7f), matte(0.0f), matte(0.1f)};
    m[1].unlit = true;
    m[1].base_color = (struct pbnds_vec4){0.9f, 0.5f, 0.7f, 1.0f};
    m[2].emissive = pbnds_vec3_make(1.0f, 1.0f, 0.5f);
    const struct pbnds_mesh meshes[3] = {floor_at(0.0f, 2.0f, 0),
                                         quad(pbnds_vec3_make(-1.0f, 0.1f, -1.0f),
                                              pbnds_vec3_make(2.0f, 0.0f, 0.0f),
                                              pbnds_vec3_make(0.0f, 2.0f, 0.0f), 1),
                                         floor_at(2.4f, 0.9f, 2)};
    fixture_scene(&z.f, meshes, 3, m, 3);
    fixture_view(&z.f, pbnds_vec3_make(0.2f, 1.5f, 4.0f),
                 pbnds_vec3_make(0.0f, 0.4f, 0.0f), 5, 5);
    z_scene_check(&z, 3);
    fixture_free(&z.f);
}

/* The map alone: the path without a choice. A sun that uniform samples still find. */
static struct pbnds_vec3 broad_sun(float u, float v)
{
    const bool sun = u > 0.5f && u < 0.75f && v > 0.25f && v < 0.5f;
    return sun ? pbnds_vec3_make(5.0f, 4.0f, 3.0f) : z_soft_sky(u, v);
}

static void bodies_under_the_sky(void **state)
{
    (void)state;
    struct z_scene z = {.naive_samples = 12000, .spp = 1024, .most_error = 0.03};
    struct pbnds_material m[3] = {matte(0.7f), matte(0.9f), matte(0.5f)};
    m[1].metallic = 1.0f;
    m[1].roughness = 0.5f;
    m[2].ior_f0 = 0.04f;
    m[2].roughness = 0.5f;
    const struct pbnds_mesh meshes[3] = {floor_at(0.0f, 2.0f, 0), cube(0.6f, 1),
                                         quad(pbnds_vec3_make(-1.5f, 0.0f, -1.0f),
                                              pbnds_vec3_make(3.0f, 0.0f, 0.2f),
                                              pbnds_vec3_make(0.0f, 1.5f, 0.0f), 2)};
    fixture_scene(&z.f, meshes, 3, m, 3);
    z_scene_sky(&z, 4, broad_sun);
    fixture_view(&z.f, pbnds_vec3_make(0.8f, 1.8f, 3.6f),
                 pbnds_vec3_make(0.0f, 0.3f, 0.0f), 6, 6);
    z_scene_check(&z, 4);
    fixture_free(&z.f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lights_of_the_file),
        cmocka_unit_test(panes_before_everything),
        cmocka_unit_test(an_unlit_wall),
        cmocka_unit_test(bodies_under_the_sky),
    };
    return cmocka_run_group_tests_name("engine/shade/z_layers", tests, NULL, NULL);
}
