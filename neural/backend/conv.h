/**
 * @file conv.h
 * What every backend needs to know of a convolution: its check, its output size, and
 * the 2x2 stride-2 transposed one seen as a 1x1 convolution to 4 C channels followed by
 * depth to space. Tap (ky, kx) of output channel o is channel (2 ky + kx) C + o of that
 * 1x1, so one input pixel gives two runs of 2 C elements, each contiguous in its output
 * row.
 */
#ifndef PBNDS_NEURAL_BACKEND_CONV_H
#define PBNDS_NEURAL_BACKEND_CONV_H

#include "neural/backend/backend.h"

#ifdef __cplusplus
extern "C" {
#endif

/** ARGUMENT when `c` is outside of what backend.h promises. */
enum pbnds_status pbnds_conv_check(const struct pbnds_conv *c,
                                   struct pbnds_error *error) PBNDS_NODISCARD;
int pbnds_conv_out_h(const struct pbnds_conv *c);
int pbnds_conv_out_w(const struct pbnds_conv *c);
/** Zero rows and columns above and to the left of the input. */
int pbnds_conv_pad(const struct pbnds_conv *c);
size_t pbnds_conv_weight_count(const struct pbnds_conv *c);

/** The 1x1 convolution of a transposed one. */
struct pbnds_conv pbnds_conv_up_as_1x1(const struct pbnds_conv *up);
/** weight iohw -> the 1x1's oihw; bias repeated for each tap. */
void pbnds_conv_up_weight_to_1x1(const struct pbnds_conv *up, const float *weight,
                                 float *out);
void pbnds_conv_up_bias_to_1x1(const struct pbnds_conv *up, const float *bias,
                               float *out);
/** The adjoints: adds the 1x1's gradients to the transposed convolution's. */
void pbnds_conv_up_weight_from_1x1(const struct pbnds_conv *up, const float *dw,
                                   float *dweight);
void pbnds_conv_up_bias_from_1x1(const struct pbnds_conv *up, const float *db,
                                 float *dbias);
/** [n, h, w, 4 C] -> [n, 2 h, 2 w, C] and back. */
void pbnds_conv_depth_to_space(const struct pbnds_conv *up, const void *deep,
                               void *wide);
void pbnds_conv_space_to_depth(const struct pbnds_conv *up, const void *wide,
                               void *deep);
/** Sums dy over pixels: db[o] += sum_p dy[p, o]. The order of the additions does not
 *  depend on the number of threads. */
enum pbnds_status pbnds_conv_bias_gradient(const void *dy, enum pbnds_dtype dtype,
                                           size_t pixels, int channels, float *dbias,
                                           struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_BACKEND_CONV_H */
