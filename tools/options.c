#include "tools/options.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "neural/data/dataset.h"

enum kind {
    KIND_FLAG,
    KIND_STRING,
    KIND_STRINGS, /* may be given several times: --envs */
    KIND_INT,
    KIND_DOUBLE,
    KIND_SEED,
    KIND_SIZE,    /* WxH into int[2] */
    KIND_SHARD,   /* I/N into int[2] */
    KIND_LOOK,    /* YAW,PITCH into double[2] */
    KIND_CHOICE,  /* one of `choices`; its place in the list into an int */
    KIND_TONEMAP, /* these two by their own tables */
    KIND_CONVENTION,
};

enum group { GROUP_CAMERA, GROUP_LIGHT, GROUP_SHADE, GROUP_JOB, GROUP_OUT, GROUP_ANY };

static const char *const group_names[] = {"Camera", "Light",  "Shading",
                                          "Job",    "Output", "Everywhere"};

struct row {
    const char *name;
    enum kind kind;
    size_t offset;
    double min, max;
    unsigned mask;
    enum group group;
    const char *metavar, *help;
    const char *choices; /* "off|on" */
};

#define AT(member) offsetof(struct tool_options, member)
#define EVERY      (~0u)
#define CASTS      (TOOL_RENDER | TOOL_GBUFFER | TOOL_COMPARE)
#define READS      (CASTS | TOOL_INFO | TOOL_CHECK)
#define LIT        (TOOL_RENDER | TOOL_SHADE | TOOL_COMPARE)
#define SHADES     (TOOL_RENDER | TOOL_SHADE)
#define MAKES      (CASTS | TOOL_SHADE | TOOL_DATASET | TOOL_TRAIN | TOOL_IMPORT)

/* The command line, row by row, in the order of --help. */
static const struct row rows[] = {
    {"camera", KIND_STRING, AT(camera), 0, 0, CASTS, GROUP_CAMERA, "NAME|INDEX",
     "a camera of the file, by its name or its number from 0 (default: the first)",
     NULL},
    {"look", KIND_LOOK, AT(look), -360, 360, CASTS | TOOL_IMPORT, GROUP_CAMERA,
     "YAW,PITCH",
     "frame the whole scene from this side, degrees; 0,0 looks along -z "
     "(default 30,20 where the file has no camera)",
     NULL},
    {"fov", KIND_DOUBLE, AT(fov), 1, 170, CASTS | TOOL_IMPORT, GROUP_CAMERA, "DEG",
     "vertical field of view (default: the file's, or 40)", NULL},
    {"time", KIND_DOUBLE, AT(time), 0, 1e6, CASTS, GROUP_CAMERA, "SECONDS",
     "poses the animation (default: the pose of the nodes)", NULL},
    {"animation", KIND_STRING, AT(animation), 0, 0, CASTS, GROUP_CAMERA, "NAME|INDEX",
     "which animation --time poses (default: the first)", NULL},
    {"scene", KIND_STRING, AT(scene), 0, 0, READS, GROUP_CAMERA, "NAME|INDEX",
     "which scene of the file (default: the one that it names)", NULL},
    {"variant", KIND_STRING, AT(variant), 0, 0, READS, GROUP_CAMERA, "NAME|INDEX",
     "which variant of the materials (KHR_materials_variants; default: none)", NULL},
    {"backfaces", KIND_FLAG, AT(backfaces), 0, 0, CASTS, GROUP_CAMERA, NULL,
     "see one-sided surfaces from behind too (glTF hides them)", NULL},
    {"no-mips", KIND_FLAG, AT(no_mips), 0, 0, CASTS, GROUP_CAMERA, NULL,
     "read textures at their finest level, not averaged over the pixel", NULL},
    {"allow-external", KIND_FLAG, AT(allow_external), 0, 0, READS, GROUP_CAMERA, NULL,
     "let the scene open files outside of its folder", NULL},
    {"max-geometry", KIND_INT, AT(max_geometry_mb), 1, 1 << 24, READS, GROUP_CAMERA,
     "MB", "refuse a scene whose vertices and structure take more (default 8192)",
     NULL},
    {"max-images", KIND_INT, AT(max_images_mb), 1, 1 << 24, READS | TOOL_SHADE,
     GROUP_CAMERA, "MB",
     "refuse a scene whose decoded images take more, or a light map that does "
     "(default 8192, 4096)",
     NULL},
    {"max-image-side", KIND_INT, AT(max_image_side), 1, 1 << 20, READS | TOOL_SHADE,
     GROUP_CAMERA, "N", "refuse images of more pixels a side (default 16384)", NULL},
    {"max-file", KIND_INT, AT(max_file_mb), 1, 1 << 24, READS, GROUP_CAMERA, "MB",
     "refuse larger files (default 2048)", NULL},

    {"env", KIND_STRING, AT(env), 0, 0, LIT, GROUP_LIGHT, "FILE|none",
     "light map, .hdr or .exr, equirect (default: the sky that ships with the scenes)",
     NULL},
    {"env-yaw", KIND_DOUBLE, AT(env_yaw), -36000, 36000, LIT, GROUP_LIGHT, "DEG",
     "turns the light about +y", NULL},
    {"env-strength", KIND_DOUBLE, AT(env_strength), 0, 1e6, LIT, GROUP_LIGHT, "X",
     "multiplies the light", NULL},
    {"env-convention", KIND_CONVENTION, AT(env_convention), 0, 0, LIT, GROUP_LIGHT,
     "NAME", "which way the map's centre looks: gltf (default), openexr, falcor, pbnds",
     NULL},
    {"no-scene-lights", KIND_FLAG, AT(no_scene_lights), 0, 0, LIT, GROUP_LIGHT, NULL,
     "leave out the lights of the file (KHR_lights_punctual)", NULL},

    {"shader", KIND_STRING, AT(shader), 0, 0, SHADES, GROUP_SHADE, "NAME",
     "shading pass (default neural); the list is below", NULL},
    {"shaders", KIND_STRING, AT(shaders), 0, 0, TOOL_COMPARE, GROUP_SHADE, "A,B,C",
     "shading passes (default blinn-phong,ggx,pbnds+,neural); the list is below", NULL},
    {"against", KIND_STRING, AT(against), 0, 0, TOOL_COMPARE, GROUP_SHADE,
     "reference|IMAGE",
     "what to compare with: the path tracer, or a picture of that size", NULL},
    {"spp", KIND_INT, AT(spp), 1, 1 << 20, LIT | TOOL_DATASET, GROUP_SHADE, "N",
     "samples a pixel of stochastic passes (default: each pass's own; data sets 64)",
     NULL},
    {"noise", KIND_DOUBLE, AT(noise), 0, 1, LIT, GROUP_SHADE, "X",
     "reference: stop when the relative standard error of the picture is below X; "
     "--spp is then the most",
     NULL},
    {"reference-spp", KIND_INT, AT(reference_spp), 1, 1 << 20, TOOL_COMPARE,
     GROUP_SHADE, "N", "samples a pixel of the reference alone (default: --spp)", NULL},
    {"lights", KIND_INT, AT(lights), 1, 1 << 16, LIT | TOOL_TRAIN, GROUP_SHADE, "N",
     "light directions of passes that use a set (default: each pass's own)", NULL},
    {"shadows", KIND_CHOICE, AT(shadows), 0, 0, TOOL_RENDER | TOOL_COMPARE, GROUP_SHADE,
     "on|off", "ray-traced visibility (default: each pass's own)", "off|on"},
    {"precision", KIND_CHOICE, AT(precision), 0, 0, LIT | TOOL_TRAIN, GROUP_SHADE,
     "fp32|bf16|auto", "of the networks; auto: bf16 where this machine is faster at it",
     "auto|fp32|bf16"},
    {"background", KIND_CHOICE, AT(background), 0, 0,
     TOOL_RENDER | TOOL_SHADE | TOOL_COMPARE, GROUP_SHADE, "env|none",
     "what is seen beside the scene (default: the light map)", "none|env"},

    {"envs", KIND_STRINGS, AT(envs), 0, 0, TOOL_DATASET, GROUP_JOB, "DIR",
     "light maps: a folder of .hdr and .exr, or one file; may be given several times",
     NULL},
    {"count", KIND_INT, AT(count), 1, 10000000, TOOL_DATASET, GROUP_JOB, "N",
     "samples in all", NULL},
    {"shard", KIND_SHARD, AT(shard), 0, 0, TOOL_DATASET, GROUP_JOB, "I/N",
     "make only the samples I, I + N, I + 2N ... (I from 0)", NULL},
    {"split", KIND_CHOICE, AT(split), 0, 0, TOOL_DATASET | TOOL_COMPARE, GROUP_JOB,
     "train|val|test",
     "make only that split; compare on a data set: use it (default test)",
     "train|val|test"},
    {"model", KIND_STRING, AT(model), 0, 0, TOOL_TRAIN, GROUP_JOB, "NAME",
     "pbnds+ or transport", NULL},
    {"init", KIND_STRING, AT(init), 0, 0, TOOL_TRAIN, GROUP_JOB, "FILE",
     "start from these weights (same model)", NULL},
    {"steps", KIND_INT, AT(steps), 1, 100000000, TOOL_TRAIN, GROUP_JOB, "N",
     "optimisation steps in all (default: the model's)", NULL},
    {"batch", KIND_INT, AT(batch), 1, 1024, TOOL_TRAIN, GROUP_JOB, "N",
     "views a step (default: the model's)", NULL},
    {"crop", KIND_INT, AT(crop), 16, 4096, TOOL_TRAIN, GROUP_JOB, "N",
     "side of the training crops, pixels, a multiple of 16 (default 128)", NULL},
    {"lr", KIND_DOUBLE, AT(lr), 1e-9, 1, TOOL_TRAIN, GROUP_JOB, "X",
     "peak learning rate (default: the model's)", NULL},
    {"minutes", KIND_DOUBLE, AT(minutes), 0.01, 1e6, TOOL_TRAIN, GROUP_JOB, "M",
     "stop at a checkpoint after this long; --resume goes on", NULL},
    {"p-dark", KIND_DOUBLE, AT(p_dark), 0, 1, TOOL_TRAIN, GROUP_JOB, "P",
     "pbnds+: how often a black light map is shown", NULL},
    {"lambda-zero", KIND_DOUBLE, AT(lambda_zero), 0, 1e6, TOOL_TRAIN, GROUP_JOB, "X",
     "pbnds+: weight of the loss under a black light map", NULL},
    {"resume", KIND_FLAG, AT(resume), 0, 0, TOOL_TRAIN, GROUP_JOB, NULL,
     "go on from the checkpoint beside the weights file", NULL},

    {"output", KIND_STRING, AT(output), 0, 0, MAKES, GROUP_OUT, "FILE|DIR",
     "-o, where the result goes", NULL},
    {"size", KIND_SIZE, AT(size), 1, 16384, CASTS | TOOL_DATASET | TOOL_BENCH,
     GROUP_OUT, "WxH", "pixels (default 512x512; data sets 256x256)", NULL},
    {"aov-samples", KIND_INT, AT(aov_samples), 1, 4096, CASTS, GROUP_OUT, "N",
     "rays a pixel of the G-buffer (default 1, through the pixel's centre)", NULL},
    {"aov-through", KIND_CHOICE, AT(aov_through), 0, 0, CASTS, GROUP_OUT, "first|alpha",
     "transparent surfaces: the first that is at least half opaque (default), or all "
     "weighed by alpha",
     "first|alpha"},
    {"normal-space", KIND_CHOICE, AT(normal_space), 0, 0, TOOL_RENDER | TOOL_GBUFFER,
     GROUP_OUT, "camera|world", "of the normals in the file (default camera)",
     "camera|world"},
    {"depth", KIND_CHOICE, AT(depth), 0, 0, TOOL_RENDER | TOOL_GBUFFER, GROUP_OUT,
     "planar|distance",
     "of Z in the file: along the view axis (default), or to the eye",
     "planar|distance"},
    {"aovs", KIND_FLAG, AT(aovs), 0, 0, TOOL_RENDER | TOOL_GBUFFER, GROUP_OUT, NULL,
     "write uv, ao and material_id too", NULL},
    {"cryptomatte", KIND_FLAG, AT(cryptomatte), 0, 0, TOOL_RENDER | TOOL_GBUFFER,
     GROUP_OUT, NULL, "write Cryptomatte of objects and materials", NULL},
    {"motion", KIND_DOUBLE, AT(motion), 0, 1e6, TOOL_RENDER | TOOL_GBUFFER, GROUP_OUT,
     "SECONDS", "write motion vectors since this long before --time", NULL},
    {"preview", KIND_STRING, AT(preview), 0, 0, SHADES, GROUP_OUT, "FILE.png",
     "writes the tone-mapped picture too", NULL},
    {"json", KIND_STRING, AT(json_file), 0, 0, TOOL_COMPARE, GROUP_OUT, "FILE",
     "writes the table as JSON ('-': on stdout in place of the table)", NULL},
    {"json", KIND_FLAG, AT(json), 0, 0, EVERY & ~(unsigned)TOOL_COMPARE, GROUP_ANY,
     NULL, "what is told on stdout, as one line of JSON", NULL},
    {"exposure", KIND_DOUBLE, AT(exposure), -64, 64, EVERY, GROUP_ANY, "EV",
     "of the display transform; EXR files stay scene-referred", NULL},
    {"tonemap", KIND_TONEMAP, AT(tonemap), 0, 0, EVERY, GROUP_ANY, "NAME",
     "pbr-neutral (default), none, reinhard", NULL},

    {"threads", KIND_INT, AT(threads), 1, 4096, EVERY, GROUP_ANY, "N",
     "default: one a core; the picture is the same at any number", NULL},
    {"seed", KIND_SEED, AT(seed), 0, 0, EVERY, GROUP_ANY, "S",
     "of every random choice (default 0)", NULL},
    {"max-memory", KIND_INT, AT(max_memory_mb), 16, 1 << 24, EVERY, GROUP_ANY, "MB",
     "working memory to stay within where possible", NULL},
    {"quiet", KIND_FLAG, AT(quiet), 0, 0, EVERY, GROUP_ANY, NULL,
     "no progress and no warnings; errors are always told", NULL},
    {"help", KIND_FLAG, AT(help), 0, 0, EVERY, GROUP_ANY, NULL, "this text", NULL},
    {"version", KIND_FLAG, AT(version), 0, 0, EVERY, GROUP_ANY, NULL, "the version",
     NULL},
};

enum { ROW_COUNT = sizeof rows / sizeof rows[0], FIRST_ID = 256 };

static bool read_double(const char *text, double *value, const char **end)
{
    /* strtod alone would take leading blanks, hexadecimal, "inf" and "nan". */
    if (!(*text == '-' || *text == '+' || *text == '.' ||
          (*text >= '0' && *text <= '9'))) {
        return false;
    }
    if (strpbrk(text, "xXnN")) return false;
    char *stop = NULL;
    errno = 0;
    *value = strtod(text, &stop);
    *end = stop;
    return stop != text && isfinite(*value);
}

static bool read_int(const char *text, long long *value, const char **end)
{
    if (!(*text == '-' || *text == '+' || (*text >= '0' && *text <= '9'))) return false;
    char *stop = NULL;
    errno = 0;
    *value = strtoll(text, &stop, 10);
    *end = stop;
    return stop != text && errno == 0;
}

static enum pbnds_status bad_value(const struct row *row, const char *text,
                                   const char *want, struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "--%s: '%s' is not %s", row->name,
                      text, want);
}

static enum pbnds_status set_number(const struct row *row, const char *text,
                                    void *target, struct pbnds_error *error)
{
    char want[96];
    const char *end = NULL;
    if (row->kind == KIND_INT) {
        long long value = 0;
        (void)snprintf(want, sizeof want, "a whole number from %.0f to %.0f", row->min,
                       row->max);
        if (!read_int(text, &value, &end) || *end || (double)value < row->min ||
            (double)value > row->max) {
            return bad_value(row, text, want, error);
        }
        *(int *)target = (int)value;
        return PBNDS_OK;
    }
    double value = 0.0;
    (void)snprintf(want, sizeof want, "a number from %g to %g", row->min, row->max);
    if (!read_double(text, &value, &end) || *end || value < row->min ||
        value > row->max) {
        return bad_value(row, text, want, error);
    }
    *(double *)target = value;
    return PBNDS_OK;
}

static enum pbnds_status set_seed(const struct row *row, const char *text,
                                  uint64_t *seed, struct pbnds_error *error)
{
    char *end = NULL;
    errno = 0;
    const unsigned long long value = strtoull(text, &end, 10);
    if (*text < '0' || *text > '9' || *end || errno) {
        return bad_value(row, text, "a whole number from 0 to 18446744073709551615",
                         error);
    }
    *seed = (uint64_t)value;
    return PBNDS_OK;
}

/* Two whole numbers with a separator: 640x480, 2/8. */
static bool read_pair(const char *text, char separator, long long pair[2])
{
    const char *end = NULL;
    return read_int(text, &pair[0], &end) && *end == separator &&
           read_int(end + 1, &pair[1], &end) && !*end;
}

static enum pbnds_status set_size(const struct row *row, const char *text, int size[2],
                                  struct pbnds_error *error)
{
    long long pair[2];
    if (!read_pair(text, 'x', pair) || (double)pair[0] < row->min ||
        (double)pair[0] > row->max || (double)pair[1] < row->min ||
        (double)pair[1] > row->max) {
        return bad_value(
            row, text, "WIDTHxHEIGHT with both from 1 to 16384, as in 640x480", error);
    }
    size[0] = (int)pair[0];
    size[1] = (int)pair[1];
    return PBNDS_OK;
}

static enum pbnds_status set_shard(const struct row *row, const char *text,
                                   int shard[2], struct pbnds_error *error)
{
    long long pair[2];
    if (!read_pair(text, '/', pair) || pair[1] < 1 || pair[1] > 1000000 ||
        pair[0] < 0 || pair[0] >= pair[1]) {
        return bad_value(row, text, "I/N with 0 <= I < N <= 1000000, as in 0/4", error);
    }
    shard[0] = (int)pair[0];
    shard[1] = (int)pair[1];
    return PBNDS_OK;
}

static enum pbnds_status set_look(const struct row *row, const char *text,
                                  double look[2], struct pbnds_error *error)
{
    const char *end = NULL;
    double yaw = 0.0, pitch = 0.0;
    if (!read_double(text, &yaw, &end) || *end != ',' ||
        !read_double(end + 1, &pitch, &end) || *end || fabs(yaw) > row->max ||
        fabs(pitch) > 90.0) {
        return bad_value(row, text,
                         "YAW,PITCH in degrees, within 360 and 90 of zero, as in 30,20",
                         error);
    }
    look[0] = yaw;
    look[1] = pitch;
    return PBNDS_OK;
}

static enum pbnds_status set_choice(const struct row *row, const char *text,
                                    int *target, struct pbnds_error *error)
{
    const size_t length = strlen(text);
    const char *at = row->choices;
    for (int i = 0; at; ++i) {
        const char *bar = strchr(at, '|');
        const size_t n = bar ? (size_t)(bar - at) : strlen(at);
        if (n == length && memcmp(at, text, n) == 0) {
            *target = i;
            return PBNDS_OK;
        }
        at = bar ? bar + 1 : NULL;
    }
    char want[96];
    (void)snprintf(want, sizeof want, "one of %s", row->metavar);
    return bad_value(row, text, want, error);
}

static enum pbnds_status set_name(const struct row *row, const char *text, int *target,
                                  struct pbnds_error *error)
{
    if (row->kind == KIND_TONEMAP) {
        enum pbnds_tonemap tonemap = PBNDS_TONEMAP_NONE;
        if (!pbnds_tonemap_parse(text, &tonemap)) {
            return bad_value(row, text, "one of pbr-neutral, none, reinhard", error);
        }
        *target = (int)tonemap;
        return PBNDS_OK;
    }
    enum pbnds_env_convention convention = PBNDS_ENV_GLTF;
    if (!pbnds_env_convention_parse(text, &convention)) {
        return bad_value(row, text, "one of gltf, openexr, falcor, pbnds", error);
    }
    *target = (int)convention;
    return PBNDS_OK;
}

static enum pbnds_status set_string(const struct row *row, const char *text,
                                    struct tool_options *options,
                                    struct pbnds_error *error)
{
    if (!*text) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "--%s: is empty", row->name);
    }
    if (row->kind == KIND_STRING) {
        *(const char **)(void *)((char *)options + row->offset) = text;
        return PBNDS_OK;
    }
    if (options->env_count == TOOL_MAX_ENVS) {
        return pbnds_fail(
            error, PBNDS_ERROR_ARGUMENT,
            "--%s: is given more than %d times; put the files in one folder", row->name,
            TOOL_MAX_ENVS);
    }
    options->envs[options->env_count++] = text;
    return PBNDS_OK;
}

static enum pbnds_status set_row(const struct row *row, const char *text,
                                 struct tool_options *options,
                                 struct pbnds_error *error)
{
    void *target = (char *)options + row->offset;
    switch (row->kind) {
    case KIND_FLAG:
        *(bool *)target = true;
        return PBNDS_OK;
    case KIND_STRING:
    case KIND_STRINGS:
        return set_string(row, text, options, error);
    case KIND_INT:
    case KIND_DOUBLE:
        return set_number(row, text, target, error);
    case KIND_SEED:
        return set_seed(row, text, target, error);
    case KIND_SIZE:
        return set_size(row, text, target, error);
    case KIND_SHARD:
        return set_shard(row, text, target, error);
    case KIND_LOOK:
        options->look_given = true;
        return set_look(row, text, target, error);
    case KIND_CHOICE:
        return set_choice(row, text, target, error);
    case KIND_TONEMAP:
    case KIND_CONVENTION:
        return set_name(row, text, target, error);
    }
    return PBNDS_OK;
}

static void set_defaults(struct tool_options *options, int argc, char **argv)
{
    *options = (struct tool_options){
        .look = {30.0, 20.0},
        .time = -1.0,
        .env_strength = 1.0,
        .shadows = -1,
        .background = 1,
        .shard = {0, 1},
        .split = -1,
        .p_dark = -1.0,
        .lambda_zero = -1.0,
        .tonemap = PBNDS_TONEMAP_PBR_NEUTRAL,
    };
    size_t used =
        (size_t)snprintf(options->arguments, sizeof options->arguments, "pbnds");
    for (int i = 0; i < argc && used < sizeof options->arguments; ++i) {
        used += (size_t)snprintf(options->arguments + used,
                                 sizeof options->arguments - used, " %s", argv[i]);
    }
}

static enum pbnds_status check_inputs(const struct tool_command *command,
                                      const struct tool_options *options,
                                      struct pbnds_error *error)
{
    if (options->input_count < command->min_inputs) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "usage: pbnds %s",
                          command->usage);
    }
    if (command->max_inputs >= 0 && options->input_count > command->max_inputs) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "'%s' is one argument too many; usage: pbnds %s",
                          options->inputs[command->max_inputs], command->usage);
    }
    if (command->needs_output && !options->output) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: -o is missing; usage: pbnds %s", command->name,
                          command->usage);
    }
    if (options->motion > 0.0 && options->time < 0.0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "--motion: there is no motion without an animation; give "
                          "--time SECONDS");
    }
    return PBNDS_OK;
}

enum pbnds_status tool_options_parse(const struct tool_command *command, int argc,
                                     char **argv, struct tool_options *options,
                                     struct pbnds_error *error)
{
    set_defaults(options, argc, argv);
    struct option table[ROW_COUNT + 1];
    int used = 0;
    for (int i = 0; i < ROW_COUNT; ++i) {
        if (!(rows[i].mask & command->mask)) continue;
        table[used++] = (struct option){
            rows[i].name, rows[i].kind == KIND_FLAG ? no_argument : required_argument,
            NULL, FIRST_ID + i};
    }
    table[used] = (struct option){NULL, 0, NULL, 0};
    opterr = 0;
    optind = 1;
    for (;;) {
        int id = getopt_long(argc, argv, ":o:h", table, NULL);
        if (id == -1) break;
        const char *typed = argv[optind - 1];
        if (id == ':') {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "%s: '%s' wants a value",
                              command->name, typed);
        }
        if (id == '?') {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "%s: '%s' is not an option of it; see pbnds %s --help",
                              command->name, typed, command->name);
        }
        for (int i = 0; i < ROW_COUNT && id < FIRST_ID; ++i) {
            const char *name = id == 'o' ? "output" : "help";
            if (strcmp(rows[i].name, name) == 0) id = FIRST_ID + i;
        }
        const struct row *row = &rows[id - FIRST_ID];
        if (!(row->mask & command->mask)) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "%s: '-o' is not an option of it; see pbnds %s --help",
                              command->name, command->name);
        }
        PBNDS_TRY(set_row(row, optarg, options, error));
    }
    options->inputs = (const char *const *)(argv + optind);
    options->input_count = argc - optind;
    if (options->help || options->version) return PBNDS_OK;
    return check_inputs(command, options, error);
}

void tool_print_wrapped(const char *text, int indent)
{
    int column = indent;
    const char *at = text;
    while (*at) {
        const int n = (int)strcspn(at, " ");
        if (column > indent && column + 1 + n > 79) {
            (void)printf("\n%*s", indent, "");
            column = indent;
        } else if (column > indent) {
            (void)printf(" ");
            ++column;
        }
        (void)printf("%.*s", n, at);
        column += n;
        at += n;
        while (*at == ' ')
            ++at;
    }
    (void)printf("\n");
}

void tool_options_help(const struct tool_command *command)
{
    (void)printf("usage: pbnds %s\n\n%s\n\n%s\n", command->usage, command->about,
                 command->details);
    for (int g = GROUP_CAMERA; g <= GROUP_ANY; ++g) {
        bool titled = false;
        for (int i = 0; i < ROW_COUNT; ++i) {
            if (rows[i].group != (enum group)g || !(rows[i].mask & command->mask))
                continue;
            if (!titled) (void)printf("\n%s\n", group_names[g]);
            titled = true;
            char left[64];
            (void)snprintf(left, sizeof left, "--%s %s", rows[i].name,
                           rows[i].metavar ? rows[i].metavar : "");
            (void)printf("  %-29s ", left);
            tool_print_wrapped(rows[i].help, 32);
        }
    }
    (void)printf("\nExit status: 0 done; 1 the run failed (I/O, memory, interrupted); "
                 "2 wrong usage;\n3 an input file is not valid; 4 valid but not "
                 "supported.\n");
}

enum pbnds_status tool_split_list(const char *option, const char *list,
                                  const char **pieces, int max, int *count,
                                  char **storage, struct pbnds_error *error)
{
    *count = 0;
    const size_t size = strlen(list) + 1;
    char *copy = malloc(size);
    *storage = copy;
    if (!copy)
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "no memory for --%s", option);
    memcpy(copy, list, size);
    for (char *at = copy; at;) {
        char *comma = strchr(at, ',');
        if (comma) *comma = 0;
        if (!*at) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "--%s: '%s' has an empty name in its list", option, list);
        }
        for (int i = 0; i < *count; ++i) {
            if (strcmp(pieces[i], at) == 0) {
                return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                                  "--%s: '%s' is in the list twice", option, at);
            }
        }
        if (*count == max) {
            return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                              "--%s: has more than %d names in its list", option, max);
        }
        pieces[(*count)++] = at;
        at = comma ? comma + 1 : NULL;
    }
    return PBNDS_OK;
}

struct pbnds_display tool_display(const struct tool_options *options)
{
    return (struct pbnds_display){(float)options->exposure,
                                  (enum pbnds_tonemap)options->tonemap};
}
