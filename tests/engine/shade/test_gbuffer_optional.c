/* What a file may hold beyond the plain contract: optional planes, other spaces, several
 * samples, mattes. Everything is read back. */
#include <stdio.h>
#include <stdlib.h>

#include "engine/shade/cryptomatte.h"
#include "engine/shade/gbuffer_channels.h"
#include "engine/shade/gbuffer_header.h"
#include "tests/engine/shade/fixture.h"

enum { W = 31, H = 23, N = W * H };

#define PATH "gbuffer_optional.exr"

static void must_write(const struct pbnds_gbuffer *g,
                       const struct pbnds_gbuffer_origin *origin)
{
    struct pbnds_error error = {""};
    must(pbnds_gbuffer_write(PATH, g, origin, NULL, NULL, 0, PBNDS_EXR_ZIP, &error),
         &error);
}

static struct pbnds_gbuffer must_read(struct pbnds_gbuffer_origin *origin)
{
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    must(pbnds_gbuffer_read(PATH, &g, origin, NULL, NULL, &error), &error);
    return g;
}

/* Two tilted cards seen from above, the nearer one clear glass; values that halves hold
 * exactly, but for the normals. */
static void make_scene(struct fixture *f, bool fresnel)
{
    struct pbnds_mesh meshes[] = {
        quad(pbnds_vec3_make(-1, -1, 0), pbnds_vec3_make(2, 0, 0.4f),
             pbnds_vec3_make(0, 2, -0.3f), 0),
        quad(pbnds_vec3_make(-0.5f, -0.6f, 0.8f), pbnds_vec3_make(0.9f, 0.1f, 0),
             pbnds_vec3_make(0.1f, 1.1f, 0), 1)};
    for (uint32_t m = 0; m < 2; ++m) {
        meshes[m].object_id = 70000 + m;
        meshes[m].uv[0] = must_alloc(4, sizeof *meshes[m].uv[0]);
        for (int v = 0; v < 4; ++v)
            meshes[m].uv[0][v] =
                (struct pbnds_vec2){(float)(v % 2) + 0.1f, (float)(v / 2) - 7.0f};
        meshes[m].previous = must_alloc(4, sizeof *meshes[m].previous);
        for (int v = 0; v < 4; ++v)
            meshes[m].previous[v] =
                pbnds_add(meshes[m].position[v], pbnds_vec3_make(0.02f, 0.01f, 0));
    }
    struct pbnds_material materials[2] = {matte(0.5f), matte(0.25f)};
    snprintf(materials[0].name, sizeof materials[0].name, "wall");
    snprintf(materials[1].name, sizeof materials[1].name, "pane");
    materials[1].alpha_mode = PBNDS_ALPHA_BLEND;
    materials[1].base_color.w = 0.5f;
    materials[0].emissive = pbnds_vec3_make(4, 2, 1);
    materials[0].ior_f0 = 0.25f;
    materials[0].roughness = 0.75f;
    if (fresnel) {
        materials[1].specular = 0.5f;
        materials[1].ior_f0 = 0.5f;
        materials[1].specular_color = pbnds_vec3_make(1, 0.5f, 0.25f);
    }
    fixture_scene(f, meshes, 2, materials, 2);
}

static struct pbnds_camera oblique(bool orthographic)
{
    struct pbnds_camera c;
    memset(&c, 0, sizeof c);
    c.world_from_camera =
        pbnds_mat4_look_at(pbnds_vec3_make(0.7f, 1.1f, 2.4f),
                           pbnds_vec3_make(0.1f, 0, 0), pbnds_vec3_make(0, 1, 0));
    c.yfov = 0.9f;
    c.ymag = 1.3f;
    c.orthographic = orthographic;
    return c;
}

static struct pbnds_gbuffer cast(const struct fixture *f,
                                 const struct pbnds_camera *camera,
                                 const struct pbnds_raycast_options *options)
{
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    must(pbnds_gbuffer_raycast(&f->scene, f->accel, camera, W, H, options, &g, &error),
         &error);
    return g;
}

enum {
    ALL = PBNDS_OPTIONAL_AO | PBNDS_OPTIONAL_UV | PBNDS_OPTIONAL_MOTION |
          PBNDS_OPTIONAL_MATERIAL_ID
};

/* Every plane of the table: the floats and ids to the bit, halves to half's step, except
 * that normals turn into camera space and back. */
static void assert_same(const struct pbnds_gbuffer *got,
                        const struct pbnds_gbuffer *want)
{
    int planes = 0;
    for (int c = 0; c < pbnds_gbuffer_channel_count(); ++c) {
        const struct pbnds_gbuffer_channel *channel = pbnds_gbuffer_channel_at(c);
        const float *a = pbnds_gbuffer_real(got, channel);
        const float *b = pbnds_gbuffer_real(want, channel);
        assert_true((a == NULL) == (b == NULL));
        if (!a) continue;
        ++planes;
        if (channel->kind == PBNDS_CHANNEL_ID ||
            (channel->type == PBNDS_EXR_FLOAT && channel->kind != PBNDS_CHANNEL_AXIS)) {
            assert_memory_equal(a, b, N * sizeof(float));
            continue;
        }
        for (int i = 0; i < N; ++i)
            assert_near(a[i], b[i], fmax(fabs((double)b[i]) * 0x1p-11, 4e-7));
    }
    assert_true(planes >= 18);
    assert_int_equal(got->samples, want->samples);
    assert_int_equal(got->through, want->through);
}

static void every_plane_comes_back(void **state)
{
    (void)state;
    const struct pbnds_camera camera = oblique(false);
    struct pbnds_camera before = oblique(false);
    before.world_from_camera.m[13] += 0.03f;
    for (int k = 0; k < 4; ++k) {
        struct fixture f;
        make_scene(&f, k % 2 == 1);
        const struct pbnds_raycast_options options = {
            .optional = k < 2 ? ALL : 0u,
            .samples = k == 3 ? 6 : 1,
            .through = k == 3 ? PBNDS_THROUGH_ALPHA : PBNDS_THROUGH_FIRST,
            .previous_camera = &before};
        struct pbnds_gbuffer g = cast(&f, &camera, &options);
        assert_true((g.f90 != NULL) == (k % 2 == 1));
        must_write(&g, NULL);
        struct pbnds_gbuffer_origin origin;
        struct pbnds_gbuffer h = must_read(&origin);
        assert_same(&h, &g);
        assert_null(h.cryptomatte);
        assert_int_equal(origin.normal_space, PBNDS_NORMAL_CAMERA);
        assert_int_equal(origin.depth, PBNDS_DEPTH_PLANAR);
        pbnds_gbuffer_free(&h);
        pbnds_gbuffer_free(&g);
        fixture_free(&f);
    }
    remove(PATH);
}

/* Depth stays float, ids uint; see the table for what may be half. */
static void types_in_the_file(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        enum pbnds_exr_type type;
    } want[] = {{"uv.U", PBNDS_EXR_FLOAT},       {"uv.V", PBNDS_EXR_FLOAT},
                {"motion.U", PBNDS_EXR_FLOAT},   {"motion.V", PBNDS_EXR_FLOAT},
                {"material_id", PBNDS_EXR_UINT}, {"object_id", PBNDS_EXR_UINT},
                {"ao.R", PBNDS_EXR_HALF},        {"f0.R", PBNDS_EXR_HALF},
                {"f0.B", PBNDS_EXR_HALF},        {"f90.R", PBNDS_EXR_HALF},
                {"normal.X", PBNDS_EXR_FLOAT},   {"position.Z", PBNDS_EXR_FLOAT},
                {"Z", PBNDS_EXR_FLOAT},          {"coverage.A", PBNDS_EXR_HALF}};
    struct fixture f;
    make_scene(&f, true);
    const struct pbnds_camera camera = oblique(false);
    const struct pbnds_raycast_options options = {.optional = ALL};
    struct pbnds_gbuffer g = cast(&f, &camera, &options);
    must_write(&g, NULL);
    struct pbnds_exr exr;
    struct pbnds_error error = {""};
    must(pbnds_exr_read(PATH, &exr, &error), &error);
    for (size_t i = 0; i < sizeof want / sizeof want[0]; ++i) {
        const struct pbnds_exr_channel *c = pbnds_exr_find(&exr, want[i].name);
        assert_non_null(c);
        assert_int_equal(c->type, want[i].type);
    }
    pbnds_exr_free(&exr);
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
    remove(PATH);
}

/* The file holds what the header says, and the reader undoes it. */
static void spaces_and_depths(void **state)
{
    (void)state;
    for (int k = 0; k < 8; ++k) {
        struct fixture f;
        make_scene(&f, false);
        const bool orthographic = (k & 4) != 0;
        const struct pbnds_camera camera = oblique(orthographic);
        struct pbnds_gbuffer g = cast(&f, &camera, NULL);
        struct pbnds_gbuffer_origin origin = {.normal_space = k & 1,
                                              .depth = k >> 1 & 1};
        must_write(&g, &origin);
        struct pbnds_exr exr;
        struct pbnds_error error = {""};
        must(pbnds_exr_read(PATH, &exr, &error), &error);
        assert_string_equal(pbnds_header_string(&exr, "pbnds:normalSpace", ""),
                            k & 1 ? "world" : "camera");
        assert_string_equal(pbnds_header_string(&exr, "pbnds:depth", ""),
                            k & 2 ? "distance" : "planar");
        const float *z = pbnds_exr_find(&exr, "Z")->data;
        const float *ny = pbnds_exr_find(&exr, "normal.Y")->data;
        const float *m = camera.world_from_camera.m;
        int hits = 0;
        for (size_t i = 0; i < N; ++i) {
            if (g.coverage[i] == 0.0f) {
                assert_true(isinf(z[i]));
                continue;
            }
            ++hits;
            const struct pbnds_vec3 p = {g.position[0][i], g.position[1][i],
                                         g.position[2][i]};
            const struct pbnds_vec3 n = {g.normal[0][i], g.normal[1][i],
                                         g.normal[2][i]};
            const float length =
                pbnds_length(pbnds_sub(p, pbnds_vec3_make(m[12], m[13], m[14])));
            const float want = (k & 2) && !orthographic ? length : g.depth[i];
            assert_near(z[i], want, 2e-6);
            assert_near(
                ny[i], k & 1 ? n.y : pbnds_camera_from_world_vector(&camera, n).y, 0.0);
        }
        assert_in_range(hits, 100, N - 100);
        pbnds_exr_free(&exr);
        struct pbnds_gbuffer_origin back;
        struct pbnds_gbuffer h = must_read(&back);
        assert_int_equal(back.normal_space, origin.normal_space);
        assert_int_equal(back.depth, origin.depth);
        for (size_t i = 0; i < N; ++i) {
            if (g.coverage[i] == 0.0f) continue;
            assert_near(h.depth[i], g.depth[i], k & 2 ? 1e-6 : 0.0);
            for (int c = 0; c < 3; ++c)
                assert_near(h.normal[c][i], g.normal[c][i], k & 1 ? 0.0 : 4e-7);
        }
        pbnds_gbuffer_free(&h);
        pbnds_gbuffer_free(&g);
        fixture_free(&f);
    }
    remove(PATH);
}

/* Without a position channel it follows from depth of either kind. */
static void position_follows_from_distance(void **state)
{
    (void)state;
    struct fixture f;
    make_scene(&f, false);
    const struct pbnds_camera camera = oblique(false);
    struct pbnds_gbuffer g = cast(&f, &camera, NULL);
    const struct pbnds_gbuffer_origin origin = {.depth = PBNDS_DEPTH_DISTANCE};
    must_write(&g, &origin);
    struct pbnds_exr exr;
    struct pbnds_error error = {""};
    must(pbnds_exr_read(PATH, &exr, &error), &error);
    for (int c = 0; c < exr.channel_count; ++c) {
        if (strcmp(exr.channels[c].name, "position.X") == 0)
            snprintf(exr.channels[c].name, sizeof exr.channels[c].name, "other.X");
    }
    must(pbnds_exr_write(PATH, &exr, &error), &error);
    pbnds_exr_free(&exr);
    struct pbnds_gbuffer h = must_read(NULL);
    for (size_t i = 0; i < N; ++i) {
        if (g.coverage[i] == 0.0f) continue;
        for (int c = 0; c < 3; ++c)
            assert_near(h.position[c][i], g.position[c][i], 4e-6);
    }
    pbnds_gbuffer_free(&h);
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
    remove(PATH);
}

static void mattes_as_the_specification_says(void **state)
{
    (void)state;
    struct fixture f;
    make_scene(&f, false);
    const struct pbnds_camera camera = oblique(false);
    const struct pbnds_raycast_options options = {.optional =
                                                      PBNDS_OPTIONAL_CRYPTOMATTE,
                                                  .samples = 5,
                                                  .through = PBNDS_THROUGH_ALPHA};
    struct pbnds_gbuffer g = cast(&f, &camera, &options);
    must_write(&g, NULL);
    struct pbnds_exr exr;
    struct pbnds_error error = {""};
    must(pbnds_exr_read(PATH, &exr, &error), &error);
    /* 3ae39a58 is the hash of CryptoObject, be359d67 that of CryptoMaterial. */
    assert_string_equal(pbnds_header_string(&exr, "cryptomatte/3ae39a5/name", ""),
                        "CryptoObject");
    assert_string_equal(pbnds_header_string(&exr, "cryptomatte/3ae39a5/hash", ""),
                        "MurmurHash3_32");
    assert_string_equal(pbnds_header_string(&exr, "cryptomatte/be359d6/conversion", ""),
                        "uint32_to_float32");
    char want[128];
    snprintf(want, sizeof want, "{\"pane\":\"%08x\",\"wall\":\"%08x\"}",
             pbnds_cryptomatte_id("pane"), pbnds_cryptomatte_id("wall"));
    assert_string_equal(pbnds_header_string(&exr, "cryptomatte/be359d6/manifest", ""),
                        want);
    const struct pbnds_cryptomatte_layer *layer = &g.cryptomatte->layers[1];
    static const struct {
        const char *channel;
        int rank;
        bool share;
    } places[] = {{"CryptoMaterial00.R", 0, false}, {"CryptoMaterial00.G", 0, true},
                  {"CryptoMaterial00.B", 1, false}, {"CryptoMaterial00.A", 1, true},
                  {"CryptoMaterial02.B", 5, false}, {"CryptoMaterial01.G", 2, true}};
    for (size_t k = 0; k < sizeof places / sizeof places[0]; ++k) {
        const struct pbnds_exr_channel *c = pbnds_exr_find(&exr, places[k].channel);
        assert_non_null(c);
        assert_int_equal(c->type, PBNDS_EXR_FLOAT);
        assert_memory_equal(c->data,
                            places[k].share ? layer->share[places[k].rank]
                                            : layer->id[places[k].rank],
                            N * sizeof(float));
    }
    pbnds_exr_free(&exr);
    struct pbnds_gbuffer h = must_read(NULL);
    assert_non_null(h.cryptomatte);
    const size_t planes =
        (size_t)2 * PBNDS_CRYPTOMATTE_LAYERS * PBNDS_CRYPTOMATTE_RANKS;
    assert_memory_equal(h.cryptomatte->storage, g.cryptomatte->storage,
                        planes * N * sizeof(float));
    assert_string_equal(h.cryptomatte->layers[0].manifest,
                        g.cryptomatte->layers[0].manifest);
    pbnds_gbuffer_free(&h);
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
    remove(PATH);
}

static void set_string(struct pbnds_exr *exr, const char *name, const char *value)
{
    for (int i = 0; i < exr->attribute_count; ++i) {
        if (strcmp(exr->attributes[i].name, name) != 0) continue;
        snprintf(exr->attributes[i].value.string, 64, "%s", value);
        return;
    }
    fail_msg("no attribute %s", name);
}

static void unknown_words_are_refused(void **state)
{
    (void)state;
    static const char *const names[] = {"pbnds:depth", "pbnds:through",
                                        "pbnds:normalSpace"};
    struct fixture f;
    make_scene(&f, false);
    const struct pbnds_camera camera = oblique(false);
    struct pbnds_gbuffer g = cast(&f, &camera, NULL), h;
    struct pbnds_error error = {""};
    for (int k = 0; k < 4; ++k) {
        must_write(&g, NULL);
        struct pbnds_exr exr;
        must(pbnds_exr_read(PATH, &exr, &error), &error);
        if (k < 3) {
            set_string(&exr, names[k], "sideways");
        } else {
            for (int i = 0; i < exr.attribute_count; ++i) {
                if (strcmp(exr.attributes[i].name, "pbnds:samples") == 0)
                    exr.attributes[i].value.i = 0;
            }
        }
        must(pbnds_exr_write(PATH, &exr, &error), &error);
        pbnds_exr_free(&exr);
        assert_int_equal(pbnds_gbuffer_read(PATH, &h, NULL, NULL, NULL, &error),
                         PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(error.message, k < 3 ? names[k] : "pbnds:samples"));
        assert_null(h.storage);
    }
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
    remove(PATH);
}

/* Half an optional layer is none; one with a NaN where something was hit is refused. */
static void optional_planes_are_checked(void **state)
{
    (void)state;
    struct fixture f;
    make_scene(&f, true);
    const struct pbnds_camera camera = oblique(false);
    const struct pbnds_raycast_options options = {.optional = ALL};
    struct pbnds_gbuffer g = cast(&f, &camera, &options), h;
    struct pbnds_error error = {""};
    size_t hit = 0, miss = 0;
    for (size_t i = 0; i < N; ++i) {
        if (g.coverage[i] > 0.0f) hit = i;
        if (g.coverage[i] == 0.0f) miss = i;
    }
    g.uv[1][miss] = g.f0[2][miss] = NAN;
    must_write(&g, NULL);
    h = must_read(NULL);
    assert_near(h.uv[1][miss], 0.0, 0.0);
    pbnds_gbuffer_free(&h);
    static const char *const names[] = {"uv.V", "f0.G", "motion.U", "ao.R", "f90.R"};
    float *const planes[] = {g.uv[1], g.f0[1], g.motion[0], g.ao, g.f90};
    for (int k = 0; k < 5; ++k) {
        const float kept = planes[k][hit];
        planes[k][hit] = NAN;
        must_write(&g, NULL);
        planes[k][hit] = kept;
        assert_int_equal(pbnds_gbuffer_read(PATH, &h, NULL, NULL, NULL, &error),
                         PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(error.message, names[k]));
    }
    float *const v = g.uv[1];
    g.uv[1] = NULL; /* the table then lists uv.U alone */
    must_write(&g, NULL);
    g.uv[1] = v;
    h = must_read(NULL);
    assert_null(h.uv[0]);
    assert_non_null(h.motion[1]);
    pbnds_gbuffer_free(&h);
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
    remove(PATH);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_plane_comes_back),
        cmocka_unit_test(types_in_the_file),
        cmocka_unit_test(spaces_and_depths),
        cmocka_unit_test(position_follows_from_distance),
        cmocka_unit_test(mattes_as_the_specification_says),
        cmocka_unit_test(unknown_words_are_refused),
        cmocka_unit_test(optional_planes_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
