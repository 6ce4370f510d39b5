/* What is open to the sky and to lights far away: formulas, and rays one by one. */
#include "tests/engine/shade/fixture.h"

#include "engine/core/parallel.h"
#include "engine/shade/openness.h"
#include "engine/shade/tiles.h"
#include "engine/shade/visibility.h"

enum { RAYS = 64 };

static float *open_of(const struct fixture *f)
{
    const struct pbnds_gbuffer *g = &f->gbuffer;
    struct pbnds_error error;
    float *open = must_alloc((size_t)g->width * (size_t)g->height, sizeof *open);
    must(pbnds_openness(g, f->accel, RAYS, 5, open, &error), &error);
    return open;
}

static void an_open_plane_is_open(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = matte(0.5f);
    struct pbnds_mesh mesh = floor_at(0.0f, 5.0f, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_view(&f, pbnds_vec3_make(0.0f, 2.0f, 9.0f), pbnds_splat(0.0f), 12, 12);
    float *open = open_of(&f);
    int empty = 0;
    for (size_t i = 0; i < 144; ++i) {
        const bool hit = isfinite(f.gbuffer.depth[i]);
        empty += !hit;
        assert_true(open[i] == (hit ? 1.0f : 0.0f));
    }
    assert_true(empty > 0 && empty < 144);
    free(open);
    fixture_free(&f);
}

static void the_inside_of_a_sphere_is_closed(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = matte(0.5f);
    struct pbnds_mesh mesh = sphere(pbnds_splat(0.0f), 2.0f, 12, 0);
    fixture_scene(&f, &mesh, 1, &m, 1);
    fixture_view(&f, pbnds_splat(0.0f), pbnds_vec3_make(0.3f, 0.2f, 1.0f), 12, 12);
    float *open = open_of(&f);
    for (size_t i = 0; i < 144; ++i)
        assert_true(open[i] == 0.0f);
    free(open);
    fixture_free(&f);
}

/* A wall of height h and no end, seen from a floor at distance d of it: the floor's form
 * factor to the wall is (1 - d / sqrt(d^2 + h^2)) / 2 (Howell, catalogue B-2 with an
 * infinite side), so the rest is open. */
static void a_wall_takes_its_form_factor(void **state)
{
    (void)state;
    const float h = 1.5f;
    struct fixture f;
    struct pbnds_material m = matte(0.5f);
    struct pbnds_mesh meshes[2];
    meshes[0] = floor_at(0.0f, 50.0f, 0);
    meshes[1] =
        quad(pbnds_vec3_make(-3000.0f, 0.0f, 0.0f),
             pbnds_vec3_make(6000.0f, 0.0f, 0.0f), pbnds_vec3_make(0.0f, h, 0.0f), 0);
    fixture_scene(&f, meshes, 2, &m, 1);
    fixture_view(&f, pbnds_vec3_make(0.0f, 6.0f, 3.0f),
                 pbnds_vec3_make(0.0f, 0.0f, 2.9f), 40, 40);
    float *open = open_of(&f);
    double sum = 0.0, wall = 0.0, worst = 0.0;
    for (size_t i = 0; i < 1600; ++i) {
        const double d = (double)f.gbuffer.position[2][i];
        assert_true(d > 0.0);
        const double expected =
            1.0 - 0.5 * (1.0 - d / sqrt(d * d + (double)h * (double)h));
        sum += (double)open[i];
        wall += expected;
        worst = fmax(worst, fabs((double)open[i] - expected));
    }
    print_message("mean %.5f, by the formula %.5f, worst pixel off by %.3f\n",
                  sum / 1600, wall / 1600, worst);
    assert_near(sum / 1600, wall / 1600, 0.001);
    assert_true(worst < 0.08); /* 64 rays */
    free(open);
    fixture_free(&f);
}

/* It is the direct light of a uniform sky on a white Lambert surface. */
static void it_is_the_transport_of_a_uniform_sky(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = matte(1.0f);
    m.specular = 0.0f;
    struct pbnds_mesh meshes[2];
    meshes[0] = floor_at(-1.0f, 4.0f, 0);
    meshes[1] = cube(1.0f, 0);
    fixture_scene(&f, meshes, 2, &m, 1);
    fixture_light(&f, 8, light_white);
    fixture_view(&f, pbnds_vec3_make(5.0f, 4.0f, 6.0f), pbnds_splat(0.0f), 24, 24);
    struct pbnds_image radiance, direct;
    struct pbnds_error error;
    const struct pbnds_pathtrace_options options = {.spp = 256, .max_bounces = 1};
    must(pbnds_pathtrace(&f.job, &options, &radiance, &direct, &error), &error);
    float *open = open_of(&f);
    double sum = 0.0, light = 0.0;
    for (size_t i = 0; i < 576; ++i) {
        sum += (double)open[i];
        light += (double)direct.data[3 * i];
        assert_near(open[i], direct.data[3 * i], 0.15);
    }
    assert_near(sum / light, 1.0, 0.004);
    free(open);
    pbnds_image_free(&radiance);
    pbnds_image_free(&direct);
    fixture_free(&f);
}

static void threads_and_tiles_change_nothing(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = matte(0.5f);
    struct pbnds_mesh meshes[2];
    meshes[0] = floor_at(-1.0f, 4.0f, 0);
    meshes[1] = cube(1.0f, 0);
    fixture_scene(&f, meshes, 2, &m, 1);
    fixture_view(&f, pbnds_vec3_make(5.0f, 4.0f, 6.0f), pbnds_splat(0.0f), 37, 29);
    const struct pbnds_vec3 wi[2] = {
        pbnds_normalize(pbnds_vec3_make(1.0f, 0.7f, 0.2f)),
        pbnds_normalize(pbnds_vec3_make(-1.0f, 0.4f, -0.2f))};
    struct pbnds_error error;
    uint32_t bits[37 * 29], again[37 * 29];
    float *open = open_of(&f);
    must(pbnds_visibility(&f.gbuffer, f.accel, wi, 2, bits, &error), &error);
    pbnds_set_threads(3);
    pbnds_set_tile_side(5);
    float *same = open_of(&f);
    must(pbnds_visibility(&f.gbuffer, f.accel, wi, 2, again, &error), &error);
    pbnds_set_tile_side(0);
    pbnds_set_threads(0);
    assert_memory_equal(open, same, 37 * 29 * sizeof *open);
    assert_memory_equal(bits, again, sizeof bits);
    free(open);
    free(same);
    fixture_free(&f);
}

/* Bit by bit, a ray for each; lights from below and along the floor among them. */
static void bits_are_what_single_rays_say(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_material m = matte(0.5f);
    struct pbnds_mesh meshes[3];
    meshes[0] = floor_at(-1.0f, 4.0f, 0);
    meshes[1] = cube(1.0f, 0);
    meshes[2] = sphere(pbnds_vec3_make(1.5f, 0.2f, 1.2f), 0.8f, 10, 0);
    fixture_scene(&f, meshes, 3, &m, 1);
    fixture_view(&f, pbnds_vec3_make(5.0f, 4.0f, 6.0f), pbnds_splat(0.0f), 33, 27);
    struct pbnds_vec3 wi[PBNDS_VISIBILITY_LIGHTS];
    for (int k = 0; k < PBNDS_VISIBILITY_LIGHTS; ++k) {
        const float z = 1.0f - (2.0f * (float)k + 1.0f) / PBNDS_VISIBILITY_LIGHTS;
        const float phi = 2.4f * (float)k, r = sqrtf(1.0f - z * z);
        wi[k] = pbnds_vec3_make(r * cosf(phi), z, r * sinf(phi));
    }
    uint32_t bits[33 * 27];
    struct pbnds_error error;
    must(pbnds_visibility(&f.gbuffer, f.accel, wi, PBNDS_VISIBILITY_LIGHTS, bits,
                          &error),
         &error);
    int differ = 0, seen = 0, hidden = 0;
    for (size_t i = 0; i < 33 * 27; ++i) {
        if (!isfinite(f.gbuffer.depth[i])) {
            assert_int_equal(bits[i], 0);
            continue;
        }
        const struct pbnds_vec3 ng = pbnds_gbuffer_vec3(f.gbuffer.geometric_normal, i);
        for (int k = 0; k < PBNDS_VISIBILITY_LIGHTS; ++k) {
            const struct pbnds_ray ray = {
                pbnds_offset_origin(pbnds_gbuffer_vec3(f.gbuffer.position, i), ng),
                wi[k]};
            const bool sees = pbnds_dot(ng, wi[k]) > 0.0f &&
                              !pbnds_accel_occluded(f.accel, &ray, INFINITY);
            differ += sees != (bits[i] >> k & 1u);
            seen += sees;
            hidden += !sees;
        }
    }
    print_message("%d seen, %d hidden, %d differ\n", seen, hidden, differ);
    assert_true(seen > 4000 && hidden > 4000);
    assert_true(differ <= 2); /* rays along an edge may fall to either side */
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_open_plane_is_open),
        cmocka_unit_test(the_inside_of_a_sphere_is_closed),
        cmocka_unit_test(a_wall_takes_its_form_factor),
        cmocka_unit_test(it_is_the_transport_of_a_uniform_sky),
        cmocka_unit_test(threads_and_tiles_change_nothing),
        cmocka_unit_test(bits_are_what_single_rays_say),
    };
    return cmocka_run_group_tests_name("engine/shade/openness", tests, NULL, NULL);
}
