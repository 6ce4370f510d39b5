/* Transparent surfaces met by chance: the mean over seeds is the composite over layers. */
#include "tests/test.h"

#include "engine/scene/accel.h"
#include "tests/engine/scene/fixture.h"

enum { LAYERS = 4, SEEDS = 40000 };

/* Sheets across the z axis, each two triangles, nearest first at z = 0. */
struct stack {
    struct fixture f;
    struct pbnds_vec3 position[LAYERS][4];
    uint32_t index[LAYERS][6];
    struct pbnds_accel *accel;
};

static void make_stack(struct stack *s, const float alpha[LAYERS])
{
    static const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    struct pbnds_error error;
    fixture_init(&s->f);
    for (int k = 0; k < LAYERS; ++k) {
        const float z = (float)-k;
        const struct pbnds_vec3 corner[4] = {
            {-1.0f, -1.0f, z}, {1.0f, -1.0f, z}, {1.0f, 1.0f, z}, {-1.0f, 1.0f, z}};
        memcpy(s->position[k], corner, sizeof corner);
        memcpy(s->index[k], index, sizeof index);
        fixture_mesh(&s->f, s->position[k], 4, s->index[k], 2)->material = k;
        s->f.materials[k].alpha_mode = PBNDS_ALPHA_BLEND;
        s->f.materials[k].base_color.w = alpha[k];
    }
    if (pbnds_accel_create(&s->f.scene, &s->accel, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
}

static const struct pbnds_ray AHEAD = {{0.3f, 0.2f, 5.0f}, {0.0f, 0.0f, -1.0f}};

/* How often each layer is the first, and how often none is. */
static void count_first(const struct stack *s, double share[LAYERS + 1])
{
    for (int k = 0; k <= LAYERS; ++k)
        share[k] = 0.0;
    for (uint32_t seed = 0; seed < SEEDS; ++seed) {
        const struct pbnds_query how = {
            .max_t = INFINITY, .stochastic = true, .seed = seed};
        struct pbnds_hit hit;
        pbnds_accel_intersect_query(s->accel, &AHEAD, &how, &hit);
        share[hit.mesh == UINT32_MAX ? LAYERS : hit.mesh] += 1.0 / SEEDS;
    }
}

static void layers_are_composited(void **state)
{
    (void)state;
    struct stack s;
    const float alpha[LAYERS] = {0.3f, 0.0f, 0.6f, 0.8f};
    double share[LAYERS + 1], through = 1.0;
    make_stack(&s, alpha);
    assert_true(pbnds_accel_blends(s.accel));
    count_first(&s, share);
    for (int k = 0; k < LAYERS; ++k) {
        assert_near(share[k], through * (double)alpha[k], 0.01); /* four sigmas */
        through *= 1.0 - (double)alpha[k];
    }
    assert_near(share[LAYERS], through, 0.01);
    pbnds_accel_free(s.accel);
}

/* What shadow rays let pass, and that each agrees with the ray of its seed that looks for
 * the closest hit: in any order of traversal. */
static void shadow_rays_see_the_same_layers(void **state)
{
    (void)state;
    struct stack s;
    const float alpha[LAYERS] = {0.3f, 0.1f, 0.2f, 0.4f};
    make_stack(&s, alpha);
    int clear = 0, near = 0;
    for (uint32_t seed = 0; seed < SEEDS; ++seed) {
        struct pbnds_query how = {.max_t = INFINITY, .stochastic = true, .seed = seed};
        struct pbnds_hit hit;
        const struct pbnds_ray back = {{0.3f, 0.2f, -9.0f}, {0.0f, 0.0f, 1.0f}};
        pbnds_accel_intersect_query(s.accel, &AHEAD, &how, &hit);
        const bool blocked = pbnds_accel_occluded_query(s.accel, &AHEAD, &how);
        assert_int_equal(blocked, hit.mesh != UINT32_MAX);
        assert_int_equal(pbnds_accel_occluded_query(s.accel, &back, &how), blocked);
        clear += !blocked;
        how.max_t = 6.5f; /* the first two */
        near += !pbnds_accel_occluded_query(s.accel, &AHEAD, &how);
        how.max_t = blocked ? hit.t * 0.999f : 1.0f;
        assert_false(pbnds_accel_occluded_query(s.accel, &AHEAD, &how));
    }
    assert_near(clear / (double)SEEDS, 0.7 * 0.9 * 0.8 * 0.6, 0.01);
    assert_near(near / (double)SEEDS, 0.7 * 0.9, 0.01);
    pbnds_accel_free(s.accel);
}

/* Rays at the diagonal of the sheets, and at their middle: two triangles, or all corners,
 * of one layer; the vertices of the second sheet are not shared. */
static void an_edge_is_one_layer(void **state)
{
    (void)state;
    struct stack s;
    const float alpha[LAYERS] = {0.3f, 0.0f, 0.0f, 0.0f};
    make_stack(&s, alpha);
    pbnds_accel_free(s.accel);
    /* the first sheet as four triangles around the middle, each with its own corners */
    struct pbnds_vec3 fan[12];
    uint32_t index[12];
    const struct pbnds_vec3 middle = {0.0f, 0.0f, 0.0f};
    for (uint32_t k = 0; k < 4; ++k) {
        fan[3 * k] = k % 2 ? s.position[0][k] : middle;
        fan[3 * k + 1] = k % 2 ? s.position[0][(k + 1) % 4] : s.position[0][k];
        fan[3 * k + 2] = k % 2 ? middle : s.position[0][(k + 1) % 4];
    }
    for (uint32_t k = 0; k < 12; ++k)
        index[k] = k;
    for (int form = 0; form < 2; ++form) {
        struct pbnds_error error;
        if (form == 1) {
            s.f.meshes[0].position = fan;
            s.f.meshes[0].vertex_count = 12;
            s.f.meshes[0].index = index;
            s.f.meshes[0].triangle_count = 4;
        }
        if (pbnds_accel_create(&s.f.scene, &s.accel, &error) != PBNDS_OK)
            fail_msg("%s", error.message);
        const float at[3] = {0.0f, 0.5f, -0.3f};
        for (int k = 0; k < 3; ++k) {
            const struct pbnds_ray ray = {{at[k], at[k], 5.0f}, {0.0f, 0.0f, -1.0f}};
            int met = 0;
            for (uint32_t seed = 0; seed < SEEDS; ++seed) {
                const struct pbnds_query how = {
                    .max_t = INFINITY, .stochastic = true, .seed = seed};
                met += pbnds_accel_occluded_query(s.accel, &ray, &how);
            }
            assert_near(met / (double)SEEDS, 0.3, 0.01);
        }
        pbnds_accel_free(s.accel);
    }
}

/* Seeds next to each other, and layers of one seed, are independent: the counts of pairs
 * are the products. */
static void seeds_and_layers_are_independent(void **state)
{
    (void)state;
    struct stack s;
    const float alpha[LAYERS] = {0.5f, 0.5f, 0.5f, 0.5f};
    make_stack(&s, alpha);
    int both = 0, next = 0;
    bool before = false;
    for (uint32_t seed = 0; seed < SEEDS; ++seed) {
        const struct pbnds_query first = {
            .max_t = 5.5f, .stochastic = true, .seed = seed};
        const struct pbnds_query second = {
            .min_t = 5.5f, .max_t = 6.5f, .stochastic = true, .seed = seed};
        const bool a = pbnds_accel_occluded_query(s.accel, &AHEAD, &first);
        const bool b = pbnds_accel_occluded_query(s.accel, &AHEAD, &second);
        both += a && b;
        next += a && before;
        before = a;
    }
    assert_near(both / (double)SEEDS, 0.25, 0.01);
    assert_near(next / (double)SEEDS, 0.25, 0.01);
    pbnds_accel_free(s.accel);
}

/* The plain rule, the solid rule, and MASK, which chance does not touch. */
static void other_queries_keep_their_rules(void **state)
{
    (void)state;
    struct stack s;
    const float alpha[LAYERS] = {0.1f, 0.4f, 0.45f, 0.5f};
    struct pbnds_hit hit;
    make_stack(&s, alpha);
    pbnds_accel_intersect(s.accel, &AHEAD, &hit);
    assert_int_equal(hit.mesh, 3);
    const struct pbnds_query solid = {.max_t = INFINITY, .blend_solid = true};
    pbnds_accel_intersect_query(s.accel, &AHEAD, &solid, &hit);
    assert_int_equal(hit.mesh, 0);
    pbnds_accel_free(s.accel);

    make_stack(&s, alpha);
    pbnds_accel_free(s.accel);
    s.f.materials[0].base_color.w = 0.0f; /* solid means seen at all */
    s.f.materials[1].alpha_mode = PBNDS_ALPHA_MASK;
    s.f.materials[1].alpha_cutoff = 0.45f; /* cut out */
    s.f.materials[2].alpha_mode = PBNDS_ALPHA_MASK;
    s.f.materials[2].alpha_cutoff = 0.4f; /* stays */
    struct pbnds_error error;
    if (pbnds_accel_create(&s.f.scene, &s.accel, &error) != PBNDS_OK)
        fail_msg("%s", error.message);
    pbnds_accel_intersect_query(s.accel, &AHEAD, &solid, &hit);
    assert_int_equal(hit.mesh, 2);
    for (uint32_t seed = 0; seed < 100; ++seed) {
        const struct pbnds_query how = {
            .max_t = INFINITY, .stochastic = true, .seed = seed};
        pbnds_accel_intersect_query(s.accel, &AHEAD, &how, &hit);
        assert_int_equal(hit.mesh, 2);
    }
    pbnds_accel_free(s.accel);
}

static void only_transparency_blends(void **state)
{
    (void)state;
    struct stack s;
    const float solid[LAYERS] = {1.0f, 1.0f, 1.0f, 1.0f};
    make_stack(&s, solid);
    assert_false(pbnds_accel_blends(s.accel));
    double share[LAYERS + 1];
    count_first(&s, share);
    assert_near(share[0], 1.0, 1e-9);
    pbnds_accel_free(s.accel);
}

/* Alpha that is no number, or out of range, is one of the two extremes. */
static void odd_alpha_is_harmless(void **state)
{
    (void)state;
    struct stack s;
    const float alpha[LAYERS] = {(float)NAN, -3.0f, 7.0f, 0.5f};
    double share[LAYERS + 1];
    make_stack(&s, alpha);
    count_first(&s, share);
    assert_near(share[2], 1.0, 1e-9);
    pbnds_accel_free(s.accel);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_are_composited),
        cmocka_unit_test(shadow_rays_see_the_same_layers),
        cmocka_unit_test(an_edge_is_one_layer),
        cmocka_unit_test(seeds_and_layers_are_independent),
        cmocka_unit_test(other_queries_keep_their_rules),
        cmocka_unit_test(only_transparency_blends),
        cmocka_unit_test(odd_alpha_is_harmless),
    };
    return cmocka_run_group_tests_name("engine/scene/accel_alpha", tests, NULL, NULL);
}
