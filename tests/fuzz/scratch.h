/** @file scratch.h  Bytes of the fuzzer as a file, for readers that want a name. */
#ifndef PBNDS_TESTS_FUZZ_SCRATCH_H
#define PBNDS_TESTS_FUZZ_SCRATCH_H

#include <stdint.h>
#include <stdio.h>
#include <unistd.h>

/** Writes the bytes to a file of this process in the working folder; the caller removes
 * it.
 *  @return 0 when that failed */
static inline int scratch_write(char *path, size_t path_size, const char *extension,
                                const uint8_t *data, size_t size)
{
    (void)snprintf(path, path_size, "fuzz-%ld%s", (long)getpid(), extension);
    FILE *file = fopen(path, "wb");
    if (!file) return 0;
    const size_t written = fwrite(data, 1, size, file);
    return fclose(file) == 0 && written == size;
}

#endif /* PBNDS_TESTS_FUZZ_SCRATCH_H */
