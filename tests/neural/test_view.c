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

/* What a part holds of the view is what the whole view holds there. */
static void a_part_is_a_cut_of_the_whole(void **state)
{
    (void)state;
    struct pbnds_gbuffer g = fixture_walls(61, 47);
    struct pbnds_view all, part;
    const struct pbnds_vec3 wi[2] = {
        pbnds_normalize(pbnds_vec3_make(1.0f, 0.0f, 0.6f)),
        pbnds_normalize(pbnds_vec3_make(-0.4f, 1.0f, 0.3f))};
    static const struct pbnds_window WINDOWS[] = {
        {-16, -16, 48, 48}, {23, 18, 17, 9}, {40, 30, 64, 64}, {0, 0, 61, 47}};
    assert_int_equal(pbnds_view_create(&g, &all, NULL), PBNDS_OK);
    static uint32_t thin[2][61 * 47], thick[2][61 * 47];
    struct pbnds_march march[2] = {{thin[0], thick[0]}, {thin[1], thick[1]}};
    pbnds_view_march(&all, wi, 2, &march[0]);
    const float median = pbnds_view_median_depth(&g);
    for (size_t k = 0; k < sizeof WINDOWS / sizeof *WINDOWS; ++k) {
        assert_int_equal(pbnds_view_create_part(&g, WINDOWS[k], median, &part, NULL),
                         PBNDS_OK);
        assert_true(part.x >= 0 && part.x + part.width <= 61);
        assert_true(part.y >= 0 && part.y + part.height <= 47);
        pbnds_view_march(&part, wi, 2, &march[1]);
        for (int y = 0; y < part.height; ++y) {
            const size_t from = at(&all, part.x, part.y + y), to = at(&part, 0, y);
            const size_t row = (size_t)part.width * sizeof(float);
            for (int j = 0; j < PBNDS_PLANE_COUNT; ++j) {
                assert_memory_equal(part.plane[j] + to, all.plane[j] + from, row);
            }
            assert_memory_equal(thin[1] + to, thin[0] + from, row);
            assert_memory_equal(thick[1] + to, thick[0] + from, row);
        }
        pbnds_view_free(&part);
    }
    assert_int_equal(pbnds_view_create_part(&g, (struct pbnds_window){61, 0, 5, 5},
                                            median, &part, NULL),
                     PBNDS_ERROR_ARGUMENT);
    pbnds_view_free(&all);
    pbnds_gbuffer_free(&g);
}

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void median_is_that_of_the_sorted_depths(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    assert_int_equal(pbnds_gbuffer_init(&g, 31, 17, NULL), PBNDS_OK);
    assert_near((double)pbnds_view_median_depth(&g), 1.0, 0.0); /* nothing was hit */
    struct pbnds_rng rng = pbnds_rng_make(5, 0, 0);
    for (int round = 0; round < 20; ++round) {
        float sorted[31 * 17];
        int n = 0;
        for (int i = 0; i < 31 * 17; ++i) {
            const float u = pbnds_rng_float(&rng);
            g.depth[i] = u < 0.3f    ? INFINITY
                         : round % 2 ? 4.0f + 1e-6f * u /* few values, many ties */
                                     : expf(20.0f * u - 10.0f);
            if (isfinite(g.depth[i])) sorted[n++] = g.depth[i];
        }
        qsort(sorted, (size_t)n, sizeof *sorted, compare);
        assert_true(pbnds_view_median_depth(&g) == sorted[n / 2]);
    }
    pbnds_gbuffer_free(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes_are_in_camera_space),
        cmocka_unit_test(horizons_rise_towards_what_stands_before),
        cmocka_unit_test(march_finds_the_block_between_point_and_light),
        cmocka_unit_test(a_part_is_a_cut_of_the_whole),
        cmocka_unit_test(median_is_that_of_the_sorted_depths),
    };
    return cmocka_run_group_tests_name("neural/view", tests, NULL, NULL);
}
