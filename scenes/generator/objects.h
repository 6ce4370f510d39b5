/**
 * @file objects.h
 * Random objects of about unit size, each one or several parts.
 */
#ifndef PBNDS_SCENES_OBJECTS_H
#define PBNDS_SCENES_OBJECTS_H

#include "scenes/generator/material.h"
#include "scenes/generator/sdf.h"

/** What a builder needs. */
struct gen_maker {
    struct gen_world *world;
    struct pbnds_rng *rng;
    float detail;     /**< 1: a hero that fills the picture; less: one of many */
    int texture_size; /**< pixels */
};

/** Segments around for a smooth outline at this level of detail. */
int gen_segments(const struct gen_maker *k, int at_full_detail);
/** A new random material of the kind. */
int gen_make_material(const struct gen_maker *k, enum gen_surface kind);

/** One object of any kind. @return its index */
int gen_random_object(const struct gen_maker *k);
/** One object that makes a picture by itself: head, helmet, figure, machine, ... */
int gen_random_hero(const struct gen_maker *k);

/* objects_basic.c: a solid of revolution, box, ..., possibly displaced or bent */
void gen_build_basic(const struct gen_maker *k);
void gen_build_vase(const struct gen_maker *k);
void gen_build_rock(const struct gen_maker *k);
/* objects_form.c, objects_head.c, objects_living.c: implicit surfaces */
/** Meshes an implicit surface into the object opened last. */
void gen_form_part(const struct gen_maker *k, const struct gen_sdf *s, int cells,
                   int material);
/** The head of mean proportions, about 1.2 high, looking along +z. */
void gen_mean_head(struct gen_sdf *s);
void gen_build_blob(const struct gen_maker *k);
void gen_build_symmetric(const struct gen_maker *k);
void gen_build_carved(const struct gen_maker *k);
void gen_build_head(const struct gen_maker *k);
void gen_build_helmet(const struct gen_maker *k);
void gen_build_figure(const struct gen_maker *k);
/* objects_prop.c: things made of several parts */
void gen_build_cloth(const struct gen_maker *k);
void gen_build_tablecloth(const struct gen_maker *k);
void gen_build_stairs(const struct gen_maker *k);
void gen_build_arch(const struct gen_maker *k);
void gen_build_column(const struct gen_maker *k);
void gen_build_clutter(const struct gen_maker *k);
void gen_build_table(const struct gen_maker *k);
void gen_build_tuft(const struct gen_maker *k);
void gen_build_lattice(const struct gen_maker *k);
void gen_build_machine(const struct gen_maker *k);
/* objects_wire.c: thin and swept */
void gen_build_wire(const struct gen_maker *k);
void gen_build_cage(const struct gen_maker *k);
void gen_build_chain(const struct gen_maker *k);
void gen_build_rope(const struct gen_maker *k);
void gen_build_tree(const struct gen_maker *k);
/* objects_cut.c: extruded */
void gen_build_plate(const struct gen_maker *k);
void gen_build_wheel(const struct gen_maker *k);
void gen_build_pixels(const struct gen_maker *k);
void gen_build_frame(const struct gen_maker *k);
void gen_build_relief(const struct gen_maker *k);
/* objects_built.c: put together on purpose */
void gen_build_building(const struct gen_maker *k);
void gen_build_vehicle(const struct gen_maker *k);
void gen_build_seat(const struct gen_maker *k);
/* objects_ware.c: of the household */
void gen_build_cup(const struct gen_maker *k);
void gen_build_pot(const struct gen_maker *k);
void gen_build_bottle(const struct gen_maker *k);
void gen_build_lamp(const struct gen_maker *k);
void gen_build_candles(const struct gen_maker *k);
void gen_build_fruit(const struct gen_maker *k);
void gen_build_bolt(const struct gen_maker *k);
void gen_build_book(const struct gen_maker *k);
void gen_build_discs(const struct gen_maker *k);
void gen_build_mushroom(const struct gen_maker *k);

#endif /* PBNDS_SCENES_OBJECTS_H */
