#include "scenes/generator/world.h"

#include <stdlib.h>

void gen_world_free(struct gen_world *w)
{
    for (int i = 0; i < w->part_count; ++i) {
        gen_mesh_free(&w->parts[i].mesh);
        free(w->parts[i].color);
    }
    for (int i = 0; i < w->image_count; ++i)
        gen_bytes_free(&w->images[i]);
    w->part_count = w->object_count = w->material_count = w->image_count = 0;
    w->light_count = w->palette_count = 0;
    w->name = NULL;
    w->camera.yfov = w->front.yfov = 0.0f;
    w->failed = false;
}

int gen_object_begin(struct gen_world *w)
{
    if (w->object_count == GEN_MAX_OBJECTS) --w->object_count;
    struct gen_object *o = &w->objects[w->object_count];
    *o = (struct gen_object){.first_part = w->part_count, .scale = 1.0f};
    o->rotation.w = 1.0f;
    return w->object_count++;
}

void gen_object_name(struct gen_world *w, const char *name)
{
    w->objects[w->object_count - 1].name = name;
    w->objects[w->object_count - 1].numbered = true;
}

void gen_object_part(struct gen_world *w, struct gen_mesh *mesh, int material)
{
    if (mesh->failed) w->failed = true;
    if (mesh->failed || mesh->index_count == 0 || w->part_count == GEN_MAX_PARTS) {
        gen_mesh_free(mesh);
        return;
    }
    const struct gen_material *m = &w->materials[material];
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        mesh->uv[i].x *= m->repeat;
        mesh->uv[i].y *= m->repeat;
    }
    if (m->normal_image >= 0) gen_mesh_tangents(mesh);
    if (!gen_material_textured(m)) gen_mesh_weld(mesh);
    if (mesh->failed) w->failed = true;
    struct gen_object *o = &w->objects[w->object_count - 1];
    w->parts[w->part_count++] =
        (struct gen_part){.mesh = *mesh, .material = material, .twin = -1};
    ++o->part_count;
    *mesh = (struct gen_mesh){.vertex_count = 0};
}

void gen_object_twin(struct gen_world *w, int part, int material)
{
    if (w->part_count == GEN_MAX_PARTS) return;
    w->parts[w->part_count++] = (struct gen_part){.material = material, .twin = part};
    ++w->objects[w->object_count - 1].part_count;
}

void gen_object_paint(struct gen_world *w,
                      struct pbnds_vec3 (*paint)(const void *context,
                                                 struct pbnds_vec3 p),
                      const void *context)
{
    if (w->part_count == 0 || w->objects[w->object_count - 1].part_count == 0) return;
    struct gen_part *part = &w->parts[w->part_count - 1];
    const struct gen_mesh *m = &part->mesh;
    if (part->twin >= 0 || part->color) return;
    part->color = malloc((m->vertex_count + 1) * sizeof *part->color);
    if (!part->color) {
        w->failed = true;
        return;
    }
    for (size_t i = 0; i < m->vertex_count; ++i)
        part->color[i] = paint(context, m->position[i]);
}

const struct gen_mesh *gen_part_mesh(const struct gen_world *w, int part)
{
    const int twin = w->parts[part].twin;
    return &w->parts[twin >= 0 ? twin : part].mesh;
}

static struct pbnds_vec3 lower(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return pbnds_vec3_make(fminf(a.x, b.x), fminf(a.y, b.y), fminf(a.z, b.z));
}

static struct pbnds_vec3 upper(struct pbnds_vec3 a, struct pbnds_vec3 b)
{
    return pbnds_vec3_make(fmaxf(a.x, b.x), fmaxf(a.y, b.y), fmaxf(a.z, b.z));
}

void gen_object_extent(const struct gen_world *w, int object, struct pbnds_vec3 *centre,
                       float *extent)
{
    const struct gen_object *o = &w->objects[object];
    struct pbnds_vec3 lo = pbnds_splat(INFINITY), hi = pbnds_splat(-INFINITY);
    for (int i = 0; i < o->part_count; ++i) {
        struct pbnds_vec3 a, b;
        gen_mesh_bounds(gen_part_mesh(w, o->first_part + i), &a, &b);
        lo = lower(lo, a);
        hi = upper(hi, b);
    }
    *centre = o->part_count ? pbnds_scale(pbnds_add(lo, hi), 0.5f) : pbnds_splat(0.0f);
    *extent = o->part_count ? pbnds_max3(pbnds_sub(hi, lo)) : 1.0f;
}

void gen_object_place(struct gen_world *w, int object, struct pbnds_vec3 translation,
                      struct pbnds_vec4 rotation, float scale)
{
    struct gen_object *o = &w->objects[object];
    o->translation = translation;
    o->rotation = rotation;
    o->scale = scale;
    const struct pbnds_mat4 m =
        pbnds_mat4_from_trs(translation, rotation, pbnds_splat(scale));
    o->lo = pbnds_splat(INFINITY);
    o->hi = pbnds_splat(-INFINITY);
    for (int i = 0; i < o->part_count; ++i) {
        const struct gen_mesh *mesh = gen_part_mesh(w, o->first_part + i);
        for (size_t k = 0; k < mesh->vertex_count; ++k) {
            const struct pbnds_vec3 p = pbnds_mat4_point(&m, mesh->position[k]);
            o->lo = lower(o->lo, p);
            o->hi = upper(o->hi, p);
        }
    }
    if (o->part_count == 0) o->lo = o->hi = translation;
}

void gen_world_normalize(struct gen_world *w, float radius)
{
    struct pbnds_vec3 lo = pbnds_splat(INFINITY), hi = pbnds_splat(-INFINITY);
    for (int i = 0; i < w->object_count; ++i) {
        lo = lower(lo, w->objects[i].lo);
        hi = upper(hi, w->objects[i].hi);
    }
    const struct pbnds_vec3 centre = pbnds_scale(pbnds_add(lo, hi), 0.5f);
    const float size = 0.5f * pbnds_length(pbnds_sub(hi, lo));
    if (!(size > 0.0f)) return;
    const float scale = radius / size;
    for (int i = 0; i < w->object_count; ++i) {
        const struct gen_object *o = &w->objects[i];
        gen_object_place(w, i, pbnds_scale(pbnds_sub(o->translation, centre), scale),
                         o->rotation, o->scale * scale);
    }
    w->camera.eye = pbnds_scale(pbnds_sub(w->camera.eye, centre), scale);
    w->camera.target = pbnds_scale(pbnds_sub(w->camera.target, centre), scale);
}

struct gen_material gen_material_plain(struct pbnds_vec3 base_color, float metallic,
                                       float roughness)
{
    const struct gen_material m = {.base_color = base_color,
                                   .metallic = metallic,
                                   .roughness = roughness,
                                   .ior = 1.5f,
                                   .specular = 1.0f,
                                   .specular_color = {1.0f, 1.0f, 1.0f},
                                   .normal_scale = 1.0f,
                                   .color_image = -1,
                                   .surface_image = -1,
                                   .normal_image = -1,
                                   .repeat = 1.0f,
                                   .alpha = 1.0f};
    return m;
}

bool gen_material_textured(const struct gen_material *m)
{
    return m->color_image >= 0 || m->surface_image >= 0 || m->normal_image >= 0;
}

int gen_world_material(struct gen_world *w, const struct gen_material *material)
{
    if (w->material_count == GEN_MAX_MATERIALS) return GEN_MAX_MATERIALS - 1;
    w->materials[w->material_count] = *material;
    return w->material_count++;
}

static int add_image(struct gen_world *w, const uint8_t *rgb, int width, int height,
                     void (*encode)(struct gen_bytes *, const uint8_t *, int, int))
{
    if (w->image_count == GEN_MAX_IMAGES) return -1;
    struct gen_bytes *image = &w->images[w->image_count];
    *image = (struct gen_bytes){.size = 0};
    encode(image, rgb, width, height);
    if (image->failed) w->failed = true;
    return w->image_count++;
}

int gen_world_image(struct gen_world *w, const uint8_t *rgb, int width, int height)
{
    return add_image(w, rgb, width, height, gen_png);
}

int gen_world_texture(struct gen_world *w, const uint8_t *rgb, int width, int height)
{
    return add_image(w, rgb, width, height, gen_png_fast);
}
