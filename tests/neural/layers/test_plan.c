/* neural/layers/plan.c: how far a network sees, found by poking its inputs; windows
 * against the whole; and what it takes against what it took. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "neural/layers/net.h"
#include "neural/layers/net_internal.h"

enum { VIEW_C = 3, LIGHT_C = 2, OUT_C = 2, SIDE = 48, LOUT = 13, VOUT = 14 };

#define CONV(n, a, c, k, s, act)                                                       \
    {                                                                                  \
        n, PBNDS_OP_CONV, {a, -1}, c, k, s, PBNDS_ACT_##act, 0.0f, 0.0f                \
    }
#define OTHER(n, op, a, b, c, act)                                                     \
    {                                                                                  \
        n, PBNDS_OP_##op, {a, b}, c, 0, 0, PBNDS_ACT_##act, 0.0f, 0.0f                 \
    }

/* Every op that moves cells. From the light output back to the view input:
 * l_out 1 | cat 1 | shuffle 1 -> 1 at 1/2 | l2 2 | v_add 2 | v_up 2 -> 1 at 1/4 |
 * v3 -> 3 before, 2 behind at 1/2 | v2 -> 6, 4 | v1 -> 7, 5. */
static const struct pbnds_layer layers[] = {
    [0] = OTHER("view", VIEW_INPUT, -1, -1, VIEW_C, NONE),
    [1] = CONV("v1", 0, 4, 3, 1, NONE),
    [2] = CONV("v2", 1, 6, 2, 2, NONE),
    [3] = CONV("v3", 2, 8, 3, 2, NONE),
    [4] = OTHER("v_up", UP, 3, -1, 6, NONE),
    [5] = OTHER("v_add", ADD, 4, 2, 0, NONE),
    [6] = OTHER("light", LIGHT_INPUT, -1, -1, LIGHT_C, NONE),
    [7] = OTHER("pool", POOL, 6, -1, 0, NONE),
    [8] = CONV("l1", 7, 6, 3, 1, NONE),
    [9] = OTHER("l_add", ADD, 8, 5, 0, NONE),
    [10] = CONV("l2", 9, 8, 3, 1, NONE),
    [11] = OTHER("shuffle", SHUFFLE, 10, -1, 0, NONE),
    [12] = OTHER("cat", CONCAT, 11, 1, 0, NONE),
    [13] = CONV("l_out", 12, OUT_C, 3, 1, NONE),
    [14] = CONV("v_out", 4, 2, 1, 1, NONE),
    [15] = CONV("dead", 3, 2, 3, 1, NONE),
};
static const struct pbnds_net_table table = {layers, 16, LOUT, VOUT};

static struct pbnds_net *make_net(bool dnn, enum pbnds_dtype dtype,
                                  struct pbnds_backend **backend)
{
    struct pbnds_net *net;
    struct pbnds_error error;
    if (dnn ? pbnds_backend_create_onednn(backend, &error)
            : pbnds_backend_create_reference(backend, &error)) {
        fail_msg("%s", error.message);
    }
    if (pbnds_net_create(&table, *backend, dtype, &net, &error))
        fail_msg("%s", error.message);
    pbnds_net_init(net, 3);
    return net;
}

static float noise(int x, int y, int c)
{
    struct pbnds_rng rng =
        pbnds_rng_make((uint64_t)c, (uint64_t)(y + 1000), (uint64_t)(x + 1000));
    return 2.0f * pbnds_rng_float(&rng) - 1.0f;
}

/** A w x h window of one endless picture whose corner is at (x0, y0); the pixel at
 *  (px, py) is another in channel 0. */
static float *picture(int x0, int y0, int w, int h, int channels, int seed, int px,
                      int py)
{
    float *p = malloc((size_t)(w * h * channels) * sizeof *p);
    for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
            for (int c = 0; c < channels; ++c) {
                const bool poked = c == 0 && x0 + x == px && y0 + y == py;
                p[(y * w + x) * channels + c] =
                    noise(x0 + x, y0 + y, seed + c) + (poked ? 4.0f : 0.0f);
            }
        }
    }
    return p;
}

/** Light output of a window, [h, w, OUT_C]. */
static float *run(struct pbnds_net *net, int x0, int y0, int w, int h, int poke_view,
                  const int poke[2])
{
    const struct pbnds_pass pass = {.batch = 1, .lights = 1, .h = h, .w = w};
    float *view = picture(x0, y0, w, h, VIEW_C, 0, poke_view == 1 ? poke[0] : -999,
                          poke_view == 1 ? poke[1] : -999);
    float *light = picture(x0, y0, w, h, LIGHT_C, 50, poke_view == 0 ? poke[0] : -999,
                           poke_view == 0 ? poke[1] : -999);
    float *out = malloc((size_t)(w * h * OUT_C) * sizeof *out);
    assert_int_equal(pbnds_net_forward_view(net, &pass, view, NULL, NULL), PBNDS_OK);
    assert_int_equal(pbnds_net_forward_light(net, &pass, light, out, NULL), PBNDS_OK);
    free(view);
    free(light);
    return out;
}

enum { FROM = 16, TO = 32 }; /* the rectangle looked at */

static bool same_inside(const float *a, int ax, int aw, const float *b, int bx, int bw)
{
    for (int y = FROM; y < TO; ++y) {
        if (memcmp(a + ((y - ax) * aw + FROM - ax) * OUT_C,
                   b + ((y - bx) * bw + FROM - bx) * OUT_C,
                   (TO - FROM) * OUT_C * sizeof(float)) != 0) {
            return false;
        }
    }
    return true;
}

static void reach_is_what_changes_the_output(void **state)
{
    (void)state;
    struct pbnds_backend *backend;
    struct pbnds_net *net = make_net(false, PBNDS_F32, &backend);
    assert_int_equal(net->rows[0].reach_before, 7);
    assert_int_equal(net->rows[0].reach_behind, 5);
    assert_int_equal(pbnds_net_halo(net), 8);
    const int nowhere[2] = {-999, -999};
    float *plain = run(net, 0, 0, SIDE, SIDE, 1, nowhere);
    for (int view = 0; view < 2; ++view) {
        const struct pbnds_row *row = &net->rows[view ? 0 : 6];
        const int near = FROM - row->reach_before;
        const int far = TO - 1 + row->reach_behind;
        const int place[4] = {near, near - 1, far, far + 1};
        for (int axis = 0; axis < 2; ++axis) {
            for (int k = 0; k < 4; ++k) {
                bool changed = false;
                /* what a cell reads depends on its place among its siblings */
                for (int across = FROM; across < FROM + 4; ++across) {
                    const int at[2] = {axis ? across : place[k],
                                       axis ? place[k] : across};
                    float *poked = run(net, 0, 0, SIDE, SIDE, view, at);
                    changed |= !same_inside(plain, 0, SIDE, poked, 0, SIDE);
                    free(poked);
                }
                assert_int_equal(changed, k % 2 == 0);
            }
        }
    }
    free(plain);
    pbnds_net_free(net);
    pbnds_backend_free(backend);
}

static void a_window_with_its_halo_says_the_same(void **state)
{
    (void)state;
    const int nowhere[2] = {-999, -999};
    for (int m = 0; m < 3; ++m) {
        const enum pbnds_dtype dtype = m == 2 ? PBNDS_BF16 : PBNDS_F32;
        if (m == 2 && !pbnds_backend_has_fast_bf16()) continue;
        struct pbnds_backend *backend;
        struct pbnds_net *net = make_net(m > 0, dtype, &backend);
        const int halo = pbnds_net_halo(net), size = TO - FROM + 2 * halo;
        float *whole = run(net, 0, 0, SIDE, SIDE, 1, nowhere);
        float *part = run(net, FROM - halo, FROM - halo, size, size, 1, nowhere);
        float *tight =
            run(net, FROM - halo + 4, FROM - halo + 4, size - 8, size - 8, 1, nowhere);
        assert_true(same_inside(whole, 0, SIDE, part, FROM - halo, size));
        assert_false(same_inside(whole, 0, SIDE, tight, FROM - halo + 4, size - 8));
        free(whole);
        free(part);
        free(tight);
        pbnds_net_free(net);
        pbnds_backend_free(backend);
    }
}

static void bytes_are_those_that_are_taken(void **state)
{
    (void)state;
    static const int SIZES[][3] = {{48, 48, 1}, {16, 64, 3}, {64, 32, 5}};
    for (size_t k = 0; k < 3; ++k) {
        struct pbnds_backend *backend;
        struct pbnds_net *net = make_net(false, PBNDS_F32, &backend);
        const int w = SIZES[k][0], h = SIZES[k][1], lights = SIZES[k][2];
        const struct pbnds_pass pass = {.batch = 1, .lights = lights, .h = h, .w = w};
        float *view = calloc((size_t)(w * h * VIEW_C), sizeof *view);
        float *light = calloc((size_t)(lights * w * h * LIGHT_C), sizeof *light);
        float *out = calloc((size_t)(lights * w * h * OUT_C), sizeof *out);
        for (int n = 0; n < 6; ++n) {
            if (n % 3 == 0) {
                assert_int_equal(pbnds_net_forward_view(net, &pass, view, NULL, NULL),
                                 PBNDS_OK);
            }
            assert_int_equal(pbnds_net_forward_light(net, &pass, light, out, NULL),
                             PBNDS_OK);
        }
        const size_t up = (size_t)(w * h / 4 * 6) * sizeof(float);
        assert_int_equal(pbnds_net_bytes(net, &pass),
                         pbnds_arena_bytes(&net->arena) + up);
        free(view);
        free(light);
        free(out);
        pbnds_net_free(net);
        pbnds_backend_free(backend);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reach_is_what_changes_the_output),
        cmocka_unit_test(a_window_with_its_halo_says_the_same),
        cmocka_unit_test(bytes_are_those_that_are_taken),
    };
    return cmocka_run_group_tests_name("neural/layers/plan", tests, NULL, NULL);
}
