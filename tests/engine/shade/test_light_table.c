/* The choice between lights, and points on emitting triangles. */
#include "engine/shade/light_table.h"

#include "engine/core/rng.h"
#include "engine/shade/light_punctual.h"
#include "engine/shade/sampler.h"
#include "tests/engine/shade/fixture.h"

static void make(const struct fixture *f, struct pbnds_light_table *table)
{
    struct pbnds_error error;
    must(pbnds_light_table_create(&f->scene, f->envmap, table, &error), &error);
}

/* Quads of areas 1, 2, 4 and emissions 3, 1, 0; a floor that does not emit. */
static void three_emitters(struct fixture *f)
{
    struct pbnds_material m[4] = {matte(0.5f), matte(0.5f), matte(0.5f), matte(0.5f)};
    m[1].emissive = pbnds_splat(3.0f);
    m[2].emissive = pbnds_splat(1.0f);
    m[2].double_sided = true;
    const struct pbnds_vec3 z = {0.0f, 0.0f, 1.0f};
    const struct pbnds_mesh meshes[4] = {floor_at(0.0f, 5.0f, 0),
                                         quad(pbnds_vec3_make(0.0f, 1.0f, 0.0f),
                                              pbnds_vec3_make(1.0f, 0.0f, 0.0f), z, 1),
                                         quad(pbnds_vec3_make(2.0f, 1.0f, 0.0f),
                                              pbnds_vec3_make(2.0f, 0.0f, 0.0f), z, 2),
                                         quad(pbnds_vec3_make(-4.0f, 1.0f, 0.0f),
                                              pbnds_vec3_make(4.0f, 0.0f, 0.0f), z, 3)};
    fixture_scene(f, meshes, 4, m, 4);
}

static void add_lights(struct fixture *f, const struct pbnds_light *lights, int count)
{
    f->scene.lights = must_alloc((size_t)count, sizeof *lights);
    memcpy(f->scene.lights, lights, (size_t)count * sizeof *lights);
    f->scene.light_count = count;
}

static void the_list_holds_what_emits(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_light_table table;
    three_emitters(&f);
    f.scene.materials[3].unlit = true;
    f.scene.materials[3].emissive = pbnds_splat(9.0f);
    make(&f, &table);
    const struct pbnds_emissive *e = &table.emissive;
    assert_int_equal(e->count, 4);
    assert_true(pbnds_emissive_find(e, 0, 0) == SIZE_MAX);
    assert_true(pbnds_emissive_find(e, 3, 1) == SIZE_MAX);
    const double pi = (double)PBNDS_PI;
    for (uint32_t k = 0; k < 2; ++k) {
        const struct pbnds_emissive_triangle *one =
            &e->triangles[pbnds_emissive_find(e, 1, k)];
        const struct pbnds_emissive_triangle *two =
            &e->triangles[pbnds_emissive_find(e, 2, k)];
        assert_near(one->area, 0.5, 1e-6);
        assert_near(one->power, 2.0 * pi * 0.5 * 3.0, 1e-5);
        assert_near(two->area, 1.0, 1e-6);
        assert_near(two->power, 2.0 * pi * 1.0 * 1.0, 1e-5);
        assert_int_equal(one->triangle, k);
    }
    pbnds_light_table_free(&table);
    fixture_free(&f);
}

/* Counts of choices against probabilities, and these against powers. */
static void choices_follow_power(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_light_table table;
    const struct pbnds_light lights[3] = {
        {.kind = PBNDS_LIGHT_POINT, .intensity = {1.0f, 1.0f, 1.0f}, .range = INFINITY},
        {.kind = PBNDS_LIGHT_SPOT}, /* dark */
        {.kind = PBNDS_LIGHT_POINT,
         .intensity = {5.0f, 5.0f, 5.0f},
         .range = INFINITY}};
    enum { N = 1 << 20 };
    static int count[8];
    double sum = 0.0, weight[8] = {0.0};
    three_emitters(&f);
    add_lights(&f, lights, 3);
    fixture_light(&f, 8, light_white);
    make(&f, &table);
    assert_int_equal(table.count, 8);
    for (uint32_t i = 0; i < N; ++i) {
        const struct pbnds_light_choice c =
            pbnds_light_table_choose(&table, i * (uint32_t)((1ull << 32) / N));
        const size_t entry = c.kind == PBNDS_LIGHT_CLASS_MAP        ? 0
                             : c.kind == PBNDS_LIGHT_CLASS_PUNCTUAL ? 1 + c.index
                                                                    : 4 + c.index;
        ++count[entry];
        weight[entry] = (double)c.probability;
    }
    for (int i = 0; i < 8; ++i) {
        assert_near(count[i] / (double)N, weight[i], 2.0 / N);
        sum += weight[i];
    }
    assert_near(sum, 1.0, 1e-6);
    assert_near(weight[0], table.map_probability, 0.0);
    assert_near(weight[2], 0.0, 0.0);
    /* 4 pi I of the points, of the triangles 2 pi A L; shares with their even part */
    assert_near(weight[3] / weight[1], (0.9 * 5.0 / 6.0 + 0.05) / (0.9 / 6.0 + 0.05),
                1e-4);
    assert_near(weight[4] / weight[6], 1.5, 1e-4);
    const double pi = (double)PBNDS_PI, emitted = 2.0 * pi * 5.0;
    const struct pbnds_vec3 d = pbnds_sub(f.scene.hi, f.scene.lo);
    const double map = pi * (double)pbnds_dot(d, d) / 4.0 * 4.0 * pi;
    const double all = emitted + map + 4.0 * pi * 6.0;
    assert_near(weight[0], 0.75 * map / all + 0.25 / 3.0, 1e-3);
    assert_near(weight[4] + weight[5] + weight[6] + weight[7],
                0.75 * emitted / all + 0.25 / 3.0, 1e-3);
    pbnds_light_table_free(&table);
    fixture_free(&f);
}

/* Mean over all directions of what arrives one metre off, next to a point light's. */
static double mean_irradiance(const struct pbnds_light *light)
{
    enum { RINGS = 400, AROUND = 64 };
    double sum = 0.0;
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const double z = 1.0 - 2.0 * (i / AROUND + 0.5) / RINGS;
        const double r = sqrt(1.0 - z * z),
                     phi = 2.0 * (double)PBNDS_PI * (i % AROUND) / AROUND;
        const struct pbnds_vec3 p = {(float)(r * cos(phi)), (float)(r * sin(phi)),
                                     (float)z};
        struct pbnds_punctual arriving;
        if (pbnds_light_punctual(light, p, &arriving))
            sum += (double)arriving.irradiance.x;
    }
    return sum / (RINGS * AROUND);
}

/* A spot is chosen as often as a point light of its intensity would be, times the share of
 * the sphere that its falloff lights. */
static void a_spot_counts_by_what_it_sends(void **state)
{
    (void)state;
    static const float cones[][2] = {
        {1.0f, 0.5f}, {0.9f, 0.85f}, {0.6f, -0.7f}, {0.2f, 0.1f}};
    for (size_t i = 0; i < sizeof cones / sizeof cones[0]; ++i) {
        const struct pbnds_light lights[2] = {
            {.kind = PBNDS_LIGHT_POINT, .intensity = {1, 1, 1}, .range = INFINITY},
            {.kind = PBNDS_LIGHT_SPOT,
             .intensity = {1, 1, 1},
             .range = INFINITY,
             .direction = {0.0f, 0.6f, 0.8f},
             .cos_inner = cones[i][0],
             .cos_outer = cones[i][1]}};
        struct fixture f;
        struct pbnds_light_table table;
        const struct pbnds_material m = matte(0.5f);
        const struct pbnds_mesh mesh = floor_at(0.0f, 1.0f, 0);
        fixture_scene(&f, &mesh, 1, &m, 1);
        add_lights(&f, lights, 2);
        make(&f, &table);
        const double share = mean_irradiance(&lights[1]) / mean_irradiance(&lights[0]);
        const struct pbnds_light_choice spot =
            pbnds_light_table_choose(&table, UINT32_MAX);
        assert_int_equal(spot.kind, PBNDS_LIGHT_CLASS_PUNCTUAL);
        assert_int_equal(spot.index, 1);
        assert_near(spot.probability, 0.9 * share / (1.0 + share) + 0.05, 1e-3);
        pbnds_light_table_free(&table);
        fixture_free(&f);
    }
}

static void one_light_needs_no_choice(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_light_table table;
    const struct pbnds_material m = matte(0.5f);
    const struct pbnds_mesh mesh = floor_at(0.0f, 1.0f, 0);
    const struct pbnds_light dark = {.kind = PBNDS_LIGHT_POINT, .range = INFINITY};
    fixture_scene(&f, &mesh, 1, &m, 1);
    make(&f, &table);
    assert_int_equal(table.count, 0); /* no light at all */
    pbnds_light_table_free(&table);
    fixture_light(&f, 8, light_black);
    make(&f, &table);
    assert_int_equal(table.count, 0);
    pbnds_light_table_free(&table);
    fixture_light(&f, 8, light_sunny);
    add_lights(&f, &dark, 1);
    make(&f, &table);
    assert_near(table.map_probability, 1.0, 0.0);
    const struct pbnds_light_choice c = pbnds_light_table_choose(&table, UINT32_MAX);
    assert_int_equal(c.kind, PBNDS_LIGHT_CLASS_MAP);
    assert_near(c.probability, 1.0, 0.0);
    pbnds_light_table_free(&table);
    fixture_free(&f);
}

/* A mesh of many triangles of sizes over six orders: each is found with its share, and
 * the shares sum to one. */
static void a_hundred_thousand_triangles(void **state)
{
    (void)state;
    enum { N = 100000, DRAWS = 200000 };
    struct fixture f;
    struct pbnds_light_table table;
    struct pbnds_material m = matte(0.5f);
    m.emissive = pbnds_splat(1.0f);
    struct pbnds_mesh mesh = new_mesh(3 * (size_t)N, N, 0);
    struct pbnds_rng rng = pbnds_rng_make(5, 0, 0);
    for (uint32_t i = 0; i < N; ++i) {
        const float size = powf(10.0f, -3.0f * pbnds_rng_float(&rng));
        const struct pbnds_vec3 p = {pbnds_rng_float(&rng), pbnds_rng_float(&rng),
                                     pbnds_rng_float(&rng)};
        mesh.position[3 * i] = p;
        mesh.position[3 * i + 1] = pbnds_vec3_make(p.x + size, p.y, p.z);
        mesh.position[3 * i + 2] = pbnds_vec3_make(p.x, p.y + size, p.z);
        for (uint32_t k = 0; k < 3; ++k)
            mesh.index[3 * i + k] = 3 * i + k;
    }
    fixture_scene(&f, &mesh, 1, &m, 1);
    make(&f, &table);
    double total = 0.0, mean_area = 0.0, inverse = 0.0;
    for (size_t i = 0; i < N; ++i)
        total += (double)table.emissive.triangles[i].power;
    for (uint32_t i = 0; i < DRAWS; ++i) {
        const struct pbnds_light_choice c =
            pbnds_light_table_choose(&table, (uint32_t)(pbnds_rng_u64(&rng) >> 32));
        const struct pbnds_emissive_triangle *t = &table.emissive.triangles[c.index];
        assert_int_equal(c.kind, PBNDS_LIGHT_CLASS_EMISSIVE);
        assert_near(c.probability, (double)t->power / total, 2e-9);
        const struct pbnds_hit hit = {2.0f, 0.2f, 0.2f, 0, t->triangle};
        assert_near(pbnds_light_table_emissive_pdf(&table, &hit, -0.5f),
                    (double)c.probability * 4.0 / (0.5 * (double)t->area),
                    1e-5 * 8.0 * (double)(c.probability / t->area));
        mean_area += (double)t->area / DRAWS;
        inverse += 1.0 / (double)c.probability / DRAWS;
    }
    double want = 0.0;
    for (size_t i = 0; i < N; ++i)
        want += (double)table.emissive.triangles[i].area *
                (double)table.emissive.triangles[i].power / total;
    assert_near(mean_area, want, 0.02 * want);
    assert_near(inverse, N, 0.1 * N); /* as many as there are */
    pbnds_light_table_free(&table);
    fixture_free(&f);
}

/* Points are uniform on the triangle; 1/pdf is the solid angle it fills. */
static void points_fill_the_triangle(void **state)
{
    (void)state;
    enum { N = 4096 };
    struct fixture f;
    struct pbnds_light_table table;
    three_emitters(&f);
    make(&f, &table);
    const struct pbnds_vec3 from = {0.4f, -0.5f, 0.3f};
    double u = 0.0, v = 0.0, square = 0.0, angle = 0.0;
    for (uint32_t s = 0; s < N; ++s) {
        const struct pbnds_sampler sampler = pbnds_sampler_make(3, 0, s, N);
        struct pbnds_emissive_sample out;
        float r[2];
        pbnds_sampler_get(&sampler, 0, 2, r);
        assert_true(pbnds_emissive_sample(&table.emissive, 0, from, r[0], r[1], &out));
        assert_near(pbnds_length(out.wi), 1.0, 1e-5);
        assert_true(out.hit.u >= 0.0f && out.hit.v >= 0.0f);
        assert_true(out.hit.u + out.hit.v <= 1.00001f);
        struct pbnds_hit hit;
        const struct pbnds_ray ray = {from, out.wi};
        const struct pbnds_query below = {.min_t = 0.6f, .max_t = INFINITY};
        pbnds_accel_intersect_query(f.accel, &ray, &below, &hit);
        assert_int_equal(hit.mesh, 1);
        assert_near(hit.t, out.hit.t, 1e-4);
        assert_true(pbnds_length(pbnds_sub(out.reach, from)) < out.hit.t);
        u += (double)out.hit.u / N;
        v += (double)out.hit.v / N;
        square += (double)(out.hit.u * out.hit.u) / N;
        angle += 1.0 / (double)out.pdf / N;
    }
    assert_near(u, 1.0 / 3.0, 1e-3);
    assert_near(v, 1.0 / 3.0, 1e-3);
    assert_near(square, 1.0 / 6.0, 1e-3);
    /* Van Oosterom and Strackee 1983 */
    struct pbnds_vec3 r[3];
    for (int k = 0; k < 3; ++k) {
        const struct pbnds_mesh *mesh = &f.scene.meshes[1];
        r[k] = pbnds_normalize(pbnds_sub(mesh->position[mesh->index[k]], from));
    }
    const double up = (double)pbnds_dot(r[0], pbnds_cross(r[1], r[2]));
    const double down = 1.0 + (double)pbnds_dot(r[0], r[1]) +
                        (double)pbnds_dot(r[1], r[2]) + (double)pbnds_dot(r[2], r[0]);
    assert_near(angle, fabs(2.0 * atan2(up, down)), 2e-3);
    pbnds_light_table_free(&table);
    fixture_free(&f);
}

/* Opacity: of a BLEND emitter alpha, of a MASK one all or nothing. */
static void a_transparent_emitter_sends_less(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_light_table table;
    three_emitters(&f);
    f.scene.materials[1].alpha_mode = PBNDS_ALPHA_BLEND;
    f.scene.materials[1].base_color.w = 0.25f;
    f.scene.materials[2].alpha_mode = PBNDS_ALPHA_MASK;
    f.scene.materials[2].base_color.w = 0.25f;
    make(&f, &table);
    struct pbnds_emissive_sample s;
    const struct pbnds_vec3 from = {0.0f, 0.0f, 0.0f};
    assert_true(pbnds_emissive_sample(&table.emissive, 0, from, 0.5f, 0.5f, &s));
    assert_near(pbnds_emissive_radiance(&table.emissive, &s).x, 0.75, 1e-6);
    assert_near(table.emissive.triangles[2].power, 0.0, 0.0);
    assert_int_equal(table.count,
                     3); /* the masked ones are behind the last that shines */
    const struct pbnds_hit hit = {1.0f, 0.2f, 0.2f, 2, 0};
    assert_near(pbnds_light_table_emissive_pdf(&table, &hit, 1.0f), 0.0, 0.0);
    pbnds_light_table_free(&table);
    fixture_free(&f);
}

/* Damaged triangles have no share and no point. */
static void degenerate_triangles_are_left_out(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_light_table table;
    struct pbnds_material m = matte(0.5f);
    m.emissive = pbnds_splat(1.0f);
    struct pbnds_mesh mesh = new_mesh(4, 3, 0);
    mesh.position[1].x = 1.0f;
    mesh.position[2].x = 2.0f;
    mesh.position[3].y = 1.0f;
    const uint32_t index[9] = {0, 0, 0, 0, 1, 2, 0, 1, 3};
    memcpy(mesh.index, index, sizeof index);
    fixture_scene(&f, &mesh, 1, &m, 1);
    make(&f, &table);
    assert_int_equal(pbnds_light_table_choose(&table, 0).index, 2);
    assert_near(pbnds_light_table_choose(&table, 0).probability, 1.0, 0.0);
    struct pbnds_emissive_sample s;
    const struct pbnds_vec3 from = {0.1f, 0.1f, 1.0f};
    assert_false(pbnds_emissive_sample(&table.emissive, 0, from, 0.5f, 0.5f, &s));
    assert_false(pbnds_emissive_sample(&table.emissive, 1, from, 0.5f, 0.5f, &s));
    assert_true(pbnds_emissive_sample(&table.emissive, 2, from, 0.5f, 0.5f, &s));
    pbnds_light_table_free(&table);
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_list_holds_what_emits),
        cmocka_unit_test(choices_follow_power),
        cmocka_unit_test(a_spot_counts_by_what_it_sends),
        cmocka_unit_test(one_light_needs_no_choice),
        cmocka_unit_test(a_hundred_thousand_triangles),
        cmocka_unit_test(points_fill_the_triangle),
        cmocka_unit_test(a_transparent_emitter_sends_less),
        cmocka_unit_test(degenerate_triangles_are_left_out),
    };
    return cmocka_run_group_tests_name("engine/shade/light_table", tests, NULL, NULL);
}
