/* libFuzzer target: any bytes as a .glb or .gltf that may open no file. Whatever loads
 * must be sound: indices in range, vertices finite. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "engine/scene/gltf.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(const struct pbnds_scene *scene)
{
    for (int i = 0; i < scene->mesh_count; ++i) {
        const struct pbnds_mesh *m = &scene->meshes[i];
        if (m->material < 0 || m->material >= scene->material_count) abort();
        for (size_t k = 0; k < 3 * m->triangle_count; ++k) {
            if (m->index[k] >= m->vertex_count) abort();
        }
        for (size_t k = 0; k < m->vertex_count; ++k) {
            const struct pbnds_vec3 p = m->position[k];
            if (!isfinite(p.x) || !isfinite(p.y) || !isfinite(p.z)) abort();
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pbnds_scene scene;
    struct pbnds_error error;
    if (pbnds_gltf_load_memory(data, size, "fuzz", NULL, NULL, NULL, &scene, &error) ==
        PBNDS_OK) {
        check(&scene);
    }
    pbnds_scene_free(&scene);
    return 0;
}
