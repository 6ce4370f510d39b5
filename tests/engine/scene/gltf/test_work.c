/* Files that cost nothing to write and for ever to read: what is shared is read for each
 * who shares it. Each of these would take minutes, or hours, unless it is refused or worked
 * out once. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/engine/scene/gltf/fixture.h"

/** A text that grows. */
struct text {
    char *bytes;
    size_t size, room;
};

static void put(struct text *t, const char *piece)
{
    const size_t n = strlen(piece);
    if (t->size + n + 1 > t->room) {
        t->room = 2 * (t->size + n + 1);
        t->bytes = realloc(t->bytes, t->room);
        assert_non_null(t->bytes);
    }
    memcpy(t->bytes + t->size, piece, n + 1);
    t->size += n;
}

/** head, then `count` pieces with commas between, then tail. */
static void put_list(struct text *t, const char *head, const char *piece, size_t count,
                     const char *tail)
{
    put(t, head);
    for (size_t i = 0; i < count; ++i) {
        if (i) put(t, ",");
        put(t, piece);
    }
    put(t, tail);
}

static void must_be_refused(struct text *t, uint64_t max_geometry)
{
    static const uint8_t zeros[12] = {0};
    const struct pbnds_gltf_options options = {.max_geometry = max_geometry};
    struct pbnds_scene s;
    assert_int_equal(load_with(t->bytes, zeros, sizeof zeros, &options, &s),
                     PBNDS_ERROR_MEMORY);
    assert_non_null(strstr(fault.message, "over and over"));
    free(t->bytes);
}

/* 5000 targets that are one accessor of 2^20 elements, one of which is in the file. */
static void morph_targets_that_are_one(void **state)
{
    (void)state;
    struct text t = {0};
    put_list(
        &t,
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"buffers\":[{"
        "\"byteLength\":12}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":12}],"
        "\"accessors\":[{\"componentType\":5126,\"count\":1048576,\"type\":\"VEC3\","
        "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5121},"
        "\"values\":{\"bufferView\":0}}}],\"meshes\":[{"
        "\"weights\":[",
        "1", 5000, "],\"primitives\":[{\"attributes\":{\"POSITION\":0},");
    put_list(&t, "\"targets\":[", "{\"POSITION\":0}", 5000, "]}]}]}");
    must_be_refused(&t, 100 << 20);
}

/* 20000 nodes with one skin of 20000 joints. */
static void nodes_that_share_a_skin(void **state)
{
    (void)state;
    struct text t = {0};
    put_list(
        &t,
        "{\"asset\":{\"version\":\"2.0\"},\"accessors\":[{\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC3\"},{\"componentType\":5121,\"count\":3,"
        "\"type\":\"VEC4\"},{\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":1,"
        "\"WEIGHTS_0\":2}}]}],\"nodes\":[",
        "{\"mesh\":0,\"skin\":0}", 20000, "],\"skins\":[{\"joints\":[");
    put_list(&t, "", "7", 20000, "]}]}");
    /* The skin is worked out once. */
    const struct pbnds_gltf_options options = {.max_geometry = 100 << 20};
    struct pbnds_scene s;
    assert_int_equal(load_with(t.bytes, NULL, 0, &options, &s), PBNDS_OK);
    assert_int_equal(s.mesh_count, 20000);
    pbnds_scene_free(&s);
    free(t.bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(morph_targets_that_are_one),
        cmocka_unit_test(nodes_that_share_a_skin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
