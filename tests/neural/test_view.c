/* neural/view.c: what is derived from a depth buffer, on shapes whose answer is known.
 */
#include "tests/neural/fixture.h"

#include "neural/view.h"

static size_t at(const struct pbnds_view *v, int x, int y)
{
    return (size_t)y * (size_t)v->width + (size_t)x;
}

static void planes_are_in_camera_space(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    assert_int_equal(pbnds_gbuffer_init(&g, 8, 8, NULL), PBNDS_OK);
    /* The camera looks along +x from -x: world -x is towards it, camera +z. */
    g.camera = fixture_camera();
    g.camera.world_from_camera = pbnds_mat4_look_at(
        pbnds_vec3_make(-4, 0, 0), pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 1, 0));
    const size_t i = 8 * 4 + 4;
    g.normal[0][i] = -1.0f;
    g.depth[i] = 4.0f;
    g.coverage[i] = 1.0f;
    struct pbnds_view v;
    assert_int_equal(pbnds_view_create(&g, &v, NULL), PBNDS_OK);
    assert_near((double)v.plane[PBNDS_PLANE_NORMAL_Z][i], 1.0, 1e-6);
    assert_near((double)v.plane[PBNDS_PLANE_NORMAL_X][i], 0.0, 1e-6);
    assert_near((double)v.plane[PBNDS_PLANE_WO_Z][i], 1.0, 2e-2);
    assert_near((double)v.plane[PBNDS_PLANE_LOG_DEPTH][i], 0.0,
                1e-6); /* the median itself */
    assert_near((double)v.plane[PBNDS_PLANE_MASK][0], 0.0, 0.0);
    pbnds_view_free(&v);
    pbnds_gbuffer_free(&g);
}

/* A wall alone has no horizon; below a near block the horizon rises towards it only. */
static void horizons_rise_towards_what_stands_before(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(60, 60);
    struct pbnds_view v;
    assert_int_equal(pbnds_view_create(&g, &v, NULL), PBNDS_OK);
    /* left of the block, which spans x 21..39: azimuth 0 looks at it, azimuth 4 away */
    const size_t beside = at(&v, 17, 30), far = at(&v, 3, 3), on = at(&v, 30, 30);
    assert_true(v.plane[PBNDS_PLANE_HORIZON + 0][beside] > 0.3f);
    assert_near((double)v.plane[PBNDS_PLANE_HORIZON + 4][beside], 0.0, 1e-4);
    assert_near((double)v.plane[PBNDS_PLANE_HORIZON + 4][far], 0.0, 1e-4);
    for (int k = 0; k < PBNDS_HORIZONS;
         ++k) { /* nothing rises above the block's face */
        assert_near((double)v.plane[PBNDS_PLANE_HORIZON + k][on], 0.0, 1e-4);
    }
    pbnds_view_free(&v);
    pbnds_gbuffer_free(&g);
}

static void march_finds_the_block_between_point_and_light(void **state)
{
    (void)state;
    for (int size = 60; size <= 120; size += 60) { /* whatever the resolution */
        struct pbnds_gbuffer g = fixture_walls(size, size);
        struct pbnds_view v;
        assert_int_equal(pbnds_view_create(&g, &v, NULL), PBNDS_OK);
        const size_t count = (size_t)size * (size_t)size;
        struct pbnds_march m = {malloc(count * 4), malloc(count * 4)};
        const struct pbnds_vec3 wi[3] = {
            pbnds_normalize(pbnds_vec3_make(1.0f, 0.0f, 0.6f)),  /* from the right */
            pbnds_normalize(pbnds_vec3_make(-1.0f, 0.0f, 0.6f)), /* from the left  */
            pbnds_vec3_make(0.0f, 0.0f, 1.0f),                   /* from the eye   */
        };
        pbnds_view_march(&v, wi, 3, &m);
        const size_t left = at(&v, size * 17 / 60, size / 2);
        const size_t right = at(&v, size * 43 / 60, size / 2);
        assert_int_equal(m.thick[left] & 7u, 1u);
        assert_int_equal(m.thick[right] & 7u, 2u);
        assert_int_equal(m.thick[at(&v, size / 2, size / 2)] & 7u, 0u);
        assert_int_equal(m.thick[at(&v, 4, 4)] & 7u, 0u);
        assert_int_equal(m.thin[0], 0u);     /* nothing was hit there */
        for (size_t i = 0; i < count; ++i) { /* thin implies thick */
            assert_int_equal(m.thin[i] & ~m.thick[i], 0u);
        }
        free(m.thin);
        free(m.thick);
        pbnds_view_free(&v);
        pbnds_gbuffer_free(&g);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes_are_in_camera_space),
        cmocka_unit_test(horizons_rise_towards_what_stands_before),
        cmocka_unit_test(march_finds_the_block_between_point_and_light),
    };
    return cmocka_run_group_tests_name("neural/view", tests, NULL, NULL);
}
