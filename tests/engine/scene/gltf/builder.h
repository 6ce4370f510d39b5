/** Documents of glTF built from accessors, one bufferView each, around the square. */
#ifndef PBNDS_TESTS_SCENE_GLTF_BUILDER_H
#define PBNDS_TESTS_SCENE_GLTF_BUILDER_H

#include "tests/engine/scene/gltf/fixture.h"

enum { BYTE = 5120, UBYTE, SHORT, USHORT, UINT = 5125, FLOAT };

/** BIN chunk and the lists that describe it. */
struct builder {
    uint8_t bin[8192];
    size_t size;
    char views[4096], accessors[8192];
    int count;
};

static inline void append(char *list, size_t size, const char *text)
{
    assert_true(strlen(list) + strlen(text) + 1 < size);
    strcat(list, text);
}

/** An accessor of its own bufferView, which is data's `size` bytes. `more`: members such
 *  as ",\"normalized\":true". @return its index */
static inline int add(struct builder *b, const void *data, size_t size, int component,
                      const char *type, size_t count, const char *more)
{
    char text[600];
    b->size = (b->size + 3) / 4 * 4;
    assert_true(b->size + size <= sizeof b->bin);
    memcpy(b->bin + b->size, data, size);
    (void)snprintf(text, sizeof text,
                   "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}",
                   b->count ? "," : "", b->size, size);
    append(b->views, sizeof b->views, text);
    (void)snprintf(text, sizeof text,
                   "%s{\"bufferView\":%d,\"componentType\":%d,\"type\":\"%s\","
                   "\"count\":%zu%s}",
                   b->count ? "," : "", b->count, component, type, count, more);
    append(b->accessors, sizeof b->accessors, text);
    b->size += size;
    return b->count++;
}

/** Floats; `width` components an element. */
static inline int add_floats(struct builder *b, const float *data, size_t count,
                             int width)
{
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    return add(b, data, count * (size_t)width * sizeof *data, FLOAT,
               width == 16 ? "MAT4" : types[width], count, "");
}

/** The square: accessors 0 position, 1 normal, 2 uv, 3 indices. */
static inline struct builder build_square(void)
{
    struct builder b = {.size = 0};
    (void)add_floats(&b, square.position, 4, 3);
    (void)add_floats(&b, square.normal, 4, 3);
    (void)add_floats(&b, square.uv, 4, 2);
    (void)add(&b, square.index, sizeof square.index, USHORT, "SCALAR", 6, "");
    return b;
}

/** Loads a document of the accessors and `rest`, its other members. */
static inline enum pbnds_status load_built(const struct builder *b, const char *rest,
                                           const struct pbnds_gltf_options *options,
                                           struct pbnds_scene *scene)
{
    static char json[32768];
    const int n = snprintf(json, sizeof json,
                           "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{"
                           "\"byteLength\":%zu}],\"bufferViews\":[%s],"
                           "\"accessors\":[%s],%s}",
                           b->size, b->views, b->accessors, rest);
    assert_true(n > 0 && (size_t)n < sizeof json);
    return load_with(json, b->bin, (b->size + 3) / 4 * 4, options, scene);
}

static inline void must_build(const struct builder *b, const char *rest,
                              const struct pbnds_gltf_options *options,
                              struct pbnds_scene *scene)
{
    const enum pbnds_status status = load_built(b, rest, options, scene);
    if (status != PBNDS_OK) fail_msg("%d: %s", status, fault.message);
}

/** Options that pose the scene at `time`. */
static inline struct pbnds_gltf_options posed_at(double time)
{
    return (struct pbnds_gltf_options){.posed = true, .time = time};
}

#endif /* PBNDS_TESTS_SCENE_GLTF_BUILDER_H */
