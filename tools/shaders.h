/**
 * @file shaders.h
 * Shading passes by the names of the command line, the classical and the neural ones.
 */
#ifndef PBNDS_TOOLS_SHADERS_H
#define PBNDS_TOOLS_SHADERS_H

#include "engine/shade/shader.h"
#include "tools/options.h"

struct tool_shader {
    const struct pbnds_shader *shader;
    bool owned; /**< a neural one, freed with this */
};

/** Is that a name of the table? ARGUMENT with the list of names when it is not; says
 * nothing about weights files. */
enum pbnds_status tool_shader_check(const char *name,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** Opens it; neural ones load their weights. precision: enum tool_precision. */
enum pbnds_status tool_shader_open(const char *name, int precision,
                                   struct tool_shader *shader,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
void tool_shader_close(struct tool_shader *shader);
/** The list for --help on stdout. */
void tool_shaders_help(void);

#endif /* PBNDS_TOOLS_SHADERS_H */
