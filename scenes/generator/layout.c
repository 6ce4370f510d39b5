#include "scenes/generator/layout.h"

#include <string.h>

#include "scenes/generator/assemble.h"
#include "scenes/generator/shapes.h"
#include "scenes/generator/surroundings.h"

/* Any turn about y; tilted as well where the thing may lie as it fell. */
static struct pbnds_vec4 random_pose(struct pbnds_rng *r, float tumbled)
{
    const float turn = gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
    if (gen_chance(r, tumbled)) return gen_rotation(r);
    return gen_turn(GEN_Y, turn);
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

/* The same on a ground that may be rough: a little sunk in. */
static void stand_on(struct gen_world *w, int object, const struct gen_ground *g,
                     float x, float z, float size, struct pbnds_vec4 rotation)
{
    float level = gen_ground_height(g, x, z);
    if (g->rough) level -= 0.04f * size;
    stand(w, object, x, z, level, size, rotation);
}

/* Does the footprint of an object meet that of an earlier one? */
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
static void scatter(const struct gen_maker *k, const struct gen_ground *g, int count,
                    float half)
{
    const int first = k->world->object_count;
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(k);
        const float size = half * gen_log_uniform(k->rng, 0.3f, 1.6f) /
                           sqrtf(1.0f + 0.2f * (float)count);
        const struct pbnds_vec4 pose = random_pose(k->rng, 0.2f);
        for (int attempt = 0; attempt < 12; ++attempt) {
            const float x = gen_uniform(k->rng, -0.7f, 0.7f) * half;
            const float z = gen_uniform(k->rng, -0.7f, 0.7f) * half;
            stand_on(k->world, object, g, x, z, size, pose);
            if (!overlaps(k->world, first, object)) break;
        }
    }
}

/* A pile: each lies on top of the one before. */
static void stack(const struct gen_maker *k, int count, float x, float z, float level,
                  float size)
{
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

/* A heap: things thrown at one place, each as deep as those under it let it. */
static void heap(const struct gen_maker *k, const struct gen_ground *g, int count,
                 float spread, float size)
{
    const int first = k->world->object_count;
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(k);
        const float a = gen_uniform(k->rng, 0.0f, 2.0f * PBNDS_PI);
        const float r = spread * pbnds_rng_float(k->rng);
        const float own = size * gen_log_uniform(k->rng, 0.5f, 1.3f);
        const struct pbnds_vec4 pose = random_pose(k->rng, 0.8f);
        stand_on(k->world, object, g, r * cosf(a), r * sinf(a), own, pose);
        const struct gen_object *o = &k->world->objects[object];
        float level = o->lo.y;
        for (int j = first; j < object; ++j) {
            const struct gen_object *b = &k->world->objects[j];
            /* boxes are larger than what is in them: only their inner parts meet */
            const float sx = 0.2f * (b->hi.x - b->lo.x),
                        sz = 0.2f * (b->hi.z - b->lo.z);
            if (o->lo.x < b->hi.x - sx && b->lo.x + sx < o->hi.x &&
                o->lo.z < b->hi.z - sz && b->lo.z + sz < o->hi.z) {
                level = fmaxf(level, b->hi.y - 0.25f * (b->hi.y - b->lo.y));
            }
        }
        struct pbnds_vec3 t = o->translation;
        t.y += level - o->lo.y;
        gen_object_place(k->world, object, t, pose, o->scale);
    }
}

/* Tilts long things against the wall or against nothing. */
static void lean(const struct gen_maker *k, int count, float half)
{
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(k);
        const float turn = gen_uniform(k->rng, 0.0f, 2.0f * PBNDS_PI);
        const float tilt = gen_uniform(k->rng, -0.5f, -0.15f);
        const struct pbnds_vec4 pose =
            gen_quat_mul(gen_turn(GEN_X, tilt), gen_turn(GEN_Y, turn));
        const float x = gen_uniform(k->rng, -0.6f, 0.6f) * half;
        const float z = gen_uniform(k->rng, -0.8f, -0.5f) * half;
        stand(k->world, object, x, z, -0.01f, half * gen_uniform(k->rng, 0.3f, 0.8f),
              pose);
    }
}

/* Things on threads from a bar. */
static void hang(const struct gen_maker *k, int count, float half, float height)
{
    const int thread = gen_make_material(k, GEN_PLAIN);
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(k);
        const float x = half * (2.0f * ((float)i + 0.5f) / (float)count - 1.0f);
        const float size = 1.5f * half / (float)count * gen_uniform(k->rng, 0.5f, 1.1f);
        const float drop = height * gen_uniform(k->rng, 0.1f, 0.5f);
        const struct pbnds_vec4 pose = random_pose(k->rng, 0.3f);
        stand(k->world, object, x, 0.0f, 0.0f, fminf(size, 0.6f * height), pose);
        const struct gen_object *o = &k->world->objects[object];
        struct pbnds_vec3 t = o->translation;
        t.y += height - drop - o->hi.y;
        gen_object_place(k->world, object, t, pose, o->scale);
        const float top = o->hi.y - 0.05f * (o->hi.y - o->lo.y);
        gen_thread(k, pbnds_vec3_make(x, height, 0.0f), top, thread);
    }
}

static size_t triangles(const struct gen_world *w, int object)
{
    size_t sum = 0;
    const struct gen_object *o = &w->objects[object];
    for (int i = 0; i < o->part_count; ++i)
        sum += gen_part_mesh(w, o->first_part + i)->index_count / 3;
    return sum;
}

/* Another object of the same parts, now and then in a material of its own. */
static int copy_object(const struct gen_maker *k, int object, float recolor)
{
    struct gen_world *w = k->world;
    const struct gen_object from = w->objects[object];
    const int copy = gen_object_begin(w);
    gen_object_name(w, from.name);
    const bool changed = gen_chance(k->rng, recolor);
    const int material = changed ? gen_make_material(k, GEN_PLAIN) : -1;
    for (int i = 0; i < from.part_count; ++i) {
        const struct gen_part *p = &w->parts[from.first_part + i];
        gen_object_twin(w, p->twin >= 0 ? p->twin : from.first_part + i,
                        i == 0 && changed ? material : p->material);
    }
    return copy;
}

static struct gen_maker maker(struct gen_world *w, struct pbnds_rng *r, int objects)
{
    const float detail = objects <= 1   ? 1.0f
                         : objects <= 3 ? 0.8f
                         : objects <= 6 ? 0.55f
                                        : 0.4f;
    const int texture = objects <= 1 ? 256 : objects <= 5 ? 128 : 64;
    const struct gen_maker k = {w, r, w->sketch ? 0.25f * detail : detail,
                                w->sketch ? 16 : texture};
    return k;
}

/* ---- the kinds of world ---- */

/* Heads nod and tilt. */
static struct pbnds_vec4 hero_pose(struct gen_world *w, struct pbnds_rng *r, int object,
                                   float tumbled)
{
    const struct pbnds_vec4 pose = random_pose(r, tumbled);
    const float nod = gen_uniform(r, -0.35f, 0.35f),
                tilt = gen_uniform(r, -0.25f, 0.25f);
    if (strcmp(w->objects[object].name, "head") != 0 || !gen_chance(r, 0.6f))
        return pose;
    return gen_quat_mul(pose,
                        gen_quat_mul(gen_turn(GEN_X, nod), gen_turn(GEN_Z, tilt)));
}

/* One thing by itself, as products and characters are shown. */
static void alone(struct gen_world *w, struct pbnds_rng *r)
{
    const struct gen_maker k = maker(w, r, 1);
    const int object = gen_random_hero(&k);
    stand(w, object, 0.0f, 0.0f, 0.0f, 1.0f, hero_pose(w, r, object, 0.3f));
}

static void presented(struct gen_world *w, struct pbnds_rng *r)
{
    const struct gen_maker k = maker(w, r, 1), rest = maker(w, r, 4);
    const int object = gen_random_hero(&k);
    const struct pbnds_vec4 pose = hero_pose(w, r, object, 0.1f);
    const float half = gen_uniform(r, 0.45f, 1.2f);
    const bool walled = gen_chance(r, 0.25f);
    const struct gen_ground g =
        walled ? gen_random_room(&rest, half, 1) : gen_random_ground(&rest, half);
    stand_on(w, object, &g, 0.0f, 0.0f, 1.0f, pose);
}

/* Two or three heroes side by side. */
static void portrait(struct gen_world *w, struct pbnds_rng *r)
{
    const int count = gen_between(r, 2, 3);
    const struct gen_maker k = maker(w, r, count);
    const bool grounded = gen_chance(r, 0.5f);
    const struct gen_ground none = {.half = 1.0f};
    const struct gen_ground g = grounded ? gen_random_ground(&k, 1.2f) : none;
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_hero(&k);
        const float x = 0.75f * ((float)i - 0.5f * (float)(count - 1));
        const float z = gen_uniform(r, -0.25f, 0.25f);
        const float size = gen_uniform(r, 0.6f, 1.0f);
        stand_on(w, object, &g, x, z, size, hero_pose(w, r, object, 0.05f));
    }
}

static void gathering(struct gen_world *w, struct pbnds_rng *r)
{
    const int count = gen_between(r, 2, 12);
    const struct gen_maker k = maker(w, r, count);
    const float half = gen_uniform(r, 0.7f, 1.5f);
    const struct gen_ground g = gen_random_ground(&k, half);
    const int stacked = gen_chance(r, 0.4f) ? gen_between(r, 2, 4) : 0;
    const float x = gen_uniform(r, -0.5f, 0.5f) * half;
    const float z = gen_uniform(r, -0.5f, 0.5f) * half;
    if (stacked) stack(&k, stacked, x, z, gen_ground_height(&g, x, z), 0.4f * half);
    scatter(&k, &g, count - stacked > 0 ? count - stacked : 1, half);
}

static void room(struct gen_world *w, struct pbnds_rng *r)
{
    static const float kinds[3] = {1.5f, 2.0f, 1.5f};
    const int count = gen_between(r, 2, 9);
    const struct gen_maker k = maker(w, r, count);
    const float half = gen_uniform(r, 0.8f, 1.4f);
    const struct gen_ground g = gen_random_room(&k, half, 1 + gen_pick(r, kinds, 3));
    const int leaning = gen_chance(r, 0.4f) ? gen_between(r, 1, 2) : 0;
    lean(&k, leaning < count ? leaning : count, half);
    scatter(&k, &g, count - leaning > 0 ? count - leaning : 1, half);
}

static void landscape(struct gen_world *w, struct pbnds_rng *r)
{
    const int count = gen_between(r, 1, 8);
    const struct gen_maker fine = maker(w, r, 2), k = maker(w, r, count + 2);
    const float half = gen_uniform(r, 0.8f, 1.6f);
    const struct gen_ground g = gen_random_terrain(&fine, half);
    scatter(&k, &g, count, 0.8f * half);
}

static void pile(struct gen_world *w, struct pbnds_rng *r)
{
    const int count = gen_between(r, 5, 16);
    const struct gen_maker k = maker(w, r, count);
    const struct gen_ground none = {.half = 1.0f};
    const bool grounded = gen_chance(r, 0.75f);
    const struct gen_ground g = grounded ? gen_random_ground(&k, 1.0f) : none;
    const float spread = gen_uniform(r, 0.2f, 0.5f), size = gen_uniform(r, 0.35f, 0.6f);
    heap(&k, &g, count, spread, size);
}

static void hanging(struct gen_world *w, struct pbnds_rng *r)
{
    const int count = gen_between(r, 1, 7);
    const struct gen_maker k = maker(w, r, count);
    const float height = gen_uniform(r, 0.8f, 1.4f), half = 0.2f + 0.1f * (float)count;
    const int place = gen_below(r, 3);
    if (place == 0) (void)gen_random_room(&k, 1.1f, gen_between(r, 1, 3));
    if (place == 1) (void)gen_random_ground(&k, 1.0f);
    gen_gallows(&k, half, height);
    hang(&k, count, half, height);
}

static void shelf(struct gen_world *w, struct pbnds_rng *r)
{
    float level[6];
    const struct gen_maker k = maker(w, r, 9);
    const float half = 0.8f, depth = gen_uniform(r, 0.15f, 0.35f);
    const bool walled = gen_chance(r, 0.5f);
    if (walled) (void)gen_random_room(&k, 1.0f, gen_between(r, 1, 2));
    const int boards = gen_random_shelf(&k, half, depth, level);
    const int each = gen_between(r, 1, 4);
    const float room = 2.0f * half / (float)boards;
    for (int i = 0; i < boards * each; ++i) {
        const int object = gen_random_object(&k);
        const float x = half * (2.0f * ((float)(i % each) + 0.5f) / (float)each - 1.0f);
        const float size =
            0.8f * fminf(fminf(room, 2.0f * half / (float)each), 2.5f * depth);
        const float own = size * gen_uniform(r, 0.6f, 1.0f);
        stand(w, object, x, 0.0f, level[i / each], own, random_pose(r, 0.1f));
    }
}

/* A laid table. */
static void table(struct gen_world *w, struct pbnds_rng *r)
{
    const int count = gen_between(r, 2, 8);
    const struct gen_maker k = maker(w, r, count + 1);
    const bool roomy = gen_chance(r, 0.4f);
    if (roomy) (void)gen_random_room(&k, 1.1f, gen_between(r, 1, 3));
    const int board = gen_object_begin(w);
    gen_object_name(w, "table");
    gen_build_table(&k);
    stand(w, board, 0.0f, 0.0f, 0.0f, 1.3f, GEN_REST);
    /* the top comes first and lies around the object's own origin */
    const struct gen_mesh *top = gen_part_mesh(w, w->objects[board].first_part);
    struct pbnds_vec3 lo, hi;
    gen_mesh_bounds(top, &lo, &hi);
    const float level =
        w->objects[board].translation.y - w->objects[board].scale * lo.y;
    const struct gen_object *o = &w->objects[board];
    const float half = 0.4f * fminf(o->hi.x - o->lo.x, o->hi.z - o->lo.z);
    const int first = w->object_count;
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(&k);
        const float size = half * gen_log_uniform(r, 0.3f, 1.0f);
        const struct pbnds_vec4 pose = random_pose(r, 0.1f);
        for (int attempt = 0; attempt < 10; ++attempt) {
            const float x = gen_uniform(r, -0.9f, 0.9f) * half;
            const float z = gen_uniform(r, -0.9f, 0.9f) * half;
            stand(w, object, x, z, level, size, pose);
            if (!overlaps(w, first, object)) break;
        }
    }
}

/* In the air, in no order. */
static void floating(struct gen_world *w, struct pbnds_rng *r)
{
    const int count = gen_between(r, 2, 9);
    const struct gen_maker k = maker(w, r, count);
    for (int i = 0; i < count; ++i) {
        const int object = gen_random_object(&k);
        const float size = gen_log_uniform(r, 0.25f, 1.0f);
        const struct pbnds_vec3 t = gen_vec3(r, -0.6f, 0.6f);
        const struct pbnds_vec4 pose = gen_rotation(r);
        stand(w, object, t.x, t.z, t.y, size, pose);
    }
}

static void tower(struct gen_world *w, struct pbnds_rng *r)
{
    const int count = gen_between(r, 2, 5);
    const struct gen_maker k = maker(w, r, count);
    stack(&k, count, 0.0f, 0.0f, 0.0f, 1.0f);
}

/* One thing many times: in a row, a ring, a field, a spiral, climbing. */
static void array(struct gen_world *w, struct pbnds_rng *r)
{
    const struct gen_maker k = maker(w, r, 5);
    const bool grounded = gen_chance(r, 0.6f);
    if (grounded) (void)gen_random_ground(&k, 1.2f);
    const int first = gen_random_object(&k), shape = gen_below(r, 4);
    const size_t most = 110000 / (triangles(w, first) + 1);
    int count = gen_between(r, 4, 24);
    if ((size_t)count > most) count = most > 2 ? (int)most : 2;
    if (shape == 0 && count > 8) count = 8;
    const int side = (int)ceilf(sqrtf((float)count));
    const float rise = gen_chance(r, 0.6f) ? 0.0f : gen_uniform(r, 0.02f, 0.12f);
    const float recolor = gen_chance(r, 0.5f) ? 0.0f : 0.7f;
    const float turn = gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
    const float shrink = gen_chance(r, 0.7f) ? 1.0f : gen_uniform(r, 0.86f, 0.97f);
    float size = shape == 2   ? 1.7f / (float)side
                 : shape == 0 ? 1.9f / (float)count
                              : 0.4f;
    if (shape == 0) size = fmaxf(size, 0.22f);
    for (int i = 0; i < count; ++i) {
        const int object = i == 0 ? first : copy_object(&k, first, recolor);
        const float t = (float)i / (float)count, a = 2.0f * PBNDS_PI * t;
        float x = 2.2f * (t - 0.5f), z = 0.0f, yaw = turn;
        if (shape == 1) { /* ring */
            x = 0.85f * cosf(a);
            z = 0.85f * sinf(a);
            yaw = turn - a;
        }
        if (shape == 2) { /* field */
            x = 2.0f * ((float)(i % side) + 0.5f) / (float)side - 1.0f;
            z = 2.0f * ((float)(i / side) + 0.5f) / (float)side - 1.0f;
        }
        if (shape == 3) { /* spiral */
            x = (0.25f + 0.7f * t) * cosf(2.5f * a);
            z = (0.25f + 0.7f * t) * sinf(2.5f * a);
            yaw = turn - 2.5f * a;
        }
        stand(w, object, x, z, rise * (float)i, size, gen_turn(GEN_Y, yaw));
        size *= shrink;
    }
}

/* Rows of one form in many materials, as samples are shown. */
static void samples(struct gen_world *w, struct pbnds_rng *r)
{
    const int columns = gen_between(r, 2, 4), rows = gen_between(r, 2, 4);
    const struct gen_maker k = maker(w, r, columns * rows);
    const bool upright = gen_chance(r, 0.5f), balls = gen_chance(r, 0.6f);
    if (!upright) {
        (void)gen_random_ground(&k, 0.6f * (float)(columns > rows ? columns : rows));
    }
    for (int i = 0; i < columns * rows; ++i) {
        struct gen_mesh m = {.vertex_count = 0};
        const float x = (float)(i % columns) - 0.5f * (float)(columns - 1);
        const float z = (float)(i / columns) - 0.5f * (float)(rows - 1);
        const int object = gen_object_begin(w);
        gen_object_name(w, "sample");
        if (balls) {
            gen_ellipsoid(&m, pbnds_splat(0.4f), 56);
        } else {
            gen_rounded_box(&m, pbnds_splat(0.35f), 0.1f, 4, 1);
        }
        gen_mesh_shade(&m, 60.0f);
        gen_object_part(w, &m, gen_make_material(&k, GEN_ANY));
        const float turn = balls ? 0.0f : gen_uniform(r, 0.0f, 2.0f * PBNDS_PI);
        stand(w, object, x, upright ? 0.0f : z, upright ? z : 0.0f, 0.8f,
              gen_turn(GEN_Y, turn));
    }
}

struct kind {
    float weight;
    const char *name;
    void (*make)(struct gen_world *w, struct pbnds_rng *r);
};

/* About half of the worlds have no ground, as most models that people render. */
static const struct kind KINDS[] = {
    {32.0f, "alone", alone},      {11.0f, "presented", presented},
    {4.0f, "portrait", portrait}, {13.0f, "gathering", gathering},
    {8.0f, "room", room},         {6.0f, "landscape", landscape},
    {5.0f, "pile", pile},         {4.0f, "hanging", hanging},
    {3.0f, "shelf", shelf},       {3.0f, "table", table},
    {7.0f, "floating", floating}, {5.0f, "tower", tower},
    {5.0f, "array", array},       {2.0f, "samples", samples},
};

void gen_random_world(struct gen_world *w, uint64_t seed, uint64_t index)
{
    enum { COUNT = (int)(sizeof KINDS / sizeof KINDS[0]) };
    float weights[COUNT];
    struct pbnds_rng r = pbnds_rng_make(seed, index, 0x776f726c64u);
    for (int i = 0; i < COUNT; ++i)
        weights[i] = KINDS[i].weight;
    const struct kind *kind = &KINDS[gen_pick(&r, weights, COUNT)];
    gen_random_palette(w, &r);
    w->name = kind->name;
    kind->make(w, &r);
    gen_world_normalize(w, gen_uniform(&r, 0.5f, 2.0f));
}
