/**
 * @file weights.h
 * Weights files for `pbnds info` and `pbnds check`.
 */
#ifndef PBNDS_TOOLS_WEIGHTS_H
#define PBNDS_TOOLS_WEIGHTS_H

#include "tools/facts.h"

/** What a weights file says of itself. With `raw` (for --json) its metadata as they are
 * beside that. */
enum pbnds_status tool_describe_weights(const char *path, bool raw, cJSON *facts,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
/** Every tensor against the model that the file names: prints the findings, and fails
 *  with FORMAT where one is a fault. */
enum pbnds_status tool_check_weights(const char *path, bool json,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_WEIGHTS_H */
