/**
 * @file draw_probe.h
 * A small picture that judges a camera: 32 rows of rays, first hits only.
 */
#ifndef PBNDS_NEURAL_DATA_DRAW_PROBE_H
#define PBNDS_NEURAL_DATA_DRAW_PROBE_H

#include "engine/scene/camera.h"
#include "neural/data/draw_subject.h"

/** Shares are of the picture's pixels, or of those at its edge; depths are distances
 *  along the rays, metres. */
struct pbnds_probe {
    float covered;           /**< something is hit                                  */
    float back;              /**< it is the back of a face                          */
    float subject;           /**< it is what the picture is about                   */
    float subject_at_edge;   /**< of the pixels at the edge                         */
    float nearest, farthest; /**< of hits; INFINITY and 0 where there are none      */
    float centre;            /**< of the ray through the middle, INFINITY: nothing  */
    bool flat;               /**< all faces look the same way                       */
    float open;              /**< share of the rays that leave what is hit, cosine
                                  distributed, that reach the sky or a lamp         */
};

/** `object` is what the picture is about; UINT32_MAX: all but backdrops. */
void pbnds_probe(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                 const struct pbnds_subjects *subjects,
                 const struct pbnds_camera *camera, uint32_t object, float aspect,
                 struct pbnds_probe *probe);

#endif /* PBNDS_NEURAL_DATA_DRAW_PROBE_H */
