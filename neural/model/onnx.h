/**
 * @file onnx.h
 * A network as an ONNX model (https://onnx.ai, IR version 7, opset 13), for runtimes that
 * know nothing of pbnds. One view, float32, NCHW where the rest of pbnds is NHWC:
 *
 *     view_input   [1, C, h, w]    light_input  [N, C', h, w]     h, w, N free
 *     light_output [N, K, h, w]    view_output  [1, K', h, w]     where the table has them
 *
 * An output below full resolution has its shape divided ("h/2"). h and w are multiples of
 * 1 << pbnds_net_deepest_level(), as everywhere: who has another size repeats the border.
 * The numbers are those of a float32 net without training: dropout is the identity.
 */
#ifndef PBNDS_NEURAL_MODEL_ONNX_H
#define PBNDS_NEURAL_MODEL_ONNX_H

#include "neural/model/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The parameters are the net's as they are now; the metadata become metadata_props.
 * Atomic. Errors: IO, MEMORY. */
enum pbnds_status pbnds_onnx_write(const char *path, const struct pbnds_model *model,
                                   const struct pbnds_net *net,
                                   const struct pbnds_metadata *metadata, int count,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_MODEL_ONNX_H */
