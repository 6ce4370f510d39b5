/* The tree of nodes, its scenes, and the cameras in it. */
#include <math.h>

#include "engine/core/rng.h"
#include "tests/engine/scene/gltf/fixture.h"

/** M^-T n by Cramer's rule in double, unit length. */
static void naive_normal(const double m[9], const double n[3], double out[3])
{
    /* rows of m are m[0..2], ...; cof(m) / det(m) * n */
    double c[9], length = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const int a = (i + 1) % 3, b = (i + 2) % 3, p = (j + 1) % 3,
                      q = (j + 2) % 3;
            c[3 * i + j] = m[3 * a + p] * m[3 * b + q] - m[3 * a + q] * m[3 * b + p];
        }
    }
    const double det = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
    for (int i = 0; i < 3; ++i) {
        out[i] = (c[3 * i] * n[0] + c[3 * i + 1] * n[1] + c[3 * i + 2] * n[2]) / det;
        length += out[i] * out[i];
    }
    for (int i = 0; i < 3; ++i)
        out[i] /= sqrt(length);
}

static void check_transform(const double m[9])
{
    char matrix[400];
    (void)snprintf(
        matrix, sizeof matrix,
        "{\"mesh\":0,\"matrix\":[%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,"
        "0,1,2,3,1]}",
        m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]);
    struct pbnds_scene s;
    load_edit("{\"mesh\":0}", matrix, &s);
    const struct pbnds_mesh *mesh = &s.meshes[0];
    const double up[3] = {0, 0, 1};
    double n[3];
    naive_normal(m, up, n);
    for (int i = 0; i < 4; ++i) {
        const float *p = square.position + 3 * i;
        double q[3];
        for (int k = 0; k < 3; ++k) {
            q[k] = m[3 * k] * (double)p[0] + m[3 * k + 1] * (double)p[1] +
                   m[3 * k + 2] * (double)p[2] + k + 1;
        }
        assert_vec3(mesh->position[i], q[0], q[1], q[2], 1e-5);
        assert_vec3(mesh->normal[i], n[0], n[1], n[2], 1e-5);
    }
    /* Front stays front: the face looks where the vertex normals look. */
    for (size_t i = 0; i < 2; ++i) {
        const struct pbnds_vec3 face = pbnds_normalize(face_normal(mesh, i));
        assert_vec3(face, n[0], n[1], n[2], 1e-5);
    }
    pbnds_scene_free(&s);
}

static void transforms_agree_with_the_inverse_transpose(void **state)
{
    (void)state;
    struct pbnds_rng rng = pbnds_rng_make(1, 2, 3);
    int mirrored = 0;
    for (int i = 0; i < 40;) {
        double m[9];
        for (int k = 0; k < 9; ++k)
            m[k] = 4.0 * (double)pbnds_rng_float(&rng) - 2.0;
        const double det = m[0] * (m[4] * m[8] - m[5] * m[7]) -
                           m[1] * (m[3] * m[8] - m[5] * m[6]) +
                           m[2] * (m[3] * m[7] - m[4] * m[6]);
        if (fabs(det) < 0.5) continue;
        mirrored += det < 0;
        check_transform(m);
        ++i;
    }
    assert_in_range(mirrored, 5, 35);
}

static void nodes_make_a_tree(void **state)
{
    (void)state;
    struct pbnds_scene s;
    /* Node 0 turns a quarter about z and moves; its child 2 scales. Node 1 is in no
     * scene.
     */
    load_edit("\"nodes\":[{\"mesh\":0}]",
              "\"nodes\":[{\"children\":[2],\"translation\":[10,0,0],"
              "\"rotation\":[0,0,0.70710678,0.70710678]},{\"mesh\":0},"
              "{\"mesh\":0,\"scale\":[2,3,1],\"name\":\"leaf\"}]",
              &s);
    assert_int_equal(s.mesh_count, 1);
    assert_int_equal(s.meshes[0].object_id, 2);
    assert_vec3(s.meshes[0].position[1], 10, 2, 0,
                1e-5); /* (1,0,0) -> (2,0,0) -> (0,2,0) */
    assert_vec3(s.meshes[0].position[3], 7, 0, 0, 1e-5);
    assert_vec3(s.lo, 7, 0, 0, 1e-5);
    assert_vec3(s.hi, 10, 2, 0, 1e-5);
    pbnds_scene_free(&s);
    /* Without scenes every root is shown. */
    load_edit("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]",
              "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[5,0,0]}]", &s);
    assert_int_equal(s.mesh_count, 2);
    assert_int_equal(s.meshes[1].object_id, 1);
    assert_vec3(s.hi, 6, 1, 0, 1e-6);
    pbnds_scene_free(&s);
    /* The scene that is named, not the first. */
    load_edit("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]",
              "\"scene\":1,\"scenes\":[{\"nodes\":[0]},{\"nodes\":[1]}],"
              "\"nodes\":[{},{\"mesh\":0,\"translation\":[5,0,0]}]",
              &s);
    assert_int_equal(s.mesh_count, 1);
    assert_vec3(s.lo, 5, 0, 0, 1e-6);
    pbnds_scene_free(&s);
}

static void a_scene_is_chosen(void **state)
{
    (void)state;
    static const char scenes[] =
        "\"scene\":1,\"scenes\":[{\"name\":\"day\",\"nodes\":[0]},{\"name\":\"1\","
        "\"nodes\":[1]},{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0,\"name\":\"house\"},"
        "{\"mesh\":0,\"translation\":[5,0,0]}]";
    static const struct {
        const char *name;
        int meshes;
        double x;
    } cases[] = {{NULL, 1, 5}, {"day", 1, 0}, {"1", 1, 5}, {"0", 1, 0}, {"2", 2, 0}};
    char *json = edit(square_json,
                      "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                      "\"nodes\":[{\"mesh\":0}]",
                      scenes);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const struct pbnds_gltf_options options = {.scene = cases[i].name};
        struct pbnds_scene s;
        assert_int_equal(load_with(json, &square, sizeof square, &options, &s),
                         PBNDS_OK);
        assert_int_equal(s.mesh_count, cases[i].meshes);
        assert_near((double)s.meshes[0].position[0].x, cases[i].x, 0);
        /* Objects are the nodes, in the scene or not. */
        assert_int_equal(s.object_count, 2);
        assert_string_equal(s.objects[0].name, "house");
        assert_string_equal(s.objects[1].name, "node 1");
        assert_true(s.meshes[s.mesh_count - 1].object_id < 2);
        pbnds_scene_free(&s);
    }
    static const char *const none[] = {"night", "3", "-1", "", "0x0", " 0"};
    for (size_t i = 0; i < sizeof none / sizeof none[0]; ++i) {
        const struct pbnds_gltf_options options = {.scene = none[i]};
        struct pbnds_scene s;
        assert_int_equal(load_with(json, &square, sizeof square, &options, &s),
                         PBNDS_ERROR_ARGUMENT);
        assert_non_null(strstr(fault.message, "scene"));
    }
    free(json);
}

static void a_deep_tree_needs_no_stack(void **state)
{
    (void)state;
    enum { DEPTH = 50000 };
    char *nodes = malloc((size_t)DEPTH * 40 + 100);
    size_t at = (size_t)sprintf(nodes, "\"nodes\":[");
    for (int i = 0; i < DEPTH; ++i) {
        at += (size_t)sprintf(nodes + at, "{\"children\":[%d]},", i + 1);
    }
    (void)sprintf(nodes + at, "{\"mesh\":0}]");
    struct pbnds_scene s;
    load_edit("\"nodes\":[{\"mesh\":0}]", nodes, &s);
    assert_int_equal(s.meshes[0].object_id, DEPTH);
    pbnds_scene_free(&s);
    free(nodes);
}

static void cameras_are_rigid(void **state)
{
    (void)state;
    struct pbnds_scene s;
    load_edit(
        "\"nodes\":[{\"mesh\":0}]",
        "\"cameras\":[{\"type\":\"perspective\",\"name\":\"eye\",\"perspective\":"
        "{\"yfov\":0.7,\"znear\":0.1}},"
        "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":2.5,"
        "\"znear\":0,"
        "\"zfar\":9}}],"
        "\"nodes\":[{\"children\":[1,2],\"scale\":[2,-3,4],\"translation\":[1,2,3]},"
        "{\"camera\":0,\"rotation\":[0,0.70710678,0,0.70710678],"
        "\"translation\":[1,1,1]},{\"camera\":1,\"name\":\"from "
        "above\"},{\"camera\":0}]",
        &s);
    assert_int_equal(s.camera_count, 2); /* node 3 is in no scene */
    assert_string_equal(s.cameras[0].name, "eye");
    assert_string_equal(s.cameras[1].name, "from above");
    assert_false(s.cameras[0].orthographic);
    assert_true(s.cameras[1].orthographic);
    assert_near((double)s.cameras[0].yfov, 0.7, 1e-7);
    assert_near((double)s.cameras[1].ymag, 2.5, 1e-7);
    for (int i = 0; i < 2; ++i) {
        const struct pbnds_mat4 *m = &s.cameras[i].world_from_camera;
        assert_near((double)pbnds_mat4_det3(m), 1.0, 1e-5);
        for (int c = 0; c < 9; ++c) {
            double dot = 0;
            for (int r = 0; r < 3; ++r) {
                dot += (double)m->m[4 * (c / 3) + r] * (double)m->m[4 * (c % 3) + r];
            }
            assert_near(dot, c / 3 == c % 3 ? 1.0 : 0.0, 1e-5);
        }
    }
    const struct pbnds_mat4 *m = &s.cameras[0].world_from_camera;
    assert_vec3(pbnds_vec3_make(m->m[12], m->m[13], m->m[14]), 3, -1, 7, 1e-5);
    /* A quarter about y takes the local z axis to +x. */
    assert_vec3(pbnds_vec3_make(m->m[8], m->m[9], m->m[10]), 1, 0, 0, 1e-5);
    pbnds_scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(transforms_agree_with_the_inverse_transpose),
        cmocka_unit_test(nodes_make_a_tree),
        cmocka_unit_test(a_scene_is_chosen),
        cmocka_unit_test(a_deep_tree_needs_no_stack),
        cmocka_unit_test(cameras_are_rigid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
