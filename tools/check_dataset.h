/**
 * @file check_dataset.h
 * Is a data set what it says it is?
 */
#ifndef PBNDS_TOOLS_CHECK_DATASET_H
#define PBNDS_TOOLS_CHECK_DATASET_H

#include <stdbool.h>

#include "engine/core/error.h"

/** Reads all of it: every file against the manifest's hash, samples that are missing or too
 *  many, assets and light maps in two splits, the G-buffers' contract, light that is
 *  negative or not finite. Prints each fault as a sentence (the first 50), or all as one
 *  line of JSON: {"output": DIR, "sound": 0|1, "samples": n, "quarantined": n,
 *  "faults": n, "findings": [SENTENCE, ...]}. Errors: IO; INTERRUPTED; MEMORY; FORMAT where
 *  there is a fault. */
enum pbnds_status tool_check_dataset(const char *dir, bool json,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_CHECK_DATASET_H */
