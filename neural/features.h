/**
 * @file features.h
 * The feature tables: which channel of a network's input is which plane, how scaled.
 * One table a model, used for training and for rendering alike; a change of a table is
 * a new version of the model.
 *
 * A row's value is (plane - offset) * scale, then its transfer, then, in a table with
 * bands > 0, the positional encoding of Mildenhall et al. 2020: identity, then for k in
 * [0, bands) sin(2^k x) for all rows, cos(2^k x) for all rows (frequency-major, no pi).
 */
#ifndef PBNDS_NEURAL_FEATURES_H
#define PBNDS_NEURAL_FEATURES_H

#include "neural/view.h"

/** Planes of one light at one pixel, camera space; all 0 where nothing was hit. */
enum pbnds_light_plane {
    PBNDS_LIGHT_N_DOT_L, /**< max(n.l, 0) */
    PBNDS_LIGHT_N_DOT_L_SIGNED,
    PBNDS_LIGHT_X, /**< direction to the light */
    PBNDS_LIGHT_Y,
    PBNDS_LIGHT_Z,
    PBNDS_LIGHT_MARCH_THIN, /**< 1: open, 0: blocked (view.h) */
    PBNDS_LIGHT_MARCH_THICK,
    PBNDS_LIGHT_HORIZON, /**< the light's place against the horizon at its azimuth, 0..1
                          */
    PBNDS_LIGHT_RADIANCE_R, /**< L_i max(n.l, 0) */
    PBNDS_LIGHT_RADIANCE_G,
    PBNDS_LIGHT_RADIANCE_B,
    PBNDS_LIGHT_PLANE_COUNT,
};

enum pbnds_transfer { PBNDS_TRANSFER_LINEAR, PBNDS_TRANSFER_LOG1P };

struct pbnds_feature {
    const char *name;
    int plane; /**< enum pbnds_plane, or enum pbnds_light_plane in a light table */
    float scale, offset;
    enum pbnds_transfer transfer;
};

struct pbnds_feature_table {
    const struct pbnds_feature *view;
    int view_count;
    const struct pbnds_feature *light;
    int light_count;
    int bands; /**< of the positional encoding, 0: none */
};

/** One light for the light planes. */
struct pbnds_light_source {
    struct pbnds_vec3 wi;       /**< unit, world */
    struct pbnds_vec3 radiance; /**< for the RADIANCE planes */
    int bit;                    /**< which bit of the march masks is this light's */
};

extern const struct pbnds_feature_table pbnds_features_transport;
extern const struct pbnds_feature_table pbnds_features_pbnds_plus;

#ifdef __cplusplus
extern "C" {
#endif

/** Channels of the encoded inputs. */
int pbnds_features_view_channels(const struct pbnds_feature_table *table);
int pbnds_features_light_channels(const struct pbnds_feature_table *table);

/** dst: [window.height, window.width, channels] float32. The view covers what the window
 * has of the image. */
void pbnds_features_view(const struct pbnds_feature_table *table,
                         const struct pbnds_view *view, struct pbnds_window window,
                         float *dst);
/** The same for one light; march may be NULL where the table has no march planes. */
void pbnds_features_light(const struct pbnds_feature_table *table,
                          const struct pbnds_view *view,
                          const struct pbnds_march *march,
                          const struct pbnds_light_source *light,
                          struct pbnds_window window, float *dst);

#ifdef __cplusplus
}
#endif
#endif /* PBNDS_NEURAL_FEATURES_H */
