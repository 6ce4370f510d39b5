/* Images: formats, where they come from, and what is said of them. */
#include "engine/core/file.h"
#include "tests/engine/scene/gltf/fixture.h"

/* 8 x 8, grey of 204: one coefficient, made by hand. */
#define JPEG_BASE64                                                                    \
    "/9j/2wBDAAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgI"                 \
    "CAgICAgICAgICAgICAgICAgICAgICAj/wAALCAAIAAgBAREA/8QAFAABAAAAAAAA"                 \
    "AAAAAAAAAAAAB//EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAIAQEAAD8ATH//2Q=="

/* 2 x 1, lossy colour with alpha 255 and 128. */
#define WEBP_BASE64                                                                    \
    "UklGRmoAAABXRUJQVlA4WAoAAAAQAAAAAQAAAAAAQUxQSAMAAAAA/4AAVlA4IEAA"                 \
    "AACwAgCdASoCAAEAAAAAJaACdLoB+AH6AfwABmVYjMAA/v/VD6pT/4a/80WP/42t"                 \
    "Je2mf/G1//7wUNl+nH/93iAA"

/* 2 x 1, sixteen bits: 65535 257 0, 32896 1 256. */
#define PNG16_BASE64                                                                   \
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABEAIAAAAr0DSeAAAAFElEQVR42mP4/5+R"                 \
    "kYGhoYEBSAEAHI4DA1BV8a4AAAAASUVORK5CYII="

enum picture { PNG, JPEG, WEBP, PNG16, PICTURES };

static const struct {
    const char *base64, *type, *file;
    int width;
    double rgba[4]; /* first texel as stored */
    double tolerance;
} pictures[PICTURES] = {
    {PNG_BASE64, "image/png", "image test.png", 2, {1, 0, 0, 1}, 0},
    {JPEG_BASE64, "image/jpeg", "image_test.jpg", 8, {0.8, 0.8, 0.8, 1}, 0.5 / 255},
    {WEBP_BASE64,
     "image/webp",
     "image_test.webp",
     2,
     {158 / 255.0, 49 / 255.0, 4 / 255.0, 1},
     2.5 / 255},
    {PNG16_BASE64, "image/png", "image_test_16.png", 2, {1, 257 / 65535.0, 0, 1}, 1e-7},
};

static uint8_t *decode_base64(const char *text, size_t *size)
{
    static const char alphabet[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    uint8_t *out = malloc(strlen(text));
    uint32_t bits = 0;
    int count = 0;
    for (*size = 0; *text && *text != '='; ++text) {
        bits = bits << 6 | (uint32_t)(strchr(alphabet, *text) - alphabet);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        out[(*size)++] = (uint8_t)(bits >> count);
    }
    return out;
}

/** The square, whose base colour is texture 0, with members after "images". */
static char *document(const char *textures, const char *images)
{
    char members[4096];
    (void)snprintf(members, sizeof members,
                   "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{"
                   "\"index\":0}}}],\"textures\":[%s],\"images\":[%s],\"buffers\"",
                   textures, images);
    return edit(square_json, "\"buffers\"", members);
}

static void assert_texel(const struct pbnds_scene *s, enum picture p)
{
    assert_int_equal(s->image_count, 1);
    assert_int_equal(s->images[0].width, pictures[p].width);
    assert_true(p == PNG16 ? s->images[0].f32 != NULL : s->images[0].u8 != NULL);
    const struct pbnds_texture *t =
        &s->textures[s->materials[0].base_color_texture.texture];
    const struct pbnds_vec4 c =
        pbnds_texture_sample(t, (struct pbnds_vec2){0.25f, 0.5f}, false);
    const float got[4] = {c.x, c.y, c.z, c.w};
    for (int i = 0; i < 4; ++i)
        assert_near(got[i], pictures[p].rgba[i], pictures[p].tolerance);
}

static void in_a_data_uri(enum picture p, const char *type, struct pbnds_scene *s)
{
    char image[2048];
    (void)snprintf(image, sizeof image, "{\"uri\":\"data:%s;base64,%s\"}", type,
                   pictures[p].base64);
    char *json = document("{\"source\":0}", image);
    must_load(json, &square, sizeof square, s);
    free(json);
}

static void in_a_buffer_view(enum picture p, const char *type, struct pbnds_scene *s)
{
    size_t size = 0;
    uint8_t *bytes = decode_base64(pictures[p].base64, &size);
    uint8_t bin[1024];
    memcpy(bin, &square, sizeof square);
    memcpy(bin + sizeof square, bytes, size);
    char image[256], length[64], view[256];
    (void)snprintf(image, sizeof image, "{\"bufferView\":2,\"mimeType\":\"%s\"}", type);
    (void)snprintf(length, sizeof length, "\"byteLength\":%zu}]", sizeof square + size);
    (void)snprintf(view, sizeof view,
                   "\"byteLength\":12},{\"buffer\":0,\"byteOffset\":%zu,"
                   "\"byteLength\":%zu}",
                   sizeof square, size);
    char *a = document("{\"source\":0}", image);
    char *b = edit(a, "\"byteLength\":144}]", length);
    char *json = edit(b, "\"byteLength\":12}", view);
    must_load(json, bin, (sizeof square + size + 3) / 4 * 4, s);
    free(a);
    free(b);
    free(json);
    free(bytes);
}

/** Loads the document with its BIN chunk, files below the current folder. */
static enum pbnds_status load_here(const char *json, struct pbnds_scene *s)
{
    size_t size = 0;
    uint8_t *glb = make_glb(json, &square, sizeof square, &size);
    warnings[0] = 0;
    const enum pbnds_status status =
        pbnds_gltf_load_memory(glb, size, "test.glb", ".", NULL, &ear, s, &fault);
    free(glb);
    return status;
}

static void in_a_file(enum picture p, struct pbnds_scene *s)
{
    size_t size = 0;
    uint8_t *bytes = decode_base64(pictures[p].base64, &size);
    assert_int_equal(pbnds_file_write(pictures[p].file, bytes, size, &fault), PBNDS_OK);
    char image[256];
    (void)snprintf(image, sizeof image, "{\"uri\":\"%s\"}",
                   p == PNG ? "image%20test.png" : pictures[p].file);
    char *json = document("{\"source\":0}", image);
    if (load_here(json, s) != PBNDS_OK) fail_msg("%s", fault.message);
    (void)remove(pictures[p].file);
    free(bytes);
    free(json);
}

static void every_format_from_everywhere(void **state)
{
    (void)state;
    for (int p = 0; p < PICTURES; ++p) {
        struct pbnds_scene s;
        in_a_data_uri((enum picture)p, pictures[p].type, &s);
        assert_texel(&s, (enum picture)p);
        assert_string_equal(warnings, "");
        pbnds_scene_free(&s);
        in_a_buffer_view((enum picture)p, pictures[p].type, &s);
        assert_texel(&s, (enum picture)p);
        assert_string_equal(warnings, "");
        pbnds_scene_free(&s);
        in_a_file((enum picture)p, &s);
        assert_texel(&s, (enum picture)p);
        assert_string_equal(warnings, "");
        pbnds_scene_free(&s);
    }
}

/* The bytes count, not what is said of them. */
static void a_wrong_media_type_is_told(void **state)
{
    (void)state;
    struct pbnds_scene s;
    in_a_data_uri(JPEG, "image/png", &s);
    assert_texel(&s, JPEG);
    assert_non_null(strstr(warnings, "image 0"));
    assert_non_null(strstr(warnings, "image/png"));
    assert_non_null(strstr(warnings, "image/jpeg"));
    pbnds_scene_free(&s);
    in_a_buffer_view(PNG, "image/webp", &s);
    assert_texel(&s, PNG);
    assert_non_null(strstr(warnings, "image/webp"));
    pbnds_scene_free(&s);
    in_a_data_uri(JPEG, "image/jpg", &s);
    pbnds_scene_free(&s);
    assert_string_equal(warnings, "");
    in_a_data_uri(PNG, "application/octet-stream", &s);
    pbnds_scene_free(&s);
    assert_string_equal(warnings, "");
}

static void a_broken_image_is_named(void **state)
{
    (void)state;
    struct pbnds_scene s;
    char *json = document("{\"source\":1}",
                          "{\"uri\":\"data:,\"},{\"uri\":\"data:image/png;base64,"
                          "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+K\"}");
    assert_int_equal(load(json, &square, sizeof square, &s), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(fault.message, "image 1"));
    free(json);
    json = document("{\"source\":0}", "{\"uri\":\"not there.png\"}");
    assert_int_equal(load_here(json, &s), PBNDS_ERROR_IO);
    assert_non_null(strstr(fault.message, "not there.png"));
    free(json);
    json = document("{\"source\":0}", "{\"uri\":\"data:text/plain,hello\"}");
    assert_int_equal(load(json, &square, sizeof square, &s), PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(fault.message, "image 0"));
    free(json);
    /* What no material uses is not looked at. */
    json =
        document("{\"source\":0},{\"source\":1}", "{\"uri\":\"data:;base64," PNG_BASE64
                                                  "\"},{\"uri\":\"not there.png\"}");
    must_load(json, &square, sizeof square, &s);
    assert_texel(&s, PNG);
    pbnds_scene_free(&s);
    free(json);
}

#define WEBP_TEXTURE(core)                                                             \
    "{" core "\"extensions\":{\"EXT_texture_webp\":{\"source\":1}}}"

static void webp_is_taken_before_its_fallback(void **state)
{
    (void)state;
    struct pbnds_scene s;
    char *json = document(WEBP_TEXTURE("\"source\":0,"),
                          "{\"uri\":\"data:;base64," PNG_BASE64
                          "\"},{\"uri\":\"data:;base64," WEBP_BASE64 "\"}");
    must_load(json, &square, sizeof square, &s);
    assert_texel(&s, WEBP);
    assert_string_equal(warnings, "");
    pbnds_scene_free(&s);
    free(json);
    /* One that cannot be read. */
    json =
        document(WEBP_TEXTURE("\"source\":0,"), "{\"uri\":\"data:;base64," PNG_BASE64
                                                "\"},{\"uri\":\"data:,RIFFxxxxWEBP\"}");
    must_load(json, &square, sizeof square, &s);
    assert_texel(&s, PNG);
    assert_non_null(strstr(warnings, "image 0 is used in its place"));
    pbnds_scene_free(&s);
    free(json);
    json = document(WEBP_TEXTURE("\"source\":0,"), "{\"uri\":\"data:;base64," PNG_BASE64
                                                   "\"},{\"uri\":\"not there.webp\"}");
    must_load(json, &square, sizeof square, &s);
    assert_texel(&s, PNG);
    assert_non_null(strstr(warnings, "not there.webp"));
    pbnds_scene_free(&s);
    free(json);
    /* Neither the one nor the other. */
    json = document(WEBP_TEXTURE("\"source\":0,"),
                    "{\"uri\":\"data:,x\"},{\"uri\":\"data:,RIFFxxxxWEBP\"}");
    assert_int_equal(load(json, &square, sizeof square, &s), PBNDS_ERROR_UNSUPPORTED);
    assert_non_null(strstr(fault.message, "image 0"));
    free(json);
    json = document(WEBP_TEXTURE(""),
                    "{\"uri\":\"data:,x\"},{\"uri\":\"data:,RIFFxxxxWEBP\"}");
    assert_int_equal(load(json, &square, sizeof square, &s), PBNDS_ERROR_FORMAT);
    assert_non_null(strstr(fault.message, "image 1"));
    free(json);
    /* A source that does not exist. */
    json = document(WEBP_TEXTURE(""), "{\"uri\":\"data:;base64," PNG_BASE64 "\"}");
    assert_int_equal(load(json, &square, sizeof square, &s), PBNDS_ERROR_FORMAT);
    free(json);
    json = document(WEBP_TEXTURE("\"source\":2,"),
                    "{\"uri\":\"data:,\"},{\"uri\":\"data:,\"}");
    assert_int_equal(load(json, &square, sizeof square, &s), PBNDS_ERROR_FORMAT);
    free(json);
}

static void a_texture_without_a_readable_image_is_left_out(void **state)
{
    (void)state;
    struct pbnds_scene s;
    char *json = document("{\"extensions\":{\"KHR_texture_basisu\":{\"source\":0}}}",
                          "{\"uri\":\"picture.ktx2\"}");
    must_load(json, &square, sizeof square, &s);
    assert_int_equal(s.materials[0].base_color_texture.texture, -1);
    assert_int_equal(s.image_count, 0);
    assert_non_null(strstr(warnings, "texture 0"));
    pbnds_scene_free(&s);
    free(json);
}

static void images_have_a_budget(void **state)
{
    (void)state;
    struct pbnds_scene s;
    struct pbnds_gltf_options options = {.max_images = 7};
    char *json =
        document("{\"source\":0}", "{\"uri\":\"data:;base64," PNG_BASE64 "\"}");
    assert_int_equal(load_with(json, &square, sizeof square, &options, &s),
                     PBNDS_ERROR_MEMORY);
    options.max_images = 16; /* two texels, with what a texture may add to them */
    assert_int_equal(load_with(json, &square, sizeof square, &options, &s), PBNDS_OK);
    pbnds_scene_free(&s);
    free(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_format_from_everywhere),
        cmocka_unit_test(a_wrong_media_type_is_told),
        cmocka_unit_test(a_broken_image_is_named),
        cmocka_unit_test(webp_is_taken_before_its_fallback),
        cmocka_unit_test(a_texture_without_a_readable_image_is_left_out),
        cmocka_unit_test(images_have_a_budget),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
