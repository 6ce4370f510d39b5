/**
 * @file commands.h
 * The subcommands, one file each.
 */
#ifndef PBNDS_TOOLS_COMMANDS_H
#define PBNDS_TOOLS_COMMANDS_H

#include "tools/options.h"

extern const struct tool_command tool_render, tool_gbuffer, tool_shade, tool_compare,
    tool_dataset, tool_train, tool_info, tool_check, tool_bench, tool_import,
    tool_export;

#endif /* PBNDS_TOOLS_COMMANDS_H */
