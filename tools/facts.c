#include "tools/facts.h"

#include <stdio.h>
#include <stdlib.h>

void tool_add_number(cJSON *facts, const char *key, double value)
{
    (void)cJSON_AddNumberToObject(facts, key, value);
}

void tool_add_text(cJSON *facts, const char *key, const char *value)
{
    (void)cJSON_AddStringToObject(facts, key, value);
}

/** Nine digits say a float exactly, more would be noise. */
static double short_of(float value)
{
    char text[32];
    (void)snprintf(text, sizeof text, "%.9g", (double)value);
    return strtod(text, NULL);
}

void tool_add_float(cJSON *facts, const char *key, float value)
{
    tool_add_number(facts, key, short_of(value));
}

void tool_add_floats(cJSON *facts, const char *key, const float *values, int count)
{
    cJSON *array = cJSON_AddArrayToObject(facts, key);
    for (int i = 0; array && i < count; ++i) {
        (void)cJSON_AddItemToArray(array, cJSON_CreateNumber(short_of(values[i])));
    }
}

void tool_add_vec3(cJSON *facts, const char *key, struct pbnds_vec3 v)
{
    const float values[3] = {v.x, v.y, v.z};
    tool_add_floats(facts, key, values, 3);
}

void tool_add_size(cJSON *facts, int width, int height)
{
    const float values[2] = {(float)width, (float)height};
    tool_add_floats(facts, "size", values, 2);
}

cJSON *tool_add_item(cJSON *array)
{
    cJSON *item = cJSON_CreateObject();
    (void)cJSON_AddItemToArray(array, item);
    return item;
}
