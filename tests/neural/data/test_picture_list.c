/* Lists beside a set of photographs. */
#include <stdlib.h>
#include <string.h>

#include "neural/data/picture_list.h"
#include "tests/test.h"

static void names_are_numbers(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int index;
    } cases[] = {{"05030", 5030},
                 {"05030.png", 5030},
                 {"05000/05030.png", 5030},
                 {"0", 0},
                 {"000000000", 0},
                 {"999999999", 999999999},
                 {"1000000000", -1},
                 {"", -1},
                 {".png", -1},
                 {"face", -1},
                 {"5a", -1},
                 {"-5", -1},
                 {"5 ", -1},
                 {"05000/", -1},
                 {"7.x.png", 7},
                 {"a/b/00012.exr", 12}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        if (pbnds_picture_index(cases[i].name) != cases[i].index)
            fail_msg("%s: %d", cases[i].name, pbnds_picture_index(cases[i].name));
    }
}

static enum pbnds_status json(struct pbnds_picture_list *list, const char *text,
                              struct pbnds_error *error)
{
    *list = (struct pbnds_picture_list){NULL, 0};
    const enum pbnds_status status =
        pbnds_picture_list_json(list, text, strlen(text), "fov.json", error);
    return status == PBNDS_OK ? pbnds_picture_list_sort(list, "fov.json", error)
                              : status;
}

static void values_are_found(void **state)
{
    (void)state;
    struct pbnds_picture_list list;
    struct pbnds_error error = {""};
    assert_int_equal(json(&list,
                          "{\"00009\": 9.5, \"3\": 3, \"x\": 1, \"00007.png\": 7, "
                          "\"5\": \"wide\", \"1\": 1, \"2\": 2, \"4\": 1e999}",
                          &error),
                     PBNDS_OK);
    assert_int_equal(list.count, 7);
    assert_near(pbnds_picture_list_find(&list, 9), 9.5, 0.0);
    assert_near(pbnds_picture_list_find(&list, 7), 7.0, 0.0);
    assert_near(pbnds_picture_list_find(&list, 3), 3.0, 0.0);
    assert_near(pbnds_picture_list_find(&list, 1), 1.0, 0.0);
    assert_true(isnan(pbnds_picture_list_find(&list, 5)));
    assert_true(isnan(pbnds_picture_list_find(&list, 6)));
    assert_true(isinf(pbnds_picture_list_find(&list, 4)));
    pbnds_picture_list_free(&list);
    assert_true(isnan(pbnds_picture_list_find(&list, 9)));
    assert_int_equal(json(&list, "{}", &error), PBNDS_OK);
    assert_int_equal(list.count, 0);
    pbnds_picture_list_free(&list);

    static const char *const bad[] = {
        "", "{", "[1]", "7", "{\"5\": 1, \"05\": 2}", "{\"5\": \"a\", \"05\": \"a\"}"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        assert_int_equal(json(&list, bad[i], &error), PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(error.message, "fov.json"));
        pbnds_picture_list_free(&list);
    }
    assert_int_equal(json(&list, "{\"5\": 1, \"05\": 1}", &error), PBNDS_OK);
    pbnds_picture_list_free(&list);
}

static void lines_are_read(void **state)
{
    (void)state;
    struct pbnds_picture_list list = {NULL, 0};
    struct pbnds_error error = {""};
    static const char text[] = "# of the paper\r\n\n 00001 \r\n05000/00002.png\n3";
    assert_int_equal(
        pbnds_picture_list_lines(&list, text, strlen(text), 2.0, "test.txt", &error),
        PBNDS_OK);
    assert_int_equal(list.count, 3);
    static const char more[] = "4\n4\n";
    assert_int_equal(
        pbnds_picture_list_lines(&list, more, strlen(more), 0.0, "train.txt", &error),
        PBNDS_OK);
    assert_int_equal(pbnds_picture_list_sort(&list, "lists", &error), PBNDS_OK);
    assert_near(pbnds_picture_list_find(&list, 2), 2.0, 0.0);
    assert_near(pbnds_picture_list_find(&list, 3), 2.0, 0.0);
    assert_near(pbnds_picture_list_find(&list, 4), 0.0, 0.0);
    static const char both[] = "3";
    assert_int_equal(pbnds_picture_list_lines(&list, both, 1, 0.0, "train.txt", &error),
                     PBNDS_OK);
    assert_int_equal(pbnds_picture_list_sort(&list, "lists", &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "picture 3"));
    static const char odd[] = "1\nface\n";
    assert_int_equal(
        pbnds_picture_list_lines(&list, odd, strlen(odd), 0.0, "val.txt", &error),
        PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "val.txt: line 2"));
    pbnds_picture_list_free(&list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_numbers),
        cmocka_unit_test(values_are_found),
        cmocka_unit_test(lines_are_read),
    };
    return cmocka_run_group_tests_name("neural/data/picture_list", tests, NULL, NULL);
}
