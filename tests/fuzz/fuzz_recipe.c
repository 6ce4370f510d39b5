/* libFuzzer target: any bytes as a recipe file; what is taken describes itself. */
#include <stdlib.h>
#include <string.h>

#include "neural/data/recipe.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pbnds_dataset_recipe recipe, again;
    struct pbnds_error error;
    if (pbnds_dataset_recipe_parse((const char *)data, size, "input", "root", &recipe,
                                   &error) != PBNDS_OK)
        return 0;
    cJSON *json = cJSON_CreateObject();
    pbnds_dataset_recipe_describe(&recipe, json);
    char *text = cJSON_PrintUnformatted(json);
    if (!text || pbnds_dataset_recipe_parse(text, strlen(text), "again", "", &again,
                                            &error) != PBNDS_OK)
        abort();
    if (again.seed != recipe.seed || again.spp != recipe.spp) abort();
    cJSON_free(text);
    cJSON_Delete(json);
    pbnds_dataset_recipe_free(&again);
    pbnds_dataset_recipe_free(&recipe);
    return 0;
}
