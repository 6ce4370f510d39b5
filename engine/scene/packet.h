/**
 * @file packet.h
 * Sixteen rays side by side, each quantity in an array of its own (structure of arrays),
 * so that the compiler can work on all of them with vector instructions.
 */
#ifndef PBNDS_ENGINE_SCENE_PACKET_H
#define PBNDS_ENGINE_SCENE_PACKET_H

#include "engine/scene/scene.h"

enum { PBNDS_PACKET = 16 };

/** Vectors are [x, y, z][lane]; directions are unit. */
struct pbnds_ray_packet {
    float origin[3][PBNDS_PACKET], direction[3][PBNDS_PACKET];
};

/** The fields of struct pbnds_hit; mesh is UINT32_MAX in lanes that hit nothing. */
struct pbnds_hit_packet {
    float t[PBNDS_PACKET], u[PBNDS_PACKET], v[PBNDS_PACKET];
    uint32_t mesh[PBNDS_PACKET], triangle[PBNDS_PACKET];
};

/** The fields of struct pbnds_surface. */
struct pbnds_surface_packet {
    float position[3][PBNDS_PACKET], ng[3][PBNDS_PACKET], n[3][PBNDS_PACKET];
    float base_color[3][PBNDS_PACKET], emission[3][PBNDS_PACKET];
    float f0[3][PBNDS_PACKET], f90[PBNDS_PACKET];
    float metallic[PBNDS_PACKET], roughness[PBNDS_PACKET];
    float alpha[PBNDS_PACKET], occlusion[PBNDS_PACKET], uv[2][PBNDS_PACKET];
    uint32_t object_id[PBNDS_PACKET], material[PBNDS_PACKET];
};

#ifdef __cplusplus
extern "C" {
#endif

/** Makes mesh->packed of every mesh that has normals, which packets need to be fast: 48
 *  bytes a vertex. Meshes without, and scenes that were not packed, are looked at lane by
 *  lane. Call it when the meshes are complete. Errors: MEMORY. */
enum pbnds_status pbnds_scene_pack(struct pbnds_scene *scene,
                                   struct pbnds_error *error) PBNDS_NODISCARD;

/** pbnds_scene_surface() of every lane that hit something, wo being -direction; the very
 *  same bits. Lanes that hit nothing are all zero. */
void pbnds_scene_surface_packet(const struct pbnds_scene *scene,
                                const struct pbnds_ray_packet *rays,
                                const struct pbnds_hit_packet *hits,
                                const float footprint[PBNDS_PACKET],
                                struct pbnds_surface_packet *surface);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SCENE_PACKET_H */
