/*
 * Which extensions of glTF are read, and what is said of the others.
 */
#include <stdio.h>
#include <string.h>

#include "engine/scene/gltf/load.h"

/** What becomes of an extension that is not read where the file does without it. */
enum manner {
    MANNER_READ,
    MANNER_LAYER,  /* of a material: the base below it is rendered */
    MANNER_OPAQUE, /* lets light through: rendered opaque */
    MANNER_TEXTURE,
    MANNER_OTHER,
};

static const struct {
    const char *name;
    enum manner manner;
} known[] = {
    {"KHR_draco_mesh_compression", MANNER_READ},
    {"KHR_lights_punctual", MANNER_READ},
    {"KHR_materials_emissive_strength", MANNER_READ},
    {"KHR_materials_ior", MANNER_READ},
    {"KHR_materials_pbrSpecularGlossiness", MANNER_READ},
    {"KHR_materials_specular", MANNER_READ},
    {"KHR_materials_unlit", MANNER_READ},
    {"KHR_materials_variants", MANNER_READ},
    {"KHR_mesh_quantization", MANNER_READ},
    {"KHR_texture_transform", MANNER_READ},
    {"EXT_mesh_gpu_instancing", MANNER_READ},
    {"EXT_meshopt_compression", MANNER_READ},
    {"EXT_texture_webp", MANNER_READ},
    {"KHR_materials_anisotropy", MANNER_LAYER},
    {"KHR_materials_clearcoat", MANNER_LAYER},
    {"KHR_materials_iridescence", MANNER_LAYER},
    {"KHR_materials_sheen", MANNER_LAYER},
    {"KHR_materials_diffuse_transmission", MANNER_OPAQUE},
    {"KHR_materials_dispersion", MANNER_OPAQUE},
    {"KHR_materials_subsurface", MANNER_OPAQUE},
    {"KHR_materials_transmission", MANNER_OPAQUE},
    {"KHR_materials_volume", MANNER_OPAQUE},
    {"KHR_materials_volume_scatter", MANNER_OPAQUE},
    {"KHR_texture_basisu", MANNER_TEXTURE},
    {"EXT_texture_astc", MANNER_TEXTURE},
    {"EXT_texture_avif", MANNER_TEXTURE},
    {"MSFT_texture_dds", MANNER_TEXTURE},
};

static enum manner manner_of(const char *extension)
{
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        if (strcmp(extension, known[i].name) == 0) return known[i].manner;
    }
    return MANNER_OTHER;
}

/** Is an item of the list the same as one before it? */
static bool is_repeated(const char *const *list, size_t i)
{
    for (size_t k = 0; k < i; ++k) {
        if (strcmp(list[k], list[i]) == 0) return true;
    }
    return false;
}

/** Names in a sentence: "A, B and 3 more". */
struct names {
    char text[480];
    size_t used, left_out;
};

static void add_name(struct names *n, const char *name)
{
    const size_t room = sizeof n->text - n->used;
    const int size =
        snprintf(n->text + n->used, room, "%s%.100s", n->used ? ", " : "", name);
    if (size > 0 && (size_t)size < room) {
        n->used += (size_t)size;
    } else {
        n->text[n->used] = 0;
        ++n->left_out;
    }
}

static const char *finish(struct names *n)
{
    if (n->left_out) {
        (void)snprintf(n->text + n->used, sizeof n->text - n->used, ", ...");
    }
    return n->text;
}

/** A hostile list is cut short: naming is quadratic in it. */
enum { NAMED = 64 };

/** Those extensions of a list that are treated in one of two manners. */
static struct names collect(const char *const *list, size_t count, enum manner a,
                            enum manner b)
{
    struct names n = {.used = 0};
    for (size_t i = 0; i < count && i < NAMED; ++i) {
        const enum manner m = manner_of(list[i]);
        if ((m == a || m == b) && !is_repeated(list, i)) add_name(&n, list[i]);
    }
    return n;
}

/** What to do about an extension that is required and not read. */
static const char *remedy_for(const char *extension)
{
    if (strcmp(extension, "KHR_texture_basisu") == 0)
        return "`gltf-transform ktxdecompress IN OUT` stores its textures as PNG";
    if (strcmp(extension, "EXT_texture_avif") == 0)
        return "`gltf-transform png IN OUT` stores its textures as PNG";
    if (manner_of(extension) == MANNER_TEXTURE) return "store its textures as PNG";
    return "export it anew without that, for example from Blender";
}

/* A file that requires an extension must not be loaded without it: glTF 2.0, 3.12. */
static enum pbnds_status refuse(struct pbnds_gltf_load_state *g)
{
    const char *const *list = g->doc.extensions_required;
    const size_t count = g->doc.extensions_required_count;
    struct names all = {.used = 0};
    const char *remedy = NULL;
    bool several = false;
    for (size_t i = 0; i < count; ++i) {
        if (manner_of(list[i]) == MANNER_READ || (i < NAMED && is_repeated(list, i)))
            continue;
        const char *this_one = remedy_for(list[i]);
        several = remedy != NULL;
        if (remedy && strcmp(remedy, this_one) != 0)
            this_one = "export it anew without them, for example from Blender";
        remedy = this_one;
        add_name(&all, list[i]);
    }
    if (!remedy) return PBNDS_OK;
    return pbnds_fail(g->error, PBNDS_ERROR_UNSUPPORTED,
                      "%s: requires the extension%s %s, which %s not supported; %s",
                      g->name, several ? "s" : "", finish(&all), several ? "are" : "is",
                      remedy);
}

enum pbnds_status pbnds_gltf_check_extensions(struct pbnds_gltf_load_state *g)
{
    PBNDS_TRY(refuse(g));
    const char *const *list = g->doc.extensions_used;
    const size_t count = g->doc.extensions_used_count;
    struct names n = collect(list, count, MANNER_OTHER, MANNER_TEXTURE);
    if (n.used)
        pbnds_warn(g->report, "%s: extensions that are not read are ignored: %s",
                   g->name, finish(&n));
    n = collect(list, count, MANNER_LAYER, MANNER_LAYER);
    if (n.used) {
        pbnds_warn(g->report,
                   "%s: %s: only the base material below these layers is rendered",
                   g->name, finish(&n));
    }
    n = collect(list, count, MANNER_OPAQUE, MANNER_OPAQUE);
    if (n.used) {
        pbnds_warn(g->report,
                   "%s: %s: no light goes through, such materials are rendered opaque "
                   "with their base colour",
                   g->name, finish(&n));
    }
    return PBNDS_OK;
}
