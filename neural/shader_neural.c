/* The rows of the shading-pass table that are networks: loading, and what they share.
 */
#include "neural/shader_neural.h"

#include <stdlib.h>
#include <string.h>

#include "neural/shader_neural_impl.h"

static void destroy(struct pbnds_shader *self)
{
    struct pbnds_shader_neural *s = (struct pbnds_shader_neural *)self;
    pbnds_net_free(s->net);
    pbnds_backend_free(s->backend);
    free(s);
}

/* The networks know lights at infinity from the map. Those of the file are few and exact:
 * ggx shades them alone, with traced shadows where the scene is known. It brings the
 * emission a second time. */
static enum pbnds_status add_file_lights(const struct pbnds_shade_job *job,
                                         struct pbnds_image *radiance,
                                         struct pbnds_error *error)
{
    if (!job->scene || job->scene->light_count == 0) return PBNDS_OK;
    struct pbnds_shade_job alone = *job;
    alone.envmap = NULL;
    alone.variance = NULL;
    struct pbnds_image lit;
    PBNDS_TRY(pbnds_shade(pbnds_shader_find("ggx"), &alone, &lit, error));
    const size_t pixels = (size_t)lit.width * (size_t)lit.height;
    for (size_t i = 0; i < pixels; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            radiance->data[3 * i + c] +=
                lit.data[3 * i + c] - job->gbuffer->emission[c][i];
        }
    }
    pbnds_image_free(&lit);
    return PBNDS_OK;
}

static enum pbnds_status shade_transport(const struct pbnds_shader *self,
                                         const struct pbnds_shade_job *job,
                                         struct pbnds_image *radiance,
                                         struct pbnds_error *error)
{
    PBNDS_TRY(pbnds_shade_transport(self, job, radiance, error));
    return add_file_lights(job, radiance, error);
}

static enum pbnds_status shade_pbnds_plus(const struct pbnds_shader *self,
                                          const struct pbnds_shade_job *job,
                                          struct pbnds_image *radiance,
                                          struct pbnds_error *error)
{
    PBNDS_TRY(pbnds_shade_pbnds_plus(self, job, radiance, error));
    return add_file_lights(job, radiance, error);
}

static const struct pbnds_shader_ops OPS[] = {
    {.name = "transport",
     .channels = PBNDS_CHANNEL_ALBEDO | PBNDS_CHANNEL_NORMAL | PBNDS_CHANNEL_SPECULAR |
                 PBNDS_CHANNEL_ROUGHNESS | PBNDS_CHANNEL_METALLIC |
                 PBNDS_CHANNEL_DEPTH | PBNDS_CHANNEL_EMISSION,
     .about = "neural light transport, linear in light: predicted shadows and indirect "
              "light",
     .shade = shade_transport,
     .destroy = destroy},
    {.name = "pbnds+",
     .channels = PBNDS_CHANNEL_ALBEDO | PBNDS_CHANNEL_NORMAL | PBNDS_CHANNEL_SPECULAR |
                 PBNDS_CHANNEL_ROUGHNESS | PBNDS_CHANNEL_DEPTH | PBNDS_CHANNEL_EMISSION,
     .about = "the paper's convolutional deferred shader: a U-Net a light, averaged",
     .shade = shade_pbnds_plus,
     .destroy = destroy},
};

static const struct pbnds_shader_ops *ops_of(const struct pbnds_model *model)
{
    for (size_t i = 0; i < sizeof OPS / sizeof OPS[0]; ++i) {
        if (strcmp(OPS[i].name, model->name) == 0) return &OPS[i];
    }
    return NULL;
}

static int lights_of(const struct pbnds_safetensors *file,
                     const struct pbnds_model *model)
{
    const char *text = pbnds_safetensors_metadata(file, "pbnds.lights");
    const long n = text ? strtol(text, NULL, 10) : 0;
    return n >= 1 && n <= 4096 ? (int)n : model->lights;
}

enum pbnds_status pbnds_shader_neural_create(const char *weights_path,
                                             enum pbnds_dtype dtype,
                                             const struct pbnds_shader **shader,
                                             struct pbnds_error *error)
{
    *shader = NULL;
    struct pbnds_safetensors file = {0};
    const struct pbnds_model *model;
    PBNDS_TRY(pbnds_weights_open(weights_path, &file, &model, error));
    struct pbnds_shader_neural *s = calloc(1, sizeof *s);
    enum pbnds_status status;
    if (!s) {
        status = pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory", weights_path);
        goto done;
    }
    s->base.ops = ops_of(model);
    s->model = model;
    s->lights = lights_of(&file, model);
    status = pbnds_backend_create_onednn(&s->backend, error);
    if (status == PBNDS_OK) {
        status = pbnds_net_create(&model->table, s->backend, dtype, &s->net, error);
    }
    if (status == PBNDS_OK)
        status = pbnds_weights_apply(weights_path, &file, s->net, error);
    if (status == PBNDS_OK) {
        *shader = &s->base;
    } else {
        destroy(&s->base);
    }
done:
    pbnds_safetensors_free(&file);
    return status;
}

void pbnds_shader_neural_free(const struct pbnds_shader *shader)
{
    if (shader) shader->ops->destroy((struct pbnds_shader *)(uintptr_t)shader);
}
