/* "reference": the path tracer as a row of the table. */
#include "engine/shade/pathtrace.h"
#include "engine/shade/shader_table.h"

static enum pbnds_status shade(const struct pbnds_shader *self,
                               const struct pbnds_shade_job *job,
                               struct pbnds_image *radiance, struct pbnds_error *error)
{
    (void)self;
    const struct pbnds_pathtrace_options options = {.spp = job->spp};
    struct pbnds_image traced;
    PBNDS_TRY(pbnds_pathtrace(job, &options, &traced, NULL, error));
    pbnds_image_free(radiance);
    *radiance = traced;
    return PBNDS_OK;
}

static const struct pbnds_shader_ops ops = {
    .name = "reference",
    .channels = PBNDS_CHANNELS_LIT,
    .needs_scene = true,
    .about = "path tracing: shadows, interreflection, emitters; needs the scene",
    .shade = shade,
};
const struct pbnds_shader pbnds_shader_reference = {.ops = &ops};
