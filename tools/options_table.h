/**
 * @file options_table.h
 * The rows of the command line: names, ranges, help. options.h is what the program sees.
 */
#ifndef PBNDS_TOOLS_OPTIONS_TABLE_H
#define PBNDS_TOOLS_OPTIONS_TABLE_H

#include <stddef.h>

/** What a value is and where it goes. */
enum tool_row_kind {
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

enum tool_row_group {
    GROUP_CAMERA,
    GROUP_LIGHT,
    GROUP_SHADE,
    GROUP_JOB,
    GROUP_OUT,
    GROUP_ANY
};

/** One option of one or more subcommands. */
struct tool_row {
    const char *name;
    enum tool_row_kind kind;
    size_t offset;
    double min, max;
    unsigned mask;
    enum tool_row_group group;
    const char *metavar, *help;
    const char *choices; /* "off|on" */
};

/** In the order of --help. */
enum { TOOL_ROW_MAX = 160 };
extern const struct tool_row tool_rows[];
extern const int tool_row_count; /**< at most TOOL_ROW_MAX */

#endif /* PBNDS_TOOLS_OPTIONS_TABLE_H */
