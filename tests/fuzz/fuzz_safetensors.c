/* libFuzzer target: any bytes as a weights file, and whose it says that it is. */
#include <stddef.h>
#include <stdint.h>

#include "neural/model/model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pbnds_safetensors file;
    struct pbnds_error error;
    volatile float sink = 0.0f;
    if (pbnds_safetensors_parse(data, size, "fuzz", &file, &error) != PBNDS_OK)
        return 0;
    for (int i = 0; i < file.tensor_count; ++i) {
        const struct pbnds_safetensor *t = &file.tensors[i];
        for (size_t k = 0; k < t->count; ++k)
            sink += t->data[k];
    }
    for (int i = 0; i < file.metadata_count; ++i) {
        sink +=
            (float)(pbnds_safetensors_metadata(&file, file.metadata[i].key) != NULL);
    }
    const struct pbnds_model *model;
    sink += (float)(pbnds_weights_identify("fuzz", &file, &model, &error) == PBNDS_OK);
    pbnds_safetensors_free(&file);
    (void)sink; /* written so that every element is read */
    return 0;
}
