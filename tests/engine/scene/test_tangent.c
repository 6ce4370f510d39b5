/* Tangents where a file brings none. */
#include <math.h>
#include <unistd.h>

#include "engine/scene/tangent.h"
#include "tests/engine/scene/gltf/fixture.h"

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
    assert_int_equal(pbnds_mesh_tangents(m, 0, NULL, "avocado", &fault), PBNDS_OK);
    size_t alike = 0;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        const struct pbnds_vec4 a = baked[i], b = m->tangent[i];
        alike += a.w == b.w && a.x * b.x + a.y * b.y + a.z * b.z > 0.99f;
    }
    assert_true(alike * 100 > m->vertex_count * 98);
    free(baked);
    pbnds_scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tangents_of_a_picture),
        cmocka_unit_test(degenerate_uv_give_unit_tangents),
        cmocka_unit_test(tangents_agree_with_a_baked_model),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
