/**
 * @file check_gbuffer.h
 * The table that pbnds check prints of a G-buffer.
 */
#ifndef PBNDS_TOOLS_CHECK_GBUFFER_H
#define PBNDS_TOOLS_CHECK_GBUFFER_H

#include <stdbool.h>

#include "engine/core/error.h"

/** Lints the file and prints what was found, as a table or as one line of JSON:
 *  {"output": FILE, "sound": 0|1, "size": [w, h], "contract": n, "findings": [{"rule",
 *  "level": "fault"|"warning", "channel", "count", "pixel": [x, y] or null, "value",
 *  "wants"}]}. Errors: those of reading; FORMAT where a finding is a fault. */
enum pbnds_status tool_check_gbuffer(const char *path, bool json,
                                     struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_CHECK_GBUFFER_H */
