/**
 * @file import_ffhq.h
 * pbnds import ffhq-pbr: a folder of photographs with their maps becomes a data set.
 */
#ifndef PBNDS_TOOLS_IMPORT_FFHQ_H
#define PBNDS_TOOLS_IMPORT_FFHQ_H

#include "tools/options.h"

enum pbnds_status tool_import_ffhq(const struct tool_options *options,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_IMPORT_FFHQ_H */
