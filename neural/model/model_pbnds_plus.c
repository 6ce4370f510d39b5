/* `pbnds+`: the paper's U-Net, evaluated once a light on the encoded inputs, averaged
 * over the lights. Widths, depth and the block's inside are not published; ours are
 *
 *     ResConvBlock(x) = relu(conv3(relu(conv3(x)))) + skip(x),  skip a 1x1 convolution
 *                       where the widths differ
 *     MidResConvBlock = the same with dropout 0.1 between its convolutions
 *     16, 32, 64 channels, middle 96 at 1/8; no normalisation layers (they normalise
 * the light away); 1x1 stem on the encoding; 1x1 head
 *
 * The stem is split in two: the encoded channels that do not depend on the light go
 * through theirs once for all lights, which is exact, since a convolution is a sum. */
#include "neural/model/model_pbnds_plus.h"

#define CONV(NAME, IN, OUT, K, S, ACT)                                                 \
    {                                                                                  \
        .name = NAME, .op = PBNDS_OP_CONV, .in = {IN, -1}, .channels = OUT,            \
        .kernel = K, .stride = S, .act = PBNDS_ACT_##ACT                               \
    }
#define ADD(NAME, A, B, ACT)                                                           \
    {                                                                                  \
        .name = NAME, .op = PBNDS_OP_ADD, .in = {A, B}, .act = PBNDS_ACT_##ACT         \
    }
#define UP(NAME, IN, OUT)                                                              \
    {                                                                                  \
        .name = NAME, .op = PBNDS_OP_UP, .in = {IN, -1}, .channels = OUT,              \
        .act = PBNDS_ACT_NONE                                                          \
    }
#define CONCAT(NAME, A, B)                                                             \
    {                                                                                  \
        .name = NAME, .op = PBNDS_OP_CONCAT, .in = { A, B }                            \
    }

/* Two rows of 3x3 convolutions and the sum with x: a block whose widths agree. */
#define BLOCK(P, NAME, IN, C)                                                          \
    [P##_A] = CONV(NAME ".conv1", IN, C, 3, 1, RELU),                                  \
    [P##_B] = CONV(NAME ".conv2", P##_A, C, 3, 1, RELU),                               \
    [P] = ADD(NAME, P##_B, IN, NONE)
/* The same with a 1x1 skip: a block that changes the width. */
#define BLOCK_TO(P, NAME, IN, C)                                                       \
    [P##_A] = CONV(NAME ".conv1", IN, C, 3, 1, RELU),                                  \
    [P##_B] = CONV(NAME ".conv2", P##_A, C, 3, 1, RELU),                               \
    [P##_S] = CONV(NAME ".skip", IN, C, 1, 1, NONE),                                   \
    [P] = ADD(NAME, P##_B, P##_S, NONE)

enum {
    VIEW,
    STEM_V,
    LIGHT,
    STEM_L,
    STEM,
    E0_A,
    E0_B,
    E0,
    DOWN0,
    E1_A,
    E1_B,
    E1,
    DOWN1,
    E2_A,
    E2_B,
    E2,
    DOWN2,
    MID_A,
    MID_D,
    MID_B,
    MID,
    UP2,
    CAT2,
    D2_A,
    D2_B,
    D2_S,
    D2,
    UP1,
    CAT1,
    D1_A,
    D1_B,
    D1_S,
    D1,
    UP0,
    CAT0,
    D0_A,
    D0_B,
    D0_S,
    D0,
    HEAD,
};

static const struct pbnds_layer LAYERS[] = {
    [VIEW] = {.name = "view",
              .op = PBNDS_OP_VIEW_INPUT,
              .in = {-1, -1},
              .channels = PBNDS_PLUS_VIEW_CHANNELS},
    [STEM_V] = CONV("stem.view", VIEW, 16, 1, 1, NONE),
    [LIGHT] = {.name = "light",
               .op = PBNDS_OP_LIGHT_INPUT,
               .in = {-1, -1},
               .channels = PBNDS_PLUS_LIGHT_CHANNELS},
    [STEM_L] = CONV("stem.light", LIGHT, 16, 1, 1, NONE),
    [STEM] = ADD("stem", STEM_L, STEM_V, RELU),
    BLOCK(E0, "enc0", STEM, 16),
    [DOWN0] = CONV("down0", E0, 32, 2, 2, NONE),
    BLOCK(E1, "enc1", DOWN0, 32),
    [DOWN1] = CONV("down1", E1, 64, 2, 2, NONE),
    BLOCK(E2, "enc2", DOWN1, 64),
    [DOWN2] = CONV("down2", E2, 96, 2, 2, NONE),
    [MID_A] = CONV("mid.conv1", DOWN2, 96, 3, 1, RELU),
    [MID_D] = {.name = "mid.dropout",
               .op = PBNDS_OP_DROPOUT,
               .in = {MID_A, -1},
               .rate = 0.1f},
    [MID_B] = CONV("mid.conv2", MID_D, 96, 3, 1, RELU),
    [MID] = ADD("mid", MID_B, DOWN2, NONE),
    [UP2] = UP("up2", MID, 64),
    [CAT2] = CONCAT("cat2", UP2, E2),
    BLOCK_TO(D2, "dec2", CAT2, 64),
    [UP1] = UP("up1", D2, 32),
    [CAT1] = CONCAT("cat1", UP1, E1),
    BLOCK_TO(D1, "dec1", CAT1, 32),
    [UP0] = UP("up0", D1, 16),
    [CAT0] = CONCAT("cat0", UP0, E0),
    BLOCK_TO(D0, "dec0", CAT0, 16),
    [HEAD] = {.name = "head",
              .op = PBNDS_OP_CONV,
              .in = {D0, -1},
              .channels = 3,
              .kernel = 1,
              .stride = 1,
              .init_scale = 0.1f},
};

const struct pbnds_model pbnds_model_pbnds_plus = {
    .name = "pbnds+",
    .version = 2,
    .table = {LAYERS, sizeof LAYERS / sizeof LAYERS[0], HEAD, -1},
    .view_channels = PBNDS_PLUS_VIEW_CHANNELS,
    .light_channels = PBNDS_PLUS_LIGHT_CHANNELS,
    .lights = 32,
    .linear_in_light = false,
    .features = 2,
    .light_mode = "uniform",
    .light_output_about = "radiance R, G, B, linear Rec. 709; the picture is the mean "
                          "over the lights",
    .about = "the paper's U-Net a light, mean over lights",
};
