/* Photographs with their maps become a data set: against the renders that they were made
 * of. */
#include "neural/data/import_ffhq.h"

#include <cjson/cJSON.h>
#include <dirent.h>

#include "neural/data/assets.h"
#include "neural/data/sample.h"
#include "neural/data/store.h"
#include "neural/train/item.h"
#include "tests/neural/data/fixture_photos.h"

#define SET  "test_import_ffhq"
#define DATA "test_import_ffhq_data"

static struct photo_truth truth;
static const struct pbnds_ffhq_options nothing_said = {.yfov = 0.0f};

static int make_truth(void **state)
{
    (void)state;
    fixture_remove(SET);
    fixture_remove(DATA);
    photo_truth_make(&truth);
    return 0;
}

static int free_truth(void **state)
{
    (void)state;
    photo_truth_free(&truth);
    fixture_remove(SET);
    fixture_remove(DATA);
    return 0;
}

static int set_first;

/* A set of the pictures [first, last], and no data. */
static void make_set(int first, int last)
{
    set_first = first;
    fixture_remove(SET);
    fixture_remove(DATA);
    for (int id = first; id <= last; ++id)
        photo_write(&truth, SET, id);
    photo_fov(&truth, SET, first, last);
}

static struct pbnds_ffhq_result import(void)
{
    struct pbnds_ffhq_result result;
    struct pbnds_error error = {""};
    if (pbnds_import_ffhq(SET, DATA, &nothing_said, NULL, &result, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    return result;
}

static int imported(const struct pbnds_ffhq_result *r)
{
    return r->count[0] + r->count[1] + r->count[2];
}

static enum pbnds_split split_of(int id)
{
    char name[16];
    (void)snprintf(name, sizeof name, "%05d", id);
    return pbnds_split_of_name(name);
}

/* Samples are numbered within their split in the order of the pictures. */
static const char *sample_path(int id, const char *file)
{
    static char path[256];
    int number = 0;
    for (int other = set_first; other < id; ++other)
        number += split_of(other) == split_of(id);
    (void)snprintf(path, sizeof path, DATA "/%s/%06d%s%s",
                   pbnds_split_name(split_of(id)), number, file[0] ? "/" : "", file);
    return path;
}

static struct pbnds_sample load(int id)
{
    struct pbnds_sample sample;
    struct pbnds_error error = {""};
    if (pbnds_sample_load(sample_path(id, ""), 0, &sample, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    return sample;
}

static cJSON *read_json(const char *path)
{
    uint8_t *text;
    size_t size;
    assert_int_equal(pbnds_file_read(path, (size_t)1 << 20, &text, &size, NULL),
                     PBNDS_OK);
    cJSON *json = cJSON_Parse((const char *)text);
    free(text);
    assert_non_null(json);
    return json;
}

static void assert_text(const cJSON *json, const char *key, const char *want)
{
    const cJSON *item = cJSON_GetObjectItem(json, key);
    assert_true(cJSON_IsString(item));
    if (!strstr(item->valuestring, want))
        fail_msg("%s: no '%s' in '%s'", key, want, item->valuestring);
}

/* ------------------------------------------------------------ sound pictures */

static void planes_come_back(void **state)
{
    (void)state;
    make_set(5030, 5030);
    const struct pbnds_ffhq_result result = import();
    assert_int_equal(imported(&result), 1);
    assert_int_equal(result.left_out, 0);
    struct pbnds_sample sample = load(5030);
    const struct pbnds_gbuffer *g = &sample.gbuffer, *t = &truth.gbuffer;
    assert_int_equal(g->width, PHOTO_WIDTH);
    assert_int_equal(g->height, PHOTO_HEIGHT);
    assert_near(g->camera.yfov, t->camera.yfov, 1e-6);
    assert_int_equal(sample.target, PBNDS_TARGET_DISPLAY);
    assert_null(sample.direct.data);
    assert_null(sample.visibility);
    const float *m = t->camera.world_from_camera.m;
    const double step = 0.5 / 255.0, half = 1.0 / 2048.0;
    int covered = 0, partly = 0;
    for (size_t i = 0; i < PHOTO_WIDTH * PHOTO_HEIGHT; ++i) {
        assert_true(isinf(g->depth[i]) == isinf(t->depth[i]));
        assert_near(g->coverage[i], t->coverage[i], 1e-4);
        if (isinf(t->depth[i])) {
            for (size_t c = 0; c < 3; ++c)
                assert_near(sample.radiance.data[3 * i + c], 0.0, 0.0);
            continue;
        }
        ++covered;
        partly += t->coverage[i] < 1.0f;
        assert_near(g->depth[i], t->depth[i], 0.0);
        assert_near(g->roughness[i], t->roughness[i], step + half);
        assert_near(g->specular[i], t->specular[i], step + half);
        assert_near(g->metallic[i], 0.0, 0.0);
        const struct pbnds_vec3 eye = {m[12], m[13], m[14]};
        const struct pbnds_vec3 p = pbnds_camera_from_world_vector(
            &t->camera, pbnds_sub(pbnds_vec3_make(t->position[0][i], t->position[1][i],
                                                  t->position[2][i]),
                                  eye));
        assert_near(g->position[0][i], p.x, 1e-4);
        assert_near(g->position[1][i], p.y, 1e-4);
        assert_near(g->position[2][i], p.z, 1e-4);
        const struct pbnds_vec3 n = pbnds_camera_from_world_vector(
            &t->camera,
            pbnds_vec3_make(t->normal[0][i], t->normal[1][i], t->normal[2][i]));
        /* half a code value a component, then made unit */
        const struct pbnds_vec3 off = pbnds_sub(
            n, pbnds_vec3_make(g->normal[0][i], g->normal[1][i], g->normal[2][i]));
        assert_true(pbnds_length(off) <= 2.0f * 0.5f / 255.0f * sqrtf(3.0f) + 1e-4f);
        for (size_t c = 0; c < 3; ++c) {
            assert_near(pbnds_srgb_encode(g->albedo[c][i]),
                        pbnds_srgb_encode(t->albedo[c][i]), step + half);
            assert_near(pbnds_srgb_encode(sample.radiance.data[3 * i + c]),
                        pbnds_srgb_encode(truth.radiance.data[3 * i + c]), step + 1e-4);
        }
    }
    assert_true(covered > 500 && partly > 3);
    pbnds_sample_free(&sample);

    cJSON *json = read_json(sample_path(5030, "sample.json"));
    assert_text(json, "target", "display");
    assert_text(json, "frame", "camera");
    assert_text(json, "light_convention", "pbnds");
    assert_text(json, "depth", "unknown scale");
    assert_text(json, "asset", "05030");
    assert_near(cJSON_GetObjectItem(json, "xfov_deg")->valuedouble, photo_xfov(&truth),
                1e-4);
    cJSON_Delete(json);
    json = read_json(DATA "/dataset.json");
    assert_text(json, "target", "display");
    assert_text(json, "identities", "unknown");
    assert_text(json, "source", SET);
    cJSON_Delete(json);
    json = read_json(DATA "/manifest.json");
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(json, "samples")), 1);
    cJSON_Delete(json);
}

static double psnr(const struct pbnds_image *a, const struct pbnds_image *b,
                   const struct pbnds_gbuffer *g)
{
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < PHOTO_WIDTH * PHOTO_HEIGHT; ++i) {
        if (!isfinite(g->depth[i])) continue;
        ++count;
        for (int c = 0; c < 3; ++c) {
            const double d = (double)pbnds_srgb_encode(a->data[3 * i + c]) -
                             (double)pbnds_srgb_encode(b->data[3 * i + c]);
            sum += d * d / 3.0;
        }
    }
    return -10.0 * log10(sum / count);
}

/* The imported G-buffer under the imported light, both in the camera's frame, looks like
 * the render in the world's: to the noise and the eight bits. */
static void relighting_agrees(void **state)
{
    (void)state;
    struct pbnds_sample sample = load(5030);
    struct pbnds_image relit, again, wrong;
    photo_shade(&sample.gbuffer, sample.envmap, 2, &relit);
    photo_shade(&truth.gbuffer, truth.envmap, 3, &again);
    const double noise = psnr(&again, &truth.radiance, &truth.gbuffer);
    const double direct = psnr(&relit, &truth.radiance, &truth.gbuffer);
    print_message("relit %.2f dB, two renders %.2f dB\n", direct, noise);
    assert_true(noise > 36.0);
    assert_true(direct > fmin(noise - 1.5, 40.0));
    assert_true(psnr(&relit, &sample.radiance, &truth.gbuffer) > direct - 0.5);

    /* It would show if the light stood elsewhere: a few degrees, a quarter turn, half. */
    static const float turns[] = {11.25f, 90.0f, 180.0f};
    for (int k = 0; k < 3; ++k) {
        struct pbnds_envmap *turned;
        assert_int_equal(pbnds_envmap_load(sample_path(5030, "light.exr"),
                                           PBNDS_ENV_GLTF, turns[k], 1.0f, &turned,
                                           NULL),
                         PBNDS_OK);
        photo_shade(&sample.gbuffer, turned, 2, &wrong);
        const double off = psnr(&wrong, &truth.radiance, &truth.gbuffer);
        print_message("turned by %g degrees %.2f dB\n", (double)turns[k], off);
        assert_true(off < direct - (k == 0 ? 3.0 : 12.0));
        pbnds_envmap_free(turned);
        pbnds_image_free(&wrong);
    }
    pbnds_image_free(&relit);
    pbnds_image_free(&again);
    pbnds_sample_free(&sample);
}

/* u_pbnds = u_gltf + 1/2: what the camera looks at (-z) is at u = 3/4 of the source, and
 * every texel comes back, to the bit. */
static void the_light_is_rolled(void **state)
{
    (void)state;
    make_set(7, 8);
    struct pbnds_image map;
    assert_int_equal(pbnds_image_init(&map, 32, 16, 3, NULL), PBNDS_OK);
    for (int i = 0; i < 32 * 16 * 3; ++i)
        map.data[i] = (float)i / 128.0f; /* eleven bits: half holds them */
    photo_hdri(photo_path(SET, "hdri", "hdri_00007.exr"), &map);
    /* the chart: an axis, a colour; as wide as the data set's maps twice over */
    struct pbnds_image chart;
    assert_int_equal(
        pbnds_image_read_rgb(PBNDS_SOURCE_DIR "/scenes/chart.hdr", &chart, NULL),
        PBNDS_OK);
    photo_hdri(photo_path(SET, "hdri", "hdri_00008.exr"), &chart);
    const struct pbnds_ffhq_result result = import();
    assert_int_equal(imported(&result), 2);

    struct pbnds_exr exr;
    assert_int_equal(pbnds_exr_read(sample_path(7, "light.exr"), &exr, NULL), PBNDS_OK);
    assert_int_equal(exr.width, 32);
    static const char *const names[3] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        const float *plane = pbnds_exr_find(&exr, names[c])->data;
        for (int i = 0; i < 32 * 16; ++i)
            assert_near(plane[i], map.data[3 * i + c], 0.0);
    }
    pbnds_exr_free(&exr);

    struct pbnds_sample sample = load(8);
    struct pbnds_envmap *straight;
    assert_int_equal(
        pbnds_envmap_create(&chart, PBNDS_ENV_GLTF, 0.0f, 1.0f, &straight, NULL),
        PBNDS_OK);
    for (int axis = 0; axis < 6; ++axis) {
        const float s = axis < 3 ? 1.0f : -1.0f;
        /* beside the glyph in the middle of the face, off the edges of texels */
        const struct pbnds_vec3 w = pbnds_normalize(
            pbnds_vec3_make(axis % 3 == 0 ? s : 0.37f, axis % 3 == 1 ? s : 0.41f,
                            axis % 3 == 2 ? s : 0.35f));
        const struct pbnds_vec3 a = pbnds_envmap_eval(sample.envmap, w);
        const struct pbnds_vec3 b = pbnds_envmap_eval(straight, w);
        assert_near(a.x, b.x, 1e-3);
        assert_near(a.y, b.y, 1e-3);
        assert_near(a.z, b.z, 1e-3);
    }
    /* +x is red, -z yellow (chart_light.c) */
    const struct pbnds_vec3 x = pbnds_envmap_eval(
        sample.envmap, pbnds_normalize(pbnds_vec3_make(1.0f, 0.41f, 0.35f)));
    const struct pbnds_vec3 z = pbnds_envmap_eval(
        sample.envmap, pbnds_normalize(pbnds_vec3_make(0.37f, 0.41f, -1.0f)));
    assert_true(x.x > 2.0f * x.y && x.x > 2.0f * x.z);
    assert_true(z.x > 2.0f * z.z && z.y > 2.0f * z.z);
    pbnds_exr_free(&exr);
    cJSON *json = read_json(sample_path(8, "sample.json"));
    assert_int_equal(cJSON_GetObjectItem(json, "light_width")->valueint, 512);
    cJSON_Delete(json);
    pbnds_envmap_free(straight);
    pbnds_sample_free(&sample);
    pbnds_image_free(&map);
    pbnds_image_free(&chart);
}

/* ------------------------------------------------------------ broken pictures */

static void put(const char *path, const char *text)
{
    assert_int_equal(pbnds_file_write(path, text, strlen(text), NULL), PBNDS_OK);
}

static void break_depth(int id, float value, size_t from, size_t count)
{
    char name[64];
    (void)snprintf(name, sizeof name, "depth_%05d.exr", id);
    float depth[PHOTO_WIDTH * PHOTO_HEIGHT];
    for (size_t i = 0; i < PHOTO_WIDTH * PHOTO_HEIGHT; ++i)
        depth[i] = i >= from && i - from < count ? value : 3.0f;
    photo_plane(photo_path(SET, "texture/depth", name), PHOTO_WIDTH, PHOTO_HEIGHT,
                depth);
}

struct heard {
    int warnings;
    char last[400];
};

static void hear(void *user, const char *sentence)
{
    struct heard *h = user;
    ++h->warnings;
    (void)snprintf(h->last, sizeof h->last, "%s", sentence);
}

static const char *reason_of(const cJSON *report, const char *id)
{
    const cJSON *list = cJSON_GetObjectItem(report, "left_out"), *item;
    cJSON_ArrayForEach(item, list)
    {
        if (strcmp(cJSON_GetObjectItem(item, "id")->valuestring, id) == 0)
            return cJSON_GetObjectItem(item, "reason")->valuestring;
    }
    fail_msg("%s is not listed", id);
    return "";
}

static void broken_pictures_are_listed(void **state)
{
    (void)state;
    make_set(10, 25);
    photo_fov(&truth, SET, 10, 23); /* 24 and 25: none */
    /* 10 and 11 stay sound */
    assert_int_equal(truncate(photo_path(SET, "bgremoval", "00012.png"), 200), 0);
    assert_int_equal(remove(photo_path(SET, "hdri", "hdri_00013.exr")), 0);
    struct pbnds_image small;
    assert_int_equal(pbnds_image_init(&small, 16, 16, 3, NULL), PBNDS_OK);
    for (int i = 0; i < 16 * 16 * 3; ++i)
        small.data[i] = 0.5f;
    photo_png(photo_path(SET, "texture/albedo", "albedo_00014.png"), &small);
    photo_hdri(photo_path(SET, "hdri", "hdri_00015.exr"), &small);
    pbnds_image_free(&small);
    break_depth(16, NAN, 100, 1);
    break_depth(17, -1.0f, 0, PHOTO_WIDTH * PHOTO_HEIGHT);
    put(photo_path(SET, "hdri", "hdri_00018.exr"), "no light");
    struct pbnds_image black;
    assert_int_equal(pbnds_image_init(&black, 32, 16, 3, NULL), PBNDS_OK);
    photo_hdri(photo_path(SET, "hdri", "hdri_00019.exr"), &black);
    pbnds_image_free(&black);
    assert_int_equal(remove(photo_path(SET, "texture/normal", "normal_00020.png")), 0);
    struct pbnds_image clear;
    assert_int_equal(pbnds_image_init(&clear, PHOTO_WIDTH, PHOTO_HEIGHT, 4, NULL),
                     PBNDS_OK);
    photo_png(photo_path(SET, "bgremoval", "00021.png"), &clear);
    pbnds_image_free(&clear);
    /* depth: missing, and constant: imported, and told */
    assert_int_equal(remove(photo_path(SET, "texture/depth", "depth_00022.exr")), 0);
    break_depth(23, 3.0f, 0, 0);
    /* names */
    put(photo_path(SET, "bgremoval", "face.png"), "x");
    put(photo_path(SET, "bgremoval", "notes.txt"), "x");
    assert_int_equal(pbnds_make_folder(SET "/bgremoval/other", NULL), PBNDS_OK);
    put(SET "/bgremoval/other/00010.png", "another of this number");

    struct heard heard = {0, ""};
    const struct pbnds_report report = {.warn = hear, .user = &heard};
    struct pbnds_ffhq_result result;
    struct pbnds_error error = {""};
    assert_int_equal(
        pbnds_import_ffhq(SET, DATA, &nothing_said, &report, &result, &error),
        PBNDS_OK);
    assert_int_equal(imported(&result), 4);
    assert_int_equal(result.left_out, 14);
    assert_int_equal(heard.warnings, 14);
    assert_non_null(strstr(heard.last, "is left out"));

    static const struct {
        const char *id, *reason;
    } cases[] = {{"00012", "00012.png"},
                 {"00013", "hdri_00013.exr: is missing"},
                 {"00014", "16 x 16"},
                 {"00015", "twice as wide"},
                 {"00016", "not a finite number at pixel (36, 1)"},
                 {"00017", "nothing that has a positive depth"},
                 {"00018", "hdri_00018.exr"},
                 {"00019", "is black"},
                 {"00020", "normal_00020.png: is missing"},
                 {"00021", "00021.png: shows nothing"},
                 {"00024", "gives 00024 no field of view"},
                 {"00025", "gives 00025 no field of view"},
                 {"face", "is no number"},
                 {"00010", "of another picture"}};
    cJSON *listed = read_json(DATA "/import.json");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        if (!strstr(reason_of(listed, cases[i].id), cases[i].reason))
            fail_msg("%s: %s", cases[i].id, reason_of(listed, cases[i].id));
    }
    assert_int_equal(cJSON_GetObjectItem(listed, "imported")->valueint, 4);
    cJSON_Delete(listed);

    cJSON *json = read_json(DATA "/manifest.json"); /* what has a number has a place */
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(json, "samples")), 4);
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(json, "quarantined")), 12);
    cJSON_Delete(json);
    json = read_json(sample_path(22, "sample.json"));
    assert_text(json, "depth", "missing");
    cJSON_Delete(json);
    json = read_json(sample_path(23, "sample.json"));
    assert_text(json, "depth", "constant");
    cJSON_Delete(json);

    /* Mended, and with a field of view for the others, the same command does the rest;
     * what was there is not touched. */
    photo_write(&truth, SET, 13);
    uint8_t *before, *after;
    size_t n, m;
    assert_int_equal(
        pbnds_file_read(sample_path(10, "sample.exr"), 1u << 24, &before, &n, NULL),
        PBNDS_OK);
    assert_int_equal(remove(photo_path(SET, "hdri", "hdri_00010.exr")), 0);
    const struct pbnds_ffhq_options wide = {.yfov = 0.5f};
    assert_int_equal(pbnds_import_ffhq(SET, DATA, &wide, NULL, &result, &error),
                     PBNDS_OK);
    assert_int_equal(imported(&result), 7);
    assert_int_equal(
        pbnds_file_read(sample_path(10, "sample.exr"), 1u << 24, &after, &m, NULL),
        PBNDS_OK);
    assert_true(n == m && memcmp(before, after, n) == 0);
    free(before);
    free(after);
    struct pbnds_sample sample = load(24);
    assert_near(sample.gbuffer.camera.yfov, 0.5, 1e-6);
    pbnds_sample_free(&sample);
    json = read_json(DATA "/manifest.json");
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(json, "quarantined")), 9);
    cJSON_Delete(json);
}

/* The same samples, in tar files. */
static void into_tar_files(void **state)
{
    (void)state;
    make_set(70, 74);
    const struct pbnds_ffhq_options tar = {.format = PBNDS_DATASET_TAR, .per_tar = 2};
    struct pbnds_ffhq_result result;
    struct pbnds_error error = {""};
    (void)import();
    assert_int_equal(rename(DATA, DATA "_folders"), 0);
    if (pbnds_import_ffhq(SET, DATA, &tar, NULL, &result, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    assert_int_equal(imported(&result), 5);
    int compared = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        struct pbnds_sample_list a, b;
        assert_int_equal(pbnds_dataset_list(DATA, (enum pbnds_split)s, &a, NULL),
                         PBNDS_OK);
        assert_int_equal(
            pbnds_dataset_list(DATA "_folders", (enum pbnds_split)s, &b, NULL),
            PBNDS_OK);
        assert_int_equal(a.count, b.count);
        for (int i = 0; i < a.count; ++i, ++compared) {
            struct pbnds_sample x, y;
            assert_int_equal(pbnds_sample_load(a.folders[i], 0, &x, NULL), PBNDS_OK);
            assert_int_equal(pbnds_sample_load(b.folders[i], 0, &y, NULL), PBNDS_OK);
            assert_memory_equal(x.radiance.data, y.radiance.data,
                                3 * sizeof(float) * PHOTO_WIDTH * PHOTO_HEIGHT);
            assert_int_equal(x.target, PBNDS_TARGET_DISPLAY);
            pbnds_sample_free(&x);
            pbnds_sample_free(&y);
        }
        pbnds_sample_list_free(&a);
        pbnds_sample_list_free(&b);
    }
    assert_int_equal(compared, 5);
    fixture_remove(DATA "_folders");
}

static void nothing_to_import(void **state)
{
    (void)state;
    make_set(30, 30);
    struct pbnds_ffhq_result result;
    struct pbnds_error error = {""};
    assert_int_equal(remove(SET "/pred_fov.json"), 0);
    assert_int_equal(pbnds_import_ffhq(SET, DATA, &nothing_said, NULL, &result, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "no picture could be imported"));
    assert_non_null(strstr(error.message, "pred_fov.json"));
    assert_int_equal(result.left_out, 1);
    assert_int_not_equal(access(DATA "/dataset.json", F_OK), 0);
    assert_int_equal(access(DATA "/import.json", F_OK), 0);
    put(SET "/pred_fov.json", "{\"00030\": 40");
    assert_int_equal(pbnds_import_ffhq(SET, DATA, &nothing_said, NULL, &result, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "pred_fov.json: is no JSON"));
    assert_int_equal(
        pbnds_import_ffhq("no/such", DATA, &nothing_said, NULL, &result, &error),
        PBNDS_ERROR_IO);
    assert_int_equal(
        pbnds_import_ffhq(SET "/bgremoval", DATA, &nothing_said, NULL, &result, &error),
        PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "bgremoval"));
    fixture_remove(SET);
    assert_int_equal(pbnds_make_folder(SET "/bgremoval", NULL), PBNDS_OK);
    assert_int_equal(pbnds_import_ffhq(SET, DATA, &nothing_said, NULL, &result, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "no .png"));
}

/* ------------------------------------------------------------ splits, training, stops */

static int count_of(enum pbnds_split split)
{
    struct pbnds_sample_list list;
    assert_int_equal(pbnds_dataset_list(DATA, split, &list, NULL), PBNDS_OK);
    const int count = list.count;
    pbnds_sample_list_free(&list);
    return count;
}

static void split_files_decide(void **state)
{
    (void)state;
    make_set(40, 43);
    put(SET "/train.txt", "00040\n00041\n");
    put(SET "/test.txt", "# of the paper\n05000/00042.png\n");
    struct pbnds_ffhq_result result = import();
    assert_int_equal(result.count[PBNDS_SPLIT_TRAIN], 2);
    assert_int_equal(result.count[PBNDS_SPLIT_TEST], 1);
    assert_int_equal(result.left_out, 1);
    assert_int_equal(count_of(PBNDS_SPLIT_TRAIN), 2);
    assert_int_equal(count_of(PBNDS_SPLIT_VAL), 0);
    assert_int_equal(access(DATA "/test/000000/sample.exr", F_OK), 0);
    cJSON *listed = read_json(DATA "/import.json");
    assert_non_null(strstr(reason_of(listed, "00043"), "in none of train.txt"));
    cJSON_Delete(listed);

    /* Other splits would put a picture into two of them. */
    struct pbnds_error error = {""};
    put(SET "/test.txt", "00041\n");
    assert_int_equal(pbnds_import_ffhq(SET, DATA, &nothing_said, NULL, &result, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "picture 41"));
    put(SET "/train.txt", "00040\n00042\n"); /* as many, of the same pictures */
    put(SET "/test.txt", "00041\n");
    assert_int_equal(pbnds_import_ffhq(SET, DATA, &nothing_said, NULL, &result, &error),
                     PBNDS_ERROR_ARGUMENT);
    put(SET "/test.txt", "00043\n");
    assert_int_equal(pbnds_import_ffhq(SET, DATA, &nothing_said, NULL, &result, &error),
                     PBNDS_ERROR_ARGUMENT);
}

/* Photographs teach the model of the displayed image, and not that of light. */
static void who_may_train(void **state)
{
    (void)state;
    make_set(50, 50);
    (void)import();
    struct pbnds_train_item item;
    struct pbnds_error error = {""};
    assert_int_equal(pbnds_train_item_load(sample_path(50, ""), true, &item, &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "is a photograph"));
    assert_non_null(strstr(error.message, sample_path(50, "")));
    assert_int_equal(pbnds_train_item_load(sample_path(50, ""), false, &item, &error),
                     PBNDS_OK);
    assert_null(item.direct);
    assert_null(item.visibility);
    assert_true(item.light_count > 0);
    struct pbnds_sample sample = load(50);
    for (int i = 0; i < 3 * PHOTO_WIDTH * PHOTO_HEIGHT; ++i)
        assert_near(item.radiance[i], sample.radiance.data[i], 0.0);
    pbnds_sample_free(&sample);
    pbnds_train_item_free(&item);
}

static void stop_at_third(void *user, const char *stage, double done, double total)
{
    (void)user;
    (void)stage;
    (void)total;
    if (done >= 2.0) pbnds_request_stop();
}

/* The last test: the flag stays raised. */
static void a_stop_leaves_whole_samples(void **state)
{
    (void)state;
    make_set(60, 64);
    assert_int_equal(remove(photo_path(SET, "hdri", "hdri_00060.exr")), 0);
    const struct pbnds_report report = {.progress = stop_at_third};
    struct pbnds_ffhq_result result;
    struct pbnds_error error = {""};
    assert_int_equal(
        pbnds_import_ffhq(SET, DATA, &nothing_said, &report, &result, &error),
        PBNDS_ERROR_INTERRUPTED);
    assert_int_equal(imported(&result), 1);
    struct pbnds_sample sample = load(61);
    pbnds_sample_free(&sample);
    assert_int_not_equal(access(DATA "/manifest.json", F_OK), 0);
    assert_int_equal(system("test -z \"$(find " DATA " -name '.tmp-*')\""), 0);
    cJSON *listed = read_json(DATA "/import.json");
    assert_non_null(strstr(reason_of(listed, "00060"), "is missing"));
    cJSON_Delete(listed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes_come_back),
        cmocka_unit_test(relighting_agrees),
        cmocka_unit_test(the_light_is_rolled),
        cmocka_unit_test(broken_pictures_are_listed),
        cmocka_unit_test(into_tar_files),
        cmocka_unit_test(nothing_to_import),
        cmocka_unit_test(split_files_decide),
        cmocka_unit_test(who_may_train),
        cmocka_unit_test(a_stop_leaves_whole_samples),
    };
    return cmocka_run_group_tests_name("neural/data/import_ffhq", tests, make_truth,
                                       free_truth);
}
