/**
 * @file report.h
 * How the library talks while it works: warnings and progress go to callbacks
 * that the caller supplies (the program prints them on stderr), and a flag
 * that the caller may raise asks long loops to stop.
 */
#ifndef PBNDS_ENGINE_CORE_REPORT_H
#define PBNDS_ENGINE_CORE_REPORT_H

#include <stdbool.h>

#include "engine/core/error.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Caller's ear. Any member may be NULL; a NULL pointer to the struct is silence.
 *  Callbacks are called from one thread at a time. */
struct pbnds_report {
    void (*warn)(void *user, const char *sentence);
    /** `done` of `total` units of `stage`; total 0 when unknown. */
    void (*progress)(void *user, const char *stage, double done, double total);
    void *user;
};

void pbnds_warn(const struct pbnds_report *report, const char *format, ...)
    PBNDS_PRINTF(2, 3);
void pbnds_progress(const struct pbnds_report *report, const char *stage, double done,
                    double total);

/** Raises the stop flag; async-signal-safe. Loops end at the next tile, step or sample
 *  and the call returns PBNDS_ERROR_INTERRUPTED. */
void pbnds_request_stop(void);
bool pbnds_stop_requested(void);

/** For a loop that found the flag raised. */
enum pbnds_status pbnds_fail_interrupted(struct pbnds_error *error);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_CORE_REPORT_H */
