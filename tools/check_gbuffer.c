#include "tools/check_gbuffer.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/shade/gbuffer_check.h"
#include "tools/output.h"

static void print_finding(const struct pbnds_finding *f)
{
    char place[96];
    if (f->x < 0) {
        (void)snprintf(place, sizeof place, "in the file");
    } else {
        (void)snprintf(place, sizeof place, "%" PRIu64 " pixel%s from (%d, %d), %.6g",
                       f->count, f->count == 1 ? "" : "s", f->x, f->y, f->value);
    }
    (void)printf("  %-7s %-12s %-16s %s: %s\n", f->fault ? "fault" : "warning", f->rule,
                 f->channel, place, f->wants);
}

static void print_table(const char *path, const struct pbnds_findings *found)
{
    const int faults = pbnds_findings_faults(found);
    (void)printf("%s: G-buffer, %s", path, faults ? "not sound" : "sound");
    if (found->count > 0) {
        (void)printf(" (%d fault%s, %d warning%s)", faults, faults == 1 ? "" : "s",
                     found->count - faults, found->count - faults == 1 ? "" : "s");
    }
    (void)printf("\n");
    for (int i = 0; i < found->count; ++i)
        print_finding(&found->items[i]);
    if (found->dropped > 0)
        (void)printf("  and %d more that are not listed\n", found->dropped);
}

static void json_finding(const struct pbnds_finding *f)
{
    (void)printf("{\"rule\": ");
    tool_json_string(stdout, f->rule);
    (void)printf(", \"level\": \"%s\", \"channel\": ", f->fault ? "fault" : "warning");
    tool_json_string(stdout, f->channel);
    (void)printf(", \"count\": %" PRIu64 ", \"pixel\": ", f->count);
    if (f->x < 0) {
        (void)printf("null");
    } else {
        (void)printf("[%d, %d]", f->x, f->y);
    }
    (void)printf(", \"value\": ");
    tool_json_number(stdout, f->value);
    (void)printf(", \"wants\": ");
    tool_json_string(stdout, f->wants);
    (void)printf("}");
}

static void print_json(const char *path, const struct pbnds_findings *found)
{
    (void)printf("{\"output\": ");
    tool_json_string(stdout, path);
    (void)printf(
        ", \"sound\": %d, \"size\": [%d, %d], \"contract\": %d, \"findings\": [",
        pbnds_findings_faults(found) == 0, found->width, found->height,
        found->contract);
    for (int i = 0; i < found->count; ++i) {
        if (i > 0) (void)printf(", ");
        json_finding(&found->items[i]);
    }
    (void)printf("]}\n");
}

enum pbnds_status tool_check_gbuffer(const char *path, bool json,
                                     struct pbnds_error *error)
{
    struct pbnds_exr exr;
    PBNDS_TRY(pbnds_exr_read(path, &exr, error));
    struct pbnds_findings *found = malloc(sizeof *found);
    if (!found) {
        pbnds_exr_free(&exr);
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory to check it", path);
    }
    pbnds_gbuffer_check(&exr, path, found);
    pbnds_exr_free(&exr);
    if (json) {
        print_json(path, found);
    } else {
        print_table(path, found);
    }
    enum pbnds_status status = PBNDS_OK;
    const int faults = pbnds_findings_faults(found);
    for (int i = 0; i < found->count && faults > 0; ++i) {
        const struct pbnds_finding *f = &found->items[i];
        if (!f->fault) continue;
        status =
            pbnds_fail(error, PBNDS_ERROR_FORMAT,
                       "%s: not a sound G-buffer: %d fault%s, the first of %s (%s)",
                       path, faults, faults == 1 ? "" : "s", f->channel, f->wants);
        break;
    }
    free(found);
    return status;
}
