/** Training samples made in memory, of a scene that no symmetry spares. */
#ifndef PBNDS_TESTS_NEURAL_TRAIN_FIXTURE_ITEM_H
#define PBNDS_TESTS_NEURAL_TRAIN_FIXTURE_ITEM_H

#include "tests/neural/fixture.h"

#include "neural/train/item.h"
#include "neural/transport.h"

/** What follows from the view and the lights, and targets far from any prediction, so that
 *  no kink of an L1 is near. Takes the envmap. */
static inline struct pbnds_train_item
fixture_item_of(const struct pbnds_gbuffer *g, struct pbnds_envmap *envmap,
                const struct pbnds_env_light *lights, int light_count)
{
    struct pbnds_train_item item = {
        .loaded = true, .envmap = envmap, .light_count = light_count};
    assert_int_equal(pbnds_view_create(g, &item.view, NULL), PBNDS_OK);
    memcpy(item.lights, lights, sizeof item.lights);
    const size_t count = (size_t)g->width * (size_t)g->height;
    item.radiance = calloc(3 * count, sizeof(float));
    item.direct = calloc(3 * count, sizeof(float));
    item.specular = calloc(3 * count, sizeof(float));
    item.visibility = calloc(count, sizeof(uint32_t));
    item.march.thin = calloc(count, sizeof(uint32_t));
    item.march.thick = calloc(count, sizeof(uint32_t));
    struct pbnds_vec3 wi[PBNDS_DATASET_LIGHTS];
    for (int k = 0; k < PBNDS_DATASET_LIGHTS; ++k)
        wi[k] = item.lights[k].wi;
    pbnds_view_march(&item.view, wi, PBNDS_DATASET_LIGHTS, &item.march);
    struct pbnds_rng rng = pbnds_rng_make(3, 0, 0);
    for (size_t i = 0; i < count; ++i) {
        item.visibility[i] = (uint32_t)pbnds_rng_u64(&rng);
        const struct pbnds_transport_pixel p = pbnds_transport_pixel(&item.view, i);
        const struct pbnds_vec3 s =
            pbnds_transport_specular(&p, &item.view, item.envmap);
        item.specular[3 * i] = s.x;
        item.specular[3 * i + 1] = s.y;
        item.specular[3 * i + 2] = s.z;
        for (size_t c = 0; c < 3; ++c) {
            item.direct[3 * i + c] = i % 2 ? 40.0f : 0.0f;
            item.radiance[3 * i + c] = i % 2 ? 90.0f : 0.5f;
        }
    }
    return item;
}

static inline struct pbnds_train_item fixture_item(int size)
{
    struct pbnds_gbuffer g = fixture_walls(size, size);
    struct pbnds_envmap *envmap = fixture_env(1.0f, 11);
    struct pbnds_env_light lights[PBNDS_DATASET_LIGHTS] = {{.wi = {0.0f, 1.0f, 0.0f}}};
    const int count = pbnds_envmap_cluster(envmap, PBNDS_DATASET_LIGHTS, lights);
    const struct pbnds_train_item item = fixture_item_of(&g, envmap, lights, count);
    pbnds_gbuffer_free(&g);
    return item;
}
#endif /* PBNDS_TESTS_NEURAL_TRAIN_FIXTURE_ITEM_H */
