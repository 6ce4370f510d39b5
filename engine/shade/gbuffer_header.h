/**
 * @file gbuffer_header.h
 * The header attributes of G-buffer files, both ways. Not for shaders.
 *
 * Matrices: OpenEXR multiplies row vectors from the left, p M, and stores rows; ours are
 * M p, stored by columns. The sixteen numbers are the same in both.
 */
#ifndef PBNDS_ENGINE_SHADE_GBUFFER_HEADER_H
#define PBNDS_ENGINE_SHADE_GBUFFER_HEADER_H

#include "engine/shade/gbuffer.h"

enum { PBNDS_HEADER_MAX = 40 };

/** Attributes that are being gathered for a file. Texts are borrowed from the G-buffer. */
struct pbnds_header {
    struct pbnds_exr_attribute items[PBNDS_HEADER_MAX];
    int count;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Everything the contract names; origin NULL: camera, spaces and sampling alone. */
void pbnds_header_describe(struct pbnds_header *header,
                           const struct pbnds_gbuffer *gbuffer,
                           const struct pbnds_gbuffer_origin *origin);

/** The camera of a file, or the default one (gbuffer.h). `path` is for messages.
 *  Errors: FORMAT. */
enum pbnds_status pbnds_header_camera(const struct pbnds_exr *exr, const char *path,
                                      struct pbnds_camera *camera,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

/** Where the file came from. Errors: UNSUPPORTED (a later contract), FORMAT (an unknown
 *  normal space, depth or target). */
enum pbnds_status pbnds_header_origin(const struct pbnds_exr *exr, const char *path,
                                      struct pbnds_gbuffer_origin *origin,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

/** Rays a pixel (1 where the file does not say) and the transparency policy. Errors:
 *  FORMAT. */
enum pbnds_status pbnds_header_sampling(const struct pbnds_exr *exr, const char *path,
                                        int *samples, enum pbnds_through *through,
                                        struct pbnds_error *error) PBNDS_NODISCARD;

/** Value of a string attribute, or `otherwise`. */
const char *pbnds_header_string(const struct pbnds_exr *exr, const char *name,
                                const char *otherwise);

/** The key under which Cryptomatte files its metadata: "cryptomatte/3ae39a5/", the first
 *  seven hex digits of the layer name's hash, and `field`. */
void pbnds_header_matte_key(const char *layer, const char *field, char out[64]);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_GBUFFER_HEADER_H */
