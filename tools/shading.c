#include "tools/shading.h"

#include <stdio.h>
#include <unistd.h>

#include "neural/light_cache.h"
#include "tools/console.h"
#include "tools/output.h"

static enum pbnds_status check_outputs(const struct tool_options *options,
                                       struct pbnds_error *error)
{
    PBNDS_TRY(tool_picture_check(options->output, error));
    if (!options->preview) return PBNDS_OK;
    if (!tool_has_extension(options->preview, ".png")) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "--preview %s: is not a .png",
                          options->preview);
    }
    return tool_output_check(options->preview, error);
}

/* What a shader gives. */
struct result {
    struct pbnds_image radiance, alpha, variance;
    int taken; /* samples a pixel; 0: the shader does not say */
    double seconds;
    size_t cached; /* bytes of the light cache; 0: none */
};

static enum pbnds_status write_outputs(const struct tool_options *options,
                                       const struct tool_world *world,
                                       struct result *result, struct pbnds_error *error)
{
    const struct pbnds_display display = tool_display(options);
    tool_background(world, options->background, &result->alpha, &result->radiance);
    PBNDS_TRY(tool_picture_write(options->output, world, &result->radiance,
                                 &result->alpha, &result->variance, &display, error));
    if (!options->preview) return PBNDS_OK;
    return tool_picture_write(options->preview, world, &result->radiance,
                              &result->alpha, &result->variance, &display, error);
}

/* From the file, or made and written to it. */
static enum pbnds_status open_cache(const struct tool_options *options,
                                    const struct pbnds_shader *shader,
                                    const struct pbnds_shade_job *job,
                                    struct pbnds_light_cache *cache,
                                    struct pbnds_error *error)
{
    const char *path = options->cache;
    if (access(path, F_OK) != 0) {
        PBNDS_TRY(tool_output_check(path, error));
        PBNDS_TRY(pbnds_light_cache_make(
            shader, job, options->lights > 0 ? options->lights : PBNDS_CACHE_DIRECTIONS,
            cache, error));
        const enum pbnds_status status = pbnds_light_cache_write(path, cache, error);
        if (status != PBNDS_OK) pbnds_light_cache_free(cache);
        return status;
    }
    PBNDS_TRY(pbnds_light_cache_read(path, cache, error));
    enum pbnds_status status =
        pbnds_light_cache_check(path, cache, shader, job->gbuffer, error);
    if (status == PBNDS_OK && options->lights > 0 &&
        options->lights != cache->directions) {
        status =
            pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                       "%s: holds %d directions, not the %d of --lights; leave that "
                       "out, or name another file",
                       path, cache->directions, options->lights);
    }
    if (status != PBNDS_OK) pbnds_light_cache_free(cache);
    return status;
}

static enum pbnds_status relight(const struct tool_options *options,
                                 const struct pbnds_shader *shader,
                                 const struct pbnds_shade_job *job,
                                 struct result *result, struct pbnds_error *error)
{
    struct pbnds_light_cache cache;
    PBNDS_TRY(open_cache(options, shader, job, &cache, error));
    const double start = tool_seconds();
    const enum pbnds_status status =
        pbnds_light_cache_shade(&cache, job, &result->radiance, error);
    result->seconds = tool_seconds() - start;
    result->cached = cache.size;
    pbnds_light_cache_free(&cache);
    return status;
}

static enum pbnds_status shade(const struct tool_options *options,
                               const struct tool_world *world,
                               const struct pbnds_shader *shader, struct result *result,
                               struct pbnds_error *error)
{
    struct pbnds_shade_job job = tool_world_job(options, world);
    job.alpha = &result->alpha;
    job.taken = &result->taken;
    if (tool_has_extension(options->output, ".exr")) job.variance = &result->variance;
    if (options->cache) {
        PBNDS_TRY(relight(options, shader, &job, result, error));
        return tool_check_stop(error);
    }
    const double start = tool_seconds();
    PBNDS_TRY(pbnds_shade(shader, &job, &result->radiance, error));
    result->seconds = tool_seconds() - start;
    return tool_check_stop(error);
}

static void say(const struct tool_options *options, const char *shader,
                const struct result *result)
{
    const struct pbnds_image *picture = &result->radiance;
    if (options->json) {
        tool_json_result(options->output, result->taken > 0 ? 4 : 3, "width",
                         (double)picture->width, "height", (double)picture->height,
                         "seconds", result->seconds, "spp", (double)result->taken);
        return;
    }
    (void)printf("%s: %dx%d, %s, shaded in %.*f s", options->output, picture->width,
                 picture->height, shader, result->cached > 0 ? 3 : 2, result->seconds);
    if (result->cached > 0)
        (void)printf(" from %.1f MB of cache", (double)result->cached * 1e-6);
    if (result->taken > 0) (void)printf(", %d samples a pixel", result->taken);
    (void)printf("\n");
}

enum pbnds_status tool_shade_one(const struct tool_options *options,
                                 tool_world_loader load, struct pbnds_error *error)
{
    struct tool_world world = {.accel = NULL};
    struct tool_shader shader = {NULL, false};
    struct result result = {.taken = 0};
    const char *name = options->shader ? options->shader : "neural";
    enum pbnds_status status = tool_shader_check(name, error);
    if (status == PBNDS_OK) status = check_outputs(options, error);
    if (status == PBNDS_OK) {
        status = tool_shader_open(name, options->precision, &shader, error);
    }
    if (status == PBNDS_OK) status = load(options, options->inputs[0], &world, error);
    if (status == PBNDS_OK) status = tool_world_light(options, &world, error);
    if (status == PBNDS_OK)
        status = shade(options, &world, shader.shader, &result, error);
    if (status == PBNDS_OK) status = write_outputs(options, &world, &result, error);
    if (status == PBNDS_OK) say(options, name, &result);
    pbnds_image_free(&result.radiance);
    pbnds_image_free(&result.alpha);
    pbnds_image_free(&result.variance);
    tool_shader_close(&shader);
    tool_world_free(&world);
    return status;
}
