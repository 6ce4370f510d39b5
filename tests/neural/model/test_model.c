/* The networks' tables and their weights files. */
#include "tests/test.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "neural/model/model.h"

static struct pbnds_backend *backend;

static struct pbnds_net *make(const char *name)
{
    struct pbnds_net *net;
    struct pbnds_error error = {{0}};
    const struct pbnds_model *model = pbnds_model_find(name);
    assert_non_null(model);
    if (pbnds_net_create(&model->table, backend, PBNDS_F32, &net, &error) != PBNDS_OK) {
        fail_msg("%s", error.message);
    }
    return net;
}

/* Counted by hand from the tables: a change of a network is a change of these numbers.
 */
static void parameter_counts_are_known(void **state)
{
    (void)state;
    struct pbnds_net *t = make("transport"), *p = make("pbnds+");
    assert_int_equal(pbnds_net_param_count(t), 405796);
    assert_int_equal(pbnds_net_param_count(p), 493139);
    assert_int_equal(pbnds_net_deepest_level(t), 4);
    assert_int_equal(pbnds_net_deepest_level(p), 3);
    pbnds_net_free(t);
    pbnds_net_free(p);
    assert_null(pbnds_model_find("pbnds-minus"));
}

static void weights_survive_the_file(void **state)
{
    (void)state;
    const char *path = "test_model_weights.safetensors";
    const struct pbnds_model *model = pbnds_model_find("pbnds+"), *found;
    struct pbnds_net *a = make("pbnds+"), *b = make("pbnds+");
    pbnds_net_init(a, 3);
    char key[] = "train.note", value[] = "a \"quoted\" note";
    const struct pbnds_metadata extra = {key, value};
    assert_int_equal(pbnds_weights_save(path, model, a, &extra, 1, NULL), PBNDS_OK);
    struct pbnds_safetensors file;
    assert_int_equal(pbnds_weights_open(path, &file, &found, NULL), PBNDS_OK);
    assert_ptr_equal(found, model);
    assert_string_equal(pbnds_safetensors_metadata(&file, "train.note"), value);
    assert_int_equal(pbnds_weights_apply(path, &file, b, NULL), PBNDS_OK);
    assert_memory_equal(pbnds_net_params(a), pbnds_net_params(b),
                        pbnds_net_param_count(a) * sizeof(float));
    pbnds_safetensors_free(&file);
    (void)unlink(path);
    pbnds_net_free(a);
    pbnds_net_free(b);
}

static void weights_of_another_model_are_refused(void **state)
{
    (void)state;
    const char *path = "test_model_other.safetensors";
    struct pbnds_net *p = make("pbnds+"), *t = make("transport");
    pbnds_net_init(p, 3);
    assert_int_equal(
        pbnds_weights_save(path, pbnds_model_find("pbnds+"), p, NULL, 0, NULL),
        PBNDS_OK);
    struct pbnds_safetensors file;
    const struct pbnds_model *found;
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_weights_open(path, &file, &found, NULL), PBNDS_OK);
    assert_int_equal(pbnds_weights_apply(path, &file, t, &error), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, path));
    assert_non_null(
        strstr(error.message, "enc1a.weight")); /* the first that is missing */
    pbnds_safetensors_free(&file);
    (void)unlink(path);
    pbnds_net_free(p);
    pbnds_net_free(t);
}

static void not_finite_is_refused(void **state)
{
    (void)state;
    const char *path = "test_model_nan.safetensors";
    struct pbnds_net *p = make("pbnds+");
    pbnds_net_init(p, 3);
    pbnds_net_params(p)[100] = NAN;
    assert_int_equal(
        pbnds_weights_save(path, pbnds_model_find("pbnds+"), p, NULL, 0, NULL),
        PBNDS_OK);
    struct pbnds_safetensors file;
    const struct pbnds_model *found;
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_weights_open(path, &file, &found, NULL), PBNDS_OK);
    assert_int_equal(pbnds_weights_apply(path, &file, p, &error), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "not finite"));
    pbnds_safetensors_free(&file);
    (void)unlink(path);
    pbnds_net_free(p);
}

static void foreign_files_are_refused(void **state)
{
    (void)state;
    const char *path = "test_model_foreign.safetensors";
    const float one = 1.0f;
    struct pbnds_safetensor tensor = {
        .name = "x", .shape = {1}, .rank = 1, .count = 1, .data = &one};
    struct pbnds_safetensors file = {.tensors = &tensor, .tensor_count = 1};
    assert_int_equal(pbnds_safetensors_write(path, &file, NULL), PBNDS_OK);
    const struct pbnds_model *found;
    struct pbnds_error error = {{0}};
    assert_int_equal(pbnds_weights_open(path, &file, &found, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "not a weights file"));

    char k0[] = "pbnds.model", v0[] = "transport", k1[] = "pbnds.version", v1[] = "99";
    struct pbnds_metadata metadata[2] = {{k0, v0}, {k1, v1}};
    file = (struct pbnds_safetensors){.tensors = &tensor,
                                      .tensor_count = 1,
                                      .metadata = metadata,
                                      .metadata_count = 2};
    assert_int_equal(pbnds_safetensors_write(path, &file, NULL), PBNDS_OK);
    assert_int_equal(pbnds_weights_open(path, &file, &found, &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "version 99"));
    (void)unlink(path);
}

int main(void)
{
    if (pbnds_backend_create_onednn(&backend, NULL) != PBNDS_OK) return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parameter_counts_are_known),
        cmocka_unit_test(weights_survive_the_file),
        cmocka_unit_test(weights_of_another_model_are_refused),
        cmocka_unit_test(not_finite_is_refused),
        cmocka_unit_test(foreign_files_are_refused),
    };
    const int failed =
        cmocka_run_group_tests_name("neural/model/model", tests, NULL, NULL);
    pbnds_backend_free(backend);
    return failed;
}
