/**
 * @file shader.h
 * The shading-pass table: what turns a G-buffer and a light map into radiance. Dispatched
 * once an image, not a pixel, because a network needs neighbours.
 *
 * Coverage. A shader gives the radiance of the part of a pixel that something covers. The
 * pixel before light L_b is c radiance + (1 - c) L_b, with c the G-buffer's coverage, or
 * the shader's own where it gave one (job.alpha): the reference does where it casts its own
 * camera rays, through transparent layers or anti-aliased, since the G-buffer's transparency
 * policy and its samples may differ. c radiance is unbiased then, radiance alone is its
 * quotient with c.
 */
#ifndef PBNDS_ENGINE_SHADE_SHADER_H
#define PBNDS_ENGINE_SHADE_SHADER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/report.h"
#include "engine/image/image.h"
#include "engine/scene/envmap.h"
#include "engine/shade/gbuffer.h"

/** One shading job. Everything is borrowed and must not be changed by the shader. */
struct pbnds_shade_job {
    const struct pbnds_gbuffer *gbuffer;
    const struct pbnds_envmap
        *envmap; /**< NULL: no light from outside (black)            */
    const struct pbnds_scene
        *scene; /**< NULL for a G-buffer that came from a file      */
    const struct pbnds_accel
        *accel; /**< NULL with it                                   */
    uint64_t seed;
    int spp;     /**< samples a pixel for stochastic shaders; 0: the shader's default */
    int lights;  /**< light directions for shaders that use a set; 0: their default   */
    int shadows; /**< ray-traced visibility: 1 on, 0 off, -1 the shader's default;
                            needs the scene, else off                                      */
    float noise; /**< reference: stop when the relative standard error of the picture
                            is below this (pathtrace.h); 0: at spp                        */
    struct pbnds_image
        *variance; /**< reference: where to put the variance of the mean of each pixel
                            and channel (pathtrace.h), allocated there; NULL: not wanted   */
    struct pbnds_image
        *alpha; /**< where a shader that finds its own coverage puts it, one channel,
                            allocated there (else left empty); NULL: not wanted            */
    int *taken; /**< reference: where to put the samples a pixel taken; or NULL      */
    size_t
        max_memory; /**< bytes of working memory to stay within where possible; 0: none  */
    const struct pbnds_report *report; /**< or NULL */
};

struct pbnds_shader;

/** What a shading model supplies. One static const table a model. */
struct pbnds_shader_ops {
    const char *name; /**< the word on the command line: "ggx", "neural"              */
    unsigned
        channels;     /**< G-buffer channels it reads, PBNDS_CHANNEL_* bits           */
    bool needs_scene; /**< true: cannot shade a G-buffer without its scene            */
    const char
        *about; /**< one line for --help                                        */

    /** Fills `radiance` (already width x height x 3, zeroed; W m^-2 sr^-1, linear Rec. 709)
     *  for every covered pixel (by job->alpha where it gives that); others stay 0. Emission is included. Must not
     *  change the job. The classical passes hold no state and may be shared by threads;
     *  a shader with buffers of its own says so where it is made. */
    enum pbnds_status (*shade)(const struct pbnds_shader *self,
                               const struct pbnds_shade_job *job,
                               struct pbnds_image *radiance, struct pbnds_error *error);
    void (*destroy)(
        struct pbnds_shader *self); /**< NULL when there is nothing to free   */
};

/** Base of every shading model: the first member of its own struct. */
struct pbnds_shader {
    const struct pbnds_shader_ops *ops;
};

#ifdef __cplusplus
extern "C" {
#endif

/** The classical passes: blinn-phong, ggx, paper-blinn-phong, paper-ggx, reference. They
 *  hold no state and live for ever. NULL when the name is none of them. */
const struct pbnds_shader *pbnds_shader_find(const char *name);
/** i-th of them, NULL past the end. */
const struct pbnds_shader *pbnds_shader_at(int i);

/** Checks the job against the table's needs (ARGUMENT), allocates `radiance`, shades. */
enum pbnds_status pbnds_shade(const struct pbnds_shader *shader,
                              const struct pbnds_shade_job *job,
                              struct pbnds_image *radiance,
                              struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_SHADER_H */
