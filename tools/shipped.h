/**
 * @file shipped.h
 * Finds the scenes and weights that ship with the program.
 */
#ifndef PBNDS_TOOLS_SHIPPED_H
#define PBNDS_TOOLS_SHIPPED_H

#include <stdbool.h>
#include <stddef.h>

/** Looks for `name` ("scenes/sky.hdr", "weights/transport.safetensors") in $PBNDS_DATA,
 * in
 *  ../share/pbnds beside the program, in the source tree it was built from and in the
 *  folder it was configured to be installed in, in this order. When none has it, `path`
 * is where the first would be and the return is false. */
bool tool_shipped(const char *name, char *path, size_t size);

#endif /* PBNDS_TOOLS_SHIPPED_H */
