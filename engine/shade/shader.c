/* The classical rows of the table, and the one door to every shader. */
#include "engine/shade/shader.h"

#include <string.h>

#include "engine/shade/shader_table.h"

enum { TABLE_COUNT = 5 };
static const struct pbnds_shader *const TABLE[TABLE_COUNT] = {
    &pbnds_shader_blinn_phong, &pbnds_shader_ggx, &pbnds_shader_paper_blinn_phong,
    &pbnds_shader_paper_ggx, &pbnds_shader_reference};

const struct pbnds_shader *pbnds_shader_at(int i)
{
    return i >= 0 && i < TABLE_COUNT ? TABLE[i] : NULL;
}

const struct pbnds_shader *pbnds_shader_find(const char *name)
{
    for (int i = 0; name && i < TABLE_COUNT; ++i)
        if (strcmp(TABLE[i]->ops->name, name) == 0) return TABLE[i];
    return NULL;
}

static enum pbnds_status check_job(const struct pbnds_shader *shader,
                                   const struct pbnds_shade_job *job,
                                   struct pbnds_error *error)
{
    const char *name = shader->ops->name;
    if (!job->gbuffer || !job->gbuffer->coverage)
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "%s: there is no G-buffer to shade; ray cast a scene or read one", name);
    if (shader->ops->needs_scene && (!job->scene || !job->accel))
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s needs the scene; give a .glb, or choose ggx, neural",
                          name);
    if (job->spp < 0 || job->lights < 0)
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: %d samples and %d lights were asked for; give positive "
                          "numbers, or 0 for the defaults",
                          name, job->spp, job->lights);
    return PBNDS_OK;
}

enum pbnds_status pbnds_shade(const struct pbnds_shader *shader,
                              const struct pbnds_shade_job *job,
                              struct pbnds_image *radiance, struct pbnds_error *error)
{
    memset(radiance, 0, sizeof *radiance);
    if (job->variance) memset(job->variance, 0, sizeof *job->variance);
    if (job->alpha) memset(job->alpha, 0, sizeof *job->alpha);
    if (job->taken) *job->taken = 0;
    PBNDS_TRY(check_job(shader, job, error));
    PBNDS_TRY(pbnds_image_init(radiance, job->gbuffer->width, job->gbuffer->height, 3,
                               error));
    const enum pbnds_status status = shader->ops->shade(shader, job, radiance, error);
    if (status != PBNDS_OK) pbnds_image_free(radiance);
    return status;
}
