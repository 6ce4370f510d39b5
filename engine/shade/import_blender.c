/* Blender's multilayer files; what is taken from where is in import.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/shade/gbuffer_planes.h"
#include "engine/shade/import.h"

#define DEPTH_NOTHING 1e10f

/* The planes of one view layer; NULL where it lacks the pass. */
struct passes {
    char layer[64];
    const float *depth, *normal[3], *position[3];
    const float *diffuse[3], *gloss[3], *albedo[3], *emit[3], *combined[3], *alpha;
    const float *roughness, *metallic, *specular, *object, *material;
};

/* A file while it is read. */
struct job {
    const char *path;
    const struct pbnds_exr *exr;
    const struct pbnds_import_options *options;
    struct pbnds_gbuffer *gbuffer;
    struct pbnds_import_notes *notes;
    struct passes from;
};

/* "Layer.Pass.X" without ".Pass.X": the length of the layer's name, or 0. */
static size_t layer_length(const char *name)
{
    int dots = 0;
    for (size_t i = strlen(name); i > 0; --i) {
        if (name[i - 1] == '.' && ++dots == 2) return i - 1;
    }
    return 0;
}

static const float *find(const struct pbnds_exr *exr, const char *layer,
                         const char *pass, char part)
{
    for (int i = 0; i < exr->channel_count; ++i) {
        const struct pbnds_exr_channel *c = &exr->channels[i];
        const size_t n = layer_length(c->name), m = strlen(pass);
        if (n == 0 || strlen(layer) != n || strncmp(c->name, layer, n) != 0) continue;
        const char *rest = c->name + n + 1;
        if (strncmp(rest, pass, m) != 0 || rest[m] != '.' || rest[m + 1] != part ||
            rest[m + 2] != 0 || c->type == PBNDS_EXR_UINT)
            continue;
        return c->data;
    }
    return NULL;
}

/* Values are called X, V or Z, by version and pass. */
static const float *find_value(const struct pbnds_exr *exr, const char *layer,
                               const char *pass)
{
    static const char parts[] = {'X', 'V', 'Z', 'R', 'A'};
    for (size_t i = 0; i < sizeof parts; ++i) {
        const float *plane = find(exr, layer, pass, parts[i]);
        if (plane) return plane;
    }
    return NULL;
}

static void find_triple(const struct pbnds_exr *exr, const char *layer,
                        const char *pass, const char *parts, const float *planes[3])
{
    bool all = true;
    for (int c = 0; c < 3; ++c) {
        planes[c] = find(exr, layer, pass, parts[c]);
        all = all && planes[c];
    }
    if (!all) planes[0] = planes[1] = planes[2] = NULL;
}

static struct passes find_passes(const struct pbnds_exr *exr, const char *layer)
{
    struct passes p;
    memset(&p, 0, sizeof p);
    snprintf(p.layer, sizeof p.layer, "%.63s", layer);
    p.depth = find_value(exr, layer, "Depth");
    find_triple(exr, layer, "Normal", "XYZ", p.normal);
    find_triple(exr, layer, "Position", "XYZ", p.position);
    find_triple(exr, layer, "DiffCol", "RGB", p.diffuse);
    find_triple(exr, layer, "GlossCol", "RGB", p.gloss);
    find_triple(exr, layer, "albedo", "RGB", p.albedo);
    find_triple(exr, layer, "Emit", "RGB", p.emit);
    find_triple(exr, layer, "Combined", "RGB", p.combined);
    p.alpha = find(exr, layer, "Combined", 'A');
    p.roughness = find_value(exr, layer, "roughness");
    p.metallic = find_value(exr, layer, "metallic");
    p.specular = find_value(exr, layer, "specular");
    p.object = find_value(exr, layer, "IndexOB");
    p.material = find_value(exr, layer, "IndexMA");
    return p;
}

static bool is_complete(const struct passes *p)
{
    return p->depth && p->normal[0] && (p->diffuse[0] || p->albedo[0]);
}

/* The first view layer that has what is needed; failing that, a sentence about the first
 * that has anything of it. */
static enum pbnds_status pick_layer(struct job *job, struct pbnds_error *error)
{
    struct passes most;
    memset(&most, 0, sizeof most);
    for (int i = 0; i < job->exr->channel_count; ++i) {
        const char *name = job->exr->channels[i].name;
        char layer[64];
        snprintf(layer, sizeof layer, "%.*s", (int)layer_length(name), name);
        if (!layer[0] || strcmp(layer, job->from.layer) == 0) continue;
        job->from = find_passes(job->exr, layer);
        if (is_complete(&job->from)) return PBNDS_OK;
        if (!most.layer[0] && (job->from.depth || job->from.normal[0] ||
                               job->from.diffuse[0] || job->from.combined[0]))
            most = job->from;
    }
    if (!most.layer[0]) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: has no view layer of Blender's; save it as OpenEXR "
                          "MultiLayer",
                          job->path);
    }
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: the view layer %s has no pass%s%s%s; switch on what is "
                      "missing (View Layer Properties, Passes) and render again",
                      job->path, most.layer, most.depth ? "" : " Z",
                      most.normal[0] ? "" : " Normal",
                      most.diffuse[0] || most.albedo[0] ? "" : " Diffuse Color");
}

static struct pbnds_vec3 at(const float *const planes[3], size_t i)
{
    return pbnds_vec3_make(planes[0][i], planes[1][i], planes[2][i]);
}

static void store(float *const planes[3], size_t i, struct pbnds_vec3 v)
{
    planes[0][i] = v.x;
    planes[1][i] = v.y;
    planes[2][i] = v.z;
}

static bool finite3(struct pbnds_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* Blender's axes in ours. */
static struct pbnds_vec3 y_up(struct pbnds_vec3 v)
{
    return pbnds_vec3_make(v.x, v.z, -v.y);
}

static float coverage_of(const struct passes *p, size_t i)
{
    const float alpha = p->alpha ? pbnds_clamp(p->alpha[i], 0.0f, 1.0f) : 1.0f;
    return p->depth[i] < DEPTH_NOTHING && alpha > 0.0f ? alpha : 0.0f;
}

static enum pbnds_status check_values(const struct job *job, struct pbnds_error *error)
{
    const struct passes *p = &job->from;
    const size_t width = (size_t)job->exr->width;
    const size_t count = width * (size_t)job->exr->height;
    const float *const *color = p->albedo[0] ? p->albedo : p->diffuse;
    for (size_t i = 0; i < count; ++i) {
        const char *wrong = NULL;
        if (isnan(p->depth[i]) || p->depth[i] < 0.0f) wrong = "Depth";
        const bool hit = coverage_of(p, i) > 0.0f;
        if (hit && !finite3(at(p->normal, i))) wrong = "Normal";
        if (hit && !finite3(at(color, i))) wrong = "the colour pass";
        if (hit && p->emit[0] && !finite3(at(p->emit, i))) wrong = "Emit";
        if (hit && p->combined[0] && !finite3(at(p->combined, i))) wrong = "Combined";
        if (!wrong) continue;
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: %s is negative, NaN or infinite at pixel (%zu, %zu); "
                          "render it again",
                          job->path, wrong, i % width, i / width);
    }
    return PBNDS_OK;
}

/* The camera that the Position pass shows. */
static enum pbnds_status fit_camera(struct job *job, struct pbnds_camera *camera,
                                    bool *found, struct pbnds_error *error)
{
    const struct passes *p = &job->from;
    const size_t count = (size_t)job->exr->width * (size_t)job->exr->height;
    float *block = malloc((4 * count + 1) * sizeof *block), off = 0.0f;
    if (!block) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its camera",
                          job->path);
    }
    float *const planes[3] = {block, block + count, block + 2 * count};
    float *depth = block + 3 * count;
    for (size_t i = 0; i < count; ++i) {
        store(planes, i, y_up(at(p->position, i)));
        depth[i] = coverage_of(p, i) == 1.0f ? p->depth[i] : INFINITY;
    }
    const float *const positions[3] = {planes[0], planes[1], planes[2]};
    const enum pbnds_camera_fit fit = pbnds_import_fit_camera(
        positions, depth, job->exr->width, job->exr->height, camera, &off);
    free(block);
    *found = fit == PBNDS_FIT_DONE;
    if (fit == PBNDS_FIT_SKEWED) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: its positions are not those of a camera with square "
                          "pixels and a centred lens; render with aspect 1:1 and no "
                          "shift, or leave out the Position pass",
                          job->path);
    }
    if (*found && camera->orthographic) {
        pbnds_import_note(job->notes,
                          "camera: from the Position pass, orthographic, %.4g m high "
                          "(%.2f pixels off)",
                          2.0 * (double)camera->ymag, (double)off);
    } else if (*found) {
        pbnds_import_note(job->notes,
                          "camera: from the Position pass, %.2f degrees vertically "
                          "(%.2f pixels off)",
                          (double)(camera->yfov * 180.0f / PBNDS_PI), (double)off);
    }
    return PBNDS_OK;
}

static enum pbnds_status choose_camera(struct job *job, struct pbnds_camera *camera,
                                       struct pbnds_error *error)
{
    bool found = false;
    *camera = pbnds_import_camera(job->options);
    if (job->from.position[0]) PBNDS_TRY(fit_camera(job, camera, &found, error));
    if (!found) {
        pbnds_import_note(
            job->notes,
            "camera: at the origin, %s, %.2f degrees vertically: the file "
            "has no Position pass to find it by",
            job->options->look_given ? "looks as it was told"
                                     : "looks along Blender's +y",
            (double)(camera->yfov * 180.0f / PBNDS_PI));
    }
    return PBNDS_OK;
}

static struct pbnds_vec3 unit_color(struct pbnds_vec3 v)
{
    return pbnds_vec3_make(pbnds_clamp(v.x, 0.0f, 1.0f), pbnds_clamp(v.y, 0.0f, 1.0f),
                           pbnds_clamp(v.z, 0.0f, 1.0f));
}

/* A mean of samples of which `share` hit something, over those. */
static float mean(const float *plane, size_t i, float share, float otherwise)
{
    return plane ? pbnds_clamp(plane[i] / share, 0.0f, 1.0f) : otherwise;
}

/* The AOV; else what DiffCol, base colour x (1 - metallic), was made of; of pure metal
 * GlossCol. */
static struct pbnds_vec3 base_color(const struct passes *p, size_t i, float share,
                                    float metallic)
{
    if (p->albedo[0]) return unit_color(pbnds_scale(at(p->albedo, i), 1.0f / share));
    const float diffuse = 1.0f - metallic;
    if (diffuse > 0.01f || !p->gloss[0] || !finite3(at(p->gloss, i)))
        return unit_color(
            pbnds_scale(at(p->diffuse, i), 1.0f / (share * fmaxf(diffuse, 0.01f))));
    return unit_color(pbnds_scale(at(p->gloss, i), 1.0f / share));
}

static void read_material(const struct job *job, size_t i, float share)
{
    const struct passes *p = &job->from;
    struct pbnds_gbuffer *g = job->gbuffer;
    const float metallic = mean(p->metallic, i, share, 0.0f);
    const struct pbnds_vec3 color = base_color(p, i, share, metallic);
    store(g->albedo, i, color);
    g->metallic[i] = metallic;
    g->roughness[i] = mean(p->roughness, i, share, 0.5f);
    g->specular[i] =
        mean(p->specular, i, share,
             0.04f * (1.0f - metallic) + metallic * pbnds_luminance(color));
    if (p->emit[0]) {
        const struct pbnds_vec3 e = pbnds_scale(at(p->emit, i), 1.0f / share);
        store(g->emission, i,
              pbnds_vec3_make(pbnds_clamp(e.x, 0.0f, 1e20f),
                              pbnds_clamp(e.y, 0.0f, 1e20f),
                              pbnds_clamp(e.z, 0.0f, 1e20f)));
    }
}

static uint32_t index_of(const float *plane, size_t i)
{
    const float value = plane ? plane[i] : 0.0f;
    return value > 0.0f && value < 4e9f ? (uint32_t)(value + 0.5f) : 0;
}

static void read_pixel(const struct job *job, const struct pbnds_camera_view *view,
                       int x, int y)
{
    const struct passes *p = &job->from;
    struct pbnds_gbuffer *g = job->gbuffer;
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    const float share = coverage_of(p, i);
    if (share == 0.0f || !(p->depth[i] > 0.0f)) {
        g->depth[i] = INFINITY;
        g->object_id[i] = UINT32_MAX;
        if (g->material_id) g->material_id[i] = UINT32_MAX;
        return;
    }
    const struct pbnds_ray ray =
        pbnds_camera_view_ray(view, (float)x + 0.5f, (float)y + 0.5f);
    const struct pbnds_vec3 wo = pbnds_scale(ray.direction, -1.0f);
    struct pbnds_vec3 n = y_up(at(p->normal, i));
    const float square = pbnds_dot(n, n);
    n = square > 1e-12f && square < 1e30f ? pbnds_scale(n, 1.0f / sqrtf(square)) : wo;
    n = pbnds_face_eye(n, wo);
    store(g->normal, i, n);
    store(g->geometric_normal, i, n);
    read_material(job, i, share);
    g->coverage[i] = share;
    g->depth[i] = p->depth[i];
    const float t = p->depth[i] / pbnds_dot(ray.direction, view->forward);
    store(g->position, i, pbnds_mad(ray.origin, ray.direction, t));
    g->object_id[i] = index_of(p->object, i);
    if (g->material_id) g->material_id[i] = index_of(p->material, i);
}

static void note_sources(struct job *job)
{
    const struct passes *p = &job->from;
    struct pbnds_import_notes *n = job->notes;
    pbnds_import_note(n, "view layer: %s", p->layer);
    if (p->albedo[0]) {
        pbnds_import_note(n, "albedo: from the AOV of that name");
    } else {
        pbnds_import_note(n, "albedo: from DiffCol%s; there is no AOV of that name",
                          !p->metallic ? " (black where metal is)"
                          : p->gloss[0]
                              ? ", of metal from GlossCol (white in Blender 3)"
                              : " (black where metal is)");
    }
    pbnds_import_note(n, "roughness: %s",
                      p->roughness ? "from the AOV of that name"
                                   : "0.5 everywhere, there is no AOV of that name");
    pbnds_import_note(n, "metallic: %s",
                      p->metallic ? "from the AOV of that name"
                                  : "0 everywhere, there is no AOV of that name");
    pbnds_import_note(n, "specular: %s",
                      p->specular ? "from the AOV of that name"
                                  : "0.04, albedo where metallic; there is no AOV of "
                                    "that name");
    if (!p->alpha)
        pbnds_import_note(n,
                          "coverage: 1 where there is depth, there is no Combined.A");
    if (!p->emit[0]) pbnds_import_note(n, "emission: 0, there is no Emit pass");
    if (!p->object) pbnds_import_note(n, "object_id: 0, there is no IndexOB pass");
}

static enum pbnds_status read_radiance(const struct job *job,
                                       struct pbnds_image *radiance,
                                       struct pbnds_error *error)
{
    const struct passes *p = &job->from;
    if (!radiance || !p->combined[0]) return PBNDS_OK;
    PBNDS_TRY(pbnds_image_init(radiance, job->exr->width, job->exr->height, 3, error));
    const size_t count = (size_t)job->exr->width * (size_t)job->exr->height;
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            const float value = p->combined[c][i];
            radiance->data[3 * i + c] = isfinite(value) ? value : 0.0f;
        }
    }
    return PBNDS_OK;
}

static enum pbnds_status read_passes(struct job *job, struct pbnds_image *radiance,
                                     struct pbnds_error *error)
{
    PBNDS_TRY(pick_layer(job, error));
    PBNDS_TRY(check_values(job, error));
    struct pbnds_camera camera;
    note_sources(job);
    PBNDS_TRY(choose_camera(job, &camera, error));
    const int width = job->exr->width, height = job->exr->height;
    PBNDS_TRY(pbnds_gbuffer_allocate(
        job->gbuffer, width, height,
        job->from.material ? PBNDS_OPTIONAL_MATERIAL_ID : 0u, false, error));
    job->gbuffer->camera = camera;
    const struct pbnds_camera_view view = pbnds_camera_view(&camera, width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x)
            read_pixel(job, &view, x, y);
    }
    return read_radiance(job, radiance, error);
}

enum pbnds_status
pbnds_import_blender(const char *path, const struct pbnds_import_options *options,
                     struct pbnds_gbuffer *gbuffer, struct pbnds_image *radiance,
                     struct pbnds_import_notes *notes, struct pbnds_error *error)
{
    memset(gbuffer, 0, sizeof *gbuffer);
    memset(notes, 0, sizeof *notes);
    if (radiance) memset(radiance, 0, sizeof *radiance);
    struct pbnds_exr exr;
    PBNDS_TRY(pbnds_exr_read(path, &exr, error));
    struct job job = {.path = path,
                      .exr = &exr,
                      .options = options,
                      .gbuffer = gbuffer,
                      .notes = notes};
    const enum pbnds_status status = read_passes(&job, radiance, error);
    pbnds_exr_free(&exr);
    if (status != PBNDS_OK) {
        pbnds_gbuffer_free(gbuffer);
        if (radiance) pbnds_image_free(radiance);
    }
    return status;
}
