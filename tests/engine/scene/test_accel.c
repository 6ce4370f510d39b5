#include "tests/test.h"

#include "engine/scene/accel.h"
#include "engine/scene/packet.h"
#include "tests/engine/scene/fixture.h"

static struct pbnds_accel *build(const struct fixture *f)
{
    struct pbnds_accel *accel = NULL;
    struct pbnds_error error;
    if (pbnds_accel_create(&f->scene, &accel, &error) != PBNDS_OK) {
        fail_msg("%s", error.message);
    }
    return accel;
}

/* The naive twin: Moeller and Trumbore 1997, every triangle, in double. */
struct naive_hit {
    double t;
    double next;   /* t of the second closest, to know ties               */
    double margin; /* least distance of any candidate to a triangle's edge */
    uint32_t mesh, triangle;
    double u, v;
};

struct dvec {
    double x, y, z;
};
static struct dvec to_d(struct pbnds_vec3 a)
{
    return (struct dvec){(double)a.x, (double)a.y, (double)a.z};
}
static struct dvec sub_d(struct dvec a, struct dvec b)
{
    return (struct dvec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static double dot_d(struct dvec a, struct dvec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static struct dvec cross_d(struct dvec a, struct dvec b)
{
    return (struct dvec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z,
                         a.x * b.y - a.y * b.x};
}

static struct naive_hit naive(const struct pbnds_scene *scene,
                              const struct pbnds_ray *ray)
{
    struct naive_hit best = {1e300, 1e300, 1e300, UINT32_MAX, 0, 0, 0};
    const struct dvec o = to_d(ray->origin), d = to_d(ray->direction);
    for (int m = 0; m < scene->mesh_count; ++m) {
        const struct pbnds_mesh *mesh = &scene->meshes[m];
        for (size_t k = 0; k < mesh->triangle_count; ++k) {
            const uint32_t *i = mesh->index + 3 * k;
            const struct dvec p = to_d(mesh->position[i[0]]);
            const struct dvec e1 = sub_d(to_d(mesh->position[i[1]]), p);
            const struct dvec e2 = sub_d(to_d(mesh->position[i[2]]), p);
            const struct dvec h = cross_d(d, e2);
            const double det = dot_d(e1, h);
            if (fabs(det) < 1e-14) continue;
            const struct dvec s = sub_d(o, p);
            const double u = dot_d(s, h) / det;
            const struct dvec q = cross_d(s, e1);
            const double v = dot_d(d, q) / det;
            const double t = dot_d(e2, q) / det;
            if (t <= 0) continue;
            const double inside = fmin(fmin(u, v), 1 - u - v);
            best.margin = fmin(best.margin, fabs(inside));
            if (inside < 0) continue;
            if (t < best.t) {
                best = (struct naive_hit){
                    t, best.t, best.margin, (uint32_t)m, (uint32_t)k, u, v};
            } else if (t < best.next) {
                best.next = t;
            }
        }
    }
    return best;
}

enum { SOUP = 200 };
struct soup {
    struct fixture f;
    struct pbnds_vec3 p[3][3 * SOUP];
    uint32_t index[3][3 * SOUP];
};

static void make_soup(struct soup *s, uint64_t seed)
{
    struct pbnds_rng rng = pbnds_rng_make(seed, 0, 0);
    fixture_init(&s->f);
    for (int m = 0; m < 3; ++m) {
        for (uint32_t i = 0; i < 3 * SOUP; ++i) {
            const struct pbnds_vec3 center =
                i % 3
                    ? s->p[m][i - i % 3]
                    : pbnds_scale(fixture_direction(&rng), fixture_uniform(&rng, 0, 3));
            s->p[m][i] = pbnds_mad(center, fixture_direction(&rng), 0.5f);
            s->index[m][i] = i;
        }
        fixture_mesh(&s->f, s->p[m], 3 * SOUP, s->index[m], SOUP);
    }
}

/* From a sphere around the soup to a point within it. */
static struct pbnds_ray random_ray(struct pbnds_rng *rng)
{
    const struct pbnds_vec3 from = pbnds_scale(fixture_direction(rng), 4.0f);
    const struct pbnds_vec3 to = pbnds_scale(fixture_direction(rng), 2.0f);
    return (struct pbnds_ray){from, pbnds_normalize(pbnds_sub(to, from))};
}

static void closest_hit_agrees_with_brute_force(void **state)
{
    (void)state;
    struct soup *s = malloc(sizeof *s);
    make_soup(s, 7);
    struct pbnds_accel *accel = build(&s->f);
    struct pbnds_rng rng = pbnds_rng_make(8, 0, 0);
    int hits = 0, skipped = 0;
    for (int k = 0; k < 3000; ++k) {
        const struct pbnds_ray ray = random_ray(&rng);
        const struct naive_hit want = naive(&s->f.scene, &ray);
        if (want.margin < 1e-5) {
            ++skipped; /* an edge: either answer is right */
            continue;
        }
        struct pbnds_hit hit;
        pbnds_accel_intersect(accel, &ray, &hit);
        assert_int_equal(hit.mesh, want.mesh);
        if (want.mesh == UINT32_MAX) continue;
        ++hits;
        assert_near(hit.t, want.t, 1e-4 * want.t + 1e-5);
        if (want.next - want.t < 1e-4) continue;
        assert_int_equal(hit.triangle, want.triangle);
        assert_near(hit.u, want.u, 1e-3);
        assert_near(hit.v, want.v, 1e-3);
    }
    assert_true(hits > 1500);
    assert_true(skipped < 100);
    pbnds_accel_free(accel);
    free(s);
}

static void packets_agree_with_single_rays(void **state)
{
    (void)state;
    struct soup *s = malloc(sizeof *s);
    make_soup(s, 9);
    struct pbnds_accel *accel = build(&s->f);
    struct pbnds_rng rng = pbnds_rng_make(10, 0, 0);
    for (int k = 0; k < 400; ++k) {
        const int count = 1 + k % PBNDS_PACKET;
        /* No more than `count`, so that a sanitizer sees who reads past them. */
        struct pbnds_ray *rays = malloc((size_t)count * sizeof *rays);
        const struct pbnds_ray first = random_ray(&rng);
        for (int i = 0; i < count; ++i) {
            rays[i].origin = first.origin;
            rays[i].direction = pbnds_normalize(pbnds_mad(
                first.direction, fixture_direction(&rng), k % 2 ? 0.05f : 2.0f));
        }
        struct pbnds_hit hits[PBNDS_PACKET];
        bool dark[PBNDS_PACKET];
        const float max_t = k % 3 ? fixture_uniform(&rng, 0.5f, 6.0f) : INFINITY;
        pbnds_accel_intersect_packet(accel, rays, count, hits);
        pbnds_accel_occluded_packet(accel, rays, count, max_t, dark);
        for (int i = 0; i < count; ++i) {
            struct pbnds_hit one;
            pbnds_accel_intersect(accel, &rays[i], &one);
            assert_int_equal(hits[i].mesh, one.mesh);
            assert_int_equal(hits[i].triangle, one.triangle);
            assert_int_equal(dark[i], pbnds_accel_occluded(accel, &rays[i], max_t));
            if (one.mesh == UINT32_MAX) {
                assert_true(isinf(hits[i].t) && isinf(one.t));
                assert_false(dark[i]);
                continue;
            }
            assert_near(hits[i].t, one.t, 1e-5 * (double)one.t);
            assert_near(hits[i].u, one.u, 1e-4);
            assert_near(hits[i].v, one.v, 1e-4);
            if (fabsf(one.t - max_t) > 1e-4f) assert_int_equal(dark[i], one.t < max_t);
        }
        free(rays);
    }
    pbnds_accel_free(accel);
    free(s);
}

static void broken_rays_miss_and_spare_their_neighbours(void **state)
{
    (void)state;
    struct pbnds_vec3 p[3] = {{-1, -1, -2}, {1, -1, -2}, {0, 1, -2}};
    uint32_t index[3] = {0, 1, 2};
    struct fixture f;
    fixture_init(&f);
    fixture_mesh(&f, p, 3, index, 1);
    struct pbnds_accel *accel = build(&f);
    const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f, -3.4e38f, 1.9e18f};
    for (int b = 0; b < 6; ++b) {
        for (int where = 0; where < 6; ++where) {
            struct pbnds_ray rays[PBNDS_PACKET];
            for (int i = 0; i < PBNDS_PACKET; ++i) {
                rays[i] = (struct pbnds_ray){{0, 0, 0}, {0, 0, -1}};
            }
            float *const member[6] = {&rays[5].origin.x,    &rays[5].origin.y,
                                      &rays[5].origin.z,    &rays[5].direction.x,
                                      &rays[5].direction.y, &rays[5].direction.z};
            *member[where] = bad[b];
            struct pbnds_hit hits[PBNDS_PACKET], one;
            bool dark[PBNDS_PACKET];
            pbnds_accel_intersect_packet(accel, rays, PBNDS_PACKET, hits);
            pbnds_accel_occluded_packet(accel, rays, PBNDS_PACKET, INFINITY, dark);
            for (int i = 0; i < PBNDS_PACKET; ++i) {
                assert_int_equal(hits[i].mesh, i == 5 ? UINT32_MAX : 0);
                assert_int_equal(dark[i], i != 5);
            }
            pbnds_accel_intersect(accel, &rays[5], &one);
            assert_int_equal(one.mesh, UINT32_MAX);
            assert_false(pbnds_accel_occluded(accel, &rays[5], INFINITY));
        }
    }
    const struct pbnds_ray good = {{0, 0, 0}, {0, 0, -1}},
                           still = {{0, 0, 0}, {0, 0, 0}};
    assert_false(pbnds_accel_occluded(accel, &good, NAN));
    assert_false(pbnds_accel_occluded(accel, &good, 0.0f));
    assert_false(pbnds_accel_occluded(accel, &good, -1.0f));
    assert_false(pbnds_accel_occluded(accel, &good, 1.999f));
    assert_true(pbnds_accel_occluded(accel, &good, 2.001f));
    struct pbnds_hit hit;
    pbnds_accel_intersect(accel, &still, &hit); /* no direction: any answer, no abort */
    pbnds_accel_intersect_packet(accel, &still, 1, &hit);
    pbnds_accel_intersect_packet(accel, &still, 0, &hit);
    pbnds_accel_free(accel);
}

static void no_ray_leaves_a_closed_mesh(void **state)
{
    (void)state;
    struct fixture f;
    fixture_init(&f);
    const struct pbnds_mesh *mesh =
        fixture_sphere(&f, pbnds_vec3_make(0.3f, -0.2f, 0.1f), 1.7f, 24);
    struct pbnds_accel *accel = build(&f);
    struct pbnds_rng rng = pbnds_rng_make(11, 0, 0);
    const struct pbnds_vec3 inside = {0.31f, -0.17f, 0.05f};
    struct pbnds_ray rays[PBNDS_PACKET];
    struct pbnds_hit hits[PBNDS_PACKET], hit;
    int filled = 0;
    for (size_t k = 0; k < 9 * mesh->triangle_count; ++k) {
        /* Straight at corners, at edges and at faces, in turn. */
        const uint32_t *i = mesh->index + 3 * (k / 9);
        const struct pbnds_vec3 a = mesh->position[i[k % 3]],
                                b = mesh->position[i[(k + 1) % 3]];
        const float along = k % 9 < 3 ? 0.0f : fixture_uniform(&rng, 0.0f, 1.0f);
        const struct pbnds_ray ray = {
            inside, pbnds_normalize(pbnds_sub(pbnds_lerp(a, b, along), inside))};
        pbnds_accel_intersect(accel, &ray, &hit);
        assert_int_equal(hit.mesh, 0);
        assert_true(pbnds_accel_occluded(accel, &ray, INFINITY));
        rays[filled++] = ray;
        if (filled < PBNDS_PACKET) continue;
        filled = 0;
        pbnds_accel_intersect_packet(accel, rays, PBNDS_PACKET, hits);
        for (int j = 0; j < PBNDS_PACKET; ++j)
            assert_int_equal(hits[j].mesh, 0);
    }
    for (int k = 0; k < 100000; ++k) {
        const struct pbnds_ray ray = {inside, fixture_direction(&rng)};
        pbnds_accel_intersect(accel, &ray, &hit);
        assert_int_equal(hit.mesh, 0);
    }
    pbnds_accel_free(accel);
    free(mesh->position);
    free(mesh->normal);
    free(mesh->index);
}

/* A square of checkered alpha (2 x 2 texels) before an opaque one. */
struct cutout_scene {
    struct fixture f;
    struct pbnds_vec3 front[4], back[4];
    struct pbnds_vec2 uv[4];
    uint32_t index[6];
    float texels[16];
};

static void make_cutout(struct cutout_scene *s, enum pbnds_alpha_mode mode,
                        float cutoff)
{
    static const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    memcpy(s->index, index, sizeof index);
    for (int i = 0; i < 4; ++i) {
        const float x = i == 1 || i == 2 ? 1.0f : 0.0f, y = i >= 2 ? 1.0f : 0.0f;
        s->front[i] = pbnds_vec3_make(x, y, -1.0f);
        s->back[i] = pbnds_vec3_make(x, y, -2.0f);
        s->uv[i] = (struct pbnds_vec2){x, 1.0f - y};
    }
    /* Alpha 0.6 on the diagonal from the upper left, else 0.2. */
    for (int i = 0; i < 16; ++i)
        s->texels[i] = 1.0f;
    s->texels[3] = s->texels[15] = 0.6f;
    s->texels[7] = s->texels[11] = 0.2f;
    fixture_init(&s->f);
    fixture_mesh(&s->f, s->front, 4, s->index, 2)->uv[0] = s->uv;
    fixture_mesh(&s->f, s->back, 4, s->index, 2)->material = 1;
    struct pbnds_material *m = &s->f.materials[0];
    m->alpha_mode = mode;
    m->alpha_cutoff = cutoff;
    m->base_color_texture.texture = fixture_texture(&s->f, s->texels, 2, 2);
}

/* Which mesh is seen at (x, y) of the square, asked in every way there is. */
static uint32_t seen(const struct pbnds_accel *accel, float x, float y)
{
    const struct pbnds_ray ray = {{x, y, 0.0f}, {0.0f, 0.0f, -1.0f}};
    struct pbnds_ray rays[PBNDS_PACKET];
    struct pbnds_hit hit, hits[PBNDS_PACKET];
    bool dark[PBNDS_PACKET];
    pbnds_accel_intersect(accel, &ray, &hit);
    for (int i = 0; i < PBNDS_PACKET; ++i)
        rays[i] = ray;
    pbnds_accel_intersect_packet(accel, rays, PBNDS_PACKET, hits);
    pbnds_accel_occluded_packet(accel, rays, PBNDS_PACKET, 1.5f, dark);
    assert_int_equal(pbnds_accel_occluded(accel, &ray, 1.5f), hit.mesh == 0);
    for (int i = 0; i < PBNDS_PACKET; ++i) {
        assert_int_equal(hits[i].mesh, hit.mesh);
        assert_int_equal(dark[i], hit.mesh == 0);
    }
    assert_near(hit.t, hit.mesh == 0 ? 1.0 : 2.0, 1e-5);
    return hit.mesh;
}

static void masks_are_cut_out(void **state)
{
    (void)state;
    static const struct {
        enum pbnds_alpha_mode mode;
        float cutoff;
        uint32_t solid, faint; /* mesh seen through texels of alpha 0.6 and 0.2 */
    } cases[] = {
        {PBNDS_ALPHA_OPAQUE, 0.5f, 0, 0}, {PBNDS_ALPHA_MASK, 0.5f, 0, 1},
        {PBNDS_ALPHA_MASK, 0.1f, 0, 0},   {PBNDS_ALPHA_MASK, 0.7f, 1, 1},
        {PBNDS_ALPHA_MASK, 0.6f, 0, 1},   {PBNDS_ALPHA_BLEND, 0.9f, 0, 1},
    };
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; ++c) {
        struct cutout_scene s;
        make_cutout(&s, cases[c].mode, cases[c].cutoff);
        struct pbnds_accel *accel = build(&s.f);
        assert_int_equal(seen(accel, 0.2f, 0.7f), cases[c].solid);
        assert_int_equal(seen(accel, 0.7f, 0.2f), cases[c].solid);
        assert_int_equal(seen(accel, 0.2f, 0.3f), cases[c].faint);
        assert_int_equal(seen(accel, 0.7f, 0.8f), cases[c].faint);
        pbnds_accel_free(accel);
    }
    /* No texture: the factor alone decides. */
    struct cutout_scene s;
    make_cutout(&s, PBNDS_ALPHA_MASK, 0.5f);
    s.f.materials[0].base_color_texture.texture = -1;
    s.f.materials[0].base_color.w = 0.4f;
    struct pbnds_accel *accel = build(&s.f);
    assert_int_equal(seen(accel, 0.2f, 0.7f), 1);
    pbnds_accel_free(accel);
}

static void an_empty_scene_is_all_misses(void **state)
{
    (void)state;
    struct fixture f;
    fixture_init(&f);
    for (int with_mesh = 0; with_mesh < 2; ++with_mesh) {
        if (with_mesh) fixture_mesh(&f, NULL, 0, NULL, 0);
        struct pbnds_accel *accel = build(&f);
        const struct pbnds_ray ray = {{0, 0, 0}, {0, 0, -1}};
        struct pbnds_hit hit, packet[1];
        bool dark;
        pbnds_accel_intersect(accel, &ray, &hit);
        pbnds_accel_intersect_packet(accel, &ray, 1, packet);
        pbnds_accel_occluded_packet(accel, &ray, 1, INFINITY, &dark);
        assert_int_equal(hit.mesh, UINT32_MAX);
        assert_int_equal(packet[0].mesh, UINT32_MAX);
        assert_false(dark);
        assert_false(pbnds_accel_occluded(accel, &ray, INFINITY));
        pbnds_accel_free(accel);
    }
    pbnds_accel_free(NULL);
}

static void a_bad_index_is_refused(void **state)
{
    (void)state;
    struct pbnds_vec3 p[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    uint32_t index[6] = {0, 1, 2, 0, 3, 1};
    struct fixture f;
    fixture_init(&f);
    struct pbnds_mesh *mesh = fixture_mesh(&f, p, 3, index, 2);
    memcpy(mesh->name, "ear", 4);
    struct pbnds_accel *accel;
    struct pbnds_error error;
    assert_int_equal(pbnds_accel_create(&f.scene, &accel, &error),
                     PBNDS_ERROR_ARGUMENT);
    assert_null(accel);
    assert_non_null(strstr(error.message, "\"ear\""));
}

static void an_offset_origin_never_meets_its_own_triangle(void **state)
{
    (void)state;
    struct pbnds_rng rng = pbnds_rng_make(12, 0, 0);
    for (int scale = -3; scale <= 3; ++scale) {
        const float size = powf(10.0f, (float)scale);
        struct pbnds_vec3 p[3];
        uint32_t index[3] = {0, 1, 2};
        const struct pbnds_vec3 center =
            pbnds_scale(fixture_direction(&rng), 3.0f * size);
        for (int i = 0; i < 3; ++i)
            p[i] = pbnds_mad(center, fixture_direction(&rng), size);
        struct fixture f;
        fixture_init(&f);
        fixture_mesh(&f, p, 3, index, 1);
        struct pbnds_accel *accel = build(&f);
        struct pbnds_vec3 ng =
            pbnds_normalize(pbnds_cross(pbnds_sub(p[1], p[0]), pbnds_sub(p[2], p[0])));
        int tested = 0;
        for (int k = 0; k < 3000; ++k) {
            const float a = pbnds_rng_float(&rng),
                        b = pbnds_rng_float(&rng) * (1.0f - a);
            const struct pbnds_vec3 q =
                pbnds_add(pbnds_scale(p[0], 1.0f - a - b),
                          pbnds_add(pbnds_scale(p[1], a), pbnds_scale(p[2], b)));
            const struct pbnds_vec3 side = pbnds_scale(ng, k % 2 ? 1.0f : -1.0f);
            struct pbnds_ray ray = {pbnds_offset_origin(q, side),
                                    fixture_direction(&rng)};
            if (pbnds_dot(ray.direction, side) < 0.0f) {
                ray.direction = pbnds_scale(ray.direction, -1.0f);
            }
            assert_false(pbnds_accel_occluded(accel, &ray, INFINITY));
            const struct pbnds_vec3 moved = pbnds_sub(ray.origin, q);
            /* 256 steps of the float below 4 size, or the fixed distance near zero. */
            assert_true(pbnds_length(moved) < fmaxf(4e-4f * size, 6e-5f));
            ++tested;
        }
        assert_int_equal(tested, 3000);
        pbnds_accel_free(accel);
    }
    /* Known: far from zero 256 representable steps, near zero n / 65536. */
    const struct pbnds_vec3 q =
        pbnds_offset_origin(pbnds_vec3_make(1, -1, 0), pbnds_vec3_make(1, 1, -1));
    assert_near(q.x, 1.0 + 256 * 0x1p-23, 0.0);
    assert_near(q.y, -1.0 + 256 * 0x1p-24, 0.0);
    assert_near(q.z, -1.0 / 65536, 0.0);
}

/* A ray down -z meets, in this order: the back of a one-sided square at z = 3, the back of
 * a one-sided one at z = 2 that lies on the front of another, and the front at z = 1. What
 * stands at `want` is seen by every kind of camera ray. */
static void camera_sees(const struct pbnds_accel *accel, uint32_t want, float t)
{
    struct pbnds_ray ray = {{0.25f, 0.5f, 10.0f}, {0.0f, 0.0f, -1.0f}};
    struct pbnds_ray rays[PBNDS_PACKET];
    struct pbnds_ray_packet lanes;
    struct pbnds_hit hits[PBNDS_PACKET], hit;
    struct pbnds_hit_packet got;
    for (int i = 0; i < PBNDS_PACKET; ++i) {
        rays[i] = ray;
        const float o[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
        for (int c = 0; c < 3; ++c) {
            lanes.origin[c][i] = o[c];
            lanes.direction[c][i] = c == 2 ? -1.0f : 0.0f;
        }
    }
    const struct pbnds_query query = {.max_t = INFINITY, .cull = true};
    pbnds_accel_intersect_query(accel, &ray, &query, &hit);
    pbnds_accel_intersect_packet(accel, rays, PBNDS_PACKET, hits);
    pbnds_accel_intersect_lanes(accel, &lanes, &got);
    assert_int_equal(hit.mesh, want);
    for (int i = 0; i < PBNDS_PACKET; ++i) {
        assert_int_equal(hits[i].mesh, want);
        assert_int_equal(got.mesh[i], want);
        if (want == UINT32_MAX) continue;
        assert_near(hits[i].t, t, 1e-5);
        assert_near(got.t[i], t, 1e-5);
    }
}

static void cameras_do_not_see_one_sided_surfaces_from_behind(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_vec3 p[4][3];
    uint32_t front[3] = {0, 1, 2}, back[3] = {0, 2, 1};
    static const float z[4] = {3.0f, 2.0f, 2.0f, 1.0f};
    for (int facing = 0; facing < 2; ++facing) {
        fixture_init(&f);
        for (int m = 0; m < 4; ++m) {
            p[m][0] = pbnds_vec3_make(-4.0f, -4.0f, z[m]);
            p[m][1] = pbnds_vec3_make(4.0f, -4.0f, z[m]);
            p[m][2] = pbnds_vec3_make(0.0f, 8.0f, z[m]);
            /* 0 and 1 show their backs; 2, on 1, its front where `facing` */
            const bool shows = m == 3 || (m == 2 && facing);
            fixture_mesh(&f, p[m], 3, shows ? front : back, 1)->material = m;
            f.materials[m].double_sided = false;
        }
        struct pbnds_accel *accel = build(&f);
        camera_sees(accel, facing ? 2 : 3, facing ? 8.0f : 9.0f);
        /* Light is stopped by what the camera looks through. */
        const struct pbnds_ray ray = {{0.25f, 0.5f, 10.0f}, {0.0f, 0.0f, -1.0f}};
        struct pbnds_hit hit;
        pbnds_accel_intersect(accel, &ray, &hit);
        assert_int_equal(hit.mesh, 0);
        assert_true(pbnds_accel_occluded(accel, &ray, 7.5f));
        pbnds_accel_free(accel);
        f.materials[1].double_sided = true;
        f.materials[2].double_sided = false;
        accel = build(&f);
        if (!facing) camera_sees(accel, 1, 8.0f);
        pbnds_accel_free(accel);
    }
    fixture_init(&f);
    fixture_mesh(&f, p[0], 3, back, 1);
    f.materials[0].double_sided = false;
    struct pbnds_accel *accel = build(&f);
    camera_sees(accel, UINT32_MAX, 0.0f);
    pbnds_accel_free(accel);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closest_hit_agrees_with_brute_force),
        cmocka_unit_test(packets_agree_with_single_rays),
        cmocka_unit_test(broken_rays_miss_and_spare_their_neighbours),
        cmocka_unit_test(no_ray_leaves_a_closed_mesh),
        cmocka_unit_test(masks_are_cut_out),
        cmocka_unit_test(an_empty_scene_is_all_misses),
        cmocka_unit_test(a_bad_index_is_refused),
        cmocka_unit_test(cameras_do_not_see_one_sided_surfaces_from_behind),
        cmocka_unit_test(an_offset_origin_never_meets_its_own_triangle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
