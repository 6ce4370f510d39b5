/* libFuzzer target: any bytes as the lists beside a set of photographs: as JSON where they
 * begin with a brace, else line by line. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "neural/data/picture_list.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pbnds_picture_list list = {NULL, 0};
    struct pbnds_error error;
    const enum pbnds_status status =
        size > 0 && data[0] == '{'
            ? pbnds_picture_list_json(&list, data, size, "fuzz", &error)
            : pbnds_picture_list_lines(&list, data, size, 1.0, "fuzz", &error);
    if (status == PBNDS_OK &&
        pbnds_picture_list_sort(&list, "fuzz", &error) == PBNDS_OK) {
        for (int i = 0; i < list.count; ++i) {
            const struct pbnds_picture_value *v = &list.items[i];
            const double found = pbnds_picture_list_find(&list, v->index);
            if (v->index < 0 || v->index > 999999999) abort();
            if (!isnan(v->value) && found != v->value) abort();
        }
    }
    pbnds_picture_list_free(&list);
    return 0;
}
