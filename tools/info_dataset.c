/* What pbnds info says of a data set: what it was made of, what is in it, and a contact
 * sheet of it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/color.h"
#include "engine/core/file.h"
#include "engine/image/oiio.h"
#include "engine/image/sheet.h"
#include "neural/data/dataset.h"
#include "tools/console.h"
#include "tools/facts.h"
#include "tools/output.h"

enum {
    LOOKED_AT = 200, /* samples a split that are opened for statistics */
    TAKEN = 400,     /* pixels of each */
    CELLS = 64,
    COLUMNS = 8,
    CELL_SIDE = 144
};

/* What is measured of every pixel taken, or of every sample. */
enum quantity {
    RADIANCE,
    ALBEDO,
    ROUGHNESS,
    METALLIC,
    SPECULAR,
    COVERAGE,
    LIGHT_MEAN,
    LIGHT_PEAK,
    QUANTITY_COUNT
};

static const char *const QUANTITY_NAMES[] = {
    "radiance", "albedo",   "roughness", "metallic",
    "specular", "coverage", "light",     "light peak over mean"};

struct statistics {
    float *values[QUANTITY_COUNT]; /* room for LOOKED_AT * TAKEN each */
    size_t count[QUANTITY_COUNT];
};

static void add(struct statistics *s, enum quantity q, float value)
{
    s->values[q][s->count[q]++] = value;
}

static bool statistics_open(struct statistics *s)
{
    *s = (struct statistics){0};
    bool ok = true;
    for (int q = 0; q < QUANTITY_COUNT; ++q) {
        s->values[q] = malloc(sizeof(float) * LOOKED_AT * TAKEN);
        ok = ok && s->values[q];
    }
    return ok;
}

static void statistics_close(struct statistics *s)
{
    for (int q = 0; q < QUANTITY_COUNT; ++q)
        free(s->values[q]);
}

static float luminance_at(const float *const planes[3], size_t i)
{
    return pbnds_luminance(pbnds_vec3_make(planes[0][i], planes[1][i], planes[2][i]));
}

static float peak_of(const struct pbnds_envmap *envmap)
{
    struct pbnds_image map;
    float peak = 0.0f;
    if (pbnds_envmap_bake(envmap, PBNDS_DATASET_LIGHT_WIDTH,
                          PBNDS_DATASET_LIGHT_WIDTH / 2, &map, NULL) != PBNDS_OK)
        return 0.0f;
    for (size_t i = 0; i < (size_t)map.width * (size_t)map.height; ++i) {
        const float *p = &map.data[3 * i];
        peak = fmaxf(peak, pbnds_luminance(pbnds_vec3_make(p[0], p[1], p[2])));
    }
    pbnds_image_free(&map);
    return peak;
}

static void add_sample(struct statistics *s, const struct pbnds_sample *sample)
{
    const struct pbnds_gbuffer *g = &sample->gbuffer;
    const size_t count = (size_t)g->width * (size_t)g->height;
    const float *const albedo[3] = {g->albedo[0], g->albedo[1], g->albedo[2]};
    double covered = 0.0;
    for (size_t i = 0; i < count; ++i)
        covered += (double)g->coverage[i];
    add(s, COVERAGE, (float)(covered / (double)count));
    const float mean = pbnds_luminance(pbnds_envmap_mean(sample->envmap));
    add(s, LIGHT_MEAN, mean);
    add(s, LIGHT_PEAK, peak_of(sample->envmap) / fmaxf(mean, 1e-20f));
    /* A stride that is prime to most widths spreads over the picture. */
    const size_t stride = count / TAKEN + 1;
    for (size_t i = stride / 2; i < count; i += stride) {
        if (!isfinite(g->depth[i])) continue;
        add(s, RADIANCE,
            pbnds_luminance(pbnds_vec3_make(sample->radiance.data[3 * i],
                                            sample->radiance.data[3 * i + 1],
                                            sample->radiance.data[3 * i + 2])));
        add(s, ALBEDO, luminance_at(albedo, i));
        add(s, ROUGHNESS, g->roughness[i]);
        add(s, METALLIC, g->metallic[i]);
        add(s, SPECULAR, g->specular[i]);
    }
}

static int by_value(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* "albedo": {"mean": .., "p1": .., "p10": .., ...} */
static void add_quantiles(cJSON *facts, const char *name, float *values, size_t count)
{
    static const int PERCENT[] = {1, 10, 50, 90, 99};
    if (count == 0) return;
    double sum = 0.0;
    for (size_t i = 0; i < count; ++i)
        sum += (double)values[i];
    qsort(values, count, sizeof *values, by_value);
    cJSON *row = cJSON_AddArrayToObject(facts, name);
    (void)cJSON_AddItemToArray(row, cJSON_CreateNumber(sum / (double)count));
    for (size_t p = 0; p < sizeof PERCENT / sizeof PERCENT[0]; ++p) {
        const size_t at = (size_t)PERCENT[p] * (count - 1) / 100;
        (void)cJSON_AddItemToArray(row, cJSON_CreateNumber((double)values[at]));
    }
}

/* Statistics of a split, from samples spread over it. */
static enum pbnds_status describe_split(const struct pbnds_sample_list *list,
                                        cJSON *facts, struct pbnds_error *error)
{
    struct statistics s;
    enum pbnds_status status = statistics_open(&s)
                                   ? PBNDS_OK
                                   : pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory");
    const int looked = list->count < LOOKED_AT ? list->count : LOOKED_AT;
    for (int i = 0; i < looked && status == PBNDS_OK; ++i) {
        const int at = (int)((int64_t)i * list->count / looked);
        struct pbnds_sample sample;
        status = pbnds_sample_load(list->folders[at], 0, &sample, error);
        if (status == PBNDS_OK) {
            add_sample(&s, &sample);
            pbnds_sample_free(&sample);
            status = tool_check_stop(error);
        }
        pbnds_progress(tool_report(), "statistics", i + 1.0, looked);
    }
    if (status == PBNDS_OK) {
        tool_add_number(facts, "samples looked at", looked);
        tool_add_text(facts, "columns", "mean, percentiles 1, 10, 50, 90, 99");
        for (int q = 0; q < QUANTITY_COUNT; ++q)
            add_quantiles(facts, QUANTITY_NAMES[q], s.values[q], s.count[q]);
    }
    statistics_close(&s);
    return status;
}

/* The picture as people see it, at most CELL_SIDE wide: box-averaged in linear light. */
static enum pbnds_status make_cell(const char *path, const struct tool_options *options,
                                   struct pbnds_image *cell, struct pbnds_error *error)
{
    struct pbnds_sample sample;
    PBNDS_TRY(pbnds_sample_load(path, 0, &sample, error));
    const struct pbnds_image *from = &sample.radiance;
    const int step = (from->width + CELL_SIDE - 1) / CELL_SIDE;
    const int width = from->width / step, height = from->height / step;
    enum pbnds_status status = pbnds_image_init(cell, width, height, 3, error);
    for (int y = 0; y < height && status == PBNDS_OK; ++y) {
        for (int x = 0; x < width * 3; ++x) {
            float sum = 0.0f;
            for (int k = 0; k < step * step; ++k) {
                const int u = x / 3 * step + k % step, v = y * step + k / step;
                sum += from->data[3 * (v * from->width + u) + x % 3];
            }
            cell->data[3 * y * width + x] = sum / (float)(step * step);
        }
    }
    if (status == PBNDS_OK) {
        struct pbnds_display display = tool_display(options);
        if (sample.target == PBNDS_TARGET_DISPLAY) display.tonemap = PBNDS_TONEMAP_NONE;
        pbnds_display_image(&display, cell, cell);
    }
    pbnds_sample_free(&sample);
    return status;
}

/* "train 000123" of ".../train/000123" or ".../train-000001.tar#000123@5120" */
static void name_cell(const char *path, const char *split, char label[40])
{
    const char *end = strrchr(path, '#'), *slash = strrchr(path, '/');
    const char *name = end ? end + 1 : slash ? slash + 1 : path;
    (void)snprintf(label, 40, "%s %.*s", split, (int)strcspn(name, "@") % 24, name);
}

static enum pbnds_status write_sheet(const struct tool_options *options,
                                     const struct pbnds_sample_list *lists,
                                     struct pbnds_error *error)
{
    int total = 0, count = 0;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        total += lists[s].count;
    static char labels[CELLS][40];
    struct pbnds_image images[CELLS] = {{0}}, sheet = {0};
    struct pbnds_sheet_cell cells[CELLS];
    const int wanted = total < CELLS ? total : CELLS;
    enum pbnds_status status = PBNDS_OK;
    for (int i = 0; i < wanted && status == PBNDS_OK; ++i) {
        int at = (int)((int64_t)i * total / wanted), split = 0;
        while (at >= lists[split].count)
            at -= lists[split++].count;
        const char *path = lists[split].folders[at];
        status = make_cell(path, options, &images[i], error);
        name_cell(path, pbnds_split_name((enum pbnds_split)split), labels[i]);
        cells[count++] = (struct pbnds_sheet_cell){&images[i], labels[i]};
    }
    if (status == PBNDS_OK && count == 0) {
        status = pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: has no samples to show",
                            options->inputs[0]);
    }
    if (status == PBNDS_OK) {
        status = pbnds_sheet_make(cells, count, COLUMNS < count ? COLUMNS : count,
                                  &sheet, error);
    }
    if (status == PBNDS_OK) status = pbnds_png_write(options->output, &sheet, error);
    pbnds_image_free(&sheet);
    for (int i = 0; i < CELLS; ++i)
        pbnds_image_free(&images[i]);
    return status;
}

/* The assets of each split are counted for people; the file has their names. */
static void summarize_assets(cJSON *recipe, const char *key)
{
    cJSON *list = cJSON_DetachItemFromObjectCaseSensitive(recipe, key);
    if (!cJSON_IsArray(list)) {
        cJSON_Delete(list);
        return;
    }
    int count[PBNDS_SPLIT_COUNT] = {0};
    const cJSON *item;
    cJSON_ArrayForEach(item, list)
    {
        const char *split =
            cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "split"));
        for (int s = 0; split && s < PBNDS_SPLIT_COUNT; ++s)
            count[s] += strcmp(split, pbnds_split_name((enum pbnds_split)s)) == 0;
    }
    cJSON_Delete(list);
    cJSON *object = cJSON_AddObjectToObject(recipe, key);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        tool_add_number(object, pbnds_split_name((enum pbnds_split)s), count[s]);
}

static enum pbnds_status read_recipe(const char *path, bool summary, cJSON *facts,
                                     struct pbnds_error *error)
{
    char manifest[1400];
    (void)snprintf(manifest, sizeof manifest, "%s/dataset.json", path);
    uint8_t *text = NULL;
    size_t size = 0;
    PBNDS_TRY(pbnds_file_read(manifest, (size_t)64 << 20, &text, &size, error));
    cJSON *recipe = cJSON_Parse((const char *)text);
    free(text);
    if (!recipe) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not JSON", manifest);
    }
    if (summary) {
        summarize_assets(recipe, "assets");
        summarize_assets(recipe, "lights");
    }
    (void)cJSON_AddItemToObject(facts, "recipe", recipe);
    return PBNDS_OK;
}

static enum pbnds_status describe_lists(const struct tool_options *options, bool deep,
                                        const struct pbnds_sample_list *lists,
                                        cJSON *facts, struct pbnds_error *error)
{
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        tool_add_number(facts, pbnds_split_name((enum pbnds_split)s), lists[s].count);
    }
    char hash[17];
    PBNDS_TRY(pbnds_dataset_hash(options->inputs[0], hash, error));
    tool_add_text(facts, "hash", hash);
    PBNDS_TRY(read_recipe(options->inputs[0], !options->json, facts, error));
    if (!deep) return PBNDS_OK;
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s) {
        if (lists[s].count == 0) continue;
        char key[40];
        (void)snprintf(key, sizeof key, "%s statistics",
                       pbnds_split_name((enum pbnds_split)s));
        PBNDS_TRY(
            describe_split(&lists[s], cJSON_AddObjectToObject(facts, key), error));
    }
    return options->output ? write_sheet(options, lists, error) : PBNDS_OK;
}

enum pbnds_status tool_describe_dataset(const struct tool_options *options, bool deep,
                                        cJSON *facts, struct pbnds_error *error)
{
    struct pbnds_sample_list lists[PBNDS_SPLIT_COUNT] = {{0}};
    tool_add_text(facts, "kind", "data set");
    enum pbnds_status status = PBNDS_OK;
    for (int s = 0; s < PBNDS_SPLIT_COUNT && status == PBNDS_OK; ++s) {
        status = pbnds_dataset_list(options->inputs[0], (enum pbnds_split)s, &lists[s],
                                    error);
    }
    if (status == PBNDS_OK) status = describe_lists(options, deep, lists, facts, error);
    for (int s = 0; s < PBNDS_SPLIT_COUNT; ++s)
        pbnds_sample_list_free(&lists[s]);
    return status;
}
