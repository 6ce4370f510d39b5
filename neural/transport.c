#include "neural/transport.h"

enum { SPECULAR_SAMPLES = 24 };

static float sigmoid(float x)
{
    return 1.0f / (1.0f + expf(-x));
}

float pbnds_transport_visibility(float v)
{
    return sigmoid(v + 1.0f);
}

float pbnds_transport_indirect(float s)
{
    const float x = s - 2.0f;
    return x > 15.0f ? x : log1pf(expf(x));
}

float pbnds_transport_indirect_slope(float s)
{
    return sigmoid(s - 2.0f);
}

float pbnds_transport_occlusion(float o)
{
    return sigmoid(o + 2.0f);
}

struct pbnds_transport_pixel pbnds_transport_pixel(const struct pbnds_view *view,
                                                   size_t i)
{
    struct pbnds_transport_pixel p = {.covered =
                                          view->plane[PBNDS_PLANE_MASK][i] > 0.0f};
    if (!p.covered) return p;
    /* The view's planes are a G-buffer whose world is the camera's space. */
    float *const *plane = view->plane;
    const struct pbnds_gbuffer g = {
        .width = view->width,
        .height = view->height,
        .albedo = {plane[PBNDS_PLANE_ALBEDO_R], plane[PBNDS_PLANE_ALBEDO_G],
                   plane[PBNDS_PLANE_ALBEDO_B]},
        .normal = {plane[PBNDS_PLANE_NORMAL_X], plane[PBNDS_PLANE_NORMAL_Y],
                   plane[PBNDS_PLANE_NORMAL_Z]},
        .specular = plane[PBNDS_PLANE_SPECULAR],
        .roughness = plane[PBNDS_PLANE_ROUGHNESS],
        .metallic = plane[PBNDS_PLANE_METALLIC],
    };
    p.bsdf = pbnds_bsdf_from_gbuffer(&g, i);
    p.wo = pbnds_vec3_make(plane[PBNDS_PLANE_WO_X][i], plane[PBNDS_PLANE_WO_Y][i],
                           plane[PBNDS_PLANE_WO_Z][i]);
    p.b = pbnds_add(p.bsdf.c_diff, p.bsdf.ggx.f0);
    p.cluster_weight = pbnds_clamp((p.bsdf.ggx.alpha - 0.1f) / 0.2f, 0.0f, 1.0f);
    return p;
}

struct pbnds_vec3 pbnds_transport_direct(const struct pbnds_transport_pixel *pixel,
                                         struct pbnds_vec3 wi)
{
    const float cosine = pbnds_dot(pixel->bsdf.frame.n, wi);
    if (cosine <= 0.0f) return pbnds_splat(0.0f);
    const struct pbnds_vec3 diffuse = pbnds_bsdf_diffuse(&pixel->bsdf, pixel->wo, wi);
    if (pixel->cluster_weight <= 0.0f) return pbnds_scale(diffuse, cosine);
    const struct pbnds_vec3 all = pbnds_bsdf_eval(&pixel->bsdf, pixel->wo, wi);
    return pbnds_scale(pbnds_lerp(diffuse, all, pixel->cluster_weight), cosine);
}

struct pbnds_vec3 pbnds_transport_outgoing(const struct pbnds_transport_pixel *pixel,
                                           struct pbnds_vec3 wi,
                                           const float out[PBNDS_OUT_COUNT])
{
    const struct pbnds_vec3 s = {pbnds_transport_indirect(out[PBNDS_OUT_INDIRECT]),
                                 pbnds_transport_indirect(out[PBNDS_OUT_INDIRECT + 1]),
                                 pbnds_transport_indirect(out[PBNDS_OUT_INDIRECT + 2])};
    const struct pbnds_vec3 direct =
        pbnds_scale(pbnds_transport_direct(pixel, wi),
                    pbnds_transport_visibility(out[PBNDS_OUT_VISIBILITY]));
    return pbnds_add(direct, pbnds_mul(pixel->b, s));
}

static struct pbnds_vec3 camera_to_world(const struct pbnds_camera *camera,
                                         struct pbnds_vec3 v)
{
    return pbnds_mat4_vector(&camera->world_from_camera, v);
}

/* Hammersley point j of n: (j / n, van der Corput(j)). */
static float radical_inverse(unsigned j)
{
    j = (j << 16) | (j >> 16);
    j = ((j & 0x00ff00ffu) << 8) | ((j & 0xff00ff00u) >> 8);
    j = ((j & 0x0f0f0f0fu) << 4) | ((j & 0xf0f0f0f0u) >> 4);
    j = ((j & 0x33333333u) << 2) | ((j & 0xccccccccu) >> 2);
    j = ((j & 0x55555555u) << 1) | ((j & 0xaaaaaaaau) >> 1);
    return (float)(j >> 8) * 0x1p-24f;
}

int pbnds_transport_looks(const struct pbnds_transport_pixel *pixel,
                          const struct pbnds_camera *camera, int count,
                          struct pbnds_transport_look *looks)
{
    if (!pixel->covered || pixel->cluster_weight >= 1.0f) return 0;
    const struct pbnds_vec3 wo = pbnds_to_local(&pixel->bsdf.frame, pixel->wo);
    if (wo.z <= 0.0f) return 0;
    int n = 0;
    for (int j = 0; j < count; ++j) {
        struct pbnds_brdf_sample s;
        const float u1 = ((float)j + 0.5f) / (float)count;
        if (!pbnds_ggx_sample(&pixel->bsdf.ggx, wo, u1, radical_inverse((unsigned)j),
                              &s) ||
            !(s.pdf > 0.0f)) {
            continue;
        }
        looks[n++] = (struct pbnds_transport_look){
            .wi = camera_to_world(camera, pbnds_to_world(&pixel->bsdf.frame, s.wi)),
            .solid_angle = fminf(1.0f / ((float)count * s.pdf), 4.0f * PBNDS_PI),
            .f = s.f,
            .factor = s.wi.z / s.pdf};
    }
    return n;
}

struct pbnds_vec3 pbnds_transport_specular(const struct pbnds_transport_pixel *pixel,
                                           const struct pbnds_view *view,
                                           const struct pbnds_envmap *envmap)
{
    struct pbnds_transport_look looks[SPECULAR_SAMPLES];
    const int n = pbnds_transport_looks(pixel, &view->camera, SPECULAR_SAMPLES, looks);
    struct pbnds_vec3 sum = pbnds_splat(0.0f);
    for (int j = 0; j < n; ++j) {
        const struct pbnds_vec3 radiance =
            pbnds_envmap_eval_cone(envmap, looks[j].wi, looks[j].solid_angle);
        sum = pbnds_add(sum,
                        pbnds_scale(pbnds_mul(looks[j].f, radiance), looks[j].factor));
    }
    return pbnds_scale(sum, (1.0f - pixel->cluster_weight) / SPECULAR_SAMPLES);
}
