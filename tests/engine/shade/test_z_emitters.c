/* The reference against the naive path tracer: emitting surfaces, light map, interiors. */
#include "tests/engine/shade/z_scene.h"

/* A bright room without its front wall: a panel of light below the ceiling, a metal and a
 * glossy box, the sky outside. Light comes in by many bounces. */
static void a_room_with_a_panel_of_light(void **state)
{
    (void)state;
    struct z_scene z = {.naive_samples = 10000, .spp = 1024, .most_error = 0.04};
    struct pbnds_material m[5] = {matte(0.85f), matte(0.8f), matte(0.7f), matte(0.0f),
                                  matte(0.6f)};
    m[1].metallic = 1.0f;
    m[1].roughness = 0.6f;
    m[1].base_color = (struct pbnds_vec4){0.9f, 0.7f, 0.4f, 1.0f};
    m[2].ior_f0 = 0.04f;
    m[2].roughness = 0.5f;
    m[3].emissive = pbnds_vec3_make(4.0f, 3.0f, 2.0f);
    m[4].base_color = (struct pbnds_vec4){0.8f, 0.3f, 0.2f, 1.0f};
    const struct pbnds_vec3 up = {0.0f, 2.0f, 0.0f}, back = {0.0f, 0.0f, -2.0f};
    const struct pbnds_mesh meshes[7] = {
        floor_at(-1.0f, 1.0f, 0),
        floor_at(1.0f, 1.0f, 0),
        quad(pbnds_vec3_make(-1.0f, -1.0f, 1.0f), back, up, 4),
        quad(pbnds_vec3_make(1.0f, -1.0f, 1.0f), back, up, 0),
        quad(pbnds_vec3_make(-1.0f, -1.0f, -1.0f), pbnds_vec3_make(2.0f, 0.0f, 0.0f),
             up, 1),
        quad(pbnds_vec3_make(-0.5f, -0.6f, 0.4f), pbnds_vec3_make(0.8f, 0.3f, 0.2f),
             pbnds_vec3_make(0.1f, 0.4f, -0.8f), 2),
        floor_at(0.7f, 0.6f, 3),
    };
    fixture_scene(&z.f, meshes, 7, m, 5);
    z_scene_sky(&z, 4, z_soft_sky);
    fixture_view(&z.f, pbnds_vec3_make(0.1f, 0.2f, 3.4f),
                 pbnds_vec3_make(0.0f, 0.0f, 0.0f), 6, 6);
    z_scene_check(&z, 8);
    fixture_free(&z.f);
}

/* No sky: closed, and all light from one wall that is a texture. */
static void a_closed_box_lit_by_a_textured_wall(void **state)
{
    (void)state;
    struct z_scene z = {.naive_samples = 6000, .spp = 1024, .most_error = 0.03};
    struct pbnds_material m[2] = {matte(0.75f), matte(0.3f)};
    m[1].emissive = pbnds_vec3_make(3.0f, 2.0f, 4.0f);
    m[1].emissive_texture.texture = 0;
    const struct pbnds_vec3 up = {0.0f, 2.0f, 0.0f}, back = {0.0f, 0.0f, -2.0f},
                            right = {2.0f, 0.0f, 0.0f};
    struct pbnds_mesh meshes[6] = {
        floor_at(-1.0f, 1.0f, 0),
        floor_at(1.0f, 1.0f, 0),
        quad(pbnds_vec3_make(-1.0f, -1.0f, 1.0f), back, up, 1),
        quad(pbnds_vec3_make(1.0f, -1.0f, 1.0f), back, up, 0),
        quad(pbnds_vec3_make(-1.0f, -1.0f, -1.0f), right, up, 0),
        quad(pbnds_vec3_make(-1.0f, -1.0f, 1.0f), right, up, 0),
    };
    const struct pbnds_vec2 uv[4] = {
        {0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}};
    meshes[2].uv[0] = must_alloc(4, sizeof *uv);
    memcpy(meshes[2].uv[0], uv, sizeof uv);
    fixture_scene(&z.f, meshes, 6, m, 2);
    /* four texels, one of them black; the scene frees them */
    static const float texels[16] = {1.0f, 0.1f, 0.1f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f,
                                     0.1f, 1.0f, 0.2f, 1.0f, 0.6f, 0.6f, 1.0f, 1.0f};
    fixture_texture_rgba(&z.f, texels, 2, 2);
    fixture_view(&z.f, pbnds_vec3_make(0.6f, 0.2f, 0.9f),
                 pbnds_vec3_make(-0.6f, -0.2f, -0.5f), 6, 6);
    z_scene_check(&z, 6);
    fixture_free(&z.f);
}

/* Many lights of very different power, seen from near and far, some from behind. */
static void a_heap_of_small_emitters(void **state)
{
    (void)state;
    struct z_scene z = {.naive_samples = 12000, .spp = 2048, .most_error = 0.03};
    struct pbnds_material m[4] = {matte(0.6f), matte(0.2f), matte(0.0f), matte(0.5f)};
    m[1].emissive = pbnds_vec3_make(1.0f, 0.2f, 0.1f);
    m[2].emissive = pbnds_vec3_make(0.5f, 2.0f, 3.0f);
    m[3].emissive = pbnds_vec3_make(0.2f, 0.3f, 0.2f);
    const struct pbnds_mesh meshes[5] = {
        floor_at(0.0f, 3.0f, 0),
        cube(0.5f, 1),
        quad(pbnds_vec3_make(-2.0f, 0.1f, -1.5f), pbnds_vec3_make(1.2f, 0.0f, 0.6f),
             pbnds_vec3_make(0.0f, 1.4f, 0.2f), 2),
        quad(pbnds_vec3_make(1.0f, 0.2f, -1.8f), pbnds_vec3_make(1.0f, 0.5f, 0.4f),
             pbnds_vec3_make(-0.2f, 1.2f, 0.0f), 3),
        floor_at(2.2f, 0.8f, 2),
    };
    fixture_scene(&z.f, meshes, 5, m, 4);
    z_scene_sky(&z, 4, z_soft_sky);
    fixture_view(&z.f, pbnds_vec3_make(0.5f, 1.8f, 3.6f),
                 pbnds_vec3_make(0.0f, 0.3f, 0.0f), 6, 6);
    z_scene_check(&z, 3);
    fixture_free(&z.f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_room_with_a_panel_of_light),
        cmocka_unit_test(a_closed_box_lit_by_a_textured_wall),
        cmocka_unit_test(a_heap_of_small_emitters),
    };
    return cmocka_run_group_tests_name("engine/shade/z_emitters", tests, NULL, NULL);
}
