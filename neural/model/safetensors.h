/**
 * @file safetensors.h
 * Weights files: the safetensors format (8-byte little-endian header length, JSON header,
 * raw little-endian data), float32 only. The reader trusts nothing: offsets, overlaps, gaps,
 * shapes, duplicate names and sizes are checked before a byte is used.
 */
#ifndef PBNDS_NEURAL_MODEL_SAFETENSORS_H
#define PBNDS_NEURAL_MODEL_SAFETENSORS_H

#include <stddef.h>

#include "engine/core/error.h"

struct pbnds_safetensor {
    char name[96];
    int shape[4];
    int rank; /**< 0 to 4                                           */
    size_t count;
    const float *data; /**< into the file's buffer (read) or borrowed (write) */
};

struct pbnds_metadata {
    char *key, *value; /**< UTF-8; owned when read, borrowed when written */
};

struct pbnds_safetensors {
    struct pbnds_safetensor *tensors;
    int tensor_count;
    struct pbnds_metadata *metadata; /**< the "__metadata__" map of strings */
    int metadata_count;
    void *storage; /**< file bytes, owned */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Errors: IO, FORMAT (cut short, not safetensors, damaged header), UNSUPPORTED (dtype),
 *  MEMORY (over 4 GiB). */
enum pbnds_status pbnds_safetensors_read(const char *path,
                                         struct pbnds_safetensors *file,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
/** The same from bytes in memory (for the fuzz target); copies what it needs. */
enum pbnds_status pbnds_safetensors_parse(const void *bytes, size_t size,
                                          const char *name,
                                          struct pbnds_safetensors *file,
                                          struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_safetensors_free(struct pbnds_safetensors *file);
const struct pbnds_safetensor *
pbnds_safetensors_find(const struct pbnds_safetensors *file, const char *name);
/** Value of a metadata key, NULL when absent. */
const char *pbnds_safetensors_metadata(const struct pbnds_safetensors *file,
                                       const char *key);
/** Writes atomically, tensors in the given order, metadata in the given order. */
enum pbnds_status pbnds_safetensors_write(const char *path,
                                          const struct pbnds_safetensors *file,
                                          struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_MODEL_SAFETENSORS_H */
