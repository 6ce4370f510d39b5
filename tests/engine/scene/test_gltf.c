/* The loader as a whole: bad input, containers, files, the shared models. What it makes of
 * the parts of a document is in tests/engine/scene/gltf. */
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "tests/engine/scene/gltf/fixture.h"

/* ---- bad input ------------------------------------------------------------------- */

static void faults_are_told(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to;
        enum pbnds_status status;
    } cases[] = {
        {"\"POSITION\":0", "\"POSITION\":4", PBNDS_ERROR_FORMAT},
        {"\"POSITION\":0", "\"POSITION\":-1", PBNDS_ERROR_FORMAT},
        {"\"POSITION\":0", "\"POSITION\":4294967296", PBNDS_ERROR_FORMAT},
        {"\"POSITION\":0", "\"POSITION\":2", PBNDS_ERROR_FORMAT}, /* VEC2 */
        {"\"POSITION\":0", "\"POSITION\":0.5", PBNDS_ERROR_FORMAT},
        {"\"NORMAL\":1", "\"NORMAL\":3", PBNDS_ERROR_FORMAT},
        {"\"NORMAL\":1", "\"COLOR_0\":2", PBNDS_ERROR_FORMAT},
        {"\"indices\":3", "\"indices\":4", PBNDS_ERROR_FORMAT},
        {"\"indices\":3", "\"indices\":0", PBNDS_ERROR_FORMAT},
        {"\"indices\":3", "\"indices\":3,\"material\":0", PBNDS_ERROR_FORMAT},
        {"\"indices\":3", "\"indices\":3,\"mode\":7", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":1", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"skin\":0", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"camera\":0", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"children\":[0]", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"children\":[1]", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"children\":[-1]", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"matrix\":[1,2,3]", PBNDS_ERROR_FORMAT},
        {"\"mesh\":0", "\"mesh\":0,\"scale\":[1e39,1,1]", PBNDS_ERROR_FORMAT},
        {"{\"mesh\":0}", "{},{\"children\":[2]},{\"children\":[1]}",
         PBNDS_ERROR_FORMAT},
        {"{\"mesh\":0}", "{\"children\":[1,2]},{\"children\":[2]},{}",
         PBNDS_ERROR_FORMAT},
        {"\"scene\":0", "\"scene\":1", PBNDS_ERROR_FORMAT},
        {"\"nodes\":[0]", "\"nodes\":[1]", PBNDS_ERROR_FORMAT},
        {"\"nodes\":[0]", "\"nodes\":[-1]", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"byteLength\":148", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"byteLength\":-1", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"byteLength\":18446744073709551615",
         PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"byteLength\":\"144\"", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":144", "\"uri\":7,\"byteLength\":144", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":128", "\"byteLength\":145", PBNDS_ERROR_FORMAT},
        {"\"byteLength\":128", "\"byteLength\":128,\"byteStride\":8",
         PBNDS_ERROR_FORMAT},
        {"\"byteLength\":128", "\"byteLength\":128,\"byteStride\":44",
         PBNDS_ERROR_FORMAT},
        {"\"byteOffset\":128", "\"byteOffset\":133", PBNDS_ERROR_FORMAT},
        {"\"byteOffset\":128", "\"byteOffset\":2147483647", PBNDS_ERROR_FORMAT},
        {"\"byteOffset\":48", "\"byteOffset\":81", PBNDS_ERROR_FORMAT},
        {"\"byteOffset\":48", "\"byteOffset\":120", PBNDS_ERROR_FORMAT},
        {"{\"nodes\":[0]}],\"nodes\":[{",
         "{\"nodes\":[1]}],\"nodes\":[{\"children\":[1]},{",
         PBNDS_ERROR_FORMAT}, /* a scene of a node that is no root */
        {"\"bufferView\":1", "\"bufferView\":2", PBNDS_ERROR_FORMAT},
        {"\"buffer\":0", "\"buffer\":1", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":5", PBNDS_ERROR_FORMAT},
        {"\"count\":4", "\"count\":2147483647", PBNDS_ERROR_FORMAT},
        {"\"count\":6", "\"count\":2147483647", PBNDS_ERROR_FORMAT},
        {"\"componentType\":5123", "\"componentType\":5126", PBNDS_ERROR_FORMAT},
        {"\"componentType\":5123", "\"componentType\":5122", PBNDS_ERROR_FORMAT},
        {"\"componentType\":5126", "\"componentType\":5130", PBNDS_ERROR_FORMAT},
        {"\"version\":\"2.0\"", "\"version\":\"1.0\"", PBNDS_ERROR_UNSUPPORTED},
        {"\"version\":\"2.0\"", "\"version\":\"x\"", PBNDS_ERROR_FORMAT},
        {"\"version\":\"2.0\"", "\"version\":\"2.0\",\"minVersion\":\"2.9\"",
         PBNDS_ERROR_UNSUPPORTED},
        {"\"asset\"", "\"atlas\"", PBNDS_ERROR_FORMAT},
        {"\"buffers\"",
         "\"extensionsRequired\":[\"KHR_texture_basisu\"],\"buffers\"",
         PBNDS_ERROR_UNSUPPORTED},
        {"\"buffers\"", "\"buffers\":[],\"buffers\"", PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"materials\":[{\"alphaMode\":\"GLASS\"}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"materials\":[{\"normalTexture\":{\"index\":0}}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"materials\":[{\"emissiveFactor\":[-1,0,0]}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"textures\":[{\"source\":0}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"textures\":[{\"sampler\":0}],\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"", "\"skins\":[{\"joints\":[1]}],\"buffers\"", PBNDS_ERROR_FORMAT},
        {"\"buffers\"",
         "\"images\":[{\"bufferView\":0}],\"textures\":[{\"source\":0}],"
         "\"materials\":[{\"normalTexture\":{\"index\":0}}],\"buffers\"",
         PBNDS_ERROR_UNSUPPORTED}, /* of no known picture format */
        {"\"buffers\"",
         "\"images\":[{\"uri\":\"data:image/png;base64,####\"}],\"textures\":"
         "[{\"source\":0}],\"materials\":[{\"normalTexture\":{\"index\":0}}],"
         "\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"",
         "\"images\":[{\"uri\":\"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAI\"}],"
         "\"textures\":[{\"source\":0}],\"materials\":[{\"normalTexture\":{\"index\":0}"
         "}],"
         "\"buffers\"",
         PBNDS_ERROR_FORMAT},
        {"\"buffers\"",
         "\"images\":[{\"uri\":\"a.png\"}],\"textures\":[{\"source\":0}],"
         "\"materials\":[{\"normalTexture\":{\"index\":0}}],\"buffers\"",
         PBNDS_ERROR_IO}, /* from memory no file may be opened */
        {"\"indices\":3}]}],", "\"indices\":3}]},", PBNDS_ERROR_FORMAT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        struct pbnds_scene s;
        char *json = edit(square_json, cases[i].from, cases[i].to);
        const enum pbnds_status status = load(json, &square, sizeof square, &s);
        if (status != cases[i].status) {
            fail_msg("%s -> %s gives %d, not %d: %s", cases[i].from, cases[i].to,
                     status, cases[i].status, fault.message);
        }
        free(json);
    }
}

static void numbers_in_extras_are_free(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_edit("\"mesh\":0", "\"mesh\":0,\"extras\":{\"count\":-1,\"mesh\":1e300}", &s);
    pbnds_scene_free(&s);
}

static void truncation_at_every_byte_is_told(void **state)
{
    (void)state;
    size_t size = 0;
    uint8_t *glb = make_glb(square_json, &square, sizeof square, &size);
    for (size_t n = 0; n < size; ++n) {
        uint8_t *part = malloc(n + 1); /* its own block: a read beyond it is seen */
        struct pbnds_scene s;
        memcpy(part, glb, n);
        const enum pbnds_status status =
            pbnds_gltf_load_memory(part, n, "part.glb", NULL, NULL, NULL, &s, &fault);
        if (status != PBNDS_ERROR_FORMAT)
            fail_msg("%zu of %zu bytes: %d", n, size, status);
        free(part);
    }
    /* The JSON alone, as .gltf, cut at every byte. */
    for (size_t n = 0; n + 1 < sizeof square_json; ++n) {
        struct pbnds_scene s;
        const enum pbnds_status status = pbnds_gltf_load_memory(
            square_json, n, "part.gltf", NULL, NULL, NULL, &s, &fault);
        if (status != PBNDS_ERROR_FORMAT) fail_msg("%zu bytes of JSON: %d", n, status);
    }
    free(glb);
}

static void damage_at_every_byte_is_survived(void **state)
{
    (void)state;
    static const uint8_t damage[] = {0x00, 0xff, '9', '"', '-', '['};
    size_t size = 0;
    uint8_t *glb = make_glb(square_json, &square, sizeof square, &size);
    int loaded = 0;
    for (size_t i = 0; i < size; ++i) {
        for (size_t k = 0; k < sizeof damage; ++k) {
            const uint8_t kept = glb[i];
            struct pbnds_scene s;
            glb[i] = damage[k];
            if (pbnds_gltf_load_memory(glb, size, "bad.glb", NULL, NULL, NULL, &s,
                                       &fault) == PBNDS_OK) {
                assert_sound(&s);
                ++loaded;
            } else {
                assert_non_null(strstr(fault.message, "bad.glb"));
            }
            pbnds_scene_free(&s);
            glb[i] = kept;
        }
    }
    assert_true(loaded > 0); /* e.g. in names */
    free(glb);
}

static void deep_json_is_refused(void **state)
{
    (void)state;
    enum { DEPTH = 200000 };
    char *deep = malloc(2 * DEPTH + 100);
    const char *head = "\"mesh\":0,\"extras\":";
    strcpy(deep, head);
    memset(deep + strlen(head), '[', DEPTH);
    memset(deep + strlen(head) + DEPTH, ']', DEPTH);
    deep[strlen(head) + 2 * DEPTH] = 0;
    char *json = edit(square_json, "\"mesh\":0", deep);
    struct pbnds_scene s;
    assert_int_equal(load(json, &square, sizeof square, &s), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(fault.message, "deep"));
    free(deep);
    free(json);
}

/* ---- containers and files ---------------------------------------------------------
 */

static void write_file(const char *path, const void *data, size_t size)
{
    assert_int_equal(pbnds_file_write(path, data, size, &fault), PBNDS_OK);
}

/** Writes the square as a .gltf whose buffer is `uri`, and loads it. */
static enum pbnds_status load_uri(const char *folder, const char *uri,
                                  struct pbnds_scene *s)
{
    char path[300], buffer[400];
    (void)snprintf(path, sizeof path, "%s/square.gltf", folder);
    (void)snprintf(buffer, sizeof buffer, "{\"byteLength\":144,\"uri\":\"%s\"}", uri);
    char *json = edit(square_json, "{\"byteLength\":144}", buffer);
    write_file(path, json, strlen(json));
    free(json);
    return pbnds_gltf_load(path, NULL, &ear, s, &fault);
}

static void uris_stay_below_the_folder(void **state)
{
    (void)state;
    static const struct {
        const char *uri;
        enum pbnds_status status;
    } cases[] = {
        {"a.bin", PBNDS_OK},
        {"./a.bin", PBNDS_OK},
        {"sub/a.bin", PBNDS_OK},
        {"sub//a.bin", PBNDS_OK},
        {"with%20space.bin", PBNDS_OK},
        {"with space.bin", PBNDS_OK},
        {"one+one.bin", PBNDS_OK},
        {"100%.bin", PBNDS_OK},
        {"\\u0061.bin", PBNDS_OK},
        {"sub\\/a.bin", PBNDS_OK},
        {"long.bin", PBNDS_OK},   /* longer than byteLength is fine */
        {"inside.bin", PBNDS_OK}, /* a link that stays inside */
        {"short.bin", PBNDS_ERROR_FORMAT},
        {"empty.bin", PBNDS_ERROR_FORMAT},
        {"none.bin", PBNDS_ERROR_IO},
        {"sub", PBNDS_ERROR_IO},
        {"pipe", PBNDS_ERROR_IO}, /* must not block */
        {"", PBNDS_ERROR_FORMAT},
        {"../jail-outside.bin", PBNDS_ERROR_FORMAT},
        {"sub/../a.bin", PBNDS_ERROR_FORMAT},
        {"%2e%2e/jail-outside.bin", PBNDS_ERROR_FORMAT},
        {"sub/%2E%2E/%2e%2e/jail-outside.bin", PBNDS_ERROR_FORMAT},
        {"..\\\\jail-outside.bin", PBNDS_ERROR_FORMAT},
        {"a.bin%00.png", PBNDS_ERROR_FORMAT},
        {"/etc/passwd", PBNDS_ERROR_FORMAT},
        {"//etc/passwd", PBNDS_ERROR_FORMAT},
        {"%2fetc/passwd", PBNDS_ERROR_FORMAT},
        {"file:a.bin", PBNDS_ERROR_FORMAT},
        {"file:///etc/passwd", PBNDS_ERROR_FORMAT},
        {"http://localhost/a.bin", PBNDS_ERROR_FORMAT},
        {"outside.bin", PBNDS_ERROR_FORMAT},         /* a link out */
        {"up/jail-outside.bin", PBNDS_ERROR_FORMAT}, /* through a linked folder */
        {"data:application/octet-stream;base64,AAAA", PBNDS_ERROR_FORMAT}, /* 3 bytes */
        {"data:application/octet-stream", PBNDS_ERROR_FORMAT},
    };
    assert_int_equal(pbnds_make_folder("jail/sub", &fault), PBNDS_OK);
    static const char *const full[] = {"jail/a.bin",          "jail/sub/a.bin",
                                       "jail/with space.bin", "jail/one+one.bin",
                                       "jail/100%.bin",       "jail-outside.bin"};
    for (size_t i = 0; i < 6; ++i)
        write_file(full[i], &square, sizeof square);
    uint8_t longer[200] = {0};
    memcpy(longer, &square, sizeof square);
    write_file("jail/long.bin", longer, sizeof longer);
    write_file("jail/short.bin", longer, 143);
    write_file("jail/empty.bin", longer, 0);
    (void)unlink("jail/outside.bin");
    (void)unlink("jail/inside.bin");
    (void)unlink("jail/up");
    (void)unlink("jail/pipe");
    assert_int_equal(symlink("../jail-outside.bin", "jail/outside.bin"), 0);
    assert_int_equal(symlink("sub/a.bin", "jail/inside.bin"), 0);
    assert_int_equal(symlink("..", "jail/up"), 0);
    assert_int_equal(mkfifo("jail/pipe", 0600), 0);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        struct pbnds_scene s;
        const enum pbnds_status status = load_uri("jail", cases[i].uri, &s);
        if (status != cases[i].status) {
            fail_msg("%s gives %d, not %d: %s", cases[i].uri, status, cases[i].status,
                     status ? fault.message : "");
        }
        if (status == PBNDS_OK) assert_int_equal(s.triangle_count, 2);
        pbnds_scene_free(&s);
    }
}

static void a_file_needs_no_folder(void **state)
{
    (void)state;
    struct pbnds_scene s;
    size_t size = 0;
    uint8_t *glb = make_glb(square_json, &square, sizeof square, &size);
    write_file("square.glb", glb, size);
    free(glb);
    assert_int_equal(pbnds_gltf_load("square.glb", NULL, NULL, &s, NULL), PBNDS_OK);
    pbnds_scene_free(&s);
    assert_int_equal(pbnds_gltf_load("no-such.glb", NULL, NULL, &s, &fault),
                     PBNDS_ERROR_IO);
    assert_non_null(strstr(fault.message, "no-such.glb"));
    assert_int_equal(pbnds_gltf_load(".", NULL, NULL, &s, &fault), PBNDS_ERROR_IO);
    write_file("empty.glb", "", 0);
    assert_int_equal(pbnds_gltf_load("empty.glb", NULL, NULL, &s, &fault),
                     PBNDS_ERROR_FORMAT);
    write_file("magic.glb", "GLTF\2\0\0\0\24\0\0\0\0\0\0\0JSON", 20);
    assert_int_equal(pbnds_gltf_load("magic.glb", NULL, NULL, &s, &fault),
                     PBNDS_ERROR_FORMAT);
}

static void other_chunks_are_passed_over(void **state)
{
    (void)state;
    size_t size = 0;
    uint8_t *glb = make_glb(square_json, &square, sizeof square, &size);
    uint8_t *more = malloc(size + 20);
    struct pbnds_scene s;
    memcpy(more, glb, size);
    memcpy(more + size, "\4\0\0\0XTRAabcdtail....", 20);
    put_u32(more + 8, size + 12); /* a third chunk, and bytes after the end */
    assert_int_equal(pbnds_gltf_load_memory(more, size + 20, "more.glb", NULL, NULL,
                                            NULL, &s, &fault),
                     PBNDS_OK);
    assert_int_equal(s.triangle_count, 2);
    pbnds_scene_free(&s);
    /* A BIN chunk that claims more than there is, in a header that claims no more. */
    put_u32(glb + size - sizeof square - 8, sizeof square + 4);
    assert_int_equal(
        pbnds_gltf_load_memory(glb, size, "chunk.glb", NULL, NULL, NULL, &s, &fault),
        PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(fault.message, "chunk 1"));
    free(glb);
    free(more);
}

/* ---- the shared models --------------------------------------------------------------
 */

static int files_seen, files_loaded;

static bool ends_with(const char *path, const char *end)
{
    const size_t a = strlen(path), b = strlen(end);
    return a >= b && strcmp(path + a - b, end) == 0;
}

static int try_file(const char *path, const struct stat *info, int type,
                    struct FTW *ftw)
{
    (void)info;
    (void)ftw;
    if (type != FTW_F || (!ends_with(path, ".glb") && !ends_with(path, ".gltf")))
        return 0;
    struct pbnds_scene s;
    warnings[0] = 0;
    const enum pbnds_status status = pbnds_gltf_load(path, NULL, &ear, &s, &fault);
    ++files_seen;
    if (status == PBNDS_OK) {
        ++files_loaded;
        assert_sound(&s);
    } else {
        assert_true(status == PBNDS_ERROR_FORMAT || status == PBNDS_ERROR_UNSUPPORTED ||
                    status == PBNDS_ERROR_IO);
        assert_non_null(strstr(fault.message, path));
        assert_null(strchr(fault.message, '\n'));
    }
    pbnds_scene_free(&s);
    return 0;
}

static void walk(const char *folder)
{
    files_seen = files_loaded = 0;
    if (access(folder, R_OK) != 0) skip();
    assert_int_equal(nftw(folder, try_file, 16, FTW_PHYS), 0);
}

static void shared_models_load(void **state)
{
    (void)state;
    walk(PBNDS_SHARED_DATA "/models");
    assert_true(files_seen > 10);
    assert_int_equal(files_loaded, files_seen);
}

static void malformed_files_are_survived(void **state)
{
    (void)state;
    walk(PBNDS_SHARED_DATA "/malformed");
    assert_true(files_seen > 100);
}

static void known_models_have_known_counts(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        size_t triangles;
        int meshes, cameras, images;
        double height;
    } cases[] = {
        {"BoxVertexColors/BoxVertexColors.glb", 12, 1, 0, 0, 1.0},
        {"Avocado/Avocado.gltf", 682, 1, 0, 3, 0.0629},
        {"CesiumMan/CesiumMan.glb", 4672, 1, 0, 1, 1.5066}, /* a man lying as stored */
        {"CornellBox/cornellBox.glb", 4006, 7, 1, 0, 3.0},
    };
    if (access(PBNDS_SHARED_DATA "/models/objects", R_OK) != 0) skip();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char path[1000];
        struct pbnds_scene s;
        (void)snprintf(path, sizeof path, "%s/models/objects/%s", PBNDS_SHARED_DATA,
                       cases[i].path);
        assert_int_equal(pbnds_gltf_load(path, NULL, NULL, &s, &fault), PBNDS_OK);
        assert_int_equal(s.triangle_count, cases[i].triangles);
        assert_int_equal(s.mesh_count, cases[i].meshes);
        assert_int_equal(s.camera_count, cases[i].cameras);
        assert_int_equal(s.image_count, cases[i].images);
        assert_near((double)(s.hi.y - s.lo.y), cases[i].height, 1e-3);
        pbnds_scene_free(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faults_are_told),
        cmocka_unit_test(numbers_in_extras_are_free),
        cmocka_unit_test(truncation_at_every_byte_is_told),
        cmocka_unit_test(damage_at_every_byte_is_survived),
        cmocka_unit_test(deep_json_is_refused),
        cmocka_unit_test(uris_stay_below_the_folder),
        cmocka_unit_test(a_file_needs_no_folder),
        cmocka_unit_test(other_chunks_are_passed_over),
        cmocka_unit_test(shared_models_load),
        cmocka_unit_test(malformed_files_are_survived),
        cmocka_unit_test(known_models_have_known_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
