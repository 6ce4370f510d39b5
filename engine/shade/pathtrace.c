/* Pictures of paths; see pathtrace.h. */
#include "engine/shade/pathtrace.h"

#include <math.h>
#include <string.h>

#include "engine/shade/path_blocks.h"
#include "engine/shade/path_start.h"
#include "engine/shade/tiles.h"

enum { DEFAULT_SPP = 256, DEFAULT_SPP_NOISE = 4096, DEFAULT_BOUNCES = 8, TILE = 8 };
/* Blocks of samples that make an estimate of noise. */
enum { ENOUGH_BLOCKS = 8 };

/* The picture so far: sums over samples, divided at the end. */
struct film {
    struct pbnds_image radiance,
        direct;                /* direct: empty where not wanted             */
    struct pbnds_image spread; /* sum_b n_b (m_b - m)^2; empty: not wanted    */
    struct pbnds_image hits;   /* samples that met a surface; empty: all do   */
};

struct trace {
    const struct pbnds_shade_job *job;
    struct pbnds_path_world world;
    struct pbnds_light_table lights;
    struct pbnds_path_lens lens;
    int spp, block;
    int begin, end; /* samples of this pass */
    struct film film;
};

/* Sums over one block. */
struct block {
    struct pbnds_vec3 total, direct;
    int hits;
};

static void trace_block(const struct trace *trace, int x, int y, size_t i,
                        const struct pbnds_path_vertex *first, int begin, int end,
                        struct block *block)
{
    memset(block, 0, sizeof *block);
    for (int s = begin; s < end; ++s) {
        const struct pbnds_sampler sampler =
            pbnds_sampler_make(trace->job->seed, i, (uint32_t)s, (uint32_t)trace->spp);
        struct pbnds_path_light light;
        if (first) {
            pbnds_path_trace(&trace->world, first, &sampler, &light);
        } else {
            float cone[2];
            const struct pbnds_ray ray =
                pbnds_path_start_ray(&trace->lens, x, y, &sampler, cone);
            if (!pbnds_path_trace_camera(&trace->world, &ray, cone, &sampler, &light))
                continue;
        }
        ++block->hits;
        block->total = pbnds_add(block->total, light.total);
        block->direct = pbnds_add(block->direct, light.direct);
    }
    if (first) {
        const struct pbnds_vec3 emission =
            pbnds_gbuffer_vec3(trace->job->gbuffer->emission, i);
        block->total = pbnds_mad(block->total, emission, (float)(end - begin));
        block->direct = pbnds_mad(block->direct, emission, (float)(end - begin));
    }
}

static void add_block(struct film *film, size_t i, const struct block *block,
                      int before, int count)
{
    const float total[3] = {block->total.x, block->total.y, block->total.z};
    float *sum = film->radiance.data + 3 * i;
    if (film->spread.data)
        pbnds_path_add_spread(film->spread.data + 3 * i, sum, total, before, count);
    for (int c = 0; c < 3; ++c)
        sum[c] += total[c];
    if (film->direct.data) {
        float *direct = film->direct.data + 3 * i;
        direct[0] += block->direct.x;
        direct[1] += block->direct.y;
        direct[2] += block->direct.z;
    }
    if (film->hits.data) film->hits.data[i] += (float)block->hits;
}

static void trace_pixel(struct trace *trace, int x, int y)
{
    const struct pbnds_gbuffer *g = trace->job->gbuffer;
    const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
    struct pbnds_path_vertex first;
    const enum pbnds_path_start start = pbnds_path_start_of(&trace->lens, x, y, &first);
    if (start == PBNDS_PATH_NOWHERE) return;
    for (int s = trace->begin; s < trace->end; s += trace->block) {
        const int end = s + trace->block < trace->end ? s + trace->block : trace->end;
        struct block block;
        trace_block(trace, x, y, i, start == PBNDS_PATH_SURFACE ? &first : NULL, s, end,
                    &block);
        add_block(&trace->film, i, &block, s, end - s);
    }
}

static void trace_tile(void *context, const struct pbnds_tile *tile)
{
    struct trace *trace = context;
    for (int y = tile->y0; y < tile->y1 && !pbnds_stop_requested(); ++y)
        for (int x = tile->x0; x < tile->x1; ++x)
            trace_pixel(trace, x, y);
}

/* Passes. */

/* Progress of one pass as a part of all of them. */
struct pass_report {
    const struct pbnds_report *report;
    double before, share;
};

static void pass_progress(void *user, const char *stage, double done, double total)
{
    const struct pass_report *pass = user;
    pbnds_progress(pass->report, stage, pass->before + pass->share * done / total, 1.0);
}

static enum pbnds_status run_pass(struct trace *trace, int begin, int end,
                                  struct pbnds_error *error)
{
    struct pass_report pass = {.report = trace->job->report};
    pass.before = (double)begin / trace->spp;
    pass.share = (double)(end - begin) / trace->spp;
    const struct pbnds_report report = {.progress = pass_progress, .user = &pass};
    trace->begin = begin;
    trace->end = end;
    const struct pbnds_gbuffer *g = trace->job->gbuffer;
    return pbnds_for_tiles(g->width, g->height, TILE, &report, "reference", trace_tile,
                           trace, error);
}

/* See pathtrace.h. In a fixed order: the answer must not depend on threads. */
static double noise(const struct trace *trace, int n)
{
    const struct film *film = &trace->film;
    const size_t pixels = (size_t)film->radiance.width * (size_t)film->radiance.height;
    const float *covered =
        film->hits.data ? film->hits.data : trace->job->gbuffer->coverage;
    double error = 0.0, sum = 0.0, values = 0.0;
    for (size_t i = 0; i < pixels; ++i) {
        if (!(covered[i] > 0.0f)) continue;
        values += 3.0;
        for (size_t k = 3 * i; k < 3 * i + 3; ++k) {
            error += (double)film->spread.data[k];
            sum += (double)film->radiance.data[k];
        }
    }
    error = sqrt(error * pbnds_path_variance_scale(n, trace->block) * values);
    return sum > 0.0 ? error * n / sum : 0.0;
}

static enum pbnds_status run_passes(struct trace *trace, int *taken,
                                    struct pbnds_error *error)
{
    const double target = (double)trace->job->noise;
    *taken = trace->spp;
    if (!(target > 0.0)) return run_pass(trace, 0, trace->spp, error);
    for (int begin = 0; begin < trace->spp;) {
        const int rest = trace->spp - begin;
        const int end = begin + (rest < trace->block ? rest : trace->block);
        PBNDS_TRY(run_pass(trace, begin, end, error));
        *taken = end;
        if (end / trace->block >= ENOUGH_BLOCKS && noise(trace, end) < target) break;
        begin = end;
    }
    pbnds_progress(trace->job->report, "reference", 1.0, 1.0);
    return PBNDS_OK;
}

/* Setting up, and the picture from the sums. */

static enum pbnds_status open_film(const struct trace *trace, bool direct,
                                   struct film *film, struct pbnds_error *error)
{
    const struct pbnds_shade_job *job = trace->job;
    const int w = job->gbuffer->width, h = job->gbuffer->height;
    PBNDS_TRY(pbnds_image_init(&film->radiance, w, h, 3, error));
    if (direct) PBNDS_TRY(pbnds_image_init(&film->direct, w, h, 3, error));
    if ((job->variance || job->noise > 0.0f) && trace->spp > 1)
        PBNDS_TRY(pbnds_image_init(&film->spread, w, h, 3, error));
    if (trace->world.blends || job->gbuffer->samples > 1)
        PBNDS_TRY(pbnds_image_init(&film->hits, w, h, 1, error));
    return PBNDS_OK;
}

static void close_film(struct film *film)
{
    pbnds_image_free(&film->radiance);
    pbnds_image_free(&film->direct);
    pbnds_image_free(&film->spread);
    pbnds_image_free(&film->hits);
}

/* Sums become means: radiance over the samples that met something, coverage over all. */
static void resolve(struct trace *trace, int n)
{
    struct film *film = &trace->film;
    const size_t pixels = (size_t)film->radiance.width * (size_t)film->radiance.height;
    const float scale =
        film->spread.data ? (float)pbnds_path_variance_scale(n, trace->block) : 0.0f;
    for (size_t i = 0; i < pixels; ++i) {
        const float hits = film->hits.data ? film->hits.data[i] : (float)n;
        if (film->hits.data) film->hits.data[i] = hits / (float)n;
        for (size_t k = 3 * i; k < 3 * i + 3; ++k) {
            if (hits > 0.0f) film->radiance.data[k] /= hits;
            if (hits > 0.0f && film->direct.data) film->direct.data[k] /= hits;
            if (film->spread.data) film->spread.data[k] *= scale;
        }
    }
}

/* Moves an image of the film to where it is wanted. */
static void hand_over(struct pbnds_image *from, struct pbnds_image *to)
{
    if (!to) return;
    *to = *from;
    memset(from, 0, sizeof *from);
}

static enum pbnds_status trace_film(struct trace *trace, bool direct, int *taken,
                                    struct pbnds_error *error)
{
    const struct pbnds_shade_job *job = trace->job;
    PBNDS_TRY(pbnds_light_table_create(job->scene, job->envmap, &trace->lights, error));
    enum pbnds_status status = open_film(trace, direct, &trace->film, error);
    if (status == PBNDS_OK) status = run_passes(trace, taken, error);
    if (status == PBNDS_OK) resolve(trace, *taken);
    pbnds_light_table_free(&trace->lights);
    return status;
}

static enum pbnds_status check(const struct pbnds_shade_job *job,
                               const struct pbnds_pathtrace_options *options,
                               struct pbnds_error *error)
{
    if (!job->scene || !job->accel)
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "reference needs the scene; give a .glb, or choose ggx, neural");
    if (options->spp < 0 || options->max_bounces < 0)
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "reference: %d samples and %d bounces were asked for; give "
                          "positive numbers, or 0 for the defaults",
                          options->spp, options->max_bounces);
    return PBNDS_OK;
}

static void set_up(struct trace *trace, const struct pbnds_shade_job *job,
                   const struct pbnds_pathtrace_options *options)
{
    memset(trace, 0, sizeof *trace);
    const int otherwise = job->noise > 0.0f ? DEFAULT_SPP_NOISE : DEFAULT_SPP;
    trace->job = job;
    trace->spp = options->spp > 0 ? options->spp : otherwise;
    trace->block = pbnds_path_block_size(trace->spp);
    trace->world = (struct pbnds_path_world){.scene = job->scene,
                                             .accel = job->accel,
                                             .envmap = job->envmap,
                                             .lights = &trace->lights,
                                             .max_bounces = options->max_bounces > 0
                                                                ? options->max_bounces
                                                                : DEFAULT_BOUNCES,
                                             .blends = pbnds_accel_blends(job->accel)};
    trace->lens = pbnds_path_lens_make(job->gbuffer, &trace->world);
}

enum pbnds_status pbnds_pathtrace(const struct pbnds_shade_job *job,
                                  const struct pbnds_pathtrace_options *options,
                                  struct pbnds_image *radiance,
                                  struct pbnds_image *direct, struct pbnds_error *error)
{
    static const struct pbnds_image empty;
    *radiance = empty;
    if (direct) *direct = empty;
    if (job->variance) *job->variance = empty;
    if (job->alpha) *job->alpha = empty;
    PBNDS_TRY(check(job, options, error));
    struct trace trace;
    int taken = 0;
    set_up(&trace, job, options);
    const enum pbnds_status status = trace_film(&trace, direct != NULL, &taken, error);
    if (status == PBNDS_OK) {
        hand_over(&trace.film.radiance, radiance);
        hand_over(&trace.film.direct, direct);
        hand_over(&trace.film.spread, job->variance);
        hand_over(&trace.film.hits, job->alpha);
        if (job->taken) *job->taken = taken;
    }
    close_film(&trace.film);
    return status;
}
