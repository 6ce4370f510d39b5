/* What others made: a file that Blender wrote (tests/golden/blender says how), cameras
 * found from positions, folders of maps. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/core/rng.h"
#include "engine/image/oiio.h"
#include "engine/shade/gbuffer_check.h"
#include "engine/shade/import.h"
#include "tests/engine/core/scratch.h"
#include "tests/test.h"

#define GOLDEN PBNDS_SOURCE_DIR "/tests/golden/blender/multilayer.exr"
#define PATH   "import_test.exr"

static const struct pbnds_import_options nothing_said = {.yfov = 0.0f};
static struct pbnds_import_notes notes;

static void must(enum pbnds_status status, const struct pbnds_error *error)
{
    if (status != PBNDS_OK) fail_msg("%s", error->message);
}

static bool noted(const char *text)
{
    for (int i = 0; i < notes.count; ++i) {
        if (strstr(notes.text[i], text)) return true;
    }
    return false;
}

/* Cameras. */

enum { W = 40, H = 30, N = W * H };

static float planes[3][N], depths[N];
static const float *const positions[3] = {planes[0], planes[1], planes[2]};

/* A wavy surface seen by the camera, each pixel's ray off by up to `jitter` pixels. */
static void see(const struct pbnds_camera *camera, float jitter, float wave)
{
    struct pbnds_rng rng = pbnds_rng_make(9, 0, 0);
    const struct pbnds_vec3 forward = pbnds_scale(
        pbnds_vec3_make(camera->world_from_camera.m[8], camera->world_from_camera.m[9],
                        camera->world_from_camera.m[10]),
        -1.0f);
    for (int i = 0; i < N; ++i) {
        const float x = (float)(i % W) + 0.5f, y = (float)(i / W) + 0.5f;
        const float dx = jitter * (2.0f * pbnds_rng_float(&rng) - 1.0f);
        const float dy = jitter * (2.0f * pbnds_rng_float(&rng) - 1.0f);
        const struct pbnds_ray ray = pbnds_camera_ray(camera, W, H, x + dx, y + dy);
        depths[i] = 3.0f + wave * sinf(0.31f * x) * cosf(0.23f * y);
        const struct pbnds_vec3 p = pbnds_mad(
            ray.origin, ray.direction, depths[i] / pbnds_dot(ray.direction, forward));
        planes[0][i] = p.x;
        planes[1][i] = p.y;
        planes[2][i] = p.z;
        if (i % 11 == 0) depths[i] = INFINITY;
    }
}

static struct pbnds_camera somewhere(bool orthographic)
{
    struct pbnds_camera camera;
    memset(&camera, 0, sizeof camera);
    camera.world_from_camera =
        pbnds_mat4_look_at(pbnds_vec3_make(11, -2, 7), pbnds_vec3_make(9.5f, -1.2f, 4),
                           pbnds_vec3_make(0, 1, 0));
    camera.orthographic = orthographic;
    camera.yfov = 0.6f;
    camera.ymag = 1.7f;
    return camera;
}

static void cameras_are_found_from_positions(void **state)
{
    (void)state;
    for (int k = 0; k < 4; ++k) {
        const bool orthographic = k % 2 == 1, jitter = k >= 2;
        const struct pbnds_camera want = somewhere(orthographic);
        struct pbnds_camera got;
        memset(&got, 0, sizeof got);
        float off = -1.0f;
        see(&want, jitter ? 0.5f : 0.0f, 0.8f);
        assert_int_equal(pbnds_import_fit_camera(positions, depths, W, H, &got, &off),
                         PBNDS_FIT_DONE);
        assert_true(got.orthographic == orthographic);
        /* Noise of 0.4 pixels over 1000 of them: a hundredth of a pixel. */
        const double pixel = (orthographic ? 1.7 : 3.0 * tan(0.3)) / (0.5 * H);
        for (int i = 0; i < 12; ++i)
            assert_near(got.world_from_camera.m[i], want.world_from_camera.m[i],
                        jitter ? 5e-3 : 1e-5);
        for (int i = 12; i < 15; ++i)
            assert_near(got.world_from_camera.m[i], want.world_from_camera.m[i],
                        jitter ? 2.0 * pixel : 1e-4);
        if (orthographic) {
            assert_near(got.ymag, 1.7, jitter ? 0.02 : 1e-5);
        } else {
            assert_near(got.yfov, 0.6, jitter ? 0.01 : 1e-5);
        }
        assert_near(off, jitter ? 0.41 : 0.0, jitter ? 0.05 : 1e-3);
    }
}

static void what_positions_do_not_say(void **state)
{
    (void)state;
    struct pbnds_camera camera = somewhere(false), got;
    float off;
    see(&camera, 0.0f, 0.0f); /* a wall that faces the eye: any distance would do */
    assert_int_equal(pbnds_import_fit_camera(positions, depths, W, H, &got, &off),
                     PBNDS_FIT_UNKNOWN);
    see(&camera, 0.0f, 0.8f);
    for (int i = 15; i < N; ++i)
        depths[i] = INFINITY;
    assert_int_equal(pbnds_import_fit_camera(positions, depths, W, H, &got, &off),
                     PBNDS_FIT_UNKNOWN);
    see(&camera, 0.0f, 0.8f); /* pixels twice as wide as high */
    const float *m = camera.world_from_camera.m;
    for (int i = 0; i < N; ++i) {
        float along = 0.0f;
        for (int c = 0; c < 3; ++c)
            along += (planes[c][i] - m[12 + c]) * m[c];
        for (int c = 0; c < 3; ++c)
            planes[c][i] += along * m[c];
    }
    assert_int_equal(pbnds_import_fit_camera(positions, depths, W, H, &got, &off),
                     PBNDS_FIT_SKEWED);
    for (int i = 0; i < N; ++i)
        planes[0][i] = planes[1][i] = planes[2][i] = NAN;
    assert_int_equal(pbnds_import_fit_camera(positions, depths, W, H, &got, &off),
                     PBNDS_FIT_UNKNOWN);
}

/* Blender. */

static struct pbnds_exr golden(void)
{
    struct pbnds_exr exr;
    struct pbnds_error error = {""};
    must(pbnds_exr_read(GOLDEN, &exr, &error), &error);
    return exr;
}

static void rename_pass(struct pbnds_exr *exr, const char *from, const char *to)
{
    const size_t n = strlen(from);
    for (int i = 0; i < exr->channel_count; ++i) {
        char *name = exr->channels[i].name, rest[64];
        if (strncmp(name, from, n) != 0) continue;
        snprintf(rest, sizeof rest, "%s", name + n);
        snprintf(name, 64, "%.30s%.30s", to, rest);
    }
}

static enum pbnds_status import(struct pbnds_exr *exr,
                                const struct pbnds_import_options *options,
                                struct pbnds_gbuffer *g, struct pbnds_image *radiance,
                                struct pbnds_error *error)
{
    struct pbnds_error other = {""};
    must(pbnds_exr_write(PATH, exr, &other), &other);
    pbnds_exr_free(exr);
    const enum pbnds_status status =
        pbnds_import_blender(PATH, options, g, radiance, &notes, error);
    if (status != PBNDS_OK) assert_null(g->storage);
    remove(PATH);
    return status;
}

/* Do the pixel and its neighbours see one object only? Blender's pixels reach into them. */
static bool is_inside(const struct pbnds_gbuffer *g, int x, int y)
{
    const uint32_t id = g->object_id[y * g->width + x];
    for (int j = y - 1; j <= y + 1; ++j) {
        for (int i = x - 1; i <= x + 1; ++i) {
            if (i < 0 || j < 0 || i >= g->width || j >= g->height) return false;
            const int k = j * g->width + i;
            if (g->object_id[k] != id || g->coverage[k] < 1.0f) return false;
        }
    }
    return true;
}

/* One pixel of the scene that make_multilayer.py builds, in our axes: the sphere is at the
 * origin, the floor at y = -1, the lamp in the plane z = -0.5. */
static void check_pixel(const struct pbnds_gbuffer *g, int x, int y, int counts[4])
{
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    if (!is_inside(g, x, y)) return;
    const struct pbnds_vec3 n = {g->normal[0][i], g->normal[1][i], g->normal[2][i]};
    const struct pbnds_vec3 p = {g->position[0][i], g->position[1][i],
                                 g->position[2][i]};
    const uint32_t id = g->object_id[i];
    assert_in_range(id, 1, 3);
    ++counts[id];
    assert_int_equal(g->material_id[i], 10 + id);
    static const struct {
        double albedo[3], roughness, metallic, specular, emission;
    } want[] = {
        {{0}, 0, 0, 0, 0},
        {{0.8, 0.4, 0.2}, 0.25, 1, 0.2126 * 0.8 + 0.7152 * 0.4 + 0.0722 * 0.2, 0},
        {{0.2, 0.5, 0.3}, 0.75, 0, 0.04, 0},
        {{0.1, 0.1, 0.1}, 0.5, 0, 0.04, 4}};
    for (int c = 0; c < 3; ++c)
        assert_near(g->albedo[c][i], want[id].albedo[c], 1e-3);
    assert_near(g->roughness[i], want[id].roughness, 1e-3);
    assert_near(g->metallic[i], want[id].metallic, 1e-3);
    assert_near(g->specular[i], want[id].specular, 1e-3);
    assert_near(g->emission[0][i], want[id].emission, 4e-3);
    assert_near(g->emission[2][i], want[id].emission / 4.0, 1e-3);
    if (id == 1) { /* 64 x 32 facets: chords lie up to 0.5 % inside */
        assert_near(pbnds_length(p), 1.0, 8e-3);
        if (pbnds_dot(n, pbnds_gbuffer_wo(g, x, y)) > 0.4f) {
            assert_near(n.x, p.x, 0.04); /* the mean over a pixel beside its centre */
            assert_near(n.y, p.y, 0.04);
            assert_near(n.z, p.z, 0.04);
        }
    } else if (id == 2) {
        assert_near(p.y, -1.0, 1e-3);
        assert_near(n.y, 1.0, 1e-3);
    } else {
        assert_near(p.z, -0.5, 1e-3);
        assert_near(n.z, 1.0, 1e-3);
    }
}

static void a_file_of_blender(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_image radiance;
    struct pbnds_error error = {""};
    must(pbnds_import_blender(GOLDEN, &nothing_said, &g, &radiance, &notes, &error),
         &error);
    assert_int_equal(g.width, 48);
    assert_int_equal(g.height, 32);
    assert_true(noted("view layer: ViewLayer"));
    assert_true(noted("roughness: from the AOV"));
    assert_true(noted("specular: 0.04"));
    /* The camera stood at (3, -4, 2.5) of Blender's axes. */
    const float *m = g.camera.world_from_camera.m;
    assert_near(m[12], 3.0, 1e-3);
    assert_near(m[13], 2.5, 1e-3);
    assert_near(m[14], 4.0, 1e-3);
    assert_near(g.camera.yfov, 40.0 * (double)PBNDS_PI / 180.0, 1e-4);
    const struct pbnds_vec3 back = pbnds_normalize(pbnds_vec3_make(3, 2.5f, 4));
    assert_near(m[8], back.x, 1e-4);
    assert_near(m[9], back.y, 1e-4);
    assert_near(m[10], back.z, 1e-4);
    int counts[4] = {0};
    for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 48; ++x)
            check_pixel(&g, x, y, counts);
    }
    if (counts[1] < 80 || counts[2] < 150 || counts[3] < 20)
        fail_msg("%d %d %d pixels", counts[1], counts[2], counts[3]);
    int empty = 0, partial = 0;
    for (size_t i = 0; i < 48 * 32; ++i) {
        empty += g.coverage[i] == 0.0f;
        partial += g.coverage[i] > 0.0f && g.coverage[i] < 1.0f;
        assert_true((g.coverage[i] == 0.0f) == isinf(g.depth[i]));
        if (g.coverage[i] > 0.0f) assert_true(g.albedo[1][i] < 0.52f);
    }
    assert_true(empty > 300 && partial > 10);
    assert_int_equal(radiance.width, 48);

    /* What it becomes is a sound G-buffer of ours. */
    struct pbnds_exr exr;
    static struct pbnds_findings found;
    must(pbnds_gbuffer_write(PATH, &g, NULL, &radiance, NULL, 0, PBNDS_EXR_ZIP, &error),
         &error);
    must(pbnds_exr_read(PATH, &exr, &error), &error);
    pbnds_gbuffer_check(&exr, PATH, &found);
    assert_int_equal(found.count, 0);
    pbnds_exr_free(&exr);
    remove(PATH);
    pbnds_image_free(&radiance);
    pbnds_gbuffer_free(&g);
}

static void other_layers_and_missing_passes(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    /* A name with dots, no AOVs, no Position: defaults, and the camera of the options. */
    struct pbnds_exr exr = golden();
    rename_pass(&exr, "ViewLayer.", "Scene 2.left.");
    rename_pass(&exr, "Scene 2.left.albedo", "Scene 2.left.other");
    rename_pass(&exr, "Scene 2.left.roughness", "Scene 2.left.r");
    rename_pass(&exr, "Scene 2.left.metallic", "Scene 2.left.m");
    rename_pass(&exr, "Scene 2.left.Position", "Scene 2.left.P");
    const struct pbnds_import_options look = {
        .yfov = 0.5f, .look_given = true, .yaw = PBNDS_PI / 2.0f};
    must(import(&exr, &look, &g, NULL, &error), &error);
    assert_true(noted("view layer: Scene 2.left"));
    assert_true(noted("roughness: 0.5 everywhere"));
    assert_true(noted("metallic: 0 everywhere"));
    assert_true(noted("camera: at the origin, looks as it was told, 28.65 degrees"));
    assert_near(g.camera.yfov, 0.5, 1e-6);
    assert_near(g.camera.world_from_camera.m[8], 1.0, 1e-6); /* from +x */
    for (size_t i = 0; i < 48 * 32; ++i) {
        if (g.object_id[i] != 2 || !is_inside(&g, (int)i % 48, (int)i / 48)) continue;
        assert_near(g.albedo[1][i], 0.5, 1e-3); /* DiffCol is all of a non-metal */
        assert_near(g.roughness[i], 0.5, 0.0);
        assert_near(g.specular[i], 0.04, 1e-6);
    }
    pbnds_gbuffer_free(&g);

    static const struct {
        const char *pass, *told;
    } needed[] = {{"ViewLayer.Depth", " Z"},
                  {"ViewLayer.Normal", " Normal"},
                  {"ViewLayer.DiffCol", " Diffuse Color"}};
    for (int k = 0; k < 3; ++k) {
        exr = golden();
        rename_pass(&exr, "ViewLayer.albedo", "ViewLayer.x");
        rename_pass(&exr, needed[k].pass, "ViewLayer.y");
        assert_int_equal(import(&exr, &nothing_said, &g, NULL, &error),
                         PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(error.message, needed[k].told));
        assert_non_null(strstr(error.message, "the view layer ViewLayer"));
    }
    exr = golden();
    for (int i = 0; i < exr.channel_count; ++i)
        snprintf(exr.channels[i].name, 64, "c%d", i);
    assert_int_equal(import(&exr, &nothing_said, &g, NULL, &error), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "MultiLayer"));
}

static void bad_passes_are_refused(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    static const struct {
        const char *channel, *told;
        float value;
    } cases[] = {{"ViewLayer.Depth.Z", "Depth", NAN},
                 {"ViewLayer.Depth.Z", "Depth", -1.0f},
                 {"ViewLayer.Normal.Y", "Normal", INFINITY},
                 {"ViewLayer.albedo.G", "colour", NAN},
                 {"ViewLayer.Emit.R", "Emit", NAN}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        struct pbnds_exr exr = golden();
        float *plane = pbnds_exr_find(&exr, cases[k].channel)->data;
        plane[48 * 16 + 22] = cases[k].value; /* on the sphere */
        assert_int_equal(import(&exr, &nothing_said, &g, NULL, &error),
                         PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(error.message, cases[k].told));
        assert_non_null(strstr(error.message, "(22, 16)"));
    }
    /* A codec that the library cannot decode is named. */
    assert_int_equal(pbnds_import_blender(PBNDS_SOURCE_DIR
                                          "/tests/fuzz/corpus/gbuffer/c_dwab.exr",
                                          &nothing_said, &g, NULL, &notes, &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "DWAB"));
    assert_int_equal(
        pbnds_import_blender("no_such.exr", &nothing_said, &g, NULL, &notes, &error),
        PBNDS_ERROR_IO);
}

/* Folders of maps. */

#define MAPS "import_maps"

enum { SIDE = 3, TEXELS = SIDE * SIDE };

static struct pbnds_image photo;
static enum pbnds_target target;

static enum pbnds_status import_folder(const char *folder,
                                       const struct pbnds_import_options *options,
                                       struct pbnds_gbuffer *g,
                                       struct pbnds_error *error)
{
    return pbnds_import_images(folder, options, g, &photo, &target, &notes, error);
}

static void write_png(const char *name, int width, const float *texel, int channels)
{
    char path[128];
    snprintf(path, sizeof path, MAPS "/%s.png", name);
    struct pbnds_image image;
    struct pbnds_error error = {""};
    must(pbnds_image_init(&image, width, SIDE, channels, &error), &error);
    for (int i = 0; i < width * SIDE * channels; ++i)
        image.data[i] = texel[i % channels];
    must(pbnds_png_write(path, &image, &error), &error);
    pbnds_image_free(&image);
}

static void write_plane(const char *name, const char *channel, float *data)
{
    char path[128];
    snprintf(path, sizeof path, MAPS "/%s.exr", name);
    struct pbnds_exr_channel c = {"", PBNDS_EXR_FLOAT, data};
    snprintf(c.name, sizeof c.name, "%s", channel);
    const struct pbnds_exr exr = {SIDE, SIDE, PBNDS_EXR_ZIP, &c, 1, NULL, 0};
    struct pbnds_error error = {""};
    must(pbnds_exr_write(path, &exr, &error), &error);
}

static void remove_map(const char *name, const char *extension)
{
    char path[128];
    snprintf(path, sizeof path, MAPS "/%s%s", name, extension);
    remove(path);
}

static void folders_of_maps(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    scratch_make(MAPS);
    assert_int_equal(import_folder(MAPS, &nothing_said, &g, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "neither albedo nor normal"));

    /* 188/255 decodes to 0.5029; a normal of length 1 toward up and the eye. */
    write_png("albedo", SIDE, (const float[]){188.0f / 255.0f, 1.0f, 0.0f}, 3);
    must(import_folder(MAPS, &nothing_said, &g, &error), &error);
    assert_near(g.albedo[0][4], 0.5029, 1e-4);
    assert_near(g.albedo[1][4], 1.0, 0.0);
    assert_near(g.roughness[4], 0.5, 0.0);
    assert_near(g.specular[4], 0.04, 1e-7);
    assert_near(g.normal[2][0], 1.0, 1e-6);
    assert_near(g.depth[0], 1.0, 0.0);
    assert_near(g.position[2][0], -1.0, 1e-6);
    assert_near(g.coverage[0], 1.0, 0.0);
    assert_true(noted("albedo: from albedo.png"));
    assert_true(noted("roughness: 0.5 everywhere"));
    assert_true(noted("depth: 1 m everywhere"));
    assert_true(noted("40.00 degrees"));
    pbnds_gbuffer_free(&g);

    write_png("normal", SIDE, (const float[]){0.5f, 0.9f, 0.8f}, 3);
    write_png("roughness", SIDE, (const float[]){0.2f}, 1);
    write_png("metallic", SIDE, (const float[]){1.0f}, 1);
    write_png("ao", SIDE, (const float[]){0.6f}, 1);
    float mask[TEXELS] = {0, 0.25f, 1, 1, 1, 1, 1, 1, 1};
    float depth[TEXELS] = {2, 2, 2, 2, 3, 2, 2, INFINITY, 0};
    write_plane("mask", "Y", mask);
    write_plane("depth", "Z", depth);
    const struct pbnds_import_options fov = {.yfov = 1.0f};
    must(import_folder(MAPS, &fov, &g, &error), &error);
    assert_near(g.camera.yfov, 1.0, 0.0);
    assert_true(g.normal[1][4] > 0.75f && g.normal[2][4] > 0.55f);
    assert_near(g.normal[1][4], 0.8, 4e-3);
    assert_near(g.roughness[4], 0.2, 1e-6);
    assert_near(g.metallic[4], 1.0, 0.0);
    assert_near(g.specular[4],
                0.2126 * (double)g.albedo[0][4] + 0.7152 * (double)g.albedo[1][4],
                1e-6);
    assert_near(g.ao[4], 0.6, 1e-6);
    assert_near(g.depth[4], 3.0, 0.0);
    assert_near(g.position[2][4], -3.0, 1e-6);
    assert_near(g.coverage[1], 0.25, 0.0);
    for (size_t i = 0; i < TEXELS; ++i) {
        const bool hit = i != 0 && i != 7 && i != 8;
        assert_true(isinf(g.depth[i]) == !hit);
        assert_true((g.object_id[i] == UINT32_MAX) == !hit);
    }
    pbnds_gbuffer_free(&g);

    write_png("depth2", SIDE, (const float[]){0.5f}, 1);
    remove_map("depth", ".exr");
    assert_int_equal(rename(MAPS "/depth2.png", MAPS "/depth.png"), 0);
    assert_int_equal(import_folder(MAPS, &fov, &g, &error), PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "8 bits"));
    remove_map("depth", ".png");

    write_png("roughness", SIDE + 1, (const float[]){0.2f}, 1);
    assert_int_equal(import_folder(MAPS, &fov, &g, &error), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "4 x 3"));
    remove_map("roughness", ".png");

    mask[3] = NAN;
    write_plane("mask", "Y", mask);
    assert_int_equal(import_folder(MAPS, &fov, &g, &error), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "(0, 1)"));
    assert_null(g.storage);
    assert_int_equal(import_folder("no/folder", &fov, &g, &error), PBNDS_ERROR_IO);
    assert_int_equal(pbnds_file_write(MAPS "/mask.exr", "damaged", 7, &error),
                     PBNDS_OK);
    assert_int_equal(import_folder(MAPS, &fov, &g, &error), PBNDS_ERROR_FORMAT);
    remove_map("mask", ".exr");
    remove_map("albedo", ".png");
    remove_map("normal", ".png");
    remove_map("metallic", ".png");
    remove_map("ao", ".png");
    assert_int_equal(rmdir(MAPS), 0);
}

/* The photograph goes with its maps: decoded, its alpha the mask, its kind told. */
static void a_photograph_goes_along(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    scratch_make(MAPS);
    write_png("albedo", SIDE, (const float[]){0.5f, 0.5f, 0.5f}, 3);
    write_png("photo", SIDE, (const float[]){188.0f / 255.0f, 1.0f, 0.0f, 0.2f}, 4);
    const struct pbnds_import_options wide = {.xfov = 1.0f, .yfov = 0.1f};
    must(import_folder(MAPS, &wide, &g, &error), &error);
    assert_near(g.camera.yfov, 1.0, 1e-6); /* square: both are the same */
    assert_int_equal(target, PBNDS_TARGET_DISPLAY);
    assert_int_equal(photo.width, SIDE);
    assert_near(photo.data[0], 0.5029, 1e-4);
    assert_near(photo.data[1], 1.0, 0.0);
    assert_near(g.coverage[0], 0.2, 1e-6);
    assert_true(noted("mask: photo's alpha"));
    assert_true(noted("photo: kept as R, G, B, display-referred"));
    pbnds_gbuffer_free(&g);
    pbnds_image_free(&photo);

    /* An opaque photograph leaves the mask to the albedo; what is not covered is black. */
    write_png("photo", SIDE, (const float[]){0.5f, 0.5f, 0.5f}, 3);
    write_png("albedo", SIDE, (const float[]){0.5f, 0.5f, 0.5f, 0.0f}, 4);
    must(import_folder(MAPS, &nothing_said, &g, &error), &error);
    assert_near(g.coverage[4], 0.0, 0.0);
    assert_near(photo.data[12], 0.0, 0.0);
    pbnds_gbuffer_free(&g);
    pbnds_image_free(&photo);
    remove_map("photo", ".png");
    remove_map("albedo", ".png");

    /* Radiance, in a format that holds it; a view twice as wide as high. */
    float white[TEXELS];
    for (int i = 0; i < TEXELS; ++i)
        white[i] = 7.0f;
    write_plane("photo", "Y", white);
    write_png("normal", SIDE, (const float[]){0.5f, 0.5f, 1.0f}, 3);
    float flat[TEXELS];
    for (int i = 0; i < TEXELS; ++i)
        flat[i] = i == 8 ? -1.0f : 2.0f;
    write_plane("depth", "Z", flat);
    must(import_folder(MAPS, &nothing_said, &g, &error), &error);
    assert_int_equal(target, PBNDS_TARGET_RADIANCE);
    assert_near(photo.data[0], 7.0, 0.0);
    assert_true(noted("depth: is the same everywhere"));
    assert_true(noted("depth: 1 pixels that the mask covers have none"));

    pbnds_gbuffer_free(&g);
    pbnds_image_free(&photo);
    remove_map("photo", ".exr");
    remove_map("depth", ".exr");
    remove_map("normal", ".png");
    assert_int_equal(rmdir(MAPS), 0);
}

/* tan(v / 2) = tan(h / 2) height / width. */
static void a_horizontal_view(void **state)
{
    (void)state;
    struct pbnds_gbuffer g;
    struct pbnds_error error = {""};
    scratch_make(MAPS);
    write_png("albedo", 2 * SIDE, (const float[]){0.5f, 0.5f, 0.5f}, 3);
    const struct pbnds_import_options wide = {.xfov = PBNDS_PI / 2.0f};
    must(import_folder(MAPS, &wide, &g, &error), &error);
    assert_near(g.camera.yfov, 2.0 * atan(0.5), 1e-6);
    /* the right edge is seen under 45 degrees */
    assert_near(g.position[0][2 * SIDE - 1] / -g.position[2][2 * SIDE - 1],
                (2 * SIDE - 1.0) / (2 * SIDE), 1e-5);
    pbnds_gbuffer_free(&g);
    remove_map("albedo", ".png");
    assert_int_equal(rmdir(MAPS), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cameras_are_found_from_positions),
        cmocka_unit_test(what_positions_do_not_say),
        cmocka_unit_test(a_file_of_blender),
        cmocka_unit_test(other_layers_and_missing_passes),
        cmocka_unit_test(bad_passes_are_refused),
        cmocka_unit_test(folders_of_maps),
        cmocka_unit_test(a_photograph_goes_along),
        cmocka_unit_test(a_horizontal_view),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
