/* Making a data set: the recipe's manifest, then one folder a sample, each a pure
 * function of (recipe, seed, id). */
#include "neural/data/dataset.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/core/rng.h"
#include "engine/scene/gltf.h"
#include "engine/shade/pathtrace.h"
#include "neural/data/assets.h"

static const char *const SCENE_EXTENSIONS[] = {".glb", ".gltf", NULL};
static const char *const ENV_EXTENSIONS[] = {".hdr", ".exr", NULL};

/* Streams of random numbers of a sample, so that one more draw in one place does not
 * move the others. */
enum { STREAM_CHOICE, STREAM_CAMERA, STREAM_LIGHT, STREAM_TRACE };

struct maker {
    const struct pbnds_dataset_recipe *recipe;
    const char *dir;
    const struct pbnds_report *report;
    struct pbnds_asset_list scenes, envs;
    /* The scene loaded last: neighbours in id often want another, so this only helps
     * small data sets of large assets. */
    int loaded;
    struct pbnds_scene scene;
    struct pbnds_accel *accel;
    bool
        writing; /* files of the data set are being written: its errors are not an asset's */
};

/* What one sample turned out to be. */
struct draw {
    int id;
    enum pbnds_split split;
    const struct pbnds_asset *asset, *env;
    float yaw_deg, strength;
    struct pbnds_camera camera;
};

static float uniform(struct pbnds_rng *rng, float lo, float hi)
{
    return lo + (hi - lo) * pbnds_rng_float(rng);
}

static bool split_is_filled(const struct maker *m, int split)
{
    return m->scenes.first[split + 1] > m->scenes.first[split] &&
           m->envs.first[split + 1] > m->envs.first[split];
}

/* Ids go round the splits in tens: eight train, one val, one test, where there are
 * such. */
static int split_of_id(const struct maker *m, int id)
{
    if (m->recipe->only_split >= 0) return m->recipe->only_split;
    const int wish = id % 10 == 8   ? PBNDS_SPLIT_VAL
                     : id % 10 == 9 ? PBNDS_SPLIT_TEST
                                    : PBNDS_SPLIT_TRAIN;
    return split_is_filled(m, wish) ? wish : PBNDS_SPLIT_TRAIN;
}

static const struct pbnds_asset *choose(const struct pbnds_asset_list *list, int split,
                                        uint64_t r)
{
    const int first = list->first[split], n = list->first[split + 1] - first;
    return &list->items[first + (int)(r % (uint64_t)n)];
}

static enum pbnds_status load_scene(struct maker *m, const struct pbnds_asset *asset,
                                    struct pbnds_error *error)
{
    const int index = (int)(asset - m->scenes.items);
    if (m->loaded == index) return PBNDS_OK;
    pbnds_accel_free(m->accel);
    m->accel = NULL;
    pbnds_scene_free(&m->scene);
    m->loaded = -1;
    PBNDS_TRY(pbnds_gltf_load(asset->path, NULL, NULL, &m->scene, error));
    /* A wall that stops light and that the camera looks through is nothing to learn from:
     * the G-buffer does not tell of it. */
    for (int i = 0; i < m->scene.material_count; ++i)
        m->scene.materials[i].double_sided = true;
    PBNDS_TRY(pbnds_accel_create(&m->scene, &m->accel, error));
    m->loaded = index;
    return PBNDS_OK;
}

/* Enough of the picture shows something, it is not all one plane (the back of a wall),
 * and the eye is not inside or against a surface. */
static bool camera_is_good(const struct maker *m, const struct pbnds_camera *camera,
                           int width, int height)
{
    struct pbnds_gbuffer g;
    if (pbnds_gbuffer_raycast(&m->scene, m->accel, camera, width, height, NULL, &g,
                              NULL) != PBNDS_OK) {
        return false;
    }
    const struct pbnds_vec3 size = pbnds_sub(m->scene.hi, m->scene.lo);
    const float too_near = 0.02f * pbnds_length(size);
    const size_t count = (size_t)width * (size_t)height;
    size_t covered = 0, near = 0;
    struct pbnds_vec3 normals = pbnds_splat(0.0f);
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(g.depth[i])) continue;
        ++covered;
        if (g.depth[i] < too_near) ++near;
        normals = pbnds_add(normals, pbnds_vec3_make(g.geometric_normal[0][i],
                                                     g.geometric_normal[1][i],
                                                     g.geometric_normal[2][i]));
    }
    pbnds_gbuffer_free(&g);
    const bool flat = pbnds_length(normals) > 0.93f * (float)covered;
    return covered * 100 >= 15 * count && near * 100 <= covered && !flat;
}

/* Cameras on a shell about the scene, looking near its centre. */
static bool draw_camera(const struct maker *m, struct pbnds_rng *rng,
                        struct pbnds_camera *camera)
{
    const struct pbnds_dataset_recipe *r = m->recipe;
    const float aspect = (float)r->width / (float)r->height;
    for (int attempt = 0; attempt < 24; ++attempt) {
        const float yaw = uniform(rng, -180.0f, 180.0f);
        const float pitch = uniform(rng, -10.0f, 55.0f);
        const float fov = uniform(rng, 20.0f, 55.0f);
        const float closer = uniform(rng, 0.45f, 1.05f);
        const struct pbnds_vec3 shift = {uniform(rng, -0.15f, 0.15f),
                                         uniform(rng, -0.15f, 0.15f),
                                         uniform(rng, -0.15f, 0.15f)};
        *camera =
            pbnds_camera_framing(m->scene.lo, m->scene.hi, yaw, pitch, fov, aspect);
        float *eye = &camera->world_from_camera.m[12];
        const struct pbnds_vec3 centre =
            pbnds_scale(pbnds_add(m->scene.lo, m->scene.hi), 0.5f);
        const struct pbnds_vec3 extent = pbnds_sub(m->scene.hi, m->scene.lo);
        const struct pbnds_vec3 away =
            pbnds_sub(pbnds_vec3_make(eye[0], eye[1], eye[2]), centre);
        const struct pbnds_vec3 moved =
            pbnds_add(pbnds_mad(centre, away, closer),
                      pbnds_scale(pbnds_mul(shift, extent), 1.0f));
        eye[0] = moved.x;
        eye[1] = moved.y;
        eye[2] = moved.z;
        if (camera_is_good(m, camera, 32, 32)) return true;
    }
    return false;
}

/* Mean luminance of the light after strength: an ordinary exposure most of the time,
 * with a few dark rooms. Log-uniform. */
static float draw_strength(struct pbnds_rng *rng, float mean_luminance)
{
    const bool dark = pbnds_rng_float(rng) < 0.04f;
    const float ev = uniform(rng, -2.0f, 1.0f) - (dark ? 4.0f : 0.0f);
    return mean_luminance > 1e-8f ? exp2f(ev) / mean_luminance : 1.0f;
}

struct visibility_job {
    const struct pbnds_gbuffer *g;
    const struct pbnds_accel *accel;
    const struct pbnds_env_light *lights;
    int count;
    uint32_t *bits;
};

static uint32_t visible_lights(const struct visibility_job *job, size_t i)
{
    const struct pbnds_gbuffer *g = job->g;
    const struct pbnds_vec3 p = {g->position[0][i], g->position[1][i],
                                 g->position[2][i]};
    const struct pbnds_vec3 ng = {g->geometric_normal[0][i], g->geometric_normal[1][i],
                                  g->geometric_normal[2][i]};
    const struct pbnds_vec3 origin = pbnds_offset_origin(p, ng);
    uint32_t bits = 0;
    for (int k = 0; k < job->count; ++k) {
        const struct pbnds_ray ray = {origin, job->lights[k].wi};
        if (pbnds_dot(ng, ray.direction) > 0.0f &&
            !pbnds_accel_occluded(job->accel, &ray, INFINITY)) {
            bits |= 1u << k;
        }
    }
    return bits;
}

static uint32_t *trace_visibility(const struct visibility_job *job)
{
    const size_t count = (size_t)job->g->width * (size_t)job->g->height;
    uint32_t *bits = calloc(count, sizeof *bits);
    if (!bits) return NULL;
    for (size_t i = 0; i < count; ++i) {
        if (isfinite(job->g->depth[i])) bits[i] = visible_lights(job, i);
    }
    return bits;
}

static enum pbnds_status write_light(const char *folder,
                                     const struct pbnds_image *light,
                                     struct pbnds_error *error)
{
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/light.exr", folder);
    const size_t count = (size_t)light->width * (size_t)light->height;
    float *planes = malloc(3 * count * sizeof *planes);
    if (!planes) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c)
            planes[c * count + i] = light->data[3 * i + c];
    }
    struct pbnds_exr_channel channels[3] = {{"B", PBNDS_EXR_FLOAT, planes + 2 * count},
                                            {"G", PBNDS_EXR_FLOAT, planes + count},
                                            {"R", PBNDS_EXR_FLOAT, planes}};
    const struct pbnds_exr exr = {.width = light->width,
                                  .height = light->height,
                                  .compression = PBNDS_EXR_ZIP,
                                  .channels = channels,
                                  .channel_count = 3};
    const enum pbnds_status status = pbnds_exr_write(path, &exr, error);
    free(planes);
    return status;
}

static enum pbnds_status write_json(const char *folder, const struct draw *d,
                                    const struct pbnds_dataset_recipe *r,
                                    struct pbnds_error *error)
{
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/sample.json", folder);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "id", d->id);
    cJSON_AddStringToObject(json, "split", pbnds_split_name(d->split));
    cJSON_AddStringToObject(json, "asset", d->asset->stem);
    cJSON_AddStringToObject(json, "light", d->env->stem);
    cJSON_AddNumberToObject(json, "yaw_deg", (double)d->yaw_deg);
    cJSON_AddNumberToObject(json, "strength", (double)d->strength);
    cJSON_AddNumberToObject(json, "yfov_deg",
                            (double)(d->camera.yfov * 180.0f / PBNDS_PI));
    cJSON_AddNumberToObject(json, "spp", r->spp);
    cJSON_AddNumberToObject(json, "seed", (double)r->seed);
    char *text = cJSON_Print(json);
    cJSON_Delete(json);
    if (!text) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    const enum pbnds_status status = pbnds_file_write(path, text, strlen(text), error);
    free(text);
    return status;
}

static struct pbnds_exr_channel *target_channels(const struct pbnds_image *direct,
                                                 const uint32_t *visibility,
                                                 float **planes)
{
    const size_t count = (size_t)direct->width * (size_t)direct->height;
    static const char *const NAMES[3] = {"direct.R", "direct.G", "direct.B"};
    struct pbnds_exr_channel *channels = calloc(4, sizeof *channels);
    *planes = malloc(3 * count * sizeof **planes);
    if (!channels || !*planes) {
        free(channels);
        free(*planes);
        *planes = NULL;
        return NULL;
    }
    for (size_t c = 0; c < 3; ++c) {
        (void)snprintf(channels[c].name, sizeof channels[c].name, "%s", NAMES[c]);
        channels[c].type = PBNDS_EXR_FLOAT;
        channels[c].data = *planes + c * count;
        for (size_t i = 0; i < count; ++i) {
            (*planes)[c * count + i] = direct->data[3 * i + c];
        }
    }
    (void)snprintf(channels[3].name, sizeof channels[3].name, "visibility");
    channels[3].type = PBNDS_EXR_UINT;
    channels[3].data = (void *)(uintptr_t)visibility;
    return channels;
}

/* Renders one sample into `folder`, which exists and is empty. */
static enum pbnds_status render_sample(struct maker *m, const struct draw *d,
                                       const struct pbnds_image *light,
                                       const char *folder, struct pbnds_error *error)
{
    const struct pbnds_dataset_recipe *r = m->recipe;
    struct pbnds_envmap *env = NULL;
    struct pbnds_gbuffer g = {0};
    struct pbnds_image radiance = {0}, direct = {0};
    struct pbnds_exr_channel *extra = NULL;
    float *planes = NULL;
    uint32_t *visibility = NULL;
    enum pbnds_status status =
        pbnds_envmap_create(light, PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, error);
    if (status != PBNDS_OK) goto done;
    status = pbnds_gbuffer_raycast(&m->scene, m->accel, &d->camera, r->width, r->height,
                                   NULL, &g, error);
    if (status != PBNDS_OK) goto done;
    const struct pbnds_shade_job job = {
        .gbuffer = &g,
        .envmap = env,
        .scene = &m->scene,
        .accel = m->accel,
        .seed = pbnds_rng_make(r->seed, (uint64_t)d->id, STREAM_TRACE).key,
        .shadows = 1,
    };
    const struct pbnds_pathtrace_options options = {.spp = r->spp};
    status = pbnds_pathtrace(&job, &options, &radiance, &direct, error);
    if (status != PBNDS_OK) goto done;

    struct pbnds_env_light lights[PBNDS_DATASET_LIGHTS];
    const int light_count = pbnds_envmap_cluster(env, PBNDS_DATASET_LIGHTS, lights);
    visibility = trace_visibility(
        &(struct visibility_job){&g, m->accel, lights, light_count, NULL});
    extra = visibility ? target_channels(&direct, visibility, &planes) : NULL;
    if (!extra) {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", folder);
        goto done;
    }
    struct pbnds_gbuffer_origin origin = {
        .env_yaw_deg = d->yaw_deg, .env_strength = d->strength, .seed = r->seed};
    (void)snprintf(origin.env, sizeof origin.env, "%s", d->env->stem);
    (void)snprintf(origin.env_convention, sizeof origin.env_convention, "gltf");
    (void)snprintf(origin.arguments, sizeof origin.arguments,
                   "dataset, sample %d of %s", d->id, d->asset->stem);
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/sample.exr", folder);
    m->writing = true;
    status = pbnds_gbuffer_write(path, &g, &origin, &radiance, extra, 4, PBNDS_EXR_PIZ,
                                 error);
    if (status != PBNDS_OK) goto done;
    status = write_light(folder, light, error);
    if (status != PBNDS_OK) goto done;
    status = write_json(folder, d, r, error);
done:
    free(extra);
    free(planes);
    free(visibility);
    pbnds_image_free(&radiance);
    pbnds_image_free(&direct);
    pbnds_gbuffer_free(&g);
    pbnds_envmap_free(env);
    return status;
}

/* A sample's folder with whatever a kill left in it. */
static void remove_folder(const char *folder)
{
    DIR *dir = opendir(folder);
    if (!dir) return;
    for (struct dirent *entry; (entry = readdir(dir));) {
        char path[4096 + 300];
        (void)snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0) {
            (void)unlink(path);
        }
    }
    (void)closedir(dir);
    (void)rmdir(folder);
}

/* Draws what the sample is; its light map is loaded and baked on the way. */
static enum pbnds_status draw_sample(struct maker *m, struct draw *d,
                                     struct pbnds_image *light,
                                     struct pbnds_error *error)
{
    const struct pbnds_dataset_recipe *r = m->recipe;
    struct pbnds_rng choice = pbnds_rng_make(r->seed, (uint64_t)d->id, STREAM_CHOICE);
    struct pbnds_rng camera = pbnds_rng_make(r->seed, (uint64_t)d->id, STREAM_CAMERA);
    struct pbnds_rng lamp = pbnds_rng_make(r->seed, (uint64_t)d->id, STREAM_LIGHT);
    d->asset = choose(&m->scenes, (int)d->split, pbnds_rng_u64(&choice));
    d->env = choose(&m->envs, (int)d->split, pbnds_rng_u64(&choice));
    PBNDS_TRY(load_scene(m, d->asset, error));
    if (!draw_camera(m, &camera, &d->camera)) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: no camera found that sees enough of it", d->asset->path);
    }
    struct pbnds_envmap *env;
    PBNDS_TRY(pbnds_envmap_load(d->env->path, PBNDS_ENV_GLTF, 0.0f, 1.0f, &env, error));
    const float mean = pbnds_luminance(pbnds_envmap_mean(env));
    pbnds_envmap_free(env);
    d->yaw_deg = uniform(&lamp, 0.0f, 360.0f);
    d->strength = draw_strength(&lamp, mean);
    PBNDS_TRY(pbnds_envmap_load(d->env->path, PBNDS_ENV_GLTF, d->yaw_deg, d->strength,
                                &env, error));
    const enum pbnds_status status = pbnds_envmap_bake(
        env, PBNDS_DATASET_LIGHT_WIDTH, PBNDS_DATASET_LIGHT_WIDTH / 2, light, error);
    pbnds_envmap_free(env);
    return status;
}

/* Makes sample `id` unless it is there: under a temporary name, renamed when whole. */
static enum pbnds_status make_sample(struct maker *m, int id, struct pbnds_error *error)
{
    struct draw d = {.id = id, .split = (enum pbnds_split)split_of_id(m, id)};
    char folder[4096], temp[4096];
    (void)snprintf(folder, sizeof folder, "%s/%s/%06d", m->dir,
                   pbnds_split_name(d.split), id);
    (void)snprintf(temp, sizeof temp, "%s/%s/.tmp-%06d", m->dir,
                   pbnds_split_name(d.split), id);
    struct stat info;
    if (stat(folder, &info) == 0) return PBNDS_OK;
    remove_folder(temp);
    m->writing = true;
    PBNDS_TRY(pbnds_make_folder(temp, error));
    m->writing = false;
    struct pbnds_image light = {0};
    enum pbnds_status status = draw_sample(m, &d, &light, error);
    if (status == PBNDS_OK) status = render_sample(m, &d, &light, temp, error);
    pbnds_image_free(&light);
    if (status == PBNDS_OK && rename(temp, folder) != 0) {
        status = pbnds_fail(error, PBNDS_ERROR_IO, "%s: cannot be written: %s", folder,
                            strerror(errno));
    }
    if (status != PBNDS_OK) remove_folder(temp);
    return status;
}

static cJSON *assets_json(const struct pbnds_asset_list *list)
{
    cJSON *array = cJSON_CreateArray();
    for (int i = 0; i < list->count; ++i) {
        cJSON *item = cJSON_CreateObject();
        char hash[24];
        (void)snprintf(hash, sizeof hash, "%016" PRIx64, list->items[i].hash);
        cJSON_AddStringToObject(item, "name", list->items[i].stem);
        cJSON_AddStringToObject(item, "split", pbnds_split_name(list->items[i].split));
        cJSON_AddStringToObject(item, "xxh64", hash);
        cJSON_AddItemToArray(array, item);
    }
    return array;
}

/* Writes the manifest, or finds that the folder already holds this very recipe. */
static enum pbnds_status claim_folder(const struct maker *m, struct pbnds_error *error)
{
    const struct pbnds_dataset_recipe *r = m->recipe;
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "format", 1);
    cJSON_AddNumberToObject(json, "count", r->count);
    cJSON_AddStringToObject(
        json, "split",
        r->only_split < 0 ? "all" : pbnds_split_name((enum pbnds_split)r->only_split));
    cJSON_AddNumberToObject(json, "width", r->width);
    cJSON_AddNumberToObject(json, "height", r->height);
    cJSON_AddNumberToObject(json, "spp", r->spp);
    cJSON_AddNumberToObject(json, "seed", (double)r->seed);
    cJSON_AddItemToObject(json, "assets", assets_json(&m->scenes));
    cJSON_AddItemToObject(json, "lights", assets_json(&m->envs));
    char *text = cJSON_Print(json);
    cJSON_Delete(json);
    if (!text) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", m->dir);
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/dataset.json", m->dir);
    enum pbnds_status status = PBNDS_OK;
    struct stat info;
    if (stat(path, &info) != 0) {
        status = pbnds_file_write(path, text, strlen(text), error);
    } else {
        uint8_t *old = NULL;
        size_t size = 0;
        status = pbnds_file_read(path, (size_t)1 << 26, &old, &size, error);
        if (status == PBNDS_OK &&
            (size != strlen(text) || memcmp(old, text, size) != 0)) {
            status =
                pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                           "%s: was made by another recipe; give another folder or "
                           "the same options",
                           path);
        }
        free(old);
    }
    free(text);
    return status;
}

static enum pbnds_status check_recipe(const struct maker *m, struct pbnds_error *error)
{
    const struct pbnds_dataset_recipe *r = m->recipe;
    if (r->count < 1 || r->spp < 1 || r->width < 8 || r->height < 8 ||
        r->shard_count < 1 || r->shard < 0 || r->shard >= r->shard_count) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "a data set needs a count, spp and size of at least 1, 1 and 8x8, "
            "and a shard I/N with I < N");
    }
    const int split = r->only_split < 0 ? PBNDS_SPLIT_TRAIN : r->only_split;
    if (!split_is_filled(m, split)) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "no scene or no light map belongs to split %s; put some below a "
            "folder of that name",
            pbnds_split_name((enum pbnds_split)split));
    }
    return PBNDS_OK;
}

/* Makes the shard's samples. One that fails is left out with its reason and the run goes
 * on, unless the data set itself cannot be written (a full disk) or nothing works. */
static enum pbnds_status make_all(struct maker *m, struct pbnds_error *error)
{
    const struct pbnds_dataset_recipe *r = m->recipe;
    int skipped = 0, there = 0;
    struct pbnds_error first = {{0}};
    enum pbnds_status first_status = PBNDS_OK;
    for (int id = r->shard; id < r->count; id += r->shard_count) {
        pbnds_progress(m->report, "dataset", id, r->count);
        struct pbnds_error reason = {{0}};
        m->writing = false;
        const enum pbnds_status made = make_sample(m, id, &reason);
        if (pbnds_stop_requested()) return pbnds_fail_interrupted(error);
        if (made == PBNDS_OK) {
            ++there;
            continue;
        }
        if (made == PBNDS_ERROR_IO && m->writing) {
            if (error) *error = reason;
            return made;
        }
        pbnds_warn(m->report, "sample %d is left out: %s", id, reason.message);
        if (++skipped == 1) {
            first = reason;
            first_status = made;
        }
    }
    pbnds_progress(m->report, "dataset", r->count, r->count);
    if (skipped > 0) pbnds_warn(m->report, "%s: %d samples left out", m->dir, skipped);
    if (skipped > 0 && there == 0) {
        char manifest[4200];
        (void)snprintf(manifest, sizeof manifest, "%s/dataset.json", m->dir);
        (void)unlink(manifest); /* mended assets make another recipe */
        return pbnds_fail(error, first_status, "no sample could be made; the first: %s",
                          first.message);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_dataset_make(const struct pbnds_dataset_recipe *recipe,
                                     const char *dir, const struct pbnds_report *report,
                                     struct pbnds_error *error)
{
    struct maker m = {.recipe = recipe, .dir = dir, .report = report, .loaded = -1};
    enum pbnds_status status = pbnds_assets_find(recipe->scenes, recipe->scene_count,
                                                 SCENE_EXTENSIONS, &m.scenes, error);
    if (status == PBNDS_OK) {
        status = pbnds_assets_find(recipe->envs, recipe->env_count, ENV_EXTENSIONS,
                                   &m.envs, error);
    }
    if (status == PBNDS_OK) status = check_recipe(&m, error);
    if (status == PBNDS_OK) status = pbnds_make_folder(dir, error);
    if (status == PBNDS_OK) status = claim_folder(&m, error);
    if (status == PBNDS_OK) status = make_all(&m, error);
    pbnds_accel_free(m.accel);
    pbnds_scene_free(&m.scene);
    pbnds_assets_free(&m.scenes);
    pbnds_assets_free(&m.envs);
    return status;
}
