/**
 * @file model.h
 * The networks of the product, each one table (net.h), and their weights files.
 */
#ifndef PBNDS_NEURAL_MODEL_MODEL_H
#define PBNDS_NEURAL_MODEL_MODEL_H

#include <stdint.h>

#include "neural/layers/net.h"
#include "neural/model/safetensors.h"

/** A network and how it is to be used. Static data. */
struct pbnds_model {
    const char *name; /**< "transport", "pbnds+": the word on the command line */
    int version;      /**< of the table and of the features together; in the file */
    struct pbnds_net_table table;
    int view_channels;    /**< of the view input */
    int light_channels;   /**< of the light input */
    int lights;           /**< default N */
    bool linear_in_light; /**< any N and any sampler are valid */
    int features;         /**< version of its feature table (features.h) */
    /** How a light map becomes the N lights: "clusters" (envmap.h) or "uniform"
     *  (pbnds_plus.h). */
    const char *light_mode;
    /** Channels of the outputs, for who runs the network elsewhere; NULL: no such output. */
    const char *light_output_about, *view_output_about;
    const char *about;
};

#ifdef __cplusplus
extern "C" {
#endif

/** NULL when the name is none of them. */
const struct pbnds_model *pbnds_model_find(const char *name);
/** i-th model, NULL past the end. */
const struct pbnds_model *pbnds_model_at(int i);

/** Writes the net's parameters with "pbnds.model", "pbnds.version" and the caller's
 * further metadata (training provenance). Atomic. */
enum pbnds_status pbnds_weights_save(const char *path, const struct pbnds_model *model,
                                     const struct pbnds_net *net,
                                     const struct pbnds_metadata *extra,
                                     int extra_count,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Opens a weights file and finds out whose it is. file is the caller's to free.
 * Errors: IO, FORMAT (not a weights file of ours), UNSUPPORTED (another version of the
 * model). */
enum pbnds_status pbnds_weights_open(const char *path, struct pbnds_safetensors *file,
                                     const struct pbnds_model **model,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Copies the tensors into a net of that model. Every parameter must be there with its
 * shape, finite, and nothing else: FORMAT otherwise, the sentence names the tensor. */
enum pbnds_status pbnds_weights_apply(const char *path,
                                      const struct pbnds_safetensors *file,
                                      struct pbnds_net *net,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_MODEL_MODEL_H */
