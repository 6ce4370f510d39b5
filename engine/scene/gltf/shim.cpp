/* The library is Debian's shared libtinygltf: TINYGLTF_IMPLEMENTATION stays undefined.
 */
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#endif
#include <tiny_gltf.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include "engine/scene/gltf/shim.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <exception>
#include <memory>
#include <new>

namespace
{

/** The model and the C arrays that mirror it. */
struct Owner {
    tinygltf::Model model;
    std::string notes;
    std::vector<const char *> used, required;
    std::vector<pbnds_gltf_view> views;
    std::vector<pbnds_gltf_accessor> accessors;
    std::vector<std::vector<pbnds_gltf_primitive>> primitives;
    std::vector<pbnds_gltf_mesh> meshes;
    std::vector<pbnds_gltf_node> nodes;
    std::vector<pbnds_gltf_scene> scenes;
    std::vector<pbnds_gltf_animation> animations;
    std::vector<pbnds_gltf_light> lights;
    std::vector<pbnds_gltf_skin> skins;
    std::vector<pbnds_gltf_camera> cameras;
    std::vector<pbnds_gltf_material> materials;
    std::vector<pbnds_gltf_texture> textures;
    std::vector<pbnds_gltf_sampler> samplers;
    std::vector<pbnds_gltf_image> images;
    std::vector<pbnds_gltf_draco> dracos;
    std::vector<const char *> variants;
    /* deques: what they hold is pointed to while they grow */
    std::deque<std::vector<pbnds_gltf_mapping>> mappings;
    std::deque<std::vector<int>> mapped_variants;
    std::deque<std::vector<pbnds_gltf_target>> targets;
    std::deque<std::vector<pbnds_gltf_influence>> influences;
    std::deque<std::vector<pbnds_gltf_channel>> channels;
    std::deque<std::vector<pbnds_gltf_animation_sampler>> animation_samplers;
};

/* tinygltf gets no file and no pixels from us: it would look for them in the current
 * folder too, stops at odd MIME types, and reads a buffer view of an image unchecked.
 */
bool no_file(const std::string &, void *)
{
    return false;
}
std::string same_path(const std::string &path, void *)
{
    return path;
}
bool no_read(std::vector<unsigned char> *, std::string *, const std::string &, void *)
{
    return false;
}
bool no_write(std::string *, const std::string &, const std::vector<unsigned char> &,
              void *)
{
    return false;
}
bool leave_image(tinygltf::Image *, const int, std::string *, std::string *, int, int,
                 const unsigned char *, int, void *)
{
    return true;
}

void put_u32(std::vector<unsigned char> &out, uint32_t x)
{
    for (int shift = 0; shift < 32; shift += 8) {
        out.push_back(static_cast<unsigned char>(x >> shift));
    }
}

/** A GLB of this JSON and four bytes of BIN: each buffer of the text is one byte long
 * by now and finds it there. */
std::vector<unsigned char> wrap(const char *json, size_t size)
{
    const size_t padded = (size + 3) & ~size_t{3};
    std::vector<unsigned char> out;
    out.reserve(padded + 32);
    put_u32(out, 0x46546c67u); /* "glTF" */
    put_u32(out, 2);
    put_u32(out, static_cast<uint32_t>(padded + 32));
    put_u32(out, static_cast<uint32_t>(padded));
    put_u32(out, 0x4e4f534au); /* "JSON" */
    out.insert(out.end(), json, json + size);
    out.resize(20 + padded, ' ');
    put_u32(out, 4);
    put_u32(out, 0x004e4942u); /* "BIN" */
    put_u32(out, 0);
    return out;
}

/** The first line of what tinygltf says, printable and short enough for a sentence. */
std::string first_line(const std::string &text)
{
    std::string line;
    for (const char c : text) {
        if (c == '\n' || line.size() == 300) break;
        line.push_back(c >= 32 && c < 127 ? c : '?');
    }
    while (!line.empty() && (line.back() == '.' || line.back() == ' '))
        line.pop_back();
    return line.empty() ? "no reason given" : line;
}

/** Lines that matter: a skin without inverseBindMatrices is valid, tinygltf says else.
 */
std::string remarks(const std::string &text)
{
    size_t start = 0;
    while (start < text.size()) {
        const size_t end = std::min(text.find('\n', start), text.size());
        const std::string line = text.substr(start, end - start);
        if (!line.empty() && line.find("inverseBindMatrices") == std::string::npos) {
            return first_line(line);
        }
        start = end + 1;
    }
    return "";
}

/** An extension's object, or null. */
const tinygltf::Value *extension(const tinygltf::ExtensionMap &extensions,
                                 const char *name)
{
    const auto found = extensions.find(name);
    return found != extensions.end() && found->second.IsObject() ? &found->second
                                                                 : nullptr;
}

double number(const tinygltf::Value &object, const char *member, double otherwise)
{
    if (!object.Has(member)) return otherwise;
    const tinygltf::Value &value = object.Get(member);
    return value.IsNumber() ? value.GetNumberAsDouble() : otherwise;
}

/** An index in an extension, which the scan of the text did not see: -1 when it is not
 *  there, one that nothing has when it is no index. */
int64_t extension_index(const tinygltf::Value &object, const char *member)
{
    if (!object.Has(member)) return -1;
    const tinygltf::Value &value = object.Get(member);
    return value.IsInt() && value.GetNumberAsInt() >= 0 ? value.GetNumberAsInt()
                                                        : INT64_MAX;
}

/** An unsigned integer below 2^53, -1 for anything that is none. */
int64_t whole(const tinygltf::Value &object, const char *member, int64_t otherwise)
{
    if (!object.Has(member)) return otherwise;
    const tinygltf::Value &value = object.Get(member);
    const double x = value.IsNumber() ? value.GetNumberAsDouble() : -1.0;
    return x >= 0.0 && x < 9007199254740992.0 && x == std::floor(x)
               ? static_cast<int64_t>(x)
               : -1;
}

const char *text(const tinygltf::Value &object, const char *member,
                 const char *otherwise)
{
    if (!object.Has(member)) return otherwise;
    const tinygltf::Value &value = object.Get(member);
    return value.IsString() ? value.Get<std::string>().c_str() : otherwise;
}

/** The first `count` numbers of an array; what is missing stays as it is. */
void numbers(const tinygltf::Value &object, const char *member, double *out,
             size_t count)
{
    if (!object.Has(member) || !object.Get(member).IsArray()) return;
    const tinygltf::Value &list = object.Get(member);
    for (size_t i = 0; i < count && i < list.ArrayLen(); ++i) {
        const tinygltf::Value &value = list.Get(static_cast<int>(i));
        if (value.IsNumber()) out[i] = value.GetNumberAsDouble();
    }
}

int64_t attribute(const std::map<std::string, int> &attributes, const std::string &name)
{
    const auto found = attributes.find(name);
    return found == attributes.end() ? -1 : found->second;
}

int width_of(int type)
{
    switch (type) {
    case TINYGLTF_TYPE_SCALAR:
        return 1;
    case TINYGLTF_TYPE_VEC2:
        return 2;
    case TINYGLTF_TYPE_VEC3:
        return 3;
    case TINYGLTF_TYPE_VEC4:
        return 4;
    case TINYGLTF_TYPE_MAT4:
        return 16;
    default:
        return 0;
    }
}

pbnds_gltf_meshopt meshopt_of(const tinygltf::BufferView &v)
{
    pbnds_gltf_meshopt c{};
    const tinygltf::Value *e = extension(v.extensions, "EXT_meshopt_compression");
    if (!e) return c;
    c.present = true;
    c.buffer = extension_index(*e, "buffer");
    c.offset = whole(*e, "byteOffset", 0);
    c.length = whole(*e, "byteLength", -1);
    c.stride = whole(*e, "byteStride", -1);
    c.count = whole(*e, "count", -1);
    c.mode = text(*e, "mode", "");
    c.filter = text(*e, "filter", "NONE");
    return c;
}

void copy_data(Owner &o)
{
    for (const auto &v : o.model.bufferViews) {
        o.views.push_back({v.buffer, v.byteOffset, v.byteLength, v.byteStride,
                           meshopt_of(v), nullptr});
    }
    for (const auto &a : o.model.accessors) {
        pbnds_gltf_accessor c{};
        c.view = a.bufferView;
        c.offset = a.byteOffset;
        c.count = a.count;
        c.component = a.componentType;
        c.width = width_of(a.type);
        c.normalized = a.normalized;
        c.draco_id = -1;
        c.sparse = a.sparse.isSparse;
        if (c.sparse) { /* unset otherwise */
            c.sparse_count = a.sparse.count;
            c.sparse_index_view = a.sparse.indices.bufferView;
            c.sparse_index_offset = a.sparse.indices.byteOffset;
            c.sparse_index_component = a.sparse.indices.componentType;
            c.sparse_value_view = a.sparse.values.bufferView;
            c.sparse_value_offset = a.sparse.values.byteOffset;
        }
        o.accessors.push_back(c);
    }
}

/** A copy of an accessor that only a compressed mesh fills. */
int unpacked_accessor(Owner &o, int index, int64_t draco_id)
{
    pbnds_gltf_accessor c = o.accessors[static_cast<size_t>(index)];
    c.view = -1;
    c.offset = 0;
    c.sparse = false;
    c.draco_id = draco_id;
    o.accessors.push_back(c);
    return static_cast<int>(o.accessors.size() - 1);
}

/** An index accessor for a compressed mesh, whether the file names one or not. */
int unpacked_indices(Owner &o, int index)
{
    if (index >= 0) return unpacked_accessor(o, index, -1);
    pbnds_gltf_accessor c{};
    c.view = c.draco_id = -1;
    c.component = PBNDS_GLTF_UINT;
    c.width = 1;
    o.accessors.push_back(c);
    return static_cast<int>(o.accessors.size() - 1);
}

/** Points a primitive at what its compressed data hold: from here on it is like any
 * other, a list of triangles. Dangling indices stay, and are told of later. */
void take_draco(Owner &o, int64_t mesh, tinygltf::Primitive &p)
{
    const tinygltf::Value *e = extension(p.extensions, "KHR_draco_mesh_compression");
    const int named = static_cast<int>(o.model.accessors.size());
    if (!e || !e->Has("attributes") || !e->Get("attributes").IsObject()) return;
    if ((p.mode != 4 && p.mode != 5) || p.indices >= named) return;
    pbnds_gltf_draco c{};
    c.mesh = mesh;
    c.view = extension_index(*e, "bufferView");
    c.counted = p.mode == 4 && p.indices >= 0;
    c.first = o.accessors.size();
    p.indices = unpacked_indices(o, p.indices);
    p.mode = 4;
    const tinygltf::Value &attributes = e->Get("attributes");
    for (auto &a : p.attributes) {
        if (!attributes.Has(a.first) || a.second < 0 || a.second >= named) continue;
        a.second = unpacked_accessor(o, a.second,
                                     extension_index(attributes, a.first.c_str()));
    }
    c.count = o.accessors.size() - c.first;
    o.dracos.push_back(c);
}

/** KHR_materials_variants of a primitive. */
void take_mappings(Owner &o, const tinygltf::Primitive &p, pbnds_gltf_primitive &c)
{
    const tinygltf::Value *e = extension(p.extensions, "KHR_materials_variants");
    if (!e || !e->Has("mappings") || !e->Get("mappings").IsArray()) return;
    std::vector<pbnds_gltf_mapping> list;
    const tinygltf::Value &mappings = e->Get("mappings");
    for (size_t i = 0; i < mappings.ArrayLen(); ++i) {
        const tinygltf::Value &m = mappings.Get(static_cast<int>(i));
        if (!m.IsObject() || !m.Has("variants") || !m.Get("variants").IsArray())
            continue;
        std::vector<int> variants;
        for (size_t k = 0; k < m.Get("variants").ArrayLen(); ++k) {
            const tinygltf::Value &v = m.Get("variants").Get(static_cast<int>(k));
            variants.push_back(v.IsInt() ? v.GetNumberAsInt() : -1);
        }
        o.mapped_variants.push_back(std::move(variants));
        const auto &kept = o.mapped_variants.back();
        list.push_back({extension_index(m, "material"), kept.data(), kept.size()});
    }
    o.mappings.push_back(std::move(list));
    c.mappings = o.mappings.back().data();
    c.mapping_count = o.mappings.back().size();
}

pbnds_gltf_primitive primitive_of(Owner &o, const tinygltf::Primitive &p)
{
    pbnds_gltf_primitive c{};
    c.position = attribute(p.attributes, "POSITION");
    c.normal = attribute(p.attributes, "NORMAL");
    c.tangent = attribute(p.attributes, "TANGENT");
    c.uv[0] = attribute(p.attributes, "TEXCOORD_0");
    c.uv[1] = attribute(p.attributes, "TEXCOORD_1");
    c.color = attribute(p.attributes, "COLOR_0");
    c.indices = p.indices;
    c.material = p.material;
    c.mode = p.mode;
    std::vector<pbnds_gltf_target> targets;
    for (const auto &t : p.targets) {
        targets.push_back({attribute(t, "POSITION"), attribute(t, "NORMAL"),
                           attribute(t, "TANGENT")});
    }
    std::vector<pbnds_gltf_influence> influences;
    for (;;) {
        const std::string n = std::to_string(influences.size());
        const pbnds_gltf_influence i{attribute(p.attributes, "JOINTS_" + n),
                                     attribute(p.attributes, "WEIGHTS_" + n)};
        if (i.joints < 0 || i.weights < 0) break;
        influences.push_back(i);
    }
    o.targets.push_back(std::move(targets));
    o.influences.push_back(std::move(influences));
    c.targets = o.targets.back().data();
    c.target_count = o.targets.back().size();
    c.influences = o.influences.back().data();
    c.influence_count = o.influences.back().size();
    return c;
}

void copy_meshes(Owner &o)
{
    for (auto &m : o.model.meshes) {
        std::vector<pbnds_gltf_primitive> list;
        for (auto &p : m.primitives) {
            /* Renamed by the scan: see gltf/scan.c. */
            if (p.extras.IsInt()) p.indices = p.extras.GetNumberAsInt();
            take_draco(o, static_cast<int64_t>(o.meshes.size()), p);
            list.push_back(primitive_of(o, p));
            take_mappings(o, p, list.back());
        }
        o.primitives.push_back(std::move(list));
        const auto &kept = o.primitives.back();
        o.meshes.push_back({m.name.c_str(), kept.data(), kept.size(), m.weights.data(),
                            m.weights.size()});
    }
}

pbnds_gltf_instancing instancing_of(const tinygltf::Node &n)
{
    pbnds_gltf_instancing c{false, -1, -1, -1};
    const tinygltf::Value *e = extension(n.extensions, "EXT_mesh_gpu_instancing");
    if (!e || !e->Has("attributes")) return c;
    const tinygltf::Value &attributes = e->Get("attributes");
    c.present = true;
    c.translation = extension_index(attributes, "TRANSLATION");
    c.rotation = extension_index(attributes, "ROTATION");
    c.scale = extension_index(attributes, "SCALE");
    return c;
}

void copy_nodes(Owner &o)
{
    for (const auto &n : o.model.nodes) {
        pbnds_gltf_node c{};
        c.name = n.name.c_str();
        c.mesh = n.mesh;
        c.skin = n.skin;
        c.camera = n.camera;
        c.light = -1;
        const tinygltf::Value *light = extension(n.extensions, "KHR_lights_punctual");
        if (light) c.light = extension_index(*light, "light");
        c.children = n.children.data();
        c.child_count = n.children.size();
        c.matrix = n.matrix.data();
        c.matrix_count = n.matrix.size();
        c.translation = n.translation.data();
        c.translation_count = n.translation.size();
        c.rotation = n.rotation.data();
        c.rotation_count = n.rotation.size();
        c.scale = n.scale.data();
        c.scale_count = n.scale.size();
        c.weights = n.weights.data();
        c.weight_count = n.weights.size();
        c.instancing = instancing_of(n);
        o.nodes.push_back(c);
    }
    for (const auto &s : o.model.scenes) {
        o.scenes.push_back({s.name.c_str(), {s.nodes.data(), s.nodes.size()}});
    }
    for (const auto &s : o.model.skins) {
        o.skins.push_back({s.name.c_str(),
                           {s.joints.data(), s.joints.size()},
                           s.inverseBindMatrices});
    }
    for (const auto &c : o.model.cameras) {
        o.cameras.push_back({c.name.c_str(), c.type == "orthographic",
                             c.perspective.yfov, c.orthographic.ymag});
    }
}

void copy_lights(Owner &o)
{
    for (const auto &l : o.model.lights) {
        pbnds_gltf_light c{};
        c.name = l.name.c_str();
        c.type = l.type.c_str();
        for (size_t i = 0; i < 3; ++i)
            c.color[i] = i < l.color.size() ? l.color[i] : 1.0;
        c.intensity = l.intensity;
        c.range = l.range;
        c.inner = l.spot.innerConeAngle;
        c.outer = l.spot.outerConeAngle;
        o.lights.push_back(c);
    }
}

pbnds_gltf_path path_of(const std::string &path)
{
    if (path == "translation") return PBNDS_GLTF_TRANSLATION;
    if (path == "rotation") return PBNDS_GLTF_ROTATION;
    if (path == "scale") return PBNDS_GLTF_SCALE;
    return path == "weights" ? PBNDS_GLTF_WEIGHTS : PBNDS_GLTF_OTHER_PATH;
}

pbnds_gltf_interpolation interpolation_of(const std::string &name)
{
    if (name == "LINEAR") return PBNDS_GLTF_LINEAR;
    if (name == "STEP") return PBNDS_GLTF_STEP;
    return name == "CUBICSPLINE" ? PBNDS_GLTF_CUBICSPLINE
                                 : PBNDS_GLTF_OTHER_INTERPOLATION;
}

void copy_animations(Owner &o)
{
    for (const auto &a : o.model.animations) {
        std::vector<pbnds_gltf_channel> channels;
        for (const auto &c : a.channels) {
            channels.push_back({c.sampler, c.target_node, path_of(c.target_path)});
        }
        std::vector<pbnds_gltf_animation_sampler> samplers;
        for (const auto &s : a.samplers) {
            samplers.push_back({s.input, s.output, interpolation_of(s.interpolation)});
        }
        o.channels.push_back(std::move(channels));
        o.animation_samplers.push_back(std::move(samplers));
        o.animations.push_back({a.name.c_str(), o.channels.back().data(),
                                o.animation_samplers.back().data(),
                                o.channels.back().size(),
                                o.animation_samplers.back().size()});
    }
}

pbnds_gltf_texture_info no_texture()
{
    return {-1, 0, false, {0.0, 0.0}, 0.0, {1.0, 1.0}};
}

/** `transform`: what KHR_texture_transform says, or null. */
pbnds_gltf_texture_info texture_info(int64_t index, int64_t texcoord,
                                     const tinygltf::Value *transform)
{
    pbnds_gltf_texture_info c = no_texture();
    c.index = index;
    c.texcoord = texcoord;
    if (!transform) return c;
    c.transformed = true;
    c.texcoord = whole(*transform, "texCoord", texcoord);
    c.rotation = number(*transform, "rotation", 0.0);
    numbers(*transform, "offset", c.offset, 2);
    numbers(*transform, "scale", c.scale, 2);
    return c;
}

/** Any of tinygltf's three kinds of texture info. */
template <class Info> pbnds_gltf_texture_info texture_of(const Info &info)
{
    return texture_info(info.index, info.texCoord,
                        extension(info.extensions, "KHR_texture_transform"));
}

/** A texture info inside of an extension. */
pbnds_gltf_texture_info texture_of(const tinygltf::Value &object, const char *member)
{
    if (!object.Has(member) || !object.Get(member).IsObject()) return no_texture();
    const tinygltf::Value &info = object.Get(member);
    const tinygltf::Value *transform = nullptr;
    if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform")) {
        transform = &info.Get("extensions").Get("KHR_texture_transform");
    }
    return texture_info(extension_index(info, "index"), whole(info, "texCoord", 0),
                        transform);
}

void take_specular(const tinygltf::Value &e, pbnds_gltf_material &c)
{
    c.specular = number(e, "specularFactor", 1.0);
    numbers(e, "specularColorFactor", c.specular_color, 3);
    c.specular_texture = texture_of(e, "specularTexture");
    c.specular_color_texture = texture_of(e, "specularColorTexture");
}

void take_specular_glossiness(const tinygltf::Value &e, pbnds_gltf_material &c)
{
    c.specular_glossiness = true;
    c.metallic = 0.0;
    c.roughness = 1.0 - number(e, "glossinessFactor", 1.0);
    c.specular = 1.0;
    std::fill_n(c.base_color, 4, 1.0);
    std::fill_n(c.specular_color, 3, 1.0);
    numbers(e, "diffuseFactor", c.base_color, 4);
    numbers(e, "specularFactor", c.specular_color, 3);
    c.base_color_texture = texture_of(e, "diffuseTexture");
    c.specular_color_texture = texture_of(e, "specularGlossinessTexture");
    c.metallic_roughness_texture = c.specular_texture = no_texture();
}

void take_extensions(const tinygltf::ExtensionMap &extensions, pbnds_gltf_material &c)
{
    c.emissive_strength = 1.0;
    c.ior = 1.5;
    if (const auto *e = extension(extensions, "KHR_materials_emissive_strength")) {
        c.emissive_strength = number(*e, "emissiveStrength", 1.0);
    }
    if (const auto *e = extension(extensions, "KHR_materials_ior")) {
        c.ior = number(*e, "ior", 1.5);
    }
    if (const auto *e = extension(extensions, "KHR_materials_specular")) {
        take_specular(*e, c);
    }
    c.unlit = extension(extensions, "KHR_materials_unlit") != nullptr;
    /* What is unlit shows the base colour of the core. */
    const auto *old = extension(extensions, "KHR_materials_pbrSpecularGlossiness");
    if (old && !c.unlit) take_specular_glossiness(*old, c);
}

pbnds_gltf_material material_of(const tinygltf::Material &m)
{
    const auto &pbr = m.pbrMetallicRoughness;
    pbnds_gltf_material c{};
    c.name = m.name.c_str();
    c.alpha_mode = m.alphaMode.c_str();
    for (size_t i = 0; i < 4; ++i) {
        c.base_color[i] = i < pbr.baseColorFactor.size() ? pbr.baseColorFactor[i] : 1.0;
    }
    for (size_t i = 0; i < 3; ++i) {
        c.emissive[i] = i < m.emissiveFactor.size() ? m.emissiveFactor[i] : 0.0;
    }
    c.metallic = pbr.metallicFactor;
    c.roughness = pbr.roughnessFactor;
    c.normal_scale = m.normalTexture.scale;
    c.occlusion_strength = m.occlusionTexture.strength;
    c.alpha_cutoff = m.alphaCutoff;
    c.double_sided = m.doubleSided;
    c.specular = 1.0;
    std::fill_n(c.specular_color, 3, 1.0);
    c.base_color_texture = texture_of(pbr.baseColorTexture);
    c.metallic_roughness_texture = texture_of(pbr.metallicRoughnessTexture);
    c.normal_texture = texture_of(m.normalTexture);
    c.emissive_texture = texture_of(m.emissiveTexture);
    c.occlusion_texture = texture_of(m.occlusionTexture);
    c.specular_texture = c.specular_color_texture = no_texture();
    take_extensions(m.extensions, c);
    return c;
}

/** EXT_texture_webp names the image that every renderer with WebP should take. */
pbnds_gltf_texture texture_of(const tinygltf::Texture &t)
{
    const tinygltf::Value *webp = extension(t.extensions, "EXT_texture_webp");
    if (!webp || !webp->Has("source")) return {t.sampler, t.source, -1};
    return {t.sampler, extension_index(*webp, "source"), t.source};
}

void copy_variants(Owner &o)
{
    const auto *root = extension(o.model.extensions, "KHR_materials_variants");
    if (!root || !root->Has("variants") || !root->Get("variants").IsArray()) return;
    const tinygltf::Value &list = root->Get("variants");
    for (size_t i = 0; i < list.ArrayLen(); ++i) {
        const tinygltf::Value &v = list.Get(static_cast<int>(i));
        o.variants.push_back(v.IsObject() ? text(v, "name", "") : "");
    }
}

void copy_looks(Owner &o)
{
    for (const auto &m : o.model.materials)
        o.materials.push_back(material_of(m));
    for (const auto &t : o.model.textures)
        o.textures.push_back(texture_of(t));
    for (const auto &s : o.model.samplers) {
        o.samplers.push_back({s.magFilter, s.wrapS, s.wrapT});
    }
    for (const auto &i : o.model.images)
        o.images.push_back({i.bufferView, i.mimeType.c_str()});
    copy_variants(o);
    for (const auto &e : o.model.extensionsUsed)
        o.used.push_back(e.c_str());
    for (const auto &e : o.model.extensionsRequired)
        o.required.push_back(e.c_str());
}

void fill(Owner &o, pbnds_gltf_document *d)
{
    d->version = o.model.asset.version.c_str();
    d->min_version = o.model.asset.minVersion.c_str();
    d->extensions_used = o.used.data();
    d->extensions_used_count = o.used.size();
    d->extensions_required = o.required.data();
    d->extensions_required_count = o.required.size();
    d->views = o.views.data();
    d->view_count = o.views.size();
    d->accessors = o.accessors.data();
    d->accessor_count = o.accessors.size();
    d->meshes = o.meshes.data();
    d->mesh_count = o.meshes.size();
    d->nodes = o.nodes.data();
    d->node_count = o.nodes.size();
    d->scenes = o.scenes.data();
    d->scene_count = o.scenes.size();
    d->skins = o.skins.data();
    d->skin_count = o.skins.size();
    d->cameras = o.cameras.data();
    d->camera_count = o.cameras.size();
    d->materials = o.materials.data();
    d->material_count = o.materials.size();
    d->textures = o.textures.data();
    d->texture_count = o.textures.size();
    d->samplers = o.samplers.data();
    d->sampler_count = o.samplers.size();
    d->images = o.images.data();
    d->image_count = o.images.size();
    d->dracos = o.dracos.data();
    d->draco_count = o.dracos.size();
    d->variants = o.variants.data();
    d->variant_count = o.variants.size();
    d->buffer_count = o.model.buffers.size();
    d->animations = o.animations.data();
    d->animation_count = o.animations.size();
    d->lights = o.lights.data();
    d->light_count = o.lights.size();
    d->scene = o.model.defaultScene;
    d->notes = o.notes.c_str();
    d->owner = &o;
}

enum pbnds_status parse(const char *json, size_t size, const char *name,
                        pbnds_gltf_document *document, pbnds_error *error)
{
    std::unique_ptr<Owner> owner(new Owner);
    const std::vector<unsigned char> glb = wrap(json, size);
    tinygltf::TinyGLTF loader;
    loader.SetImageLoader(leave_image, nullptr);
    loader.SetFsCallbacks({no_file, same_path, no_read, no_write, nullptr});
    std::string fault, warnings;
    if (!loader.LoadBinaryFromMemory(&owner->model, &fault, &warnings, glb.data(),
                                     static_cast<unsigned int>(glb.size()))) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not valid glTF: %s", name,
                          first_line(fault).c_str());
    }
    owner->notes = remarks(fault);
    copy_data(*owner);
    copy_meshes(*owner);
    copy_nodes(*owner);
    copy_lights(*owner);
    copy_animations(*owner);
    copy_looks(*owner);
    fill(*owner, document);
    (void)owner.release(); /* now document->owner's */
    return PBNDS_OK;
}

} // namespace

extern "C" enum pbnds_status pbnds_gltf_parse(const char *json, size_t size,
                                              const char *name,
                                              struct pbnds_gltf_document *document,
                                              struct pbnds_error *error)
{
    *document = {};
    if (size > 0x40000000u) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "%s: its JSON is larger than 1 GiB", name);
    }
    try {
        return parse(json, size, name, document, error);
    } catch (const std::bad_alloc &) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory to parse it", name);
    } catch (const std::exception &e) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: is not valid glTF: %s", name,
                          first_line(e.what()).c_str());
    }
}

extern "C" void pbnds_gltf_document_free(struct pbnds_gltf_document *document)
{
    delete static_cast<Owner *>(document->owner);
    *document = {};
}
