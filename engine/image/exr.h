/**
 * @file exr.h
 * OpenEXR files of named channels through OpenEXRCore (the only file that includes it):
 * single part, scanline, lossless (none, ZIPS, ZIP, PIZ). Chunks are compressed and
 * decompressed by all threads (parallel.h); file and planes are the same at any number. What it cannot read (DWAA, DWAB,
 * tiles, several parts) is PBNDS_ERROR_UNSUPPORTED; light maps then go through oiio.h.
 */
#ifndef PBNDS_ENGINE_IMAGE_EXR_H
#define PBNDS_ENGINE_IMAGE_EXR_H

#include <stddef.h>
#include <stdint.h>

#include "engine/core/error.h"

enum pbnds_exr_type { PBNDS_EXR_UINT = 0, PBNDS_EXR_HALF = 1, PBNDS_EXR_FLOAT = 2 };

enum pbnds_exr_compression {
    PBNDS_EXR_NONE = 0,
    PBNDS_EXR_ZIPS = 2,
    PBNDS_EXR_ZIP = 3,
    PBNDS_EXR_PIZ = 4,
};

/** One plane. In memory FLOAT and HALF are float (converted on the way), UINT is
 *  uint32_t; values beyond half range saturate to +-65504, infinities stay. */
struct pbnds_exr_channel {
    char name[64];
    enum pbnds_exr_type type; /**< as stored in the file                       */
    void *data;               /**< width * height elements, row 0 on top       */
};

enum pbnds_exr_attribute_type {
    PBNDS_EXR_ATTRIBUTE_STRING,
    PBNDS_EXR_ATTRIBUTE_INT,
    PBNDS_EXR_ATTRIBUTE_FLOAT,
    PBNDS_EXR_ATTRIBUTE_M44F, /**< 16 floats, OpenEXR row-vector order        */
    PBNDS_EXR_ATTRIBUTE_TEXT, /**< a string over 511 bytes                    */
};

struct pbnds_exr_attribute {
    char name[64];
    enum pbnds_exr_attribute_type type;
    union {
        char string[512];
        int32_t i;
        float f;
        float m44[16];
        char *text; /**< owned by a file that was read, borrowed when written */
    } value;
};

/** A file in memory. Arrays and planes of one that was read are owned by it. */
struct pbnds_exr {
    int width, height;
    enum pbnds_exr_compression compression;
    struct pbnds_exr_channel *channels;
    int channel_count;
    struct pbnds_exr_attribute *attributes;
    int attribute_count;
};

#ifdef __cplusplus
extern "C" {
#endif

/** Reads every channel and every attribute of the kinds above. The data window may be offset; its size is the image's. Errors: IO, FORMAT (truncated, damaged, 0x0),
 *  UNSUPPORTED, MEMORY (over 2^31 bytes of planes). */
enum pbnds_status pbnds_exr_read(const char *path, struct pbnds_exr *exr,
                                 struct pbnds_error *error) PBNDS_NODISCARD;
/** The same from a file's bytes, which are borrowed for the call; `name` is for
 *  messages. */
enum pbnds_status pbnds_exr_read_memory(const char *name, const uint8_t *bytes,
                                        size_t size, struct pbnds_exr *exr,
                                        struct pbnds_error *error) PBNDS_NODISCARD;
/** Frees what pbnds_exr_read() made. Never call it on a borrowed description. */
void pbnds_exr_free(struct pbnds_exr *exr);

/** Plane of that name and memory kind (float for HALF and FLOAT, uint32_t for UINT), or
 *  NULL. */
const struct pbnds_exr_channel *pbnds_exr_find(const struct pbnds_exr *exr,
                                               const char *name);
const struct pbnds_exr_attribute *pbnds_exr_find_attribute(const struct pbnds_exr *exr,
                                                           const char *name);

/** Writes atomically (file.h). Channels may come in any order. Attributes that follow from
 *  the planes (type, name, version, chunkCount) are left out; the others the format needs
 *  are 0 or 1 by default. Pure: the same input gives the same bytes. */
enum pbnds_status pbnds_exr_write(const char *path, const struct pbnds_exr *exr,
                                  struct pbnds_error *error) PBNDS_NODISCARD;

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_ENGINE_IMAGE_EXR_H */
