/**
 * @file safetensors_internal.h
 * What the reader and the writer of safetensors share: both hold to the same limits.
 */
#ifndef PBNDS_NEURAL_MODEL_SAFETENSORS_INTERNAL_H
#define PBNDS_NEURAL_MODEL_SAFETENSORS_INTERNAL_H

#include <stdint.h>

#include "neural/model/safetensors.h"

#define PBNDS_SAFETENSORS_MAX_FILE   ((uint64_t)1 << 32) /* 4 GiB */
#define PBNDS_SAFETENSORS_MAX_HEADER ((uint64_t)16 << 20)
/** The entry of the header that is no tensor. */
#define PBNDS_SAFETENSORS_METADATA "__metadata__"

/** Why the bytes cannot be a header, or NULL: not UTF-8, control characters, zeros in
 *  strings, nested too deep, too many values. */
const char *pbnds_safetensors_scan(const uint8_t *text, size_t size);
/** Sorts names; one that is there twice, or NULL. */
const char *pbnds_safetensors_duplicate(const char **names, size_t count);

#endif /* PBNDS_NEURAL_MODEL_SAFETENSORS_INTERNAL_H */
