/**
 * @file path_blocks.h
 * Samples in blocks, and the variance of their mean; what they are for stands in
 * pathtrace.h.
 */
#ifndef PBNDS_ENGINE_SHADE_PATH_BLOCKS_H
#define PBNDS_ENGINE_SHADE_PATH_BLOCKS_H

enum {
    PBNDS_PATH_BLOCKS = 8,         /**< there are at least so many      */
    PBNDS_PATH_LARGEST_BLOCK = 32, /**< of at most so many samples each */
};

/** Samples of a block: the greatest power of two that the above allow. */
static inline int pbnds_path_block_size(int spp)
{
    int block = 1;
    while (block < PBNDS_PATH_LARGEST_BLOCK && 2 * block * PBNDS_PATH_BLOCKS <= spp)
        block *= 2;
    return block;
}

/** Adds a block of `count` samples, their sums, to the spread about the mean, sum_b n_b (m_b
 *  - m)^2, in one pass (West 1979): `before` samples of sum `sum` came earlier. */
static inline void pbnds_path_add_spread(float *spread, const float *sum,
                                         const float block[3], int before, int count)
{
    if (before == 0) return;
    for (int c = 0; c < 3; ++c) {
        const float d = block[c] / (float)count - sum[c] / (float)before;
        spread[c] += d * d * ((float)before * (float)count / (float)(before + count));
    }
}

/** n > 1 samples in blocks of `block`: the factor from spread to variance of the mean. */
static inline double pbnds_path_variance_scale(int n, int block)
{
    const int blocks = (n + block - 1) / block;
    return 1.0 / ((double)(blocks - 1) * (double)n);
}

#endif /* PBNDS_ENGINE_SHADE_PATH_BLOCKS_H */
