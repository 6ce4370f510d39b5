/** Scenes of boxes, made by hand, for tests of draws. */
#ifndef PBNDS_TESTS_NEURAL_FIXTURE_SCENE_H
#define PBNDS_TESTS_NEURAL_FIXTURE_SCENE_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/test.h"

#include "engine/scene/accel.h"
#include "engine/scene/scene.h"

/* Room for a handful of meshes, each an object of its own, and one material. */
static inline void fixture_scene(struct pbnds_scene *scene)
{
    *scene = (struct pbnds_scene){0};
    scene->meshes = calloc(16, sizeof *scene->meshes);
    scene->objects = calloc(16, sizeof *scene->objects);
    scene->materials = calloc(16, sizeof *scene->materials);
    assert_true(scene->meshes && scene->objects && scene->materials);
    scene->materials[0] = pbnds_material_default();
    scene->materials[0].double_sided = true; /* as data sets have them */
    scene->material_count = 1;
    scene->lo = pbnds_splat(INFINITY);
    scene->hi = pbnds_splat(-INFINITY);
}

/* Corner i of a box: bits 0, 1, 2 choose x, y, z. Faces outward, or inward. */
static inline void fixture_box(struct pbnds_scene *scene, struct pbnds_vec3 lo,
                               struct pbnds_vec3 hi, bool inward)
{
    static const uint32_t FACES[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5,
                                       0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3,
                                       0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    struct pbnds_mesh *m = &scene->meshes[scene->mesh_count];
    m->vertex_count = 8;
    m->triangle_count = 12;
    m->position = calloc(8, sizeof *m->position);
    m->index = calloc(36, sizeof *m->index);
    assert_true(m->position && m->index);
    for (int i = 0; i < 8; ++i)
        m->position[i] = pbnds_vec3_make(i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y,
                                         i & 4 ? hi.z : lo.z);
    for (int i = 0; i < 36; ++i)
        m->index[i] = FACES[inward ? 3 * (i / 3) + 2 - i % 3 : i];
    m->object_id = (uint32_t)scene->object_count;
    (void)snprintf(scene->objects[scene->object_count].name, 64, "box %d",
                   scene->object_count);
    ++scene->mesh_count;
    ++scene->object_count;
    scene->triangle_count += 12;
    scene->lo = pbnds_vec3_make(fminf(scene->lo.x, lo.x), fminf(scene->lo.y, lo.y),
                                fminf(scene->lo.z, lo.z));
    scene->hi = pbnds_vec3_make(fmaxf(scene->hi.x, hi.x), fmaxf(scene->hi.y, hi.y),
                                fmaxf(scene->hi.z, hi.z));
}

static inline struct pbnds_accel *fixture_accel(const struct pbnds_scene *scene)
{
    struct pbnds_accel *accel;
    struct pbnds_error error = {{0}};
    if (pbnds_accel_create(scene, &accel, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    return accel;
}
#endif /* PBNDS_TESTS_NEURAL_FIXTURE_SCENE_H */
