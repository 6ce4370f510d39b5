/* EXT_meshopt_compression, one range: modes, filters, rules, damage. The data are encoded
 * here by libmeshoptimizer, the filters have naive twins after appendix B of the text. */
#include <stdlib.h>
#include <string.h>

#include <meshoptimizer.h>

#include "engine/core/rng.h"
#include "engine/scene/gltf/meshopt.h"
#include "tests/test.h"

enum { COUNT = 700, ROOM = 65536 };

static uint8_t packed[ROOM];
static size_t packed_size;

static void pack(const void *data, size_t stride)
{
    packed_size = meshopt_encodeVertexBuffer(packed, ROOM, data, COUNT, stride);
    assert_true(packed_size > 0);
}

static void must_decode(const char *mode, const char *filter, size_t count,
                        size_t stride, void *out)
{
    const char *why =
        pbnds_meshopt_decode(mode, filter, packed, packed_size, count, stride, out);
    if (why) fail_msg("%s %s: %s", mode, filter, why);
}

static void attributes_come_back(void **state)
{
    (void)state;
    struct pbnds_rng rng = pbnds_rng_make(7, 0, 0);
    static uint8_t in[COUNT * 256], out[COUNT * 256];
    for (size_t stride = 4; stride <= 64; stride += 12) {
        for (size_t i = 0; i < COUNT * stride; ++i)
            in[i] = (uint8_t)(i / stride + (pbnds_rng_u64(&rng) % 3));
        memset(out, 0, sizeof out);
        pack(in, stride);
        must_decode("ATTRIBUTES", "NONE", COUNT, stride, out);
        assert_memory_equal(in, out, COUNT * stride);
    }
}

/** A strip of triangles and a few jumps. */
static void make_indices(uint32_t *index)
{
    for (uint32_t i = 0; i < COUNT / 3; ++i) {
        const uint32_t at = i % 40 == 39 ? 7 * i : i;
        index[3 * i] = at;
        index[3 * i + 1] = at + 1 + i % 2;
        index[3 * i + 2] = at + 2 - i % 2;
    }
}

static void triangles_come_back(void **state)
{
    (void)state;
    const size_t count = COUNT / 3 * 3;
    uint32_t in[COUNT], out[COUNT];
    uint16_t narrow[COUNT];
    make_indices(in);
    meshopt_encodeIndexVersion(1);
    packed_size = meshopt_encodeIndexBuffer(packed, ROOM, in, count);
    must_decode("TRIANGLES", "NONE", count, 4, out);
    must_decode("TRIANGLES", "NONE", count, 2, narrow);
    for (size_t i = 0; i < count; i += 3) { /* a triangle may start at any corner */
        size_t k = 0;
        while (k < 3 && out[i + k] != in[i])
            ++k;
        assert_true(k < 3 && out[i + (k + 1) % 3] == in[i + 1] &&
                    out[i + (k + 2) % 3] == in[i + 2]);
        for (size_t c = 0; c < 3; ++c)
            assert_int_equal(narrow[i + c], out[i + c]);
    }
}

static void indices_come_back(void **state)
{
    (void)state;
    uint32_t in[COUNT], out[COUNT];
    uint16_t narrow[COUNT];
    for (uint32_t i = 0; i < COUNT; ++i)
        in[i] = (i * 37) % 500;
    packed_size = meshopt_encodeIndexSequence(packed, ROOM, in, COUNT);
    must_decode("INDICES", "NONE", COUNT, 4, out);
    must_decode("INDICES", "NONE", COUNT, 2, narrow);
    for (size_t i = 0; i < COUNT; ++i) {
        assert_int_equal(out[i], in[i]);
        assert_int_equal(narrow[i], in[i]);
    }
}

/* ---- filters -------------------------------------------------------------------- */

static void random_units(float v[COUNT][4], int width)
{
    struct pbnds_rng rng = pbnds_rng_make(9, 0, 0);
    for (int i = 0; i < COUNT; ++i) {
        float square = 0.0f;
        for (int c = 0; c < 4; ++c) {
            v[i][c] = c < width ? 2.0f * pbnds_rng_float(&rng) - 1.0f : 1.0f;
            if (c < width) square += v[i][c] * v[i][c];
        }
        for (int c = 0; c < width; ++c)
            v[i][c] /= sqrtf(square);
    }
}

/** The octahedron unfolded: x and y of `one`, the rest of z, then to unit length. */
static void unfold(double x, double y, double one, double most, double out[3])
{
    double p[3] = {x / one, y / one, 0.0};
    p[2] = 1.0 - fabs(p[0]) - fabs(p[1]);
    const double t = p[2] < 0.0 ? -p[2] : 0.0;
    p[0] -= p[0] >= 0.0 ? t : -t;
    p[1] -= p[1] >= 0.0 ? t : -t;
    const double length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    for (int c = 0; c < 3; ++c)
        out[c] = p[c] / length * most;
}

static void octahedral_is_the_text(void **state)
{
    (void)state;
    static float unit[COUNT][4];
    int8_t narrow[COUNT][4], raw8[COUNT][4];
    int16_t wide[COUNT][4], raw16[COUNT][4];
    double want[3];
    random_units(unit, 3);
    meshopt_encodeFilterOct(narrow, COUNT, 4, 8, unit[0]);
    pack(narrow, 4);
    must_decode("ATTRIBUTES", "NONE", COUNT, 4, raw8);
    must_decode("ATTRIBUTES", "OCTAHEDRAL", COUNT, 4, narrow);
    meshopt_encodeFilterOct(wide, COUNT, 8, 12, unit[0]);
    pack(wide, 8);
    must_decode("ATTRIBUTES", "NONE", COUNT, 8, raw16);
    must_decode("ATTRIBUTES", "OCTAHEDRAL", COUNT, 8, wide);
    for (int i = 0; i < COUNT; ++i) {
        unfold(raw8[i][0], raw8[i][1], raw8[i][2], 127.0, want);
        for (int c = 0; c < 3; ++c) {
            assert_near(narrow[i][c], want[c], 0.51);
            assert_near(narrow[i][c] / 127.0, unit[i][c], 0.03);
        }
        assert_int_equal(narrow[i][3], raw8[i][3]);
        unfold(raw16[i][0], raw16[i][1], raw16[i][2], 32767.0, want);
        for (int c = 0; c < 3; ++c) {
            assert_near(wide[i][c], want[c], 0.52);
            assert_near(wide[i][c] / 32767.0, unit[i][c], 0.002);
        }
        assert_int_equal(wide[i][3], raw16[i][3]);
    }
}

static void quaternion_is_the_text(void **state)
{
    (void)state;
    static float unit[COUNT][4];
    int16_t raw[COUNT][4], got[COUNT][4];
    random_units(unit, 4);
    meshopt_encodeFilterQuat(got, COUNT, 8, 14, unit[0]);
    pack(got, 8);
    must_decode("ATTRIBUTES", "NONE", COUNT, 8, raw);
    must_decode("ATTRIBUTES", "QUATERNION", COUNT, 8, got);
    for (int i = 0; i < COUNT; ++i) {
        /* The largest component is left out; its place is in the low bits of w. */
        const int largest = raw[i][3] & 3;
        const double scale = sqrt(0.5) / (double)(raw[i][3] | 3);
        double want[4], square = 0.0, dot = 0.0;
        for (int c = 0; c < 3; ++c) {
            const double x = raw[i][c] * scale;
            want[(largest + 1 + c) % 4] = x;
            square += x * x;
        }
        want[largest] = sqrt(fmax(0.0, 1.0 - square));
        for (int c = 0; c < 4; ++c) {
            assert_near(got[i][c], want[c] * 32767.0, 0.52);
            dot += got[i][c] / 32767.0 * (double)unit[i][c];
        }
        /* the same turn, with either sign; sixteen bits a component */
        assert_near(fabs(dot), 1.0, 4e-5);
    }
}

static void exponential_is_the_text(void **state)
{
    (void)state;
    static float in[COUNT][3], got[COUNT][3];
    uint32_t raw[COUNT][3];
    struct pbnds_rng rng = pbnds_rng_make(11, 0, 0);
    for (int i = 0; i < COUNT; ++i) {
        for (int c = 0; c < 3; ++c)
            in[i][c] = ldexpf(2.0f * pbnds_rng_float(&rng) - 1.0f, i % 20 - 10);
    }
    meshopt_encodeFilterExp(raw, COUNT, 12, 16, in[0]);
    pack(raw, 12);
    must_decode("ATTRIBUTES", "NONE", COUNT, 12, raw);
    must_decode("ATTRIBUTES", "EXPONENTIAL", COUNT, 12, got);
    for (int i = 0; i < COUNT; ++i) {
        double most = 0.0;
        for (int c = 0; c < 3; ++c)
            most = fmax(most, fabs((double)in[i][c]));
        for (int c = 0; c < 3; ++c) {
            const uint32_t x = raw[i][c], m = x & 0xffffffu;
            const int mantissa = m & 0x800000u ? (int)m - 0x1000000 : (int)m;
            const int exponent = x >> 31 ? (int)(x >> 24) - 256 : (int)(x >> 24);
            assert_near(got[i][c], ldexp(mantissa, exponent), 0);
            assert_near(got[i][c], in[i][c], most * 1e-4);
        }
    }
}

/* ---- rules and damage -------------------------------------------------------------- */

static void rules_are_kept(void **state)
{
    (void)state;
    static const struct {
        const char *mode, *filter;
        size_t count, stride;
    } broken[] = {
        {"ATTRIBUTES", "NONE", COUNT, 6},
        {"ATTRIBUTES", "NONE", COUNT, 0},
        {"ATTRIBUTES", "NONE", COUNT, 260},
        {"ATTRIBUTES", "none", COUNT, 8},
        {"ATTRIBUTES", "OCTAHEDRAL", COUNT, 12},
        {"ATTRIBUTES", "QUATERNION", COUNT, 4},
        {"ATTRIBUTES", "", COUNT, 8},
        {"attributes", "NONE", COUNT, 8},
        {"", "NONE", COUNT, 8},
        {"TRIANGLES", "NONE", 9, 8},
        {"TRIANGLES", "NONE", 9, 1},
        {"TRIANGLES", "NONE", 10, 2},
        {"TRIANGLES", "EXPONENTIAL", 9, 4},
        {"INDICES", "OCTAHEDRAL", 9, 4},
        {"INDICES", "NONE", 9, 3},
    };
    static uint8_t in[COUNT * 8], out[COUNT * 260];
    pack(in, 8);
    must_decode("ATTRIBUTES", "NONE", COUNT, 8, out);
    for (size_t i = 0; i < sizeof broken / sizeof broken[0]; ++i) {
        assert_non_null(pbnds_meshopt_decode(broken[i].mode, broken[i].filter, packed,
                                             packed_size, broken[i].count,
                                             broken[i].stride, out));
    }
    /* The bytes of another mode, of another count. */
    assert_non_null(
        pbnds_meshopt_decode("INDICES", "NONE", packed, packed_size, 8, 4, out));
    assert_non_null(
        pbnds_meshopt_decode("TRIANGLES", "NONE", packed, packed_size, 9, 4, out));
    assert_non_null(pbnds_meshopt_decode("ATTRIBUTES", "NONE", packed, packed_size,
                                         10 * COUNT, 8, out));
}

/** Cuts and flips; room and data end where a sanitizer knows. */
static void damage(const char *mode, const char *filter, size_t count, size_t stride)
{
    struct pbnds_rng rng = pbnds_rng_make(3, 0, 0);
    uint8_t *out = malloc(count * stride);
    for (size_t i = 0; i < packed_size + 2000; ++i) {
        const size_t size = i < packed_size ? i : packed_size;
        uint8_t *copy = malloc(size ? size : 1);
        memcpy(copy, packed, size);
        for (size_t k = 0; i >= packed_size && k <= i % 3; ++k)
            copy[pbnds_rng_u64(&rng) % size] ^=
                (uint8_t)(1u << (pbnds_rng_u64(&rng) % 8));
        (void)pbnds_meshopt_decode(mode, filter, copy, size, count, stride, out);
        free(copy);
    }
    free(out);
}

static void damage_is_survived(void **state)
{
    (void)state;
    static const char *const filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION",
                                          "EXPONENTIAL"};
    static int16_t data[COUNT][4];
    struct pbnds_rng rng = pbnds_rng_make(5, 0, 0);
    for (int i = 0; i < COUNT; ++i) {
        for (int c = 0; c < 4; ++c)
            data[i][c] = (int16_t)(pbnds_rng_u64(&rng) % (i % 2 ? 65536 : 16));
    }
    packed_size = meshopt_encodeVertexBuffer(packed, ROOM, data, 90, 8);
    for (int i = 0; i < 4; ++i)
        damage("ATTRIBUTES", filters[i], 90, 8);
    uint32_t index[COUNT];
    make_indices(index);
    packed_size = meshopt_encodeIndexBuffer(packed, ROOM, index, 300);
    damage("TRIANGLES", "NONE", 300, 2);
    damage("TRIANGLES", "NONE", 300, 4);
    packed_size = meshopt_encodeIndexSequence(packed, ROOM, index, 300);
    damage("INDICES", "NONE", 300, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attributes_come_back),
        cmocka_unit_test(triangles_come_back),
        cmocka_unit_test(indices_come_back),
        cmocka_unit_test(octahedral_is_the_text),
        cmocka_unit_test(quaternion_is_the_text),
        cmocka_unit_test(exponential_is_the_text),
        cmocka_unit_test(rules_are_kept),
        cmocka_unit_test(damage_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
