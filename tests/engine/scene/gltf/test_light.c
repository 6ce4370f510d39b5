/* KHR_lights_punctual. */
#include <math.h>

#include "tests/engine/scene/gltf/builder.h"

static enum pbnds_status load_lights(const char *lights, const char *nodes,
                                     struct pbnds_scene *s)
{
    char json[2000];
    (void)snprintf(json, sizeof json,
                   "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":["
                   "\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{"
                   "\"lights\":[%s]}},\"nodes\":[%s]}",
                   lights, nodes);
    return load(json, NULL, 0, s);
}

#define LIGHT(n) "\"extensions\":{\"KHR_lights_punctual\":{\"light\":" #n "}}"

static void lights_are_placed(void **state)
{
    (void)state;
    struct pbnds_scene s;
    /* Node 0 turns -z to -x by a quarter about +y and moves; scales and a mirror of x are
     * no part of it. Node 2 looks down, node 4 is in no list of children. */
    assert_int_equal(
        load_lights(
            "{\"type\":\"point\",\"name\":\"bulb\",\"color\":[1,0.5,0.25],"
            "\"intensity\":8,\"range\":12},"
            "{\"type\":\"directional\"},"
            "{\"type\":\"spot\",\"intensity\":2,\"spot\":{\"innerConeAngle\":0.3,"
            "\"outerConeAngle\":0.6}},"
            "{\"type\":\"spot\",\"spot\":{}}",
            "{\"children\":[1,2],\"translation\":[1,2,3],\"scale\":[-2,5,9],"
            "\"rotation\":[0,0.70710678,0,0.70710678]},"
            "{" LIGHT(0) ",\"translation\":[0,1,0]},"
                         "{" LIGHT(2) ",\"rotation\":[-0.70710678,0,0,0.70710678]},"
                                      "{" LIGHT(1) ",\"name\":\"sun\"},"
                                                   "{" LIGHT(
                                                       3) ",\"matrix\":[3,0,0,0,0,3,0,"
                                                          "0,0,0,0.01,0,4,4,4,1]}",
            &s),
        PBNDS_OK);
    assert_int_equal(s.light_count, 4);
    assert_null(strstr(warnings, "KHR_lights_punctual"));
    const struct pbnds_light *l = s.lights;
    assert_int_equal(l[0].kind, PBNDS_LIGHT_POINT);
    assert_string_equal(l[0].name, "bulb");
    assert_vec3(l[0].position, 1, 7, 3, 1e-5);
    assert_vec3(l[0].intensity, 8, 4, 2, 1e-6);
    assert_near((double)l[0].range, 12, 0);
    assert_int_equal(l[1].kind, PBNDS_LIGHT_SPOT);
    assert_vec3(l[1].position, 1, 2, 3, 1e-5);
    assert_vec3(l[1].direction, 0, -1, 0, 1e-5);
    assert_vec3(l[1].intensity, 2, 2, 2, 0);
    assert_true(isinf(l[1].range));
    assert_near((double)l[1].cos_inner, cos(0.3), 1e-6);
    assert_near((double)l[1].cos_outer, cos(0.6), 1e-6);
    assert_int_equal(l[2].kind, PBNDS_LIGHT_DIRECTIONAL);
    assert_string_equal(l[2].name, "sun");
    assert_vec3(l[2].direction, 0, 0, -1, 0);
    assert_vec3(l[2].intensity, 1, 1, 1, 0);
    assert_vec3(l[3].position, 4, 4, 4, 0);
    assert_vec3(l[3].direction, 0, 0, -1, 1e-6);
    assert_near((double)l[3].cos_inner, 1, 1e-6);
    assert_near((double)l[3].cos_outer, sqrt(0.5), 1e-6);
    pbnds_scene_free(&s);
    /* The direction that node 0 alone has. */
    assert_int_equal(
        load_lights("{\"type\":\"directional\"}",
                    "{" LIGHT(0) ",\"scale\":[-2,5,9],"
                                 "\"rotation\":[0,0.70710678,0,0.70710678]}",
                    &s),
        PBNDS_OK);
    assert_vec3(s.lights[0].direction, -1, 0, 0, 1e-6);
    pbnds_scene_free(&s);
}

static void lights_of_other_scenes_stay_out(void **state)
{
    (void)state;
    struct pbnds_scene s;
    assert_int_equal(
        load("{\"asset\":{\"version\":\"2.0\"},\"extensions\":{"
             "\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\"}]}},"
             "\"scenes\":[{\"nodes\":[1]}],\"nodes\":[{" LIGHT(
                 0) "},"
                    "{" LIGHT(0) "},{" LIGHT(0) "}]}",
             NULL, 0, &s),
        PBNDS_OK);
    assert_int_equal(s.light_count, 1);
    assert_string_equal(s.lights[0].name, "light 0");
    pbnds_scene_free(&s);
}

static void faulty_lights_are_told(void **state)
{
    (void)state;
    static const char *const lights[] = {
        "{\"type\":\"area\"}",
        "{\"type\":\"point\",\"intensity\":-1}",
        "{\"type\":\"point\",\"intensity\":1e300}",
        "{\"type\":\"point\",\"color\":[1,-1,1]}",
        "{\"type\":\"point\",\"range\":-2}",
        "{\"type\":\"spot\",\"spot\":{\"innerConeAngle\":0.7,\"outerConeAngle\":0.7}}",
        "{\"type\":\"spot\",\"spot\":{\"innerConeAngle\":-0.1}}",
        "{\"type\":\"spot\",\"spot\":{\"outerConeAngle\":1.6}}",
    };
    struct pbnds_scene s;
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; ++i) {
        const enum pbnds_status status = load_lights(lights[i], "{" LIGHT(0) "}", &s);
        if (status != PBNDS_ERROR_FORMAT) fail_msg("%s: %d", lights[i], status);
        assert_non_null(strstr(fault.message, "light"));
    }
    static const char *const nodes[] = {"{" LIGHT(1) "}", "{" LIGHT(-1) "}",
                                        "{" LIGHT(0.5) "}", "{" LIGHT("x") "}",
                                        "{" LIGHT(0) ",\"translation\":[1e39,0,0]}"};
    for (size_t i = 0; i < sizeof nodes / sizeof nodes[0]; ++i) {
        const enum pbnds_status status =
            load_lights("{\"type\":\"point\"}", nodes[i], &s);
        if (status != PBNDS_ERROR_FORMAT) fail_msg("%s: %d", nodes[i], status);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lights_are_placed),
        cmocka_unit_test(lights_of_other_scenes_stay_out),
        cmocka_unit_test(faulty_lights_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
