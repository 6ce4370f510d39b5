#include "neural/data/draw_camera.h"

#include <string.h>

#include "neural/data/draw_probe.h"
#include "neural/data/draw_random.h"

static const float degree = PBNDS_PI / 180.0f;

enum { ATTEMPTS = 40, STRICT_ATTEMPTS = 28 };

/* What the shots of one draw have in common. */
struct stage {
    const struct pbnds_scene *scene;
    const struct pbnds_accel *accel;
    const struct pbnds_subjects *subjects;
    float aspect;
    float radius; /* of the whole subject */
};

const char *pbnds_shot_name(enum pbnds_shot_kind kind)
{
    static const char *const NAMES[] = {"scene",  "object", "portrait",
                                        "detail", "room",   "file"};
    return kind < PBNDS_SHOT_COUNT ? NAMES[kind] : "?";
}

static struct pbnds_vec3 eye_of(const struct pbnds_camera *camera)
{
    const float *m = camera->world_from_camera.m;
    return pbnds_vec3_make(m[12], m[13], m[14]);
}

/* Stands at the eye, looks along the unit vector `forward`; a positive roll turns the
 * camera clockwise. */
static void place(struct pbnds_shot *shot, struct pbnds_vec3 eye,
                  struct pbnds_vec3 forward)
{
    const struct pbnds_vec3 z = pbnds_scale(forward, -1.0f);
    const struct pbnds_vec3 up =
        fabsf(z.y) > 0.999f ? pbnds_vec3_make(0, 0, 1) : pbnds_vec3_make(0, 1, 0);
    const struct pbnds_vec3 level = pbnds_normalize(pbnds_cross(up, z));
    const struct pbnds_vec3 over = pbnds_cross(z, level);
    const float c = cosf(shot->roll_deg * degree), s = sinf(shot->roll_deg * degree);
    const struct pbnds_vec3 x = pbnds_mad(pbnds_scale(level, c), over, -s);
    const struct pbnds_vec3 y = pbnds_mad(pbnds_scale(over, c), level, s);
    shot->camera.world_from_camera = (struct pbnds_mat4){
        {x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, eye.x, eye.y, eye.z, 1}};
}

static void aim(struct pbnds_shot *shot, struct pbnds_vec3 eye,
                struct pbnds_vec3 target)
{
    const struct pbnds_vec3 way = pbnds_sub(target, eye);
    shot->focus = pbnds_length(way);
    place(shot, eye,
          shot->focus > 0.0f ? pbnds_scale(way, 1.0f / shot->focus)
                             : pbnds_vec3_make(0, 0, -1));
}

static struct pbnds_vec3 from_angles(float yaw_deg, float pitch_deg)
{
    const float yaw = yaw_deg * degree, pitch = pitch_deg * degree;
    return pbnds_vec3_make(sinf(yaw) * cosf(pitch), sinf(pitch),
                           cosf(yaw) * cosf(pitch));
}

/* Half of the narrower field of view. */
static float half_view(const struct stage *stage, float yfov)
{
    const float half = 0.5f * yfov;
    return fminf(half, atanf(tanf(half) * stage->aspect));
}

/* Mostly from a little above, as people look at things; some level, from high above, or
 * from below. */
static float draw_pitch(struct pbnds_rng *rng)
{
    const float u = pbnds_rng_float(rng);
    const float v = pbnds_rng_float(rng);
    if (u < 0.15f) return -5.0f + 10.0f * v;
    if (u < 0.25f) return 45.0f + 40.0f * v;
    if (u < 0.32f) return -30.0f + 25.0f * v;
    return 3.0f + 42.0f * v;
}

/* Around a subject at the distance at which its sphere fills the view, times `closer`. */
static void draw_shell(const struct stage *stage, const struct pbnds_subject *subject,
                       struct pbnds_rng *rng, float closer, float yaw, float pitch,
                       struct pbnds_shot *shot)
{
    const struct pbnds_vec3 half =
        pbnds_scale(pbnds_sub(subject->hi, subject->lo), 0.5f);
    const struct pbnds_vec3 centre =
        pbnds_scale(pbnds_add(subject->hi, subject->lo), 0.5f);
    const struct pbnds_vec3 shift = pbnds_draw_vec3(rng, -0.25f, 0.25f);
    const float radius = fmaxf(pbnds_length(half), 1e-6f);
    const float distance = closer * radius / sinf(half_view(stage, shot->camera.yfov));
    const struct pbnds_vec3 target = pbnds_add(centre, pbnds_mul(shift, half));
    aim(shot, pbnds_mad(target, from_angles(yaw, pitch), distance), target);
}

static void draw_scene_shot(const struct stage *stage, struct pbnds_rng *rng,
                            struct pbnds_shot *shot)
{
    const float closer = pbnds_draw_uniform(rng, 0.5f, 1.05f);
    const float yaw = pbnds_draw_uniform(rng, -180.0f, 180.0f);
    const float pitch = draw_pitch(rng);
    draw_shell(stage, &stage->subjects->items[0], rng, closer, yaw, pitch, shot);
}

static void draw_object_shot(const struct stage *stage, struct pbnds_rng *rng,
                             struct pbnds_shot *shot)
{
    const int i = 1 + pbnds_draw_below(rng, stage->subjects->count - 1);
    const struct pbnds_subject *subject = &stage->subjects->items[i];
    shot->object = subject->object;
    const float closer = pbnds_draw_uniform(rng, 0.65f, 1.5f);
    const float yaw = pbnds_draw_uniform(rng, -180.0f, 180.0f);
    const float pitch = draw_pitch(rng);
    draw_shell(stage, subject, rng, closer, yaw, pitch, shot);
}

static void draw_portrait_shot(const struct stage *stage, struct pbnds_rng *rng,
                               struct pbnds_shot *shot)
{
    shot->camera.yfov = pbnds_draw_log_uniform(rng, 15.0f, 42.0f) * degree;
    const float closer = pbnds_draw_uniform(rng, 0.6f, 1.0f);
    const float yaw = 28.0f * pbnds_draw_normal(rng);
    const float pitch = 4.0f + 8.0f * pbnds_draw_normal(rng);
    draw_shell(stage, &stage->subjects->items[0], rng, closer, yaw, pitch, shot);
}

/* A point of a triangle of a mesh, all meshes alike, seen from its front. */
static void draw_detail_shot(const struct stage *stage, struct pbnds_rng *rng,
                             struct pbnds_shot *shot)
{
    const struct pbnds_scene *scene = stage->scene;
    const uint32_t m = (uint32_t)pbnds_draw_below(rng, scene->mesh_count);
    const float u = pbnds_rng_float(rng);
    const struct pbnds_vec3 spread = pbnds_draw_vec3(rng, -1.0f, 1.0f);
    const float distance = stage->radius * pbnds_draw_log_uniform(rng, 0.15f, 0.6f);
    const struct pbnds_mesh *mesh = &scene->meshes[m];
    if (mesh->triangle_count == 0) return;
    size_t t = (size_t)((double)u * (double)mesh->triangle_count);
    if (t >= mesh->triangle_count) t = mesh->triangle_count - 1;
    const uint32_t *index = mesh->index + 3 * t;
    const struct pbnds_vec3 target = pbnds_scale(
        pbnds_add(pbnds_add(mesh->position[index[0]], mesh->position[index[1]]),
                  mesh->position[index[2]]),
        1.0f / 3.0f);
    const struct pbnds_hit hit = {0.0f, 0.0f, 0.0f, m, (uint32_t)t};
    const struct pbnds_vec3 n = pbnds_hit_normal(scene, &hit);
    const struct pbnds_vec3 way = pbnds_mad(n, spread, 0.7f);
    const float length = pbnds_length(way);
    if (!(length > 0.05f)) return;
    aim(shot, pbnds_mad(target, way, distance / length), target);
}

/* From one place within the walls toward another, where there is an object if there are
 * any: bare corners have little to show. */
static void draw_room_shot(const struct stage *stage, struct pbnds_rng *rng,
                           struct pbnds_shot *shot)
{
    const struct pbnds_vec3 lo = stage->scene->lo;
    const struct pbnds_vec3 size = pbnds_sub(stage->scene->hi, lo);
    shot->camera.yfov = pbnds_draw_uniform(rng, 35.0f, 75.0f) * degree;
    struct pbnds_vec3 from = pbnds_draw_vec3(rng, 0.08f, 0.92f);
    const struct pbnds_vec3 to = pbnds_draw_vec3(rng, 0.2f, 0.8f);
    from.y = 0.2f + 0.6f * from.y;
    const int i = pbnds_draw_below(rng, stage->subjects->count);
    const struct pbnds_subject *subject = &stage->subjects->items[i];
    const struct pbnds_vec3 object =
        pbnds_add(subject->lo, pbnds_mul(pbnds_sub(subject->hi, subject->lo), to));
    aim(shot, pbnds_add(lo, pbnds_mul(size, from)),
        i > 0 ? object : pbnds_add(lo, pbnds_mul(size, to)));
}

static void draw_file_shot(const struct stage *stage, struct pbnds_rng *rng,
                           struct pbnds_shot *shot)
{
    const int i = pbnds_draw_below(rng, stage->scene->camera_count);
    const struct pbnds_vec3 shift = pbnds_draw_vec3(rng, -1.0f, 1.0f);
    const struct pbnds_vec3 turn = pbnds_draw_vec3(rng, -1.0f, 1.0f);
    const float zoom = pbnds_draw_log_uniform(rng, 0.8f, 1.2f);
    const struct pbnds_camera *from = &stage->scene->cameras[i];
    const struct pbnds_vec3 centre = pbnds_scale(
        pbnds_add(stage->subjects->items[0].lo, stage->subjects->items[0].hi), 0.5f);
    if (from->orthographic) { /* as a long lens would have it */
        draw_scene_shot(stage, rng, shot);
        return;
    }
    const float *m = from->world_from_camera.m;
    const float away = pbnds_length(pbnds_sub(eye_of(from), centre));
    const struct pbnds_vec3 forward =
        pbnds_normalize(pbnds_mad(pbnds_vec3_make(-m[8], -m[9], -m[10]), turn, 0.08f));
    shot->camera.yfov = pbnds_clamp(from->yfov * zoom, 10.0f * degree, 80.0f * degree);
    shot->focus = fmaxf(away, 1e-6f);
    place(shot, pbnds_mad(eye_of(from), shift, 0.05f * away), forward);
}

/* Which kinds a scene allows, and how often each is tried. */
static enum pbnds_shot_kind draw_kind(const struct stage *stage, struct pbnds_rng *rng)
{
    const struct pbnds_subjects *s = stage->subjects;
    const float weight[PBNDS_SHOT_COUNT] = {
        [PBNDS_SHOT_SCENE] = s->room ? 0.3f : 1.0f,
        [PBNDS_SHOT_OBJECT] = s->count > 1 ? s->upright ? 0.2f : 1.0f : 0.0f,
        [PBNDS_SHOT_PORTRAIT] = s->upright ? 1.5f : 0.0f,
        [PBNDS_SHOT_DETAIL] = 0.22f,
        [PBNDS_SHOT_ROOM] = s->room ? 2.0f : 0.0f,
        [PBNDS_SHOT_FILE] = stage->scene->camera_count > 0 ? 0.7f : 0.0f,
    };
    float total = 0.0f;
    for (int i = 0; i < PBNDS_SHOT_COUNT; ++i)
        total += weight[i];
    float x = total * pbnds_rng_float(rng);
    for (int i = 0; i < PBNDS_SHOT_COUNT; ++i) {
        if (x < weight[i]) return (enum pbnds_shot_kind)i;
        x -= weight[i];
    }
    return PBNDS_SHOT_SCENE;
}

static void draw_shot(const struct stage *stage, struct pbnds_rng *rng,
                      struct pbnds_shot *shot)
{
    static void (*const DRAW[PBNDS_SHOT_COUNT])(
        const struct stage *, struct pbnds_rng *,
        struct pbnds_shot *) = {draw_scene_shot,  draw_object_shot, draw_portrait_shot,
                                draw_detail_shot, draw_room_shot,   draw_file_shot};
    shot->kind = draw_kind(stage, rng);
    shot->object = UINT32_MAX;
    shot->camera = (struct pbnds_camera){.name = "drawn"};
    shot->camera.world_from_camera = pbnds_mat4_identity();
    shot->camera.yfov = pbnds_draw_log_uniform(rng, 15.0f, 75.0f) * degree;
    const float roll = pbnds_draw_uniform(rng, -25.0f, 25.0f);
    shot->roll_deg = pbnds_draw_chance(rng, 0.12) ? roll : 0.0f;
    shot->focus = 0.0f;
    DRAW[shot->kind](stage, rng, shot);
}

/* Does the camera stand in free space, a step away from everything? */
static bool stands_well(const struct stage *stage, const struct pbnds_shot *shot,
                        bool strict)
{
    const struct pbnds_surroundings around =
        pbnds_look_around(stage->scene, stage->accel, eye_of(&shot->camera));
    if (!(around.nearest > 0.04f * shot->focus)) return false;
    if (!strict) return true;
    if (eye_of(&shot->camera).y < stage->subjects->ground) return false;
    if (shot->kind == PBNDS_SHOT_ROOM && around.front < PBNDS_SURROUNDING_RAYS / 2)
        return false;
    return !pbnds_is_inside(&around);
}

/* What is too near to be anything but an obstacle, too far for one picture, too much of
 * one thing. Shares are of the picture. */
static bool sees_well(const struct stage *stage, const struct pbnds_shot *shot,
                      const struct pbnds_probe *p, bool strict)
{
    if (p->covered < 0.15f || (p->flat && p->covered > 0.85f)) return false;
    if (!(p->nearest > 0.1f * shot->focus)) return false;
    if (!strict) return true;
    const float dark = shot->kind == PBNDS_SHOT_ROOM ? 0.12f : 0.08f;
    if (p->open < dark && stage->scene->light_count == 0) return false;
    if (p->flat || p->back > 0.35f * p->covered || p->farthest > 2000.0f * p->nearest)
        return false;
    switch (shot->kind) {
    case PBNDS_SHOT_OBJECT:
        return p->subject > 0.12f && p->subject_at_edge < 0.5f;
    case PBNDS_SHOT_SCENE:
    case PBNDS_SHOT_PORTRAIT:
        return p->subject > 0.15f && p->subject_at_edge < 0.6f;
    case PBNDS_SHOT_DETAIL:
        return p->covered > 0.5f && p->centre > 0.8f * shot->focus;
    case PBNDS_SHOT_ROOM:
        return p->covered > 0.6f;
    case PBNDS_SHOT_FILE:
    case PBNDS_SHOT_COUNT:
        break;
    }
    return true;
}

static bool is_good(const struct stage *stage, const struct pbnds_shot *shot,
                    bool strict)
{
    if (!(shot->focus > 0.0f) || !stands_well(stage, shot, strict)) return false;
    struct pbnds_probe probe;
    pbnds_probe(stage->scene, stage->accel, stage->subjects, &shot->camera,
                shot->object, stage->aspect, &probe);
    return sees_well(stage, shot, &probe, strict);
}

/* The last attempts ask for less: there are scenes of one sheet, or that are inside out. */
bool pbnds_draw_camera(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                       const struct pbnds_subjects *subjects, float aspect,
                       struct pbnds_rng *rng, struct pbnds_shot *shot)
{
    const struct pbnds_subject *whole = &subjects->items[0];
    const struct stage stage = {
        scene, accel, subjects, aspect,
        .radius = 0.5f * pbnds_length(pbnds_sub(whole->hi, whole->lo))};
    if (scene->mesh_count < 1) return false;
    for (int attempt = 0; attempt < ATTEMPTS; ++attempt) {
        draw_shot(&stage, rng, shot);
        shot->attempts = attempt + 1;
        if (is_good(&stage, shot, attempt < STRICT_ATTEMPTS)) return true;
    }
    return false;
}
