/**
 * @file shader_table.h
 * The rows of the table in shader.c. Private to this folder: others use shader.h.
 */
#ifndef PBNDS_ENGINE_SHADE_SHADER_TABLE_H
#define PBNDS_ENGINE_SHADE_SHADER_TABLE_H

#include "engine/shade/shader.h"

extern const struct pbnds_shader pbnds_shader_blinn_phong, pbnds_shader_ggx,
    pbnds_shader_paper_blinn_phong, pbnds_shader_paper_ggx, pbnds_shader_reference;

/** What every lit model reads. */
enum {
    PBNDS_CHANNELS_LIT = PBNDS_CHANNEL_ALBEDO | PBNDS_CHANNEL_NORMAL |
                         PBNDS_CHANNEL_SPECULAR | PBNDS_CHANNEL_ROUGHNESS |
                         PBNDS_CHANNEL_METALLIC | PBNDS_CHANNEL_POSITION |
                         PBNDS_CHANNEL_EMISSION
};

#endif /* PBNDS_ENGINE_SHADE_SHADER_TABLE_H */
