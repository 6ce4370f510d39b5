/* pbnds: the command. Finds the subcommand, runs it, turns its status into an exit
 * code. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/parallel.h"
#include "engine/core/ranks.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/shaders.h"

static const struct tool_command *const commands[] = {
    &tool_render, &tool_gbuffer, &tool_shade, &tool_compare, &tool_dataset, &tool_train,
    &tool_export, &tool_import,  &tool_info,  &tool_check,   &tool_bench,
};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static const char version_text[] = "pbnds " PBNDS_VERSION "\n";

/* Exit status of the program, a part of its interface. */
static int exit_code(enum pbnds_status status)
{
    switch (status) {
    case PBNDS_OK:
        return 0;
    case PBNDS_ERROR_ARGUMENT:
        return 2;
    case PBNDS_ERROR_FORMAT:
        return 3;
    case PBNDS_ERROR_UNSUPPORTED:
        return 4;
    case PBNDS_ERROR_IO:
    case PBNDS_ERROR_MEMORY:
    case PBNDS_ERROR_BACKEND:
    case PBNDS_ERROR_INTERRUPTED:
        return 1;
    }
    return 1;
}

static void print_help(void)
{
    (void)printf(
        "usage: pbnds SUBCOMMAND ...\n\n"
        "A deferred renderer whose shading pass is a neural network: ray casts glTF "
        "scenes\ninto G-buffers, shades them under an HDRI, makes training data, "
        "trains.\n\n");
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        (void)printf("  %-9s %s\n", commands[i]->name, commands[i]->about);
    }
    (void)printf(
        "\n'pbnds SUBCOMMAND --help' tells the rest. For a start:\n"
        "  pbnds render scene.glb -o out.png --env studio.hdr\n"
        "  pbnds compare scene.glb -o out --env studio.hdr --shaders ggx,neural\n");
    tool_shaders_help();
}

static enum pbnds_status find_command(const char *name,
                                      const struct tool_command **command,
                                      struct pbnds_error *error)
{
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        if (strcmp(commands[i]->name, name) == 0) {
            *command = commands[i];
            return PBNDS_OK;
        }
    }
    if (strcmp(name, "eval") == 0) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "'%s' is not in this version; see pbnds --help", name);
    }
    return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                      "'%s' is not a subcommand; see pbnds --help", name);
}

static enum pbnds_status run(int argc, char **argv, struct pbnds_error *error)
{
    if (argc < 2) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "a subcommand is missing; see pbnds --help");
    }
    const char *word = argv[1];
    if (strcmp(word, "--version") == 0) {
        (void)fputs(version_text, stdout);
        return PBNDS_OK;
    }
    const bool help = strcmp(word, "help") == 0;
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || (help && argc == 2)) {
        print_help();
        return PBNDS_OK;
    }
    const struct tool_command *command = NULL;
    PBNDS_TRY(find_command(help ? argv[2] : word, &command, error));
    struct tool_options options;
    if (!help)
        PBNDS_TRY(tool_options_parse(command, argc - 1, argv + 1, &options, error));
    if (help || options.help) {
        tool_options_help(command);
        if (command->mask & (TOOL_RENDER | TOOL_SHADE | TOOL_COMPARE))
            tool_shaders_help();
        return PBNDS_OK;
    }
    if (options.version) {
        (void)fputs(version_text, stdout);
        return PBNDS_OK;
    }
    tool_console_quiet(options.quiet);
    pbnds_set_threads(options.threads);
    const bool shared = command->mask & (TOOL_DATASET | TOOL_TRAIN);
    if (shared) PBNDS_TRY(pbnds_ranks_init(error));
    const enum pbnds_status status = command->run(&options, error);
    if (shared) pbnds_ranks_finish();
    return status;
}

int main(int argc, char **argv)
{
    tool_console_init();
    struct pbnds_error error = {""};
    enum pbnds_status status = run(argc, argv, &error);
    tool_console_clear();
    errno = 0;
    if ((fflush(stdout) != 0 || ferror(stdout)) && status == PBNDS_OK) {
        status =
            pbnds_fail(&error, PBNDS_ERROR_IO, "standard output: cannot be written: %s",
                       strerror(errno ? errno : EIO));
    }
    if (status != PBNDS_OK) (void)fprintf(stderr, "pbnds: %s\n", error.message);
    return exit_code(status);
}
