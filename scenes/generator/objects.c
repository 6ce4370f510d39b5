#include "scenes/generator/objects.h"

int gen_segments(const struct gen_maker *k, int at_full_detail)
{
    const int n = (int)((float)at_full_detail * k->detail + 0.5f);
    return n < 12 ? 12 : n;
}

int gen_make_material(const struct gen_maker *k, enum gen_surface kind)
{
    return gen_random_material(k->world, k->rng, kind, k->texture_size);
}

/* How often a kind is met among many, and alone. */
struct choice {
    float crowd, hero;
    const char *name;
    void (*build)(const struct gen_maker *k);
};

static const struct choice CHOICES[] = {
    {4.0f, 0.8f, "basic", gen_build_basic},
    {1.2f, 0.7f, "vase", gen_build_vase},
    {1.1f, 0.8f, "rock", gen_build_rock},
    {0.8f, 0.8f, "blob", gen_build_blob},
    {0.7f, 1.0f, "symmetric", gen_build_symmetric},
    {0.7f, 0.9f, "carved", gen_build_carved},
    {1.3f, 10.0f, "head", gen_build_head},
    {0.3f, 1.4f, "helmet", gen_build_helmet},
    {0.6f, 1.2f, "figure", gen_build_figure},
    {0.4f, 0.6f, "cloth", gen_build_cloth},
    {0.4f, 0.5f, "tablecloth", gen_build_tablecloth},
    {0.3f, 0.4f, "stairs", gen_build_stairs},
    {0.3f, 0.3f, "arch", gen_build_arch},
    {0.3f, 0.4f, "column", gen_build_column},
    {0.7f, 0.5f, "clutter", gen_build_clutter},
    {0.5f, 0.5f, "table", gen_build_table},
    {0.5f, 0.6f, "tuft", gen_build_tuft},
    {0.3f, 0.3f, "lattice", gen_build_lattice},
    {0.7f, 1.2f, "machine", gen_build_machine},
    {0.8f, 0.8f, "wire", gen_build_wire},
    {0.5f, 0.5f, "cage", gen_build_cage},
    {0.4f, 0.4f, "chain", gen_build_chain},
    {0.4f, 0.4f, "rope", gen_build_rope},
    {0.6f, 0.8f, "tree", gen_build_tree},
    {1.2f, 1.2f, "plate", gen_build_plate},
    {0.6f, 0.5f, "wheel", gen_build_wheel},
    {0.5f, 0.4f, "pixels", gen_build_pixels},
    {0.4f, 0.3f, "frame", gen_build_frame},
    {0.2f, 0.6f, "relief", gen_build_relief},
    {0.7f, 0.7f, "building", gen_build_building},
    {0.7f, 0.9f, "vehicle", gen_build_vehicle},
    {0.6f, 0.6f, "seat", gen_build_seat},
    {0.8f, 0.6f, "cup", gen_build_cup},
    {0.5f, 0.7f, "pot", gen_build_pot},
    {0.8f, 0.5f, "bottle", gen_build_bottle},
    {0.5f, 0.4f, "lamp", gen_build_lamp},
    {0.3f, 0.3f, "candles", gen_build_candles},
    {0.8f, 0.7f, "fruit", gen_build_fruit},
    {0.5f, 0.4f, "bolt", gen_build_bolt},
    {0.4f, 0.2f, "book", gen_build_book},
    {0.5f, 0.3f, "discs", gen_build_discs},
    {0.5f, 0.4f, "mushroom", gen_build_mushroom},
};

enum { KINDS = (int)(sizeof CHOICES / sizeof CHOICES[0]) };

static int build_one(const struct gen_maker *k, bool hero)
{
    float weights[KINDS];
    for (int i = 0; i < KINDS; ++i)
        weights[i] = hero ? CHOICES[i].hero : CHOICES[i].crowd;
    const struct choice *c = &CHOICES[gen_pick(k->rng, weights, KINDS)];
    const int object = gen_object_begin(k->world);
    gen_object_name(k->world, c->name);
    c->build(k);
    return object;
}

int gen_random_object(const struct gen_maker *k)
{
    return build_one(k, false);
}

int gen_random_hero(const struct gen_maker *k)
{
    return build_one(k, true);
}
