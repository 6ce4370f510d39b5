/**
 * @file facts.h
 * What `pbnds info` says is gathered as one JSON object; the text form is a walk over it.
 * Without memory a fact is left out: cJSON bears NULL everywhere.
 */
#ifndef PBNDS_TOOLS_FACTS_H
#define PBNDS_TOOLS_FACTS_H

#include <cjson/cJSON.h>

#include "engine/core/error.h"
#include "engine/core/vec.h"
#include "tools/options.h"

void tool_add_number(cJSON *facts, const char *key, double value);
void tool_add_text(cJSON *facts, const char *key, const char *value);
void tool_add_float(cJSON *facts, const char *key, float value);
void tool_add_floats(cJSON *facts, const char *key, const float *values, int count);
void tool_add_vec3(cJSON *facts, const char *key, struct pbnds_vec3 v);
/** "size": [width, height] */
void tool_add_size(cJSON *facts, int width, int height);
/** A new object in an array. */
cJSON *tool_add_item(cJSON *array);

/** The facts of a glTF file (info_scene.c). */
enum pbnds_status tool_describe_scene(const struct tool_options *options,
                                      const char *path, cJSON *facts,
                                      struct pbnds_error *error) PBNDS_NODISCARD;

/** The facts of a data set; `deep`: statistics of its pixels too, and the contact sheet
 *  where there is a name for it (info_dataset.c). */
enum pbnds_status tool_describe_dataset(const struct tool_options *options, bool deep,
                                        cJSON *facts,
                                        struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_FACTS_H */
