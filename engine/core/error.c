#include "engine/core/error.h"

#include <stdarg.h>
#include <stdio.h>

enum pbnds_status pbnds_fail(struct pbnds_error *error, enum pbnds_status status,
                             const char *format, ...)
{
    if (error) {
        va_list args;
        va_start(args, format);
        (void)vsnprintf(error->message, sizeof error->message, format, args);
        va_end(args);
    }
    return status;
}
