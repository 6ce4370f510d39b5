/**
 * @file console.h
 * What a person sees and does while a command runs: progress and warnings on stderr,
 * Ctrl-C, the clock.
 */
#ifndef PBNDS_TOOLS_CONSOLE_H
#define PBNDS_TOOLS_CONSOLE_H

#include <stdbool.h>

#include "engine/core/report.h"

/** Installs the signal handlers: the first SIGINT or SIGTERM asks the library to stop,
 * the second kills. SIGPIPE and SIGXFSZ become write errors. */
void tool_console_init(void);
void tool_console_quiet(bool quiet);
/** Without progress (of the ranks of one run, the first shows its own). */
void tool_console_no_progress(void);
/** The ear that library calls get. */
const struct pbnds_report *tool_report(void);
/** Ends an open progress bar, so that other text starts on a clean line. */
void tool_console_clear(void);
/** PBNDS_ERROR_INTERRUPTED when a stop was asked for: call it between stages. */
enum pbnds_status tool_check_stop(struct pbnds_error *error) PBNDS_NODISCARD;
/** Monotonic seconds. */
double tool_seconds(void);

#endif /* PBNDS_TOOLS_CONSOLE_H */
