/* `transport`: linear in light by construction. An encoder runs once a view; a decoder,
 * conditioned on one light, runs at half resolution and below, and gives per pixel the
 * logit of the light's visibility and three channels of indirect transport (transport.h
 * says how they become radiance). A small view decoder gives the occlusion of the
 * specular lobe, which the light map enters in full. Design C of the experiment. */
#include "neural/model/model_transport.h"

enum {
    VIEW,
    E1A,
    E1B,
    E2A,
    E2B,
    E3A,
    E3B,
    E4A,
    E4B,
    U3V,
    U3W,
    V3,
    U2V,
    U2W,
    V2,
    U1V,
    U1W,
    V1,
    VOUT,
    OCCLUSION,
    LIGHT,
    L1,
    L2,
    L3,
    D3L,
    D3V,
    D3S,
    D3,
    U2L,
    S2L,
    A2L,
    S2V,
    D2S,
    D2,
    U1L,
    S1L,
    A1L,
    S1V,
    D1S,
    D1,
    LOUT,
    TRANSPORT,
};

#define CONV(NAME, IN, OUT, K, S, ACT)                                                 \
    {                                                                                  \
        .name = NAME, .op = PBNDS_OP_CONV, .in = {IN, -1}, .channels = OUT,            \
        .kernel = K, .stride = S, .act = PBNDS_ACT_##ACT                               \
    }
#define UP(NAME, IN, OUT, ACT)                                                         \
    {                                                                                  \
        .name = NAME, .op = PBNDS_OP_UP, .in = {IN, -1}, .channels = OUT,              \
        .act = PBNDS_ACT_##ACT                                                         \
    }
#define ADD(NAME, A, B, ACT)                                                           \
    {                                                                                  \
        .name = NAME, .op = PBNDS_OP_ADD, .in = {A, B}, .act = PBNDS_ACT_##ACT         \
    }

static const struct pbnds_layer LAYERS[] = {
    [VIEW] = {.name = "view",
              .op = PBNDS_OP_VIEW_INPUT,
              .in = {-1, -1},
              .channels = PBNDS_TRANSPORT_VIEW_CHANNELS},
    /* encoder: 1/2, 1/4, 1/8, 1/16 */
    [E1A] = CONV("enc1a", VIEW, 32, 2, 2, RELU),
    [E1B] = CONV("enc1b", E1A, 32, 3, 1, RELU),
    [E2A] = CONV("enc2a", E1B, 48, 2, 2, RELU),
    [E2B] = CONV("enc2b", E2A, 48, 3, 1, RELU),
    [E3A] = CONV("enc3a", E2B, 64, 2, 2, RELU),
    [E3B] = CONV("enc3b", E3A, 64, 3, 1, RELU),
    [E4A] = CONV("enc4a", E3B, 96, 2, 2, RELU),
    [E4B] = CONV("enc4b", E4A, 96, 3, 1, RELU),
    /* the view's own decoder: context flows back up once, for all lights */
    [U3V] = UP("view3_up", E4B, 64, NONE),
    [U3W] = ADD("view3_sum", U3V, E3B, NONE),
    [V3] = CONV("view3", U3W, 64, 3, 1, RELU),
    [U2V] = UP("view2_up", V3, 48, NONE),
    [U2W] = ADD("view2_sum", U2V, E2B, NONE),
    [V2] = CONV("view2", U2W, 48, 3, 1, RELU),
    [U1V] = UP("view1_up", V2, 32, NONE),
    [U1W] = ADD("view1_sum", U1V, E1B, NONE),
    [V1] = CONV("view1", U1W, 32, 3, 1, RELU),
    [VOUT] = {.name = "occlusion_head",
              .op = PBNDS_OP_CONV,
              .in = {V1, -1},
              .channels = 4,
              .kernel = 3,
              .stride = 1,
              .init_scale = 0.1f},
    [OCCLUSION] = {.name = "occlusion", .op = PBNDS_OP_SHUFFLE, .in = {VOUT, -1}},
    /* the light's features, brought to 1/2, 1/4 and 1/8 */
    [LIGHT] = {.name = "light",
               .op = PBNDS_OP_LIGHT_INPUT,
               .in = {-1, -1},
               .channels = PBNDS_TRANSPORT_LIGHT_CHANNELS},
    [L1] = CONV("light1", LIGHT, 16, 2, 2, RELU),
    [L2] = CONV("light2", L1, 16, 2, 2, RELU),
    [L3] = CONV("light3", L2, 16, 2, 2, RELU),
    /* decoder a light: 1/8, 1/4, 1/2; split weights instead of concatenation, so that
     * the view's half of each convolution is paid once */
    [D3L] = CONV("dec3_light", L3, 32, 3, 1, NONE),
    [D3V] = CONV("dec3_view", V3, 32, 3, 1, NONE),
    [D3S] = ADD("dec3_sum", D3L, D3V, RELU),
    [D3] = CONV("dec3", D3S, 32, 3, 1, RELU),
    [U2L] = UP("dec2_up", D3, 32, NONE),
    [S2L] = CONV("dec2_light", L2, 32, 3, 1, NONE),
    [A2L] = ADD("dec2_mix", U2L, S2L, NONE),
    [S2V] = CONV("dec2_view", V2, 32, 3, 1, NONE),
    [D2S] = ADD("dec2_sum", A2L, S2V, RELU),
    [D2] = CONV("dec2", D2S, 32, 3, 1, RELU),
    [U1L] = UP("dec1_up", D2, 32, NONE),
    [S1L] = CONV("dec1_light", L1, 32, 3, 1, NONE),
    [A1L] = ADD("dec1_mix", U1L, S1L, NONE),
    [S1V] = CONV("dec1_view", V1, 32, 3, 1, NONE),
    [D1S] = ADD("dec1_sum", A1L, S1V, RELU),
    [D1] = CONV("dec1", D1S, 32, 3, 1, RELU),
    [LOUT] = {.name = "transport_head",
              .op = PBNDS_OP_CONV,
              .in = {D1, -1},
              .channels = 4 * PBNDS_TRANSPORT_OUT_CHANNELS,
              .kernel = 3,
              .stride = 1,
              .init_scale = 0.1f},
    [TRANSPORT] = {.name = "transport", .op = PBNDS_OP_SHUFFLE, .in = {LOUT, -1}},
};

const struct pbnds_model pbnds_model_transport = {
    .name = "transport",
    .version = 1,
    .table = {LAYERS, sizeof LAYERS / sizeof LAYERS[0], TRANSPORT, OCCLUSION},
    .view_channels = PBNDS_TRANSPORT_VIEW_CHANNELS,
    .light_channels = PBNDS_TRANSPORT_LIGHT_CHANNELS,
    .lights = 32,
    .linear_in_light = true,
    .features = 1,
    .light_mode = "clusters",
    .light_output_about =
        "per light: visibility logit v, indirect s.R, s.G, s.B; light i of irradiance "
        "E_i adds E_i (A_i sigmoid(v + 1) + B softplus(s - 2)), where A_i = (f_diffuse "
        "+ w f_specular) max(n.l, 0), w = clamp((alpha - 0.1) / 0.2, 0, 1), B = c_diff "
        "+ f0",
    .view_output_about =
        "occlusion logit o; sigmoid(o + 2) times (1 - w) times the unshadowed specular "
        "reflection of the whole light map is added once",
    .about = "structured light transport, linear in light (the default)",
};
