/** @file shader_neural_impl.h  What the neural shading passes share among themselves.
 */
#ifndef PBNDS_NEURAL_SHADER_NEURAL_IMPL_H
#define PBNDS_NEURAL_SHADER_NEURAL_IMPL_H

#include "neural/features.h"
#include "neural/model/model.h"
#include "neural/shader_neural.h"

/** Most lights of a chunk: more gain nothing, and per-chunk arrays stay on the stack. */
enum { PBNDS_CHUNK_MAX = 16 };

struct pbnds_shader_neural {
    struct pbnds_shader base;
    const struct pbnds_model *model;
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    int lights; /**< as the weights were trained */
};

/** Image size rounded up to what the net's deepest level divides. */
struct pbnds_window pbnds_padded_window(const struct pbnds_net *net, int width,
                                        int height);
/** How many lights of a window to evaluate at once within `max_memory` (0: 512 MiB). */
int pbnds_lights_a_chunk(const struct pbnds_model *model, struct pbnds_window window,
                         size_t max_memory, int lights);

enum pbnds_status pbnds_shade_transport(const struct pbnds_shader *self,
                                        const struct pbnds_shade_job *job,
                                        struct pbnds_image *radiance,
                                        struct pbnds_error *error);
enum pbnds_status pbnds_shade_pbnds_plus(const struct pbnds_shader *self,
                                         const struct pbnds_shade_job *job,
                                         struct pbnds_image *radiance,
                                         struct pbnds_error *error);

#endif /* PBNDS_NEURAL_SHADER_NEURAL_IMPL_H */
