#include <string.h>

#include "engine/scene/gltf/image.h"

#include <stdlib.h>

/* Far above any lamp, and far enough below FLT_MAX for the sums of a path. */
static const double EMISSION_MAX = 1e20;

/* A texture transform beyond this leaves no digits for the place in the image. */
static const double TRANSFORM_MAX = 1e6;

static float unit(double x)
{
    return x > 0.0 ? (x < 1.0 ? (float)x : 1.0f) : 0.0f;
}

/**
 * KHR_texture_transform: scale, then rotate counter-clockwise as the picture is seen,
 * then move. In glTF v points down, so the rotation by r is
 *     u' =  cos(r) u + sin(r) v
 *     v' = -sin(r) u + cos(r) v.
 * That is what the text, its example and every viewer say; the GLSL listing of older
 * versions of the text has the other sign (KhronosGroup/glTF, issue 1563).
 */
static enum pbnds_status fold_transform(struct pbnds_gltf_load_state *g,
                                        size_t material,
                                        const struct pbnds_gltf_texture_info *info,
                                        struct pbnds_texture_ref *ref)
{
    if (!info->transformed) return PBNDS_OK;
    const double c = cos(info->rotation), s = sin(info->rotation);
    const double t[6] = {c * info->scale[0],  s * info->scale[1], info->offset[0],
                         -s * info->scale[0], c * info->scale[1], info->offset[1]};
    static const double identity[6] = {1, 0, 0, 0, 1, 0};
    for (int i = 0; i < 6; ++i) {
        if (!(fabs(t[i]) <= TRANSFORM_MAX)) {
            return pbnds_fail(
                g->error, PBNDS_ERROR_FORMAT,
                "%s: material %zu has a KHR_texture_transform beyond all images",
                g->name, material);
        }
        ref->transform[i] = (float)t[i];
        ref->transformed = ref->transformed || t[i] != identity[i];
    }
    return PBNDS_OK;
}

static enum pbnds_status make_ref(struct pbnds_gltf_load_state *g,
                                  struct pbnds_gltf_remap *map, size_t material,
                                  const struct pbnds_gltf_texture_info *info,
                                  struct pbnds_texture_ref *ref)
{
    *ref = (struct pbnds_texture_ref){.texture = -1};
    if (info->index < 0) return PBNDS_OK;
    if (info->texcoord < 0 || info->texcoord > 1) {
        if (!g->more_texcoords) {
            pbnds_warn(
                g->report,
                "%s: a texture of material %zu uses TEXCOORD_%lld, such textures "
                "are left out, only 0 and 1 are read",
                g->name, material, (long long)info->texcoord);
        }
        g->more_texcoords = true;
        return PBNDS_OK;
    }
    ref->texture = pbnds_gltf_add_texture(g, map, info->index);
    if (ref->texture < 0) return PBNDS_OK;
    ref->texcoord = (int)info->texcoord;
    return fold_transform(g, material, info, ref);
}

/** Reflectance at normal incidence. KHR_materials_ior: an ior of 0 stands for infinity.
 */
static float ior_f0(double ior)
{
    const double r = ior > 0.0 ? (ior - 1.0) / (ior + 1.0) : 1.0;
    return unit(r * r);
}

/** A factor that may be above one: KHR_materials_specular's colour. */
static float positive(double x)
{
    return x > 0.0 ? (x < 1e6 ? (float)x : 1e6f) : 0.0f;
}

static enum pbnds_status convert_emission(struct pbnds_gltf_load_state *g, size_t index,
                                          struct pbnds_material *m)
{
    const struct pbnds_gltf_material *s = &g->doc.materials[index];
    float emissive[3];
    for (int i = 0; i < 3; ++i) {
        const double e = s->emissive[i] * s->emissive_strength;
        if (!(e >= 0.0 && e <= EMISSION_MAX)) {
            return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                              "%s: material %zu emits %g, which is not a radiance",
                              g->name, index, e);
        }
        emissive[i] = (float)e;
    }
    m->emissive = pbnds_vec3_make(emissive[0], emissive[1], emissive[2]);
    return PBNDS_OK;
}

static enum pbnds_status convert_alpha(struct pbnds_gltf_load_state *g, size_t index,
                                       struct pbnds_material *m)
{
    const struct pbnds_gltf_material *s = &g->doc.materials[index];
    m->alpha_cutoff =
        s->alpha_cutoff >= 0.0 && s->alpha_cutoff < 1e6 ? (float)s->alpha_cutoff : 0.5f;
    if (strcmp(s->alpha_mode, "OPAQUE") == 0)
        m->alpha_mode = PBNDS_ALPHA_OPAQUE;
    else if (strcmp(s->alpha_mode, "MASK") == 0)
        m->alpha_mode = PBNDS_ALPHA_MASK;
    else if (strcmp(s->alpha_mode, "BLEND") == 0)
        m->alpha_mode = PBNDS_ALPHA_BLEND;
    else {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: material %zu has an unknown alphaMode", g->name, index);
    }
    return PBNDS_OK;
}

static void convert_factors(const struct pbnds_gltf_material *s,
                            struct pbnds_material *m)
{
    m->base_color = (struct pbnds_vec4){unit(s->base_color[0]), unit(s->base_color[1]),
                                        unit(s->base_color[2]), unit(s->base_color[3])};
    m->metallic = unit(s->metallic);
    m->roughness = unit(s->roughness);
    m->ior_f0 = ior_f0(s->ior);
    m->specular = unit(s->specular);
    m->specular_color =
        pbnds_vec3_make(positive(s->specular_color[0]), positive(s->specular_color[1]),
                        positive(s->specular_color[2]));
    m->normal_scale = fabs(s->normal_scale) < 1e6 ? (float)s->normal_scale : 1.0f;
    m->occlusion_strength = unit(s->occlusion_strength);
    m->double_sided = s->double_sided;
    m->unlit = s->unlit;
    m->specular_glossiness = s->specular_glossiness;
}

static enum pbnds_status convert_textures(struct pbnds_gltf_load_state *g,
                                          struct pbnds_gltf_remap *map, size_t index,
                                          struct pbnds_material *m)
{
    const struct pbnds_gltf_material *s = &g->doc.materials[index];
    const struct {
        const struct pbnds_gltf_texture_info *from;
        struct pbnds_texture_ref *to;
    } list[] = {
        {&s->base_color_texture, &m->base_color_texture},
        {&s->metallic_roughness_texture, &m->metallic_roughness_texture},
        {&s->normal_texture, &m->normal_texture},
        {&s->emissive_texture, &m->emissive_texture},
        {&s->occlusion_texture, &m->occlusion_texture},
        {&s->specular_texture, &m->specular_texture},
        {&s->specular_color_texture, &m->specular_color_texture},
    };
    for (size_t i = 0; i < sizeof list / sizeof list[0]; ++i) {
        PBNDS_TRY(make_ref(g, map, index, list[i].from, list[i].to));
    }
    return PBNDS_OK;
}

static enum pbnds_status convert_material(struct pbnds_gltf_load_state *g,
                                          struct pbnds_gltf_remap *map, size_t index,
                                          struct pbnds_material *m)
{
    const struct pbnds_gltf_material *s = &g->doc.materials[index];
    *m = pbnds_material_default();
    pbnds_gltf_name(m->name, s->name, "material", index);
    convert_factors(s, m);
    PBNDS_TRY(convert_emission(g, index, m));
    PBNDS_TRY(convert_alpha(g, index, m));
    return convert_textures(g, map, index, m);
}

enum pbnds_status pbnds_gltf_materials(struct pbnds_gltf_load_state *g)
{
    struct pbnds_gltf_remap map = {0};
    enum pbnds_status status = pbnds_gltf_remap_init(g, &map);
    g->scene->materials =
        calloc(g->doc.material_count + 1, sizeof *g->scene->materials);
    if (status == PBNDS_OK && !g->scene->materials) {
        status = pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for materials",
                            g->name);
    }
    for (size_t i = 0; i < g->doc.material_count && status == PBNDS_OK; ++i) {
        status = convert_material(g, &map, i, &g->scene->materials[i]);
        ++g->scene->material_count;
    }
    if (status == PBNDS_OK) {
        g->scene->materials[g->scene->material_count++] = pbnds_material_default();
        status = pbnds_gltf_decode_images(g, &map);
    }
    pbnds_gltf_remap_free(&map);
    return status;
}
