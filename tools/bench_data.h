/**
 * @file bench_data.h
 * The stage `dataset` of pbnds bench: what a sample of a data set costs, and how much of it
 * is not the path tracer.
 */
#ifndef PBNDS_TOOLS_BENCH_DATA_H
#define PBNDS_TOOLS_BENCH_DATA_H

#include "tools/options.h"

/** Makes samples of procedural worlds with every target, prints one line. Errors: of the
 *  samples, IO. */
enum pbnds_status tool_bench_data(const struct tool_options *options,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

#endif /* PBNDS_TOOLS_BENCH_DATA_H */
