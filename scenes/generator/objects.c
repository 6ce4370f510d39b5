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

struct choice {
    float weight;
    void (*build)(const struct gen_maker *k);
};

static int build_one(const struct gen_maker *k, const struct choice *choices, int count)
{
    float weights[32];
    for (int i = 0; i < count; ++i)
        weights[i] = choices[i].weight;
    const int object = gen_object_begin(k->world);
    choices[gen_pick(k->rng, weights, count)].build(k);
    return object;
}

int gen_random_object(const struct gen_maker *k)
{
    static const struct choice choices[] = {
        {5.0f, gen_build_basic},      {1.5f, gen_build_vase},
        {1.2f, gen_build_rock},       {0.9f, gen_build_blob},
        {0.7f, gen_build_symmetric},  {0.8f, gen_build_carved},
        {0.6f, gen_build_head},       {0.4f, gen_build_helmet},
        {0.6f, gen_build_figure},     {0.5f, gen_build_cloth},
        {0.5f, gen_build_tablecloth}, {0.4f, gen_build_stairs},
        {0.4f, gen_build_arch},       {0.4f, gen_build_column},
        {1.0f, gen_build_clutter},    {0.6f, gen_build_table},
        {0.6f, gen_build_tuft},       {0.4f, gen_build_lattice},
        {0.8f, gen_build_machine},
    };
    return build_one(k, choices, (int)(sizeof choices / sizeof choices[0]));
}

int gen_random_hero(const struct gen_maker *k)
{
    static const struct choice choices[] = {
        {0.8f, gen_build_basic},      {0.7f, gen_build_vase},
        {0.8f, gen_build_rock},       {0.7f, gen_build_blob},
        {1.3f, gen_build_symmetric},  {1.0f, gen_build_carved},
        {4.0f, gen_build_head},       {1.8f, gen_build_helmet},
        {1.4f, gen_build_figure},     {0.6f, gen_build_cloth},
        {0.4f, gen_build_tablecloth}, {0.4f, gen_build_stairs},
        {0.3f, gen_build_arch},       {0.5f, gen_build_column},
        {0.6f, gen_build_clutter},    {0.4f, gen_build_table},
        {0.7f, gen_build_tuft},       {0.3f, gen_build_lattice},
        {1.6f, gen_build_machine},
    };
    return build_one(k, choices, (int)(sizeof choices / sizeof choices[0]));
}
