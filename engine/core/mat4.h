/**
 * @file mat4.h
 * 4x4 matrices, column-major as in glTF: m[4 * column + row]; points are columns, M p.
 */
#ifndef PBNDS_ENGINE_CORE_MAT4_H
#define PBNDS_ENGINE_CORE_MAT4_H

#include <stdbool.h>

#include "engine/core/vec.h"

struct pbnds_mat4 {
    float m[16];
};

#ifdef __cplusplus
extern "C" {
#endif

struct pbnds_mat4 pbnds_mat4_identity(void);
struct pbnds_mat4 pbnds_mat4_mul(const struct pbnds_mat4 *a, const struct pbnds_mat4 *b);
/** Translation, unit quaternion rotation (x, y, z, w) and scale, as a glTF node. */
struct pbnds_mat4 pbnds_mat4_from_trs(struct pbnds_vec3 t, struct pbnds_vec4 q,
                                      struct pbnds_vec3 s);
/** Camera-to-world: the camera sits at eye and looks along -z at target. */
struct pbnds_mat4 pbnds_mat4_look_at(struct pbnds_vec3 eye, struct pbnds_vec3 target,
                                     struct pbnds_vec3 up);
/** @return false when the matrix is singular; then *out is untouched */
bool pbnds_mat4_inverse(const struct pbnds_mat4 *a, struct pbnds_mat4 *out);
/** Determinant of the upper left 3x3: negative where the transform mirrors. */
float pbnds_mat4_det3(const struct pbnds_mat4 *a);
struct pbnds_vec3 pbnds_mat4_point(const struct pbnds_mat4 *a, struct pbnds_vec3 p);
struct pbnds_vec3 pbnds_mat4_vector(const struct pbnds_mat4 *a, struct pbnds_vec3 v);
/** Cofactor matrix times n: transforms normals, any scale; not normalised. */
struct pbnds_vec3 pbnds_mat4_normal(const struct pbnds_mat4 *a, struct pbnds_vec3 n);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_CORE_MAT4_H */
