/* Tangents where a file brings none. The golden numbers are of the reference implementation
 * of MikkTSpace (tests/reference/tangents_blender.py). By hand, the same script wrote every
 * corner of Avocado, CesiumMan, FlightHelmet, NormalTangentTest and LeePerrySmith: at all
 * 376546 corners ours differ by less than 1e-4, with the same sign. */
#include <math.h>
#include <unistd.h>

#include "engine/scene/tangent.h"
#include "tests/engine/scene/gltf/fixture.h"
#include "tests/reference/tangents_blender.h"

static void tangents_of_a_picture(void **state)
{
    (void)state;
    /* An upright picture on the square: tangent +x, bitangent (up in the picture) +y.
     * Mirrored uv turn both the tangent and the handedness. */
    for (int mirror = 0; mirror < 2; ++mirror) {
        struct square bin = square;
        for (int i = 0; mirror && i < 4; ++i)
            bin.uv[2 * i] = 1.0f - bin.uv[2 * i];
        struct pbnds_scene s;
        char *a = edit(square_json, "\"indices\":3", "\"indices\":3,\"material\":0");
        char *json =
            edit(a, "\"buffers\"",
                 "\"materials\":[{\"normalTexture\":{\"index\":0,\"scale\":0.5}}],"
                 "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":"
                 "\"data:image/png;base64," PNG_BASE64 "\"}],\"buffers\"");
        must_load(json, &bin, sizeof bin, &s);
        assert_near((double)s.materials[0].normal_scale, 0.5, 0);
        for (int i = 0; i < 4; ++i) {
            const struct pbnds_vec4 t = s.meshes[0].tangent[i];
            const struct pbnds_vec3 direction = {t.x, t.y, t.z};
            assert_vec3(direction, mirror ? -1 : 1, 0, 0, 1e-6);
            assert_vec3(pbnds_scale(pbnds_cross(s.meshes[0].normal[i], direction), t.w),
                        0, 1, 0, 1e-6);
        }
        pbnds_scene_free(&s);
        free(a);
        free(json);
    }
}

static void degenerate_uv_give_unit_tangents(void **state)
{
    (void)state;
    struct pbnds_scene s;
    must_load(square_json, &square, sizeof square, &s);
    for (int i = 0; i < 4; ++i)
        s.meshes[0].uv[0][i] = (struct pbnds_vec2){0.5f, 0.5f};
    assert_int_equal(pbnds_mesh_tangents(&s.meshes[0], 0, NULL, "x", &fault), PBNDS_OK);
    for (int i = 0; i < 4; ++i) {
        const struct pbnds_vec4 t = s.meshes[0].tangent[i];
        assert_near(hypot(hypot((double)t.x, (double)t.y), (double)t.z), 1.0, 1e-6);
        assert_near((double)t.z, 0.0, 1e-6);
    }
    pbnds_scene_free(&s);
}

/** Copies `count` elements into an array that a mesh may free. */
static void *own(const void *data, size_t count, size_t size)
{
    void *copy = malloc(count * size);
    memcpy(copy, data, count * size);
    return copy;
}

static struct pbnds_mesh make_sheet(void)
{
    struct pbnds_mesh m = {.vertex_count = SHEET_VERTICES,
                           .triangle_count = SHEET_CORNERS / 3};
    m.position = own(sheet_position, SHEET_VERTICES, sizeof *m.position);
    m.normal = own(sheet_normal, SHEET_VERTICES, sizeof *m.normal);
    m.uv[1] = own(sheet_uv, SHEET_VERTICES, sizeof *m.uv[1]);
    m.index = own(sheet_index, SHEET_CORNERS, sizeof *m.index);
    m.color = malloc(SHEET_VERTICES * sizeof *m.color);
    m.previous = malloc(SHEET_VERTICES * sizeof *m.previous);
    for (size_t i = 0; i < SHEET_VERTICES; ++i) {
        m.color[i] = (struct pbnds_vec4){(float)i, 1, 2, 3};
        m.previous[i] = pbnds_splat((float)i);
    }
    return m;
}

/** A scene of one mesh, to be freed as such. */
static void free_mesh(const struct pbnds_mesh *m)
{
    struct pbnds_scene s = {.meshes = own(m, 1, sizeof *m), .mesh_count = 1};
    pbnds_scene_free(&s);
}

static double distance(struct pbnds_vec4 a, const float *b)
{
    return hypot(hypot((double)(a.x - b[0]), (double)(a.y - b[1])),
                 (double)(a.z - b[2]));
}

static void tangents_are_those_of_the_reference(void **state)
{
    (void)state;
    struct pbnds_mesh m = make_sheet();
    uint32_t *origin = NULL;
    assert_int_equal(pbnds_mesh_tangents(&m, 1, &origin, "sheet", &fault), PBNDS_OK);
    /* The seam of three vertices is mirrored. The triangle without an area in the picture
     * is reached over its edge, and its loose corner takes nothing. */
    assert_int_equal(m.vertex_count, SHEET_VERTICES + 3);
    size_t compared = 0;
    for (size_t c = 0; c < SHEET_CORNERS; ++c) {
        const uint32_t v = m.index[c];
        const uint32_t was = v < SHEET_VERTICES ? v : origin[v];
        assert_int_equal(was, sheet_index[c]);
        assert_int_equal(origin[v], was);
        assert_true(m.color[v].x == (float)was && m.previous[v].y == (float)was);
        assert_memory_equal(&m.position[v], sheet_position[was], 12);
        assert_memory_equal(&m.normal[v], sheet_normal[was], 12);
        assert_memory_equal(&m.uv[1][v], sheet_uv[was], 8);
        const float *t = sheet_tangent[c];
        if (t[0] == 1.0f) continue; /* the reference's "none" */
        assert_near(distance(m.tangent[v], t), 0, 2e-5);
        assert_true(m.tangent[v].w == t[3]);
        ++compared;
    }
    assert_int_equal(compared, SHEET_CORNERS - 1);
    free(origin);
    free_mesh(&m);
}

static void the_order_of_triangles_does_not_matter(void **state)
{
    (void)state;
    struct pbnds_mesh m = make_sheet();
    for (size_t i = 0; i < m.triangle_count / 2; ++i) {
        for (size_t k = 0; k < 3; ++k) {
            uint32_t *a = &m.index[3 * i + k],
                     *b = &m.index[3 * (m.triangle_count - 1 - i) + k];
            const uint32_t kept = *a;
            *a = *b;
            *b = kept;
        }
    }
    assert_int_equal(pbnds_mesh_tangents(&m, 1, NULL, "sheet", &fault), PBNDS_OK);
    assert_int_equal(m.vertex_count, SHEET_VERTICES + 3);
    for (size_t i = 0; i < m.triangle_count; ++i) {
        for (size_t k = 0; k < 3; ++k) {
            const float *t = sheet_tangent[3 * (m.triangle_count - 1 - i) + k];
            if (t[0] == 1.0f) continue;
            assert_near(distance(m.tangent[m.index[3 * i + k]], t), 0, 2e-5);
        }
    }
    free_mesh(&m);
}

static void shared_or_not_the_tangents_are_the_same(void **state)
{
    (void)state;
    struct pbnds_mesh shared = make_sheet(), apart = make_sheet();
    free(apart.position);
    free(apart.normal);
    free(apart.uv[1]);
    free(apart.color);
    free(apart.previous);
    apart.color = NULL;
    apart.previous = NULL;
    apart.vertex_count = SHEET_CORNERS;
    apart.position = malloc(SHEET_CORNERS * sizeof *apart.position);
    apart.normal = malloc(SHEET_CORNERS * sizeof *apart.normal);
    apart.uv[1] = malloc(SHEET_CORNERS * sizeof *apart.uv[1]);
    for (uint32_t c = 0; c < SHEET_CORNERS; ++c) {
        apart.position[c] = shared.position[shared.index[c]];
        apart.normal[c] = shared.normal[shared.index[c]];
        apart.uv[1][c] = shared.uv[1][shared.index[c]];
        apart.index[c] = c;
    }
    uint32_t *origin = NULL;
    assert_int_equal(pbnds_mesh_tangents(&shared, 1, NULL, "x", &fault), PBNDS_OK);
    assert_int_equal(pbnds_mesh_tangents(&apart, 1, &origin, "x", &fault), PBNDS_OK);
    assert_null(origin); /* nothing was added */
    for (uint32_t c = 0; c < SHEET_CORNERS; ++c) {
        if (sheet_tangent[c][0] == 1.0f) continue;
        assert_memory_equal(&shared.tangent[shared.index[c]], &apart.tangent[c],
                            sizeof *apart.tangent);
    }
    free_mesh(&shared);
    free_mesh(&apart);
}

static void flat_faces_get_tangents_of_their_own(void **state)
{
    (void)state;
    /* A roof: two faces that meet in an edge, picture upright on both. */
    static const float position[] = {0, 0, 0, 0, 1, 0, -1, 0, -1, 1, 0, -1};
    static const float uv[] = {0.5f, 1, 0.5f, 0, 0, 1, 1, 1};
    static const uint32_t index[] = {2, 0, 1, 0, 3, 1};
    struct pbnds_mesh m = {.vertex_count = 4, .triangle_count = 2};
    m.position = own(position, 4, sizeof *m.position);
    m.uv[0] = own(uv, 4, sizeof *m.uv[0]);
    m.index = own(index, 6, sizeof *m.index);
    uint32_t *origin = NULL;
    assert_int_equal(pbnds_mesh_tangents(&m, 0, &origin, "roof", &fault), PBNDS_OK);
    assert_null(m.normal); /* still flat */
    assert_int_equal(m.vertex_count, 6);
    for (uint32_t c = 0; c < 6; ++c) {
        assert_int_equal(m.index[c], c);
        assert_int_equal(origin[c], index[c]);
        assert_memory_equal(&m.position[c], position + 3 * index[c], 12);
        const double side = c < 3 ? 1 : -1; /* both look to +z and run to +x */
        const struct pbnds_vec4 t = m.tangent[c];
        assert_vec3(pbnds_vec3_make(t.x, t.y, t.z), sqrt(0.5), 0, side * sqrt(0.5),
                    1e-6);
        assert_true(t.w == 1.0f);
    }
    free(origin);
    free_mesh(&m);
}

static void a_hard_edge_keeps_tangents_apart(void **state)
{
    (void)state;
    /* The same roof with the normals of its faces: only they differ along the edge. */
    static const float position[] = {-1, 0, -1, 0, 0, 0,  0, 1, 0,
                                     0,  0, 0,  1, 0, -1, 0, 1, 0};
    static const float uv[] = {0, 1, 0.5f, 1, 0.5f, 0, 0.5f, 1, 1, 1, 0.5f, 0};
    static const uint32_t index[] = {0, 1, 2, 3, 4, 5};
    const float h = sqrtf(0.5f);
    struct pbnds_mesh m = {.vertex_count = 6, .triangle_count = 2};
    m.position = own(position, 6, sizeof *m.position);
    m.uv[0] = own(uv, 6, sizeof *m.uv[0]);
    m.index = own(index, 6, sizeof *m.index);
    m.normal = malloc(6 * sizeof *m.normal);
    for (int i = 0; i < 6; ++i)
        m.normal[i] = pbnds_vec3_make(i < 3 ? -h : h, 0, h);
    assert_int_equal(pbnds_mesh_tangents(&m, 0, NULL, "roof", &fault), PBNDS_OK);
    for (int i = 0; i < 6; ++i) {
        const float along[3] = {h, 0, i < 3 ? h : -h};
        assert_near(distance(m.tangent[i], along), 0, 1e-6);
    }
    free_mesh(&m);
}

static void many_faces_at_one_vertex_take_no_time(void **state)
{
    (void)state;
    /* A fan of 100000 faces whose rim is not shared and whose picture is turned a bit more
     * on each: one vertex becomes 100000. What is quadratic in it would be noticed. */
    enum { FACES = 100000 };
    struct pbnds_mesh m = {.vertex_count = 2 * FACES + 1, .triangle_count = FACES};
    m.position = calloc(m.vertex_count, sizeof *m.position);
    m.normal = calloc(m.vertex_count, sizeof *m.normal);
    m.uv[0] = calloc(m.vertex_count, sizeof *m.uv[0]);
    m.index = calloc(3 * m.triangle_count, sizeof *m.index);
    for (size_t i = 0; i < m.vertex_count; ++i)
        m.normal[i] = pbnds_vec3_make(0, 0, 1);
    for (uint32_t i = 0; i < FACES; ++i) {
        for (uint32_t k = 0; k < 2; ++k) {
            const uint32_t v = 1 + 2 * i + k;
            const float a = 6.2831853f * (float)i / FACES + 0.01f * (float)k;
            m.position[v] = pbnds_vec3_make(cosf(a), sinf(a), 0);
            m.uv[0][v] = k ? (struct pbnds_vec2){0, 1} : (struct pbnds_vec2){1, 0};
            m.index[3 * i + 1 + k] = v;
        }
    }
    assert_int_equal(pbnds_mesh_tangents(&m, 0, NULL, "fan", &fault), PBNDS_OK);
    assert_true(m.vertex_count > 2 * FACES + FACES / 2);
    for (uint32_t i = 0; i < FACES; ++i) {
        const struct pbnds_vec3 u = m.position[m.index[3 * i + 1]];
        const float along[3] = {u.x, u.y, u.z};
        assert_near(distance(m.tangent[m.index[3 * i]], along), 0, 1e-3);
    }
    free_mesh(&m);
}

/** Tangents that a baker wrote agree with ours nearly everywhere. */
static void tangents_agree_with_a_baked_model(void **state)
{
    (void)state;
    struct pbnds_scene s;
    if (access(PBNDS_SHARED_DATA "/models/objects/Avocado", R_OK) != 0) skip();
    assert_int_equal(pbnds_gltf_load(PBNDS_SHARED_DATA
                                     "/models/objects/Avocado/Avocado.gltf",
                                     NULL, NULL, &s, &fault),
                     PBNDS_OK);
    struct pbnds_mesh *m = &s.meshes[0];
    struct pbnds_vec4 *baked = m->tangent;
    uint32_t *origin = NULL;
    assert_int_equal(pbnds_mesh_tangents(m, 0, &origin, "avocado", &fault), PBNDS_OK);
    size_t alike = 0;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const struct pbnds_vec4 a = baked[origin ? origin[i] : i], b = m->tangent[i];
        alike += a.w == b.w && a.x * b.x + a.y * b.y + a.z * b.z > 0.99f;
    }
    assert_true(alike * 100 > m->vertex_count * 98);
    free(origin);
    free(baked);
    pbnds_scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tangents_of_a_picture),
        cmocka_unit_test(degenerate_uv_give_unit_tangents),
        cmocka_unit_test(tangents_are_those_of_the_reference),
        cmocka_unit_test(the_order_of_triangles_does_not_matter),
        cmocka_unit_test(shared_or_not_the_tangents_are_the_same),
        cmocka_unit_test(flat_faces_get_tangents_of_their_own),
        cmocka_unit_test(a_hard_edge_keeps_tangents_apart),
        cmocka_unit_test(many_faces_at_one_vertex_take_no_time),
        cmocka_unit_test(tangents_agree_with_a_baked_model),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
