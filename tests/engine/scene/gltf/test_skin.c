/* Skins. */
#include "tests/engine/scene/gltf/fixture.h"

static void skins_take_their_rest_pose(void **state)
{
    (void)state;
    /* Joint 1 at x = 10, joint 2 turned a half about z; inverse bind matrices move by
     * -1 in x. The node's own translation must not count. */
    struct {
        struct square square;
        uint8_t joints[16];
        float weights[16];
        float bind[32];
    } bin = {
        square,
        {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0},
        {1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0, 1, 0, 0, 2, 0, 0, 0},
        {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1,
         1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1},
    };
    char *a = edit(square_json, "\"NORMAL\":1",
                   "\"NORMAL\":1,\"JOINTS_0\":4,\"WEIGHTS_0\":5");
    char *b = edit(a, "\"byteLength\":144", "\"byteLength\":352");
    char *c = edit(b, "\"byteLength\":12}",
                   "\"byteLength\":12},"
                   "{\"buffer\":0,\"byteOffset\":144,\"byteLength\":208}");
    char *d =
        edit(c, "\"type\":\"SCALAR\"}",
             "\"type\":\"SCALAR\"},"
             "{\"bufferView\":2,\"componentType\":5121,\"count\":4,\"type\":\"VEC4\"},"
             "{\"bufferView\":2,\"byteOffset\":16,\"componentType\":5126,\"count\":4,"
             "\"type\":\"VEC4\"},"
             "{\"bufferView\":2,\"byteOffset\":80,\"componentType\":5126,\"count\":2,"
             "\"type\":\"MAT4\"}");
    char *json = edit(d, "\"nodes\":[{\"mesh\":0}]",
                      "\"nodes\":[{\"mesh\":0,\"skin\":0,\"translation\":[0,0,99]},"
                      "{\"translation\":[10,0,0]},{\"rotation\":[0,0,1,0]}],"
                      "\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":6}]");
    struct pbnds_scene s;
    must_load(json, &bin, sizeof bin, &s);
    const struct pbnds_mesh *m = &s.meshes[0];
    assert_vec3(m->position[0], 9, 0, 0, 1e-5); /* (0,0,0) -> (-1,0,0) -> +10 */
    assert_vec3(m->position[1], 5, 0, 0,
                1e-5); /* (0,0,0): mean of (10,0,0) and itself */
    assert_vec3(m->position[2], 0, -1, 0, 1e-5); /* (0,1,0) turned */
    assert_vec3(m->position[3], 9, 1, 0, 1e-5);  /* weights are normalised */
    assert_vec3(m->normal[2], 0, 0, 1, 1e-5);
    pbnds_scene_free(&s);
    bin.joints[0] = 2; /* the skin has two */
    assert_int_equal(load(json, &bin, sizeof bin, &s), PBNDS_ERROR_FORMAT);
    free(a);
    free(b);
    free(c);
    free(d);
    free(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(skins_take_their_rest_pose),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
