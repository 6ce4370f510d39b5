/**
 * @file light_cache.h
 * Light transport of one view, kept, so that another light map costs one weighted sum.
 *
 * For N fixed directions w_j, spread evenly over the sphere (a Fibonacci lattice about
 * +y), the network's answer for unit irradiance is kept at each covered pixel,
 *
 *     T_j = A(w_j) V_j + B S_j            (transport.h), per channel,
 *
 * in 8 bits, T_j = s (q_j / 255)^2 with s the pixel's greatest T_j. A light map gives each
 * direction the irradiance
 *
 *     E_j = integral of L(w) phi_j(w) dw,   phi_j(w) = g_j(w) / sum_k g_k(w),
 *     g_j(w) = exp(2 N / pi (w.w_j - 1)),
 *
 * a partition of unity that turns smoothly with the map, and R = sum_j E_j T_j + G O +
 * emission. The narrow specular G keeps, for the pixels that have one, where its
 * PBNDS_CACHE_LOOKS widest samples look on the map. Compared with the transport pass, the
 * map's strong lights are moved to the nearest of N directions: shadows and wide
 * highlights of a sun are as sharp as the lattice is dense.
 *
 * A covered pixel takes 3 N + 16 bytes, 40 more where it has a narrow lobe; a relight
 * reads each byte once.
 */
#ifndef PBNDS_NEURAL_LIGHT_CACHE_H
#define PBNDS_NEURAL_LIGHT_CACHE_H

#include "engine/shade/shader.h"

enum {
    PBNDS_CACHE_BLOCK = 64, /**< pixels side by side */
    PBNDS_CACHE_LOOKS = 4,
    PBNDS_CACHE_DIRECTIONS = 64, /**< default */
    PBNDS_CACHE_DIRECTIONS_MAX = 1024,
};

/** The narrow lobe of one pixel: sum of weight L over its looks, times scale. */
struct pbnds_cache_gloss {
    uint32_t pixel;
    float scale[3];
    uint16_t turn[PBNDS_CACHE_LOOKS]; /**< (turn + 1/2) 65536, wrapped */
    uint16_t v[PBNDS_CACHE_LOOKS];    /**< v 65535 */
    uint8_t size[PBNDS_CACHE_LOOKS];  /**< (log2_texel + 22) 10 */
    uint8_t weight[PBNDS_CACHE_LOOKS];
};

struct pbnds_light_cache {
    int width, height, directions;
    uint64_t weights, gbuffer; /**< hashes of what it was made of */
    size_t covered, glossy, blocks;
    uint32_t *pixel;    /**< [blocks, 64]: y * width + x, ascending; behind them none */
    float *scale;       /**< [blocks, 3, 64] */
    uint8_t *transport; /**< [blocks, directions, 3, 64] */
    struct pbnds_cache_gloss *gloss; /**< ascending by pixel */
    uint8_t *storage;                /**< owned: the file's bytes */
    size_t size;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Runs the network of a `transport` shader over the job's G-buffer for that many
 *  directions. Errors: ARGUMENT (another model), MEMORY, BACKEND, INTERRUPTED. */
enum pbnds_status pbnds_light_cache_make(const struct pbnds_shader *shader,
                                         const struct pbnds_shade_job *job,
                                         int directions,
                                         struct pbnds_light_cache *cache,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
void pbnds_light_cache_free(struct pbnds_light_cache *cache);

enum pbnds_status pbnds_light_cache_write(const char *path,
                                          const struct pbnds_light_cache *cache,
                                          struct pbnds_error *error) PBNDS_NODISCARD;
/** Errors: IO, FORMAT (damaged; the sentence says how), MEMORY. */
enum pbnds_status pbnds_light_cache_read(const char *path,
                                         struct pbnds_light_cache *cache,
                                         struct pbnds_error *error) PBNDS_NODISCARD;
/** The same from a file's bytes, malloc'd; the cache owns them from now on, in failure they
 *  are freed. */
enum pbnds_status pbnds_light_cache_parse(const char *name, uint8_t *bytes, size_t size,
                                          struct pbnds_light_cache *cache,
                                          struct pbnds_error *error) PBNDS_NODISCARD;
/** FORMAT where the cache is not of this shader's weights and this G-buffer. */
enum pbnds_status pbnds_light_cache_check(const char *name,
                                          const struct pbnds_light_cache *cache,
                                          const struct pbnds_shader *shader,
                                          const struct pbnds_gbuffer *gbuffer,
                                          struct pbnds_error *error) PBNDS_NODISCARD;

/** Radiance of the view under the job's light map; allocates the image. Bytes of the cache
 *  that it reads: cache->size. Errors: ARGUMENT (a G-buffer of another size), MEMORY. */
enum pbnds_status pbnds_light_cache_shade(const struct pbnds_light_cache *cache,
                                          const struct pbnds_shade_job *job,
                                          struct pbnds_image *radiance,
                                          struct pbnds_error *error) PBNDS_NODISCARD;

/** The irradiance of each direction; the map's integral is kept. NULL: zeros.
 *  Errors: MEMORY. */
enum pbnds_status pbnds_light_cache_project(const struct pbnds_envmap *envmap,
                                            int directions,
                                            struct pbnds_vec3 *irradiance,
                                            struct pbnds_error *error) PBNDS_NODISCARD;
/** w_j, world. */
struct pbnds_vec3 pbnds_light_cache_direction(int j, int directions);

/** Allocates the bytes of a cache whose sizes are set, and points into them. */
enum pbnds_status pbnds_light_cache_allocate(struct pbnds_light_cache *cache,
                                             struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_LIGHT_CACHE_H */
