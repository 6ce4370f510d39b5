/** A small set laid out as FFHQ-PBR, made of one of our own renders. */
#ifndef PBNDS_TESTS_NEURAL_FIXTURE_PHOTOS_H
#define PBNDS_TESTS_NEURAL_FIXTURE_PHOTOS_H

#include "tests/neural/data/fixture_data.h"

#include "engine/core/color.h"
#include "engine/image/oiio.h"
#include "engine/scene/gltf.h"
#include "engine/shade/shader.h"

enum {
    PHOTO_WIDTH = 64,
    PHOTO_HEIGHT = 48,
    PHOTO_ENV_WIDTH = 64,
    PHOTO_ENV_HEIGHT = 32
};

/* Eight texels of the light map: the camera looks this far to the side, degrees. */
static const float photo_yaw = 45.0f;

/** What the pictures are made of: the shipped still life as this layout can hold it (no
 *  metal, no colour in f0), under a light map of wide lamps. */
struct photo_truth {
    struct pbnds_scene scene;
    struct pbnds_accel *accel;
    struct pbnds_gbuffer gbuffer; /* world space */
    struct pbnds_image light;     /* world, gltf convention */
    struct pbnds_envmap *envmap;  /* of it */
    struct pbnds_image radiance;  /* ggx, without shadows */
};

static inline void photo_light(struct pbnds_image *light)
{
    assert_int_equal(
        pbnds_image_init(light, PHOTO_ENV_WIDTH, PHOTO_ENV_HEIGHT, 3, NULL), PBNDS_OK);
    for (int y = 0; y < PHOTO_ENV_HEIGHT; ++y) {
        for (int x = 0; x < PHOTO_ENV_WIDTH; ++x) {
            float *p = pbnds_image_at(light, x, y);
            p[0] = p[1] = p[2] = y < PHOTO_ENV_HEIGHT / 2 ? 0.3f : 0.1f;
            if (y >= 6 && y < 12 && x >= 10 && x < 18) p[0] += 6.0f;
            if (y >= 8 && y < 14 && x >= 40 && x < 46) p[2] += 4.0f;
        }
    }
}

static inline void photo_shade(const struct pbnds_gbuffer *g,
                               const struct pbnds_envmap *envmap, uint64_t seed,
                               struct pbnds_image *radiance)
{
    const struct pbnds_shade_job job = {
        .gbuffer = g, .envmap = envmap, .seed = seed, .spp = 256, .shadows = 0};
    assert_int_equal(pbnds_shade(pbnds_shader_find("ggx"), &job, radiance, NULL),
                     PBNDS_OK);
}

static inline void photo_truth_make(struct photo_truth *t)
{
    *t = (struct photo_truth){.accel = NULL};
    struct pbnds_error error = {""};
    if (pbnds_gltf_load(PBNDS_SOURCE_DIR "/scenes/still_life.glb", NULL, NULL,
                        &t->scene, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    assert_int_equal(pbnds_accel_create(&t->scene, &t->accel, &error), PBNDS_OK);
    const struct pbnds_camera camera =
        pbnds_camera_framing(t->scene.lo, t->scene.hi, photo_yaw, 0.0f, 25.0f, 1.3f);
    assert_int_equal(pbnds_gbuffer_raycast(&t->scene, t->accel, &camera, PHOTO_WIDTH,
                                           PHOTO_HEIGHT, NULL, &t->gbuffer, &error),
                     PBNDS_OK);
    struct pbnds_gbuffer *g = &t->gbuffer;
    for (int i = 0; i < PHOTO_WIDTH * PHOTO_HEIGHT; ++i) {
        g->metallic[i] = 0.0f;
        for (int c = 0; c < 3; ++c)
            g->emission[c][i] = 0.0f;
        if (i % 97 == 0 && g->coverage[i] > 0.0f) g->coverage[i] = 77.0f / 255.0f;
    }
    g->f0[0] = g->f0[1] = g->f0[2] = g->f90 = NULL; /* all lie in g->storage */
    photo_light(&t->light);
    assert_int_equal(
        pbnds_envmap_create(&t->light, PBNDS_ENV_GLTF, 0.0f, 1.0f, &t->envmap, &error),
        PBNDS_OK);
    photo_shade(g, t->envmap, 1, &t->radiance);
}

static inline void photo_truth_free(struct photo_truth *t)
{
    pbnds_gbuffer_free(&t->gbuffer);
    pbnds_accel_free(t->accel);
    pbnds_scene_free(&t->scene);
    pbnds_image_free(&t->light);
    pbnds_envmap_free(t->envmap);
    pbnds_image_free(&t->radiance);
}

/* DIR/SUB/05000/NAME; the folder is made. */
static inline const char *photo_path(const char *dir, const char *sub, const char *name)
{
    static char path[512];
    (void)snprintf(path, sizeof path, "%s/%s/05000", dir, sub);
    assert_int_equal(pbnds_make_folder(path, NULL), PBNDS_OK);
    (void)snprintf(path, sizeof path, "%s/%s/05000/%s", dir, sub, name);
    return path;
}

static inline void photo_png(const char *path, const struct pbnds_image *image)
{
    assert_int_equal(pbnds_png_write(path, image, NULL), PBNDS_OK);
}

/* One map of a picture: the value of each channel at each pixel. */
static inline void photo_map(const char *dir, int id, const char *kind,
                             float *const *planes, int channels, bool color,
                             float scale, float off)
{
    char sub[64], name[64];
    struct pbnds_image image;
    assert_int_equal(
        pbnds_image_init(&image, PHOTO_WIDTH, PHOTO_HEIGHT, channels, NULL), PBNDS_OK);
    for (int i = 0; i < PHOTO_WIDTH * PHOTO_HEIGHT; ++i) {
        for (int c = 0; c < channels; ++c) {
            const float v = scale * planes[c][i] + off;
            image.data[channels * i + c] = color ? pbnds_srgb_encode(v) : v;
        }
    }
    (void)snprintf(sub, sizeof sub, "texture/%s", kind);
    (void)snprintf(name, sizeof name, "%s_%05d.png", kind, id);
    photo_png(photo_path(dir, sub, name), &image);
    pbnds_image_free(&image);
}

static inline void photo_plane(const char *path, int width, int height, float *data)
{
    struct pbnds_exr_channel c = {"Z", PBNDS_EXR_FLOAT, data};
    const struct pbnds_exr exr = {width, height, PBNDS_EXR_ZIP, &c, 1, NULL, 0};
    assert_int_equal(pbnds_exr_write(path, &exr, NULL), PBNDS_OK);
}

/* A light map in the `pbnds` convention: column x of gltf is column x + W / 2 of it. */
static inline void photo_hdri(const char *path, const struct pbnds_image *gltf)
{
    const int w = gltf->width, h = gltf->height;
    float *data = malloc(sizeof(float) * 3 * (size_t)w * (size_t)h);
    assert_non_null(data);
    for (int c = 0; c < 3; ++c) {
        for (int y = 0; y < h; ++y) {
            for (int x = 0; x < w; ++x)
                data[(c * h + y) * w + (x + w / 2) % w] = pbnds_image_at(gltf, x, y)[c];
        }
    }
    struct pbnds_exr_channel channels[3] = {{"R", PBNDS_EXR_FLOAT, data},
                                            {"G", PBNDS_EXR_FLOAT, data + w * h},
                                            {"B", PBNDS_EXR_FLOAT, data + 2 * w * h}};
    const struct pbnds_exr exr = {w, h, PBNDS_EXR_ZIP, channels, 3, NULL, 0};
    assert_int_equal(pbnds_exr_write(path, &exr, NULL), PBNDS_OK);
    free(data);
}

/* The light as the camera sees it: a turn by eight columns. The camera's -z is the world's
 * direction (-sin yaw, 0, -cos yaw), so that the camera's u is the world's u plus yaw. */
static inline void photo_camera_light(const struct pbnds_image *world,
                                      struct pbnds_image *camera)
{
    const int turn = (int)(photo_yaw / 360.0f * (float)world->width + 0.5f);
    assert_int_equal(pbnds_image_init(camera, world->width, world->height, 3, NULL),
                     PBNDS_OK);
    for (int y = 0; y < world->height; ++y) {
        for (int x = 0; x < world->width; ++x)
            memcpy(pbnds_image_at(camera, (x + turn) % world->width, y),
                   pbnds_image_at(world, x, y), 3 * sizeof(float));
    }
}

/** Writes everything of picture `id` but its field of view. */
static inline void photo_write(const struct photo_truth *t, const char *dir, int id)
{
    const struct pbnds_gbuffer *g = &t->gbuffer;
    char name[64];
    struct pbnds_image image;
    assert_int_equal(pbnds_image_init(&image, PHOTO_WIDTH, PHOTO_HEIGHT, 4, NULL),
                     PBNDS_OK);
    float *normal[3], *depth = malloc(sizeof(float) * PHOTO_WIDTH * PHOTO_HEIGHT);
    float *block = malloc(3 * sizeof(float) * PHOTO_WIDTH * PHOTO_HEIGHT);
    assert_true(depth && block);
    for (int c = 0; c < 3; ++c)
        normal[c] = block + c * PHOTO_WIDTH * PHOTO_HEIGHT;
    for (int i = 0; i < PHOTO_WIDTH * PHOTO_HEIGHT; ++i) {
        for (int c = 0; c < 3; ++c) /* something beside the mask, too */
            image.data[4 * i + c] = g->coverage[i] > 0.0f
                                        ? pbnds_srgb_encode(t->radiance.data[3 * i + c])
                                        : 0.25f;
        image.data[4 * i + 3] = g->coverage[i];
        const struct pbnds_vec3 n = pbnds_camera_from_world_vector(
            &g->camera,
            pbnds_vec3_make(g->normal[0][i], g->normal[1][i], g->normal[2][i]));
        normal[0][i] = n.x;
        normal[1][i] = n.y;
        normal[2][i] = n.z;
        depth[i] = isfinite(g->depth[i]) ? g->depth[i] : 0.0f;
    }
    (void)snprintf(name, sizeof name, "%05d.png", id);
    photo_png(photo_path(dir, "bgremoval", name), &image);
    pbnds_image_free(&image);
    photo_map(dir, id, "albedo", g->albedo, 3, true, 1.0f, 0.0f);
    photo_map(dir, id, "normal", normal, 3, false, 0.5f, 0.5f);
    photo_map(dir, id, "roughness", &g->roughness, 1, false, 1.0f, 0.0f);
    photo_map(dir, id, "specular", &g->specular, 1, false, 1.0f, 0.0f);
    (void)snprintf(name, sizeof name, "depth_%05d.exr", id);
    photo_plane(photo_path(dir, "texture/depth", name), PHOTO_WIDTH, PHOTO_HEIGHT,
                depth);
    struct pbnds_image light;
    photo_camera_light(&t->light, &light);
    (void)snprintf(name, sizeof name, "hdri_%05d.exr", id);
    photo_hdri(photo_path(dir, "hdri", name), &light);
    pbnds_image_free(&light);
    free(depth);
    free(block);
}

/** Horizontal field of view, degrees. */
static inline double photo_xfov(const struct photo_truth *t)
{
    return 2.0 *
           atan(tan(0.5 * (double)t->gbuffer.camera.yfov) * PHOTO_WIDTH /
                PHOTO_HEIGHT) *
           180.0 / 3.14159265358979323846;
}

/** pred_fov.json of the pictures [first, last]. */
static inline void photo_fov(const struct photo_truth *t, const char *dir, int first,
                             int last)
{
    char path[512], text[4096] = "{";
    size_t n = 1;
    for (int id = first; id <= last; ++id)
        n += (size_t)snprintf(text + n, sizeof text - n, "%s\"%05d\": %.9g",
                              id > first ? ", " : "", id, photo_xfov(t));
    n += (size_t)snprintf(text + n, sizeof text - n, "}");
    (void)snprintf(path, sizeof path, "%s/pred_fov.json", dir);
    assert_int_equal(pbnds_file_write(path, text, n, NULL), PBNDS_OK);
}
#endif /* PBNDS_TESTS_NEURAL_FIXTURE_PHOTOS_H */
