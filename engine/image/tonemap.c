#include "engine/image/tonemap.h"

#include <string.h>

#include "engine/core/color.h"

static const char *const names[] = {
    [PBNDS_TONEMAP_PBR_NEUTRAL] = "pbr-neutral",
    [PBNDS_TONEMAP_NONE] = "none",
    [PBNDS_TONEMAP_REINHARD] = "reinhard",
};

/* Khronos PBR Neutral 1.0: colours below 0.8 - 0.04 only lose the 4 % that a dielectric
 * reflects (so that a base colour comes out as it went in); above, the peak is
 * compressed by a hyperbola towards 1 and the colour is faded to white.
 * https://github.com/KhronosGroup/ToneMapping/tree/main/PBR_Neutral */
static struct pbnds_vec3 pbr_neutral(struct pbnds_vec3 c)
{
    const float f90 = 0.04f, start = 0.8f - f90, desaturation = 0.15f;
    const float lowest = fminf(c.x, fminf(c.y, c.z));
    const float offset = lowest < 0.08f ? lowest - 6.25f * lowest * lowest : f90;
    c = pbnds_sub(c, pbnds_splat(offset));
    const float peak = pbnds_max3(c);
    if (peak < start) return c;
    const float d = 1.0f - start;
    const float new_peak = 1.0f - d * d / (peak + d - start);
    c = pbnds_scale(c, new_peak / peak);
    const float white = 1.0f - 1.0f / (desaturation * (peak - new_peak) + 1.0f);
    return pbnds_lerp(c, pbnds_splat(new_peak), white);
}

/* NaN and negatives to 0; infinity to a number that every curve maps to its white. */
static float tame(float x)
{
    return x > 0.0f ? fminf(x, 1e30f) : 0.0f;
}

struct pbnds_vec3 pbnds_display_color(const struct pbnds_display *display,
                                      struct pbnds_vec3 linear)
{
    const float gain = exp2f(display->exposure_ev);
    struct pbnds_vec3 c = pbnds_vec3_make(tame(gain * linear.x), tame(gain * linear.y),
                                          tame(gain * linear.z));
    switch (display->tonemap) {
    case PBNDS_TONEMAP_PBR_NEUTRAL:
        c = pbr_neutral(c);
        break;
    case PBNDS_TONEMAP_REINHARD:
        c = pbnds_vec3_make(c.x / (1.0f + c.x), c.y / (1.0f + c.y), c.z / (1.0f + c.z));
        break;
    case PBNDS_TONEMAP_NONE:
        break;
    }
    return pbnds_vec3_make(pbnds_srgb_encode(c.x), pbnds_srgb_encode(c.y),
                           pbnds_srgb_encode(c.z));
}

void pbnds_display_image(const struct pbnds_display *display,
                         const struct pbnds_image *src, struct pbnds_image *dst)
{
    const size_t count = (size_t)src->width * (size_t)src->height;
    for (size_t i = 0; i < count; ++i) {
        const float *in = src->data + 3 * i;
        float *out = dst->data + 3 * i;
        const struct pbnds_vec3 c =
            pbnds_display_color(display, pbnds_vec3_make(in[0], in[1], in[2]));
        out[0] = c.x;
        out[1] = c.y;
        out[2] = c.z;
    }
}

int pbnds_tonemap_parse(const char *name, enum pbnds_tonemap *tonemap)
{
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strcmp(name, names[i]) != 0) continue;
        *tonemap = (enum pbnds_tonemap)i;
        return 1;
    }
    return 0;
}

const char *pbnds_tonemap_name(enum pbnds_tonemap tonemap)
{
    return names[tonemap];
}
