/* Punctual lights; the equations and their source are in light_punctual.h. */
#include "engine/shade/light_punctual.h"

#include <math.h>

static float range_window(float distance, float range)
{
    const float q = distance / range; /* 0 for an infinite range */
    return pbnds_clamp(1.0f - q * q * q * q, 0.0f, 1.0f);
}

static float cone_falloff(const struct pbnds_light *light, struct pbnds_vec3 wi)
{
    const float cd = -pbnds_dot(light->direction, wi);
    const float width = fmaxf(light->cos_inner - light->cos_outer, 1e-3f);
    const float t = pbnds_clamp((cd - light->cos_outer) / width, 0.0f, 1.0f);
    return t * t;
}

/* The light's share of its intensity that arrives at the point, per square metre. */
static float arriving(const struct pbnds_light *light, struct pbnds_vec3 p,
                      struct pbnds_punctual *out)
{
    if (light->kind == PBNDS_LIGHT_DIRECTIONAL) {
        out->wi = pbnds_scale(light->direction, -1.0f);
        out->distance = INFINITY;
        return 1.0f;
    }
    const struct pbnds_vec3 way = pbnds_sub(light->position, p);
    const float d = pbnds_length(way);
    if (!(d > 0.0f) || !isfinite(d)) return 0.0f;
    out->wi = pbnds_scale(way, 1.0f / d);
    out->distance = d;
    const float cone =
        light->kind == PBNDS_LIGHT_SPOT ? cone_falloff(light, out->wi) : 1.0f;
    return range_window(d, light->range) * cone / (d * d);
}

bool pbnds_light_punctual(const struct pbnds_light *light, struct pbnds_vec3 p,
                          struct pbnds_punctual *out)
{
    const float share = arriving(light, p, out);
    if (!(share > 0.0f)) return false; /* NaN too */
    out->irradiance = pbnds_scale(light->intensity, share);
    const float most = pbnds_max3(out->irradiance);
    return most > 0.0f && isfinite(most);
}
