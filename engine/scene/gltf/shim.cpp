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
    std::vector<pbnds_gltf_list> scenes;
    std::vector<pbnds_gltf_skin> skins;
    std::vector<pbnds_gltf_camera> cameras;
    std::vector<pbnds_gltf_material> materials;
    std::vector<pbnds_gltf_texture> textures;
    std::vector<pbnds_gltf_sampler> samplers;
    std::vector<int64_t> image_views;
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

int64_t attribute(const tinygltf::Primitive &p, const char *name)
{
    const auto found = p.attributes.find(name);
    return found == p.attributes.end() ? -1 : found->second;
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

void copy_data(Owner &o)
{
    for (const auto &v : o.model.bufferViews) {
        o.views.push_back({v.buffer, v.byteOffset, v.byteLength, v.byteStride});
    }
    for (const auto &a : o.model.accessors) {
        pbnds_gltf_accessor c{};
        c.view = a.bufferView;
        c.offset = a.byteOffset;
        c.count = a.count;
        c.component = a.componentType;
        c.width = width_of(a.type);
        c.normalized = a.normalized;
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

pbnds_gltf_primitive primitive_of(const tinygltf::Primitive &p)
{
    pbnds_gltf_primitive c{};
    c.position = attribute(p, "POSITION");
    c.normal = attribute(p, "NORMAL");
    c.tangent = attribute(p, "TANGENT");
    c.uv[0] = attribute(p, "TEXCOORD_0");
    c.uv[1] = attribute(p, "TEXCOORD_1");
    c.color = attribute(p, "COLOR_0");
    c.joints = attribute(p, "JOINTS_0");
    c.weights = attribute(p, "WEIGHTS_0");
    /* Renamed by the scan: see gltf/scan.c. */
    c.indices = p.extras.IsInt() ? p.extras.GetNumberAsInt() : p.indices;
    c.material = p.material;
    c.mode = p.mode;
    c.more_joints = attribute(p, "JOINTS_1") >= 0;
    c.morphed = !p.targets.empty();
    return c;
}

void copy_graph(Owner &o)
{
    for (const auto &m : o.model.meshes) {
        std::vector<pbnds_gltf_primitive> list;
        for (const auto &p : m.primitives)
            list.push_back(primitive_of(p));
        o.primitives.push_back(std::move(list));
        const auto &kept = o.primitives.back();
        o.meshes.push_back({m.name.c_str(), kept.data(), kept.size()});
    }
    for (const auto &n : o.model.nodes) {
        pbnds_gltf_node c{};
        c.name = n.name.c_str();
        c.mesh = n.mesh;
        c.skin = n.skin;
        c.camera = n.camera;
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
        o.nodes.push_back(c);
    }
    for (const auto &s : o.model.scenes) {
        o.scenes.push_back({s.nodes.data(), s.nodes.size()});
    }
    for (const auto &s : o.model.skins) {
        o.skins.push_back({{s.joints.data(), s.joints.size()}, s.inverseBindMatrices});
    }
    for (const auto &c : o.model.cameras) {
        o.cameras.push_back({c.name.c_str(), c.type == "orthographic",
                             c.perspective.yfov, c.orthographic.ymag});
    }
}

/** A number of an extension, or `otherwise`. */
double extension_number(const tinygltf::ExtensionMap &extensions, const char *extension,
                        const char *member, double otherwise)
{
    const auto found = extensions.find(extension);
    if (found == extensions.end() || !found->second.Has(member)) return otherwise;
    const tinygltf::Value &value = found->second.Get(member);
    return value.IsNumber() ? value.GetNumberAsDouble() : otherwise;
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
    c.alpha_cutoff = m.alphaCutoff;
    c.double_sided = m.doubleSided;
    c.emissive_strength = extension_number(
        m.extensions, "KHR_materials_emissive_strength", "emissiveStrength", 1.0);
    c.ior = extension_number(m.extensions, "KHR_materials_ior", "ior", 1.5);
    c.specular =
        extension_number(m.extensions, "KHR_materials_specular", "specularFactor", 1.0);
    const auto specular = m.extensions.find("KHR_materials_specular");
    c.more_specular = specular != m.extensions.end() &&
                      (specular->second.Has("specularTexture") ||
                       specular->second.Has("specularColorFactor") ||
                       specular->second.Has("specularColorTexture"));
    c.base_color_texture = {pbr.baseColorTexture.index, pbr.baseColorTexture.texCoord};
    c.metallic_roughness_texture = {pbr.metallicRoughnessTexture.index,
                                    pbr.metallicRoughnessTexture.texCoord};
    c.normal_texture = {m.normalTexture.index, m.normalTexture.texCoord};
    c.emissive_texture = {m.emissiveTexture.index, m.emissiveTexture.texCoord};
    return c;
}

/** EXT_texture_webp names the image that every renderer with WebP should take. */
int64_t image_of(const tinygltf::Texture &t)
{
    const auto webp = t.extensions.find("EXT_texture_webp");
    if (webp != t.extensions.end() && webp->second.Has("source")) {
        const tinygltf::Value &source = webp->second.Get("source");
        if (source.IsInt()) return source.GetNumberAsInt();
    }
    return t.source;
}

void copy_looks(Owner &o)
{
    for (const auto &m : o.model.materials)
        o.materials.push_back(material_of(m));
    for (const auto &t : o.model.textures)
        o.textures.push_back({t.sampler, image_of(t)});
    for (const auto &s : o.model.samplers) {
        o.samplers.push_back({s.magFilter, s.wrapS, s.wrapT});
    }
    for (const auto &i : o.model.images)
        o.image_views.push_back(i.bufferView);
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
    d->image_views = o.image_views.data();
    d->image_count = o.image_views.size();
    d->buffer_count = o.model.buffers.size();
    d->animation_count = o.model.animations.size();
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
    copy_graph(*owner);
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
