#include "neural/data/draw_probe.h"

enum { ROWS = 32, MOST_COLUMNS = 64, SKY_STEP = 4 };

/* Sums over the pixels, and the rays to the sky that are not yet asked. */
struct count {
    int covered, back, subject, edge, subject_at_edge;
    struct pbnds_vec3 normals;
    struct pbnds_ray sky[PBNDS_PACKET];
    int waiting, asked, reached;
};

static bool is_lamp(const struct pbnds_scene *scene, const struct pbnds_hit *hit)
{
    const struct pbnds_material *m =
        &scene->materials[scene->meshes[hit->mesh].material];
    return !m->unlit && pbnds_max3(m->emissive) > 0.5f;
}

static void ask_sky(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                    struct count *count)
{
    struct pbnds_hit hits[PBNDS_PACKET];
    pbnds_accel_intersect_packet(accel, count->sky, count->waiting, hits);
    for (int i = 0; i < count->waiting; ++i)
        count->reached += hits[i].mesh == UINT32_MAX || is_lamp(scene, &hits[i]);
    count->asked += count->waiting;
    count->waiting = 0;
}

/* Cosine distributed: the normal plus a point of the unit sphere, of the sequence of
 * multiples of the golden ratio. */
static struct pbnds_vec3 sky_direction(struct pbnds_vec3 n, int i)
{
    const float y = 1.0f - 2.0f * ((float)(i % 61) + 0.5f) / 61.0f;
    const float turn = 0.61803399f * (float)i;
    const float azimuth = 2.0f * PBNDS_PI * (turn - floorf(turn));
    const float r = sqrtf(1.0f - y * y);
    const struct pbnds_vec3 d = {n.x + r * cosf(azimuth), n.y + y,
                                 n.z + r * sinf(azimuth)};
    const float length = pbnds_length(d);
    return length > 1e-3f ? pbnds_scale(d, 1.0f / length) : n;
}

static bool is_subject(const struct pbnds_subjects *subjects, uint32_t object,
                       uint32_t seen)
{
    if (object != UINT32_MAX) return seen == object;
    return seen >= (uint32_t)subjects->backdrop_size || !subjects->backdrop[seen];
}

static void count_hit(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                      const struct pbnds_ray *ray, const struct pbnds_hit *hit,
                      struct count *count, struct pbnds_probe *probe)
{
    struct pbnds_vec3 n = pbnds_hit_normal(scene, hit);
    if (pbnds_dot(n, ray->direction) > 0.0f) {
        ++count->back;
        n = pbnds_scale(n, -1.0f);
    }
    ++count->covered;
    count->normals = pbnds_add(count->normals, n);
    probe->nearest = fminf(probe->nearest, hit->t);
    probe->farthest = fmaxf(probe->farthest, hit->t);
    if (count->covered % SKY_STEP != 0) return;
    const struct pbnds_vec3 p = pbnds_mad(ray->origin, ray->direction, hit->t);
    count->sky[count->waiting++] = (struct pbnds_ray){
        pbnds_offset_origin(p, n), sky_direction(n, count->covered / SKY_STEP)};
    if (count->waiting == PBNDS_PACKET) ask_sky(scene, accel, count);
}

void pbnds_probe(const struct pbnds_scene *scene, const struct pbnds_accel *accel,
                 const struct pbnds_subjects *subjects,
                 const struct pbnds_camera *camera, uint32_t object, float aspect,
                 struct pbnds_probe *probe)
{
    const int columns =
        (int)pbnds_clamp((float)ROWS * aspect + 0.5f, 8.0f, (float)MOST_COLUMNS);
    const struct pbnds_camera_view view = pbnds_camera_view(camera, columns, ROWS);
    struct count count = {0};
    *probe = (struct pbnds_probe){.nearest = INFINITY, .centre = INFINITY};
    for (int first = 0; first < columns * ROWS; first += PBNDS_PACKET) {
        struct pbnds_ray rays[PBNDS_PACKET];
        struct pbnds_hit hits[PBNDS_PACKET];
        int n = 0;
        for (; n < PBNDS_PACKET && first + n < columns * ROWS; ++n)
            rays[n] =
                pbnds_camera_view_ray(&view, (float)((first + n) % columns) + 0.5f,
                                      (float)((first + n) / columns) + 0.5f);
        pbnds_accel_intersect_packet(accel, rays, n, hits);
        for (int i = 0; i < n; ++i) {
            const int x = (first + i) % columns, y = (first + i) / columns;
            const bool edge = x == 0 || y == 0 || x == columns - 1 || y == ROWS - 1;
            count.edge += edge;
            if (hits[i].mesh == UINT32_MAX) continue;
            count_hit(scene, accel, &rays[i], &hits[i], &count, probe);
            if (x == columns / 2 && y == ROWS / 2) probe->centre = hits[i].t;
            if (!is_subject(subjects, object, scene->meshes[hits[i].mesh].object_id))
                continue;
            ++count.subject;
            count.subject_at_edge += edge;
        }
    }
    if (count.waiting > 0) ask_sky(scene, accel, &count);
    const float pixels = (float)(columns * ROWS);
    probe->open = count.asked > 0 ? (float)count.reached / (float)count.asked : 1.0f;
    probe->covered = (float)count.covered / pixels;
    probe->back = (float)count.back / pixels;
    probe->subject = (float)count.subject / pixels;
    probe->subject_at_edge = (float)count.subject_at_edge / (float)count.edge;
    probe->flat = pbnds_length(count.normals) > 0.93f * (float)count.covered;
}
