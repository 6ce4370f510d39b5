#include "tools/shipped.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool joined(char *path, size_t size, const char *folder, const char *name)
{
    const int n = snprintf(path, size, "%s/%s", folder, name);
    return n > 0 && (size_t)n < size && access(path, R_OK) == 0;
}

/* <folder of the program>/../share/pbnds: an installed tree may be moved. */
static bool beside_program(char *folder, size_t size)
{
    char program[1024];
    const ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
    if (n <= 0) return false;
    program[n] = 0;
    char *slash = strrchr(program, '/');
    if (!slash) return false;
    *slash = 0;
    const int length = snprintf(folder, size, "%s/../share/pbnds", program);
    return length > 0 && (size_t)length < size;
}

bool tool_shipped(const char *name, char *path, size_t size)
{
    const char *chosen = getenv("PBNDS_DATA");
    if (chosen && *chosen && joined(path, size, chosen, name)) return true;
    char folder[1200];
    if (beside_program(folder, sizeof folder) && joined(path, size, folder, name))
        return true;
    /* In the source tree the weights lie with the code that reads them. */
    const bool weights = strncmp(name, "weights/", 8) == 0;
    if (joined(path, size, weights ? PBNDS_SOURCE_DIR "/neural" : PBNDS_SOURCE_DIR,
               name)) {
        return true;
    }
    if (joined(path, size, PBNDS_DATA_DIR, name)) return true;
    (void)snprintf(path, size, "%s/%s", chosen && *chosen ? chosen : PBNDS_DATA_DIR,
                   name);
    return false;
}
