#include <math.h>
#include <stdio.h>
#include <string.h>

#include "neural/model/model.h"
#include "tools/output.h"
#include "tools/weights.h"

struct check {
    const char *path;
    bool json;
    int faults, warnings;
    char first[192]; /* fault */
};

/* One finding of a tensor; `at` < 0: of no element in particular. */
static void tell(struct check *c, bool fault, const char *rule, const char *tensor,
                 double count, double at, const char *what)
{
    if (fault && c->faults == 0)
        (void)snprintf(c->first, sizeof c->first, "%.95s: %s", tensor, what);
    const bool leading = c->faults + c->warnings == 0;
    ++*(fault ? &c->faults : &c->warnings);
    if (c->json) {
        (void)printf("%s{\"rule\": ", leading ? "" : ", ");
        tool_json_string(stdout, rule);
        (void)printf(", \"level\": \"%s\", \"tensor\": ", fault ? "fault" : "warning");
        tool_json_string(stdout, tensor);
        (void)printf(", \"count\": %.0f, \"first\": ", count);
        tool_json_number(stdout, at < 0.0 ? (double)NAN : at);
        (void)printf("}");
        return;
    }
    char plain[96];
    (void)snprintf(plain, sizeof plain, "%s", tensor); /* it comes from the file */
    pbnds_plain_text(plain);
    (void)printf("  %-7s %-10s %-28s %s", fault ? "fault" : "warning", rule, plain,
                 what);
    if (at >= 0.0) (void)printf(" (%.0f of them, the first at %.0f)", count, at);
    (void)printf("\n");
}

static void check_values(struct check *c, const struct pbnds_safetensor *t)
{
    size_t bad = 0, first = 0, zeros = 0;
    for (size_t k = 0; k < t->count; ++k) {
        if (!isfinite(t->data[k])) {
            if (bad++ == 0) first = k;
        }
        if (t->data[k] == 0.0f) ++zeros;
    }
    if (bad > 0)
        tell(c, true, "finite", t->name, (double)bad, (double)first,
             "NaN or infinite values");
    if (t->rank == 4 && t->count > 0 && zeros == t->count)
        tell(c, false, "zero", t->name, (double)zeros, -1.0,
             "every weight is 0: it passes nothing on");
}

static void check_against(struct check *c, const struct pbnds_safetensors *file,
                          const struct pbnds_net *net)
{
    for (int i = 0; i < pbnds_net_tensor_count(net); ++i) {
        const struct pbnds_param *p = pbnds_net_param(net, i);
        const struct pbnds_safetensor *t = pbnds_safetensors_find(file, p->name);
        if (!t) {
            tell(c, true, "missing", p->name, 1.0, -1.0, "the model has this tensor");
        } else if (t->rank != p->rank ||
                   memcmp(t->shape, p->shape, (size_t)p->rank * sizeof(int)) != 0) {
            tell(c, true, "shape", p->name, 1.0, -1.0, "the model's has another shape");
        }
    }
    for (int i = 0; i < file->tensor_count; ++i) {
        const struct pbnds_safetensor *t = &file->tensors[i];
        int k = 0;
        while (k < pbnds_net_tensor_count(net) &&
               strcmp(pbnds_net_param(net, k)->name, t->name) != 0)
            ++k;
        if (k == pbnds_net_tensor_count(net))
            tell(c, true, "foreign", t->name, 1.0, -1.0,
                 "the model has no such tensor");
        check_values(c, t);
    }
}

static enum pbnds_status check_file(struct check *c,
                                    const struct pbnds_safetensors *file,
                                    const struct pbnds_model *model,
                                    struct pbnds_error *error)
{
    struct pbnds_backend *backend = NULL;
    struct pbnds_net *net = NULL;
    PBNDS_TRY(pbnds_backend_create_onednn(&backend, error));
    const enum pbnds_status status =
        pbnds_net_create(&model->table, backend, PBNDS_F32, &net, error);
    if (status == PBNDS_OK) {
        if (c->json) {
            (void)printf("{\"output\": ");
            tool_json_string(stdout, c->path);
            (void)printf(", \"model\": ");
            tool_json_string(stdout, model->name);
            (void)printf(", \"findings\": [");
        }
        check_against(c, file, net);
        if (c->json) {
            (void)printf("], \"sound\": %d}\n", c->faults == 0);
        } else {
            (void)printf("%s: weights of %s, %s (%d fault%s, %d warning%s)\n", c->path,
                         model->name, c->faults ? "not sound" : "sound", c->faults,
                         c->faults == 1 ? "" : "s", c->warnings,
                         c->warnings == 1 ? "" : "s");
        }
    }
    pbnds_net_free(net);
    pbnds_backend_free(backend);
    return status;
}

enum pbnds_status tool_check_weights(const char *path, bool json,
                                     struct pbnds_error *error)
{
    struct pbnds_safetensors file;
    const struct pbnds_model *model;
    struct check c = {.path = path, .json = json};
    PBNDS_TRY(pbnds_weights_open(path, &file, &model, error));
    const enum pbnds_status status = check_file(&c, &file, model, error);
    pbnds_safetensors_free(&file);
    if (status != PBNDS_OK || c.faults == 0) return status;
    return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                      "%s: not sound weights: %d fault%s, the first of %s", path,
                      c.faults, c.faults == 1 ? "" : "s", c.first);
}
