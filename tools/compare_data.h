/** @file compare_data.h  `pbnds compare` on a data set: many samples a shader. */
#ifndef PBNDS_TOOLS_COMPARE_DATA_H
#define PBNDS_TOOLS_COMPARE_DATA_H

#include "tools/options.h"

/** Shades every sample of a split from its G-buffer and light map alone and compares
 * with the reference radiance that lies in it. `names`: the shaders. */
enum pbnds_status tool_compare_data(const struct tool_options *options, const char *dir,
                                    const char *const *names, int count,
                                    struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_COMPARE_DATA_H */
