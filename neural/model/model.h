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

/**
 * A weights file is a safetensors file (safetensors.h) of the net's parameters, float32, by
 * their names, with these metadata, all of them text:
 *
 *     pbnds.model         "transport": the name of the model
 *     pbnds.version       of its table and features together; a program reads its own only
 *     pbnds.architecture  "43 layers, 405796 parameters, xxh64 ...": the hash is that of
 *                         the table (operators, wiring, widths, activations)
 *     pbnds.features      version of the feature table
 *     pbnds.light_mode    "clusters" or "uniform": how a light map becomes lights
 *
 * and, of weights that were trained (provenance.h):
 *
 *     pbnds.lights        N in training
 *     pbnds.features.view, pbnds.features.light, pbnds.features.encoding
 *                         the feature table with its normalisation (features_text.h)
 *     pbnds.program       version of the program that trained
 *     train.data          hash of the data set (dataset.h)
 *     train.recipe        model, data and options: what the numbers follow from
 *     train.step, train.steps, train.seed, train.dtype ("bf16" or "fp32": of the passes)
 *     train.validation_psnr_srgb
 *
 * Files that were written before there was a key lack it: what is absent is not checked.
 */

/** Writes the net's parameters with the first five of these and the caller's `extra`.
 * Atomic. */
enum pbnds_status pbnds_weights_save(const char *path, const struct pbnds_model *model,
                                     const struct pbnds_net *net,
                                     const struct pbnds_metadata *extra,
                                     int extra_count,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Opens a weights file and finds out whose it is. file is the caller's to free.
 * Errors: IO, FORMAT (not a weights file of ours, or its metadata contradict each other),
 * UNSUPPORTED (another version of the model or of its features: the sentence says both
 * and ours). */
enum pbnds_status pbnds_weights_open(const char *path, struct pbnds_safetensors *file,
                                     const struct pbnds_model **model,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** The second half of it: whose a file that was read is. */
enum pbnds_status pbnds_weights_identify(const char *path,
                                         const struct pbnds_safetensors *file,
                                         const struct pbnds_model **model,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
/** Copies the tensors into a net of that model. Every parameter must be there with its
 * shape, finite, and nothing else: FORMAT otherwise, the sentence names the tensor, and
 * the net is as it was. */
enum pbnds_status pbnds_weights_apply(const char *path,
                                      const struct pbnds_safetensors *file,
                                      struct pbnds_net *net,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_MODEL_MODEL_H */
