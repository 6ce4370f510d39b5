/* The glb container (glTF 2.0, chapter 4): JSON chunk, binary chunk. */
#include <stdlib.h>
#include <string.h>

#include "engine/core/file.h"
#include "scenes/generator/world.h"

enum { FLOAT = 5126, USHORT = 5123, UINT = 5125, VERTICES = 34962, INDICES = 34963 };

/* JSON arrays grow side by side with the binary block. */
struct glb {
    struct gen_bytes bin, views, accessors;
    int view_count, accessor_count;
    int of_part[GEN_MAX_PARTS][6]; /* accessors */
};

static int add_view(struct glb *g, const void *data, size_t size, int target)
{
    gen_bytes_align(&g->bin, 0);
    gen_bytes_print(&g->views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu",
                    g->view_count ? "," : "", g->bin.size, size);
    if (target) gen_bytes_print(&g->views, ",\"target\":%d", target);
    gen_bytes_print(&g->views, "}");
    gen_bytes_add(&g->bin, data, size);
    return g->view_count++;
}

static int add_accessor(struct glb *g, int view, int type, size_t count,
                        const char *shape, const char *extra)
{
    gen_bytes_print(&g->accessors,
                    "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%zu,"
                    "\"type\":\"%s\"%s}",
                    g->accessor_count ? "," : "", view, type, count, shape, extra);
    return g->accessor_count++;
}

static int add_positions(struct glb *g, const struct gen_mesh *m)
{
    char bounds[256];
    struct pbnds_vec3 lo, hi;
    gen_mesh_bounds(m, &lo, &hi);
    (void)snprintf(bounds, sizeof bounds,
                   ",\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]", (double)lo.x,
                   (double)lo.y, (double)lo.z, (double)hi.x, (double)hi.y,
                   (double)hi.z);
    const int view =
        add_view(g, m->position, m->vertex_count * sizeof *m->position, VERTICES);
    return add_accessor(g, view, FLOAT, m->vertex_count, "VEC3", bounds);
}

static int add_floats(struct glb *g, const void *data, size_t count, int width)
{
    static const char *const shapes[5] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const int view = add_view(g, data, count * (size_t)width * sizeof(float), VERTICES);
    return add_accessor(g, view, FLOAT, count, shapes[width], "");
}

static int add_indices(struct glb *g, const struct gen_mesh *m)
{
    if (m->vertex_count > 65535) {
        const int view =
            add_view(g, m->index, m->index_count * sizeof *m->index, INDICES);
        return add_accessor(g, view, UINT, m->index_count, "SCALAR", "");
    }
    uint16_t *narrow = malloc(m->index_count * sizeof *narrow);
    if (!narrow) {
        g->bin.failed = true;
        return 0;
    }
    for (size_t i = 0; i < m->index_count; ++i)
        narrow[i] = (uint16_t)m->index[i];
    const int view = add_view(g, narrow, m->index_count * sizeof *narrow, INDICES);
    free(narrow);
    return add_accessor(g, view, USHORT, m->index_count, "SCALAR", "");
}

/* Accessors of a part's mesh, in the order position, normal, uv, tangent, index, colour. */
static void add_mesh(struct glb *g, const struct gen_world *w, int part)
{
    const struct gen_mesh *m = gen_part_mesh(w, part);
    const struct gen_material *material = &w->materials[w->parts[part].material];
    const bool textured = gen_material_textured(material);
    int *a = g->of_part[part];
    a[0] = add_positions(g, m);
    a[1] = add_floats(g, m->normal, m->vertex_count, 3);
    a[2] = textured ? add_floats(g, m->uv, m->vertex_count, 2) : -1;
    a[3] = m->tangent ? add_floats(g, m->tangent, m->vertex_count, 4) : -1;
    a[4] = add_indices(g, m);
    const struct pbnds_vec3 *color = w->parts[part].color;
    a[5] = color ? add_floats(g, color, m->vertex_count, 3) : -1;
}

static void print_primitive(struct glb *g, struct gen_bytes *json,
                            const struct gen_world *w, int part)
{
    const int twin = w->parts[part].twin;
    if (twin < 0) add_mesh(g, w, part);
    const int *a = g->of_part[twin >= 0 ? twin : part];
    gen_bytes_print(json, "{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d", a[0], a[1]);
    if (a[2] >= 0) gen_bytes_print(json, ",\"TEXCOORD_0\":%d", a[2]);
    if (a[3] >= 0) gen_bytes_print(json, ",\"TANGENT\":%d", a[3]);
    if (a[5] >= 0) gen_bytes_print(json, ",\"COLOR_0\":%d", a[5]);
    gen_bytes_print(json, "},\"indices\":%d,\"material\":%d}", a[4],
                    w->parts[part].material);
}

static void print_meshes(struct glb *g, struct gen_bytes *json,
                         const struct gen_world *w)
{
    gen_bytes_print(json, ",\"meshes\":[");
    for (int i = 0; i < w->object_count; ++i) {
        const struct gen_object *o = &w->objects[i];
        gen_bytes_print(json, "%s{\"primitives\":[", i ? "," : "");
        for (int k = 0; k < o->part_count; ++k) {
            if (k) gen_bytes_print(json, ",");
            print_primitive(g, json, w, o->first_part + k);
        }
        gen_bytes_print(json, "]}");
    }
    gen_bytes_print(json, "]");
}

/* Quaternion of a camera at eye that looks at target along its -z, +y up. */
static struct pbnds_vec4 look_rotation(struct pbnds_vec3 eye, struct pbnds_vec3 target)
{
    const struct pbnds_vec3 d = pbnds_normalize(pbnds_sub(target, eye));
    const float yaw = atan2f(-d.x, -d.z), pitch = asinf(pbnds_clamp(d.y, -1.0f, 1.0f));
    return gen_quat_mul(gen_turn(pbnds_vec3_make(0.0f, 1.0f, 0.0f), yaw),
                        gen_turn(pbnds_vec3_make(1.0f, 0.0f, 0.0f), pitch));
}

static void print_pose(struct gen_bytes *json, struct pbnds_vec3 t, struct pbnds_vec4 q)
{
    gen_bytes_print(
        json, "\"translation\":[%.9g,%.9g,%.9g],\"rotation\":[%.9g,%.9g,%.9g,%.9g]",
        (double)t.x, (double)t.y, (double)t.z, (double)q.x, (double)q.y, (double)q.z,
        (double)q.w);
}

/* Opens the next node of the list. */
static void begin_node(struct gen_bytes *json, int *count)
{
    gen_bytes_print(json, "%s{", (*count)++ ? "," : "");
}

static void print_objects(struct gen_bytes *json, const struct gen_world *w, int *count)
{
    for (int i = 0; i < w->object_count; ++i) {
        const struct gen_object *o = &w->objects[i];
        const double s = (double)o->scale;
        char number[64];
        (void)snprintf(number, sizeof number, "%s_%d", o->name ? o->name : "object", i);
        begin_node(json, count);
        gen_bytes_print(json, "\"name\":\"%s\",\"mesh\":%d,",
                        o->name && !o->numbered ? o->name : number, i);
        print_pose(json, o->translation, o->rotation);
        gen_bytes_print(json, ",\"scale\":[%.9g,%.9g,%.9g]}", s, s, s);
    }
}

/* Cameras and lights both look along their -z. */
static void print_onlooker(struct gen_bytes *json, struct pbnds_vec3 at,
                           struct pbnds_vec3 target)
{
    gen_bytes_print(json, ",");
    print_pose(json, at, look_rotation(at, target));
    gen_bytes_print(json, "}");
}

static void print_nodes(struct gen_bytes *json, const struct gen_world *w)
{
    const struct gen_camera *const cameras[] = {&w->camera, &w->front};
    static const char *const names[] = {"main", "front"};
    int count = 0, camera_count = 0;
    gen_bytes_print(json, ",\"nodes\":[");
    print_objects(json, w, &count);
    for (int i = 0; i < 2; ++i) {
        if (!(cameras[i]->yfov > 0.0f)) continue;
        begin_node(json, &count);
        gen_bytes_print(json, "\"name\":\"%s\",\"camera\":%d", names[i],
                        camera_count++);
        print_onlooker(json, cameras[i]->eye, cameras[i]->target);
    }
    for (int i = 0; i < w->light_count; ++i) {
        begin_node(json, &count);
        gen_bytes_print(json,
                        "\"name\":\"%s\",\"extensions\":{\"KHR_lights_punctual\":"
                        "{\"light\":%d}}",
                        w->lights[i].name, i);
        print_onlooker(json, w->lights[i].at, w->lights[i].target);
    }
    gen_bytes_print(json, "],\"scenes\":[{\"nodes\":[");
    for (int i = 0; i < count; ++i)
        gen_bytes_print(json, "%s%d", i ? "," : "", i);
    if (w->name) gen_bytes_print(json, "],\"name\":\"%s", w->name);
    gen_bytes_print(json, w->name ? "\"}],\"scene\":0" : "]}],\"scene\":0");
    if (camera_count > 0) gen_bytes_print(json, ",\"cameras\":[");
    for (int i = 0, n = 0; i < 2; ++i) {
        if (!(cameras[i]->yfov > 0.0f)) continue;
        gen_bytes_print(json,
                        "%s{\"name\":\"%s\",\"type\":\"perspective\","
                        "\"perspective\":{\"yfov\":%.9g,\"znear\":0.01}}",
                        n++ ? "," : "", names[i], (double)cameras[i]->yfov);
    }
    if (camera_count > 0) gen_bytes_print(json, "]");
}

static void print_lights(struct gen_bytes *json, const struct gen_world *w)
{
    static const char *const kinds[] = {"directional", "point", "spot"};
    if (w->light_count == 0) return;
    gen_bytes_print(json, ",\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[");
    for (int i = 0; i < w->light_count; ++i) {
        const struct gen_light *l = &w->lights[i];
        gen_bytes_print(json,
                        "%s{\"name\":\"%s\",\"type\":\"%s\",\"color\":[%.9g,%.9g,%.9g],"
                        "\"intensity\":%.9g",
                        i ? "," : "", l->name, kinds[l->kind], (double)l->color.x,
                        (double)l->color.y, (double)l->color.z, (double)l->intensity);
        if (l->range > 0.0f) gen_bytes_print(json, ",\"range\":%.9g", (double)l->range);
        if (l->kind == GEN_LIGHT_SPOT)
            gen_bytes_print(
                json, ",\"spot\":{\"innerConeAngle\":%.9g,\"outerConeAngle\":%.9g}",
                (double)l->inner, (double)l->outer);
        gen_bytes_print(json, "}");
    }
    gen_bytes_print(json, "]}}");
}

enum extension { IOR, SPECULAR, STRENGTH, UNLIT, LIGHTS, EXTENSION_COUNT };

static const char *const extension_names[] = {
    "KHR_materials_ior", "KHR_materials_specular", "KHR_materials_emissive_strength",
    "KHR_materials_unlit", "KHR_lights_punctual"};

static bool has_extension(const struct gen_material *m, int extension)
{
    switch ((enum extension)extension) {
    case IOR:
        return m->ior != 1.5f;
    case SPECULAR:
        return m->specular != 1.0f ||
               pbnds_max3(pbnds_sub(pbnds_splat(1.0f), m->specular_color)) > 0.0f;
    case STRENGTH:
        return pbnds_max3(m->emission) > 1.0f;
    case UNLIT:
        return m->unlit;
    default:
        return false;
    }
}

static void print_extensions(struct gen_bytes *json, const struct gen_material *m)
{
    static const char *const members[] = {"ior", "specularFactor", "emissiveStrength"};
    const double values[] = {(double)m->ior, (double)m->specular,
                             (double)pbnds_max3(m->emission)};
    int count = 0;
    for (int k = 0; k < LIGHTS; ++k) {
        if (!has_extension(m, k)) continue;
        gen_bytes_print(json, "%s\"%s\":{", count++ ? "," : ",\"extensions\":{",
                        extension_names[k]);
        if (k != UNLIT) gen_bytes_print(json, "\"%s\":%.9g", members[k], values[k]);
        const struct pbnds_vec3 c = m->specular_color;
        if (k == SPECULAR && fminf(c.x, fminf(c.y, c.z)) < 1.0f)
            gen_bytes_print(json, ",\"specularColorFactor\":[%.9g,%.9g,%.9g]",
                            (double)c.x, (double)c.y, (double)c.z);
        gen_bytes_print(json, "}");
    }
    if (count) gen_bytes_print(json, "}");
}

/* A material's texture factors are 1 where the image carries the value. */
static void print_material(struct gen_bytes *json, const struct gen_material *m)
{
    const struct pbnds_vec3 c = m->base_color;
    gen_bytes_print(
        json, "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%.9g,%.9g,%.9g,%.9g]",
        (double)c.x, (double)c.y, (double)c.z, (double)m->alpha);
    gen_bytes_print(json, ",\"metallicFactor\":%.9g,\"roughnessFactor\":%.9g",
                    (double)m->metallic, (double)m->roughness);
    if (m->color_image >= 0) {
        gen_bytes_print(json, ",\"baseColorTexture\":{\"index\":%d}", m->color_image);
    }
    if (m->surface_image >= 0) {
        gen_bytes_print(json, ",\"metallicRoughnessTexture\":{\"index\":%d}",
                        m->surface_image);
    }
    gen_bytes_print(json, "}");
    if (m->normal_image >= 0) {
        gen_bytes_print(json, ",\"normalTexture\":{\"index\":%d,\"scale\":%.9g}",
                        m->normal_image, (double)m->normal_scale);
    }
    if (m->double_sided) gen_bytes_print(json, ",\"doubleSided\":true");
    if (m->blend) gen_bytes_print(json, ",\"alphaMode\":\"BLEND\"");
    const float power = pbnds_max3(m->emission);
    if (power > 0.0f) {
        const struct pbnds_vec3 e = pbnds_scale(m->emission, 1.0f / fmaxf(power, 1.0f));
        gen_bytes_print(json, ",\"emissiveFactor\":[%.9g,%.9g,%.9g]", (double)e.x,
                        (double)e.y, (double)e.z);
    }
    print_extensions(json, m);
    gen_bytes_print(json, "}");
}

static void print_materials(struct gen_bytes *json, const struct gen_world *w)
{
    bool used[EXTENSION_COUNT] = {false};
    used[LIGHTS] = w->light_count > 0;
    gen_bytes_print(json, ",\"materials\":[");
    for (int i = 0; i < w->material_count; ++i) {
        if (i) gen_bytes_print(json, ",");
        print_material(json, &w->materials[i]);
        for (int k = 0; k < LIGHTS; ++k)
            used[k] = used[k] || has_extension(&w->materials[i], k);
    }
    gen_bytes_print(json, "]");
    int count = 0;
    for (int k = 0; k < EXTENSION_COUNT; ++k) {
        if (!used[k]) continue;
        gen_bytes_print(json, "%s\"%s\"", count++ ? "," : ",\"extensionsUsed\":[",
                        extension_names[k]);
    }
    if (count) gen_bytes_print(json, "]");
}

static void print_images(struct glb *g, struct gen_bytes *json,
                         const struct gen_world *w)
{
    if (w->image_count == 0) return;
    gen_bytes_print(json, ",\"images\":[");
    for (int i = 0; i < w->image_count; ++i) {
        const int view = add_view(g, w->images[i].data, w->images[i].size, 0);
        gen_bytes_print(json, "%s{\"bufferView\":%d,\"mimeType\":\"image/png\"}",
                        i ? "," : "", view);
    }
    gen_bytes_print(json, "],\"textures\":[");
    for (int i = 0; i < w->image_count; ++i) {
        gen_bytes_print(json, "%s{\"source\":%d}", i ? "," : "", i);
    }
    gen_bytes_print(json, "]");
}

static void add_word(struct gen_bytes *b, size_t x)
{
    uint8_t bytes[4];
    for (int i = 0; i < 4; ++i)
        bytes[i] = (uint8_t)(x >> (8 * i));
    gen_bytes_add(b, bytes, 4);
}

static void add_file(struct gen_bytes *file, const struct gen_bytes *json,
                     const struct gen_bytes *bin)
{
    gen_bytes_add(file, "glTF", 4);
    add_word(file, 2);
    add_word(file, 12 + 8 + json->size + 8 + bin->size);
    add_word(file, json->size);
    gen_bytes_add(file, "JSON", 4);
    gen_bytes_add(file, json->data, json->size);
    add_word(file, bin->size);
    gen_bytes_add(file, "BIN\0", 4);
    gen_bytes_add(file, bin->data, bin->size);
}

bool gen_glb_make(const struct gen_world *w, struct gen_bytes *file)
{
    struct glb g = {.view_count = 0};
    struct gen_bytes json = {.size = 0};
    gen_bytes_print(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"pbnds\"}");
    print_meshes(&g, &json, w);
    print_nodes(&json, w);
    print_materials(&json, w);
    print_lights(&json, w);
    print_images(&g, &json, w);
    gen_bytes_print(&json, ",\"bufferViews\":[");
    gen_bytes_add(&json, g.views.data, g.views.size);
    gen_bytes_print(&json, "],\"accessors\":[");
    gen_bytes_add(&json, g.accessors.data, g.accessors.size);
    gen_bytes_align(&g.bin, 0);
    gen_bytes_print(&json, "],\"buffers\":[{\"byteLength\":%zu}]}", g.bin.size);
    gen_bytes_align(&json, ' ');
    add_file(file, &json, &g.bin);
    const bool failed = w->failed || g.bin.failed || g.views.failed ||
                        g.accessors.failed || json.failed || file->failed;
    gen_bytes_free(&g.bin);
    gen_bytes_free(&g.views);
    gen_bytes_free(&g.accessors);
    gen_bytes_free(&json);
    return !failed;
}

enum pbnds_status gen_glb_write(const struct gen_world *w, const char *path,
                                struct pbnds_error *error)
{
    struct gen_bytes file = {.size = 0};
    const enum pbnds_status status =
        gen_glb_make(w, &file) ? pbnds_file_write(path, file.data, file.size, error)
                               : pbnds_fail(error, PBNDS_ERROR_MEMORY,
                                            "%s: no memory for the scene", path);
    gen_bytes_free(&file);
    return status;
}
