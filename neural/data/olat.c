#include "neural/data/olat.h"

#include <math.h>
#include <stdbool.h>

#include "neural/data/targets.h"

static const float APART = 0.98480775f; /* cos 10 degrees */

static bool is_apart(const struct pbnds_vec3 *taken, int count, struct pbnds_vec3 wi)
{
    for (int i = 0; i < count; ++i)
        if (pbnds_dot(taken[i], wi) > APART) return false;
    return true;
}

/* The brightest light left that is apart from those taken; -1: none. The first of equals. */
static int brightest(const struct pbnds_env_light *lights, int count,
                     const struct pbnds_vec3 *taken, int taken_count)
{
    int found = -1;
    float most = 0.0f;
    for (int i = 0; i < count; ++i) {
        const float power = pbnds_luminance(lights[i].power);
        if (power > most && is_apart(taken, taken_count, lights[i].wi)) {
            most = power;
            found = i;
        }
    }
    return found;
}

static int take_from_map(const struct pbnds_envmap *envmap, int count,
                         struct pbnds_vec3 *wi)
{
    struct pbnds_env_light lights[PBNDS_DATASET_LIGHTS];
    const int clusters = pbnds_envmap_cluster(envmap, PBNDS_DATASET_LIGHTS, lights);
    int taken = 0;
    while (taken < count) {
        const int i = brightest(lights, clusters, wi, taken);
        if (i < 0) break;
        wi[taken++] = lights[i].wi;
    }
    return taken;
}

/* A uniform rotation as the images of the axes. */
static void random_rotation(struct pbnds_rng *rng, struct pbnds_vec3 axes[3])
{
    const float u = pbnds_rng_float(rng);
    const float a = 2.0f * PBNDS_PI * pbnds_rng_float(rng);
    const float b = 2.0f * PBNDS_PI * pbnds_rng_float(rng);
    const float r = sqrtf(1.0f - u), s = sqrtf(u);
    const float x = r * sinf(a), y = r * cosf(a), z = s * sinf(b), w = s * cosf(b);
    axes[0] = pbnds_vec3_make(1.0f - 2.0f * (y * y + z * z), 2.0f * (x * y + z * w),
                              2.0f * (x * z - y * w));
    axes[1] = pbnds_vec3_make(2.0f * (x * y - z * w), 1.0f - 2.0f * (x * x + z * z),
                              2.0f * (y * z + x * w));
    axes[2] = pbnds_vec3_make(2.0f * (x * z + y * w), 2.0f * (y * z - x * w),
                              1.0f - 2.0f * (x * x + y * y));
}

static void spread(int count, struct pbnds_rng *rng, struct pbnds_vec3 *wi)
{
    struct pbnds_vec3 axes[3];
    random_rotation(rng, axes);
    for (int i = 0; i < count; ++i) {
        const float z = 1.0f - (float)(2 * i + 1) / (float)count;
        const float phi = (float)i * PBNDS_PI * (3.0f - sqrtf(5.0f));
        const float r = sqrtf(1.0f - z * z);
        const struct pbnds_vec3 w = pbnds_mad(
            pbnds_mad(pbnds_scale(axes[0], r * cosf(phi)), axes[1], r * sinf(phi)),
            axes[2], z);
        wi[i] = pbnds_normalize(w);
    }
}

int pbnds_olat_choose(const struct pbnds_envmap *envmap, int count,
                      struct pbnds_rng *rng, struct pbnds_vec3 *wi)
{
    const int taken = take_from_map(envmap, count / 2, wi);
    spread(count - taken, rng, wi + taken);
    return taken;
}
