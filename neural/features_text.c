#include "neural/features_text.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const VIEW_ABOUT[PBNDS_PLANE_COUNT] = {
    [PBNDS_PLANE_ALBEDO_R] = "base colour, red, linear Rec. 709",
    [PBNDS_PLANE_ALBEDO_G] = "base colour, green",
    [PBNDS_PLANE_ALBEDO_B] = "base colour, blue",
    [PBNDS_PLANE_NORMAL_X] =
        "unit shading normal, camera space (+x right, +y up, looks down -z)",
    [PBNDS_PLANE_NORMAL_Y] = "its y",
    [PBNDS_PLANE_NORMAL_Z] = "its z",
    [PBNDS_PLANE_WO_X] = "unit direction to the eye, camera space",
    [PBNDS_PLANE_WO_Y] = "its y",
    [PBNDS_PLANE_WO_Z] = "its z",
    [PBNDS_PLANE_SPECULAR] = "reflectance at normal incidence",
    [PBNDS_PLANE_ROUGHNESS] = "perceptual roughness, alpha is its square",
    [PBNDS_PLANE_METALLIC] = "metallic, 0 to 1",
    [PBNDS_PLANE_N_DOT_V] = "cosine between the normal and the eye",
    [PBNDS_PLANE_MASK] = "coverage, 0 to 1; where it is 0 so is every plane",
    [PBNDS_PLANE_LOG_DEPTH] = "ln(depth / median depth of the view)",
};

static const char *const LIGHT_ABOUT[PBNDS_LIGHT_PLANE_COUNT] = {
    [PBNDS_LIGHT_N_DOT_L] = "max(cosine between the normal and the light, 0)",
    [PBNDS_LIGHT_N_DOT_L_SIGNED] = "cosine between the normal and the light",
    [PBNDS_LIGHT_X] = "unit direction to the light, camera space",
    [PBNDS_LIGHT_Y] = "its y",
    [PBNDS_LIGHT_Z] = "its z",
    [PBNDS_LIGHT_MARCH_THIN] = "1: the depth buffer does not block the light, 0: it "
                               "does, surfaces taken as thin",
    [PBNDS_LIGHT_MARCH_THICK] = "the same, surfaces taken as thick",
    [PBNDS_LIGHT_HORIZON] = "the light's place against the horizon at its azimuth, 0 "
                            "to 1",
    [PBNDS_LIGHT_RADIANCE_R] = "radiance of the light times max(n.l, 0), red",
    [PBNDS_LIGHT_RADIANCE_G] = "the same, green",
    [PBNDS_LIGHT_RADIANCE_B] = "the same, blue",
};

/* Text that grows; `failed` without memory. */
struct text {
    char *data;
    size_t size;
    bool failed;
};

static void append(struct text *t, const char *format, ...) PBNDS_PRINTF(2, 3);

static void append(struct text *t, const char *format, ...)
{
    char part[512];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(part, sizeof part, format, arguments);
    va_end(arguments);
    if (t->failed || length < 0 || (size_t)length >= sizeof part) {
        t->failed = true;
        return;
    }
    char *data = realloc(t->data, t->size + (size_t)length + 1);
    if (!data) {
        t->failed = true;
        return;
    }
    memcpy(data + t->size, part, (size_t)length + 1);
    t->data = data;
    t->size += (size_t)length;
}

static void append_formula(struct text *t, const struct pbnds_feature *f)
{
    const bool log1p = f->transfer == PBNDS_TRANSFER_LOG1P;
    const bool shifted = f->offset != 0.0f, scaled = f->scale != 1.0f;
    append(t, "%s%s%s", log1p ? "log1p(max(" : "", shifted ? "(" : "", f->name);
    if (shifted) append(t, " - %.9g)", (double)f->offset);
    if (scaled) append(t, " * %.9g", (double)f->scale);
    append(t, "%s", log1p ? ", 0))" : "");
}

static void append_rows(struct text *t, const struct pbnds_feature *rows, int count)
{
    for (int i = 0; i < count; ++i) {
        append(t, "%s", i > 0 ? "; " : "");
        append_formula(t, &rows[i]);
    }
}

static void append_channels(struct text *t, const struct pbnds_feature *rows, int count,
                            int bands)
{
    for (int i = 0; i < count; ++i)
        append(t, "%s%s", i > 0 ? "; " : "", rows[i].name);
    for (int k = 0; k < 2 * bands; ++k) {
        for (int i = 0; i < count; ++i) {
            append(t, "; %s(%d %s)", k % 2 ? "cos" : "sin", 1 << (k / 2), rows[i].name);
        }
    }
}

static void append_encoding(struct text *t, int bands)
{
    if (bands == 0) {
        append(t, "none");
    } else {
        append(t,
               "x of all rows, then for k = 0 to %d sin(2^k x) of all rows, cos(2^k x) "
               "of all rows",
               bands - 1);
    }
}

static void append_about(struct text *t, const struct pbnds_feature_table *table)
{
    for (int i = 0; i < table->view_count; ++i) {
        const struct pbnds_feature *f = &table->view[i];
        const int azimuth = f->plane - PBNDS_PLANE_HORIZON;
        append(t, "%s%s: ", i > 0 ? "\n" : "", f->name);
        if (azimuth >= 0) {
            append(t,
                   "largest cosine between the normal and what stands around, %d "
                   "degrees from +x towards -y; 0: open",
                   azimuth * (360 / PBNDS_HORIZONS));
        } else {
            append(t, "%s", VIEW_ABOUT[f->plane]);
        }
    }
    for (int i = 0; i < table->light_count; ++i)
        append(t, "\n%s: %s", table->light[i].name, LIGHT_ABOUT[table->light[i].plane]);
}

const struct pbnds_feature_table *pbnds_features_of(const struct pbnds_model *model)
{
    if (strcmp(model->name, "transport") == 0) return &pbnds_features_transport;
    if (strcmp(model->name, "pbnds+") == 0) return &pbnds_features_pbnds_plus;
    return NULL;
}

enum pbnds_status pbnds_features_text(const struct pbnds_feature_table *table,
                                      struct pbnds_features_text *text,
                                      struct pbnds_error *error)
{
    struct text t[6] = {{0}};
    append_rows(&t[0], table->view, table->view_count);
    append_rows(&t[1], table->light, table->light_count);
    append_encoding(&t[2], table->bands);
    append_channels(&t[3], table->view, table->view_count, table->bands);
    append_channels(&t[4], table->light, table->light_count, table->bands);
    append_about(&t[5], table);
    *text = (struct pbnds_features_text){t[0].data, t[1].data, t[2].data,
                                         t[3].data, t[4].data, t[5].data};
    for (int i = 0; i < 6; ++i) {
        if (!t[i].failed && t[i].data) continue;
        pbnds_features_text_free(text);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "no memory for the names of the features");
    }
    return PBNDS_OK;
}

void pbnds_features_text_free(struct pbnds_features_text *text)
{
    free(text->view);
    free(text->light);
    free(text->encoding);
    free(text->view_channels);
    free(text->light_channels);
    free(text->about);
    *text = (struct pbnds_features_text){0};
}
