#include "tools/options.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/options_table.h"

enum { FIRST_ID = 256 };

static const char *const group_names[] = {"Camera", "Light",  "Shading",
                                          "Job",    "Output", "Everywhere"};

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

static enum pbnds_status bad_value(const struct tool_row *row, const char *text,
                                   const char *want, struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_ARGUMENT, "--%s: '%s' is not %s", row->name,
                      text, want);
}

static enum pbnds_status set_number(const struct tool_row *row, const char *text,
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

static enum pbnds_status set_seed(const struct tool_row *row, const char *text,
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

static enum pbnds_status set_size(const struct tool_row *row, const char *text,
                                  int size[2], struct pbnds_error *error)
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

static enum pbnds_status set_shard(const struct tool_row *row, const char *text,
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

static enum pbnds_status set_look(const struct tool_row *row, const char *text,
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

static enum pbnds_status set_choice(const struct tool_row *row, const char *text,
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

static enum pbnds_status set_name(const struct tool_row *row, const char *text,
                                  int *target, struct pbnds_error *error)
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

static enum pbnds_status set_string(const struct tool_row *row, const char *text,
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

static enum pbnds_status set_row(const struct tool_row *row, const char *text,
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
        .ema = 0.999,
        .augment = 1,
        .sheet_every = 1000,
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
    struct option table[TOOL_ROW_MAX + 1];
    int used = 0;
    for (int i = 0; i < tool_row_count; ++i) {
        if (!(tool_rows[i].mask & command->mask)) continue;
        table[used++] = (struct option){
            tool_rows[i].name,
            tool_rows[i].kind == KIND_FLAG ? no_argument : required_argument, NULL,
            FIRST_ID + i};
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
        for (int i = 0; i < tool_row_count && id < FIRST_ID; ++i) {
            const char *name = id == 'o' ? "output" : "help";
            if (strcmp(tool_rows[i].name, name) == 0) id = FIRST_ID + i;
        }
        const struct tool_row *row = &tool_rows[id - FIRST_ID];
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
        for (int i = 0; i < tool_row_count; ++i) {
            if (tool_rows[i].group != (enum tool_row_group)g ||
                !(tool_rows[i].mask & command->mask))
                continue;
            if (!titled) (void)printf("\n%s\n", group_names[g]);
            titled = true;
            char left[64];
            (void)snprintf(left, sizeof left, "--%s %s", tool_rows[i].name,
                           tool_rows[i].metavar ? tool_rows[i].metavar : "");
            (void)printf("  %-29s ", left);
            tool_print_wrapped(tool_rows[i].help, 32);
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
