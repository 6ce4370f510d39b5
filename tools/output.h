/**
 * @file output.h
 * Results on disk and on stdout.
 */
#ifndef PBNDS_TOOLS_OUTPUT_H
#define PBNDS_TOOLS_OUTPUT_H

#include <stdio.h>

#include "tools/world.h"

/** Can this file be written? Asked before minutes are spent on what goes into it. */
enum pbnds_status tool_output_check(const char *path,
                                    struct pbnds_error *error) PBNDS_NODISCARD;
/** The same for a picture, which must end in .exr or .png. */
enum pbnds_status tool_picture_check(const char *path,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Makes the folder and checks that files can be made in it. */
enum pbnds_status tool_folder_check(const char *folder,
                                    struct pbnds_error *error) PBNDS_NODISCARD;

/** What was shaded becomes what is seen: c radiance + (1 - c) L, with c the shader's own
 *  coverage where `alpha` is not empty (shader.h), else the G-buffer's, and L the light map
 *  as the camera sees it through the pixel's centre, or black. */
void tool_background(const struct tool_world *world, bool light_map,
                     const struct pbnds_image *alpha, struct pbnds_image *radiance);
/** .exr: linear radiance, with A = alpha where that is not empty, the AOVs, and variance.R,
 *  .G, .B where that is not empty; .png: the tone-mapped preview. alpha and variance may
 *  be NULL. */
enum pbnds_status tool_picture_write(const char *path, const struct tool_world *world,
                                     const struct pbnds_image *radiance,
                                     const struct pbnds_image *alpha,
                                     const struct pbnds_image *variance,
                                     const struct pbnds_display *display,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** A new display-encoded image. */
enum pbnds_status tool_displayed(const struct pbnds_image *radiance,
                                 const struct pbnds_display *display,
                                 struct pbnds_image *shown,
                                 struct pbnds_error *error) PBNDS_NODISCARD;

/** JSON pieces: a quoted string; a number, null where it is not finite. */
void tool_json_string(FILE *file, const char *text);
/** One line on stdout for --json: an object of what was made and its facts; `count` pairs of
 *  (const char *key, double value) follow. */
void tool_json_result(const char *output, int count, ...);
void tool_json_number(FILE *file, double value);

/** Text that goes to a file at once (atomically) when it is complete. */
struct tool_text {
    FILE *file; /**< write here */
    char *data;
    size_t size;
};
enum pbnds_status tool_text_begin(struct tool_text *text,
                                  struct pbnds_error *error) PBNDS_NODISCARD;
/** path "-" is stdout. The text is freed in any case. */
enum pbnds_status tool_text_end(struct tool_text *text, const char *path,
                                struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_OUTPUT_H */
