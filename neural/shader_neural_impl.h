/** @file shader_neural_impl.h  What the neural shading passes share among themselves.
 */
#ifndef PBNDS_NEURAL_SHADER_NEURAL_IMPL_H
#define PBNDS_NEURAL_SHADER_NEURAL_IMPL_H

#include "neural/features.h"
#include "neural/model/model.h"
#include "neural/shader_neural.h"

struct pbnds_shader_neural {
    struct pbnds_shader base;
    const struct pbnds_model *model;
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    int lights; /**< as the weights were trained */
};

enum pbnds_status pbnds_shade_transport(const struct pbnds_shader *self,
                                        const struct pbnds_shade_job *job,
                                        struct pbnds_image *radiance,
                                        struct pbnds_error *error);
enum pbnds_status pbnds_shade_pbnds_plus(const struct pbnds_shader *self,
                                         const struct pbnds_shade_job *job,
                                         struct pbnds_image *radiance,
                                         struct pbnds_error *error);

#endif /* PBNDS_NEURAL_SHADER_NEURAL_IMPL_H */
