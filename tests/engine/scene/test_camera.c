#include "tests/test.h"

#include "engine/scene/camera.h"
#include "tests/engine/scene/fixture.h"

static struct pbnds_camera perspective(float yfov_deg)
{
    struct pbnds_camera c;
    memset(&c, 0, sizeof c);
    c.world_from_camera = pbnds_mat4_identity();
    c.yfov = yfov_deg * PBNDS_PI / 180.0f;
    return c;
}

static struct pbnds_camera orthographic(float ymag)
{
    struct pbnds_camera c = perspective(0.0f);
    c.orthographic = true;
    c.ymag = ymag;
    return c;
}

static void known_perspective_rays(void **state)
{
    (void)state;
    const struct pbnds_camera c = perspective(90.0f);
    struct pbnds_ray ray = pbnds_camera_ray(&c, 200, 100, 100.0f, 50.0f);
    assert_near(ray.direction.x, 0.0, 1e-7);
    assert_near(ray.direction.y, 0.0, 1e-7);
    assert_near(ray.direction.z, -1.0, 1e-7);
    /* Upper left corner of a 2:1 image: (-2, 1, -1), row 0 is on top. */
    ray = pbnds_camera_ray(&c, 200, 100, 0.0f, 0.0f);
    const double length = sqrt(6.0);
    assert_near(ray.direction.x, -2.0 / length, 1e-6);
    assert_near(ray.direction.y, 1.0 / length, 1e-6);
    assert_near(ray.direction.z, -1.0 / length, 1e-6);
    assert_near(ray.origin.x, 0.0, 0.0);
}

static void known_orthographic_rays(void **state)
{
    (void)state;
    const struct pbnds_camera c = orthographic(2.0f);
    const struct pbnds_ray ray = pbnds_camera_ray(&c, 200, 100, 0.0f, 100.0f);
    assert_near(ray.origin.x, -4.0, 1e-6);
    assert_near(ray.origin.y, -2.0, 1e-6);
    assert_near(ray.origin.z, 0.0, 0.0);
    assert_near(ray.direction.x, 0.0, 0.0);
    assert_near(ray.direction.y, 0.0, 0.0);
    assert_near(ray.direction.z, -1.0, 0.0);
}

static void depth_is_planar(void **state)
{
    (void)state;
    struct pbnds_camera c = perspective(60.0f);
    assert_near(pbnds_camera_depth(&c, pbnds_vec3_make(0, 0, -5)), 5.0, 0.0);
    assert_near(pbnds_camera_depth(&c, pbnds_vec3_make(3, -2, -5)), 5.0, 0.0);
    c.world_from_camera = pbnds_mat4_look_at(
        pbnds_vec3_make(10, 0, 0), pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 1, 0));
    assert_near(pbnds_camera_depth(&c, pbnds_vec3_make(3, 7, -9)), 7.0, 1e-5);
    const struct pbnds_vec3 v =
        pbnds_camera_from_world_vector(&c, pbnds_vec3_make(1, 2, 3));
    assert_near(v.x, -3.0, 1e-6); /* from +x, world -z is on the right */
    assert_near(v.y, 2.0, 1e-6);
    assert_near(v.z, 1.0, 1e-6);
}

static void a_ray_projects_to_its_pixel(void **state)
{
    (void)state;
    struct pbnds_rng rng = pbnds_rng_make(1, 0, 0);
    for (int k = 0; k < 2000; ++k) {
        struct pbnds_camera c = k % 2 ? perspective(fixture_uniform(&rng, 5.0f, 120.0f))
                                      : orthographic(fixture_uniform(&rng, 0.1f, 9.0f));
        c.world_from_camera =
            pbnds_mat4_look_at(pbnds_scale(fixture_direction(&rng), 4.0f),
                               fixture_direction(&rng), pbnds_vec3_make(0, 1, 0));
        const int w = 1 + (int)fixture_uniform(&rng, 1.0f, 900.0f);
        const int h = 1 + (int)fixture_uniform(&rng, 1.0f, 900.0f);
        const float x = fixture_uniform(&rng, 0.0f, (float)w);
        const float y = fixture_uniform(&rng, 0.0f, (float)h);
        const struct pbnds_ray ray = pbnds_camera_ray(&c, w, h, x, y);
        assert_near(pbnds_length(ray.direction), 1.0, 1e-6);
        const float t = fixture_uniform(&rng, 0.5f, 20.0f);
        const struct pbnds_vec3 p = pbnds_mad(ray.origin, ray.direction, t);
        float px = -1.0f, py = -1.0f;
        assert_true(pbnds_camera_project(&c, w, h, p, &px, &py));
        assert_near(px, x, 0.02);
        assert_near(py, y, 0.02);
        assert_true(pbnds_camera_depth(&c, p) <= t * 1.0001f);
        assert_false(pbnds_camera_project(
            &c, w, h, pbnds_mad(ray.origin, ray.direction, -t), &px, &py));
    }
}

static void a_view_gives_the_same_bits(void **state)
{
    (void)state;
    struct pbnds_camera c = perspective(37.0f);
    c.world_from_camera =
        pbnds_mat4_look_at(pbnds_vec3_make(1, 2, 3), pbnds_vec3_make(0, 0.5f, 0),
                           pbnds_vec3_make(0, 1, 0));
    const struct pbnds_camera_view view = pbnds_camera_view(&c, 33, 47);
    for (int y = 0; y < 47; ++y) {
        for (int x = 0; x < 33; ++x) {
            const float fx = (float)x + 0.5f, fy = (float)y + 0.5f;
            const struct pbnds_ray a = pbnds_camera_ray(&c, 33, 47, fx, fy);
            const struct pbnds_ray b = pbnds_camera_view_ray(&view, fx, fy);
            assert_memory_equal(&a, &b, sizeof a);
        }
    }
}

static struct pbnds_vec3 eye_of(const struct pbnds_camera *c)
{
    const float *m = c->world_from_camera.m;
    return pbnds_vec3_make(m[12], m[13], m[14]);
}

static void framing_angles(void **state)
{
    (void)state;
    const struct pbnds_vec3 lo = {0, 0, 0}, hi = {2, 2, 2};
    struct pbnds_camera c = pbnds_camera_framing(lo, hi, 0.0f, 0.0f, 40.0f, 1.0f);
    const float d = sqrtf(3.0f) / sinf(20.0f * PBNDS_PI / 180.0f);
    assert_near(eye_of(&c).x, 1.0, 1e-5);
    assert_near(eye_of(&c).y, 1.0, 1e-5);
    assert_near(eye_of(&c).z, 1.0 + (double)d, 1e-4);
    c = pbnds_camera_framing(lo, hi, 90.0f, 0.0f, 40.0f, 1.0f);
    assert_near(eye_of(&c).x, 1.0 + (double)d, 1e-4);
    assert_near(eye_of(&c).z, 1.0, 1e-4);
    c = pbnds_camera_framing(lo, hi, 0.0f, 30.0f, 40.0f, 1.0f);
    assert_near(eye_of(&c).y, 1.0 + 0.5 * (double)d, 1e-4);
    /* Straight down keeps the yaw: the top of the image points away from the yaw's
     * side. */
    c = pbnds_camera_framing(lo, hi, 90.0f, 90.0f, 40.0f, 1.0f);
    assert_near(eye_of(&c).y, 1.0 + (double)d, 1e-4);
    assert_near(c.world_from_camera.m[4], -1.0, 1e-6);
}

static void framing_is_a_rotation_that_looks_at_the_center(void **state)
{
    (void)state;
    const struct pbnds_vec3 lo = {-1, 2, -3}, hi = {1.5f, 2.5f, 4};
    for (int k = 0; k < 100; ++k) {
        const float yaw = (float)k * 17.0f, pitch = (float)(k % 19) * 10.0f - 90.0f;
        const struct pbnds_camera c =
            pbnds_camera_framing(lo, hi, yaw, pitch, 35.0f, 1.5f);
        assert_near(pbnds_mat4_det3(&c.world_from_camera), 1.0, 1e-5);
        float x = 0.0f, y = 0.0f;
        assert_true(pbnds_camera_project(&c, 300, 200,
                                         pbnds_scale(pbnds_add(lo, hi), 0.5f), &x, &y));
        assert_near(x, 150.0, 0.01);
        assert_near(y, 100.0, 0.01);
    }
}

static void framing_fits_the_sphere(void **state)
{
    (void)state;
    const struct pbnds_vec3 lo = {-1, -1, -1}, hi = {1, 1, 1};
    const int sizes[][2] = {{200, 100}, {100, 100}, {100, 300}};
    for (int s = 0; s < 3; ++s) {
        const int w = sizes[s][0], h = sizes[s][1];
        const struct pbnds_camera c =
            pbnds_camera_framing(lo, hi, 33.0f, 21.0f, 50.0f, (float)w / (float)h);
        const float side = 0.5f * (float)(w < h ? w : h);
        float worst = 0.0f;
        struct pbnds_rng rng = pbnds_rng_make(2, 0, 0);
        for (int k = 0; k < 200000; ++k) {
            float x = 0.0f, y = 0.0f;
            assert_true(pbnds_camera_project(
                &c, w, h, pbnds_scale(fixture_direction(&rng), sqrtf(3.0f)), &x, &y));
            const float dx = fabsf(x - 0.5f * (float)w),
                        dy = fabsf(y - 0.5f * (float)h);
            worst = fmaxf(worst, (w < h ? dx : dy) / side);
            assert_true(dx <= 0.5f * (float)w * 1.001f &&
                        dy <= 0.5f * (float)h * 1.001f);
        }
        assert_near(worst, 1.0, 0.005); /* fits, and not looser than it must */
    }
}

static void framing_of_nothing_is_finite(void **state)
{
    (void)state;
    const struct pbnds_vec3 p = {1, 2, 3};
    const struct pbnds_camera c = pbnds_camera_framing(p, p, 10.0f, 5.0f, 40.0f, 1.0f);
    for (int i = 0; i < 16; ++i)
        assert_true(isfinite(c.world_from_camera.m[i]));
    assert_true(pbnds_camera_depth(&c, p) > 0.5f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_perspective_rays),
        cmocka_unit_test(known_orthographic_rays),
        cmocka_unit_test(depth_is_planar),
        cmocka_unit_test(a_ray_projects_to_its_pixel),
        cmocka_unit_test(a_view_gives_the_same_bits),
        cmocka_unit_test(framing_angles),
        cmocka_unit_test(framing_is_a_rotation_that_looks_at_the_center),
        cmocka_unit_test(framing_fits_the_sphere),
        cmocka_unit_test(framing_of_nothing_is_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
