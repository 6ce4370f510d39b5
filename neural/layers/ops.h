/**
 * @file ops.h
 * The elementwise kernels of a network, forward and adjoint, on NHWC tensors of either
 * element type. Each result is a pure function of its arguments at any thread count:
 * sums have a fixed order and are made in float32.
 *
 * Broadcasting over lights: image k of the result reads image k / repeat of the
 * operand, where repeat is N for a view tensor in the light scope and 1 otherwise.
 */
#ifndef PBNDS_NEURAL_LAYERS_OPS_H
#define PBNDS_NEURAL_LAYERS_OPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "neural/backend/backend.h"

/** A batch of images: `images` of h x w pixels with c channels. */
struct pbnds_shape {
    size_t images, h, w, c;
};

static inline size_t pbnds_shape_count(struct pbnds_shape s)
{
    return s.images * s.h * s.w * s.c;
}

#ifdef __cplusplus
extern "C" {
#endif

void pbnds_from_f32(enum pbnds_dtype dtype, const float *from, void *to, size_t count);
void pbnds_to_f32(enum pbnds_dtype dtype, const void *from, float *to, size_t count);

/** y = act(a + b). */
void pbnds_add_forward(enum pbnds_dtype dtype, struct pbnds_shape shape, const void *a,
                       size_t repeat_a, const void *b, size_t repeat_b, bool relu,
                       void *y);
/** y += x */
void pbnds_accumulate(enum pbnds_dtype dtype, const void *x, void *y, size_t count);
/** y += x, x float32 */
void pbnds_accumulate_f32(enum pbnds_dtype dtype, const float *x, void *y,
                          size_t count);
/** dy = y > 0 ? dy : 0 */
void pbnds_relu_mask(enum pbnds_dtype dtype, const void *y, void *dy, size_t count);

/** Copies the channels of `part` (part.c of them, starting at `at`) into or out of the
 *  pixels of whole (whole_c channels). */
void pbnds_channels_insert(enum pbnds_dtype dtype, struct pbnds_shape part,
                           const void *from, size_t repeat, void *whole, size_t whole_c,
                           size_t at);
void pbnds_channels_extract(enum pbnds_dtype dtype, struct pbnds_shape part,
                            const void *whole, size_t whole_c, size_t at, void *to);
/** The adjoint of a broadcast: to[b] (+)= sum_i whole[b N + i], over the channels of
 * `part` starting at `at`; part.images is the number of views. */
void pbnds_sum_lights(enum pbnds_dtype dtype, struct pbnds_shape part, size_t lights,
                      const void *whole, size_t whole_c, size_t at, float *to,
                      bool add);

/** `in` is the shape of the deeper tensor: out[2y+dy, 2x+dx, c] = in[y, x, 4c+2dy+dx].
 */
void pbnds_shuffle_forward(enum pbnds_dtype dtype, struct pbnds_shape in, const void *x,
                           void *y);
void pbnds_shuffle_backward(enum pbnds_dtype dtype, struct pbnds_shape in,
                            const void *dy, void *dx);
/** `out` is the shape of the smaller tensor. */
void pbnds_pool_forward(enum pbnds_dtype dtype, struct pbnds_shape out, const void *x,
                        void *y);
void pbnds_pool_backward(enum pbnds_dtype dtype, struct pbnds_shape out, const void *dy,
                         void *dx);
/** y = x / (1 - rate) where kept, else 0. Its own adjoint. Element i is kept when the
 *  uniform number of (key, i) is not below rate. */
void pbnds_dropout(enum pbnds_dtype dtype, size_t count, uint64_t key, float rate,
                   const void *x, void *y);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_LAYERS_OPS_H */
