/* libFuzzer target: any bytes as a Blender multilayer file, or, behind a byte that says
 * which, as one of the maps of a folder. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/shade/import.h"
#include "tests/fuzz/scratch.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void check(const struct pbnds_gbuffer *g)
{
    const size_t count = (size_t)g->width * (size_t)g->height;
    for (size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c) {
            if (!isfinite(g->albedo[c][i]) || !isfinite(g->normal[c][i])) abort();
            if (!isfinite(g->position[c][i]) || !isfinite(g->emission[c][i])) abort();
        }
        if (!isfinite(g->roughness[i]) || !isfinite(g->metallic[i])) abort();
        if (!isfinite(g->specular[i]) || isnan(g->depth[i])) abort();
        if (!(g->coverage[i] >= 0.0f && g->coverage[i] <= 1.0f)) abort();
    }
}

static void import_layers(const uint8_t *data, size_t size)
{
    char path[64];
    static struct pbnds_import_notes notes;
    const struct pbnds_import_options options = {0};
    struct pbnds_gbuffer gbuffer;
    struct pbnds_image radiance;
    struct pbnds_error error;
    if (!scratch_write(path, sizeof path, ".exr", data, size)) return;
    if (pbnds_import_blender(path, &options, &gbuffer, &radiance, &notes, &error) ==
        PBNDS_OK) {
        check(&gbuffer);
        pbnds_gbuffer_free(&gbuffer);
        pbnds_image_free(&radiance);
    }
    (void)unlink(path);
}

static const char *extension_of(const uint8_t *data, size_t size)
{
    if (size >= 4 && memcmp(data, "\x76\x2f\x31\x01", 4) == 0) return "exr";
    if (size >= 2 && memcmp(data, "#?", 2) == 0) return "hdr";
    if (size >= 4 && memcmp(data, "RIFF", 4) == 0) return "webp";
    return size >= 2 && data[0] == 0xff && data[1] == 0xd8 ? "jpg" : "png";
}

static void import_map(const uint8_t *data, size_t size)
{
    static const char *const names[] = {"albedo",   "normal",   "roughness",
                                        "metallic", "specular", "depth",
                                        "mask",     "emission", "ao"};
    static struct pbnds_import_notes notes;
    char folder[64], path[128];
    const struct pbnds_import_options options = {0};
    struct pbnds_gbuffer gbuffer;
    struct pbnds_image photo;
    enum pbnds_target target;
    struct pbnds_error error;
    (void)snprintf(folder, sizeof folder, "fuzz-%ld.maps", (long)getpid());
    (void)mkdir(folder, 0700);
    (void)snprintf(path, sizeof path, "%s/%s.%s", folder, names[data[0] % 9],
                   extension_of(data + 1, size - 1));
    FILE *file = fopen(path, "wb");
    if (!file) return;
    (void)fwrite(data + 1, 1, size - 1, file);
    if (fclose(file) == 0 && pbnds_import_images(folder, &options, &gbuffer, &photo,
                                                 &target, &notes, &error) == PBNDS_OK) {
        check(&gbuffer);
        pbnds_gbuffer_free(&gbuffer);
        pbnds_image_free(&photo);
    }
    (void)unlink(path);
    (void)rmdir(folder);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size >= 4 && memcmp(data, "\x76\x2f\x31\x01", 4) == 0)
        import_layers(data, size);
    else if (size >= 2)
        import_map(data, size);
    return 0;
}
