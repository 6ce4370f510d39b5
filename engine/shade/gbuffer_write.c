/* G-buffers into OpenEXR files. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/image/half.h"
#include "engine/shade/cryptomatte.h"
#include "engine/shade/gbuffer_channels.h"
#include "engine/shade/gbuffer_header.h"

enum { MATTES = 2 * PBNDS_CRYPTOMATTE_LAYERS * PBNDS_CRYPTOMATTE_RANKS, RADIANCE = 4 };

/* A file while it is written. */
struct writing {
    const char *path;
    const struct pbnds_gbuffer *gbuffer;
    const struct pbnds_gbuffer_origin *origin;
    const struct pbnds_image *radiance;
    struct pbnds_exr_channel *channels;
    int channel_count;
    /* What the file holds in another form than memory; NULL: in the same. */
    float *normal[3], *depth, *color[3];
};

static void add_channel(struct writing *w, const char *name, enum pbnds_exr_type type,
                        void *data)
{
    struct pbnds_exr_channel *c = &w->channels[w->channel_count++];
    snprintf(c->name, sizeof c->name, "%s", name);
    c->type = type;
    c->data = data;
}

static void normals_to_camera(const struct writing *w)
{
    const struct pbnds_gbuffer *g = w->gbuffer;
    const size_t count = (size_t)g->width * (size_t)g->height;
    for (size_t i = 0; i < count; ++i) {
        const struct pbnds_vec3 n = pbnds_camera_from_world_vector(
            &g->camera,
            pbnds_vec3_make(g->normal[0][i], g->normal[1][i], g->normal[2][i]));
        w->normal[0][i] = n.x;
        w->normal[1][i] = n.y;
        w->normal[2][i] = n.z;
    }
}

/* Along the ray through the pixel's centre; an orthographic ray is the view axis. */
static void depth_to_distance(const struct writing *w)
{
    const struct pbnds_gbuffer *g = w->gbuffer;
    const struct pbnds_camera_view view =
        pbnds_camera_view(&g->camera, g->width, g->height);
    for (int y = 0; y < g->height; ++y) {
        for (int x = 0; x < g->width; ++x) {
            const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
            const struct pbnds_ray ray =
                pbnds_camera_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
            w->depth[i] = g->depth[i] / pbnds_dot(ray.direction, view.forward);
        }
    }
}

static void split_radiance(const struct writing *w)
{
    const size_t count = (size_t)w->gbuffer->width * (size_t)w->gbuffer->height;
    for (size_t i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c)
            w->color[c][i] = w->radiance->data[3 * i + c];
    }
}

/* The planes that are made for the file, all in one block, the caller's to free. */
static enum pbnds_status convert(struct writing *w, float **block,
                                 struct pbnds_error *error)
{
    const struct pbnds_gbuffer *g = w->gbuffer;
    const bool camera = !w->origin || w->origin->normal_space == PBNDS_NORMAL_CAMERA;
    const bool distance = w->origin && w->origin->depth == PBNDS_DEPTH_DISTANCE;
    const size_t count = (size_t)g->width * (size_t)g->height;
    const size_t planes =
        (camera ? 3u : 0u) + (distance ? 1u : 0u) + (w->radiance ? 3u : 0u);
    float *at = malloc((planes * count + 1) * sizeof *at);
    *block = at;
    if (!at) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "%s: out of memory while writing %d x %d pixels", w->path,
                          g->width, g->height);
    }
    for (int c = 0; c < 3 && camera; ++c, at += count)
        w->normal[c] = at;
    for (int c = 0; c < 3 && w->radiance; ++c, at += count)
        w->color[c] = at;
    if (distance) w->depth = at;
    if (camera) normals_to_camera(w);
    if (distance) depth_to_distance(w);
    if (w->radiance) split_radiance(w);
    return PBNDS_OK;
}

/* Half holds up to 65504; one value beyond makes the whole layer float. */
static bool light_fits_half(const struct pbnds_gbuffer *g)
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    for (int c = 0; c < 3; ++c) {
        for (size_t i = 0; i < count; ++i) {
            if (!(fabsf(g->emission[c][i]) <= PBNDS_HALF_MAX)) return false;
        }
    }
    return true;
}

/* The plane that goes into the file in place of one in memory. */
static float *converted(const struct writing *w, const float *plane)
{
    for (int c = 0; c < 3; ++c) {
        if (plane == w->gbuffer->normal[c]) return w->normal[c];
    }
    return plane == w->gbuffer->depth ? w->depth : NULL;
}

static void list_contract(struct writing *w)
{
    const bool fits = light_fits_half(w->gbuffer);
    for (int i = 0; i < pbnds_gbuffer_channel_count(); ++i) {
        const struct pbnds_gbuffer_channel *c = pbnds_gbuffer_channel_at(i);
        if (c->kind == PBNDS_CHANNEL_ID) {
            uint32_t *id = pbnds_gbuffer_id(w->gbuffer, c);
            if (id) add_channel(w, c->name, c->type, id);
            continue;
        }
        float *plane = pbnds_gbuffer_real(w->gbuffer, c);
        if (!plane) continue;
        float *other = converted(w, plane);
        const bool grows = c->kind == PBNDS_CHANNEL_LIGHT && !fits;
        add_channel(w, c->name, grows ? PBNDS_EXR_FLOAT : c->type,
                    other ? other : plane);
    }
}

/* A shader may have found a coverage of its own. */
static void list_radiance(struct writing *w, const struct pbnds_exr_channel *extra,
                          int extra_count)
{
    if (!w->radiance) return;
    add_channel(w, "R", PBNDS_EXR_FLOAT, w->color[0]);
    add_channel(w, "G", PBNDS_EXR_FLOAT, w->color[1]);
    add_channel(w, "B", PBNDS_EXR_FLOAT, w->color[2]);
    for (int i = 0; i < extra_count; ++i)
        if (strcmp(extra[i].name, "A") == 0) return;
    add_channel(w, "A", PBNDS_EXR_HALF, w->gbuffer->coverage);
}

static void list_mattes(struct writing *w)
{
    const struct pbnds_cryptomatte *mattes = w->gbuffer->cryptomatte;
    for (int l = 0; mattes && l < PBNDS_CRYPTOMATTE_LAYERS; ++l) {
        const struct pbnds_cryptomatte_layer *layer = &mattes->layers[l];
        for (int r = 0; r < PBNDS_CRYPTOMATTE_RANKS; ++r) {
            char name[64];
            snprintf(name, sizeof name, "%s%02d.%c", layer->name, r / 2,
                     r % 2 ? 'B' : 'R');
            add_channel(w, name, PBNDS_EXR_FLOAT, layer->id[r]);
            snprintf(name, sizeof name, "%s%02d.%c", layer->name, r / 2,
                     r % 2 ? 'A' : 'G');
            add_channel(w, name, PBNDS_EXR_FLOAT, layer->share[r]);
        }
    }
}

static enum pbnds_status add_extra(struct writing *w,
                                   const struct pbnds_exr_channel *extra,
                                   int extra_count, struct pbnds_error *error)
{
    for (int i = 0; i < extra_count; ++i) {
        for (int k = 0; k < w->channel_count; ++k) {
            if (strcmp(w->channels[k].name, extra[i].name) != 0) continue;
            return pbnds_fail(
                error, PBNDS_ERROR_ARGUMENT,
                "%s: the channel %s would be written twice; give the extra "
                "channel another name",
                w->path, extra[i].name);
        }
        w->channels[w->channel_count++] = extra[i];
    }
    return PBNDS_OK;
}

static enum pbnds_status check_radiance(const struct writing *w,
                                        struct pbnds_error *error)
{
    const struct pbnds_image *r = w->radiance;
    const struct pbnds_gbuffer *g = w->gbuffer;
    if (!r || (r->width == g->width && r->height == g->height && r->channels == 3))
        return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                      "%s: the radiance is %d x %d with %d channels, the G-buffer "
                      "%d x %d; they must agree, with 3 channels",
                      w->path, r->width, r->height, r->channels, g->width, g->height);
}

enum pbnds_status
pbnds_gbuffer_write(const char *path, const struct pbnds_gbuffer *gbuffer,
                    const struct pbnds_gbuffer_origin *origin,
                    const struct pbnds_image *radiance,
                    const struct pbnds_exr_channel *extra, int extra_count,
                    enum pbnds_exr_compression compression, struct pbnds_error *error)
{
    if (extra_count < 0) extra_count = 0;
    struct writing w = {
        .path = path, .gbuffer = gbuffer, .origin = origin, .radiance = radiance};
    PBNDS_TRY(check_radiance(&w, error));
    const size_t room =
        (size_t)pbnds_gbuffer_channel_count() + RADIANCE + MATTES + (size_t)extra_count;
    float *block = NULL;
    struct pbnds_header *header = malloc(sizeof *header);
    w.channels = calloc(room, sizeof *w.channels);
    enum pbnds_status status = PBNDS_OK;
    if (!header || !w.channels) {
        status =
            pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for its header", path);
    }
    if (status == PBNDS_OK) status = convert(&w, &block, error);
    if (status == PBNDS_OK) {
        list_contract(&w);
        list_radiance(&w, extra, extra_count);
        list_mattes(&w);
        status = add_extra(&w, extra, extra_count, error);
    }
    if (status == PBNDS_OK) {
        pbnds_header_describe(header, gbuffer, origin);
        const struct pbnds_exr exr = {.width = gbuffer->width,
                                      .height = gbuffer->height,
                                      .compression = compression,
                                      .channels = w.channels,
                                      .channel_count = w.channel_count,
                                      .attributes = header->items,
                                      .attribute_count = header->count};
        status = pbnds_exr_write(path, &exr, error);
    }
    free(w.channels);
    free(header);
    free(block);
    return status;
}
