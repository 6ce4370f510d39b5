/* Packets of surfaces against surfaces one by one: the same bits. */
#include "tests/test.h"

#include "engine/scene/maps.h"
#include "engine/scene/packet.h"
#include "tests/engine/scene/fixture.h"

enum { VERTICES = 60, TRIANGLES = 40, MESHES = 3, TEXELS = 8 };

struct heap {
    struct fixture f;
    struct pbnds_vec3 p[MESHES][VERTICES], n[MESHES][VERTICES];
    struct pbnds_vec4 t[MESHES][VERTICES];
    struct pbnds_vec2 uv[MESHES][VERTICES];
    uint32_t index[MESHES][3 * TRIANGLES];
    float texels[FIXTURE_MAX][TEXELS * TEXELS * 4];
};

/* Triangles of any shape; normals and tangents about the right way, some of them not. */
static void make_heap(struct heap *h, struct pbnds_rng *rng)
{
    memset(h, 0, sizeof *h);
    fixture_init(&h->f);
    for (int m = 0; m < MESHES; ++m) {
        for (int i = 0; i < VERTICES; ++i) {
            const struct pbnds_vec3 t = fixture_direction(rng);
            h->p[m][i] = pbnds_scale(fixture_direction(rng), 1.0f + (float)m);
            h->n[m][i] = fixture_direction(rng);
            h->t[m][i] = (struct pbnds_vec4){t.x, t.y, t.z, i & 1 ? 1.0f : -1.0f};
            h->uv[m][i] = (struct pbnds_vec2){4.0f * pbnds_rng_float(rng) - 2.0f,
                                              4.0f * pbnds_rng_float(rng) - 2.0f};
        }
        for (int i = 0; i < 3 * TRIANGLES; ++i)
            h->index[m][i] = (uint32_t)(pbnds_rng_u64(rng) % VERTICES);
        struct pbnds_mesh *mesh =
            fixture_mesh(&h->f, h->p[m], VERTICES, h->index[m], TRIANGLES);
        mesh->normal = h->n[m];
        mesh->tangent = h->t[m];
        mesh->uv[0] = h->uv[m];
        mesh->material = m;
    }
    for (int i = 0; i < FIXTURE_MAX; ++i) {
        for (int k = 0; k < TEXELS * TEXELS * 4; ++k)
            h->texels[i][k] = pbnds_rng_float(rng);
        fixture_texture(&h->f, h->texels[i], TEXELS, TEXELS);
        h->f.textures[i].nearest = false;
    }
}

/* Materials that packets know and some that they hand on. */
static void dress(struct heap *h, int kind)
{
    for (int m = 0; m < MESHES; ++m) {
        struct pbnds_material *x = &h->f.materials[m];
        const int k = (kind + m) % 9;
        x->metallic = 0.7f;
        x->roughness = 0.8f;
        x->emissive = pbnds_vec3_make(1.0f, 2.0f, 3.0f);
        if (k >= 1) x->base_color_texture.texture = 0;
        if (k >= 2) x->metallic_roughness_texture.texture = 1;
        if (k >= 2) x->normal_texture.texture = 2;
        if (k >= 3) x->occlusion_texture.texture = 1;
        if (k >= 3) x->emissive_texture.texture = 3;
        if (k == 4) x->alpha_mode = PBNDS_ALPHA_BLEND;
        if (k == 5) x->unlit = true;
        if (k == 6) x->specular_glossiness = true;
        if (k == 7) x->specular_color_texture.texture = 3;
        if (k == 8) h->f.textures[1].wrap_u = PBNDS_WRAP_MIRROR;
    }
}

static void assert_same3(const float lanes[3][PBNDS_PACKET], int k, struct pbnds_vec3 v)
{
    const float got[3] = {lanes[0][k], lanes[1][k], lanes[2][k]};
    const float want[3] = {v.x, v.y, v.z};
    assert_memory_equal(got, want, sizeof got);
}

static void assert_same(const struct pbnds_surface_packet *s, int k,
                        const struct pbnds_surface *q)
{
    assert_same3(s->position, k, q->position);
    assert_same3(s->ng, k, q->ng);
    assert_same3(s->n, k, q->n);
    assert_same3(s->base_color, k, q->base_color);
    assert_same3(s->emission, k, q->emission);
    assert_same3(s->f0, k, q->f0);
    assert_true(s->f90[k] == q->f90 && s->metallic[k] == q->metallic);
    assert_true(s->roughness[k] == q->roughness && s->alpha[k] == q->alpha);
    assert_true(s->occlusion[k] == q->occlusion);
    assert_true(s->uv[0][k] == q->uv.x && s->uv[1][k] == q->uv.y);
    assert_int_equal(s->object_id[k], q->object_id);
    assert_int_equal(s->material[k], q->material);
}

static void compare(const struct heap *h, struct pbnds_rng *rng, int spread)
{
    struct pbnds_ray_packet rays;
    struct pbnds_hit_packet hits;
    struct pbnds_surface_packet s;
    float footprint[PBNDS_PACKET];
    memset(&s, 0xff, sizeof s);
    for (int k = 0; k < PBNDS_PACKET; ++k) {
        const struct pbnds_vec3 d = fixture_direction(rng);
        rays.direction[0][k] = d.x;
        rays.direction[1][k] = d.y;
        rays.direction[2][k] = d.z;
        for (int c = 0; c < 3; ++c)
            rays.origin[c][k] = 0.0f;
        hits.t[k] = 1.0f;
        hits.u[k] = pbnds_rng_float(rng);
        hits.v[k] = (1.0f - hits.u[k]) * pbnds_rng_float(rng);
        hits.triangle[k] = (uint32_t)(pbnds_rng_u64(rng) % TRIANGLES);
        hits.mesh[k] = (uint32_t)(pbnds_rng_u64(rng) % MESHES);
        if (spread == 0) hits.mesh[k] = hits.mesh[0];
        if (spread == 2 && pbnds_rng_u64(rng) % 3 == 0) hits.mesh[k] = UINT32_MAX;
        footprint[k] = ldexpf(1.0f, (int)(pbnds_rng_u64(rng) % 12) - 8);
    }
    pbnds_scene_surface_packet(&h->f.scene, &rays, &hits, footprint, &s);
    for (int k = 0; k < PBNDS_PACKET; ++k) {
        struct pbnds_surface q;
        memset(&q, 0, sizeof q);
        if (hits.mesh[k] != UINT32_MAX) {
            const struct pbnds_hit hit = {hits.t[k], hits.u[k], hits.v[k], hits.mesh[k],
                                          hits.triangle[k]};
            const struct pbnds_vec3 wo = {-rays.direction[0][k], -rays.direction[1][k],
                                          -rays.direction[2][k]};
            pbnds_scene_surface(&h->f.scene, &hit, wo, footprint[k], &q);
        }
        assert_same(&s, k, &q);
    }
}

static void packets_are_surfaces_side_by_side(void **state)
{
    (void)state;
    struct pbnds_rng rng = pbnds_rng_make(11, 0, 0);
    static struct heap h;
    for (int kind = 0; kind < 9; ++kind) {
        struct pbnds_error error;
        make_heap(&h, &rng);
        dress(&h, kind);
        if (pbnds_scene_pack(&h.f.scene, &error) != PBNDS_OK ||
            pbnds_scene_prefilter(&h.f.scene, 0, &error) != PBNDS_OK)
            fail_msg("%s", error.message);
        for (int i = 0; i < 600; ++i)
            compare(&h, &rng, i % 3);
        for (int m = 0; m < MESHES; ++m)
            free(h.f.meshes[m].packed);
        pbnds_maps_free(h.f.scene.maps);
    }
}

static void a_scene_that_was_not_packed_looks_the_same(void **state)
{
    (void)state;
    struct pbnds_rng rng = pbnds_rng_make(12, 0, 0);
    static struct heap h;
    make_heap(&h, &rng);
    dress(&h, 3);
    for (int i = 0; i < 100; ++i)
        compare(&h, &rng, i % 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packets_are_surfaces_side_by_side),
        cmocka_unit_test(a_scene_that_was_not_packed_looks_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
