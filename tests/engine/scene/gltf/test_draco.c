/* Draco meshes, encoded here: exact values, counts, damage, claims beyond reason. */
#include <stdlib.h>
#include <string.h>

#include "engine/core/rng.h"
#include "engine/scene/gltf/draco.h"
#include "engine/scene/gltf/shim.h"
#include "tests/engine/scene/gltf/encode_draco.h"
#include "tests/test.h"

enum { SIDE = 12, POINTS = SIDE * SIDE, FACES = 2 * (SIDE - 1) * (SIDE - 1) };
enum { ROOM = 65536 };

/* A bumpy grid. Colours jump in the middle: a seam on points that share a position. */
static struct {
    float position[POINTS][3];
    int8_t normal[POINTS][3];
    uint16_t uv[POINTS][2];
    uint8_t color[POINTS][4];
    uint32_t index[3 * FACES];
} grid;

static const struct encode_attribute attributes[] = {
    {0, PBNDS_GLTF_FLOAT, 3, false, 0, grid.position},
    {1, PBNDS_GLTF_BYTE, 3, true, 0, grid.normal},
    {3, PBNDS_GLTF_USHORT, 2, true, 0, grid.uv},
    {2, PBNDS_GLTF_UBYTE, 4, true, 0, grid.color},
};
static const struct encode_mesh mesh = {POINTS, FACES, grid.index, attributes, 4};
static const struct pbnds_draco_limits any = {UINT64_MAX, UINT64_MAX, 1u << 30};

static uint8_t bytes[ROOM];
static size_t size;
static struct pbnds_error fault;

static int make_grid(void **state)
{
    (void)state;
    uint32_t *out = grid.index;
    for (int y = 0; y < SIDE; ++y) {
        for (int x = 0; x < SIDE; ++x) {
            const int i = y * SIDE + x;
            grid.position[i][0] = (float)x * 0.1f;
            grid.position[i][1] = (float)(x * x + 3 * y) * 0.013f;
            grid.position[i][2] = (float)y * 0.1f;
            for (int c = 0; c < 3; ++c)
                grid.normal[i][c] = (int8_t)(10 * x - 7 * y + c);
            grid.uv[i][0] = (uint16_t)(x * 5000);
            grid.uv[i][1] = (uint16_t)(y * 5001);
            for (int c = 0; c < 4; ++c)
                grid.color[i][c] = (uint8_t)(x < SIDE / 2 ? 20 * c : 200 - c);
            if (x == SIDE - 1 || y == SIDE - 1) continue;
            const uint32_t a = (uint32_t)i, quad[6] = {a,     a + 1,        a + SIDE,
                                                       a + 1, a + SIDE + 1, a + SIDE};
            memcpy(out, quad, sizeof quad);
            out += 6;
        }
    }
    return 0;
}

static void encode(bool edgebreaker)
{
    size = encode_draco(&mesh, edgebreaker, bytes, sizeof bytes);
    assert_true(size > 0);
}

static struct pbnds_draco *decode(const struct pbnds_draco_limits *limits)
{
    struct pbnds_draco *out = NULL;
    if (pbnds_draco_decode(bytes, size, "m", limits, &out, &fault) != PBNDS_OK)
        fail_msg("%s", fault.message);
    return out;
}

/* One corner of a triangle with all that is known of it. */
struct corner {
    float position[3];
    int8_t normal[3];
    uint16_t uv[2];
    uint8_t color[4];
};

static struct corner decoded[POINTS * 4];

static void read_points(const struct pbnds_draco *m)
{
    static float position[POINTS * 4][3];
    static int8_t normal[POINTS * 4][3];
    static uint16_t uv[POINTS * 4][2];
    static uint8_t color[POINTS * 4][4];
    const uint64_t count = pbnds_draco_vertices(m);
    assert_in_range(count, 1, POINTS * 4);
    assert_true(pbnds_draco_attribute(m, 10, 3, PBNDS_GLTF_FLOAT, position));
    assert_true(pbnds_draco_attribute(m, 11, 3, PBNDS_GLTF_BYTE, normal));
    assert_true(pbnds_draco_attribute(m, 12, 2, PBNDS_GLTF_USHORT, uv));
    assert_true(pbnds_draco_attribute(m, 13, 4, PBNDS_GLTF_UBYTE, color));
    memset(decoded, 0, sizeof decoded);
    for (uint64_t i = 0; i < count; ++i) {
        memcpy(decoded[i].position, position[i], sizeof position[i]);
        memcpy(decoded[i].normal, normal[i], sizeof normal[i]);
        memcpy(decoded[i].uv, uv[i], sizeof uv[i]);
        memcpy(decoded[i].color, color[i], sizeof color[i]);
    }
}

static struct corner source_corner(uint32_t i)
{
    struct corner c;
    memset(&c, 0, sizeof c);
    memcpy(c.position, grid.position[i], sizeof c.position);
    memcpy(c.normal, grid.normal[i], sizeof c.normal);
    memcpy(c.uv, grid.uv[i], sizeof c.uv);
    memcpy(c.color, grid.color[i], sizeof c.color);
    return c;
}

static int by_bytes(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(struct corner[3]));
}

/** Starts a triangle at its least corner: turning it does not change it. */
static void turn(struct corner t[3])
{
    int least = 0;
    for (int k = 1; k < 3; ++k) {
        if (memcmp(&t[k], &t[least], sizeof t[0]) < 0) least = k;
    }
    const struct corner copy[3] = {t[least], t[(least + 1) % 3], t[(least + 2) % 3]};
    memcpy(t, copy, sizeof copy);
}

/* Both methods: the same triangles with the same corners, whatever their order. */
static void every_corner_comes_back(void **state)
{
    (void)state;
    static struct corner want[FACES][3], got[FACES][3];
    for (int method = 0; method < 2; ++method) {
        encode(method == 1);
        struct pbnds_draco *m = decode(&any);
        assert_int_equal(pbnds_draco_triangles(m), FACES);
        static uint32_t index[3 * FACES];
        assert_true(pbnds_draco_indices(m, 4, index));
        read_points(m);
        for (uint32_t f = 0; f < FACES; ++f) {
            for (uint32_t k = 0; k < 3; ++k) {
                want[f][k] = source_corner(grid.index[3 * f + k]);
                got[f][k] = decoded[index[3 * f + k]];
            }
            turn(want[f]);
            turn(got[f]);
        }
        qsort(want, FACES, sizeof want[0], by_bytes);
        qsort(got, FACES, sizeof got[0], by_bytes);
        assert_memory_equal(want, got, sizeof want);
        uint16_t narrow[3 * FACES];
        assert_true(pbnds_draco_indices(m, 2, narrow));
        for (int i = 0; i < 3 * FACES; ++i)
            assert_int_equal(narrow[i], index[i]);
        pbnds_draco_free(m);
    }
}

static void types_are_converted_where_they_fit(void **state)
{
    (void)state;
    encode(false); /* keeps the order */
    struct pbnds_draco *m = decode(&any);
    static float f[POINTS][4];
    static uint32_t u[POINTS][4];
    static uint8_t b[POINTS][4];
    assert_int_equal(pbnds_draco_vertices(m), POINTS);
    /* A normalised attribute that is asked for as floats: those of glTF's formula. */
    assert_true(pbnds_draco_attribute(m, 13, 4, PBNDS_GLTF_FLOAT, f));
    for (int i = 0; i < POINTS; ++i)
        assert_near(f[i][2], grid.color[i][2] / 255.0, 1e-7);
    assert_true(pbnds_draco_attribute(m, 13, 4, PBNDS_GLTF_UINT, u));
    assert_int_equal(u[POINTS - 1][3], grid.color[POINTS - 1][3]);
    assert_false(pbnds_draco_attribute(m, 12, 2, PBNDS_GLTF_UBYTE, b)); /* too large */
    assert_false(pbnds_draco_attribute(m, 13, 3, PBNDS_GLTF_UBYTE, b)); /* width     */
    assert_false(pbnds_draco_attribute(m, 14, 3, PBNDS_GLTF_FLOAT, f)); /* no such   */
    assert_false(pbnds_draco_attribute(m, -1, 3, PBNDS_GLTF_FLOAT, f));
    assert_false(pbnds_draco_attribute(m, INT64_MAX, 3, PBNDS_GLTF_FLOAT, f));
    assert_false(pbnds_draco_attribute(m, 10, 3, 5124, f)); /* no type of glTF */
    uint8_t index[3 * FACES];
    assert_true(pbnds_draco_indices(m, 1, index)); /* 144 points */
    assert_false(pbnds_draco_indices(m, 3, index));
    pbnds_draco_free(m);
}

static void quantised_positions_are_near(void **state)
{
    (void)state;
    const struct encode_attribute position = {0,  PBNDS_GLTF_FLOAT, 3, false,
                                              14, grid.position};
    const struct encode_mesh coarse = {POINTS, FACES, grid.index, &position, 1};
    static float p[POINTS][3];
    size = encode_draco(&coarse, false, bytes, sizeof bytes);
    struct pbnds_draco *m = decode(&any);
    assert_true(pbnds_draco_attribute(m, 10, 3, PBNDS_GLTF_FLOAT, p));
    for (int i = 0; i < POINTS; ++i) {
        for (int c = 0; c < 3; ++c) /* the box has a side of 1.96 */
            assert_near(p[i][c], grid.position[i][c], 1.96 / 16383);
    }
    pbnds_draco_free(m);
}

static enum pbnds_status try_decode(const struct pbnds_draco_limits *limits)
{
    struct pbnds_draco *m = NULL;
    fault.message[0] = 0;
    const enum pbnds_status status =
        pbnds_draco_decode(bytes, size, "m.glb", limits, &m, &fault);
    assert_true((status == PBNDS_OK) == (m != NULL));
    if (status != PBNDS_OK) assert_non_null(strstr(fault.message, "m.glb"));
    /* What it says it has can be read. */
    static uint32_t index[1 << 20], values[1 << 20];
    if (m && pbnds_draco_triangles(m) < (1 << 20) / 3) {
        (void)pbnds_draco_indices(m, 4, index);
        for (int id = 10; id < 14 && pbnds_draco_vertices(m) < (1 << 18); ++id) {
            for (int width = 1; width <= 4; ++width)
                (void)pbnds_draco_attribute(m, id, width, PBNDS_GLTF_FLOAT, values);
        }
    }
    pbnds_draco_free(m);
    return status;
}

static void counts_are_compared_before_decoding(void **state)
{
    (void)state;
    for (int method = 0; method < 2; ++method) {
        encode(method == 1);
        struct pbnds_draco *m = decode(&any);
        const uint64_t points = pbnds_draco_vertices(m);
        pbnds_draco_free(m);
        struct pbnds_draco_limits limits = {FACES, points, 1 << 20};
        assert_int_equal(try_decode(&limits), PBNDS_OK);
        limits.triangles = FACES + 1;
        assert_int_equal(try_decode(&limits), PBNDS_ERROR_FORMAT);
        limits.triangles = FACES - 1;
        assert_int_equal(try_decode(&limits), PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(fault.message, "indices"));
        limits = (struct pbnds_draco_limits){FACES, points + 1, 1 << 20};
        assert_int_equal(try_decode(&limits), PBNDS_ERROR_FORMAT);
        assert_non_null(strstr(fault.message, "vertices"));
        /* Less than the mesh itself takes: 24 bytes a point, 12 a triangle. */
        limits = (struct pbnds_draco_limits){FACES, points, 24 * POINTS + 12 * FACES};
        assert_int_equal(try_decode(&limits), PBNDS_ERROR_MEMORY);
    }
}

/* A varint of Draco: seven bits a byte, the lowest first. */
static size_t put_varint(uint8_t *out, uint32_t x)
{
    size_t n = 0;
    for (; x >= 128; x >>= 7)
        out[n++] = (uint8_t)(x | 128);
    out[n++] = (uint8_t)x;
    return n;
}

/* A few bytes that claim a thousand million triangles, or seams, or splits. */
static void claims_are_weighed(void **state)
{
    (void)state;
    static const struct {
        int method;
        uint32_t numbers[5]; /* vertices, faces, seams, symbols, splits */
    } claims[] = {
        {1, {1000000000, 1000000000, 0, 1000000000, 0}},
        {1, {3, 1000000, 255, 1000000, 0}},
        {1, {3, 1, 0, 1, 4000000000u}},
        {0, {1000000000, 1000000000, 0, 0, 0}},
    };
    for (size_t i = 0; i < sizeof claims / sizeof claims[0]; ++i) {
        const uint32_t *n = claims[i].numbers;
        memset(bytes, 0, 1024);
        memcpy(bytes, "DRACO\2\2\1", 8);
        bytes[8] = (uint8_t)claims[i].method;
        size = 11;
        if (claims[i].method == 1) bytes[size++] = 0; /* the standard traversal */
        size += put_varint(bytes + size, n[0]);
        size += put_varint(bytes + size, n[1]);
        if (claims[i].method == 1) {
            bytes[size++] = (uint8_t)n[2];
            size += put_varint(bytes + size, n[3]);
            size += put_varint(bytes + size, n[4]);
        }
        size += 100;
        assert_int_equal(try_decode(&any), PBNDS_ERROR_MEMORY);
    }
}

static void other_streams_are_refused(void **state)
{
    (void)state;
    encode(true);
    bytes[6] = 1; /* version 2.1 */
    assert_int_equal(try_decode(&any), PBNDS_ERROR_UNSUPPORTED);
    bytes[6] = 2;
    bytes[7] = 0; /* a point cloud */
    assert_int_equal(try_decode(&any), PBNDS_ERROR_UNSUPPORTED);
    bytes[7] = 1;
    bytes[8] = 2; /* no such method */
    assert_int_equal(try_decode(&any), PBNDS_ERROR_FORMAT);
    bytes[8] = 1;
    bytes[0] = 'd';
    assert_int_equal(try_decode(&any), PBNDS_ERROR_FORMAT);
    size = 0;
    assert_int_equal(try_decode(&any), PBNDS_ERROR_FORMAT);
}

static void damage_is_survived(void **state)
{
    (void)state;
    static uint8_t sound[ROOM];
    struct pbnds_rng rng = pbnds_rng_make(1, 2, 3);
    for (int method = 0; method < 2; ++method) {
        encode(method == 1);
        const size_t full = size;
        memcpy(sound, bytes, full);
        for (size = 0; size < full; ++size) {
            uint8_t *copy = malloc(size + 1); /* so that a sanitizer knows its end */
            memcpy(copy, sound, size);
            struct pbnds_draco *m = NULL;
            if (pbnds_draco_decode(copy, size, "m", &any, &m, NULL) == PBNDS_OK)
                pbnds_draco_free(m);
            free(copy);
        }
        for (int i = 0; i < 3000; ++i) {
            size = full;
            memcpy(bytes, sound, full);
            for (uint32_t k = 0; k <= (uint32_t)i % 3; ++k)
                bytes[11 + pbnds_rng_u64(&rng) % (full - 11)] ^=
                    (uint8_t)(1u << pbnds_rng_u64(&rng) % 8);
            (void)try_decode(
                &(struct pbnds_draco_limits){UINT64_MAX, UINT64_MAX, 64 << 20});
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_corner_comes_back),
        cmocka_unit_test(types_are_converted_where_they_fit),
        cmocka_unit_test(quantised_positions_are_near),
        cmocka_unit_test(counts_are_compared_before_decoding),
        cmocka_unit_test(claims_are_weighed),
        cmocka_unit_test(other_streams_are_refused),
        cmocka_unit_test(damage_is_survived),
    };
    return cmocka_run_group_tests(tests, make_grid, NULL);
}
