#include "neural/train/task.h"

#include <stdio.h>
#include <string.h>

static const struct pbnds_task_ops *const TASKS[] = {
    &pbnds_task_transport,
    &pbnds_task_pbnds_plus,
};

const struct pbnds_task_ops *pbnds_task_find(const char *model)
{
    for (size_t i = 0; i < sizeof TASKS / sizeof TASKS[0]; ++i) {
        if (strcmp(TASKS[i]->model->name, model) == 0) return TASKS[i];
    }
    return NULL;
}

void pbnds_task_names(char *text, size_t size)
{
    size_t used = 0;
    if (size > 0) text[0] = 0;
    for (size_t i = 0; i < sizeof TASKS / sizeof TASKS[0] && used < size; ++i) {
        const int n = snprintf(text + used, size - used, "%s%s", i ? ", " : "",
                               TASKS[i]->model->name);
        used += n > 0 ? (size_t)n : 0;
    }
}
