#include "neural/data/import_ffhq.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "engine/image/oiio.h"
#include "neural/data/ffhq_layout.h"
#include "neural/data/sample.h"
#include "neural/data/store.h"

enum { WARNINGS_MAX = 100 };

struct importer {
    const char *to;
    const struct pbnds_ffhq_options *options;
    const struct pbnds_report *report;
    struct pbnds_ffhq_result *result;
    struct pbnds_ffhq_layout layout;
    struct pbnds_store *store;
    cJSON *left_out; /* {id, folder, reason} each */
    int done, total; /* pictures that have a split */
};

/* One picture on its way into the data set. */
struct picture {
    const struct pbnds_ffhq_picture *about;
    struct pbnds_ffhq_paths paths;
    struct pbnds_import_options options;
    struct pbnds_gbuffer gbuffer;
    struct pbnds_image photo;
    enum pbnds_target target;
    struct pbnds_import_notes notes;
    struct pbnds_image light;      /* gltf convention */
    int light_width, light_height; /* as they were */
};

/* ------------------------------------------------------------ one picture */

static enum pbnds_status find_fov(const struct importer *m, struct picture *p,
                                  struct pbnds_error *error)
{
    const double degrees = pbnds_picture_list_find(&m->layout.fov, p->about->index);
    if (degrees >= 1.0 && degrees <= 170.0) { /* not NaN */
        p->options.xfov = (float)degrees * PBNDS_PI / 180.0f;
        return PBNDS_OK;
    }
    p->options.yfov = m->options->yfov;
    if (p->options.yfov > 0.0f) return PBNDS_OK;
    return pbnds_fail(
        error, PBNDS_ERROR_FORMAT,
        "%s/pred_fov.json: gives %s no field of view from 1 to 170 degrees",
        m->layout.dir, p->about->id);
}

/* The light as data sets keep it. The convention is an exact roll: half a turn. */
static enum pbnds_status load_light(struct picture *p, struct pbnds_error *error)
{
    const char *path = p->paths.light;
    struct pbnds_image image;
    PBNDS_TRY(pbnds_image_read_rgb(path, &image, error));
    p->light_width = image.width;
    p->light_height = image.height;
    struct pbnds_envmap *envmap = NULL;
    enum pbnds_status status = PBNDS_OK;
    if (image.width != 2 * image.height) {
        status =
            pbnds_fail(error, PBNDS_ERROR_FORMAT,
                       "%s: is %d x %d pixels; a light map is twice as wide as high",
                       path, image.width, image.height);
    }
    if (status == PBNDS_OK) {
        status =
            pbnds_envmap_create(&image, PBNDS_ENV_PBNDS, 0.0f, 1.0f, &envmap, error);
    }
    pbnds_image_free(&image);
    if (status == PBNDS_OK && !(pbnds_luminance(pbnds_envmap_mean(envmap)) > 0.0f)) {
        status = pbnds_fail(error, PBNDS_ERROR_FORMAT,
                            "%s: is black, and the photograph is not", path);
    }
    if (status == PBNDS_OK) {
        const int width = p->light_width < PBNDS_DATASET_LIGHT_WIDTH
                              ? p->light_width
                              : PBNDS_DATASET_LIGHT_WIDTH;
        status = pbnds_envmap_bake(envmap, width, width / 2, &p->light, error);
    }
    pbnds_envmap_free(envmap);
    return status;
}

static bool is_empty(const struct pbnds_gbuffer *g)
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    for (size_t i = 0; i < count; ++i) {
        if (isfinite(g->depth[i])) return false;
    }
    return true;
}

static enum pbnds_status load_picture(const struct importer *m, struct picture *p,
                                      struct pbnds_error *error)
{
    PBNDS_TRY(find_fov(m, p, error));
    PBNDS_TRY(pbnds_ffhq_paths_of(&m->layout, p->about, &p->paths, error));
    PBNDS_TRY(pbnds_import_maps(&p->paths.maps, &p->options, &p->gbuffer, &p->photo,
                                &p->target, &p->notes, error));
    if (is_empty(&p->gbuffer)) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: shows nothing that has a positive depth",
                          p->paths.maps.path[PBNDS_IMPORT_PHOTO]);
    }
    return load_light(p, error);
}

static void free_picture(struct picture *p)
{
    pbnds_gbuffer_free(&p->gbuffer);
    pbnds_image_free(&p->photo);
    pbnds_image_free(&p->light);
    free(p);
}

/* ------------------------------------------------------------ what it says of itself */

static void add_conventions(cJSON *json)
{
    cJSON_AddStringToObject(json, "target", "display");
    cJSON_AddStringToObject(json, "frame", "camera");
    cJSON_AddStringToObject(json, "normal", "camera space, PNG * 2 - 1");
    cJSON_AddStringToObject(json, "light_convention",
                            "pbnds, rolled by half a turn into gltf");
    cJSON_AddStringToObject(json, "fov", "horizontal in the source, vertical here");
    cJSON_AddStringToObject(json, "specular",
                            "reflectance at normal incidence, as given");
    cJSON_AddStringToObject(json, "metallic", "no map: 0");
}

static const char *depth_kind(const struct picture *p)
{
    if (!p->paths.maps.path[PBNDS_IMPORT_DEPTH][0]) return "missing: 1 everywhere";
    const struct pbnds_gbuffer *g = &p->gbuffer;
    const size_t count = (size_t)g->width * (size_t)g->height;
    float lo = INFINITY, hi = 0.0f;
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(g->depth[i])) continue;
        lo = fminf(lo, g->depth[i]);
        hi = fmaxf(hi, g->depth[i]);
    }
    return lo == hi ? "constant" : "as given, of unknown scale";
}

static cJSON *sample_json(const struct picture *p)
{
    const double degrees = 180.0 / (double)PBNDS_PI;
    char light[80];
    (void)snprintf(light, sizeof light, "hdri_%s", p->about->id);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "id", p->about->number);
    cJSON_AddStringToObject(json, "split",
                            pbnds_split_name((enum pbnds_split)p->about->split));
    cJSON_AddStringToObject(json, "asset", p->about->id);
    cJSON_AddStringToObject(json, "folder", p->about->folder);
    cJSON_AddStringToObject(json, "light", light);
    cJSON_AddNumberToObject(json, "yaw_deg", 0.0);
    cJSON_AddNumberToObject(json, "strength", 1.0);
    cJSON_AddNumberToObject(json, "yfov_deg", (double)p->gbuffer.camera.yfov * degrees);
    if (p->options.xfov > 0.0f)
        cJSON_AddNumberToObject(json, "xfov_deg", (double)p->options.xfov * degrees);
    cJSON_AddNumberToObject(json, "light_width", p->light_width);
    cJSON_AddNumberToObject(json, "light_height", p->light_height);
    cJSON_AddStringToObject(json, "depth", depth_kind(p));
    add_conventions(json);
    cJSON *notes = cJSON_AddArrayToObject(json, "notes");
    for (int i = 0; i < p->notes.count; ++i)
        cJSON_AddItemToArray(notes, cJSON_CreateString(p->notes.text[i]));
    return json;
}

/* The name of the folder given, without those above it. */
static void base_name(const char *dir, char *name, size_t size)
{
    size_t end = strlen(dir);
    while (end > 1 && dir[end - 1] == '/')
        --end;
    size_t begin = end;
    while (begin > 0 && dir[begin - 1] != '/')
        --begin;
    (void)snprintf(name, size, "%.*s", (int)(end - begin), dir + begin);
}

static cJSON *claim_json(const struct importer *m,
                         const struct pbnds_dataset_recipe *recipe)
{
    char name[256], hash[24];
    base_name(m->layout.dir, name, sizeof name);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "format", 2);
    cJSON_AddStringToObject(json, "kind", "import ffhq-pbr");
    if (recipe->format == PBNDS_DATASET_TAR)
        cJSON_AddNumberToObject(json, "per_tar", recipe->per_tar);
    cJSON_AddStringToObject(json, "source", name);
    (void)snprintf(hash, sizeof hash, "%016" PRIx64, m->layout.hash);
    cJSON *pictures = cJSON_AddObjectToObject(json, "count");
    for (int k = 0; k < PBNDS_SPLIT_COUNT; ++k)
        cJSON_AddNumberToObject(pictures, pbnds_split_name((enum pbnds_split)k),
                                m->layout.split_count[k]);
    cJSON_AddStringToObject(json, "pictures_xxh64", hash);
    cJSON_AddStringToObject(json, "splits",
                            m->layout.has_splits
                                ? "train.txt, val.txt, test.txt"
                                : "80 / 10 / 10 by the hash of the ID");
    cJSON_AddStringToObject(json, "identities",
                            "unknown: one person may be in two splits");
    cJSON_AddStringToObject(json, "direct", "absent");
    cJSON_AddStringToObject(json, "visibility", "absent");
    add_conventions(json);
    return json;
}

/* ------------------------------------------------------------ into the data set */

static enum pbnds_status write_picture(const struct picture *p, const char *folder,
                                       struct pbnds_error *error)
{
    struct pbnds_gbuffer_origin origin = {.env_strength = 1.0f, .target = p->target};
    (void)snprintf(origin.env, sizeof origin.env, "hdri_%s", p->about->id);
    (void)snprintf(origin.env_convention, sizeof origin.env_convention, "gltf");
    (void)snprintf(origin.arguments, sizeof origin.arguments,
                   "import ffhq-pbr, picture %s", p->about->id);
    cJSON *json = sample_json(p);
    const struct pbnds_sample_parts parts = {.gbuffer = &p->gbuffer,
                                             .origin = &origin,
                                             .radiance = &p->photo,
                                             .light = &p->light,
                                             .json = json};
    const enum pbnds_status status = pbnds_sample_write_parts(folder, &parts, error);
    cJSON_Delete(json);
    return status;
}

static void leave_out(struct importer *m, const struct pbnds_ffhq_picture *about,
                      const char *reason)
{
    const int number = m->result->left_out++;
    cJSON *item = cJSON_CreateObject();
    cJSON_AddStringToObject(item, "id", about->id);
    cJSON_AddStringToObject(item, "folder", about->folder);
    cJSON_AddStringToObject(item, "reason", reason);
    cJSON_AddItemToArray(m->left_out, item);
    if (number < WARNINGS_MAX)
        pbnds_warn(m->report, "picture %s is left out: %s", about->id, reason);
    if (number == WARNINGS_MAX)
        pbnds_warn(m->report, "more are left out; %s/import.json lists all", m->to);
}

/* Pictures that belong to no split. */
static void leave_out_strangers(struct importer *m)
{
    for (int i = 0; i < m->layout.count; ++i) {
        const struct pbnds_ffhq_picture *p = &m->layout.pictures[i];
        if (p->index < 0) {
            leave_out(m, p, "its name is no number, or that of another picture");
        } else if (p->split < 0) {
            leave_out(m, p, "it is in none of train.txt, val.txt and test.txt");
        }
    }
}

/* Errors are those of writing: a full disk, on which the next one would not fit either. A
 * picture that cannot be read is quarantined, and tried again by the next run. */
static enum pbnds_status import_picture(struct importer *m,
                                        const struct pbnds_ffhq_picture *about,
                                        struct pbnds_error *error)
{
    struct picture *p = calloc(1, sizeof *p);
    if (!p) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", about->id);
    p->about = about;
    const char *folder;
    struct pbnds_error reason = {{0}};
    enum pbnds_status status =
        pbnds_store_begin(m->store, about->number, &folder, error);
    if (status == PBNDS_OK && load_picture(m, p, &reason) == PBNDS_OK) {
        const bool sync = pbnds_file_set_sync(false); /* commit does it, once */
        status = write_picture(p, folder, error);
        if (status == PBNDS_OK) status = pbnds_store_commit(m->store, error);
        (void)pbnds_file_set_sync(sync);
        if (status == PBNDS_OK) ++m->result->count[about->split];
    } else if (status == PBNDS_OK && pbnds_stop_requested()) {
        status = pbnds_fail_interrupted(error); /* which may be all that went wrong */
    } else if (status == PBNDS_OK) {
        leave_out(m, about, reason.message);
        status = pbnds_store_quarantine(m->store, reason.message, error);
    }
    if (status != PBNDS_OK) pbnds_store_abort(m->store);
    free_picture(p);
    return status;
}

static enum pbnds_status import_unit(struct importer *m, int number,
                                     struct pbnds_error *error)
{
    const struct pbnds_store_unit unit = pbnds_store_unit(m->store, number);
    bool busy;
    PBNDS_TRY(pbnds_store_enter(m->store, number, &busy, error));
    if (busy) return PBNDS_OK; /* another process imports the same */
    enum pbnds_status status = PBNDS_OK;
    for (int i = unit.first; i < unit.end && status == PBNDS_OK; ++i, ++m->done) {
        const struct pbnds_ffhq_picture *about = m->layout.in_split[unit.split][i];
        pbnds_progress(m->report, "import", m->done, m->total);
        if (pbnds_stop_requested()) {
            status = pbnds_fail_interrupted(error);
        } else if (pbnds_store_state(m->store, i) == PBNDS_STORE_THERE) {
            ++m->result->count[unit.split];
        } else {
            status = import_picture(m, about, error);
        }
    }
    const enum pbnds_status left =
        pbnds_store_leave(m->store, status == PBNDS_OK ? error : NULL);
    return status == PBNDS_OK ? left : status;
}

static int imported(const struct importer *m)
{
    int count = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        count += m->result->count[s];
    return count;
}

static enum pbnds_status write_report(const struct importer *m,
                                      struct pbnds_error *error)
{
    char path[4200];
    (void)snprintf(path, sizeof path, "%s/import.json", m->to);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "source", m->layout.dir);
    cJSON_AddNumberToObject(json, "pictures", m->layout.count);
    cJSON_AddNumberToObject(json, "imported", imported(m));
    cJSON_AddItemReferenceToObject(json, "left_out", m->left_out);
    char *text = cJSON_Print(json);
    cJSON_Delete(json);
    if (!text) return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", path);
    const enum pbnds_status status = pbnds_file_write(path, text, strlen(text), error);
    free(text);
    return status;
}

static enum pbnds_status import_all(struct importer *m, struct pbnds_error *error)
{
    const int units = pbnds_store_units(m->store);
    enum pbnds_status status = PBNDS_OK;
    leave_out_strangers(m);
    for (int n = 0; n < units && status == PBNDS_OK; ++n)
        status = import_unit(m, n, error);
    if (status == PBNDS_OK) pbnds_progress(m->report, "import", m->total, m->total);
    /* A run that was stopped tells what it left out so far, too. */
    const enum pbnds_status told = write_report(m, status == PBNDS_OK ? error : NULL);
    if (status != PBNDS_OK) return status;
    PBNDS_TRY(told);
    bool complete;
    if (imported(m) > 0) return pbnds_store_finish(m->store, &complete, error);
    pbnds_store_abandon(m->store);
    const cJSON *first = m->left_out->child;
    const cJSON *reason = first ? cJSON_GetObjectItem(first, "reason") : NULL;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: no picture could be imported; %s%s", m->layout.dir,
                      reason ? "the first: " : "there is no .png in bgremoval/",
                      reason ? reason->valuestring : "");
}

static enum pbnds_status open_store(struct importer *m, struct pbnds_error *error)
{
    struct pbnds_dataset_recipe recipe;
    pbnds_dataset_recipe_init(&recipe);
    recipe.format = m->options->format;
    if (m->options->per_tar > 0) recipe.per_tar = m->options->per_tar;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        m->total += m->layout.split_count[s];
    cJSON *claim = claim_json(m, &recipe);
    m->left_out = cJSON_CreateArray();
    const enum pbnds_status status =
        claim && m->left_out
            ? pbnds_store_open(m->to, &recipe, m->layout.split_count, claim, &m->store,
                               error)
            : pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", m->to);
    cJSON_Delete(claim);
    return status;
}

enum pbnds_status pbnds_import_ffhq(const char *from, const char *to,
                                    const struct pbnds_ffhq_options *options,
                                    const struct pbnds_report *report,
                                    struct pbnds_ffhq_result *result,
                                    struct pbnds_error *error)
{
    *result = (struct pbnds_ffhq_result){.left_out = 0};
    struct importer m = {
        .to = to, .options = options, .report = report, .result = result};
    PBNDS_TRY(pbnds_ffhq_layout_read(from, &m.layout, error));
    enum pbnds_status status = open_store(&m, error);
    if (status == PBNDS_OK) status = import_all(&m, error);
    pbnds_store_free(m.store);
    cJSON_Delete(m.left_out);
    pbnds_ffhq_layout_free(&m.layout);
    return status;
}
