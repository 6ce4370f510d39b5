#include "scenes/generator/layout.h"

#include "scenes/generator/objects.h"
#include "scenes/generator/shapes.h"

static const struct pbnds_vec3 UP = {0.0f, 1.0f, 0.0f};

/* Any turn about y; tilted as well where the thing may lie as it fell. */
static struct pbnds_vec4 random_pose(struct pbnds_rng *r, float tumbled)
{
    const float turn = gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
    if (gen_chance(r, tumbled)) return gen_rotation(r);
    return gen_turn(UP, turn);
}

/* Puts an object of a given size on the level `ground` at (x, z). */
static void stand(struct gen_world *w, int object, float x, float z, float ground,
                  float size, struct pbnds_vec4 rotation)
{
    struct pbnds_vec3 centre;
    float extent;
    gen_object_extent(w, object, &centre, &extent);
    gen_object_place(w, object, pbnds_splat(0.0f), rotation, size / extent);
    const struct gen_object *o = &w->objects[object];
    const struct pbnds_vec3 t = {x - 0.5f * (o->lo.x + o->hi.x), ground - o->lo.y,
                                 z - 0.5f * (o->lo.z + o->hi.z)};
    gen_object_place(w, object, t, rotation, o->scale);
}

/* A flat slab; `rotation` turns its upper side to where it must face. */
static void slab(const struct gen_maker *k, struct pbnds_vec3 t,
                 struct pbnds_vec4 rotation, float half_x, float half_z, int material)
{
    struct gen_mesh m = {.vertex_count = 0};
    const int object = gen_object_begin(k->world);
    gen_plane(&m, half_x, half_z, 1);
    gen_mesh_shade(&m, 30.0f);
    const float longer = fmaxf(half_x, half_z);
    for (size_t i = 0; i < m.vertex_count; ++i) { /* square texels */
        m.uv[i].x *= half_x / longer;
        m.uv[i].y *= half_z / longer;
    }
    gen_object_part(k->world, &m, material);
    gen_object_place(k->world, object, t, rotation, 1.0f);
}

enum walls { GROUND, BACK_WALL, CORNER, ROOM };

static void surroundings(const struct gen_maker *k, enum walls walls, float half)
{
    const float quarter = 0.5f * PBNDS_PI;
    const struct pbnds_vec3 x = {1.0f, 0.0f, 0.0f}, z = {0.0f, 0.0f, 1.0f};
    const float height = half * gen_uniform(k->rng, 0.7f, 1.2f);
    const int floor = gen_make_material(k, GEN_GROUND);
    const bool other = gen_chance(k->rng, 0.5f);
    slab(k, pbnds_splat(0.0f), gen_turn(UP, 0.0f), half, half, floor);
    if (walls == GROUND) return;
    const int wall = gen_make_material(k, GEN_GROUND);
    const int side = walls >= CORNER && other ? gen_make_material(k, GEN_GROUND) : wall;
    slab(k, pbnds_vec3_make(0.0f, 0.5f * height, -half), gen_turn(x, quarter), half,
         0.5f * height, wall);
    if (walls >= CORNER) {
        slab(k, pbnds_vec3_make(-half, 0.5f * height, 0.0f), gen_turn(z, -quarter),
             0.5f * height, half, side);
    }
    if (walls >= ROOM) {
        slab(k, pbnds_vec3_make(half, 0.5f * height, 0.0f), gen_turn(z, quarter),
             0.5f * height, half, side);
        if (!gen_chance(k->rng, 0.4f)) return; /* open to the sky */
        slab(k, pbnds_vec3_make(0.0f, height, 0.0f), gen_turn(x, 2.0f * quarter), half,
             half, wall);
    }
}

static bool overlaps(const struct gen_world *w, int first, int object)
{
    const struct gen_object *a = &w->objects[object];
    for (int i = first; i < object; ++i) {
        const struct gen_object *b = &w->objects[i];
        if (a->lo.x < b->hi.x && b->lo.x < a->hi.x && a->lo.z < b->hi.z &&
            b->lo.z < a->hi.z) {
            return true;
        }
    }
    return false;
}

/* Objects on the ground within a square, apart from each other where there is room. */
static void scatter(const struct gen_maker *k, int count, float half)
{
    const int first = k->world->object_count;
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(k);
        const float size = half * gen_log_uniform(k->rng, 0.35f, 1.5f) /
                           sqrtf(1.0f + 0.2f * (float)count);
        const struct pbnds_vec4 pose = random_pose(k->rng, 0.25f);
        for (int attempt = 0; attempt < 12; ++attempt) {
            const float x = gen_uniform(k->rng, -0.7f, 0.7f) * half;
            const float z = gen_uniform(k->rng, -0.7f, 0.7f) * half;
            stand(k->world, object, x, z, 0.0f, size, pose);
            if (!overlaps(k->world, first, object)) break;
        }
    }
}

/* A pile: each lies on top of the one before. */
static void stack(const struct gen_maker *k, int count, float x, float z, float size)
{
    float level = 0.0f;
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(k);
        const float dx = gen_uniform(k->rng, -0.08f, 0.08f) * size;
        const float dz = gen_uniform(k->rng, -0.08f, 0.08f) * size;
        const struct pbnds_vec4 pose = random_pose(k->rng, 0.2f);
        stand(k->world, object, x + dx, z + dz, level, size, pose);
        const struct gen_object *o = &k->world->objects[object];
        level += 0.97f * (o->hi.y - o->lo.y); /* settled a little */
        size *= gen_uniform(k->rng, 0.65f, 1.0f);
    }
}

/* Tilts long things against the wall or against nothing. */
static void lean(const struct gen_maker *k, int count, float half)
{
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(k);
        const float turn = gen_uniform(k->rng, 0.0f, 2.0f * PBNDS_PI);
        const float tilt = gen_uniform(k->rng, -0.5f, -0.15f);
        const struct pbnds_vec4 pose = gen_quat_mul(
            gen_turn(pbnds_vec3_make(1.0f, 0.0f, 0.0f), tilt), gen_turn(UP, turn));
        const float x = gen_uniform(k->rng, -0.6f, 0.6f) * half;
        const float z = gen_uniform(k->rng, -0.85f, -0.5f) * half;
        stand(k->world, object, x, z, -0.01f, half * gen_uniform(k->rng, 0.3f, 0.8f),
              pose);
    }
}

/* In the air, in no order. */
static void float_freely(const struct gen_maker *k, int count)
{
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(k);
        const float size = gen_log_uniform(k->rng, 0.25f, 1.0f);
        const struct pbnds_vec3 t = gen_vec3(k->rng, -0.6f, 0.6f);
        const struct pbnds_vec4 pose = gen_rotation(k->rng);
        stand(k->world, object, t.x, t.z, t.y, size, pose);
    }
}

static struct gen_maker maker(struct gen_world *w, struct pbnds_rng *r, int objects)
{
    const float detail = objects <= 1   ? 1.0f
                         : objects <= 3 ? 0.8f
                         : objects <= 6 ? 0.55f
                                        : 0.4f;
    const int texture = objects <= 1 ? 256 : objects <= 5 ? 128 : 64;
    const struct gen_maker k = {w, r, detail, texture};
    return k;
}

static void hero(struct gen_world *w, struct pbnds_rng *r, bool grounded)
{
    const struct gen_maker k = maker(w, r, 1);
    const int object = gen_random_hero(&k);
    const struct pbnds_vec4 pose = random_pose(r, grounded ? 0.1f : 0.3f);
    stand(w, object, 0.0f, 0.0f, 0.0f, 1.0f, pose);
    if (!grounded) return;
    const struct gen_maker rest = maker(w, r, 4);
    const enum walls walls = gen_chance(r, 0.7f) ? GROUND : BACK_WALL;
    surroundings(&rest, walls, gen_uniform(r, 0.5f, 1.1f));
}

static void group(struct gen_world *w, struct pbnds_rng *r)
{
    static const float kinds[4] = {3.0f, 1.5f, 1.5f, 1.5f};
    const int count = gen_between(r, 2, 12);
    const struct gen_maker k = maker(w, r, count);
    const float half = gen_uniform(r, 0.8f, 1.5f);
    surroundings(&k, (enum walls)gen_pick(r, kinds, 4), half);
    const int leaning = gen_chance(r, 0.3f) ? gen_between(r, 1, 2) : 0;
    const int stacked = gen_chance(r, 0.4f) ? gen_between(r, 2, 4) : 0;
    lean(&k, leaning < count ? leaning : count, half);
    const float x = gen_uniform(r, -0.5f, 0.5f) * half,
                z = gen_uniform(r, -0.5f, 0.5f) * half;
    if (stacked) stack(&k, stacked, x, z, 0.35f * half);
    scatter(&k, count - leaning - stacked > 0 ? count - leaning - stacked : 1, half);
}

/* Rows of one form in many materials, as samples are shown. */
static void samples(struct gen_world *w, struct pbnds_rng *r)
{
    const int columns = gen_between(r, 2, 4), rows = gen_between(r, 2, 4);
    const struct gen_maker k = maker(w, r, columns * rows);
    const bool upright = gen_chance(r, 0.5f), balls = gen_chance(r, 0.6f);
    if (!upright)
        surroundings(&k, GROUND, 0.6f * (float)(columns > rows ? columns : rows));
    for (int i = 0; i < columns * rows; ++i) {
        struct gen_mesh m = {.vertex_count = 0};
        const float x = (float)(i % columns) - 0.5f * (float)(columns - 1);
        const float z = (float)(i / columns) - 0.5f * (float)(rows - 1);
        const int object = gen_object_begin(w);
        if (balls) {
            gen_ellipsoid(&m, pbnds_splat(0.4f), 56);
        } else {
            gen_rounded_box(&m, pbnds_splat(0.35f), 0.1f, 4, 1);
        }
        gen_mesh_shade(&m, 60.0f);
        gen_object_part(w, &m, gen_make_material(&k, GEN_ANY));
        const float turn = balls ? 0.0f : gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
        stand(w, object, x, upright ? 0.0f : z, upright ? z : 0.0f, 0.8f,
              gen_turn(UP, turn));
    }
}

void gen_random_world(struct gen_world *w, uint64_t seed, uint64_t index)
{
    static const float kinds[6] = {3.8f, 1.2f, 4.0f, 0.8f, 0.7f, 0.3f};
    struct pbnds_rng r = pbnds_rng_make(seed, index, 0x776f726c64u);
    const int kind = gen_pick(&r, kinds, 6);
    if (kind <= 1) hero(w, &r, kind == 1);
    if (kind == 2) group(w, &r);
    if (kind == 3) {
        const int count = gen_between(&r, 2, 8);
        const struct gen_maker k = maker(w, &r, count);
        float_freely(&k, count);
    }
    if (kind == 4) {
        const int count = gen_between(&r, 2, 5);
        const struct gen_maker k = maker(w, &r, count);
        stack(&k, count, 0.0f, 0.0f, 1.0f);
    }
    if (kind == 5) samples(w, &r);
    gen_world_normalize(w, gen_uniform(&r, 0.5f, 2.0f));
}
