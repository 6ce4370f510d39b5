#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "engine/shade/gbuffer.h"

enum { W = 9, H = 7, N = W * H };

static float uniform(struct pbnds_rng *rng, float lo, float hi)
{
    return lo + (hi - lo) * pbnds_rng_float(rng);
}

/* Random planes that keep the contract; every fourth pixel is empty. */
static void make_gbuffer(struct pbnds_gbuffer *g, bool turned)
{
    struct pbnds_error error;
    assert_int_equal(pbnds_gbuffer_init(g, W, H, &error), PBNDS_OK);
    memcpy(g->camera.name, "left eye", 9);
    g->camera.yfov = 0.7f;
    g->camera.ymag = 1.25f;
    if (turned) {
        g->camera.world_from_camera = pbnds_mat4_look_at(
            pbnds_vec3_make(1, 2, 3), pbnds_vec3_make(-0.3f, 0.1f, 0.2f),
            pbnds_vec3_make(0, 1, 0));
    }
    struct pbnds_rng rng = pbnds_rng_make(5, 0, 0);
    for (int y = 0; y < H; ++y) {
        for (int x = 0; x < W; ++x) {
            const size_t i = (size_t)y * W + (size_t)x;
            if (i % 4 == 3) continue;
            const struct pbnds_vec3 wo = pbnds_gbuffer_wo(g, x, y);
            const struct pbnds_vec3 n = pbnds_normalize(
                pbnds_add(wo, pbnds_vec3_make(uniform(&rng, -0.5f, 0.5f),
                                              uniform(&rng, -0.5f, 0.5f),
                                              uniform(&rng, -0.5f, 0.5f))));
            g->normal[0][i] = n.x;
            g->normal[1][i] = n.y;
            g->normal[2][i] = n.z;
            for (int c = 0; c < 3; ++c) {
                g->albedo[c][i] = pbnds_rng_float(&rng);
                g->emission[c][i] = uniform(&rng, 0.0f, 30.0f);
                g->position[c][i] = uniform(&rng, -3.0f, 3.0f);
            }
            g->specular[i] = pbnds_rng_float(&rng);
            g->roughness[i] = pbnds_rng_float(&rng);
            g->metallic[i] = pbnds_rng_float(&rng);
            g->depth[i] = uniform(&rng, 0.1f, 1e4f);
            g->coverage[i] = 1.0f;
            g->object_id[i] = (uint32_t)(pbnds_rng_u64(&rng) >> 33);
        }
    }
}

static void write_ok(const char *path, const struct pbnds_gbuffer *g,
                     const struct pbnds_gbuffer_origin *origin,
                     const struct pbnds_image *radiance,
                     const struct pbnds_exr_channel *extra, int extra_count)
{
    struct pbnds_error error = {""};
    if (pbnds_gbuffer_write(path, g, origin, radiance, extra, extra_count,
                            PBNDS_EXR_ZIP, &error) != PBNDS_OK) {
        fail_msg("%s", error.message);
    }
}

static struct pbnds_gbuffer read_ok(const char *path)
{
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    if (pbnds_gbuffer_read(path, &g, NULL, NULL, NULL, &error) != PBNDS_OK) {
        fail_msg("%s", error.message);
    }
    return g;
}

static void assert_half(float got, float want)
{
    /* Eleven significant bits, rounded to nearest; below 2^-14 a fixed step. */
    assert_near(got, want, fmax((double)fabsf(want) * 0x1p-11, 0x1p-25));
}

static void round_trip(void **state)
{
    (void)state;
    const char *path = "gbuffer_round_trip.exr";
    struct pbnds_gbuffer g;
    make_gbuffer(&g, true);
    struct pbnds_gbuffer_origin origin = {"sunset \xc3\xa9t\xc3\xa9.hdr",
                                          12.5f,
                                          0.75f,
                                          "openexr",
                                          18446744073709551615u,
                                          PBNDS_NORMAL_CAMERA,
                                          PBNDS_DEPTH_PLANAR,
                                          PBNDS_TARGET_DISPLAY,
                                          "pbnds gbuffer head.glb -o x.exr",
                                          ""};
    struct pbnds_image radiance;
    struct pbnds_error error;
    assert_int_equal(pbnds_image_init(&radiance, W, H, 3, &error), PBNDS_OK);
    float target[N];
    for (int i = 0; i < 3 * N; ++i)
        radiance.data[i] = 1e6f / (float)(i + 1);
    for (int i = 0; i < N; ++i)
        target[i] = (float)i / 7.0f;
    struct pbnds_exr_channel extra = {"target.R", PBNDS_EXR_FLOAT, target};
    write_ok(path, &g, &origin, &radiance, &extra, 1);

    struct pbnds_gbuffer h;
    struct pbnds_gbuffer_origin back;
    struct pbnds_image light;
    struct pbnds_exr exr;
    assert_int_equal(pbnds_gbuffer_read(path, &h, &back, &light, &exr, &error),
                     PBNDS_OK);
    assert_int_equal(h.width, W);
    assert_int_equal(h.height, H);
    assert_memory_equal(h.depth, g.depth, N * sizeof(float));
    assert_memory_equal(h.object_id, g.object_id, N * sizeof(uint32_t));
    assert_memory_equal(h.coverage, g.coverage, N * sizeof(float));
    assert_memory_equal(light.data, radiance.data, 3 * N * sizeof(float));
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(h.position[c], g.position[c], N * sizeof(float));
        for (int i = 0; i < N; ++i) {
            assert_half(h.albedo[c][i], g.albedo[c][i]);
            assert_half(h.emission[c][i], g.emission[c][i]);
            assert_near(h.normal[c][i], g.normal[c][i], 4e-7);
            assert_near(h.geometric_normal[c][i], h.normal[c][i], 0.0);
        }
    }
    for (int i = 0; i < N; ++i) {
        assert_half(h.specular[i], g.specular[i]);
        assert_half(h.roughness[i], g.roughness[i]);
        assert_half(h.metallic[i], g.metallic[i]);
    }
    assert_string_equal(h.camera.name, "left eye");
    assert_memory_equal(&h.camera.world_from_camera, &g.camera.world_from_camera,
                        sizeof g.camera.world_from_camera);
    assert_true(h.camera.yfov == 0.7f && h.camera.ymag == 1.25f);
    assert_false(h.camera.orthographic);
    assert_string_equal(back.env, origin.env);
    assert_string_equal(back.env_convention, "openexr");
    assert_string_equal(back.arguments, origin.arguments);
    assert_string_equal(back.version, PBNDS_VERSION);
    assert_true(back.env_yaw_deg == 12.5f && back.env_strength == 0.75f);
    assert_true(back.seed == UINT64_MAX);
    assert_int_equal(back.target, PBNDS_TARGET_DISPLAY);
    const struct pbnds_exr_channel *c = pbnds_exr_find(&exr, "target.R");
    assert_non_null(c);
    assert_memory_equal(c->data, target, sizeof target);
    const struct pbnds_exr_attribute *a =
        pbnds_exr_find_attribute(&exr, "pbnds:version");
    assert_non_null(a);
    assert_string_equal(a->value.string, PBNDS_VERSION);
    assert_int_equal(pbnds_exr_find(&exr, "A")->type, PBNDS_EXR_HALF);
    assert_int_equal(pbnds_exr_find(&exr, "emission.G")->type, PBNDS_EXR_HALF);
    assert_int_equal(pbnds_exr_find(&exr, "object_id")->type, PBNDS_EXR_UINT);
    pbnds_exr_free(&exr);
    pbnds_image_free(&light);
    pbnds_image_free(&radiance);
    pbnds_gbuffer_free(&h);
    pbnds_gbuffer_free(&g);
    remove(path);
}

/* What was read once comes back bit for bit: nothing drifts over generations. */
static void a_second_trip_changes_nothing(void **state)
{
    (void)state;
    const char *path = "gbuffer_second_trip.exr";
    struct pbnds_gbuffer g;
    make_gbuffer(&g, false);
    g.camera.orthographic = true;
    write_ok(path, &g, NULL, NULL, NULL, 0);
    struct pbnds_gbuffer first = read_ok(path);
    assert_true(first.camera.orthographic);
    write_ok(path, &first, NULL, NULL, NULL, 0);
    struct pbnds_gbuffer second = read_ok(path);
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(first.albedo[c], second.albedo[c], N * sizeof(float));
        assert_memory_equal(first.normal[c], second.normal[c], N * sizeof(float));
        assert_memory_equal(first.emission[c], second.emission[c], N * sizeof(float));
        /* The camera's axes are the world's here. */
        assert_memory_equal(first.normal[c], g.normal[c], N * sizeof(float));
    }
    assert_memory_equal(first.roughness, second.roughness, N * sizeof(float));
    pbnds_gbuffer_free(&second);
    pbnds_gbuffer_free(&first);
    pbnds_gbuffer_free(&g);
    remove(path);
}

static void the_file_follows_the_contract(void **state)
{
    (void)state;
    const char *path = "gbuffer_contract.exr";
    struct pbnds_gbuffer g;
    make_gbuffer(&g, true);
    g.emission[1][0] = 70000.0f;
    write_ok(path, &g, NULL, NULL, NULL, 0);
    struct pbnds_exr exr;
    struct pbnds_error error;
    assert_int_equal(pbnds_exr_read(path, &exr, &error), PBNDS_OK);
    assert_int_equal(pbnds_exr_find(&exr, "Z")->type, PBNDS_EXR_FLOAT);
    assert_int_equal(pbnds_exr_find(&exr, "albedo.G")->type, PBNDS_EXR_HALF);
    assert_int_equal(pbnds_exr_find(&exr, "emission.G")->type, PBNDS_EXR_FLOAT);
    assert_near(((float *)pbnds_exr_find(&exr, "emission.G")->data)[0], 70000.0, 0.0);
    assert_null(pbnds_exr_find(&exr, "R"));
    assert_string_equal(
        pbnds_exr_find_attribute(&exr, "pbnds:normalSpace")->value.string, "camera");
    assert_int_equal(pbnds_exr_find_attribute(&exr, "pbnds:contract")->value.i, 1);
    const float *nz = pbnds_exr_find(&exr, "normal.Z")->data;
    for (int i = 0; i < N; ++i) {
        if (g.coverage[i] == 0.0f) continue;
        const struct pbnds_vec3 n = {g.normal[0][i], g.normal[1][i], g.normal[2][i]};
        assert_near(nz[i], pbnds_camera_from_world_vector(&g.camera, n).z, 0.0);
        assert_true(nz[i] > 0.0f); /* camera space: toward the viewer */
    }
    /* Row vectors: p M, divided by w, is the image position. */
    const float *ndc = pbnds_exr_find_attribute(&exr, "worldToNDC")->value.m44;
    const float *view = pbnds_exr_find_attribute(&exr, "worldToCamera")->value.m44;
    const struct pbnds_vec3 p = {0.1f, -0.2f, 0.3f};
    float clip[4], eye[4];
    for (int k = 0; k < 4; ++k) {
        clip[k] = p.x * ndc[k] + p.y * ndc[4 + k] + p.z * ndc[8 + k] + ndc[12 + k];
        eye[k] = p.x * view[k] + p.y * view[4 + k] + p.z * view[8 + k] + view[12 + k];
    }
    float x = 0.0f, y = 0.0f;
    assert_true(pbnds_camera_project(&g.camera, W, H, p, &x, &y));
    assert_near((clip[0] / clip[3] + 1.0f) * 0.5f * W, x, 1e-4);
    assert_near((1.0f - clip[1] / clip[3]) * 0.5f * H, y, 1e-4);
    assert_near(-eye[2], pbnds_camera_depth(&g.camera, p), 1e-5);
    assert_near(eye[3], 1.0, 0.0);
    pbnds_exr_free(&exr);
    pbnds_gbuffer_free(&g);
    remove(path);
}

/* Files of other writers: planes made by hand. */
struct foreign {
    float planes[12][N];
    struct pbnds_exr_channel channels[12];
    struct pbnds_exr_attribute attributes[4];
    struct pbnds_exr exr;
};

static float *foreign_plane(struct foreign *f, const char *name)
{
    for (int i = 0; i < 12; ++i) {
        if (strcmp(f->channels[i].name, name) == 0) return f->planes[i];
    }
    fail_msg("no plane %s", name);
    return NULL;
}

/* The eight required channels only, normals toward the viewer, depth 2. */
static void make_foreign(struct foreign *f)
{
    static const char *const names[] = {"albedo.R", "albedo.G",   "albedo.B",
                                        "normal.X", "normal.Y",   "normal.Z",
                                        "Z",        "roughness.R"};
    memset(f, 0, sizeof *f);
    for (int c = 0; c < 8; ++c) {
        snprintf(f->channels[c].name, sizeof f->channels[c].name, "%s", names[c]);
        f->channels[c].type = PBNDS_EXR_FLOAT;
        f->channels[c].data = f->planes[c];
        for (int i = 0; i < N; ++i)
            f->planes[c][i] = c == 5 ? 1.0f : c == 6 ? 2.0f : 0.25f;
        if (c == 3 || c == 4) memset(f->planes[c], 0, sizeof f->planes[c]);
    }
    f->exr = (struct pbnds_exr){W, H, PBNDS_EXR_ZIP, f->channels, 8, f->attributes, 0};
}

static void add_foreign_string(struct foreign *f, const char *name, const char *value)
{
    struct pbnds_exr_attribute *a = &f->attributes[f->exr.attribute_count++];
    snprintf(a->name, sizeof a->name, "%s", name);
    a->type = PBNDS_EXR_ATTRIBUTE_STRING;
    snprintf(a->value.string, sizeof a->value.string, "%s", value);
}

/* Writes the foreign file and reads it as a G-buffer. */
static enum pbnds_status pass(const struct foreign *f, struct pbnds_gbuffer *g,
                              struct pbnds_error *error)
{
    const char *path = "gbuffer_foreign.exr";
    struct pbnds_image radiance;
    struct pbnds_exr exr;
    if (pbnds_exr_write(path, &f->exr, error) != PBNDS_OK)
        fail_msg("%s", error->message);
    const enum pbnds_status status =
        pbnds_gbuffer_read(path, g, NULL, &radiance, &exr, error);
    assert_null(radiance.data);
    if (status == PBNDS_OK) {
        pbnds_exr_free(&exr);
    } else {
        assert_null(g->storage);
        assert_null(exr.channels);
        assert_non_null(strstr(error->message, path));
    }
    remove(path);
    return status;
}

static void absent_planes_get_their_defaults(void **state)
{
    (void)state;
    struct foreign f;
    make_foreign(&f);
    foreign_plane(&f, "Z")[5] = INFINITY;
    foreign_plane(&f, "Z")[6] = 1e10f;
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    assert_int_equal(pass(&f, &g, &error), PBNDS_OK);
    assert_near(g.camera.yfov, 40.0 * 3.14159265 / 180.0, 1e-6);
    for (int i = 0; i < N; ++i) {
        if (i == 5 || i == 6) {
            assert_true(isinf(g.depth[i]));
            assert_near(g.coverage[i], 0.0, 0.0);
            assert_near(g.albedo[0][i], 0.0, 0.0);
            assert_near(g.normal[2][i], 0.0, 0.0);
            assert_int_equal(g.object_id[i], UINT32_MAX);
            continue;
        }
        assert_near(g.specular[i], 0.04, 1e-7);
        assert_near(g.metallic[i], 0.0, 0.0);
        assert_near(g.coverage[i], 1.0, 0.0);
        assert_near(g.emission[1][i], 0.0, 0.0);
        assert_int_equal(g.object_id[i], 0);
        /* Position from depth: planar, and on the pixel's ray. */
        const struct pbnds_vec3 p = {g.position[0][i], g.position[1][i],
                                     g.position[2][i]};
        float x = 0.0f, y = 0.0f;
        assert_near(p.z, -2.0, 1e-6);
        assert_true(pbnds_camera_project(&g.camera, W, H, p, &x, &y));
        assert_near(x, i % W + 0.5, 1e-4);
        assert_near(y, i / W + 0.5, 1e-4);
    }
    pbnds_gbuffer_free(&g);
}

static void missing_channels_are_listed_together(void **state)
{
    (void)state;
    struct foreign f;
    make_foreign(&f);
    snprintf(f.channels[1].name, 64, "albedo.Green");
    snprintf(f.channels[5].name, 64, "Normal.Z");
    snprintf(f.channels[7].name, 64, "rough.R");
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    assert_int_equal(pass(&f, &g, &error), PBNDS_ERROR_FORMAT);
    assert_non_null(
        strstr(error.message, "albedo.G, normal.Z, roughness.R are missing"));
    assert_null(strstr(error.message, "albedo.R"));
    assert_null(strstr(error.message, "normal.X"));
}

static void bad_values_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *channel;
        float value;
    } cases[] = {
        {"albedo.R", NAN},      {"normal.Y", NAN}, {"Z", NAN},  {"roughness.R", NAN},
        {"normal.X", INFINITY}, {"Z", -INFINITY},  {"Z", 0.0f}, {"Z", -3.0f}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        struct foreign f;
        make_foreign(&f);
        foreign_plane(&f, cases[k].channel)[3 * W + 4] = cases[k].value;
        struct pbnds_gbuffer g;
        struct pbnds_error error = {""};
        assert_int_equal(pass(&f, &g, &error), PBNDS_ERROR_FORMAT);
        char name[64];
        snprintf(name, sizeof name, "channel %s ", cases[k].channel);
        assert_non_null(strstr(error.message, name));
        assert_non_null(strstr(error.message, "(4, 3)"));
    }
    /* Optional planes count where something was hit. */
    for (int hit = 0; hit < 2; ++hit) {
        struct foreign f;
        make_foreign(&f);
        snprintf(f.channels[8].name, 64, "metallic.R");
        f.channels[8].type = PBNDS_EXR_FLOAT;
        f.channels[8].data = f.planes[8];
        f.exr.channel_count = 9;
        f.planes[8][W] = NAN;
        if (!hit) foreign_plane(&f, "Z")[W] = INFINITY;
        struct pbnds_gbuffer g;
        struct pbnds_error error = {""};
        assert_int_equal(pass(&f, &g, &error), hit ? PBNDS_ERROR_FORMAT : PBNDS_OK);
        if (hit) assert_non_null(strstr(error.message, "metallic.R"));
        pbnds_gbuffer_free(&g);
    }
}

static void normals_are_mended(void **state)
{
    (void)state;
    struct foreign f;
    make_foreign(&f);
    f.channels[3].type = f.channels[4].type = f.channels[5].type = PBNDS_EXR_HALF;
    float *nx = foreign_plane(&f, "normal.X"), *nz = foreign_plane(&f, "normal.Z");
    const struct pbnds_vec3 n = pbnds_normalize(pbnds_vec3_make(0.3f, 0.0f, 0.7f));
    for (int i = 0; i < N; ++i) {
        nx[i] = n.x;
        nz[i] = n.z;
    }
    nx[10] = 0.0f; /* no direction  */
    nz[10] = 0.0f;
    nx[11] = 0.0f; /* looks away    */
    nz[11] = -1.0f;
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    assert_int_equal(pass(&f, &g, &error), PBNDS_OK);
    for (int i = 0; i < N; ++i) {
        const struct pbnds_vec3 m = {g.normal[0][i], g.normal[1][i], g.normal[2][i]};
        assert_near(pbnds_length(m), 1.0, 2e-6);
        assert_true(pbnds_dot(m, pbnds_gbuffer_wo(&g, i % W, i / W)) > 4e-4f);
        if (i == 10 || i == 11) continue;
        assert_near(m.x, n.x, 5e-4);
        assert_near(m.z, n.z, 5e-4);
    }
    pbnds_gbuffer_free(&g);
}

static void add_camera(struct foreign *f, const struct pbnds_mat4 *m)
{
    struct pbnds_exr_attribute *a = &f->attributes[f->exr.attribute_count++];
    snprintf(a->name, sizeof a->name, "pbnds:worldFromCamera");
    a->type = PBNDS_EXR_ATTRIBUTE_M44F;
    memcpy(a->value.m44, m->m, sizeof m->m);
}

static void the_header_says_the_normal_space(void **state)
{
    (void)state;
    static const char *const spaces[] = {"world", "camera", NULL};
    for (int k = 0; k < 3; ++k) {
        struct foreign f;
        make_foreign(&f);
        /* From above: camera +z is world +y. */
        const struct pbnds_mat4 m = {{1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 5, 0, 1}};
        add_camera(&f, &m);
        if (spaces[k]) add_foreign_string(&f, "pbnds:normalSpace", spaces[k]);
        if (k == 0) {
            for (int i = 0; i < N; ++i) {
                foreign_plane(&f, "normal.Y")[i] = 0.8f;
                foreign_plane(&f, "normal.Z")[i] = 0.6f;
            }
        }
        struct pbnds_gbuffer g;
        struct pbnds_error error = {""};
        assert_int_equal(pass(&f, &g, &error), PBNDS_OK);
        for (int i = 0; i < N; ++i) {
            assert_near(g.normal[0][i], 0.0, 1e-6);
            assert_near(g.normal[1][i], k == 0 ? 0.8 : 1.0, 1e-6);
            assert_near(g.normal[2][i], k == 0 ? 0.6 : 0.0, 1e-6);
            assert_near(g.position[1][i], 3.0, 1e-5);
        }
        pbnds_gbuffer_free(&g);
    }
}

static void bad_headers_are_refused(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    struct foreign f;
    make_foreign(&f);
    add_foreign_string(&f, "pbnds:normalSpace", "tangent");
    assert_int_equal(pass(&f, &g, &error), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "\"tangent\""));

    make_foreign(&f);
    f.exr.attribute_count = 1;
    snprintf(f.attributes[0].name, 64, "pbnds:contract");
    f.attributes[0].type = PBNDS_EXR_ATTRIBUTE_INT;
    f.attributes[0].value.i = PBNDS_GBUFFER_CONTRACT + 1;
    assert_int_equal(pass(&f, &g, &error), PBNDS_ERROR_UNSUPPORTED);

    const float wrong[] = {2.0f, 0.0f, -1.0f, NAN}; /* scaled, flat, mirrored, broken */
    for (int k = 0; k < 4; ++k) {
        make_foreign(&f);
        struct pbnds_mat4 m = pbnds_mat4_identity();
        m.m[5] = wrong[k];
        add_camera(&f, &m);
        assert_int_equal(pass(&f, &g, &error), PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(error.message, "worldFromCamera"));
    }

    make_foreign(&f);
    const struct pbnds_mat4 m = pbnds_mat4_identity();
    add_camera(&f, &m);
    snprintf(f.attributes[1].name, 64, "pbnds:yfov");
    f.attributes[1].type = PBNDS_EXR_ATTRIBUTE_FLOAT;
    f.attributes[1].value.f = 4.0f;
    f.exr.attribute_count = 2;
    assert_int_equal(pass(&f, &g, &error), PBNDS_ERROR_FORMAT);

    /* Numbers that would put every point out of the range of float. */
    make_foreign(&f);
    struct pbnds_mat4 far_off = pbnds_mat4_identity();
    far_off.m[13] = -1e30f;
    add_camera(&f, &far_off);
    assert_int_equal(pass(&f, &g, &error), PBNDS_ERROR_FORMAT);
    if (!strstr(error.message, "1e+30 m")) fail_msg("%s", error.message);
}

static void bad_arguments_are_refused(void **state)
{
    (void)state;
    const char *path = "gbuffer_refused.exr";
    struct pbnds_gbuffer g, h;
    struct pbnds_error error = {""};
    make_gbuffer(&g, true);
    struct pbnds_image radiance;
    assert_int_equal(pbnds_image_init(&radiance, W, H + 1, 3, &error), PBNDS_OK);
    assert_int_equal(
        pbnds_gbuffer_write(path, &g, NULL, &radiance, NULL, 0, PBNDS_EXR_ZIP, &error),
        PBNDS_ERROR_ARGUMENT);
    float plane[N] = {0};
    struct pbnds_exr_channel extra = {"metallic.R", PBNDS_EXR_FLOAT, plane};
    assert_int_equal(
        pbnds_gbuffer_write(path, &g, NULL, NULL, &extra, 1, PBNDS_EXR_ZIP, &error),
        PBNDS_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "metallic.R"));
    assert_int_equal(pbnds_gbuffer_write("no/such/folder/x.exr", &g, NULL, NULL, NULL,
                                         0, PBNDS_EXR_ZIP, &error),
                     PBNDS_ERROR_IO);
    assert_int_equal(pbnds_gbuffer_read(path, &h, NULL, NULL, NULL, &error),
                     PBNDS_ERROR_IO);
    assert_null(h.storage);
    pbnds_image_free(&radiance);
    pbnds_gbuffer_free(&g);
}

static void broken_files_are_refused(void **state)
{
    (void)state;
    const char *path = "gbuffer_broken.exr";
    struct pbnds_gbuffer g;
    struct pbnds_error error;
    make_gbuffer(&g, true);
    write_ok(path, &g, NULL, NULL, NULL, 0);
    pbnds_gbuffer_free(&g);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    static char bytes[1 << 16];
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    for (size_t keep = 0; keep < size; keep += size / 37) {
        file = fopen(path, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(bytes, 1, keep, file), keep);
        fclose(file);
        assert_int_not_equal(pbnds_gbuffer_read(path, &g, NULL, NULL, NULL, &error),
                             PBNDS_OK);
        assert_null(g.storage);
    }
    remove(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip),
        cmocka_unit_test(a_second_trip_changes_nothing),
        cmocka_unit_test(the_file_follows_the_contract),
        cmocka_unit_test(absent_planes_get_their_defaults),
        cmocka_unit_test(missing_channels_are_listed_together),
        cmocka_unit_test(bad_values_are_named),
        cmocka_unit_test(normals_are_mended),
        cmocka_unit_test(the_header_says_the_normal_space),
        cmocka_unit_test(bad_headers_are_refused),
        cmocka_unit_test(bad_arguments_are_refused),
        cmocka_unit_test(broken_files_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
