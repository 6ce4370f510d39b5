/* The networks' tables and their weights files. */
#include "tests/test.h"

#include <stdio.h>
#include <stdlib.h>
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
    struct pbnds_net *other = make("pbnds+");
    assert_int_equal(pbnds_weights_apply(path, &file, other, &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "not finite"));
    for (size_t i = 0; i < pbnds_net_param_count(other); ++i) /* as it was */
        assert_near(pbnds_net_params(other)[i], 0.0, 0.0);
    pbnds_net_free(other);
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

/* A file of one small tensor with the metadata of the model, one of them changed. */
static enum pbnds_status opened_with(const char *key, const char *value,
                                     struct pbnds_error *error)
{
    const char *path = "test_model_changed.safetensors";
    struct pbnds_net *t = make("transport");
    assert_int_equal(
        pbnds_weights_save(path, pbnds_model_find("transport"), t, NULL, 0, NULL),
        PBNDS_OK);
    pbnds_net_free(t);
    struct pbnds_safetensors file, again;
    assert_int_equal(pbnds_safetensors_read(path, &file, NULL), PBNDS_OK);
    bool found = false;
    for (int i = 0; i < file.metadata_count; ++i) {
        struct pbnds_metadata *m = &file.metadata[i];
        if (strcmp(m->key, key) != 0) continue;
        found = true;
        free(m->value);
        m->value = malloc(strlen(value) + 1);
        assert_non_null(m->value);
        memcpy(m->value, value, strlen(value) + 1);
    }
    assert_true(found);
    assert_int_equal(pbnds_safetensors_write(path, &file, NULL), PBNDS_OK);
    pbnds_safetensors_free(&file);
    const struct pbnds_model *model;
    const enum pbnds_status status = pbnds_weights_open(path, &again, &model, error);
    if (status == PBNDS_OK) {
        pbnds_safetensors_free(&again);
    } else {
        assert_null(model);
        assert_non_null(strstr(error->message, path));
    }
    (void)unlink(path);
    return status;
}

/* One sentence that names the file, its version and ours. */
static void other_versions_are_told_apart(void **state)
{
    (void)state;
    struct pbnds_error error = {{0}};
    assert_int_equal(opened_with("pbnds.features", "1", &error), PBNDS_OK);
    assert_int_equal(opened_with("pbnds.version", "99", &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "holds version 99"));
    assert_non_null(strstr(error.message, "this program has version 1"));
    assert_null(strchr(error.message, '\n'));
    assert_int_equal(opened_with("pbnds.features", "7", &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "version 7 of the features"));
    assert_non_null(strstr(error.message, "this program has version 1"));
    assert_int_equal(opened_with("pbnds.light_mode", "uniform", &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "'uniform'"));
    assert_int_equal(opened_with("pbnds.architecture",
                                 "43 layers, 405796 parameters, xxh64 0123456789abcdef",
                                 &error),
                     PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(error.message, "another network"));
    assert_int_equal(opened_with("pbnds.architecture", "a U-Net", &error),
                     PBNDS_ERROR_FORMAT);
    assert_int_equal(opened_with("pbnds.model", "vit", &error),
                     PBNDS_ERROR_UNSUPPORTED);
    char many[300];
    memset(many, 'x', sizeof many - 1);
    many[sizeof many - 1] = 0; /* a sentence stays one */
    assert_int_equal(opened_with("pbnds.version", many, &error),
                     PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "this program has version 1"));
}

/* A table that changes without a new version would load old weights into a network that
 * they are not for: change the version with the hash. */
static void architectures_belong_to_versions(void **state)
{
    (void)state;
    static const struct {
        const char *model;
        int version;
        const char *architecture;
    } known[] = {
        {"transport", 1, "42 layers, 405796 parameters, xxh64 0adbad2149f13c9a"},
        {"pbnds+", 2, "40 layers, 493139 parameters, xxh64 40dcc8d5bc23a467"},
    };
    const char *path = "test_model_architecture.safetensors";
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        const struct pbnds_model *model = pbnds_model_find(known[i].model), *found;
        struct pbnds_net *net = make(known[i].model);
        struct pbnds_safetensors file;
        assert_int_equal(pbnds_weights_save(path, model, net, NULL, 0, NULL), PBNDS_OK);
        assert_int_equal(pbnds_weights_open(path, &file, &found, NULL), PBNDS_OK);
        assert_int_equal(model->version, known[i].version);
        assert_string_equal(pbnds_safetensors_metadata(&file, "pbnds.architecture"),
                            known[i].architecture);
        pbnds_safetensors_free(&file);
        pbnds_net_free(net);
    }
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
        cmocka_unit_test(other_versions_are_told_apart),
        cmocka_unit_test(architectures_belong_to_versions),
    };
    const int failed =
        cmocka_run_group_tests_name("neural/model/model", tests, NULL, NULL);
    pbnds_backend_free(backend);
    return failed;
}
