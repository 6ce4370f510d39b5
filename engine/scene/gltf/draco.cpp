#include "engine/scene/gltf/draco.h"

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#endif
#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <cstring>
#include <exception>
#include <memory>
#include <new>

#include "engine/scene/gltf/shim.h"

struct pbnds_draco {
    draco::Mesh mesh;
};

namespace
{

/** What the data claim, and why they are refused. */
struct Guard {
    const pbnds_draco_limits *limits;
    uint64_t bytes = 0; /* claimed so far */
    pbnds_status status = PBNDS_OK;
    const char *fault = nullptr;

    bool refuse(pbnds_status why, const char *what)
    {
        status = why;
        fault = what;
        return false;
    }

    /** Memory for `count` things of `size` bytes: both below 2^40. */
    bool claim(uint64_t count, uint64_t size)
    {
        if (size && count > (limits->bytes - bytes) / size) {
            return refuse(PBNDS_ERROR_MEMORY,
                          "asks for more memory than is allowed (see --max-geometry)");
        }
        bytes += count * size;
        return true;
    }

    bool expect_triangles(uint64_t count)
    {
        return limits->triangles == UINT64_MAX || count == limits->triangles ||
               refuse(PBNDS_ERROR_FORMAT,
                      "has another number of indices than its accessor says");
    }

    bool expect_vertices(uint64_t count)
    {
        return limits->vertices == UINT64_MAX || count == limits->vertices ||
               refuse(PBNDS_ERROR_FORMAT,
                      "has another number of vertices than its accessors say");
    }
};

/** The library's two decoders with a look at the counts before it acts on them: its own
 * checks compare them with each other, but a few bytes may claim millions. */
template <class Base> class Guarded : public Base
{
  public:
    explicit Guarded(Guard &guard) : guard_(guard) {}

  protected:
    bool DecodeConnectivity() override { return weigh() && Base::DecodeConnectivity(); }

    /** All attributes are described by now, none is allocated. */
    bool DecodeAllAttributes() override
    {
        const uint64_t points = this->mesh()->num_points();
        if (!guard_.expect_vertices(points)) return false;
        for (int i = 0; i < this->mesh()->num_attributes(); ++i) {
            const draco::PointAttribute *a = this->mesh()->attribute(i);
            /* values, their integers before the last transform, corrections, map */
            const uint64_t size =
                static_cast<uint64_t>(a->byte_stride()) + 8u * a->num_components() + 8u;
            if (!guard_.claim(points, size)) return false;
        }
        return Base::DecodeAllAttributes();
    }

  private:
    bool weigh();
    Guard &guard_;
};

template <> bool Guarded<draco::MeshSequentialDecoder>::weigh()
{
    draco::DecoderBuffer ahead = *this->buffer();
    uint32_t faces = 0, points = 0;
    if (!draco::DecodeVarint(&faces, &ahead) || !draco::DecodeVarint(&points, &ahead))
        return false;
    return guard_.expect_triangles(faces) && guard_.expect_vertices(points) &&
           guard_.claim(faces, 6 * sizeof(uint32_t));
}

template <> bool Guarded<draco::MeshEdgebreakerDecoder>::weigh()
{
    draco::DecoderBuffer ahead = *this->buffer();
    uint8_t seams = 0;
    uint32_t vertices = 0, faces = 0, symbols = 0, splits = 0;
    if (!draco::DecodeVarint(&vertices, &ahead) ||
        !draco::DecodeVarint(&faces, &ahead) || !ahead.Decode(&seams) ||
        !draco::DecodeVarint(&symbols, &ahead) ||
        !draco::DecodeVarint(&splits, &ahead)) {
        return false;
    }
    /* Corner table: opposite, vertex and face of each corner, a corner of each vertex;
     * flags and stacks beside. Seams: another vertex and edge of each corner, and maps
     * from vertices. */
    const uint64_t corners = 3 * static_cast<uint64_t>(faces);
    const uint64_t all = static_cast<uint64_t>(vertices) + splits;
    return guard_.expect_triangles(faces) && guard_.claim(corners, 24) &&
           guard_.claim(all, 24) && guard_.claim(corners, 16u * seams) &&
           guard_.claim(all, 16u * seams);
}

/** Bytes of the header: "DRACO", version, kind, method, flags. */
constexpr size_t header_size = 11;

std::unique_ptr<draco::MeshDecoder> make_decoder(uint8_t method, Guard &guard)
{
    if (method == draco::MESH_SEQUENTIAL_ENCODING) {
        return std::unique_ptr<draco::MeshDecoder>(
            new Guarded<draco::MeshSequentialDecoder>(guard));
    }
    if (method == draco::MESH_EDGEBREAKER_ENCODING) {
        return std::unique_ptr<draco::MeshDecoder>(
            new Guarded<draco::MeshEdgebreakerDecoder>(guard));
    }
    return nullptr;
}

pbnds_status fail(const char *name, pbnds_status status, const char *fault,
                  pbnds_error *error)
{
    return pbnds_fail(error, status, "%s: a Draco mesh %s", name, fault);
}

pbnds_status decode(const uint8_t *bytes, size_t size, const char *name,
                    const pbnds_draco_limits *limits, pbnds_draco **mesh,
                    pbnds_error *error)
{
    if (size < header_size || std::memcmp(bytes, "DRACO", 5) != 0) {
        return fail(name, PBNDS_ERROR_FORMAT, "is damaged", error);
    }
    if (bytes[5] != 2 || bytes[6] != 2 || bytes[7] != draco::TRIANGULAR_MESH) {
        return fail(name, PBNDS_ERROR_UNSUPPORTED,
                    "is not a triangle mesh of bit stream version 2.2", error);
    }
    Guard guard{limits};
    const std::unique_ptr<draco::MeshDecoder> decoder = make_decoder(bytes[8], guard);
    if (!decoder) return fail(name, PBNDS_ERROR_FORMAT, "is damaged", error);
    std::unique_ptr<pbnds_draco> result(new pbnds_draco);
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char *>(bytes), size);
    const draco::DecoderOptions options;
    if (!decoder->Decode(options, &buffer, &result->mesh).ok()) {
        return guard.fault ? fail(name, guard.status, guard.fault, error)
                           : fail(name, PBNDS_ERROR_FORMAT, "is damaged", error);
    }
    *mesh = result.release();
    return PBNDS_OK;
}

template <class T> bool copy_indices(const draco::Mesh &mesh, void *out)
{
    T *to = static_cast<T *>(out);
    for (uint32_t i = 0; i < mesh.num_faces(); ++i) {
        const draco::Mesh::Face &face = mesh.face(draco::FaceIndex(i));
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t index = face[k].value();
            const T narrow = static_cast<T>(index);
            if (narrow != index || index >= mesh.num_points()) return false;
            std::memcpy(to++, &narrow, sizeof narrow);
        }
    }
    return true;
}

template <class T>
bool copy_values(const draco::PointAttribute &a, uint32_t points, int width, void *out)
{
    T *to = static_cast<T *>(out);
    for (uint32_t i = 0; i < points; ++i) {
        const draco::AttributeValueIndex value = a.mapped_index(draco::PointIndex(i));
        if (value.value() >= a.size()) return false;
        if (!a.ConvertValue<T>(value, static_cast<int8_t>(width), to)) return false;
        to += width;
    }
    return true;
}

/** Do all values lie in the attribute's buffer, and has it a place for every point? */
bool is_sound(const draco::PointAttribute &a, uint32_t points)
{
    if (!a.buffer() || a.byte_offset() < 0 || a.byte_stride() <= 0) return false;
    const uint64_t need = static_cast<uint64_t>(a.byte_offset()) +
                          static_cast<uint64_t>(a.byte_stride()) * a.size();
    if (need > a.buffer()->data_size()) return false;
    return a.is_mapping_identity() ? a.size() >= points
                                   : a.indices_map_size() >= points;
}

} // namespace

extern "C" enum pbnds_status pbnds_draco_decode(const uint8_t *bytes, size_t size,
                                                const char *name,
                                                const struct pbnds_draco_limits *limits,
                                                struct pbnds_draco **mesh,
                                                struct pbnds_error *error)
{
    *mesh = nullptr;
    try {
        return decode(bytes, size, name, limits, mesh, error);
    } catch (const std::bad_alloc &) {
        return fail(name, PBNDS_ERROR_MEMORY, "does not fit in memory", error);
    } catch (...) {
        return fail(name, PBNDS_ERROR_FORMAT, "is damaged", error);
    }
}

extern "C" void pbnds_draco_free(struct pbnds_draco *mesh)
{
    delete mesh;
}

extern "C" uint64_t pbnds_draco_triangles(const struct pbnds_draco *mesh)
{
    return mesh->mesh.num_faces();
}

extern "C" uint64_t pbnds_draco_vertices(const struct pbnds_draco *mesh)
{
    return mesh->mesh.num_points();
}

extern "C" bool pbnds_draco_indices(const struct pbnds_draco *mesh, size_t bytes,
                                    void *out)
{
    if (bytes == 1) return copy_indices<uint8_t>(mesh->mesh, out);
    if (bytes == 2) return copy_indices<uint16_t>(mesh->mesh, out);
    return bytes == 4 && copy_indices<uint32_t>(mesh->mesh, out);
}

extern "C" bool pbnds_draco_attribute(const struct pbnds_draco *mesh, int64_t id,
                                      int width, int component, void *out)
{
    if (id < 0 || id > UINT32_MAX) return false;
    const draco::PointAttribute *a =
        mesh->mesh.GetAttributeByUniqueId(static_cast<uint32_t>(id));
    const uint32_t points = mesh->mesh.num_points();
    if (!a || a->num_components() != width || !is_sound(*a, points)) return false;
    switch (component) {
    case PBNDS_GLTF_BYTE:
        return copy_values<int8_t>(*a, points, width, out);
    case PBNDS_GLTF_UBYTE:
        return copy_values<uint8_t>(*a, points, width, out);
    case PBNDS_GLTF_SHORT:
        return copy_values<int16_t>(*a, points, width, out);
    case PBNDS_GLTF_USHORT:
        return copy_values<uint16_t>(*a, points, width, out);
    case PBNDS_GLTF_UINT:
        return copy_values<uint32_t>(*a, points, width, out);
    case PBNDS_GLTF_FLOAT:
        return copy_values<float>(*a, points, width, out);
    default:
        return false;
    }
}
