#include "neural/model/model.h"

#include <string.h>

#include "neural/model/model_pbnds_plus.h"
#include "neural/model/model_transport.h"

static const struct pbnds_model *const MODELS[] = {&pbnds_model_transport,
                                                   &pbnds_model_pbnds_plus};

const struct pbnds_model *pbnds_model_at(int i)
{
    const int count = (int)(sizeof MODELS / sizeof MODELS[0]);
    return i >= 0 && i < count ? MODELS[i] : NULL;
}

const struct pbnds_model *pbnds_model_find(const char *name)
{
    for (int i = 0; pbnds_model_at(i); ++i) {
        if (strcmp(MODELS[i]->name, name) == 0) return MODELS[i];
    }
    return NULL;
}
