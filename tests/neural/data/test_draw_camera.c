/* Cameras stand in free space and see what they are for. */
#include "tests/neural/data/fixture_scene.h"

#include "neural/data/draw_camera.h"
#include "neural/data/draw_probe.h"

struct stage {
    struct pbnds_scene scene;
    struct pbnds_accel *accel;
    struct pbnds_subjects subjects;
};

static void set(struct stage *s)
{
    s->accel = fixture_accel(&s->scene);
    assert_true(pbnds_subjects_find(&s->scene, s->accel, &s->subjects));
}

static void clear(struct stage *s)
{
    pbnds_subjects_free(&s->subjects);
    pbnds_accel_free(s->accel);
    pbnds_scene_free(&s->scene);
}

/* A ground with three boxes. */
static struct stage yard(void)
{
    struct stage s;
    fixture_scene(&s.scene);
    fixture_box(&s.scene, pbnds_vec3_make(-4, -0.05f, -4), pbnds_vec3_make(4, 0, 4),
                false);
    fixture_box(&s.scene, pbnds_vec3_make(-2, 0, -1), pbnds_vec3_make(-1, 1, 0), false);
    fixture_box(&s.scene, pbnds_vec3_make(0.5f, 0, -1), pbnds_vec3_make(1.5f, 2, 0),
                false);
    fixture_box(&s.scene, pbnds_vec3_make(0, 0, 1), pbnds_vec3_make(0.5f, 0.4f, 1.6f),
                false);
    set(&s);
    return s;
}

static struct stage room(void)
{
    struct stage s;
    fixture_scene(&s.scene);
    fixture_box(&s.scene, pbnds_vec3_make(-3, 0, -2), pbnds_vec3_make(3, 2.5f, 2),
                true);
    fixture_box(&s.scene, pbnds_vec3_make(-1, 0, -1), pbnds_vec3_make(0, 1, 0), false);
    s.scene.materials[0].emissive = pbnds_splat(1.0f); /* it glows */
    set(&s);
    return s;
}

static struct pbnds_vec3 eye_of(const struct pbnds_shot *shot)
{
    const float *m = shot->camera.world_from_camera.m;
    return pbnds_vec3_make(m[12], m[13], m[14]);
}

static bool is_within(struct pbnds_vec3 p, const struct pbnds_mesh *box)
{
    const struct pbnds_vec3 lo = box->position[0], hi = box->position[7];
    return p.x > lo.x && p.y > lo.y && p.z > lo.z && p.x < hi.x && p.y < hi.y &&
           p.z < hi.z;
}

static void grounds_are_no_subjects(void **state)
{
    (void)state;
    struct stage s = yard();
    assert_true(s.subjects.backdrop[0]);
    assert_int_equal(s.subjects.count, 4); /* the whole and three boxes */
    assert_near(s.subjects.items[0].lo.y, 0.0, 0.0);
    assert_near(s.subjects.ground, 0.0, 0.0);
    assert_near(s.subjects.items[0].hi.y, 2.0, 0.0);
    assert_near(s.subjects.items[0].lo.x, -2.0, 0.0);
    assert_false(s.subjects.room);
    assert_false(s.subjects.upright);
    clear(&s);
    s = room();
    assert_true(s.subjects.room);
    clear(&s);
}

static void the_inside_of_a_box_is_known(void **state)
{
    (void)state;
    struct stage s = yard();
    for (int i = 0; i < 200; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(1, (uint64_t)i, 0);
        struct pbnds_vec3 p;
        p.x = -4.0f + 8.0f * pbnds_rng_float(&rng);
        p.y = 0.01f + 2.5f * pbnds_rng_float(&rng);
        p.z = -4.0f + 8.0f * pbnds_rng_float(&rng);
        if (i % 2) { /* in the tall box */
            p.x = 0.55f + 0.9f * (p.x + 4.0f) / 8.0f;
            p.y *= 0.75f;
            p.z = -0.95f + 0.9f * (p.z + 4.0f) / 8.0f;
        }
        bool within = false;
        for (int k = 0; k < s.scene.mesh_count; ++k)
            within = within || is_within(p, &s.scene.meshes[k]);
        const struct pbnds_surroundings around =
            pbnds_look_around(&s.scene, s.accel, p);
        assert_int_equal(pbnds_is_inside(&around), within);
        /* below, the ground's face and the box's are one */
        if (within) assert_true(around.back >= PBNDS_SURROUNDING_RAYS - 4);
    }
    clear(&s);
}

static void cameras_stand_free_and_see_enough(void **state)
{
    (void)state;
    struct stage s = yard();
    int kinds[PBNDS_SHOT_COUNT] = {0}, below = 0, rolled = 0;
    float narrow = 10.0f, wide = 0.0f;
    for (int i = 0; i < 300; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(2, (uint64_t)i, 1);
        struct pbnds_shot shot;
        const float aspect = i % 2 ? 1.0f : 1.6f;
        assert_true(
            pbnds_draw_camera(&s.scene, s.accel, &s.subjects, aspect, &rng, &shot));
        ++kinds[shot.kind];
        rolled += shot.roll_deg != 0.0f;
        narrow = fminf(narrow, shot.camera.yfov);
        wide = fmaxf(wide, shot.camera.yfov);
        for (int k = 0; k < s.scene.mesh_count; ++k)
            assert_false(is_within(eye_of(&shot), &s.scene.meshes[k]));
        below += eye_of(&shot).y < 0.0f;
        /* Judged anew, by rays of another grid. */
        int covered = 0, subject = 0;
        for (int k = 0; k < 40 * 40; ++k) {
            const struct pbnds_ray ray = pbnds_camera_ray(
                &shot.camera, (int)(40.0f * aspect), 40,
                ((float)(k % 40) + 0.5f) * aspect, (float)(k / 40) + 0.5f);
            struct pbnds_hit hit;
            pbnds_accel_intersect(s.accel, &ray, &hit);
            if (hit.mesh == UINT32_MAX) continue;
            ++covered;
            assert_true(hit.t > 0.05f * shot.focus);
            subject +=
                shot.object == UINT32_MAX ? hit.mesh != 0 : hit.mesh == shot.object;
        }
        assert_true(covered > 1600 * 12 / 100);
        if (shot.attempts <= 28 && shot.kind != PBNDS_SHOT_DETAIL)
            assert_true(subject > 1600 * 9 / 100);
    }
    assert_int_equal(below, 0);
    assert_true(kinds[PBNDS_SHOT_SCENE] > 50 && kinds[PBNDS_SHOT_OBJECT] > 50 &&
                kinds[PBNDS_SHOT_DETAIL] > 10);
    assert_int_equal(kinds[PBNDS_SHOT_ROOM] + kinds[PBNDS_SHOT_FILE], 0);
    assert_true(rolled > 10 && rolled < 75);
    assert_true(narrow < 0.35f && wide > 1.15f);
    clear(&s);
}

static void rooms_are_seen_from_inside(void **state)
{
    (void)state;
    struct stage s = room();
    int inside = 0;
    for (int i = 0; i < 60; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(3, (uint64_t)i, 1);
        struct pbnds_shot shot;
        assert_true(
            pbnds_draw_camera(&s.scene, s.accel, &s.subjects, 1.0f, &rng, &shot));
        inside += is_within(eye_of(&shot), &s.scene.meshes[0]);
        assert_false(is_within(eye_of(&shot), &s.scene.meshes[1]));
    }
    assert_int_equal(inside, 60);
    /* Without that light such a room is black: only what is left to the last
     * attempts shows it. */
    s.scene.materials[0].emissive = pbnds_splat(0.0f);
    for (int i = 0; i < 10; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(3, (uint64_t)i, 1);
        struct pbnds_shot shot;
        if (pbnds_draw_camera(&s.scene, s.accel, &s.subjects, 1.0f, &rng, &shot))
            assert_true(shot.attempts > 28);
    }
    clear(&s);
}

/* A camera of the file that stands in a box is no help, moved a little or not. */
static void cameras_of_the_file_are_used_and_judged(void **state)
{
    (void)state;
    struct stage s = yard();
    s.scene.cameras = calloc(1, sizeof *s.scene.cameras);
    assert_non_null(s.scene.cameras);
    s.scene.camera_count = 1;
    s.scene.cameras[0] =
        pbnds_camera_framing(s.scene.lo, s.scene.hi, 20.0f, 15.0f, 40.0f, 1.0f);
    const struct pbnds_camera good = s.scene.cameras[0];
    int used = 0;
    for (int pass = 0; pass < 2; ++pass) {
        int file = 0;
        for (int i = 0; i < 60; ++i) {
            struct pbnds_rng rng = pbnds_rng_make(4, (uint64_t)i, 1);
            struct pbnds_shot shot;
            assert_true(
                pbnds_draw_camera(&s.scene, s.accel, &s.subjects, 1.0f, &rng, &shot));
            file += shot.kind == PBNDS_SHOT_FILE;
        }
        if (pass == 0) used = file;
        if (pass == 1) assert_int_equal(file, 0);
        s.scene.cameras[0] = good;
        s.scene.cameras[0].world_from_camera.m[12] = 1.0f; /* in the tall box */
        s.scene.cameras[0].world_from_camera.m[13] = 1.0f;
        s.scene.cameras[0].world_from_camera.m[14] = -0.5f;
    }
    assert_true(used > 5 && used < 40);
    clear(&s);
}

static void roll_turns_the_picture(void **state)
{
    (void)state;
    struct stage s = yard();
    for (int i = 0; i < 200; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(2, (uint64_t)i, 1);
        struct pbnds_shot shot;
        assert_true(
            pbnds_draw_camera(&s.scene, s.accel, &s.subjects, 1.0f, &rng, &shot));
        const float *m = shot.camera.world_from_camera.m;
        /* The camera's x axis leaves the horizon by the roll. */
        const float flat = sqrtf(1.0f - m[9] * m[9]);
        assert_near(asinf(pbnds_clamp(-m[1] / flat, -1.0f, 1.0f)) * 180.0f / PBNDS_PI,
                    shot.roll_deg, 0.05);
        for (int a = 0; a < 3; ++a) {
            for (int b = 0; b < 3; ++b)
                assert_near(m[4 * a] * m[4 * b] + m[4 * a + 1] * m[4 * b + 1] +
                                m[4 * a + 2] * m[4 * b + 2],
                            a == b, 1e-5);
        }
    }
    clear(&s);
}

static void nothing_gives_no_camera(void **state)
{
    (void)state;
    struct stage s;
    fixture_scene(&s.scene);
    s.scene.lo = s.scene.hi = pbnds_splat(0.0f);
    set(&s);
    struct pbnds_rng rng = pbnds_rng_make(1, 1, 1);
    struct pbnds_shot shot;
    assert_false(pbnds_draw_camera(&s.scene, s.accel, &s.subjects, 1.0f, &rng, &shot));
    clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(grounds_are_no_subjects),
        cmocka_unit_test(the_inside_of_a_box_is_known),
        cmocka_unit_test(cameras_stand_free_and_see_enough),
        cmocka_unit_test(rooms_are_seen_from_inside),
        cmocka_unit_test(cameras_of_the_file_are_used_and_judged),
        cmocka_unit_test(roll_turns_the_picture),
        cmocka_unit_test(nothing_gives_no_camera),
    };
    return cmocka_run_group_tests_name("neural/data/draw_camera", tests, NULL, NULL);
}
