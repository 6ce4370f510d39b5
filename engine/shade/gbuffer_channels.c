#include "engine/shade/gbuffer_channels.h"

#include <string.h>

#define PLANE(member) offsetof(struct pbnds_gbuffer, member)
/* offsetof an element of an array member */
#define PART(member, c) (offsetof(struct pbnds_gbuffer, member) + (c) * sizeof(float *))

#define HALF  PBNDS_EXR_HALF
#define FLOAT PBNDS_EXR_FLOAT

/*
 * Colours and the scalars of [0, 1] are half, whose step of 2^-11 is finer than the 8-bit
 * textures they come from. Depth and position are float, and so are normals: half turns a
 * normal by up to 3e-4 radian, a third of the narrowest GGX lobe (alpha = 1e-3), which
 * shows as facets in sharp reflections. Texture coordinates and motion are float because
 * half is coarser than a texel of a 4K texture, and than a hundredth of a pixel.
 */
static const struct pbnds_gbuffer_channel channels[] = {
    {"albedo.R", PART(albedo, 0), PBNDS_CHANNEL_UNIT, HALF, true, 0},
    {"albedo.G", PART(albedo, 1), PBNDS_CHANNEL_UNIT, HALF, true, 0},
    {"albedo.B", PART(albedo, 2), PBNDS_CHANNEL_UNIT, HALF, true, 0},
    {"normal.X", PART(normal, 0), PBNDS_CHANNEL_AXIS, FLOAT, true, 0},
    {"normal.Y", PART(normal, 1), PBNDS_CHANNEL_AXIS, FLOAT, true, 0},
    {"normal.Z", PART(normal, 2), PBNDS_CHANNEL_AXIS, FLOAT, true, 0},
    {"Z", PLANE(depth), PBNDS_CHANNEL_METRES, FLOAT, true, 0},
    {"roughness.R", PLANE(roughness), PBNDS_CHANNEL_UNIT, HALF, true, 0},
    {"specular.R", PLANE(specular), PBNDS_CHANNEL_UNIT, HALF, false, 0},
    {"metallic.R", PLANE(metallic), PBNDS_CHANNEL_UNIT, HALF, false, 0},
    {"coverage.A", PLANE(coverage), PBNDS_CHANNEL_UNIT, HALF, false, 0},
    {"position.X", PART(position, 0), PBNDS_CHANNEL_REAL, FLOAT, false, 0},
    {"position.Y", PART(position, 1), PBNDS_CHANNEL_REAL, FLOAT, false, 0},
    {"position.Z", PART(position, 2), PBNDS_CHANNEL_REAL, FLOAT, false, 0},
    {"emission.R", PART(emission, 0), PBNDS_CHANNEL_LIGHT, HALF, false, 0},
    {"emission.G", PART(emission, 1), PBNDS_CHANNEL_LIGHT, HALF, false, 0},
    {"emission.B", PART(emission, 2), PBNDS_CHANNEL_LIGHT, HALF, false, 0},
    {"object_id", PLANE(object_id), PBNDS_CHANNEL_ID, PBNDS_EXR_UINT, false, 0},
    {"f0.R", PART(f0, 0), PBNDS_CHANNEL_UNIT, HALF, false, PBNDS_GBUFFER_FRESNEL},
    {"f0.G", PART(f0, 1), PBNDS_CHANNEL_UNIT, HALF, false, PBNDS_GBUFFER_FRESNEL},
    {"f0.B", PART(f0, 2), PBNDS_CHANNEL_UNIT, HALF, false, PBNDS_GBUFFER_FRESNEL},
    {"f90.R", PLANE(f90), PBNDS_CHANNEL_UNIT, HALF, false, PBNDS_GBUFFER_FRESNEL},
    {"ao.R", PLANE(ao), PBNDS_CHANNEL_UNIT, HALF, false, PBNDS_OPTIONAL_AO},
    {"uv.U", PART(uv, 0), PBNDS_CHANNEL_REAL, FLOAT, false, PBNDS_OPTIONAL_UV},
    {"uv.V", PART(uv, 1), PBNDS_CHANNEL_REAL, FLOAT, false, PBNDS_OPTIONAL_UV},
    {"motion.U", PART(motion, 0), PBNDS_CHANNEL_REAL, FLOAT, false,
     PBNDS_OPTIONAL_MOTION},
    {"motion.V", PART(motion, 1), PBNDS_CHANNEL_REAL, FLOAT, false,
     PBNDS_OPTIONAL_MOTION},
    {"material_id", PLANE(material_id), PBNDS_CHANNEL_ID, PBNDS_EXR_UINT, false,
     PBNDS_OPTIONAL_MATERIAL_ID},
};

enum { CHANNELS = sizeof channels / sizeof channels[0] };

const struct pbnds_gbuffer_channel *pbnds_gbuffer_channel_at(int i)
{
    return i >= 0 && i < CHANNELS ? &channels[i] : NULL;
}

int pbnds_gbuffer_channel_count(void)
{
    return CHANNELS;
}

float *pbnds_gbuffer_real(const struct pbnds_gbuffer *gbuffer,
                          const struct pbnds_gbuffer_channel *channel)
{
    float *plane = NULL;
    memcpy(&plane, (const char *)gbuffer + channel->plane, sizeof plane);
    return plane;
}

uint32_t *pbnds_gbuffer_id(const struct pbnds_gbuffer *gbuffer,
                           const struct pbnds_gbuffer_channel *channel)
{
    uint32_t *plane = NULL;
    memcpy(&plane, (const char *)gbuffer + channel->plane, sizeof plane);
    return plane;
}
