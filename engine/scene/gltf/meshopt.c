#include "engine/scene/gltf/meshopt.h"

#include <stdbool.h>
#include <string.h>

#include <meshoptimizer.h>

/* The library asserts, or trusts, what the extension's text demands: checked here. */

static const char *decode_attributes(const char *filter, const uint8_t *bytes,
                                     size_t size, size_t count, size_t stride,
                                     uint8_t *out)
{
    void (*apply)(void *, size_t, size_t) = NULL;
    bool fits = true;
    if (stride % 4 != 0 || stride == 0 || stride > 256) {
        return "a byteStride that is not 4, 8, ... or 256";
    }
    if (strcmp(filter, "OCTAHEDRAL") == 0) {
        apply = meshopt_decodeFilterOct;
        fits = stride == 4 || stride == 8;
    } else if (strcmp(filter, "QUATERNION") == 0) {
        apply = meshopt_decodeFilterQuat;
        fits = stride == 8;
    } else if (strcmp(filter, "EXPONENTIAL") == 0) {
        apply = meshopt_decodeFilterExp;
    } else if (strcmp(filter, "NONE") != 0) {
        return "an unknown filter";
    }
    if (!fits) return "a byteStride that its filter does not allow";
    if (meshopt_decodeVertexBuffer(out, count, stride, bytes, size) != 0) {
        return "damaged data";
    }
    if (apply) apply(out, count, stride);
    return NULL;
}

static const char *decode_indices(const char *mode, const char *filter,
                                  const uint8_t *bytes, size_t size, size_t count,
                                  size_t stride, uint8_t *out)
{
    const bool triangles = strcmp(mode, "TRIANGLES") == 0;
    if (strcmp(filter, "NONE") != 0) return "a filter where there are indices";
    if (stride != 2 && stride != 4) return "indices that have neither 2 nor 4 bytes";
    if (triangles && count % 3 != 0) return "triangles that are not whole";
    const int fault =
        triangles ? meshopt_decodeIndexBuffer(out, count, stride, bytes, size)
                  : meshopt_decodeIndexSequence(out, count, stride, bytes, size);
    return fault != 0 ? "damaged data" : NULL;
}

const char *pbnds_meshopt_decode(const char *mode, const char *filter,
                                 const uint8_t *bytes, size_t size, size_t count,
                                 size_t stride, uint8_t *out)
{
    if (strcmp(mode, "ATTRIBUTES") == 0) {
        return decode_attributes(filter, bytes, size, count, stride, out);
    }
    if (strcmp(mode, "TRIANGLES") == 0 || strcmp(mode, "INDICES") == 0) {
        return decode_indices(mode, filter, bytes, size, count, stride, out);
    }
    return "an unknown mode";
}
