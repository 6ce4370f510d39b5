#include "engine/core/report.h"

#include <signal.h>
#include <stdarg.h>
#include <stdio.h>

static volatile sig_atomic_t stop_flag;

void pbnds_warn(const struct pbnds_report *report, const char *format, ...)
{
    if (!report || !report->warn) return;
    char sentence[1024];
    va_list args;
    va_start(args, format);
    (void)vsnprintf(sentence, sizeof sentence, format, args);
    va_end(args);
    pbnds_plain_text(sentence);
    report->warn(report->user, sentence);
}

void pbnds_progress(const struct pbnds_report *report, const char *stage, double done,
                    double total)
{
    if (report && report->progress) report->progress(report->user, stage, done, total);
}

void pbnds_request_stop(void)
{
    stop_flag = 1;
}

bool pbnds_stop_requested(void)
{
    return stop_flag != 0;
}

enum pbnds_status pbnds_fail_interrupted(struct pbnds_error *error)
{
    return pbnds_fail(error, PBNDS_ERROR_INTERRUPTED, "interrupted");
}
