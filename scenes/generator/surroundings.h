/**
 * @file surroundings.h
 * What objects stand on and in: floors, terrain, backdrops, walls with openings, shelves.
 */
#ifndef PBNDS_SCENES_SURROUNDINGS_H
#define PBNDS_SCENES_SURROUNDINGS_H

#include "scenes/generator/objects.h"

enum gen_terrain {
    GEN_HILLS,
    GEN_RIDGES,
    GEN_DUNES,
    GEN_TERRACES,
    GEN_RIPPLES,
    GEN_COBBLES
};

/** A ground and how high it is; `rough` false: flat at 0. */
struct gen_ground {
    float half; /**< metres from the middle to its edge */
    bool rough;
    enum gen_terrain terrain;
    float height, frequency;
    uint32_t seed;
};

float gen_ground_height(const struct gen_ground *g, float x, float z);

/** A floor (square, round, a plinth), a studio's curved backdrop or terrain. */
struct gen_ground gen_random_ground(const struct gen_maker *k, float half);
struct gen_ground gen_random_terrain(const struct gen_maker *k, float half);
/** Floor and one to three walls, which have windows and doors; open to the front, a ceiling
 *  or none. walls: 1 the back, 2 and the left, 3 and the right. */
struct gen_ground gen_random_room(const struct gen_maker *k, float half, int walls);
/** Boards between uprights; the levels of their upper sides into level[]. @return their
 *  number, at most 6 */
int gen_random_shelf(const struct gen_maker *k, float half, float depth, float *level);
/** Posts and a bar at the given height, from which things hang. */
void gen_gallows(const struct gen_maker *k, float half, float height);
/** A thread from `from` straight down to `to`. */
void gen_thread(const struct gen_maker *k, struct pbnds_vec3 from, float to,
                int material);

#endif /* PBNDS_SCENES_SURROUNDINGS_H */
