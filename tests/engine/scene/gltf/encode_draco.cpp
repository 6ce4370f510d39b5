#include "tests/engine/scene/gltf/encode_draco.h"

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#endif
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <cstring>

namespace
{

draco::DataType type_of(int component)
{
    switch (component) {
    case 5120:
        return draco::DT_INT8;
    case 5121:
        return draco::DT_UINT8;
    case 5122:
        return draco::DT_INT16;
    case 5123:
        return draco::DT_UINT16;
    case 5125:
        return draco::DT_UINT32;
    default:
        return draco::DT_FLOAT32;
    }
}

void add_attribute(draco::Mesh &mesh, const encode_mesh &source, int i)
{
    static const draco::GeometryAttribute::Type kinds[] = {
        draco::GeometryAttribute::POSITION, draco::GeometryAttribute::NORMAL,
        draco::GeometryAttribute::COLOR, draco::GeometryAttribute::TEX_COORD,
        draco::GeometryAttribute::GENERIC};
    const encode_attribute &a = source.attributes[i];
    const draco::DataType type = type_of(a.component);
    const int stride = a.width * draco::DataTypeLength(type);
    draco::GeometryAttribute g;
    g.Init(kinds[a.kind], nullptr, static_cast<uint8_t>(a.width), type, a.normalized,
           stride, 0);
    const int id = mesh.AddAttribute(g, true, static_cast<uint32_t>(source.points));
    const char *bytes = static_cast<const char *>(a.data);
    for (size_t p = 0; p < source.points; ++p) {
        mesh.attribute(id)->SetAttributeValue(
            draco::AttributeValueIndex(static_cast<uint32_t>(p)),
            bytes + p * static_cast<size_t>(stride));
    }
    mesh.attribute(id)->set_unique_id(static_cast<uint32_t>(10 + i));
}

} // namespace

extern "C" size_t encode_draco(const struct encode_mesh *source, bool edgebreaker,
                               uint8_t *out, size_t room)
{
    draco::Mesh mesh;
    mesh.set_num_points(static_cast<uint32_t>(source->points));
    mesh.SetNumFaces(source->faces);
    for (uint32_t f = 0; f < source->faces; ++f) {
        draco::Mesh::Face face;
        for (uint32_t k = 0; k < 3; ++k)
            face[k] = draco::PointIndex(source->index[3 * f + k]);
        mesh.SetFace(draco::FaceIndex(f), face);
    }
    for (int i = 0; i < source->attribute_count; ++i)
        add_attribute(mesh, *source, i);
    if (edgebreaker) mesh.DeduplicateAttributeValues();
    draco::ExpertEncoder encoder(mesh);
    encoder.SetEncodingMethod(edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING
                                          : draco::MESH_SEQUENTIAL_ENCODING);
    for (int i = 0; i < source->attribute_count; ++i) {
        if (source->attributes[i].bits)
            encoder.SetAttributeQuantization(i, source->attributes[i].bits);
    }
    draco::EncoderBuffer buffer;
    if (!encoder.EncodeToBuffer(&buffer).ok() || buffer.size() > room) return 0;
    std::memcpy(out, buffer.data(), buffer.size());
    return buffer.size();
}
