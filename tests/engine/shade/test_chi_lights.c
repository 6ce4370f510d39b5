/* Directions toward the lights of a scene against their density: one emitting triangle,
 * and the choice between the light map and all triangles; and which light is chosen, of all
 * kinds, against its probability.
 *
 * Points, spots and directional lights have no density to test over directions. From a
 * point of a surface each is seen in one direction, a spot too: its cone says who is lit,
 * not from where. Nothing is drawn there, nor is light ever followed from its source, so
 * what a spot draws by is the choice alone, in proportion to its power (the power itself:
 * test_light_table.c).
 *
 * The other samplers: the map in tests/engine/scene/test_chi_envmap.c, lobes in
 * test_chi_bsdf.c, test_chi_ggx.c and test_chi_blinn_phong.c; the numbers that all of them
 * use in test_sampler.c. */
#include "engine/shade/light_table.h"
#include "tests/engine/shade/chi_squared.h"
#include "tests/engine/shade/fixture.h"

struct view {
    const struct fixture *fixture;
    const struct pbnds_light_table *table;
    struct pbnds_vec3 from;
    size_t triangle; /* of the list; SIZE_MAX: the table chooses */
};

/* No two emitters are behind each other, so the ray meets what a sample can stand for. */
static double pdf(const void *self, struct pbnds_vec3 w)
{
    const struct view *v = self;
    const struct pbnds_emissive *e = &v->table->emissive;
    const struct pbnds_ray ray = {v->from, w};
    struct pbnds_hit hit;
    struct pbnds_surface surface;
    const bool all = v->triangle == SIZE_MAX;
    double density = 0.0;
    if (all && v->fixture->envmap)
        density = (double)(v->table->map_probability *
                           pbnds_envmap_pdf(v->fixture->envmap, w));
    pbnds_accel_intersect(v->fixture->accel, &ray, &hit);
    if (hit.mesh == UINT32_MAX) return density;
    const size_t index = pbnds_emissive_find(e, hit.mesh, hit.triangle);
    const struct pbnds_vec3 wo = pbnds_scale(w, -1.0f);
    pbnds_scene_surface(&v->fixture->scene, &hit, wo, 0.0f, &surface);
    const float cos_l = pbnds_dot(surface.ng, wo);
    if (all)
        return density + (double)pbnds_light_table_emissive_pdf(v->table, &hit, cos_l);
    return index == v->triangle ? (double)pbnds_emissive_pdf(e, index, hit.t, cos_l)
                                : 0.0;
}

static bool sample(const void *self, struct pbnds_rng *rng, struct pbnds_vec3 *w)
{
    const struct view *v = self;
    const uint32_t bits = (uint32_t)(pbnds_rng_u64(rng) >> 32);
    const float u1 = pbnds_rng_float(rng), u2 = pbnds_rng_float(rng);
    size_t index = v->triangle;
    if (index == SIZE_MAX) {
        const struct pbnds_light_choice c = pbnds_light_table_choose(v->table, bits);
        if (c.kind == PBNDS_LIGHT_CLASS_MAP) {
            *w = pbnds_envmap_sample(v->fixture->envmap, u1, u2).wi;
            return true;
        }
        index = c.index;
    }
    struct pbnds_emissive_sample s;
    if (!pbnds_emissive_sample(&v->table->emissive, index, v->from, u1, u2, &s))
        return false;
    *w = s.wi;
    return true;
}

/* Three parallelograms about the origin: near, far and bright, and seen at a low angle. */
static void lamps(struct fixture *f)
{
    struct pbnds_material m[2] = {matte(0.5f), matte(0.5f)};
    m[0].emissive = pbnds_splat(1.0f);
    m[1].emissive = pbnds_vec3_make(9.0f, 3.0f, 1.0f);
    const struct pbnds_mesh meshes[3] = {
        quad(pbnds_vec3_make(-0.4f, 0.5f, -0.7f), pbnds_vec3_make(1.0f, 0.1f, 0.0f),
             pbnds_vec3_make(0.2f, 0.0f, 1.1f), 0),
        quad(pbnds_vec3_make(3.0f, -1.0f, -1.0f), pbnds_vec3_make(0.5f, 2.0f, 0.0f),
             pbnds_vec3_make(0.0f, 0.3f, 2.0f), 1),
        quad(pbnds_vec3_make(-0.5f, -0.6f, 0.0f), pbnds_vec3_make(-2.0f, 0.1f, 0.0f),
             pbnds_vec3_make(0.0f, 0.1f, 1.0f), 0)};
    fixture_scene(f, meshes, 3, m, 2);
}

enum { RUNS = 6 };

static void run(const struct fixture *f, size_t triangle, uint64_t seed,
                const char *what)
{
    struct pbnds_error error;
    struct pbnds_light_table table;
    must(pbnds_light_table_create(&f->scene, f->envmap, &table, &error), &error);
    const struct view view = {f, &table, {0.0f, 0.0f, 0.1f}, triangle};
    const struct chi_sampler sampler = {.self = &view,
                                        .pdf = pdf,
                                        .sample = sample,
                                        .pole = {0.0f, 1.0f, 0.0f},
                                        .edges = true};
    assert_chi_squared(&sampler, seed, RUNS, what);
    pbnds_light_table_free(&table);
}

static void points_on_a_triangle_follow_their_density(void **state)
{
    (void)state;
    const char *names[] = {"near", "far", "at a low angle"};
    struct fixture f;
    lamps(&f);
    for (size_t i = 0; i < 3; ++i)
        run(&f, 2 * i, 20 + i, names[i]);
    fixture_free(&f);
}

static void the_choice_of_lights_does_too(void **state)
{
    (void)state;
    struct fixture f;
    lamps(&f);
    run(&f, SIZE_MAX, 30, "all triangles");
    fixture_light(&f, 20, light_sunny);
    run(&f, SIZE_MAX, 31, "triangles and the map");
    fixture_free(&f);
}

/* Cells are the lights instead of bins of directions. */
static void each_light_is_chosen_as_often_as_it_says(void **state)
{
    (void)state;
    static const struct pbnds_light lights[5] = {
        {.kind = PBNDS_LIGHT_SPOT, .cos_inner = 0.99f, .cos_outer = 0.97f},
        {.kind = PBNDS_LIGHT_SPOT, .cos_inner = 0.8f, .cos_outer = -0.2f},
        {.kind = PBNDS_LIGHT_POINT},
        {.kind = PBNDS_LIGHT_DIRECTIONAL},
        {.kind = PBNDS_LIGHT_SPOT, .cos_inner = 1.0f, .cos_outer = 0.999999f}};
    enum { LIGHTS = 5, TRIANGLES = 6, CELLS = 1 + LIGHTS + TRIANGLES };
    struct chi_cell cells[CELLS] = {{0.0, 0.0}};
    struct fixture f;
    struct pbnds_error error;
    struct pbnds_light_table table;
    lamps(&f);
    fixture_light(&f, 20, light_sunny);
    f.scene.lights = must_alloc(LIGHTS, sizeof *lights);
    memcpy(f.scene.lights, lights, sizeof lights);
    f.scene.light_count = LIGHTS;
    for (int i = 0; i < LIGHTS; ++i) {
        f.scene.lights[i].intensity = pbnds_splat(1.0f + (float)i);
        f.scene.lights[i].direction = pbnds_vec3_make(0.0f, -1.0f, 0.0f);
        f.scene.lights[i].range = INFINITY;
    }
    must(pbnds_light_table_create(&f.scene, f.envmap, &table, &error), &error);
    assert_int_equal(table.count, CELLS);
    for (uint64_t i = 0; i < CHI_SAMPLES; ++i) {
        struct pbnds_rng rng = pbnds_rng_make(40, 0, i);
        const uint32_t bits = (uint32_t)(pbnds_rng_u64(&rng) >> 32);
        const struct pbnds_light_choice c = pbnds_light_table_choose(&table, bits);
        const size_t entry = c.kind == PBNDS_LIGHT_CLASS_MAP        ? 0
                             : c.kind == PBNDS_LIGHT_CLASS_PUNCTUAL ? 1 + c.index
                                                                    : 6 + c.index;
        cells[entry].observed += 1.0;
        cells[entry].expected = (double)c.probability * CHI_SAMPLES;
    }
    double total = 0.0;
    for (int i = 0; i < CELLS; ++i)
        total += cells[i].expected;
    assert_near(total, CHI_SAMPLES, 1.0);
    const double p = chi_statistic(cells, CELLS);
    if (!(p >= chi_threshold(RUNS))) fail_msg("p = %g", p);
    pbnds_light_table_free(&table);
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_on_a_triangle_follow_their_density),
        cmocka_unit_test(the_choice_of_lights_does_too),
        cmocka_unit_test(each_light_is_chosen_as_often_as_it_says),
    };
    return cmocka_run_group_tests_name("engine/shade/chi_lights", tests, NULL, NULL);
}
