/* What there is in 200 worlds: kinds of places and things, materials over their whole range;
 * all load, none is like another. Made as sketches, which draw the same numbers. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/scene/gltf.h"
#include "scenes/generator/layout.h"

enum { WORLDS = 200, NAMES = 80 };

struct tally {
    char name[NAMES][32];
    int count[NAMES]; /* worlds that have it */
    int names;
};

static struct {
    struct tally places, things;
    int materials, metals, textured, bumped, glowing, other_ior, tinted, two_sided;
    int dark, bright, middle, polished, rough; /* of untextured materials */
    int plain;
    float least_ior, most_ior;
    size_t fewest, most; /* triangles */
    int painted;         /* parts with vertex colours */
    uint64_t hash[WORLDS];
} seen;

static void add(struct tally *t, const char *name, int *once)
{
    int i = 0;
    while (i < t->names && strcmp(t->name[i], name) != 0)
        ++i;
    assert_true(i < NAMES);
    if (i == t->names)
        (void)snprintf(t->name[t->names++], sizeof t->name[0], "%s", name);
    if (once && once[i]++) return;
    ++t->count[i];
}

static int worlds_with(const struct tally *t, const char *name)
{
    for (int i = 0; i < t->names; ++i)
        if (strcmp(t->name[i], name) == 0) return t->count[i];
    return 0;
}

static void refuse(void *user, const char *sentence)
{
    (void)user;
    fail_msg("%s", sentence);
}

static uint64_t fnv(const uint8_t *data, size_t size)
{
    uint64_t h = 1469598103934665603u;
    for (size_t i = 0; i < size; ++i)
        h = (h ^ data[i]) * 1099511628211u;
    return h;
}

static void look_at_material(const struct gen_material *m)
{
    const bool textured = m->color_image >= 0 || m->surface_image >= 0;
    ++seen.materials;
    seen.textured += textured;
    seen.bumped += m->normal_image >= 0;
    seen.glowing += pbnds_max3(m->emission) > 0.0f;
    seen.other_ior += m->ior != 1.5f;
    seen.two_sided += m->double_sided;
    seen.tinted += m->specular != 1.0f || m->specular_color.x != 1.0f;
    seen.least_ior = fminf(seen.least_ior, m->ior);
    seen.most_ior = fmaxf(seen.most_ior, m->ior);
    assert_true(m->roughness >= 0.02f && m->roughness <= 1.0f);
    assert_true(m->metallic >= 0.0f && m->metallic <= 1.0f);
    assert_true(pbnds_max3(m->base_color) <= 1.0f);
    assert_true(m->specular >= 0.0f && m->specular <= 1.0f);
    if (textured) return;
    ++seen.plain;
    seen.metals += m->metallic == 1.0f;
    seen.polished += m->roughness < 0.08f;
    seen.rough += m->roughness > 0.8f;
    if (m->metallic > 0.0f) return;
    const float albedo = pbnds_luminance(m->base_color);
    seen.dark += albedo < 0.05f;
    seen.bright += albedo > 0.6f;
    seen.middle += albedo >= 0.05f && albedo <= 0.8f;
}

static void load(const struct gen_bytes *file, int index)
{
    const struct pbnds_report report = {.warn = refuse};
    struct pbnds_scene scene;
    struct pbnds_error error = {{0}};
    if (pbnds_gltf_load_memory(file->data, file->size, "world", NULL, NULL, &report,
                               &scene, &error) != PBNDS_OK)
        fail_msg("world %d: %s", index, error.message);
    assert_true(scene.triangle_count > 0);
    if (scene.triangle_count < seen.fewest) seen.fewest = scene.triangle_count;
    if (scene.triangle_count > seen.most) seen.most = scene.triangle_count;
    pbnds_scene_free(&scene);
}

static void look_at(int index)
{
    int once[NAMES] = {0};
    struct gen_bytes file = {.size = 0};
    struct gen_world *w = calloc(1, sizeof *w);
    assert_non_null(w);
    w->sketch = true;
    gen_random_world(w, 11, (uint64_t)index);
    add(&seen.places, w->name, NULL);
    for (int i = 0; i < w->object_count; ++i)
        add(&seen.things, w->objects[i].name, once);
    for (int i = 0; i < w->material_count; ++i)
        look_at_material(&w->materials[i]);
    for (int i = 0; i < w->part_count; ++i)
        seen.painted += w->parts[i].color != NULL;
    assert_true(gen_glb_make(w, &file));
    gen_world_free(w);
    free(w);
    seen.hash[index] = fnv(file.data, file.size);
    load(&file, index);
    gen_bytes_free(&file);
}

static int look(void **state)
{
    (void)state;
    pbnds_set_threads(1); /* many small loads */
    seen.least_ior = INFINITY;
    seen.fewest = SIZE_MAX;
    for (int i = 0; i < WORLDS; ++i)
        look_at(i);
    return 0;
}

static void no_two_are_equal(void **state)
{
    (void)state;
    for (int i = 0; i < WORLDS; ++i)
        for (int k = 0; k < i; ++k)
            assert_true(seen.hash[i] != seen.hash[k]);
}

static void every_kind_of_place_is_there(void **state)
{
    (void)state;
    static const char *const places[] = {"alone", "presented", "portrait", "gathering",
                                         "room",  "landscape", "pile",     "hanging",
                                         "shelf", "table",     "floating", "tower",
                                         "array", "samples"};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        if (!worlds_with(&seen.places, places[i]))
            fail_msg("no world is '%s'", places[i]);
    }
    /* about half have neither ground nor walls: single things, stacks, what floats */
    const int grounded =
        worlds_with(&seen.things, "ground") + worlds_with(&seen.things, "terrain");
    assert_in_range(grounded, 30 * WORLDS / 100, 65 * WORLDS / 100);
    assert_true(worlds_with(&seen.things, "terrain") >= WORLDS / 20);
    assert_true(worlds_with(&seen.things, "wall") >= WORLDS / 20);
}

static void every_kind_of_thing_is_there(void **state)
{
    (void)state;
    static const char *const things[] = {
        "basic",      "vase",   "rock",  "blob",     "symmetric", "carved",  "head",
        "helmet",     "figure", "cloth", "stairs",   "arch",      "column",  "clutter",
        "tablecloth", "table",  "tuft",  "lattice",  "machine",   "wire",    "cage",
        "chain",      "rope",   "tree",  "plate",    "wheel",     "pixels",  "frame",
        "relief",     "cup",    "pot",   "bottle",   "lamp",      "candles", "fruit",
        "bolt",       "book",   "discs", "mushroom", "building",  "vehicle", "seat"};
    for (size_t i = 0; i < sizeof things / sizeof things[0]; ++i) {
        if (!worlds_with(&seen.things, things[i]))
            fail_msg("no world has '%s'", things[i]);
    }
    assert_true(worlds_with(&seen.things, "head") >= 15 * WORLDS / 100);
    assert_true(seen.painted >= 10);
}

static void materials_cover_their_range(void **state)
{
    (void)state;
    const int m = seen.materials, p = seen.plain;
    assert_true(m > 2 * WORLDS);
    assert_in_range(seen.metals, 8 * p / 100, 35 * p / 100);
    assert_in_range(seen.textured, 25 * m / 100, 70 * m / 100);
    assert_in_range(seen.bumped, 10 * m / 100, 50 * m / 100);
    assert_in_range(seen.glowing, m / 200, 8 * m / 100);
    assert_in_range(seen.other_ior, 15 * m / 100, 50 * m / 100);
    assert_in_range(seen.tinted, 5 * m / 100, 25 * m / 100);
    assert_true(seen.two_sided > 0);
    assert_true(seen.least_ior < 1.36f && seen.most_ior > 1.8f &&
                seen.most_ior < 2.41f);
    assert_true(seen.polished > 5 * p / 100 && seen.rough > 10 * p / 100);
    assert_true(seen.dark > 3 * p / 100 && seen.bright > 3 * p / 100);
    assert_true(seen.middle > 45 * p / 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_two_are_equal),
        cmocka_unit_test(every_kind_of_place_is_there),
        cmocka_unit_test(every_kind_of_thing_is_there),
        cmocka_unit_test(materials_cover_their_range),
    };
    return cmocka_run_group_tests(tests, look, NULL);
}
