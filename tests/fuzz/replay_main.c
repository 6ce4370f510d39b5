/* Feeds every file of a folder to a fuzz target once: the corpus as a regression test.
 */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

static int replay(const char *folder, const char *name)
{
    char path[1400];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    uint8_t *data = NULL;
    size_t size = 0;
    struct pbnds_error error;
    if (pbnds_file_read(path, (size_t)64 << 20, &data, &size, &error) != PBNDS_OK) {
        (void)fprintf(stderr, "%s\n", error.message);
        return 0;
    }
    /* An exact copy on the heap: reading one byte past it is seen by the sanitizer. */
    uint8_t *copy = malloc(size ? size : 1);
    if (!copy) abort();
    memcpy(copy, data, size);
    free(data);
    (void)printf("%s: %zu bytes\n", name, size);
    (void)fflush(stdout);
    (void)LLVMFuzzerTestOneInput(copy, size);
    free(copy);
    return 1;
}

int main(int argc, char **argv)
{
    if (argc != 2) return 2;
    struct dirent **entries = NULL;
    const int count = scandir(argv[1], &entries, NULL, by_name);
    int wanted = 0, done = 0;
    for (int i = 0; i < count; ++i) {
        if (entries[i]->d_name[0] != '.') {
            ++wanted;
            done += replay(argv[1], entries[i]->d_name);
        }
        free(entries[i]);
    }
    free(entries);
    (void)printf("%d of %d files replayed\n", done, wanted);
    return wanted > 0 && done == wanted ? 0 : 1;
}
