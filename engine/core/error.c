#include "engine/core/error.h"

#include <stdarg.h>
#include <stdio.h>

void pbnds_plain_text(char *text)
{
    for (unsigned char *p = (unsigned char *)text; *p; ++p) {
        /* C0, DEL, and C1 as UTF-8 (c2 80 to c2 9f). */
        const int c1 = *p == 0xc2 && p[1] >= 0x80 && p[1] <= 0x9f;
        if (*p < 0x20 || *p == 0x7f || c1) {
            *p = '?';
            if (c1) *++p = '?';
        }
    }
}

enum pbnds_status pbnds_fail(struct pbnds_error *error, enum pbnds_status status,
                             const char *format, ...)
{
    if (error) {
        va_list args;
        va_start(args, format);
        (void)vsnprintf(error->message, sizeof error->message, format, args);
        va_end(args);
        pbnds_plain_text(error->message);
    }
    return status;
}
