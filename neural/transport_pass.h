/**
 * @file transport_pass.h
 * The transport network over an image, tile by tile and some lights at a time. What is
 * done with its output is the caller's.
 */
#ifndef PBNDS_NEURAL_TRANSPORT_PASS_H
#define PBNDS_NEURAL_TRANSPORT_PASS_H

#include "neural/shader_neural_impl.h"
#include "neural/tiles.h"
#include "neural/transport.h"

/** A tile and what the network said there. */
struct pbnds_transport_tile {
    struct pbnds_tile at;
    const struct pbnds_view *view;              /**< covers the window */
    const struct pbnds_transport_pixel *pixels; /**< of `at.own`, row-major */
    const float *occlusion; /**< logits, of the window; NULL where it was not run */
    const float *lights;    /**< [count, window, PBNDS_OUT_COUNT] */
    int first, count;       /**< which lights those are */
};

/** Called in order: for each tile its chunks of lights, then its end. */
struct pbnds_transport_pass {
    const struct pbnds_shader_neural *shader;
    const struct pbnds_shade_job *job; /**< its G-buffer, memory and report are used */
    const struct pbnds_vec3 *wi;       /**< unit, world */
    int count;                         /**< 0: the network is not run */
    size_t bytes_a_pixel;              /**< of a window, that the caller takes itself */
    void *context;
    enum pbnds_status (*lights)(void *context, const struct pbnds_transport_tile *tile,
                                struct pbnds_error *error);
    enum pbnds_status (*end)(void *context, const struct pbnds_transport_tile *tile,
                             struct pbnds_error *error);
};

#ifdef __cplusplus
extern "C" {
#endif

/** Errors: MEMORY, BACKEND, INTERRUPTED, and the caller's own. */
enum pbnds_status pbnds_transport_run(const struct pbnds_transport_pass *pass,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

/** Indices of pixel (x, y) of the image: among the own pixels, in the window. */
static inline size_t pbnds_transport_own(const struct pbnds_transport_tile *t, int x,
                                         int y)
{
    return (size_t)(y - t->at.own.y) * (size_t)t->at.own.width +
           (size_t)(x - t->at.own.x);
}
static inline size_t pbnds_transport_in_window(const struct pbnds_transport_tile *t,
                                               int x, int y)
{
    return (size_t)(y - t->at.window.y) * (size_t)t->at.window.width +
           (size_t)(x - t->at.window.x);
}

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_TRANSPORT_PASS_H */
