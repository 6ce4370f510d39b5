/*
 * From a hit to the values a BRDF needs: interpolation, textures, normal map.
 */
#include "engine/scene/lookup.h"
#include "engine/scene/scene.h"

/* A hit with its triangle looked up. */
struct triangle {
    const struct pbnds_mesh *mesh;
    const struct pbnds_material *material;
    uint32_t i0, i1, i2;
    float w0, w1, w2;
    float footprint, cosine; /* of the ray's cone; |face normal . ray| */
};

static struct triangle find_triangle(const struct pbnds_scene *scene,
                                     const struct pbnds_hit *hit)
{
    struct triangle t;
    t.mesh = &scene->meshes[hit->mesh];
    t.material = &scene->materials[t.mesh->material];
    const uint32_t *index = t.mesh->index + 3 * (size_t)hit->triangle;
    t.i0 = index[0];
    t.i1 = index[1];
    t.i2 = index[2];
    t.w0 = 1.0f - hit->u - hit->v;
    t.w1 = hit->u;
    t.w2 = hit->v;
    t.footprint = t.cosine = 0.0f;
    return t;
}

static struct pbnds_vec3 mix3(const struct triangle *t, const struct pbnds_vec3 *a)
{
    return pbnds_mad(pbnds_mad(pbnds_scale(a[t->i0], t->w0), a[t->i1], t->w1), a[t->i2],
                     t->w2);
}

static struct pbnds_vec2 mix2(const struct triangle *t, const struct pbnds_vec2 *a)
{
    const struct pbnds_vec2 p = a[t->i0], q = a[t->i1], r = a[t->i2];
    return (struct pbnds_vec2){p.x * t->w0 + q.x * t->w1 + r.x * t->w2,
                               p.y * t->w0 + q.y * t->w1 + r.y * t->w2};
}

static struct pbnds_vec4 mix4(const struct triangle *t, const struct pbnds_vec4 *a)
{
    const struct pbnds_vec4 p = a[t->i0], q = a[t->i1], r = a[t->i2];
    return (struct pbnds_vec4){p.x * t->w0 + q.x * t->w1 + r.x * t->w2,
                               p.y * t->w0 + q.y * t->w1 + r.y * t->w2,
                               p.z * t->w0 + q.z * t->w1 + r.z * t->w2,
                               p.w * t->w0 + q.w * t->w1 + r.w * t->w2};
}

/* KHR_texture_transform. */
static struct pbnds_vec2 transform_uv(const struct pbnds_texture_ref *ref,
                                      struct pbnds_vec2 uv)
{
    if (!ref->transformed) return uv;
    const float *m = ref->transform;
    return (struct pbnds_vec2){m[0] * uv.x + m[1] * uv.y + m[2],
                               m[3] * uv.x + m[4] * uv.y + m[5]};
}

static struct pbnds_vec3 face_cross(const struct triangle *t)
{
    const struct pbnds_vec3 *p = t->mesh->position;
    return pbnds_cross(pbnds_sub(p[t->i1], p[t->i0]), pbnds_sub(p[t->i2], p[t->i0]));
}

/* How many levels of the bundle the ray's cone covers. */
static float level_of(const struct triangle *t, const struct pbnds_bundle *b)
{
    const struct pbnds_vec2 *uv = t->mesh->uv[b->texcoord == 1 ? 1 : 0];
    const float u1 = uv[t->i1].x - uv[t->i0].x, v1 = uv[t->i1].y - uv[t->i0].y;
    const float u2 = uv[t->i2].x - uv[t->i0].x, v2 = uv[t->i2].y - uv[t->i0].y;
    return pbnds_cone_lod(t->footprint, t->cosine, fabsf(u1 * v2 - u2 * v1),
                          pbnds_length(face_cross(t)), b->density);
}

/* The bundle that holds a map of the hit's material; NULL: the finest level is read. */
static const struct pbnds_bundle *bundle_of(const struct pbnds_scene *scene,
                                            const struct triangle *t, int map)
{
    if (!scene->maps || !(t->footprint > 0.0f)) return NULL;
    const int i = scene->maps->materials[t->mesh->material].bundle[map];
    return i < 0 ? NULL : &scene->maps->bundles[i];
}

/* Value of a map at the hit; false when there is none, or no UV set to look it up
 * with (then the factor stands alone). */
static bool sample(const struct pbnds_scene *scene, const struct triangle *t,
                   const struct pbnds_texture_ref *ref, int map, bool srgb,
                   struct pbnds_vec4 *value)
{
    if (ref->texture < 0) return false;
    const struct pbnds_vec2 *uv = t->mesh->uv[ref->texcoord == 1 ? 1 : 0];
    if (!uv) return false;
    const struct pbnds_bundle *b = bundle_of(scene, t, map);
    if (b) {
        float values[PBNDS_BUNDLE_CHANNELS];
        pbnds_bundle_sample(b, mix2(t, uv), level_of(t, b), values);
        *value = pbnds_map_value(b, map, values);
    } else {
        *value = pbnds_texture_sample(&scene->textures[ref->texture],
                                      transform_uv(ref, mix2(t, uv)), srgb);
    }
    return true;
}

/* Base colour and alpha: factor x vertex colour x texture. */
static struct pbnds_vec4 base_color(const struct pbnds_scene *scene,
                                    const struct triangle *t)
{
    struct pbnds_vec4 c = t->material->base_color, s;
    if (t->mesh->color) {
        s = mix4(t, t->mesh->color);
        c = (struct pbnds_vec4){c.x * s.x, c.y * s.y, c.z * s.z, c.w * s.w};
    }
    if (sample(scene, t, &t->material->base_color_texture, PBNDS_MAP_BASE_COLOR, true,
               &s)) {
        c = (struct pbnds_vec4){c.x * s.x, c.y * s.y, c.z * s.z, c.w * s.w};
    }
    return c;
}

/* a / |a|, or `otherwise` where a has no direction. Squares of very short or long
 * vectors leave the range of float, so those are scaled first. */
static struct pbnds_vec3 unit_or(struct pbnds_vec3 a, struct pbnds_vec3 otherwise)
{
    float square = pbnds_dot(a, a);
    if (!(square > 1e-30f && square < 1e30f)) {
        const float largest = fmaxf(fabsf(a.x), fmaxf(fabsf(a.y), fabsf(a.z)));
        if (!(largest > 1e-37f && largest < INFINITY)) return otherwise;
        a = pbnds_vec3_make(a.x / largest, a.y / largest, a.z / largest);
        square = pbnds_dot(a, a);
        if (!(square >= 1.0f)) return otherwise; /* one component was NaN */
    }
    return pbnds_scale(a, 1.0f / sqrtf(square));
}

static struct pbnds_vec3 face_normal(const struct triangle *t,
                                     struct pbnds_vec3 otherwise)
{
    struct pbnds_vec3 n = face_cross(t);
    const float square = pbnds_dot(n, n);
    if (!(square > 1e-30f && square < 1e30f)) {
        /* The cross product squares lengths: take it of edges near unit length. */
        const struct pbnds_vec3 zero = {0.0f, 0.0f, 0.0f};
        const struct pbnds_vec3 *p = t->mesh->position;
        const struct pbnds_vec3 e1 = pbnds_sub(p[t->i1], p[t->i0]);
        const struct pbnds_vec3 e2 = pbnds_sub(p[t->i2], p[t->i0]);
        n = pbnds_cross(unit_or(e1, zero), unit_or(e2, zero));
        if (!(pbnds_dot(n, n) > 1e-12f)) return otherwise;
    }
    return unit_or(n, otherwise);
}

/* Tangent and the sign of the bitangent from the UVs of one face, for meshes that bring
 * no tangents. glTF: v points down in the image, the normal map's +y up, so the
 * bitangent is -dP/dv. */
static bool face_tangent(const struct triangle *t, const struct pbnds_texture_ref *ref,
                         struct pbnds_vec3 n, struct pbnds_vec3 *tangent, float *sign)
{
    const struct pbnds_vec2 *uv = t->mesh->uv[ref->texcoord == 1 ? 1 : 0];
    const struct pbnds_vec2 uv0 = transform_uv(ref, uv[t->i0]);
    const struct pbnds_vec2 uv1 = transform_uv(ref, uv[t->i1]);
    const struct pbnds_vec2 uv2 = transform_uv(ref, uv[t->i2]);
    const struct pbnds_vec3 *p = t->mesh->position;
    const struct pbnds_vec3 e1 = pbnds_sub(p[t->i1], p[t->i0]);
    const struct pbnds_vec3 e2 = pbnds_sub(p[t->i2], p[t->i0]);
    const float u1 = uv1.x - uv0.x, v1 = uv1.y - uv0.y;
    const float u2 = uv2.x - uv0.x, v2 = uv2.y - uv0.y;
    const float det = u1 * v2 - u2 * v1;
    if (!(fabsf(det) > 0.0f)) return false;
    const float flip = det < 0.0f ? -1.0f : 1.0f;
    *tangent = pbnds_scale(pbnds_sub(pbnds_scale(e1, v2), pbnds_scale(e2, v1)), flip);
    const struct pbnds_vec3 down =
        pbnds_scale(pbnds_sub(pbnds_scale(e2, u1), pbnds_scale(e1, u2)), flip);
    *sign = pbnds_dot(pbnds_cross(n, *tangent), down) > 0.0f ? -1.0f : 1.0f;
    return true;
}

/* glTF 2.0, 3.9.3: the map is (2 rgb - 1) * (scale, scale, 1) in the frame (t, b, n)
 * with b = cross(n, t) * w. n is the interpolated vertex normal, not yet turned to the
 * eye. */
static struct pbnds_vec3 apply_normal_map(const struct pbnds_scene *scene,
                                          const struct triangle *t, struct pbnds_vec3 n)
{
    const struct pbnds_texture_ref *ref = &t->material->normal_texture;
    struct pbnds_vec4 texel;
    if (!sample(scene, t, ref, PBNDS_MAP_NORMAL, false, &texel)) return n;

    struct pbnds_vec3 tangent;
    float sign;
    if (t->mesh->tangent) {
        const struct pbnds_vec4 mixed = mix4(t, t->mesh->tangent);
        tangent = pbnds_vec3_make(mixed.x, mixed.y, mixed.z);
        sign = mixed.w < 0.0f ? -1.0f : 1.0f;
    } else if (!face_tangent(t, ref, n, &tangent, &sign)) {
        return n;
    }
    const struct pbnds_vec3 zero = {0.0f, 0.0f, 0.0f};
    tangent = unit_or(tangent, zero);
    tangent = pbnds_mad(tangent, n, -pbnds_dot(tangent, n));
    if (!(pbnds_dot(tangent, tangent) > 1e-12f)) return n;
    tangent = pbnds_normalize(tangent);
    const struct pbnds_vec3 bitangent = pbnds_scale(pbnds_cross(n, tangent), sign);

    const float x = (2.0f * texel.x - 1.0f) * t->material->normal_scale;
    const float y = (2.0f * texel.y - 1.0f) * t->material->normal_scale;
    const float z = 2.0f * texel.z - 1.0f;
    const struct pbnds_vec3 mapped =
        pbnds_mad(pbnds_mad(pbnds_scale(tangent, x), bitangent, y), n, z);
    return unit_or(mapped, n);
}

struct pbnds_vec3 pbnds_face_eye(struct pbnds_vec3 n, struct pbnds_vec3 wo)
{
    const float cosine = pbnds_dot(n, wo);
    if (cosine > 0.5f * PBNDS_FACING)
        return n; /* half: what was turned once stays as it is */
    /* The unit vector at that cosine in the plane of n and wo. */
    const struct pbnds_vec3 side = pbnds_mad(n, wo, -cosine);
    if (!(pbnds_dot(side, side) > 1e-12f))
        return wo; /* n = -wo: every side is as near */
    return pbnds_mad(
        pbnds_scale(pbnds_normalize(side), sqrtf(1.0f - PBNDS_FACING * PBNDS_FACING)),
        wo, PBNDS_FACING);
}

/* n, or, where the face would hide what a smooth surface mirrors, n bent toward the face's
 * normal until it just does not. With n at the angle phi from ng, toward x, and wo.ng = a,
 * wo.x = b, R^2 = a^2 + b^2, the mirror direction 2 (n.wo) n - wo rises
 *     a cos(2 phi) + b sin(2 phi)
 * above the face: a = 0 or more at phi = 0, and the greatest angle at which it is h has
 *     cos(2 phi) = (a h - b sqrt(R^2 - h^2)) / R^2.
 * h is PBNDS_LEAVING, or a / 2 where that is less: n = ng is never bent. The result is
 * continuous in n and wo, and faces the eye, for (n.wo) (n.ng) = (a + h) / 2. */
static struct pbnds_vec3 leave_face(struct pbnds_vec3 n, struct pbnds_vec3 ng,
                                    struct pbnds_vec3 wo)
{
    const float a = pbnds_dot(wo, ng), up = pbnds_dot(n, ng);
    const float h = fminf(PBNDS_LEAVING, 0.5f * a);
    if (2.0f * pbnds_dot(n, wo) * up - a >= h) return n;
    struct pbnds_vec3 x = pbnds_mad(n, ng, -up);
    if (!(pbnds_dot(x, x) > 1e-12f)) return n;
    x = pbnds_normalize(x);
    const float b = pbnds_dot(wo, x), square = a * a + b * b;
    if (!(square > 1e-12f)) return n;
    const float c = pbnds_clamp(
        (a * h - b * sqrtf(fmaxf(square - h * h, 0.0f))) / square, -1.0f, 1.0f);
    return unit_or(
        pbnds_mad(pbnds_scale(ng, sqrtf(0.5f + 0.5f * c)), x, sqrtf(0.5f - 0.5f * c)),
        n);
}

/* The shading normal: interpolated, mapped, above the face, facing the eye, and such that
 * the face does not hide what it mirrors. */
static struct pbnds_vec3 shading_normal(const struct pbnds_scene *scene,
                                        const struct triangle *t,
                                        struct pbnds_vec3 face, struct pbnds_vec3 ng,
                                        struct pbnds_vec3 wo)
{
    struct pbnds_vec3 smooth = face;
    if (t->mesh->normal) smooth = unit_or(mix3(t, t->mesh->normal), face);
    /* Back faces, and normals that disagree with the winding: the frame is turned as a
     * whole, after the map was applied in it. */
    const bool turned = pbnds_dot(smooth, ng) < 0.0f;
    struct pbnds_vec3 n = apply_normal_map(scene, t, smooth);
    if (turned) n = pbnds_scale(n, -1.0f);
    /* A steep map may still dip below the face: lift it onto the face's plane. */
    const float above = pbnds_dot(n, ng);
    if (above < 0.0f) n = unit_or(pbnds_mad(n, ng, -above), ng);
    /* Turning toward wo keeps n above the face, as dot(wo, ng) >= 0. */
    return pbnds_face_eye(leave_face(n, ng, wo), wo);
}

static float unit(float x)
{
    return pbnds_clamp(x, 0.0f, 1.0f);
}

static struct pbnds_vec3 unit3(struct pbnds_vec3 a)
{
    return pbnds_vec3_make(unit(a.x), unit(a.y), unit(a.z));
}

/* specular_color times its texture, which for specular-glossiness holds the glossiness
 * in alpha: 1 where there is no texture. */
static struct pbnds_vec4 specular_color(const struct pbnds_scene *scene,
                                        const struct triangle *t)
{
    const struct pbnds_material *m = t->material;
    struct pbnds_vec4 s = {1.0f, 1.0f, 1.0f, 1.0f};
    (void)sample(scene, t, &m->specular_color_texture, PBNDS_MAP_SPECULAR_COLOR, true,
                 &s);
    return (struct pbnds_vec4){s.x * m->specular_color.x, s.y * m->specular_color.y,
                               s.z * m->specular_color.z, s.w};
}

/* glTF 2.0, 3.9.2, with KHR_materials_ior and KHR_materials_specular. */
static void metallic_roughness(const struct pbnds_scene *scene,
                               const struct triangle *t, struct pbnds_surface *surface)
{
    const struct pbnds_material *m = t->material;
    struct pbnds_vec4 s;
    float roughness = m->roughness, metallic = m->metallic, specular = m->specular;
    if (sample(scene, t, &m->metallic_roughness_texture, PBNDS_MAP_METALLIC_ROUGHNESS,
               false, &s)) {
        roughness *= s.y;
        metallic *= s.z;
    }
    if (sample(scene, t, &m->specular_texture, PBNDS_MAP_SPECULAR, false, &s))
        specular *= s.w;
    const struct pbnds_vec4 color = specular_color(scene, t);
    const struct pbnds_vec3 f0 = pbnds_vec3_make(fminf(m->ior_f0 * color.x, 1.0f),
                                                 fminf(m->ior_f0 * color.y, 1.0f),
                                                 fminf(m->ior_f0 * color.z, 1.0f));
    surface->roughness = unit(roughness);
    surface->metallic = unit(metallic);
    surface->f0 = unit3(pbnds_scale(f0, specular));
    surface->f90 = unit(specular);
}

/* KHR_materials_pbrSpecularGlossiness; base_color comes in as the diffuse colour. */
static void specular_glossiness(const struct pbnds_scene *scene,
                                const struct triangle *t, struct pbnds_surface *surface)
{
    const struct pbnds_vec4 color = specular_color(scene, t);
    surface->f0 = unit3(pbnds_vec3_make(color.x, color.y, color.z));
    surface->f90 = 1.0f;
    surface->roughness = unit(1.0f - (1.0f - t->material->roughness) * color.w);
    surface->metallic = 0.0f;
    surface->base_color =
        pbnds_scale(surface->base_color, 1.0f - pbnds_max3(surface->f0));
}

/* KHR_materials_unlit: what it shows is light of its own. */
static void unlit(struct pbnds_surface *surface)
{
    const struct pbnds_vec3 black = {0.0f, 0.0f, 0.0f};
    surface->emission = surface->base_color;
    surface->base_color = surface->f0 = black;
    surface->f90 = surface->metallic = 0.0f;
    surface->roughness = 1.0f;
}

static void evaluate_material(const struct pbnds_scene *scene, const struct triangle *t,
                              struct pbnds_surface *surface)
{
    const struct pbnds_material *m = t->material;
    const struct pbnds_vec4 base = base_color(scene, t);
    surface->base_color = unit3(pbnds_vec3_make(base.x, base.y, base.z));
    surface->alpha = m->alpha_mode == PBNDS_ALPHA_OPAQUE ? 1.0f : unit(base.w);
    struct pbnds_vec4 s;
    surface->occlusion = 1.0f;
    if (sample(scene, t, &m->occlusion_texture, PBNDS_MAP_OCCLUSION, false, &s))
        surface->occlusion = unit(1.0f + m->occlusion_strength * (s.x - 1.0f));
    if (m->unlit) {
        unlit(surface);
        return;
    }
    surface->emission = m->emissive;
    if (pbnds_max3(m->emissive) > 0.0f &&
        sample(scene, t, &m->emissive_texture, PBNDS_MAP_EMISSIVE, true, &s))
        surface->emission = pbnds_mul(m->emissive, pbnds_vec3_make(s.x, s.y, s.z));
    if (m->specular_glossiness)
        specular_glossiness(scene, t, surface);
    else
        metallic_roughness(scene, t, surface);
}

void pbnds_scene_surface(const struct pbnds_scene *scene, const struct pbnds_hit *hit,
                         struct pbnds_vec3 wo, float footprint,
                         struct pbnds_surface *surface)
{
    struct triangle t = find_triangle(scene, hit);
    surface->position = mix3(&t, t.mesh->position);
    const struct pbnds_vec3 face = face_normal(&t, wo);
    const float facing = pbnds_dot(face, wo);
    surface->ng = facing < 0.0f ? pbnds_scale(face, -1.0f) : face;
    t.footprint = footprint;
    t.cosine = fabsf(facing);
    surface->n = shading_normal(scene, &t, face, surface->ng, wo);
    evaluate_material(scene, &t, surface);
    surface->uv =
        t.mesh->uv[0] ? mix2(&t, t.mesh->uv[0]) : (struct pbnds_vec2){0.0f, 0.0f};
    surface->object_id = t.mesh->object_id;
    surface->material = t.mesh->material;
}

struct pbnds_vec3 pbnds_scene_previous(const struct pbnds_scene *scene,
                                       const struct pbnds_hit *hit)
{
    const struct triangle t = find_triangle(scene, hit);
    return mix3(&t, t.mesh->previous ? t.mesh->previous : t.mesh->position);
}

float pbnds_scene_alpha(const struct pbnds_scene *scene, const struct pbnds_hit *hit)
{
    const struct triangle t = find_triangle(scene, hit);
    if (t.material->alpha_mode == PBNDS_ALPHA_OPAQUE) return 1.0f;
    return base_color(scene, &t).w;
}
