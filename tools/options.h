/**
 * @file options.h
 * The command line: one table of options serves parsing, range checks and --help.
 */
#ifndef PBNDS_TOOLS_OPTIONS_H
#define PBNDS_TOOLS_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"
#include "engine/image/tonemap.h"
#include "engine/scene/envmap.h"

/** One bit a subcommand: which rows of the table it takes. */
enum tool_mask {
    TOOL_RENDER = 1u << 0,
    TOOL_GBUFFER = 1u << 1,
    TOOL_SHADE = 1u << 2,
    TOOL_COMPARE = 1u << 3,
    TOOL_DATASET = 1u << 4,
    TOOL_TRAIN = 1u << 5,
    TOOL_INFO = 1u << 6,
    TOOL_CHECK = 1u << 7,
    TOOL_BENCH = 1u << 8,
    TOOL_IMPORT = 1u << 9,
    TOOL_EXPORT = 1u << 10,
};

enum tool_precision { TOOL_PRECISION_AUTO, TOOL_PRECISION_FP32, TOOL_PRECISION_BF16 };

enum { TOOL_MAX_ENVS = 64 };

/** What was typed; numbers are in range, strings point into argv. Grouped as --help is.
 */
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding)
struct tool_options {
    const char *const *inputs;
    int input_count;
    char arguments[400]; /**< the command line, for file headers */
    bool help, version;

    const char *output, *preview, *json_file;
    bool json;

    const char *camera;
    double look[2]; /**< yaw, pitch, degrees */
    bool look_given;
    double fov;  /**< 0: not given */
    double time; /**< seconds; < 0: not given, the pose of the nodes */

    const char *scene, *variant, *animation; /**< of the file, by name or index */
    bool allow_external, backfaces, no_mips;
    int max_geometry_mb, max_images_mb, max_image_side, max_file_mb; /**< 0: default */

    const char *env;
    double env_yaw, env_strength;
    int env_convention; /**< enum pbnds_env_convention */
    bool no_scene_lights;

    const char *shader, *shaders, *against;
    const char *cache; /**< NULL: not given */
    int size[2];       /**< 0, 0: not given */
    int spp, reference_spp, lights;
    double noise;     /**< 0: not given */
    int aov_samples;  /**< 0: not given, one ray through each pixel centre */
    int aov_through;  /**< enum pbnds_through */
    int normal_space; /**< enum pbnds_normal_space */
    int depth;        /**< enum pbnds_depth_kind */
    bool aovs;        /**< all optional channels */
    bool cryptomatte;
    double motion;  /**< seconds back in time, 0: no motion vectors */
    int shadows;    /**< -1: not given */
    int precision;  /**< enum tool_precision */
    int background; /**< 0 none, 1 the light map */

    const char *envs[TOOL_MAX_ENVS];
    int env_count;
    int count;
    int shard[2]; /**< index, count */
    int split;    /**< enum pbnds_split, or -1 */
    const char *recipe, *root;
    int worlds, skies;
    double randomize_materials, swap_textures, mix_lights, hard_lights;
    bool variance, ao, denoise;
    int olat, olat_spp;
    int format, per_tar; /**< enum pbnds_dataset_format; 0: not given */
    bool dry_run, retry;

    const char *model, *init;
    int steps, batch, crop, accumulate;
    double lr, minutes, p_dark, lambda_zero; /**< p_dark, lambda_zero: -1 not given */
    double weight_decay, ema;
    int augment; /**< 0 or 1 */
    int checkpoint_every, sheet_every;
    bool resume;
    bool onnx;

    int threads;
    uint64_t seed;
    double exposure;
    int tonemap; /**< enum pbnds_tonemap */
    int max_memory_mb;
    bool quiet;
};

/** One subcommand, one file. */
struct tool_command {
    const char *name;
    unsigned mask;
    int min_inputs, max_inputs; /**< max -1: any number */
    bool needs_output;
    const char *usage;   /**< after "pbnds " */
    const char *about;   /**< one line */
    const char *details; /**< paragraphs and examples for --help */
    enum pbnds_status (*run)(const struct tool_options *options,
                             struct pbnds_error *error);
};

/** Parses argv[1..] of a subcommand (argv[0] is its name). The sentence of a failure
 * says which option, what was typed and what is wanted. */
enum pbnds_status tool_options_parse(const struct tool_command *command, int argc,
                                     char **argv, struct tool_options *options,
                                     struct pbnds_error *error) PBNDS_NODISCARD;
/** Prints the help of a subcommand on stdout. */
void tool_options_help(const struct tool_command *command);
/** Words on stdout, wrapped at 80 columns; lines after the first are indented. The
 * cursor is at column `indent` already. */
void tool_print_wrapped(const char *text, int indent);
/** "a,b,c" to at most max pieces; each must be non-empty and differ from the others.
 *  `storage` is the one allocation behind the pieces, the caller's to free. */
enum pbnds_status tool_split_list(const char *option, const char *list,
                                  const char **pieces, int max, int *count,
                                  char **storage,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

struct pbnds_display tool_display(const struct tool_options *options);

#endif /* PBNDS_TOOLS_OPTIONS_H */
