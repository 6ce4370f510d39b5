#include "neural/data/draw_subject.h"

#include <stdlib.h>
#include <string.h>

struct box {
    struct pbnds_vec3 lo, hi; /* empty: lo > hi */
};

static struct box empty_box(void)
{
    const struct box b = {pbnds_splat(INFINITY), pbnds_splat(-INFINITY)};
    return b;
}

static struct pbnds_vec3 min3(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return pbnds_vec3_make(fminf(a.x, b.x), fminf(a.y, b.y), fminf(a.z, b.z));
}

static struct pbnds_vec3 max3(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return pbnds_vec3_make(fmaxf(a.x, b.x), fmaxf(a.y, b.y), fmaxf(a.z, b.z));
}

static void include(struct box *box, const struct box *other)
{
    box->lo = min3(box->lo, other->lo);
    box->hi = max3(box->hi, other->hi);
}

static bool is_empty(const struct box *box)
{
    return !(box->lo.x <= box->hi.x);
}

static void include_mesh(struct box *box, const struct pbnds_mesh *mesh)
{
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        const struct box point = {mesh->position[i], mesh->position[i]};
        include(box, &point);
    }
}

static struct pbnds_vec3 extent_of(const struct box *box)
{
    return pbnds_sub(box->hi, box->lo);
}

static float least3(struct pbnds_vec3 a)
{
    return fminf(a.x, fminf(a.y, a.z));
}

/* A ground, a wall, or the shell that encloses all else: it spans the scene in at least
 * two directions and is flat, or hollow around the others. */
static bool is_backdrop(const struct box *box, const struct pbnds_scene *scene)
{
    const struct pbnds_vec3 all = pbnds_sub(scene->hi, scene->lo), e = extent_of(box);
    const int spans =
        (e.x > 0.7f * all.x) + (e.y > 0.7f * all.y) + (e.z > 0.7f * all.z);
    return spans >= 2 && least3(e) < 0.12f * pbnds_max3(e);
}

/* Neither a speck nor a sheet. */
static bool is_worth_a_picture(const struct box *box, const struct box *whole)
{
    const struct pbnds_vec3 e = extent_of(box);
    const float share = pbnds_length(e) / pbnds_length(extent_of(whole));
    return share > 0.06f && share < 0.9f && least3(e) > 0.08f * pbnds_max3(e);
}

static bool is_upright(const struct pbnds_subjects *s)
{
    for (int i = 0; i < s->backdrop_size; ++i) {
        if (s->backdrop[i]) return false;
    }
    const struct pbnds_vec3 e = pbnds_sub(s->items[0].hi, s->items[0].lo);
    return e.y > 0.85f * e.x && e.y < 3.5f * e.x && e.z > 0.5f * e.x &&
           e.z < 1.8f * e.x;
}

struct pbnds_vec3 pbnds_hit_normal(const struct pbnds_scene *scene,
                                   const struct pbnds_hit *hit)
{
    const struct pbnds_mesh *m = &scene->meshes[hit->mesh];
    const uint32_t *index = m->index + 3 * (size_t)hit->triangle;
    const struct pbnds_vec3 a = m->position[index[0]];
    const struct pbnds_vec3 n = pbnds_cross(pbnds_sub(m->position[index[1]], a),
                                            pbnds_sub(m->position[index[2]], a));
    const float length = pbnds_length(n);
    return length > 0.0f && length < INFINITY ? pbnds_scale(n, 1.0f / length)
                                              : pbnds_splat(0.0f);
}

/* The faces and corners of a cube, turned a little: rays along the axes run in the
 * faces of what is built along them. */
static struct pbnds_vec3 around_direction(int i)
{
    struct pbnds_vec3 d;
    if (i < 6) {
        const float side = i % 2 ? -1.0f : 1.0f;
        d = pbnds_vec3_make(i / 2 == 0 ? side : 0.0f, i / 2 == 1 ? side : 0.0f,
                            i / 2 == 2 ? side : 0.0f);
    } else {
        d = pbnds_vec3_make((i - 6) & 1 ? 1.0f : -1.0f, (i - 6) & 2 ? 1.0f : -1.0f,
                            (i - 6) & 4 ? 1.0f : -1.0f);
    }
    const struct pbnds_frame turn =
        pbnds_frame_from_normal(pbnds_normalize(pbnds_vec3_make(0.13f, 0.97f, 0.21f)));
    return pbnds_normalize(pbnds_to_world(&turn, d));
}

struct pbnds_surroundings pbnds_look_around(const struct pbnds_scene *scene,
                                            const struct pbnds_accel *accel,
                                            struct pbnds_vec3 eye)
{
    struct pbnds_ray rays[PBNDS_SURROUNDING_RAYS];
    struct pbnds_hit hits[PBNDS_SURROUNDING_RAYS];
    struct pbnds_surroundings around = {0, 0, INFINITY};
    for (int i = 0; i < PBNDS_SURROUNDING_RAYS; ++i)
        rays[i] = (struct pbnds_ray){eye, around_direction(i)};
    pbnds_accel_intersect_packet(accel, rays, PBNDS_SURROUNDING_RAYS, hits);
    for (int i = 0; i < PBNDS_SURROUNDING_RAYS; ++i) {
        if (hits[i].mesh == UINT32_MAX) continue;
        const struct pbnds_vec3 n = pbnds_hit_normal(scene, &hits[i]);
        if (pbnds_dot(n, rays[i].direction) > 0.0f) {
            ++around.back;
        } else {
            ++around.front;
        }
        around.nearest = fminf(around.nearest, hits[i].t);
    }
    return around;
}

/* From most of nine places within the bounds, walls are seen nearly everywhere, and from
 * the front. */
static bool is_room(const struct pbnds_scene *scene, const struct pbnds_accel *accel)
{
    const struct pbnds_vec3 size = pbnds_sub(scene->hi, scene->lo);
    int closed = 0;
    for (int i = 0; i < 9; ++i) {
        const struct pbnds_vec3 at = {i & 1 ? 0.3f : 0.7f, i & 2 ? 0.4f : 0.75f,
                                      i & 4 ? 0.3f : 0.7f};
        const struct pbnds_vec3 eye =
            pbnds_add(scene->lo, pbnds_mul(size, i == 8 ? pbnds_splat(0.5f) : at));
        const struct pbnds_surroundings around = pbnds_look_around(scene, accel, eye);
        closed += around.front >= PBNDS_SURROUNDING_RAYS - 3 && around.back <= 2;
    }
    return closed >= 5;
}

static void list_objects(const struct pbnds_scene *scene, const struct box *boxes,
                         struct pbnds_subjects *s)
{
    struct box whole = empty_box();
    for (int i = 0; i < scene->object_count; ++i) {
        if (is_empty(&boxes[i])) continue;
        s->backdrop[i] = is_backdrop(&boxes[i], scene);
        if (!s->backdrop[i]) {
            include(&whole, &boxes[i]);
        } else if (extent_of(&boxes[i]).y <= least3(extent_of(&boxes[i]))) {
            s->ground = fmaxf(s->ground, boxes[i].hi.y);
        }
    }
    if (is_empty(&whole)) { /* nothing but grounds and walls */
        whole = (struct box){scene->lo, scene->hi};
        memset(s->backdrop, 0, (size_t)s->backdrop_size * sizeof *s->backdrop);
    }
    if (s->ground > whole.lo.y + 0.5f * extent_of(&whole).y)
        s->ground = -INFINITY; /* a ceiling */
    s->items[s->count++] = (struct pbnds_subject){whole.lo, whole.hi, UINT32_MAX};
    for (int i = 0; i < scene->object_count; ++i) {
        if (is_empty(&boxes[i]) || s->backdrop[i]) continue;
        if (!is_worth_a_picture(&boxes[i], &whole)) continue;
        s->items[s->count++] =
            (struct pbnds_subject){boxes[i].lo, boxes[i].hi, (uint32_t)i};
    }
}

bool pbnds_subjects_find(const struct pbnds_scene *scene,
                         const struct pbnds_accel *accel, struct pbnds_subjects *s)
{
    const size_t objects = (size_t)scene->object_count;
    *s = (struct pbnds_subjects){.backdrop_size = scene->object_count,
                                 .ground = -INFINITY};
    struct box *boxes = malloc((objects + 1) * sizeof *boxes);
    s->items = malloc((objects + 1) * sizeof *s->items);
    s->backdrop = calloc(objects + 1, sizeof *s->backdrop);
    if (!boxes || !s->items || !s->backdrop) {
        free(boxes);
        pbnds_subjects_free(s);
        return false;
    }
    for (size_t i = 0; i < objects; ++i)
        boxes[i] = empty_box();
    for (int i = 0; i < scene->mesh_count; ++i) {
        const struct pbnds_mesh *mesh = &scene->meshes[i];
        if (mesh->object_id < objects) include_mesh(&boxes[mesh->object_id], mesh);
    }
    list_objects(scene, boxes, s);
    free(boxes);
    s->upright = is_upright(s);
    s->room = !s->upright && is_room(scene, accel); /* not a vase */
    return true;
}

void pbnds_subjects_free(struct pbnds_subjects *subjects)
{
    free(subjects->items);
    free(subjects->backdrop);
    *subjects = (struct pbnds_subjects){0};
}
