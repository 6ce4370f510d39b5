/* What pbnds info says of a glTF file. */
#include "engine/scene/gltf.h"
#include "tools/console.h"
#include "tools/facts.h"
#include "tools/world.h"

/* Items are kept as they are made: cJSON counts through a list to find one again, and a
 * hostile file has many. */

static cJSON *add_item(cJSON *list, const struct pbnds_gltf_item *from)
{
    cJSON *item = tool_add_item(list);
    tool_add_text(item, "name", from->name);
    return item;
}

static void add_scenes(const struct pbnds_gltf_contents *c, cJSON *facts)
{
    cJSON *list = cJSON_AddArrayToObject(facts, "scenes");
    for (size_t i = 0; i < c->scene_count; ++i) {
        cJSON *item = add_item(list, &c->scenes[i]);
        tool_add_number(item, "roots", (double)c->scenes[i].count);
        if (i == c->default_scene) (void)cJSON_AddTrueToObject(item, "default");
    }
}

static void add_animations(const struct pbnds_gltf_contents *c, cJSON *facts)
{
    cJSON *list = cJSON_AddArrayToObject(facts, "animations");
    for (size_t i = 0; i < c->animation_count; ++i) {
        cJSON *item = add_item(list, &c->animations[i]);
        tool_add_number(item, "channels", (double)c->animations[i].count);
        tool_add_float(item, "seconds", (float)c->animations[i].seconds);
    }
}

static enum pbnds_status add_contents(const char *path,
                                      const struct pbnds_gltf_options *options,
                                      cJSON *facts, struct pbnds_error *error)
{
    struct pbnds_gltf_contents c;
    PBNDS_TRY(pbnds_gltf_list(path, options, &c, error));
    add_scenes(&c, facts);
    add_animations(&c, facts);
    cJSON *variants = cJSON_AddArrayToObject(facts, "variants");
    for (size_t i = 0; i < c.variant_count; ++i)
        (void)add_item(variants, &c.variants[i]);
    cJSON *skins = cJSON_AddArrayToObject(facts, "skins");
    for (size_t i = 0; i < c.skin_count; ++i) {
        cJSON *item = add_item(skins, &c.skins[i]);
        tool_add_number(item, "joints", (double)c.skins[i].count);
    }
    pbnds_gltf_contents_free(&c);
    return PBNDS_OK;
}

static void add_cameras(const struct pbnds_scene *scene, cJSON *facts)
{
    cJSON *cameras = cJSON_AddArrayToObject(facts, "cameras");
    for (int i = 0; i < scene->camera_count; ++i) {
        const struct pbnds_camera *camera = &scene->cameras[i];
        cJSON *item = tool_add_item(cameras);
        tool_add_text(item, "name", camera->name);
        if (camera->orthographic) {
            tool_add_number(item, "ymag", (double)camera->ymag);
        } else {
            tool_add_number(item, "yfov_deg",
                            (double)(camera->yfov * 180.0f / PBNDS_PI));
        }
    }
}

static void add_lights(const struct pbnds_scene *scene, cJSON *facts)
{
    static const char *const kinds[] = {"directional", "point", "spot"};
    cJSON *lights = cJSON_AddArrayToObject(facts, "lights");
    for (int i = 0; i < scene->light_count; ++i) {
        const struct pbnds_light *light = &scene->lights[i];
        cJSON *item = tool_add_item(lights);
        tool_add_text(item, "name", light->name);
        tool_add_text(item, "kind", kinds[light->kind]);
        if (light->kind != PBNDS_LIGHT_DIRECTIONAL)
            tool_add_vec3(item, "position", light->position);
        if (light->kind != PBNDS_LIGHT_POINT)
            tool_add_vec3(item, "direction", light->direction);
        tool_add_vec3(item, "intensity", light->intensity);
        if (light->range < INFINITY) tool_add_float(item, "range", light->range);
    }
}

enum pbnds_status tool_describe_scene(const struct tool_options *options,
                                      const char *path, cJSON *facts,
                                      struct pbnds_error *error)
{
    struct pbnds_scene scene;
    const struct pbnds_gltf_options gltf = tool_gltf_options(options);
    PBNDS_TRY(pbnds_gltf_load(path, &gltf, tool_report(), &scene, error));
    tool_add_text(facts, "kind", "glTF scene");
    tool_add_number(facts, "meshes", scene.mesh_count);
    tool_add_number(facts, "triangles", (double)scene.triangle_count);
    tool_add_number(facts, "materials", scene.material_count);
    tool_add_number(facts, "textures", scene.texture_count);
    if (scene.triangle_count > 0) {
        tool_add_vec3(facts, "lo", scene.lo);
        tool_add_vec3(facts, "hi", scene.hi);
    }
    cJSON *images = cJSON_AddArrayToObject(facts, "images");
    for (int i = 0; i < scene.image_count; ++i) {
        tool_add_size(tool_add_item(images), scene.images[i].width,
                      scene.images[i].height);
    }
    add_cameras(&scene, facts);
    add_lights(&scene, facts);
    pbnds_scene_free(&scene);
    return add_contents(path, &gltf, facts, error);
}
