/* The lint: sound files pass without a word, each fault is found where it is. */
#include <stdio.h>

#include "engine/shade/cryptomatte.h"
#include "engine/shade/gbuffer_check.h"
#include "tests/engine/shade/fixture.h"

enum { W = 24, H = 18, N = W * H };

#define PATH "gbuffer_check.exr"

enum {
    ALL = PBNDS_OPTIONAL_AO | PBNDS_OPTIONAL_UV | PBNDS_OPTIONAL_MOTION |
          PBNDS_OPTIONAL_MATERIAL_ID | PBNDS_OPTIONAL_CRYPTOMATTE
};

struct variant {
    int samples;
    bool alpha, orthographic, world, distance;
    float far_away; /* the scene and its camera, metres from the origin */
};

/* A file of ours, in memory. */
static struct pbnds_exr make_file(const struct variant *v)
{
    const struct pbnds_vec3 shift = {v->far_away, -v->far_away, 0.5f * v->far_away};
    struct pbnds_mesh meshes[] = {
        sphere(shift, 0.7f, 10, 0),
        quad(pbnds_add(shift, pbnds_vec3_make(-0.6f, -0.8f, 0.9f)),
             pbnds_vec3_make(0.7f, 0.2f, 0), pbnds_vec3_make(0.2f, 0.9f, 0.1f), 1)};
    meshes[1].object_id = 1;
    struct pbnds_material materials[2] = {matte(0.5f), matte(0.25f)};
    materials[1].alpha_mode = PBNDS_ALPHA_BLEND;
    materials[1].base_color.w = 0.625f;
    materials[1].emissive = pbnds_vec3_make(3, 2, 1);
    materials[0].specular = 0.5f; /* makes f0 and f90 */
    materials[0].ior_f0 = 0.08f;
    struct fixture f;
    fixture_scene(&f, meshes, 2, materials, 2);
    struct pbnds_camera camera;
    memset(&camera, 0, sizeof camera);
    camera.world_from_camera =
        pbnds_mat4_look_at(pbnds_add(shift, pbnds_vec3_make(0.5f, 0.8f, 2.5f)), shift,
                           pbnds_vec3_make(0, 1, 0));
    camera.yfov = 0.7f;
    camera.ymag = 0.9f;
    camera.orthographic = v->orthographic;
    const struct pbnds_raycast_options options = {
        .samples = v->samples,
        .optional = ALL,
        .through = v->alpha ? PBNDS_THROUGH_ALPHA : PBNDS_THROUGH_FIRST};
    const struct pbnds_gbuffer_origin origin = {
        .normal_space = v->world ? PBNDS_NORMAL_WORLD : PBNDS_NORMAL_CAMERA,
        .depth = v->distance ? PBNDS_DEPTH_DISTANCE : PBNDS_DEPTH_PLANAR};
    struct pbnds_gbuffer g;
    struct pbnds_exr exr;
    struct pbnds_error error = {""};
    must(pbnds_gbuffer_raycast(&f.scene, f.accel, &camera, W, H, &options, &g, &error),
         &error);
    must(pbnds_gbuffer_write(PATH, &g, &origin, NULL, NULL, 0, PBNDS_EXR_PIZ, &error),
         &error);
    must(pbnds_exr_read(PATH, &exr, &error), &error);
    pbnds_gbuffer_free(&g);
    fixture_free(&f);
    remove(PATH);
    return exr;
}

static struct pbnds_findings found;

static void print_findings(void)
{
    for (int i = 0; i < found.count; ++i) {
        const struct pbnds_finding *f = &found.items[i];
        print_message("%s %s: %s, %llu from (%d, %d): %g\n",
                      f->fault ? "fault" : "warning", f->rule, f->channel,
                      (unsigned long long)f->count, f->x, f->y, f->value);
    }
}

static void sound_files_pass_without_a_word(void **state)
{
    (void)state;
    static const struct variant variants[] = {
        {1, false, false, false, false, 0},   {1, false, true, true, true, 0},
        {9, false, false, true, true, 0},     {4, true, false, false, true, 0},
        {9, true, true, false, false, 0},     {1, true, false, true, false, 300.0f},
        {5, false, false, false, true, 5000},
    };
    for (size_t i = 0; i < sizeof variants / sizeof variants[0]; ++i) {
        struct pbnds_exr exr = make_file(&variants[i]);
        pbnds_gbuffer_check(&exr, PATH, &found);
        print_findings();
        assert_int_equal(found.count, 0);
        assert_int_equal(found.width, W);
        assert_int_equal(found.contract, PBNDS_GBUFFER_CONTRACT);
        pbnds_exr_free(&exr);
    }
}

static float *plane(struct pbnds_exr *exr, const char *name)
{
    const struct pbnds_exr_channel *c = pbnds_exr_find(exr, name);
    if (!c) fail_msg("no channel %s", name);
    return c->data;
}

/* The only finding of that rule. */
static const struct pbnds_finding *only(const char *rule, const char *channel)
{
    const struct pbnds_finding *hit = NULL;
    for (int i = 0; i < found.count; ++i) {
        if (strcmp(found.items[i].rule, rule) != 0 ||
            strcmp(found.items[i].channel, channel) != 0)
            continue;
        if (hit) fail_msg("%s is found twice", rule);
        hit = &found.items[i];
    }
    if (!hit) print_findings();
    if (!hit) fail_msg("%s of %s is not found", rule, channel);
    return hit;
}

/* One value at a pixel that was hit, or at one that was not. */
static void one_bad_value(void **state)
{
    (void)state;
    static const struct {
        const char *channel;
        bool on_hit;
        float value;
        const char *rule, *named;
        bool fault;
    } cases[] = {
        {"albedo.G", true, NAN, "finite", "albedo.G", true},
        {"albedo.G", false, INFINITY, "finite", "albedo.G", true},
        {"uv.U", true, NAN, "finite", "uv.U", true},
        {"Z", true, NAN, "finite", "Z", true},
        {"coverage.A", false, NAN, "finite", "coverage.A", true},
        {"albedo.B", true, 1.25f, "range", "albedo.B", true},
        {"roughness.R", true, -0.1f, "range", "roughness.R", true},
        {"metallic.R", true, 7.0f, "range", "metallic.R", true},
        {"coverage.A", true, 1.5f, "range", "coverage.A", true},
        {"emission.R", true, -1.0f, "range", "emission.R", true},
        {"f90.R", true, 2.0f, "range", "f90.R", true},
        {"normal.Z", true, 3.0f, "unit-normals", "normal", true},
        {"Z", true, -2.0f, "depth", "Z", true},
        {"Z", true, INFINITY, "coverage", "Z", true},
        {"Z", false, 3.0f, "coverage", "Z", false},
        {"Z", true, 2.9f, "position", "Z", true},
        {"specular.R", true, 0.9f, "specular", "specular.R", false},
        {"ao.R", false, 0.5f, "empty", "ao.R", false},
        {"CryptoObject00.G", true, 1.5f, "mattes", "CryptoObject", true},
        {"CryptoMaterial00.R", true, 0.0f, "mattes", "CryptoMaterial", true},
    };
    const struct variant plain = {1, false, false, false, false, 0};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        struct pbnds_exr exr = make_file(&plain);
        const float *coverage = plane(&exr, "coverage.A");
        size_t at = 3 * W + 2;
        while ((coverage[at] > 0.0f) != cases[k].on_hit)
            ++at;
        plane(&exr, cases[k].channel)[at] = cases[k].value;
        pbnds_gbuffer_check(&exr, PATH, &found);
        const struct pbnds_finding *f = only(cases[k].rule, cases[k].named);
        assert_int_equal(f->fault, cases[k].fault);
        assert_int_equal(f->count, 1);
        assert_int_equal(f->x, at % W);
        assert_int_equal(f->y, at / W);
        assert_int_equal(pbnds_findings_faults(&found) > 0, cases[k].fault);
        pbnds_exr_free(&exr);
    }
}

static void pixels_are_counted(void **state)
{
    (void)state;
    const struct variant plain = {1, false, false, false, false, 0};
    struct pbnds_exr exr = make_file(&plain);
    const float *coverage = plane(&exr, "coverage.A");
    float *n[3] = {plane(&exr, "normal.X"), plane(&exr, "normal.Y"),
                   plane(&exr, "normal.Z")};
    uint32_t *id = (uint32_t *)(void *)plane(&exr, "object_id");
    uint64_t hits = 0, misses = 0;
    for (size_t i = 0; i < N; ++i) {
        hits += coverage[i] > 0.0f;
        misses += coverage[i] == 0.0f;
        for (int c = 0; c < 3; ++c)
            n[c][i] *= -1.0f;
        if (coverage[i] == 0.0f) id[i] = 0;
    }
    pbnds_gbuffer_check(&exr, PATH, &found);
    const struct pbnds_finding *f = only("facing", "normal");
    assert_true(f->fault && f->value < 0.0);
    assert_true(f->count > hits * 9 / 10); /* grazing ones stay within the slack */
    f = only("ids", "object_id");
    assert_false(f->fault);
    assert_int_equal(f->count, misses);
    assert_int_equal(found.count, 2);
    pbnds_exr_free(&exr);
}

/* Half a pixel is right for means, wrong for points. */
static void positions_lie_in_their_pixels(void **state)
{
    (void)state;
    for (int samples = 1; samples <= 4; samples += 3) {
        const struct variant v = {samples, false, true, false, false, 0};
        struct pbnds_exr exr = make_file(&v);
        float *p[3] = {plane(&exr, "position.X"), plane(&exr, "position.Y"),
                       plane(&exr, "position.Z")};
        const float *coverage = plane(&exr, "coverage.A");
        const float *m =
            pbnds_exr_find_attribute(&exr, "pbnds:worldFromCamera")->value.m44;
        const float pixel = 2.0f * 0.9f / H;
        for (size_t i = 0; i < N; ++i) {
            for (int c = 0; c < 3 && coverage[i] == 1.0f; ++c)
                p[c][i] += 0.3f * pixel * m[c]; /* along the camera's x axis */
        }
        pbnds_gbuffer_check(&exr, PATH, &found);
        if (samples == 1) {
            assert_near(only("position", "position")->value, 0.3, 0.02);
            assert_true(only("position", "position")->fault);
        } else {
            for (size_t i = 0; i < N; ++i) {
                for (int c = 0; c < 3 && coverage[i] == 1.0f; ++c)
                    p[c][i] += 0.7f * pixel * m[c];
            }
            pbnds_gbuffer_check(&exr, PATH, &found);
            assert_near(only("position", "position")->value, 1.0, 0.5);
        }
        pbnds_exr_free(&exr);
    }
}

static struct pbnds_exr_attribute *attribute(struct pbnds_exr *exr, const char *name)
{
    for (int i = 0; i < exr->attribute_count; ++i) {
        if (strcmp(exr->attributes[i].name, name) == 0) return &exr->attributes[i];
    }
    fail_msg("no attribute %s", name);
    return NULL;
}

static void rename_channel(struct pbnds_exr *exr, const char *from, const char *to)
{
    for (int i = 0; i < exr->channel_count; ++i) {
        if (strcmp(exr->channels[i].name, from) == 0)
            snprintf(exr->channels[i].name, sizeof exr->channels[i].name, "%s", to);
    }
}

static void headers_and_channel_lists(void **state)
{
    (void)state;
    const struct variant plain = {1, false, false, false, false, 0};
    struct pbnds_exr exr = make_file(&plain);
    attribute(&exr, "pbnds:contract")->value.i = 7;
    pbnds_gbuffer_check(&exr, PATH, &found);
    assert_true(only("contract", "pbnds:contract")->fault);
    snprintf(attribute(&exr, "pbnds:contract")->name, 64, "other");
    pbnds_gbuffer_check(&exr, PATH, &found);
    assert_false(only("contract", "pbnds:contract")->fault);
    assert_int_equal(found.count, 1);

    snprintf(attribute(&exr, "pbnds:depth")->value.string, 16, "deep");
    attribute(&exr, "pbnds:samples")->value.i = -1;
    pbnds_gbuffer_check(&exr, PATH, &found);
    assert_true(only("header", "pbnds:normalSpace, pbnds:depth")->fault);
    assert_true(only("header", "pbnds:samples, pbnds:through")->fault);
    pbnds_exr_free(&exr);

    exr = make_file(&plain);
    attribute(&exr, "pbnds:worldFromCamera")->value.m44[5] = 9.0f;
    pbnds_gbuffer_check(&exr, PATH, &found);
    assert_true(only("header", "pbnds:worldFromCamera, pbnds:yfov, pbnds:ymag")->fault);
    pbnds_exr_free(&exr);

    exr = make_file(&plain);
    rename_channel(&exr, "normal.Z", "Normal.Z");
    rename_channel(&exr, "roughness.R", "rough.R");
    pbnds_gbuffer_check(&exr, PATH, &found);
    assert_true(only("channels", "normal.Z")->fault);
    assert_true(only("channels", "roughness.R")->fault);
    assert_false(only("z-order", "Normal.Z")->fault);
    assert_int_equal(found.count, 3);
    pbnds_exr_free(&exr);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sound_files_pass_without_a_word),
        cmocka_unit_test(one_bad_value),
        cmocka_unit_test(pixels_are_counted),
        cmocka_unit_test(positions_lie_in_their_pixels),
        cmocka_unit_test(headers_and_channel_lists),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
