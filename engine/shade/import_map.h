/**
 * @file import_map.h
 * One map of a material or a photograph as its file stores it. Not for shaders.
 */
#ifndef PBNDS_ENGINE_SHADE_IMPORT_MAP_H
#define PBNDS_ENGINE_SHADE_IMPORT_MAP_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/error.h"
#include "engine/core/vec.h"

/** Four floats a pixel, grey replicated, alpha 1 where the file has none. */
struct pbnds_import_map {
    int width, height;
    float *rgba;  /**< owned; NULL: there is none                                    */
    bool integer; /**< 8 or 16 bit: display-encoded where it is a colour, [0, 1]     */
    int bits;
};

#ifdef __cplusplus
extern "C" {
#endif

/** OpenEXR by its channels (R, G, B, else X, Y, Z, else the only one), other formats
 *  through oiio.h. Errors: IO, FORMAT, UNSUPPORTED, MEMORY. */
enum pbnds_status pbnds_import_map_load(const char *path, struct pbnds_import_map *map,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_import_map_free(struct pbnds_import_map *map);

/** FORMAT where a number is not finite; `infinity` lets +inf pass. */
enum pbnds_status pbnds_import_map_finite(const struct pbnds_import_map *map,
                                          const char *path, bool infinity,
                                          struct pbnds_error *error) PBNDS_NODISCARD;

/** A colour of a pixel, linear Rec. 709. */
struct pbnds_vec3 pbnds_import_map_color(const struct pbnds_import_map *map, size_t i);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_IMPORT_MAP_H */
