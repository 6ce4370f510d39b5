/* neural/tiles.c: windows that cover the image once, hold their halo and fit. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>

#include "neural/model/model.h"
#include "neural/tiles.h"

static size_t linear(const void *context, int width, int height, int lights)
{
    const size_t *base = context;
    return *base + (size_t)width * (size_t)height * (size_t)(100 + 50 * lights);
}

static struct pbnds_net *make_net(struct pbnds_backend **backend)
{
    struct pbnds_net *net;
    assert_int_equal(pbnds_backend_create_reference(backend, NULL), PBNDS_OK);
    assert_int_equal(pbnds_net_create(&pbnds_model_find("transport")->table, *backend,
                                      PBNDS_F32, &net, NULL),
                     PBNDS_OK);
    return net;
}

static void check_axis(int window, int size, int own, int own_size, int domain,
                       int halo, int unit)
{
    assert_true(window >= 0 && window % unit == 0 && size % unit == 0);
    assert_true(window + size <= domain);
    assert_true(own_size > 0);
    assert_true(window == 0 || own >= window + halo);
    assert_true(window + size == domain || own + own_size <= window + size - halo);
}

static void check_tiles(const struct pbnds_tiling *t, int unit)
{
    unsigned char *seen = calloc((size_t)t->width * (size_t)t->height, sizeof *seen);
    for (int i = 0; i < t->columns * t->rows; ++i) {
        const struct pbnds_tile tile = pbnds_tiling_tile(t, i);
        const struct pbnds_window w = tile.window, own = tile.own;
        assert_int_equal(w.width, t->window_width);
        assert_int_equal(w.height, t->window_height);
        check_axis(w.x, w.width, own.x, own.width, t->domain_width, t->halo, unit);
        check_axis(w.y, w.height, own.y, own.height, t->domain_height, t->halo, unit);
        assert_true(own.x + own.width <= t->width && own.y + own.height <= t->height);
        for (int y = own.y; y < own.y + own.height; ++y) {
            for (int x = own.x; x < own.x + own.width; ++x)
                ++seen[y * t->width + x];
        }
    }
    for (int i = 0; i < t->width * t->height; ++i)
        assert_int_equal(seen[i], 1);
    free(seen);
}

static void tiles_cover_the_image_once_and_fit(void **state)
{
    (void)state;
    static const int SIZES[][2] = {{1, 1},       {16, 17},     {300, 200}, {513, 1000},
                                   {1920, 1080}, {3840, 2160}, {7, 3000}};
    static const size_t BUDGETS[] = {1, 12u << 20, 30u << 20, 100u << 20, 0};
    struct pbnds_backend *backend;
    struct pbnds_net *net = make_net(&backend);
    const int unit = 1 << pbnds_net_deepest_level(net), halo = pbnds_net_halo(net);
    const size_t base = 1000;
    for (size_t s = 0; s < sizeof SIZES / sizeof *SIZES; ++s) {
        for (size_t b = 0; b < sizeof BUDGETS / sizeof *BUDGETS; ++b) {
            const struct pbnds_tiling t = pbnds_tiling_plan(
                net, SIZES[s][0], SIZES[s][1], 9, BUDGETS[b], linear, &base);
            check_tiles(&t, unit);
            assert_int_equal(t.bytes,
                             linear(&base, t.window_width, t.window_height, t.chunk));
            assert_in_range((unsigned)t.chunk, 1, 9);
            if (BUDGETS[b] == 1) {
                assert_true(t.window_width <= 3 * unit + 2 * halo);
                assert_int_equal(t.chunk, 1);
            } else if (BUDGETS[b] > 0) {
                assert_true(t.bytes <= BUDGETS[b]);
                /* no light more would have fitted */
                assert_true(t.chunk == 9 ||
                            linear(&base, t.window_width, t.window_height,
                                   t.chunk + 1) > BUDGETS[b]);
            }
        }
    }
    pbnds_net_free(net);
    pbnds_backend_free(backend);
}

static void an_image_that_fits_is_one_window(void **state)
{
    (void)state;
    struct pbnds_backend *backend;
    struct pbnds_net *net = make_net(&backend);
    const size_t base = 0;
    const struct pbnds_tiling t =
        pbnds_tiling_plan(net, 250, 130, 3, (size_t)64 << 20, linear, &base);
    assert_int_equal(t.columns * t.rows, 1);
    assert_int_equal(t.window_width, 256);
    assert_int_equal(t.window_height, 144);
    assert_int_equal(t.chunk, 3);
    pbnds_net_free(net);
    pbnds_backend_free(backend);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiles_cover_the_image_once_and_fit),
        cmocka_unit_test(an_image_that_fits_is_one_window),
    };
    return cmocka_run_group_tests_name("neural/tiles", tests, NULL, NULL);
}
