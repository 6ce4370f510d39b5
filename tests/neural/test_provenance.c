/* neural/features_text.c, neural/provenance.c: what a weights file tells of itself. */
#include "tests/test.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "neural/features_text.h"
#include "neural/provenance.h"

static int pieces(const char *text)
{
    int count = 1;
    for (const char *at = text; (at = strstr(at, "; ")); ++at)
        ++count;
    return count;
}

static void formulas_say_the_normalisation(void **state)
{
    (void)state;
    const struct pbnds_feature view[] = {
        {"albedo.R", PBNDS_PLANE_ALBEDO_R, 1.0f, 0.0f, PBNDS_TRANSFER_LINEAR},
        {"depth", PBNDS_PLANE_LOG_DEPTH, 0.5f, 0.25f, PBNDS_TRANSFER_LINEAR},
        {"horizon2", PBNDS_PLANE_HORIZON + 2, 2.0f, 0.0f, PBNDS_TRANSFER_LINEAR},
    };
    const struct pbnds_feature light[] = {
        {"L.R", PBNDS_LIGHT_RADIANCE_R, 1.0f, 0.0f, PBNDS_TRANSFER_LOG1P},
        {"L.G", PBNDS_LIGHT_RADIANCE_G, 3.0f, -1.0f, PBNDS_TRANSFER_LOG1P},
    };
    const struct pbnds_feature_table table = {view, 3, light, 2, 2};
    struct pbnds_features_text text;
    assert_int_equal(pbnds_features_text(&table, &text, NULL), PBNDS_OK);
    assert_string_equal(text.view, "albedo.R; (depth - 0.25) * 0.5; horizon2 * 2");
    assert_string_equal(text.light,
                        "log1p(max(L.R, 0)); log1p(max((L.G - -1) * 3, 0))");
    assert_string_equal(text.light_channels,
                        "L.R; L.G; sin(1 L.R); sin(1 L.G); cos(1 L.R); cos(1 L.G); "
                        "sin(2 L.R); sin(2 L.G); cos(2 L.R); cos(2 L.G)");
    assert_non_null(strstr(text.encoding, "k = 0 to 1 sin(2^k x)"));
    assert_non_null(strstr(text.about, "albedo.R: base colour"));
    assert_non_null(strstr(text.about, "horizon2: largest cosine"));
    assert_non_null(strstr(text.about, " 90 degrees"));
    assert_non_null(strstr(text.about, "\nL.G: the same, green"));
    pbnds_features_text_free(&text);
    assert_null(text.view);
}

/* As many names as the network has channels, none of them in need of a separator. A table
 * that changes wants a new version in its model, here and in its rows. */
static void every_model_is_described(void **state)
{
    (void)state;
    static const struct {
        const char *model;
        int features;
        const char *light;
    } known[] = {
        {"transport", 1,
         "n.l; n.l signed; l.x; l.y; l.z; march thin; march thick; horizon"},
        {"pbnds+", 2,
         "log1p(max(L.R n.l, 0)); log1p(max(L.G n.l, 0)); log1p(max(L.B n.l, 0))"},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        const struct pbnds_model *model = pbnds_model_find(known[i].model);
        const struct pbnds_feature_table *table = pbnds_features_of(model);
        struct pbnds_features_text text;
        assert_non_null(table);
        assert_int_equal(pbnds_features_text(table, &text, NULL), PBNDS_OK);
        assert_int_equal(model->features, known[i].features);
        assert_string_equal(text.light, known[i].light);
        assert_int_equal(pieces(text.view), table->view_count);
        assert_int_equal(pieces(text.view_channels), model->view_channels);
        assert_int_equal(pieces(text.light_channels), model->light_channels);
        assert_null(strstr(text.about, "(null)"));
        pbnds_features_text_free(&text);
    }
}

static void assert_says(const struct pbnds_safetensors *file, const char *key,
                        const char *value)
{
    const char *text = pbnds_safetensors_metadata(file, key);
    if (!text) fail_msg("no %s", key);
    assert_string_equal(text, value);
}

static void trained_weights_say_where_they_come_from(void **state)
{
    (void)state;
    const char *path = "test_provenance.safetensors";
    const struct pbnds_model *model = pbnds_model_find("transport"), *found;
    struct pbnds_backend *backend;
    struct pbnds_net *net;
    assert_int_equal(pbnds_backend_create_onednn(&backend, NULL), PBNDS_OK);
    assert_int_equal(pbnds_net_create(&model->table, backend, PBNDS_F32, &net, NULL),
                     PBNDS_OK);
    const struct pbnds_provenance p = {.model = model,
                                       .lights = 32,
                                       .data = "c90f3d1270937855",
                                       .recipe = "model transport v1, \"quoted\"",
                                       .step = 2400,
                                       .steps = 8000,
                                       .seed = UINT64_MAX,
                                       .dtype = PBNDS_BF16,
                                       .validation_psnr = 25.2346};
    assert_int_equal(pbnds_weights_save_trained(path, net, &p, NULL), PBNDS_OK);
    struct pbnds_safetensors file;
    assert_int_equal(pbnds_weights_open(path, &file, &found, NULL), PBNDS_OK);
    assert_ptr_equal(found, model);
    assert_says(&file, "pbnds.model", "transport");
    assert_says(&file, "pbnds.light_mode", "clusters");
    assert_says(&file, "pbnds.lights", "32");
    assert_says(&file, "pbnds.features.encoding", "none");
    assert_says(&file, "pbnds.program", PBNDS_VERSION);
    assert_says(&file, "train.data", p.data);
    assert_says(&file, "train.recipe", p.recipe);
    assert_says(&file, "train.step", "2400");
    assert_says(&file, "train.steps", "8000");
    assert_says(&file, "train.seed", "18446744073709551615");
    assert_says(&file, "train.dtype", "bf16");
    assert_says(&file, "train.validation_psnr_srgb", "25.235");
    pbnds_safetensors_free(&file);
    (void)unlink(path);
    pbnds_net_free(net);
    pbnds_backend_free(backend);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(formulas_say_the_normalisation),
        cmocka_unit_test(every_model_is_described),
        cmocka_unit_test(trained_weights_say_where_they_come_from),
    };
    return cmocka_run_group_tests_name("neural/provenance", tests, NULL, NULL);
}
