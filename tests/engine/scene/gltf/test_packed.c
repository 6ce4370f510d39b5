/* Compressed geometry inside of glTF: the same scene as from plain data. */
#include <meshoptimizer.h>
#include <sys/stat.h>

#include "engine/core/rng.h"
#include "tests/engine/scene/gltf/encode_draco.h"
#include "tests/engine/scene/gltf/fixture.h"

enum { SIDE = 9, POINTS = SIDE * SIDE, FACES = 2 * (SIDE - 1) * (SIDE - 1) };

static struct {
    float position[POINTS][3], normal[POINTS][3];
    uint16_t uv[POINTS][2];
    uint16_t index[3 * FACES];
    uint32_t wide[3 * FACES];
} grid;

static int make_grid(void **state)
{
    (void)state;
    uint32_t *out = grid.wide;
    for (int y = 0; y < SIDE; ++y) {
        for (int x = 0; x < SIDE; ++x) {
            const int i = y * SIDE + x;
            const struct pbnds_vec3 n = pbnds_normalize(
                pbnds_vec3_make((float)x * 0.1f, 1.0f, (float)y * -0.07f));
            const float p[3] = {(float)x * 0.25f, (float)(x * y) * 0.125f, (float)y},
                        normal[3] = {n.x, n.y, n.z};
            memcpy(grid.position[i], p, sizeof p);
            memcpy(grid.normal[i], normal, sizeof normal);
            grid.uv[i][0] = (uint16_t)(x * 7000);
            grid.uv[i][1] = (uint16_t)(y * 7001);
            if (x == SIDE - 1 || y == SIDE - 1) continue;
            const uint32_t a = (uint32_t)i, quad[6] = {a,     a + SIDE, a + 1,
                                                       a + 1, a + SIDE, a + SIDE + 1};
            memcpy(out, quad, sizeof quad);
            out += 6;
        }
    }
    for (int i = 0; i < 3 * FACES; ++i)
        grid.index[i] = (uint16_t)grid.wide[i];
    return 0;
}

/* ---- a document and its BIN chunk, part by part ------------------------------------ */

struct document {
    char views[4096];
    uint8_t bin[65536];
    size_t bin_size, view_count;
};

/** Appends bytes, aligned; returns their offset. */
static size_t put(struct document *d, const void *bytes, size_t size)
{
    const size_t at = d->bin_size;
    assert_true(at + size + 4 <= sizeof d->bin);
    memcpy(d->bin + at, bytes, size);
    d->bin_size = (at + size + 3) / 4 * 4;
    return at;
}

static void add_text(char *out, size_t room, const char *format, ...)
    PBNDS_PRINTF(3, 4);
static void add_text(char *out, size_t room, const char *format, ...)
{
    const size_t used = strlen(out);
    va_list list;
    va_start(list, format);
    const int n = vsnprintf(out + used, room - used, format, list);
    va_end(list);
    assert_true(n >= 0 && used + (size_t)n < room);
}

static void add_view(struct document *d, const void *bytes, size_t size)
{
    const size_t at = put(d, bytes, size);
    add_text(d->views, sizeof d->views,
             "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}",
             d->view_count++ ? "," : "", at, size);
}

/** Loads it: `primitive` is its one primitive, `accessors` all accessors. */
static enum pbnds_status load_document(const struct document *d, const char *primitive,
                                       const char *accessors, const char *buffers,
                                       const struct pbnds_gltf_options *options,
                                       struct pbnds_scene *s)
{
    static char json[16384];
    (void)snprintf(json, sizeof json,
                   "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],"
                   "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[%s]}],"
                   "\"buffers\":[{\"byteLength\":%zu}%s],\"bufferViews\":[%s],"
                   "\"accessors\":[%s]}",
                   primitive, d->bin_size, buffers, d->views, accessors);
    return load_with(json, d->bin, d->bin_size, options, s);
}

#define ATTRIBUTES "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2}"
#define PRIMITIVE  "{" ATTRIBUTES ",\"indices\":3}"

/** The four accessors, each with what `source` says (a view of its own, or nothing). */
static const char *accessors(bool views, int points, int indices)
{
    static char text[1024];
    static const char *const types[4] = {
        "\"componentType\":5126,\"type\":\"VEC3\"",
        "\"componentType\":5126,\"type\":\"VEC3\"",
        "\"componentType\":5123,\"normalized\":true,\"type\":\"VEC2\"",
        "\"componentType\":5123,\"type\":\"SCALAR\""};
    text[0] = 0;
    for (int i = 0; i < 4; ++i) {
        add_text(text, sizeof text, "%s{%s,\"count\":%d", i ? "," : "", types[i],
                 i < 3 ? points : indices);
        if (views) add_text(text, sizeof text, ",\"bufferView\":%d", i);
        add_text(text, sizeof text, "}");
    }
    return text;
}

static void load_plain(struct pbnds_scene *s)
{
    static struct document d;
    d = (struct document){{0}, {0}, 0, 0};
    add_view(&d, grid.position, sizeof grid.position);
    add_view(&d, grid.normal, sizeof grid.normal);
    add_view(&d, grid.uv, sizeof grid.uv);
    add_view(&d, grid.index, sizeof grid.index);
    if (load_document(&d, PRIMITIVE, accessors(true, POINTS, 3 * FACES), "", NULL, s) !=
        PBNDS_OK) {
        fail_msg("%s", fault.message);
    }
}

static void assert_near3(struct pbnds_vec3 a, struct pbnds_vec3 b, double tolerance)
{
    assert_vec3(a, (double)b.x, (double)b.y, (double)b.z, tolerance);
}

/** Position, normal and uv of a corner. */
static void corner(const struct pbnds_mesh *m, size_t i, float out[8])
{
    const uint32_t k = m->index[i];
    memcpy(out, &m->position[k], 12);
    memcpy(out + 3, &m->normal[k], 12);
    memcpy(out + 6, &m->uv[0][k], 8);
}

static int by_bytes(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(float[3][8]));
}

/** All triangles, each from its least corner, in order of their bytes: what two meshes
 *  have in common whose vertices are numbered differently. */
static void soup_of(const struct pbnds_mesh *m, float out[FACES][3][8])
{
    for (size_t f = 0; f < FACES; ++f) {
        float c[3][8];
        size_t least = 0;
        for (size_t k = 0; k < 3; ++k) {
            corner(m, 3 * f + k, c[k]);
            if (memcmp(c[k], c[least], sizeof c[k]) < 0) least = k;
        }
        for (size_t k = 0; k < 3; ++k)
            memcpy(out[f][k], c[(least + k) % 3], sizeof c[k]);
    }
    qsort(out, FACES, sizeof out[0], by_bytes);
}

static void assert_same(const struct pbnds_scene *a, const struct pbnds_scene *b)
{
    static float one[FACES][3][8], other[FACES][3][8];
    assert_int_equal(a->triangle_count, FACES);
    assert_int_equal(b->triangle_count, FACES);
    soup_of(&a->meshes[0], one);
    soup_of(&b->meshes[0], other);
    assert_memory_equal(one, other, sizeof one);
}

static void assert_like_plain(const struct pbnds_scene *s)
{
    struct pbnds_scene plain;
    load_plain(&plain);
    assert_same(s, &plain);
    pbnds_scene_free(&plain);
}

/* ---- KHR_draco_mesh_compression ------------------------------------------------------ */

static const struct encode_attribute attributes[] = {
    {0, 5126, 3, false, 0, grid.position},
    {1, 5126, 3, false, 0, grid.normal},
    {3, 5123, 2, true, 0, grid.uv},
};

#define DRACO(attributes)                                                              \
    "\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0,"                \
    "\"attributes\":{" attributes "}}}}"
#define ALL     "\"POSITION\":10,\"NORMAL\":11,\"TEXCOORD_0\":12"
#define COUNTED "{" ATTRIBUTES ",\"indices\":3," DRACO(ALL)

/** A document whose view 0 is the Draco mesh. */
static struct document *draco_document(bool edgebreaker)
{
    static struct document d;
    static uint8_t bytes[32768];
    const struct encode_mesh mesh = {POINTS, FACES, grid.wide, attributes, 3};
    const size_t size = encode_draco(&mesh, edgebreaker, bytes, sizeof bytes);
    assert_true(size > 0);
    d = (struct document){{0}, {0}, 0, 0};
    add_view(&d, bytes, size);
    return &d;
}

static void must(enum pbnds_status status)
{
    if (status != PBNDS_OK) fail_msg("%s", fault.message);
}

static void draco_is_like_plain_data(void **state)
{
    (void)state;
    struct pbnds_scene s;
    for (int method = 0; method < 2; ++method) {
        struct document *d = draco_document(method == 1);
        must(load_document(d, COUNTED, accessors(false, POINTS, 3 * FACES), "", NULL,
                           &s));
        assert_string_equal(warnings, "");
        assert_like_plain(&s);
        pbnds_scene_free(&s);
        /* A strip, whose accessor counts its indices as it likes, or none at all. */
        must(load_document(d, "{" ATTRIBUTES ",\"indices\":3,\"mode\":5," DRACO(ALL),
                           accessors(false, POINTS, 100), "", NULL, &s));
        assert_like_plain(&s);
        pbnds_scene_free(&s);
        must(load_document(d, "{" ATTRIBUTES "," DRACO(ALL),
                           accessors(false, POINTS, 1), "", NULL, &s));
        assert_like_plain(&s);
        pbnds_scene_free(&s);
    }
}

/* Two primitives of one mesh: what is decoded for one is not the other's. */
static void draco_meshes_do_not_mix(void **state)
{
    (void)state;
    struct pbnds_scene s;
    struct document *d = draco_document(false);
    must(load_document(d, COUNTED "," COUNTED, accessors(false, POINTS, 3 * FACES), "",
                       NULL, &s));
    assert_int_equal(s.mesh_count, 2);
    assert_int_equal(s.triangle_count, 2 * FACES);
    assert_memory_equal(s.meshes[0].position, s.meshes[1].position,
                        sizeof grid.position);
    pbnds_scene_free(&s);
}

/* The views of the accessors are a fallback for others; attributes that the compressed
 * data lack come from theirs. */
static void draco_goes_before_its_fallback(void **state)
{
    (void)state;
    struct pbnds_scene s;
    struct document *d = draco_document(false);
    static const float nonsense[POINTS][3];
    add_view(d, nonsense, sizeof nonsense);
    add_view(d, grid.uv, sizeof grid.uv);
    add_view(d, grid.index, sizeof grid.index);
    char list[1024];
    (void)snprintf(
        list, sizeof list,
        "{\"componentType\":5126,\"type\":\"VEC3\",\"count\":%d,"
        "\"bufferView\":1},{\"componentType\":5126,\"type\":\"VEC3\","
        "\"count\":%d,\"bufferView\":1},{\"componentType\":5123,"
        "\"normalized\":true,\"type\":\"VEC2\",\"count\":%d,\"bufferView\":2},"
        "{\"componentType\":5123,\"type\":\"SCALAR\",\"count\":%d,"
        "\"bufferView\":3}",
        POINTS, POINTS, POINTS, 3 * FACES);
    must(load_document(
        d, "{" ATTRIBUTES ",\"indices\":3," DRACO("\"POSITION\":10,\"NORMAL\":11"),
        list, "", NULL, &s));
    assert_like_plain(&s);
    pbnds_scene_free(&s);
}

static void draco_faults_are_told(void **state)
{
    (void)state;
    static const struct {
        const char *primitive;
        int points, indices;
        enum pbnds_status status;
    } cases[] = {
        {COUNTED, POINTS + 1, 3 * FACES, PBNDS_ERROR_FORMAT},
        {COUNTED, POINTS, 3 * FACES - 3, PBNDS_ERROR_FORMAT},
        {COUNTED, POINTS, 2000000000, PBNDS_ERROR_FORMAT},
        {"{" ATTRIBUTES ",\"indices\":3," DRACO("\"POSITION\":13"), POINTS, 3 * FACES,
         PBNDS_ERROR_FORMAT}, /* no such id */
        {"{" ATTRIBUTES ",\"indices\":3," DRACO("\"POSITION\":12"), POINTS, 3 * FACES,
         PBNDS_ERROR_FORMAT}, /* two components */
        {"{" ATTRIBUTES ",\"indices\":3," DRACO("\"POSITION\":-1"), POINTS, 3 * FACES,
         PBNDS_ERROR_FORMAT},
        {"{" ATTRIBUTES ",\"indices\":3," DRACO("\"POSITION\":4294967306"), POINTS,
         3 * FACES, PBNDS_ERROR_FORMAT},
        {"{" ATTRIBUTES ",\"indices\":0," DRACO(ALL), POINTS, 3 * FACES,
         PBNDS_ERROR_FORMAT}, /* VEC3 of floats */
        {"{" ATTRIBUTES ",\"indices\":9," DRACO(ALL), POINTS, 3 * FACES,
         PBNDS_ERROR_FORMAT},
        {"{\"attributes\":{\"POSITION\":9},\"indices\":3," DRACO(ALL), POINTS,
         3 * FACES, PBNDS_ERROR_FORMAT},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        struct pbnds_scene s;
        const enum pbnds_status status = load_document(
            draco_document(true), cases[i].primitive,
            accessors(false, cases[i].points, cases[i].indices), "", NULL, &s);
        if (status != cases[i].status)
            fail_msg("case %zu gives %d: %s", i, status, fault.message);
    }
    static const char *const views[] = {"\"bufferView\":1", "\"bufferView\":-1",
                                        "\"bufferView\":0.5", "\"bufferVeiw\":0"};
    for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i) {
        struct pbnds_scene s;
        char *primitive = edit(COUNTED, "\"bufferView\":0", views[i]);
        assert_int_equal(load_document(draco_document(true), primitive,
                                       accessors(false, POINTS, 3 * FACES), "", NULL,
                                       &s),
                         PBNDS_ERROR_FORMAT);
        free(primitive);
    }
}

static void geometry_has_a_budget(void **state)
{
    (void)state;
    struct pbnds_scene s;
    /* Less than the decoded grid takes alone. */
    const struct pbnds_gltf_options tight = {.max_geometry = 4096};
    assert_int_equal(load_document(draco_document(true), COUNTED,
                                   accessors(false, POINTS, 3 * FACES), "", &tight, &s),
                     PBNDS_ERROR_MEMORY);
    const struct pbnds_gltf_options wide = {.max_geometry = 1 << 20};
    must(load_document(draco_document(true), COUNTED,
                       accessors(false, POINTS, 3 * FACES), "", &wide, &s));
    pbnds_scene_free(&s);
}

/* ---- EXT_meshopt_compression ---------------------------------------------------------- */

/** Appends a view of `count` elements that is there in compressed form only; its plain
 *  form would lie in buffer 1, which has no data. */
static void add_packed(struct document *d, const char *mode, const uint8_t *bytes,
                       size_t size, size_t count, size_t stride, const char *more)
{
    const size_t at = put(d, bytes, size);
    add_text(d->views, sizeof d->views,
             "%s{\"buffer\":1,\"byteLength\":%zu,\"extensions\":{"
             "\"EXT_meshopt_compression\":{\"buffer\":0,\"byteOffset\":%zu,"
             "\"byteLength\":%zu,\"byteStride\":%zu,\"count\":%zu,\"mode\":\"%s\"%s}}}",
             d->view_count++ ? "," : "", count * stride, at, size, stride, count, mode,
             more);
}

static void add_attribute(struct document *d, const void *data, size_t stride)
{
    static uint8_t bytes[32768];
    const size_t size =
        meshopt_encodeVertexBuffer(bytes, sizeof bytes, data, POINTS, stride);
    add_packed(d, "ATTRIBUTES", bytes, size, POINTS, stride, "");
}

static struct document *meshopt_document(bool triangles)
{
    static struct document d;
    static uint8_t bytes[8192];
    d = (struct document){{0}, {0}, 0, 0};
    add_attribute(&d, grid.position, 12);
    add_attribute(&d, grid.normal, 12);
    add_attribute(&d, grid.uv, 4);
    const size_t size =
        triangles
            ? meshopt_encodeIndexBuffer(bytes, sizeof bytes, grid.wide, 3 * FACES)
            : meshopt_encodeIndexSequence(bytes, sizeof bytes, grid.wide, 3 * FACES);
    add_packed(&d, triangles ? "TRIANGLES" : "INDICES", bytes, size, 3 * FACES, 2,
               ",\"filter\":\"NONE\"");
    return &d;
}

#define FALLBACK                                                                       \
    ",{\"byteLength\":65536,\"extensions\":{\"EXT_meshopt_compression\":{"             \
    "\"fallback\":true}}}"

static void meshopt_is_like_plain_data(void **state)
{
    (void)state;
    struct pbnds_scene s;
    for (int mode = 0; mode < 2; ++mode) {
        must(load_document(meshopt_document(mode == 0), PRIMITIVE,
                           accessors(true, POINTS, 3 * FACES), FALLBACK, NULL, &s));
        assert_string_equal(warnings, "");
        assert_like_plain(&s);
        pbnds_scene_free(&s);
    }
    const struct pbnds_gltf_options tight = {.max_geometry = 1500};
    assert_int_equal(load_document(meshopt_document(true), PRIMITIVE,
                                   accessors(true, POINTS, 3 * FACES), FALLBACK, &tight,
                                   &s),
                     PBNDS_ERROR_MEMORY);
}

/* Normals by the octahedral filter, as four signed bytes (KHR_mesh_quantization). */
static void meshopt_filters_reach_the_mesh(void **state)
{
    (void)state;
    struct pbnds_scene s;
    static struct document d;
    static uint8_t bytes[8192];
    static float unit[POINTS][4];
    static int8_t folded[POINTS][4];
    d = (struct document){{0}, {0}, 0, 0};
    for (int i = 0; i < POINTS; ++i)
        memcpy(unit[i], grid.normal[i], sizeof grid.normal[i]);
    meshopt_encodeFilterOct(folded, POINTS, 4, 8, unit[0]);
    add_attribute(&d, grid.position, 12);
    const size_t size =
        meshopt_encodeVertexBuffer(bytes, sizeof bytes, folded, POINTS, 4);
    add_packed(&d, "ATTRIBUTES", bytes, size, POINTS, 4, ",\"filter\":\"OCTAHEDRAL\"");
    char list[512];
    (void)snprintf(list, sizeof list,
                   "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\","
                   "\"count\":%d},{\"bufferView\":1,\"componentType\":5120,"
                   "\"normalized\":true,\"type\":\"VEC3\",\"count\":%d}",
                   POINTS, POINTS);
    char *strided =
        edit(d.views, "\"byteLength\":324,", "\"byteLength\":324,\"byteStride\":4,");
    memcpy(d.views, strided, strlen(strided) + 1);
    free(strided);
    must(load_document(&d, "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}", list,
                       FALLBACK, NULL, &s));
    for (size_t i = 0; i < s.meshes[0].vertex_count; ++i) {
        assert_near3(s.meshes[0].normal[i],
                     pbnds_vec3_make(unit[i][0], unit[i][1], unit[i][2]), 0.03);
    }
    pbnds_scene_free(&s);
}

static void meshopt_faults_are_told(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to;
    } edits[] = {
        {"\"buffer\":0", "\"buffer\":2"},
        {"\"buffer\":0", "\"buffer\":-1"},
        {"\"buffer\":0", "\"buffer\":1"}, /* which has no data */
        {"\"byteOffset\":0", "\"byteOffset\":60000"},
        {"\"byteOffset\":0", "\"byteOffset\":-1"},
        {"\"byteOffset\":0", "\"byteOffset\":9007199254740991"},
        {"\"byteStride\":12", "\"byteStride\":0"},
        {"\"byteStride\":12", "\"byteStride\":16"},
        {"\"byteStride\":12", "\"byteStride\":4294967308"},
        {"\"count\":81", "\"count\":82"},
        {"\"count\":81", "\"count\":\"81\""},
        {"\"count\":81",
         "\"count\":1537228672809129302"}, /* times 12 is 8 in 64 bits */
        {"\"mode\":\"ATTRIBUTES\"", "\"mode\":\"ATTRIBUTE\""},
        {"\"mode\":\"ATTRIBUTES\"", "\"mode\":7"},
        {"\"mode\":\"ATTRIBUTES\"", "\"mode\":\"TRIANGLES\""},
        {"\"mode\":\"ATTRIBUTES\"",
         "\"mode\":\"ATTRIBUTES\",\"filter\":\"QUATERNION\""},
        {"\"mode\":\"TRIANGLES\"", "\"mode\":\"INDICES\""},
        {"\"filter\":\"NONE\"", "\"filter\":\"OCTAHEDRAL\""},
        {"{\"buffer\":1,", "{\"buffer\":1,\"byteStride\":16,"},
        {"EXT_meshopt_compression", "EXT_meshopt_something"},
    };
    for (size_t i = 0; i < sizeof edits / sizeof edits[0]; ++i) {
        struct pbnds_scene s;
        struct document *d = meshopt_document(true);
        char *views = edit(d->views, edits[i].from, edits[i].to);
        memcpy(d->views, views, strlen(views) + 1);
        free(views);
        const enum pbnds_status status = load_document(
            d, PRIMITIVE, accessors(true, POINTS, 3 * FACES), FALLBACK, NULL, &s);
        if (status != PBNDS_ERROR_FORMAT)
            fail_msg("%s gives %d: %s", edits[i].to, status, fault.message);
    }
}

/* ---- damage, and a real file --------------------------------------------------------- */

static void damage_is_survived(void **state)
{
    (void)state;
    struct pbnds_rng rng = pbnds_rng_make(2, 0, 0);
    const struct pbnds_gltf_options options = {.max_geometry = 64 << 20};
    for (int kind = 0; kind < 4; ++kind) {
        for (int i = 0; i < 300; ++i) {
            struct pbnds_scene s;
            struct document *d =
                kind < 2 ? draco_document(kind == 1) : meshopt_document(kind == 2);
            for (int k = 0; k <= i % 4; ++k)
                d->bin[pbnds_rng_u64(&rng) % d->bin_size] ^=
                    (uint8_t)(1u << (pbnds_rng_u64(&rng) % 8));
            const enum pbnds_status status =
                load_document(d, kind < 2 ? COUNTED : PRIMITIVE,
                              accessors(kind >= 2, POINTS, 3 * FACES),
                              kind < 2 ? "" : FALLBACK, &options, &s);
            if (status == PBNDS_OK) assert_sound(&s);
            pbnds_scene_free(&s);
        }
    }
}

static double area(const struct pbnds_scene *s)
{
    double sum = 0.0;
    for (int i = 0; i < s->mesh_count; ++i) {
        for (size_t t = 0; t < s->meshes[i].triangle_count; ++t)
            sum += 0.5 * (double)pbnds_length(face_normal(&s->meshes[i], t));
    }
    return sum;
}

/* Debian's assimp-testmodels have the same engine compressed and plain. */
static void a_real_file_is_like_its_plain_form(void **state)
{
    (void)state;
    static const char *const packed =
        "/usr/share/assimp/models/glTF2/draco/2CylinderEngine.gltf";
    static const char *const plain = "/usr/share/assimp/models/glTF2/"
                                     "2CylinderEngine-glTF-Binary/2CylinderEngine.glb";
    struct stat info;
    if (stat(packed, &info) != 0 || stat(plain, &info) != 0) skip();
    struct pbnds_scene a, b;
    must(pbnds_gltf_load(packed, NULL, &ear, &a, &fault));
    must(pbnds_gltf_load(plain, NULL, &ear, &b, &fault));
    assert_sound(&a);
    assert_int_equal(a.mesh_count, b.mesh_count);
    assert_int_equal(a.material_count, b.material_count);
    assert_near3(a.lo, b.lo, 0.05);
    assert_near3(a.hi, b.hi, 0.05);
    assert_near(area(&a) / area(&b), 1.0, 1e-3);
    pbnds_scene_free(&a);
    pbnds_scene_free(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draco_is_like_plain_data),
        cmocka_unit_test(draco_meshes_do_not_mix),
        cmocka_unit_test(draco_goes_before_its_fallback),
        cmocka_unit_test(draco_faults_are_told),
        cmocka_unit_test(geometry_has_a_budget),
        cmocka_unit_test(meshopt_is_like_plain_data),
        cmocka_unit_test(meshopt_filters_reach_the_mesh),
        cmocka_unit_test(meshopt_faults_are_told),
        cmocka_unit_test(damage_is_survived),
        cmocka_unit_test(a_real_file_is_like_its_plain_form),
    };
    return cmocka_run_group_tests(tests, make_grid, NULL);
}
