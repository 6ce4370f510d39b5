#include "tests/test.h"

#include "tests/engine/scene/fixture.h"

#define assert_vec(v, vx, vy, vz, tol)                                                 \
    do {                                                                               \
        const struct pbnds_vec3 v_ = (v);                                              \
        assert_near(v_.x, vx, tol);                                                    \
        assert_near(v_.y, vy, tol);                                                    \
        assert_near(v_.z, vz, tol);                                                    \
    } while (0)

static const struct pbnds_vec3 up_z = {0.0f, 0.0f, 1.0f};

/* The unit square in the plane z = 0, seen from +z; u to the right, v down. */
struct square {
    struct fixture f;
    struct pbnds_vec3 p[4], n[4];
    struct pbnds_vec4 tangent[4], color[4];
    struct pbnds_vec2 uv[4];
    uint32_t index[6];
    float texels[4][16];
    struct pbnds_mesh *mesh;
    struct pbnds_material *material;
};

static void make_square(struct square *s)
{
    static const uint32_t index[6] = {0, 1, 2, 0, 2, 3};
    memset(s, 0, sizeof *s);
    memcpy(s->index, index, sizeof index);
    for (int i = 0; i < 4; ++i) {
        const float x = i == 1 || i == 2 ? 1.0f : 0.0f, y = i >= 2 ? 1.0f : 0.0f;
        s->p[i] = pbnds_vec3_make(x, y, 0.0f);
        s->n[i] = up_z;
        s->uv[i] = (struct pbnds_vec2){x, 1.0f - y};
        s->tangent[i] = (struct pbnds_vec4){1.0f, 0.0f, 0.0f, 1.0f};
    }
    fixture_init(&s->f);
    s->mesh = fixture_mesh(&s->f, s->p, 4, s->index, 2);
    s->mesh->normal = s->n;
    s->mesh->uv[0] = s->uv;
    s->material = &s->f.materials[0];
}

/* A texture of one texel. */
static int plain_texture(struct square *s, float r, float g, float b, float a)
{
    float *t = s->texels[s->f.scene.texture_count];
    t[0] = r;
    t[1] = g;
    t[2] = b;
    t[3] = a;
    return fixture_texture(&s->f, t, 1, 1);
}

static struct pbnds_surface look(const struct square *s, uint32_t triangle, float u,
                                 float v, struct pbnds_vec3 wo)
{
    const struct pbnds_hit hit = {1.0f, u, v, 0, triangle};
    struct pbnds_surface surface;
    memset(&surface, 0xff, sizeof surface);
    pbnds_scene_surface(&s->f.scene, &hit, wo, 0.0f, &surface);
    return surface;
}

static void attributes_are_interpolated(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.mesh->color = s.color;
    for (int i = 0; i < 4; ++i) {
        s.color[i] = (struct pbnds_vec4){(float)(i + 1) * 0.25f, 1.0f, 0.5f, 1.0f};
    }
    s.material->base_color = (struct pbnds_vec4){0.8f, 0.5f, 1.0f, 1.0f};
    s.n[2] = pbnds_normalize(pbnds_vec3_make(1, 0, 1));
    const struct pbnds_surface q = look(&s, 0, 0.25f, 0.5f, up_z);
    /* Weights 0.25, 0.25, 0.5 of vertices 0, 1, 2. */
    assert_vec(q.position, 0.75, 0.5, 0.0, 1e-6);
    assert_near(q.uv.x, 0.75, 1e-6);
    assert_near(q.uv.y, 0.5, 1e-6);
    const double nx = 0.5 * sqrt(0.5), nz = 0.5 + nx, length = sqrt(nx * nx + nz * nz);
    assert_vec(q.n, nx / length, 0.0, nz / length, 1e-6);
    assert_vec(q.ng, 0.0, 0.0, 1.0, 1e-6);
    const double red = 0.25 * 0.25 + 0.25 * 0.5 + 0.5 * 0.75;
    assert_vec(q.base_color, 0.8 * red, 0.5, 0.5, 1e-6);
    assert_int_equal(q.object_id, 10);
    assert_near(q.alpha, 1.0, 0.0);
    assert_near(q.f0.x, 0.04, 1e-7);
    /* The second triangle has other corners. */
    assert_vec(look(&s, 1, 0.0f, 1.0f, up_z).position, 0.0, 1.0, 0.0, 1e-6);
}

static void textures_go_where_gltf_says(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.material->base_color = (struct pbnds_vec4){1.0f, 1.0f, 0.5f, 0.5f};
    s.material->roughness = 0.8f;
    s.material->metallic = 0.5f;
    s.material->emissive = pbnds_vec3_make(2.0f, 4.0f, 0.0f);
    s.material->alpha_mode = PBNDS_ALPHA_MASK;
    s.material->base_color_texture.texture = plain_texture(&s, 0.5f, 1.0f, 0.5f, 0.5f);
    s.material->metallic_roughness_texture.texture =
        plain_texture(&s, 0.11f, 0.5f, 0.25f, 1.0f);
    s.material->emissive_texture.texture = plain_texture(&s, 0.5f, 0.25f, 1.0f, 1.0f);
    const struct pbnds_surface q = look(&s, 0, 0.3f, 0.3f, up_z);
    const double half = pow((0.5 + 0.055) / 1.055, 2.4); /* sRGB 0.5, linear */
    const double quarter = pow((0.25 + 0.055) / 1.055, 2.4);
    assert_vec(q.base_color, half, 1.0, 0.5 * half, 1e-5);
    assert_near(q.alpha, 0.25, 1e-6);
    assert_near(q.roughness, 0.4, 1e-6);  /* G */
    assert_near(q.metallic, 0.125, 1e-6); /* B */
    assert_vec(q.emission, 2.0 * half, 4.0 * quarter, 0.0, 1e-5);
    const struct pbnds_hit hit = {1.0f, 0.3f, 0.3f, 0, 0};
    assert_near(pbnds_scene_alpha(&s.f.scene, &hit), 0.25, 1e-6);
    s.material->alpha_mode = PBNDS_ALPHA_OPAQUE;
    assert_near(pbnds_scene_alpha(&s.f.scene, &hit), 1.0, 0.0);
}

static void the_second_uv_set_is_used(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    static struct pbnds_vec2 other[4] = {
        {0.75f, 0}, {0.75f, 0}, {0.75f, 0}, {0.75f, 0}};
    s.mesh->uv[1] = other;
    float *t = s.texels[0];
    for (int i = 0; i < 8; ++i)
        t[i] = i < 4 ? 0.0f : 1.0f;
    s.material->base_color = (struct pbnds_vec4){1, 1, 1, 1};
    s.material->base_color_texture.texture = fixture_texture(&s.f, t, 2, 1);
    assert_near(look(&s, 0, 0.1f, 0.1f, up_z).base_color.x, 0.0, 1e-6);
    s.material->base_color_texture.texcoord = 1;
    assert_near(look(&s, 0, 0.1f, 0.1f, up_z).base_color.x, 1.0, 1e-6);
    /* Without UVs the factor stands alone. */
    s.mesh->uv[1] = NULL;
    s.material->base_color.x = 0.3f;
    assert_near(look(&s, 0, 0.1f, 0.1f, up_z).base_color.x, 0.3, 1e-6);
}

static void normal_map_known_answers(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.mesh->tangent = s.tangent;
    s.material->normal_texture.texture = plain_texture(&s, 0.8f, 0.5f, 0.9f, 1.0f);
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, 0.6, 0.0, 0.8, 1e-6);
    /* Green is up: the bitangent is cross(n, t) w. */
    s.texels[0][0] = 0.5f;
    s.texels[0][1] = 0.8f;
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, 0.0, 0.6, 0.8, 1e-6);
    for (int i = 0; i < 4; ++i)
        s.tangent[i].w = -1.0f;
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, 0.0, -0.6, 0.8, 1e-6);
    /* The scale acts on x and y only. */
    s.material->normal_scale = 0.5f;
    const double length = sqrt(0.09 + 0.64);
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, 0.0, -0.3 / length, 0.8 / length, 1e-6);
    /* Seen from behind, the whole normal is turned. */
    s.material->normal_scale = 1.0f;
    const struct pbnds_surface back =
        look(&s, 0, 0.3f, 0.3f, pbnds_vec3_make(0, 0, -1));
    assert_vec(back.n, 0.0, 0.6, -0.8, 1e-6);
    assert_vec(back.ng, 0.0, 0.0, -1.0, 1e-6);
}

static void tangents_follow_from_uvs(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.material->normal_texture.texture = plain_texture(&s, 0.8f, 0.5f, 0.9f, 1.0f);
    for (uint32_t t = 0; t < 2; ++t) {
        s.texels[0][0] = 0.8f;
        s.texels[0][1] = 0.5f;
        assert_vec(look(&s, t, 0.3f, 0.3f, up_z).n, 0.6, 0.0, 0.8, 1e-6);
        s.texels[0][0] = 0.5f;
        s.texels[0][1] = 0.8f;
        assert_vec(look(&s, t, 0.3f, 0.3f, up_z).n, 0.0, 0.6, 0.8, 1e-6);
    }
    /* Mirrored u: tangents turn, the green axis does not. */
    for (int i = 0; i < 4; ++i)
        s.uv[i].x = -s.uv[i].x;
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, 0.0, 0.6, 0.8, 1e-6);
    s.texels[0][0] = 0.8f;
    s.texels[0][1] = 0.5f;
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, -0.6, 0.0, 0.8, 1e-6);
    /* UVs without area: the map is left out. */
    for (int i = 0; i < 4; ++i)
        s.uv[i] = (struct pbnds_vec2){0.5f, 0.5f};
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, 0.0, 0.0, 1.0, 1e-6);
}

static void a_vertex_normal_against_the_winding_is_turned(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    for (int i = 0; i < 4; ++i)
        s.n[i] = pbnds_vec3_make(0.0f, 0.6f, -0.8f);
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, 0.0, -0.6, 0.8, 1e-6);
}

static void face_eye_is_the_smallest_turn(void **state)
{
    (void)state;
    struct pbnds_rng rng = pbnds_rng_make(3, 0, 0);
    for (int k = 0; k < 20000; ++k) {
        const struct pbnds_vec3 n = fixture_direction(&rng),
                                wo = fixture_direction(&rng);
        const struct pbnds_vec3 m = pbnds_face_eye(n, wo);
        assert_near(pbnds_length(m), 1.0, 1e-6);
        assert_true(pbnds_dot(m, wo) > 4e-4f);
        if (pbnds_dot(n, wo) > 1e-3f) {
            assert_memory_equal(&m, &n, sizeof n);
            continue;
        }
        assert_near(pbnds_dot(m, wo), 1e-3, 6e-4);
        /* In the plane of n and wo, on n's side: no shorter way exists. */
        const struct pbnds_vec3 across = pbnds_cross(n, wo);
        if (pbnds_length(across) < 0.01f) continue;
        assert_near(pbnds_dot(pbnds_normalize(across), m), 0.0, 1e-5);
        assert_true(pbnds_dot(m, pbnds_mad(n, wo, -pbnds_dot(n, wo))) > 0.0f);
        const struct pbnds_vec3 again = pbnds_face_eye(m, wo);
        assert_memory_equal(&again, &m, sizeof m);
    }
    const struct pbnds_vec3 wo = {0, 1, 0}, away = {0, -1, 0};
    assert_near(pbnds_dot(pbnds_face_eye(away, wo), wo), 1.0, 1e-6);
}

/* What a surface mirrors must not lie below its face. */
static void a_normal_is_bent_until_its_mirror_leaves_the_face(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.mesh->tangent = s.tangent;
    s.material->normal_texture.texture = plain_texture(&s, 0.8f, 0.5f, 0.9f, 1.0f);
    /* Mirrored at (0.6, 0, 0.8), this eye sees (0.936, 0, -0.352). The half vector by hand
     * of it and of a mirror direction 0.01 above the face: */
    const struct pbnds_vec3 low = {-0.6f, 0.0f, 0.8f};
    const double x = sqrt(1.0 - 1e-4) - 0.6, z = 0.01 + 0.8;
    const double length = sqrt(x * x + z * z);
    assert_vec(look(&s, 0, 0.3f, 0.3f, low).n, x / length, 0.0, z / length, 1e-6);
    /* From above it is (0.96, 0, 0.28), and there is nothing to bend. */
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, 0.6, 0.0, 0.8, 1e-6);
    /* Out of the plane of n and the face: toward the face, and no further than needed. */
    const struct pbnds_vec3 wo = pbnds_normalize(pbnds_vec3_make(-0.6f, 0.5f, 0.6f));
    const struct pbnds_vec3 m = look(&s, 0, 0.3f, 0.3f, wo).n;
    assert_near(m.y, 0.0, 1e-7);
    assert_true(m.x > 0.0f && m.x < 0.6f);
    assert_near(2.0f * pbnds_dot(m, wo) * m.z - wo.z, 0.01, 1e-6);
    /* A normal that looks away from the eye: seen, and not just so. */
    const struct pbnds_vec3 lower = pbnds_normalize(pbnds_vec3_make(-0.9f, 0.0f, 0.3f));
    const struct pbnds_vec3 away = look(&s, 0, 0.3f, 0.3f, lower).n;
    assert_near(2.0f * pbnds_dot(away, lower) * away.z - lower.z, 0.01, 1e-6);
    assert_true(pbnds_dot(away, lower) > 0.5f * lower.z);
    /* A face without a map keeps its normal at the most grazing view. */
    s.material->normal_texture.texture = -1;
    for (float height = 1e-1f; height > 1e-6f; height *= 0.1f) {
        const struct pbnds_vec3 grazing =
            pbnds_normalize(pbnds_vec3_make(1.0f, 0.0f, height));
        const struct pbnds_vec3 flat = look(&s, 0, 0.3f, 0.3f, grazing).n;
        if (height > 2e-3f) assert_vec(flat, 0.0, 0.0, 1.0, 0.0);
        assert_vec(flat, 0.0, 0.0, 1.0, 2e-3);
    }
}

static void assert_sound(const struct pbnds_surface *q, struct pbnds_vec3 wo)
{
    assert_near(pbnds_length(q->n), 1.0, 2e-6);
    assert_near(pbnds_length(q->ng), 1.0, 2e-6);
    assert_true(pbnds_dot(q->ng, wo) >= 0.0f);
    assert_true(pbnds_dot(q->n, wo) > 4e-4f);
    assert_true(pbnds_dot(q->n, q->ng) >= -1e-5f);
    const float eye = pbnds_dot(wo, q->ng);
    const float mirror = 2.0f * pbnds_dot(q->n, wo) * pbnds_dot(q->n, q->ng) - eye;
    assert_true(mirror >= fminf(0.01f, 0.5f * eye) - 1e-4f);
    assert_true(isfinite(q->position.x + q->position.y + q->position.z));
    assert_true(isfinite(pbnds_max3(q->base_color) + pbnds_max3(q->emission)));
}

static void normals_are_sound_whatever_the_mesh(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.mesh->tangent = s.tangent;
    s.material->normal_texture.texture = plain_texture(&s, 0.5f, 0.5f, 1.0f, 1.0f);
    struct pbnds_rng rng = pbnds_rng_make(4, 0, 0);
    for (int k = 0; k < 50000; ++k) {
        const float size = powf(10.0f, fixture_uniform(&rng, -18.0f, 12.0f));
        for (int i = 0; i < 4; ++i) {
            const struct pbnds_vec3 t = fixture_direction(&rng);
            s.p[i] = pbnds_scale(fixture_direction(&rng), size);
            s.n[i] = fixture_direction(&rng);
            s.tangent[i] = (struct pbnds_vec4){t.x, t.y, t.z, k & 1 ? 1.0f : -1.0f};
            s.uv[i] = (struct pbnds_vec2){pbnds_rng_float(&rng), pbnds_rng_float(&rng)};
        }
        if (k % 3 == 0) s.p[2] = s.p[1];                     /* no area       */
        if (k % 6 == 0) s.p[1] = s.p[2] = s.p[0];            /* a point       */
        if (k % 5 == 0) s.n[1] = pbnds_scale(s.n[0], -1.0f); /* cancel halfway */
        if (k % 7 == 0) s.n[0] = s.n[1] = s.n[2] = pbnds_splat(0.0f);
        if (k % 11 == 0) s.tangent[0].x = s.tangent[0].y = s.tangent[0].z = 0.0f;
        s.mesh->tangent = k % 2 ? s.tangent : NULL;
        s.mesh->normal = k % 13 ? s.n : NULL;
        for (int c = 0; c < 3; ++c)
            s.texels[0][c] = pbnds_rng_float(&rng);
        if (k % 17 == 0) s.texels[0][0] = s.texels[0][1] = s.texels[0][2] = 0.5f;
        const float u = k % 5 ? pbnds_rng_float(&rng) : 0.5f;
        const float v = k % 5 ? pbnds_rng_float(&rng) * (1.0f - u) : 0.0f;
        const struct pbnds_vec3 wo = fixture_direction(&rng);
        const struct pbnds_surface q = look(&s, 0, u, v, wo);
        assert_sound(&q, wo);
    }
}

static void tiny_triangles_keep_their_normal(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.mesh->normal = NULL;
    for (int e = -15; e <= 15; e += 3) {
        const float size = powf(10.0f, (float)e);
        for (int i = 0; i < 4; ++i) {
            s.p[i] = pbnds_scale(pbnds_vec3_make(i == 1 || i == 2 ? 1.0f : 0.0f,
                                                 i >= 2 ? 1.0f : 0.0f, 0.0f),
                                 size);
        }
        const struct pbnds_vec3 wo = pbnds_normalize(pbnds_vec3_make(1, 2, 0.5f));
        assert_vec(look(&s, 0, 0.2f, 0.2f, wo).n, 0.0, 0.0, 1.0, 1e-6);
    }
}

static void values_stay_in_range(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.mesh->color = s.color;
    for (int i = 0; i < 4; ++i)
        s.color[i] = (struct pbnds_vec4){9, -1, 1, 1};
    s.material->roughness = 3.0f;
    s.material->metallic = -1.0f;
    const struct pbnds_surface q = look(&s, 0, 0.2f, 0.2f, up_z);
    assert_vec(q.base_color, 1.0, 0.0, 0.5, 1e-6);
    assert_near(q.roughness, 1.0, 0.0);
    assert_near(q.metallic, 0.0, 0.0);
}

static void texture_transforms_move_the_lookup(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    for (int i = 0; i < 16; ++i) /* four texels in a row, red = index / 4 */
        s.texels[0][i] = 0.25f * (float)(i / 4);
    struct pbnds_texture_ref *ref = &s.material->occlusion_texture;
    ref->texture = fixture_texture(&s.f, s.texels[0], 4, 1);
    assert_near(look(&s, 0, 0.1f, 0.0f, up_z).occlusion, 0.0, 1e-6); /* u = 0.1 */
    const float moved[6] = {1.0f, 0.0f, 0.5f, 0.0f, 1.0f, 0.0f};
    memcpy(ref->transform, moved, sizeof moved);
    assert_near(look(&s, 0, 0.1f, 0.0f, up_z).occlusion, 0.0, 1e-6); /* not in use */
    ref->transformed = true;
    assert_near(look(&s, 0, 0.1f, 0.0f, up_z).occlusion, 0.5, 1e-6); /* u = 0.6 */
    /* Rows act on (u, v, 1): u' = v, with v = 1 - y. */
    const float turned[6] = {0.0f, 1.0f, 0.0f, -1.0f, 0.0f, 0.0f};
    memcpy(ref->transform, turned, sizeof turned);
    assert_near(look(&s, 0, 0.1f, 0.65f, up_z).occlusion, 0.25, 1e-6); /* v = 0.35 */
    /* surface.uv is TEXCOORD_0 itself. */
    assert_near(look(&s, 0, 0.1f, 0.0f, up_z).uv.x, 0.1, 1e-6);
}

static void turned_maps_turn_the_derived_tangent(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.material->normal_texture.texture = plain_texture(&s, 0.8f, 0.5f, 0.9f, 1.0f);
    /* u' = v = 1 - y: the map's red axis points down the square. */
    const float turned[6] = {0.0f, 1.0f, 0.0f, -1.0f, 0.0f, 0.0f};
    memcpy(s.material->normal_texture.transform, turned, sizeof turned);
    s.material->normal_texture.transformed = true;
    assert_vec(look(&s, 0, 0.3f, 0.3f, up_z).n, 0.0, -0.6, 0.8, 1e-6);
}

static void occlusion_has_a_strength(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    assert_near(look(&s, 0, 0.3f, 0.3f, up_z).occlusion, 1.0, 0.0);
    s.material->occlusion_texture.texture = plain_texture(&s, 0.2f, 0.9f, 0.9f, 0.9f);
    assert_near(look(&s, 0, 0.3f, 0.3f, up_z).occlusion, 0.2, 1e-6);
    s.material->occlusion_strength = 0.5f;
    assert_near(look(&s, 0, 0.3f, 0.3f, up_z).occlusion, 0.6, 1e-6);
}

/* KHR_materials_specular: f0 = specular min(ior_f0 color, 1), f90 = specular. */
static void specular_known_answers(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.material->ior_f0 = 0.2f;
    s.material->specular = 0.5f;
    s.material->specular_color = pbnds_vec3_make(1.0f, 0.5f, 10.0f);
    struct pbnds_surface q = look(&s, 0, 0.3f, 0.3f, up_z);
    assert_vec(q.f0, 0.1, 0.05, 0.5, 1e-6); /* blue: min(2, 1) before the factor */
    assert_near(q.f90, 0.5, 1e-6);
    s.material->specular_texture.texture = plain_texture(&s, 0.9f, 0.9f, 0.9f, 0.4f);
    s.material->specular_color_texture.texture =
        plain_texture(&s, 1.0f, 0.5f, 0.0f, 0.1f);
    q = look(&s, 0, 0.3f, 0.3f, up_z);
    const double half = pow((0.5 + 0.055) / 1.055, 2.4);
    assert_vec(q.f0, 0.2 * 0.2, 0.2 * 0.2 * 0.5 * half, 0.0, 1e-6);
    assert_near(q.f90, 0.2, 1e-6);
    /* Metal and roughness are not touched by any of it. */
    assert_near(q.roughness, 1.0, 0.0);
    assert_near(q.metallic, 0.0, 0.0);
}

static void specular_glossiness_known_answers(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.material->specular_glossiness = true;
    s.material->base_color = (struct pbnds_vec4){0.8f, 0.4f, 0.2f, 1.0f};
    s.material->specular_color = pbnds_vec3_make(0.5f, 0.25f, 0.1f);
    s.material->roughness = 0.25f; /* glossiness 0.75 */
    s.material->metallic = 1.0f;
    s.material->specular = 0.3f; /* of the other extension: not looked at */
    struct pbnds_surface q = look(&s, 0, 0.3f, 0.3f, up_z);
    assert_vec(q.f0, 0.5, 0.25, 0.1, 1e-6);
    assert_near(q.f90, 1.0, 0.0);
    assert_vec(q.base_color, 0.4, 0.2, 0.1, 1e-6);
    assert_near(q.roughness, 0.25, 1e-6);
    assert_near(q.metallic, 0.0, 0.0);
    s.material->specular_color_texture.texture =
        plain_texture(&s, 0.5f, 1.0f, 1.0f, 0.4f);
    q = look(&s, 0, 0.3f, 0.3f, up_z);
    const double half = pow((0.5 + 0.055) / 1.055, 2.4);
    assert_vec(q.f0, 0.5 * half, 0.25, 0.1, 1e-6);
    assert_vec(q.base_color, 0.6, 0.3, 0.15, 1e-6); /* 1 - max(f0) = 0.75 */
    assert_near(q.roughness, 1.0 - 0.75 * 0.4, 1e-6);
}

static void unlit_emits_its_color_and_reflects_nothing(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    s.material->unlit = true;
    s.material->base_color = (struct pbnds_vec4){0.8f, 0.4f, 0.2f, 0.5f};
    s.material->alpha_mode = PBNDS_ALPHA_BLEND;
    s.material->metallic = 1.0f;
    s.material->emissive = pbnds_splat(3.0f); /* of a lit material: not looked at */
    s.material->base_color_texture.texture = plain_texture(&s, 1.0f, 1.0f, 0.0f, 0.5f);
    const struct pbnds_surface q = look(&s, 0, 0.3f, 0.3f, up_z);
    assert_vec(q.emission, 0.8, 0.4, 0.0, 1e-6);
    assert_vec(q.base_color, 0.0, 0.0, 0.0, 0.0);
    assert_vec(q.f0, 0.0, 0.0, 0.0, 0.0);
    assert_near(q.f90, 0.0, 0.0);
    assert_near(q.metallic, 0.0, 0.0);
    assert_near(q.roughness, 1.0, 0.0);
    assert_near(q.alpha, 0.25, 1e-6);
}

static void earlier_positions_are_interpolated(void **state)
{
    (void)state;
    struct square s;
    make_square(&s);
    const struct pbnds_hit hit = {1.0f, 0.25f, 0.5f, 0, 0};
    const struct pbnds_vec3 now = look(&s, 0, 0.25f, 0.5f, up_z).position;
    const struct pbnds_vec3 rest = pbnds_scene_previous(&s.f.scene, &hit);
    assert_memory_equal(&now, &rest, sizeof now);
    struct pbnds_vec3 before[4];
    for (int i = 0; i < 4; ++i)
        before[i] = pbnds_vec3_make((float)i, 2.0f, s.p[i].y);
    s.mesh->previous = before;
    assert_vec(pbnds_scene_previous(&s.f.scene, &hit), 1.25, 2.0, 0.5, 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attributes_are_interpolated),
        cmocka_unit_test(textures_go_where_gltf_says),
        cmocka_unit_test(the_second_uv_set_is_used),
        cmocka_unit_test(texture_transforms_move_the_lookup),
        cmocka_unit_test(turned_maps_turn_the_derived_tangent),
        cmocka_unit_test(occlusion_has_a_strength),
        cmocka_unit_test(specular_known_answers),
        cmocka_unit_test(specular_glossiness_known_answers),
        cmocka_unit_test(unlit_emits_its_color_and_reflects_nothing),
        cmocka_unit_test(earlier_positions_are_interpolated),
        cmocka_unit_test(normal_map_known_answers),
        cmocka_unit_test(tangents_follow_from_uvs),
        cmocka_unit_test(a_vertex_normal_against_the_winding_is_turned),
        cmocka_unit_test(face_eye_is_the_smallest_turn),
        cmocka_unit_test(a_normal_is_bent_until_its_mirror_leaves_the_face),
        cmocka_unit_test(normals_are_sound_whatever_the_mesh),
        cmocka_unit_test(tiny_triangles_keep_their_normal),
        cmocka_unit_test(values_stay_in_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
