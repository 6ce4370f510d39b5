#include "engine/scene/gltf/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"

/** What all images together may take once decoded, where the options say nothing. */
static const uint64_t decoded_max = (uint64_t)8 << 30;

/** One image to decode, on any thread. */
struct job {
    const uint8_t *bytes;
    uint64_t size;
    size_t index; /* in the document */
    char name[512];
    enum pbnds_status status;
    struct pbnds_error error;
    struct pbnds_pixels *pixels;
    struct pbnds_image_limits limits;
    uint64_t decoded; /* bytes that the pixels will take */
};

enum pbnds_status pbnds_gltf_remap_init(struct pbnds_gltf_load_state *g,
                                        struct pbnds_gltf_remap *map)
{
    const struct pbnds_gltf_document *d = &g->doc;
    g->scene->textures = calloc(d->texture_count + 1, sizeof *g->scene->textures);
    g->scene->images = calloc(d->image_count + 1, sizeof *g->scene->images);
    map->texture = malloc((d->texture_count + 1) * sizeof *map->texture);
    map->image = malloc((d->image_count + 1) * sizeof *map->image);
    map->fallback = malloc((d->image_count + 1) * sizeof *map->fallback);
    if (!g->scene->textures || !g->scene->images || !map->texture || !map->image ||
        !map->fallback) {
        return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for textures",
                          g->name);
    }
    for (size_t i = 0; i < d->texture_count; ++i)
        map->texture[i] = -1;
    for (size_t i = 0; i < d->image_count; ++i) {
        map->image[i] = -1;
        map->fallback[i] = -1;
    }
    return PBNDS_OK;
}

void pbnds_gltf_remap_free(struct pbnds_gltf_remap *map)
{
    free(map->texture);
    free(map->image);
    free(map->fallback);
    *map = (struct pbnds_gltf_remap){0};
}

/** glTF 2.0, 3.8.4.2: GL constants; what is unknown repeats. */
static enum pbnds_wrap wrap_of(int gl)
{
    return gl == 33071 ? PBNDS_WRAP_CLAMP
                       : (gl == 33648 ? PBNDS_WRAP_MIRROR : PBNDS_WRAP_REPEAT);
}

int pbnds_gltf_add_texture(struct pbnds_gltf_load_state *g,
                           struct pbnds_gltf_remap *map, int64_t index)
{
    if (index < 0) return -1;
    if (map->texture[index] != -1)
        return map->texture[index] < 0 ? -1 : map->texture[index];
    const struct pbnds_gltf_texture *source = &g->doc.textures[index];
    if (source->image < 0) {
        map->texture[index] = -2; /* told once */
        pbnds_warn(g->report,
                   "%s: texture %lld has no image in a format that can be read, it is "
                   "left out",
                   g->name, (long long)index);
        return -1;
    }
    int *image = &map->image[source->image];
    if (*image < 0) *image = g->scene->image_count++;
    if (source->fallback >= 0) map->fallback[source->image] = source->fallback;
    struct pbnds_texture *texture = &g->scene->textures[g->scene->texture_count];
    texture->pixels = &g->scene->images[*image];
    texture->wrap_u = texture->wrap_v = PBNDS_WRAP_REPEAT;
    if (source->sampler >= 0) {
        const struct pbnds_gltf_sampler *s = &g->doc.samplers[source->sampler];
        texture->wrap_u = wrap_of(s->wrap_s);
        texture->wrap_v = wrap_of(s->wrap_t);
        texture->nearest = s->mag_filter == 9728;
    }
    return map->texture[index] = g->scene->texture_count++;
}

/** The encoded bytes of an image: a buffer view or what its URI names. */
static enum pbnds_status find_image(struct pbnds_gltf_load_state *g, size_t index,
                                    struct job *job)
{
    struct pbnds_gltf_payload *payload = &g->source.images[index];
    const int64_t view = g->doc.images[index].view;
    job->index = index;
    (void)snprintf(job->name, sizeof job->name, "%.400s, image %zu", g->name, index);
    if (view >= 0 || !payload->uri) {
        return pbnds_gltf_view_bytes(g, view, "an image", &job->bytes, &job->size);
    }
    if (strncmp(payload->uri, "data:", 5) != 0) {
        (void)snprintf(job->name, sizeof job->name, "%.300s, image \"%.180s\"", g->name,
                       payload->uri);
    }
    PBNDS_TRY(pbnds_gltf_resolve(&g->source, payload, "image", index, g->error));
    job->bytes = payload->data;
    job->size = payload->size;
    return PBNDS_OK;
}

/** The media type that the first bytes tell, "" for what is none of glTF's. */
static const char *type_of(const uint8_t *p, uint64_t size)
{
    if (size >= 8 && memcmp(p, "\x89PNG\r\n\x1a\n", 8) == 0) return "image/png";
    if (size >= 3 && memcmp(p, "\xff\xd8\xff", 3) == 0) return "image/jpeg";
    if (size >= 12 && memcmp(p, "RIFF", 4) == 0 && memcmp(p + 8, "WEBP", 4) == 0)
        return "image/webp";
    return "";
}

/** The media type that the file names: of the image, or of its data: URI. */
static void declared_type(const struct pbnds_gltf_load_state *g, size_t index,
                          char type[64])
{
    const char *uri = g->source.images[index].uri;
    const char *from = g->doc.images[index].mime_type;
    if (uri && strncmp(uri, "data:", 5) == 0) from = uri + 5;
    const size_t size = strcspn(from, ";,");
    (void)snprintf(type, 64, "%.*s", (int)(size < 63 ? size : 63), from);
}

/** An image is what its bytes say. Where the file says otherwise, that is told. */
static void compare_types(const struct pbnds_gltf_load_state *g, const struct job *job)
{
    char declared[64];
    declared_type(g, job->index, declared);
    const char *found = type_of(job->bytes, job->size);
    /* An octet stream says nothing; "image/jpg" is a common misspelling. */
    if (!declared[0] || !found[0] || strcmp(declared, found) == 0 ||
        strcmp(declared, "application/octet-stream") == 0 ||
        (strcmp(declared, "image/jpg") == 0 && strcmp(found, "image/jpeg") == 0)) {
        return;
    }
    pbnds_warn(g->report, "%s: is said to be %s, but is %s, and read as such",
               job->name, declared, found);
}

static void decode_one(void *context, size_t i, int thread)
{
    (void)thread;
    struct job *job = (struct job *)context + i;
    if (job->status != PBNDS_OK) return;
    job->status = pbnds_pixels_decode_within(job->bytes, (size_t)job->size, job->name,
                                             &job->limits, job->pixels, &job->error);
}

/** Where an image of EXT_texture_webp cannot be had, the one of the core stands in. */
static enum pbnds_status fall_back(struct pbnds_gltf_load_state *g,
                                   const struct pbnds_gltf_remap *map, struct job *job)
{
    const int64_t other = map->fallback[job->index];
    if (other < 0) {
        if (g->error) *g->error = job->error;
        return job->status;
    }
    pbnds_warn(g->report, "%s; image %lld is used in its place", job->error.message,
               (long long)other);
    PBNDS_TRY(find_image(g, (size_t)other, job));
    return pbnds_pixels_decode_within(job->bytes, (size_t)job->size, job->name,
                                      &job->limits, job->pixels, g->error);
}

/** Bytes that decoded pixels take. */
static uint64_t pixels_size(const struct pbnds_pixels *p)
{
    return (uint64_t)p->width * (uint64_t)p->height * (p->f32 ? 16u : 4u);
}

/** The size of an image, from its header. */
static enum pbnds_status measure(struct pbnds_gltf_load_state *g, struct job *job,
                                 uint64_t most)
{
    struct pbnds_image_size size;
    job->limits.side = g->options->max_image_side;
    job->limits.bytes = most;
    PBNDS_TRY(pbnds_image_measure(job->bytes, (size_t)job->size, job->name,
                                  &job->limits, &size, g->error));
    job->decoded = size.bytes;
    return PBNDS_OK;
}

static enum pbnds_status too_much(struct pbnds_gltf_load_state *g, uint64_t most)
{
    return pbnds_fail(g->error, PBNDS_ERROR_MEMORY,
                      "%s: its images take more than %.0f MiB (see --max-images)",
                      g->name, (double)most / 1048576.0);
}

/** Looks for the bytes of all jobs. What is not there is an error only where nothing can
 *  stand in for it. */
static void find_all(struct pbnds_gltf_load_state *g,
                     const struct pbnds_gltf_remap *map, struct job *jobs,
                     uint64_t most)
{
    for (size_t i = 0; i < g->doc.image_count; ++i) {
        if (map->image[i] < 0) continue;
        struct job *job = &jobs[map->image[i]];
        job->pixels = &g->scene->images[map->image[i]];
        job->status = find_image(g, i, job);
        if (job->status == PBNDS_OK) job->status = measure(g, job, most);
        if (job->status != PBNDS_OK && g->error) job->error = *g->error;
        if (job->status == PBNDS_OK) compare_types(g, job);
    }
}

static enum pbnds_status decode_all(struct pbnds_gltf_load_state *g,
                                    const struct pbnds_gltf_remap *map,
                                    struct job *jobs, uint64_t most)
{
    const size_t count = (size_t)g->scene->image_count;
    uint64_t decoded = 0;
    /* A bomb is seen before anything is decoded. */
    for (size_t i = 0; i < count && decoded <= most; ++i)
        decoded += jobs[i].decoded;
    if (decoded > most) return too_much(g, most);
    decoded = 0;
    for (size_t i = 0; i < count;) {
        const size_t threads = (size_t)pbnds_threads();
        const size_t batch = count - i < threads ? count - i : threads;
        pbnds_parallel_for(batch, decode_one, jobs + i);
        for (size_t end = i + batch; i < end; ++i) {
            if (jobs[i].status != PBNDS_OK) PBNDS_TRY(fall_back(g, map, &jobs[i]));
            decoded += pixels_size(jobs[i].pixels);
        }
        pbnds_progress(g->report, "textures", (double)i, (double)count);
        if (pbnds_stop_requested()) return pbnds_fail_interrupted(g->error);
        if (decoded > most) return too_much(g, most); /* by fall-backs */
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_decode_images(struct pbnds_gltf_load_state *g,
                                           const struct pbnds_gltf_remap *map)
{
    struct job *jobs = calloc((size_t)g->scene->image_count + 1, sizeof *jobs);
    if (!jobs)
        return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory", g->name);
    const uint64_t most = g->options->max_images ? g->options->max_images : decoded_max;
    find_all(g, map, jobs, most);
    const enum pbnds_status status = decode_all(g, map, jobs, most);
    free(jobs);
    return status;
}
