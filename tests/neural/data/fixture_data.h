/** A small data set for the tests: two boxes in glTF, three light maps, written by the
 * test. */
#ifndef PBNDS_TESTS_NEURAL_FIXTURE_DATA_H
#define PBNDS_TESTS_NEURAL_FIXTURE_DATA_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/test.h"

#include "engine/core/file.h"
#include "engine/image/exr.h"
#include "neural/data/dataset.h"

/* A tetrahedron on a triangle of ground: 15 points of 12 bytes. */
static inline void fixture_points(float height, unsigned char bytes[180])
{
    const float v[15][3] = {
        {-2, 0, 2},     {2, 0, 2},      {0, 0, -3},   {-1, .1f, 1},   {1, .1f, 1},
        {0, height, 0}, {1, .1f, 1},    {0, .1f, -1}, {0, height, 0}, {0, .1f, -1},
        {-1, .1f, 1},   {0, height, 0}, {-1, .1f, 1}, {0, .1f, -1},   {1, .1f, 1}};
    memcpy(bytes, v, sizeof v);
}

/* Non-indexed, positions only, from a buffer of fixture_points(). */
static inline void fixture_gltf_of(const char *path, const char *uri)
{
    char text[2048];
    const int length =
        snprintf(text, sizeof text,
                 "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],"
                 "\"nodes\":[{\"mesh\":0}],"
                 "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
                 "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":15,"
                 "\"type\":\"VEC3\",\"min\":[-2,0,-3],\"max\":[2,3,2]}],"
                 "\"bufferViews\":[{\"buffer\":0,\"byteLength\":180}],\"buffers\":[{"
                 "\"byteLength\":180,\"uri\":\"%s\"}]}",
                 uri);
    assert_int_equal(pbnds_file_write(path, text, (size_t)length, NULL), PBNDS_OK);
}

/* The same with the points as a data URI. */
static inline void fixture_gltf(const char *path, float height)
{
    unsigned char bytes[180];
    fixture_points(height, bytes);
    static const char DIGITS[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char uri[64 + 4 * sizeof bytes / 3 + 1] = "data:application/octet-stream;base64,";
    char *base64 = uri + strlen(uri);
    size_t n = 0;
    for (size_t i = 0; i < sizeof bytes; i += 3) { /* 180 bytes: a multiple of three */
        const unsigned w =
            (unsigned)bytes[i] << 16 | (unsigned)bytes[i + 1] << 8 | bytes[i + 2];
        for (unsigned k = 0; k < 4; ++k)
            base64[n++] = DIGITS[w >> (18 - 6 * k) & 63u];
    }
    base64[n] = 0;
    fixture_gltf_of(path, uri);
}

static inline void fixture_light(const char *path, int lamp)
{
    float plane[3][8 * 16];
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < 8 * 16; ++i)
            plane[c][i] = 0.2f + 0.1f * (float)c;
        plane[c][lamp] = 30.0f;
    }
    struct pbnds_exr_channel channels[3] = {{"R", PBNDS_EXR_FLOAT, plane[0]},
                                            {"G", PBNDS_EXR_FLOAT, plane[1]},
                                            {"B", PBNDS_EXR_FLOAT, plane[2]}};
    const struct pbnds_exr exr = {.width = 16,
                                  .height = 8,
                                  .compression = PBNDS_EXR_NONE,
                                  .channels = channels,
                                  .channel_count = 3};
    assert_int_equal(pbnds_exr_write(path, &exr, NULL), PBNDS_OK);
}

/* ROOT/{train,val,test}/{a,b,c}.gltf and .exr */
static inline void fixture_assets(const char *root)
{
    static const char *const SPLITS[] = {"train", "val", "test"};
    for (int s = 0; s < 3; ++s) {
        char path[256];
        (void)snprintf(path, sizeof path, "%s/%s", root, SPLITS[s]);
        assert_int_equal(pbnds_make_folder(path, NULL), PBNDS_OK);
        (void)snprintf(path, sizeof path, "%s/%s/shape%d.gltf", root, SPLITS[s], s);
        fixture_gltf(path, 1.0f + (float)s);
        (void)snprintf(path, sizeof path, "%s/%s/light%d.exr", root, SPLITS[s], s);
        fixture_light(path, 20 + 5 * s);
    }
}

/* `count` samples of all splits: a tenth val, a tenth test. */
static inline struct pbnds_dataset_recipe
fixture_recipe(struct pbnds_dataset_source *root, int count)
{
    struct pbnds_dataset_recipe recipe;
    pbnds_dataset_recipe_init(&recipe);
    pbnds_dataset_recipe_count(&recipe, count);
    recipe.scenes = root;
    recipe.scene_count = 1;
    recipe.envs = root;
    recipe.env_count = 1;
    recipe.width = 32;
    recipe.height = 32;
    recipe.spp = 4;
    recipe.seed = 3;
    return recipe;
}

static inline void fixture_remove(const char *folder)
{
    char command[512];
    (void)snprintf(command, sizeof command, "rm -rf '%s'", folder);
    assert_int_equal(system(command), 0);
}

/* Do two files hold the same bytes? */
static inline bool fixture_same(const char *a, const char *b)
{
    uint8_t *x, *y;
    size_t n, m;
    assert_int_equal(pbnds_file_read(a, (size_t)1 << 30, &x, &n, NULL), PBNDS_OK);
    assert_int_equal(pbnds_file_read(b, (size_t)1 << 30, &y, &m, NULL), PBNDS_OK);
    const bool same = n == m && memcmp(x, y, n) == 0;
    free(x);
    free(y);
    return same;
}
#endif /* PBNDS_TESTS_NEURAL_FIXTURE_DATA_H */
