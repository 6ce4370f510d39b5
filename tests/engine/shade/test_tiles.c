/* engine/shade/tiles.c: every pixel once, honest progress, prompt stop. */
#include "tests/engine/shade/fixture.h"
#include "tests/test.h"

#include <stdbool.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/shade/tiles.h"

enum { WIDTH = 37, HEIGHT = 23 };

struct visits {
    unsigned char count[HEIGHT][WIDTH];
};

static void visit(void *context, const struct pbnds_tile *tile)
{
    struct visits *visits = context;
    for (int y = tile->y0; y < tile->y1; ++y)
        for (int x = tile->x0; x < tile->x1; ++x)
            ++visits->count[y][x];
}

static void each_pixel_is_visited_once(void **state)
{
    (void)state;
    struct pbnds_error error;
    const int sides[] = {1, 8, 16, 100};
    for (size_t s = 0; s < sizeof sides / sizeof *sides; ++s) {
        struct visits visits;
        memset(&visits, 0, sizeof visits);
        assert_int_equal(
            pbnds_for_tiles(WIDTH, HEIGHT, sides[s], NULL, "t", visit, &visits, &error),
            PBNDS_OK);
        for (int y = 0; y < HEIGHT; ++y)
            for (int x = 0; x < WIDTH; ++x)
                assert_int_equal(visits.count[y][x], 1);
    }
}

static _Thread_local bool on_calling_thread;

struct heard {
    double last;
    bool falling, over, from_elsewhere;
    double total;
};

static void hear(void *user, const char *stage, double done, double total)
{
    struct heard *heard = user;
    (void)stage;
    heard->falling = heard->falling || done < heard->last;
    heard->over = heard->over || done > total;
    heard->from_elsewhere = heard->from_elsewhere || !on_calling_thread;
    heard->last = done;
    heard->total = total;
}

/* Long enough that the other threads get their share before the first is done. */
static void visit_slowly(void *context, const struct pbnds_tile *tile)
{
    visit(context, tile);
    for (volatile int i = 0; i < 30000; ++i)
        continue;
}

static void progress_rises_to_the_total(void **state)
{
    (void)state;
    struct pbnds_error error;
    struct visits visits;
    struct heard heard = {0};
    const struct pbnds_report report = {.progress = hear, .user = &heard};
    memset(&visits, 0, sizeof visits);
    pbnds_set_threads(3);
    on_calling_thread = true;
    assert_int_equal(
        pbnds_for_tiles(WIDTH, HEIGHT, 1, &report, "t", visit_slowly, &visits, &error),
        PBNDS_OK);
    assert_false(heard.falling);
    assert_false(heard.over);
    assert_false(heard.from_elsewhere);
    assert_near(heard.total, WIDTH * HEIGHT, 0.0);
    assert_near(heard.last, WIDTH * HEIGHT, 0.0);
}

static void assert_same_pictures(const struct fixture *f, const char *shader)
{
    struct pbnds_error error;
    struct pbnds_image one;
    pbnds_set_threads(1);
    must(pbnds_shade(pbnds_shader_find(shader), &f->job, &one, &error), &error);
    const int threads[] = {1, 2, 5}, sides[] = {1, 3, 7, 16, 100};
    for (int k = 0; k < 5; ++k) {
        struct pbnds_image other;
        pbnds_set_threads(threads[k % 3]);
        pbnds_set_tile_side(sides[k]);
        must(pbnds_shade(pbnds_shader_find(shader), &f->job, &other, &error), &error);
        assert_memory_equal(one.data, other.data,
                            (size_t)one.width * (size_t)one.height * 3 * sizeof(float));
        pbnds_image_free(&other);
    }
    pbnds_set_tile_side(0);
    pbnds_image_free(&one);
}

static void tiles_and_threads_change_no_picture(void **state)
{
    (void)state;
    const struct pbnds_material white = matte(0.7f);
    const struct pbnds_mesh meshes[2] = {floor_at(0.0f, 3.0f, 0),
                                         sphere(pbnds_vec3_make(0, 1, 0), 1.0f, 12, 0)};
    struct fixture f;
    fixture_scene(&f, meshes, 2, &white, 1);
    fixture_light(&f, 16, light_sunny);
    fixture_view(&f, pbnds_vec3_make(1, 2, 4), pbnds_vec3_make(0, 0.7f, 0), 45, 37);
    f.job.spp = 3;
    assert_same_pictures(&f, "ggx");
    assert_same_pictures(&f, "reference");
    fixture_free(&f);
}

static void stop_at_first_tile(void *context, const struct pbnds_tile *tile)
{
    visit(context, tile);
    pbnds_request_stop();
}

/* Last, because the flag cannot be lowered. */
static void a_stop_ends_the_walk(void **state)
{
    (void)state;
    struct pbnds_error error;
    struct visits visits;
    memset(&visits, 0, sizeof visits);
    pbnds_set_threads(1);
    assert_int_equal(pbnds_for_tiles(WIDTH, HEIGHT, 8, NULL, "t", stop_at_first_tile,
                                     &visits, &error),
                     PBNDS_ERROR_INTERRUPTED);
    assert_int_equal(visits.count[0][0], 1);
    assert_int_equal(visits.count[HEIGHT - 1][WIDTH - 1], 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_pixel_is_visited_once),
        cmocka_unit_test(progress_rises_to_the_total),
        cmocka_unit_test(tiles_and_threads_change_no_picture),
        cmocka_unit_test(a_stop_ends_the_walk),
    };
    return cmocka_run_group_tests_name("engine/shade/tiles", tests, NULL, NULL);
}
