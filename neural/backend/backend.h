/**
 * @file backend.h
 * The small op interface that a device implements: convolutions forward and backward on
 * NHWC tensors. reference.c is the naive twin for tests; dnn.c is oneDNN and the
 * only file that includes it; another device is one more file.
 *
 * Element type: float32, or bfloat16 for activations and their gradients (round to
 * nearest even). Weights, biases and their gradients are always float32 at this
 * interface; the backend makes and caches the bf16 or blocked copies it wants.
 * Accumulation is float32.
 */
#ifndef PBNDS_NEURAL_BACKEND_BACKEND_H
#define PBNDS_NEURAL_BACKEND_BACKEND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

enum pbnds_dtype { PBNDS_F32, PBNDS_BF16 };

/** A convolution, cross-correlation as everywhere in the field, zero padding
 *  (kernel - 1) / 2 on the top and left for odd kernels, none for kernel 2:
 *      y[n, oy, ox, o] = act(b[o] + sum_{i,ky,kx} w[o, i, ky, kx] x[n, oy s + ky - p, ox s + kx - p, i])
 *  or, transposed (kernel 2, stride 2 only),
 *      y[n, 2 y + ky, 2 x + kx, o] = act(b[o] + sum_i w[i, o, ky, kx] x[n, y, x, i]). */
struct pbnds_conv {
    int n, h, w;            /**< input batch and size                             */
    int in, out;            /**< channels                                         */
    int kernel;             /**< 1, 2 or 3                                        */
    int stride;             /**< 1, or 2 (kernels 2 and 3; h and w even)          */
    bool transposed;        /**< weight is iohw then, oihw otherwise (as torch)   */
    bool relu;              /**< act is max(0, .), fused; backward takes dy already
                          masked by the caller                              */
    enum pbnds_dtype dtype; /**< of x, y, dx, dy                           */
};

struct pbnds_backend;

struct pbnds_backend_ops {
    const char *name; /**< "onednn", "reference" */
    enum pbnds_status (*conv_forward)(struct pbnds_backend *b,
                                      const struct pbnds_conv *c, const void *x,
                                      const float *weight, const float *bias, void *y,
                                      struct pbnds_error *error);
    /** dx = dL/dx (overwritten). */
    enum pbnds_status (*conv_backward_data)(struct pbnds_backend *b,
                                            const struct pbnds_conv *c, const void *dy,
                                            const float *weight, void *dx,
                                            struct pbnds_error *error);
    /** dweight += dL/dw, dbias += dL/db. */
    enum pbnds_status (*conv_backward_weights)(struct pbnds_backend *b,
                                               const struct pbnds_conv *c,
                                               const void *x, const void *dy,
                                               float *dweight, float *dbias,
                                               struct pbnds_error *error);
    /** Weights changed in place (an optimiser step): drop cached copies of them. */
    void (*weights_changed)(struct pbnds_backend *b);
    void (*destroy)(struct pbnds_backend *b);
};

/** Base of every backend: the first member of its own struct. Not thread-safe: one caller
 *  at a time (it is parallel inside, with pbnds_threads() threads at creation). */
struct pbnds_backend {
    const struct pbnds_backend_ops *ops;
};

#ifdef __cplusplus
extern "C" {
#endif

enum pbnds_status
pbnds_backend_create_onednn(struct pbnds_backend **backend,
                            struct pbnds_error *error) PBNDS_NODISCARD;
enum pbnds_status
pbnds_backend_create_reference(struct pbnds_backend **backend,
                               struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_backend_free(struct pbnds_backend *backend);
/** Is bf16 faster than f32 here (AMX)? */
bool pbnds_backend_has_fast_bf16(void);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_BACKEND_BACKEND_H */
