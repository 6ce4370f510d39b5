/**
 * @file gbuffer_check.h
 * Does a file keep the contract of the G-buffer? Looks at what is stored, before the
 * reader mends it.
 */
#ifndef PBNDS_ENGINE_SHADE_GBUFFER_CHECK_H
#define PBNDS_ENGINE_SHADE_GBUFFER_CHECK_H

#include <stdbool.h>
#include <stdint.h>

#include "engine/image/exr.h"

/** One thing that is wrong, at one channel or in the header. */
struct pbnds_finding {
    const char *rule;  /**< a word: "unit-normals"                                    */
    const char *wants; /**< what the contract wants                                   */
    bool fault;        /**< false: a warning, the file is used as it is               */
    char channel[64];  /**< or attribute                                              */
    uint64_t count;    /**< pixels; 1 for what concerns the whole file                */
    int x, y;          /**< the first of them, in rows from the top; -1, -1: no pixel */
    double value;      /**< found there: the channel's, or what `wants` is about      */
};

enum { PBNDS_FINDINGS_MAX = 256 };

/** What was found, faults and warnings in the order in which they were met; what is
 *  beyond PBNDS_FINDINGS_MAX is counted in `dropped` alone. */
struct pbnds_findings {
    struct pbnds_finding items[PBNDS_FINDINGS_MAX];
    int count, dropped;
    int width, height;
    int contract; /**< version, 0: the file does not say */
};

#ifdef __cplusplus
extern "C" {
#endif

/** Lints a file in memory; `path` is for messages. */
void pbnds_gbuffer_check(const struct pbnds_exr *exr, const char *path,
                         struct pbnds_findings *findings);

/** Number of findings that are faults: none, and the file is sound. */
int pbnds_findings_faults(const struct pbnds_findings *findings);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_SHADE_GBUFFER_CHECK_H */
