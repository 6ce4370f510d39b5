/**
 * @file shader_neural.h
 * The neural shading pass: features -> network -> integrate over lights, as one row of
 * the engine's table (shader.h). A weights file says which model it is and how it wants
 * its lights sampled.
 */
#ifndef PBNDS_NEURAL_SHADER_NEURAL_H
#define PBNDS_NEURAL_SHADER_NEURAL_H

#include "engine/shade/shader.h"
#include "neural/backend/backend.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Loads weights and makes a shader; free with pbnds_shader_neural_free().
 *  Unlike the classical passes a neural one works in buffers of its own: one image at a
 *  time a shader (it is parallel inside). dtype: PBNDS_BF16 or PBNDS_F32. Its ops->name
 *  is the model's ("transport", "pbnds+"). Errors: IO, FORMAT (cut short, damaged, weights of another model or
 * version: the sentence names the tensor), UNSUPPORTED, MEMORY, BACKEND. */
enum pbnds_status pbnds_shader_neural_create(const char *weights_path,
                                             enum pbnds_dtype dtype,
                                             const struct pbnds_shader **shader,
                                             struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_shader_neural_free(const struct pbnds_shader *shader);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_SHADER_NEURAL_H */
