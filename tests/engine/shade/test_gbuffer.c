#include "tests/test.h"

#include "engine/core/parallel.h"
#include "engine/scene/maps.h"
#include "engine/scene/packet.h"
#include "engine/shade/gbuffer.h"
#include "engine/shade/tiles.h"
#include "tests/engine/scene/fixture.h"

static struct pbnds_camera camera_at(struct pbnds_vec3 eye, struct pbnds_vec3 target,
                                     float yfov_deg)
{
    struct pbnds_camera c;
    memset(&c, 0, sizeof c);
    c.world_from_camera = pbnds_mat4_look_at(eye, target, pbnds_vec3_make(0, 1, 0));
    c.yfov = yfov_deg * PBNDS_PI / 180.0f;
    return c;
}

static struct pbnds_gbuffer cast_with(const struct fixture *f,
                                      const struct pbnds_camera *camera, int width,
                                      int height,
                                      const struct pbnds_raycast_options *options)
{
    struct pbnds_accel *accel = NULL;
    struct pbnds_error error;
    struct pbnds_gbuffer g = {0};
    if (pbnds_accel_create(&f->scene, &accel, &error) != PBNDS_OK ||
        pbnds_gbuffer_raycast(&f->scene, accel, camera, width, height, options, &g,
                              &error) != PBNDS_OK) {
        fail_msg("%s", error.message);
    }
    pbnds_accel_free(accel);
    return g;
}

static struct pbnds_gbuffer
cast(const struct fixture *f, const struct pbnds_camera *camera, int width, int height)
{
    return cast_with(f, camera, width, height, NULL);
}

static void free_mesh(const struct pbnds_mesh *mesh)
{
    free(mesh->position);
    free(mesh->normal);
    free(mesh->index);
}

/* A rectangle [-a, a] x [-b, b] at z = -depth. */
static struct pbnds_vec3 square[4];
static uint32_t square_index[6] = {0, 1, 2, 0, 2, 3};

static void make_square(struct fixture *f, float a, float b, float depth)
{
    fixture_init(f);
    square[0] = pbnds_vec3_make(-a, -b, -depth);
    square[1] = pbnds_vec3_make(a, -b, -depth);
    square[2] = pbnds_vec3_make(a, b, -depth);
    square[3] = pbnds_vec3_make(-a, b, -depth);
    fixture_mesh(f, square, 4, square_index, 2);
}

static void assert_nothing(const struct pbnds_gbuffer *g, size_t i)
{
    assert_true(isinf(g->depth[i]) && g->depth[i] > 0.0f);
    assert_int_equal(g->object_id[i], UINT32_MAX);
    assert_near(g->coverage[i], 0.0, 0.0);
    assert_near(g->specular[i], 0.0, 0.0);
    assert_near(g->roughness[i], 0.0, 0.0);
    assert_near(g->metallic[i], 0.0, 0.0);
    for (int c = 0; c < 3; ++c) {
        assert_near(g->albedo[c][i], 0.0, 0.0);
        assert_near(g->normal[c][i], 0.0, 0.0);
        assert_near(g->position[c][i], 0.0, 0.0);
        assert_near(g->emission[c][i], 0.0, 0.0);
        assert_near(g->geometric_normal[c][i], 0.0, 0.0);
    }
}

/* Seen straight on at 90 degrees, a pixel of 50 rows spans 2 d / 50 at depth d. */
static void check_square(const struct pbnds_gbuffer *g, float a, float b, float depth,
                         float pixel)
{
    for (int y = 0; y < g->height; ++y) {
        for (int x = 0; x < g->width; ++x) {
            const size_t i = (size_t)y * (size_t)g->width + (size_t)x;
            const float px = ((float)x + 0.5f - 0.5f * (float)g->width) * pixel;
            const float py = (0.5f * (float)g->height - (float)y - 0.5f) * pixel;
            if (fabsf(px) > a || fabsf(py) > b) {
                assert_nothing(g, i);
                continue;
            }
            assert_near(g->depth[i], depth, 1e-5);
            assert_near(g->position[0][i], px, 1e-4);
            assert_near(g->position[1][i], py, 1e-4);
            assert_near(g->position[2][i], -depth, 1e-5);
            assert_near(g->normal[2][i], 1.0, 1e-6);
            assert_near(g->geometric_normal[2][i], 1.0, 1e-6);
            assert_near(g->coverage[i], 1.0, 0.0);
            assert_int_equal(g->object_id[i], 10);
        }
    }
}

static void a_square_in_perspective(void **state)
{
    (void)state;
    struct fixture f;
    make_square(&f, 1.51f, 1.01f, 2.0f);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 0, -1), 90.0f);
    struct pbnds_gbuffer g = cast(&f, &c, 70, 50);
    check_square(&g, 1.51f, 1.01f, 2.0f, 4.0f / 50.0f);
    pbnds_gbuffer_free(&g);
    assert_null(g.storage);
}

static void a_square_in_parallel_projection(void **state)
{
    (void)state;
    struct fixture f;
    make_square(&f, 1.51f, 1.01f, 7.0f);
    struct pbnds_camera c =
        camera_at(pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 0, -1), 0.0f);
    c.orthographic = true;
    c.ymag = 2.0f;
    struct pbnds_gbuffer g = cast(&f, &c, 33, 50);
    check_square(&g, 1.51f, 1.01f, 7.0f, 4.0f / 50.0f);
    const struct pbnds_vec3 wo = pbnds_gbuffer_wo(&g, 3, 9);
    assert_near(wo.z, 1.0, 0.0);
    pbnds_gbuffer_free(&g);
}

static void material_planes(void **state)
{
    (void)state;
    struct fixture f;
    make_square(&f, 5.0f, 5.0f, 1.0f);
    struct pbnds_material *m = &f.materials[0];
    m->base_color = (struct pbnds_vec4){0.9f, 0.6f, 0.3f, 1.0f};
    m->metallic = 0.25f;
    m->roughness = 0.7f;
    m->ior_f0 = 0.08f;
    m->emissive = pbnds_vec3_make(1.0f, 200.0f, 3.0f);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 0, -1), 60.0f);
    struct pbnds_gbuffer g = cast(&f, &c, 8, 8);
    const double luminance = 0.2126 * (0.75 * 0.08 + 0.25 * 0.9) +
                             0.7152 * (0.75 * 0.08 + 0.25 * 0.6) +
                             0.0722 * (0.75 * 0.08 + 0.25 * 0.3);
    for (size_t i = 0; i < 64; ++i) {
        assert_near(g.albedo[0][i], 0.9, 1e-6);
        assert_near(g.albedo[1][i], 0.6, 1e-6);
        assert_near(g.albedo[2][i], 0.3, 1e-6);
        assert_near(g.specular[i], luminance, 1e-6);
        assert_near(g.roughness[i], 0.7, 1e-6);
        assert_near(g.metallic[i], 0.25, 1e-6);
        assert_near(g.emission[1][i], 200.0, 1e-4);
    }
    pbnds_gbuffer_free(&g);
}

static void a_sphere_against_its_equation(void **state)
{
    (void)state;
    struct fixture f;
    fixture_init(&f);
    const struct pbnds_vec3 center = {0.2f, -0.1f, 0.3f};
    const float radius = 0.8f;
    const struct pbnds_mesh *mesh = fixture_sphere(&f, center, radius, 128);
    const struct pbnds_vec3 eye = {2.0f, 1.5f, 2.5f};
    const struct pbnds_camera c = camera_at(eye, center, 35.0f);
    enum { W = 117, H = 91 };
    struct pbnds_gbuffer g = cast(&f, &c, W, H);
    int covered = 0;
    for (int y = 0; y < H; ++y) {
        for (int x = 0; x < W; ++x) {
            const size_t i = (size_t)y * W + (size_t)x;
            const struct pbnds_vec3 wo = pbnds_gbuffer_wo(&g, x, y);
            const struct pbnds_ray ray =
                pbnds_camera_ray(&c, W, H, (float)x + 0.5f, (float)y + 0.5f);
            assert_near(pbnds_dot(wo, ray.direction), -1.0, 1e-6);
            const struct pbnds_vec3 oc = pbnds_sub(ray.origin, center);
            const float b = pbnds_dot(oc, ray.direction);
            const float disc = b * b - pbnds_dot(oc, oc) + radius * radius;
            if (disc < 0.0f) {
                assert_nothing(&g, i); /* the mesh lies inside the sphere */
                continue;
            }
            if (disc < 0.05f) continue; /* near the outline facets show */
            ++covered;
            const struct pbnds_vec3 p =
                pbnds_mad(ray.origin, ray.direction, -b - sqrtf(disc));
            const struct pbnds_vec3 n =
                pbnds_scale(pbnds_sub(p, center), 1.0f / radius);
            assert_near(g.depth[i], pbnds_camera_depth(&c, p), 2e-3);
            const float *const got[3] = {g.normal[0] + i, g.normal[1] + i,
                                         g.normal[2] + i};
            assert_near(*got[0], n.x, 4e-3);
            assert_near(*got[1], n.y, 4e-3);
            assert_near(*got[2], n.z, 4e-3);
            assert_near(g.position[0][i], p.x, 3e-3);
            assert_near(g.geometric_normal[0][i], n.x, 0.03);
            /* depth and position are the same point. */
            const struct pbnds_vec3 q = {g.position[0][i], g.position[1][i],
                                         g.position[2][i]};
            assert_near(g.depth[i], pbnds_camera_depth(&c, q), 1e-6);
        }
    }
    assert_true(covered > 1500);
    pbnds_gbuffer_free(&g);
    free_mesh(mesh);
}

static void every_normal_faces_the_eye(void **state)
{
    (void)state;
    struct fixture f;
    fixture_init(&f);
    /* Few rings: smooth normals look away from the eye along the outline. */
    const struct pbnds_mesh *mesh =
        fixture_sphere(&f, pbnds_vec3_make(0, 0, 0), 1.0f, 6);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(0, 0.4f, 3), pbnds_vec3_make(0, 0, 0), 45.0f);
    struct pbnds_gbuffer g = cast(&f, &c, 160, 160);
    for (int y = 0; y < 160; ++y) {
        for (int x = 0; x < 160; ++x) {
            const size_t i = (size_t)y * 160 + (size_t)x;
            if (g.coverage[i] == 0.0f) continue;
            const struct pbnds_vec3 wo = pbnds_gbuffer_wo(&g, x, y);
            const struct pbnds_vec3 n = {g.normal[0][i], g.normal[1][i],
                                         g.normal[2][i]};
            const struct pbnds_vec3 ng = {g.geometric_normal[0][i],
                                          g.geometric_normal[1][i],
                                          g.geometric_normal[2][i]};
            assert_true(pbnds_dot(n, wo) > 4e-4f);
            assert_true(pbnds_dot(ng, wo) >= 0.0f);
            assert_near(pbnds_length(n), 1.0, 2e-6);
        }
    }
    pbnds_gbuffer_free(&g);
    free_mesh(mesh);
}

static void cut_out_texels_are_holes(void **state)
{
    (void)state;
    struct fixture f;
    make_square(&f, 1.0f, 1.0f, 1.0f);
    struct pbnds_vec2 uv[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    float texels[8] = {1, 1, 1, 0, 1, 1, 1, 1}; /* left half clear, right half solid */
    f.meshes[0].uv[0] = uv;
    f.materials[0].alpha_mode = PBNDS_ALPHA_MASK;
    f.materials[0].base_color_texture.texture = fixture_texture(&f, texels, 2, 1);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 0, -1), 80.0f);
    struct pbnds_gbuffer g = cast(&f, &c, 20, 20);
    for (size_t i = 0; i < 400; ++i) {
        if (i % 20 < 10) {
            assert_nothing(&g, i);
        } else {
            assert_near(g.coverage[i], 1.0, 0.0);
        }
    }
    pbnds_gbuffer_free(&g);
}

static void assert_same_planes(const struct pbnds_gbuffer *a,
                               const struct pbnds_gbuffer *b)
{
    const size_t size = (size_t)a->width * (size_t)a->height * sizeof(float);
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(a->albedo[c], b->albedo[c], size);
        assert_memory_equal(a->normal[c], b->normal[c], size);
        assert_memory_equal(a->position[c], b->position[c], size);
        assert_memory_equal(a->emission[c], b->emission[c], size);
        assert_memory_equal(a->geometric_normal[c], b->geometric_normal[c], size);
    }
    assert_memory_equal(a->specular, b->specular, size);
    assert_memory_equal(a->roughness, b->roughness, size);
    assert_memory_equal(a->metallic, b->metallic, size);
    assert_memory_equal(a->depth, b->depth, size);
    assert_memory_equal(a->coverage, b->coverage, size);
    assert_memory_equal(a->object_id, b->object_id, size);
}

static void fresnel_planes_come_when_specular_cannot_tell(void **state)
{
    (void)state;
    struct fixture f;
    make_square(&f, 1.0f, 1.0f, 1.0f);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 0, -1), 80.0f);
    f.materials[0].base_color = (struct pbnds_vec4){0.8f, 0.4f, 0.2f, 1.0f};
    f.materials[0].metallic = 0.25f;
    f.materials[1].unlit = true; /* worn by nothing */
    struct pbnds_gbuffer g = cast(&f, &c, 4, 4);
    assert_null(g.f90);
    assert_null(g.f0[2]);
    pbnds_gbuffer_free(&g);

    f.materials[0].specular = 0.5f;
    f.materials[0].specular_color = pbnds_vec3_make(1.0f, 0.5f, 0.25f);
    g = cast(&f, &c, 4, 4);
    assert_non_null(g.f90);
    const double metal[3] = {0.2, 0.1, 0.05};
    const double dielectric[3] = {0.02, 0.01, 0.005};
    double f0[3];
    for (int k = 0; k < 3; ++k) {
        f0[k] = metal[k] + 0.75 * dielectric[k];
        assert_near(g.f0[k][5], f0[k], 1e-6);
    }
    assert_near(g.f90[5], 0.25 + 0.75 * 0.5, 1e-6);
    assert_near(g.specular[5], 0.2126 * f0[0] + 0.7152 * f0[1] + 0.0722 * f0[2], 1e-6);
    pbnds_gbuffer_free(&g);

    f.materials[0].unlit = true;
    g = cast(&f, &c, 4, 4);
    assert_near(g.f90[5], 0.0, 0.0);
    assert_near(g.f0[0][5] + g.specular[5] + g.albedo[0][5], 0.0, 0.0);
    assert_near(g.emission[0][5], 0.8, 1e-6);
    pbnds_gbuffer_free(&g);
}

static void optional_planes_come_when_asked_for(void **state)
{
    (void)state;
    struct fixture f;
    make_square(&f, 1.0f, 1.0f, 1.0f); /* half of what 127 degrees see */
    struct pbnds_vec2 uv[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    float texel[4] = {0.3f, 0, 0, 1};
    f.meshes[0].uv[0] = uv;
    f.meshes[0].material = 2;
    f.materials[2].occlusion_texture.texture = fixture_texture(&f, texel, 1, 1);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 0, -1),
                  2.0f * atanf(2.0f) * 180.0f / PBNDS_PI);
    struct pbnds_gbuffer g = cast(&f, &c, 8, 8);
    assert_null(g.ao);
    assert_null(g.uv[0]);
    assert_null(g.motion[1]);
    assert_null(g.material_id);
    pbnds_gbuffer_free(&g);
    const struct pbnds_raycast_options options = {
        .optional = PBNDS_OPTIONAL_AO | PBNDS_OPTIONAL_UV | PBNDS_OPTIONAL_MATERIAL_ID};
    g = cast_with(&f, &c, 8, 8, &options);
    for (int y = 0; y < 8; ++y) {
        for (int x = 0; x < 8; ++x) {
            const size_t i = (size_t)(8 * y + x);
            const bool hit = x >= 2 && x < 6 && y >= 2 && y < 6;
            assert_near(g.coverage[i], hit ? 1.0 : 0.0, 0.0);
            assert_near(g.ao[i], hit ? 0.3 : 0.0, 1e-6);
            assert_int_equal(g.material_id[i], hit ? 2u : UINT32_MAX);
            assert_near(g.uv[0][i], hit ? (x - 2 + 0.5) / 4 : 0.0, 1e-6);
            assert_near(g.uv[1][i], hit ? (y - 2 + 0.5) / 4 : 0.0, 1e-6);
        }
    }
    pbnds_gbuffer_free(&g);
}

static void motion_known_answers(void **state)
{
    (void)state;
    struct fixture f;
    make_square(&f, 1.0f, 1.0f, 1.0f);
    struct pbnds_camera c =
        camera_at(pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 0, -1),
                  2.0f * atanf(2.0f) * 180.0f / PBNDS_PI);
    struct pbnds_raycast_options options = {.optional = PBNDS_OPTIONAL_MOTION};
    struct pbnds_gbuffer g = cast_with(&f, &c, 8, 8, &options);
    for (int i = 0; i < 64; ++i) /* at rest: nothing, to the bit */
        assert_true(g.motion[0][i] == 0.0f && g.motion[1][i] == 0.0f);
    pbnds_gbuffer_free(&g);

    /* A pixel is 0.5 m of the square. It came 0.5 m from the left and 0.25 m from below:
     * one pixel to the right, half a one up. */
    struct pbnds_vec3 before[4];
    for (int i = 0; i < 4; ++i)
        before[i] = pbnds_sub(square[i], pbnds_vec3_make(0.5f, 0.25f, 0.0f));
    f.meshes[0].previous = before;
    g = cast_with(&f, &c, 8, 8, &options);
    assert_near(g.motion[0][8 * 3 + 4], 1.0, 1e-5);
    assert_near(g.motion[1][8 * 3 + 4], -0.5, 1e-5);
    assert_near(g.motion[0][0], 0.0, 0.0); /* the background */
    pbnds_gbuffer_free(&g);

    /* The camera came from twice as far: points moved away from the middle. */
    struct pbnds_camera earlier = c;
    earlier.world_from_camera = pbnds_mat4_look_at(
        pbnds_vec3_make(0, 0, 1), pbnds_vec3_make(0, 0, -1), pbnds_vec3_make(0, 1, 0));
    f.meshes[0].previous = NULL;
    options.previous_camera = &earlier;
    g = cast_with(&f, &c, 8, 8, &options);
    assert_near(g.motion[0][8 * 3 + 5], 0.75, 1e-5); /* x was 4.75, is 5.5 */
    assert_near(g.motion[1][8 * 3 + 5], -0.25, 1e-5);
    pbnds_gbuffer_free(&g);

    /* It was behind the earlier camera: no position to move from. */
    earlier.world_from_camera = pbnds_mat4_look_at(
        pbnds_vec3_make(0, 0, -2), pbnds_vec3_make(0, 0, -3), pbnds_vec3_make(0, 1, 0));
    g = cast_with(&f, &c, 8, 8, &options);
    assert_near(g.motion[0][8 * 3 + 5], 0.0, 0.0);
    pbnds_gbuffer_free(&g);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    struct fixture f;
    fixture_init(&f);
    const struct pbnds_mesh *mesh =
        fixture_sphere(&f, pbnds_vec3_make(0, 0, 0), 1.0f, 40);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(1, 2, 2), pbnds_vec3_make(0.1f, 0, 0), 50.0f);
    pbnds_set_threads(1);
    struct pbnds_gbuffer one = cast(&f, &c, 733, 475);
    const int counts[] = {2, 5};
    for (int k = 0; k < 2; ++k) {
        pbnds_set_threads(counts[k]);
        struct pbnds_gbuffer many = cast(&f, &c, 733, 475);
        assert_same_planes(&one, &many);
        pbnds_gbuffer_free(&many);
    }
    pbnds_set_threads(0);
    pbnds_gbuffer_free(&one);
    free_mesh(mesh);
}

/* A scene with maps, packed and prefiltered, so that all of the pass is at work. */
static void tiles_and_threads_change_nothing(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    fixture_init(&f);
    struct pbnds_mesh *mesh = fixture_sphere(&f, pbnds_vec3_make(0, 0, 0), 1.0f, 30);
    struct pbnds_vec2 *uv = calloc(mesh->vertex_count, sizeof *uv);
    struct pbnds_vec4 *tangent = calloc(mesh->vertex_count, sizeof *tangent);
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        const struct pbnds_vec3 n = mesh->normal[i];
        uv[i] = (struct pbnds_vec2){n.x + 0.3f * n.z, n.y};
        tangent[i] = (struct pbnds_vec4){n.y, n.z, n.x, 1.0f};
    }
    mesh->uv[0] = uv;
    mesh->tangent = tangent;
    float texels[9 * 7 * 4];
    for (int i = 0; i < 9 * 7 * 4; ++i)
        texels[i] = (float)(i * 37 % 101) / 101.0f;
    struct pbnds_material *m = &f.materials[0];
    const int texture = fixture_texture(&f, texels, 9, 7);
    f.textures[texture].nearest = false;
    m->base_color_texture.texture = m->normal_texture.texture = texture;
    m->metallic_roughness_texture.texture = texture;
    assert_int_equal(pbnds_scene_pack(&f.scene, &error), PBNDS_OK);
    assert_int_equal(pbnds_scene_prefilter(&f.scene, 0, &error), PBNDS_OK);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(1, 2, 2), pbnds_vec3_make(0.1f, 0, 0), 50.0f);
    struct pbnds_accel *accel;
    assert_int_equal(pbnds_accel_create(&f.scene, &accel, &error), PBNDS_OK);
    struct pbnds_gbuffer one, again = {0};
    pbnds_set_threads(1);
    assert_int_equal(
        pbnds_gbuffer_raycast(&f.scene, accel, &c, 333, 175, NULL, &one, &error),
        PBNDS_OK);
    const int threads[] = {1, 2, 5}, sides[] = {1, 5, 8, 16, 31, 64, 1000};
    for (int k = 0; k < 21; ++k) {
        pbnds_set_threads(threads[k % 3]);
        pbnds_set_tile_side(sides[k / 3]);
        /* Into the memory of the one before, spoilt, or of another size. */
        if (again.storage && k % 2) again.albedo[1][77] = again.depth[99] = NAN;
        assert_int_equal(
            pbnds_gbuffer_recast(&f.scene, accel, &c, 333, 175, NULL, &again, &error),
            PBNDS_OK);
        assert_same_planes(&one, &again);
        if (k == 10)
            assert_int_equal(
                pbnds_gbuffer_recast(&f.scene, accel, &c, 20, 30, NULL, &again, &error),
                PBNDS_OK);
    }
    pbnds_set_tile_side(0);
    pbnds_set_threads(0);
    pbnds_gbuffer_free(&one);
    pbnds_gbuffer_free(&again);
    pbnds_accel_free(accel);
    pbnds_maps_free(f.scene.maps);
    free(mesh->packed);
    free(uv);
    free(tangent);
    free_mesh(mesh);
}

/* What the bench compares with does the same work. */
static void bare_rays_hit_what_the_pass_hits(void **state)
{
    (void)state;
    struct fixture f;
    struct pbnds_error error;
    fixture_init(&f);
    struct pbnds_mesh *mesh = fixture_sphere(&f, pbnds_vec3_make(0, 0, 0), 1.0f, 30);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(1, 2, 2), pbnds_vec3_make(0.1f, 0, 0), 50.0f);
    struct pbnds_accel *accel;
    assert_int_equal(pbnds_accel_create(&f.scene, &accel, &error), PBNDS_OK);
    struct pbnds_gbuffer g = cast(&f, &c, 128, 96);
    double covered = 0.0;
    for (size_t i = 0; i < 128 * 96; ++i)
        covered += (double)g.coverage[i];
    const struct pbnds_camera_view view = pbnds_camera_view(&c, 128, 96);
    assert_near((double)pbnds_accel_bare_primary(accel, &view, 128, 96), covered, 2.0);
    /* Off a convex body every path ends after one bounce: the primary ray, then a shadow
     * ray and the next ray of each hit. */
    assert_near((double)pbnds_accel_bare_paths(accel, &view, 128, 96, 2, 8),
                2.0 * (128.0 * 96.0 + 2.0 * covered), 0.01 * covered);
    pbnds_gbuffer_free(&g);
    pbnds_accel_free(accel);
    free_mesh(mesh);
}

static void sizes_are_checked(void **state)
{
    (void)state;
    const int sizes[][2] = {{0, 5}, {5, 0}, {-1, 5}, {65536, 1}, {1, 65536}, {0, 0}};
    struct pbnds_gbuffer g;
    struct pbnds_error error;
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; ++k) {
        assert_int_equal(pbnds_gbuffer_init(&g, sizes[k][0], sizes[k][1], &error),
                         PBNDS_ERROR_ARGUMENT);
        assert_null(g.storage);
        assert_null(g.depth);
    }
    assert_int_equal(pbnds_gbuffer_init(&g, 7, 3, &error), PBNDS_OK);
    for (size_t i = 0; i < 21; ++i)
        assert_nothing(&g, i);
    /* Planes do not overlap: mark each, then look at all. */
    float *const planes[] = {
        g.albedo[0], g.normal[2], g.specular,    g.roughness,   g.metallic,
        g.depth,     g.coverage,  g.position[1], g.emission[0], g.geometric_normal[2]};
    for (int p = 0; p < 10; ++p) {
        for (int i = 0; i < 21; ++i)
            planes[p][i] = (float)p;
    }
    for (int i = 0; i < 21; ++i)
        g.object_id[i] = 77;
    for (int p = 0; p < 10; ++p) {
        for (int i = 0; i < 21; ++i)
            assert_near(planes[p][i], p, 0.0);
    }
    pbnds_gbuffer_free(&g);
    pbnds_gbuffer_free(&g); /* twice is fine */
}

/* Last: the flag stays up. */
static void a_stop_leaves_nothing(void **state)
{
    (void)state;
    struct fixture f;
    make_square(&f, 1.0f, 1.0f, 1.0f);
    const struct pbnds_camera c =
        camera_at(pbnds_vec3_make(0, 0, 0), pbnds_vec3_make(0, 0, -1), 60.0f);
    struct pbnds_accel *accel;
    struct pbnds_gbuffer g;
    struct pbnds_error error;
    assert_int_equal(pbnds_accel_create(&f.scene, &accel, &error), PBNDS_OK);
    pbnds_request_stop();
    assert_int_equal(
        pbnds_gbuffer_raycast(&f.scene, accel, &c, 64, 64, NULL, &g, &error),
        PBNDS_ERROR_INTERRUPTED);
    assert_null(g.storage);
    pbnds_accel_free(accel);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_square_in_perspective),
        cmocka_unit_test(a_square_in_parallel_projection),
        cmocka_unit_test(material_planes),
        cmocka_unit_test(a_sphere_against_its_equation),
        cmocka_unit_test(every_normal_faces_the_eye),
        cmocka_unit_test(cut_out_texels_are_holes),
        cmocka_unit_test(fresnel_planes_come_when_specular_cannot_tell),
        cmocka_unit_test(optional_planes_come_when_asked_for),
        cmocka_unit_test(motion_known_answers),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(tiles_and_threads_change_nothing),
        cmocka_unit_test(bare_rays_hit_what_the_pass_hits),
        cmocka_unit_test(sizes_are_checked),
        cmocka_unit_test(a_stop_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
