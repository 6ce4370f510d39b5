#include "engine/shade/gbuffer_check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "engine/shade/cryptomatte.h"
#include "engine/shade/gbuffer_channels.h"
#include "engine/shade/gbuffer_header.h"

/* Blender writes 1e10 where nothing was hit. */
#define DEPTH_NOTHING 1e10f
/* Half rounds 1 by this much at most, and so may a sum of shares. */
#define SLACK 1e-3f

enum rule {
    MISSING,
    VERSION,
    LATER,
    HEADER,
    CAMERA,
    TRAP,
    TYPE,
    FINITE,
    RANGE,
    UNIT,
    NEARLY_UNIT,
    FACING,
    DEPTH,
    UNCOVERED,
    COVERED,
    POSITION,
    PROJECTION,
    FRESNEL,
    ID,
    LEFTOVER,
    MATTE_ID,
    MATTE_SUM,
};

static const struct {
    const char *name, *wants;
    bool fault;
} rules[] = {
    [MISSING] = {"channels", "the contract requires this channel, half or float", true},
    [VERSION] = {"contract", "pbnds:contract should say a version that is known",
                 false},
    [LATER] = {"contract", "this program knows no such version of the contract", true},
    [HEADER] = {"header", "the attribute holds no word or number of the contract",
                true},
    [CAMERA] = {"camera", "without a camera, 40 degrees at the origin are assumed",
                false},
    [TRAP] = {"z-order", "sorts before Z, so OpenImageIO takes it for depth", false},
    [TYPE] = {"types", "depth is stored as float, ids as uint", false},
    [FINITE] = {"finite", "no NaN, and no infinity but the Z of nothing", true},
    [RANGE] = {"range", "shares lie in [0, 1], light is not negative", true},
    [UNIT] = {"unit-normals", "normals have length 1 (value: the length)", true},
    [NEARLY_UNIT] = {"unit-normals", "length 1 to 1/1000 (value: the length)", false},
    [FACING] = {"facing", "normals face the eye (value: the cosine)", true},
    [DEPTH] = {"depth", "depth is positive where something was hit", true},
    [UNCOVERED] = {"coverage", "what has depth is covered", false},
    [COVERED] = {"coverage", "what is covered has depth", true},
    [POSITION] = {"position", "depth is that of the position (value: metres off)",
                  true},
    [PROJECTION] = {"position", "the position is seen in its pixel (value: pixels off)",
                    true},
    [FRESNEL] = {"specular", "specular is the luminance of f0 (value: off by)", false},
    [ID] = {"ids", "4294967295 where nothing was hit, and only there", false},
    [LEFTOVER] = {"empty", "zero where nothing was hit", false},
    [MATTE_ID] = {"mattes", "ids are normal floats, shares fall from rank to rank",
                  true},
    [MATTE_SUM] = {"mattes", "shares add up to no more than coverage (value: the sum)",
                   true},
};

/* A file while it is looked at. */
struct lint {
    const struct pbnds_exr *exr;
    struct pbnds_findings *found;
    struct pbnds_gbuffer_origin origin;
    struct pbnds_camera camera;
    struct pbnds_camera_view view;
    int samples;
    const float *depth, *coverage, *normal[3], *position[3];
    bool half_normals;
    int x, y; /* the pixel */
    size_t i;
};

static struct pbnds_finding *finding(struct lint *l, enum rule rule,
                                     const char *channel)
{
    struct pbnds_findings *f = l->found;
    for (int k = 0; k < f->count; ++k) {
        if (f->items[k].wants == rules[rule].wants &&
            strcmp(f->items[k].channel, channel) == 0)
            return &f->items[k];
    }
    if (f->count == PBNDS_FINDINGS_MAX) {
        ++f->dropped;
        return NULL;
    }
    struct pbnds_finding *item = &f->items[f->count++];
    *item = (struct pbnds_finding){.rule = rules[rule].name,
                                   .wants = rules[rule].wants,
                                   .fault = rules[rule].fault,
                                   .x = -1,
                                   .y = -1};
    snprintf(item->channel, sizeof item->channel, "%s", channel);
    return item;
}

static void tell(struct lint *l, enum rule rule, const char *channel, double value)
{
    struct pbnds_finding *item = finding(l, rule, channel);
    if (!item || item->count++ > 0) return;
    item->value = value;
}

static void tell_pixel(struct lint *l, enum rule rule, const char *channel,
                       double value)
{
    struct pbnds_finding *item = finding(l, rule, channel);
    if (!item || item->count++ > 0) return;
    item->x = l->x;
    item->y = l->y;
    item->value = value;
}

static const float *float_plane(const struct pbnds_exr *exr, const char *name)
{
    const struct pbnds_exr_channel *c = pbnds_exr_find(exr, name);
    return c && c->type != PBNDS_EXR_UINT ? c->data : NULL;
}

static bool is_hit(const struct lint *l)
{
    if (l->coverage && l->coverage[l->i] == 0.0f) return false;
    return l->depth && l->depth[l->i] < DEPTH_NOTHING;
}

/* The header. */

static void check_header(struct lint *l, const char *path)
{
    const struct pbnds_exr *exr = l->exr;
    const struct pbnds_exr_attribute *version =
        pbnds_exr_find_attribute(exr, "pbnds:contract");
    if (version && version->type == PBNDS_EXR_ATTRIBUTE_INT)
        l->found->contract = version->value.i;
    if (l->found->contract < 1) tell(l, VERSION, "pbnds:contract", l->found->contract);
    if (l->found->contract > PBNDS_GBUFFER_CONTRACT)
        tell(l, LATER, "pbnds:contract", l->found->contract);
    struct pbnds_error error;
    enum pbnds_through through;
    if (l->found->contract <= PBNDS_GBUFFER_CONTRACT &&
        pbnds_header_origin(exr, path, &l->origin, &error) != PBNDS_OK)
        tell(l, HEADER, "pbnds:normalSpace, pbnds:depth", 0.0);
    if (pbnds_header_sampling(exr, path, &l->samples, &through, &error) != PBNDS_OK)
        tell(l, HEADER, "pbnds:samples, pbnds:through", 0.0);
    if (pbnds_header_camera(exr, path, &l->camera, &error) != PBNDS_OK) {
        tell(l, HEADER, "pbnds:worldFromCamera, pbnds:yfov, pbnds:ymag", 0.0);
        l->camera.world_from_camera = pbnds_mat4_identity();
        l->camera.orthographic = false;
        l->camera.yfov = 40.0f * PBNDS_PI / 180.0f;
        l->position[0] = NULL; /* cannot be judged */
    } else if (!pbnds_exr_find_attribute(exr, "pbnds:worldFromCamera")) {
        tell(l, CAMERA, "pbnds:worldFromCamera", 0.0);
    }
    l->view = pbnds_camera_view(&l->camera, exr->width, exr->height);
}

static void check_types(struct lint *l)
{
    for (int c = 0; c < pbnds_gbuffer_channel_count(); ++c) {
        const struct pbnds_gbuffer_channel *want = pbnds_gbuffer_channel_at(c);
        const struct pbnds_exr_channel *got = pbnds_exr_find(l->exr, want->name);
        if (want->required && !float_plane(l->exr, want->name)) {
            tell(l, MISSING, want->name, 0.0);
        } else if (got && want->kind == PBNDS_CHANNEL_ID &&
                   got->type != PBNDS_EXR_UINT) {
            tell(l, TYPE, want->name, got->type);
        } else if (got && want->kind == PBNDS_CHANNEL_METRES &&
                   got->type != PBNDS_EXR_FLOAT) {
            tell(l, TYPE, want->name, got->type);
        }
    }
    for (int c = 0; c < l->exr->channel_count; ++c) {
        const char *name = l->exr->channels[c].name;
        const size_t n = strlen(name);
        if (n > 2 && strcmp(name + n - 2, ".Z") == 0 && strcmp(name, "Z") < 0)
            tell(l, TRAP, name, 0.0);
    }
}

/* One channel over all pixels. */

static void check_value(struct lint *l, const struct pbnds_gbuffer_channel *c,
                        float value)
{
    const bool depth = c->kind == PBNDS_CHANNEL_METRES;
    if (depth && value == INFINITY && l->coverage && l->coverage[l->i] > 0.0f) {
        tell_pixel(l, COVERED, "Z", (double)value);
    } else if (!isfinite(value) && !(depth && value == INFINITY)) {
        if (c->required || is_hit(l) || strcmp(c->name, "coverage.A") == 0)
            tell_pixel(l, FINITE, c->name, (double)value);
    } else if (c->kind == PBNDS_CHANNEL_UNIT) {
        if (value < -SLACK || value > 1.0f + SLACK)
            tell_pixel(l, RANGE, c->name, (double)value);
    } else if (c->kind == PBNDS_CHANNEL_LIGHT) {
        if (value < 0.0f) tell_pixel(l, RANGE, c->name, (double)value);
    }
    if (!is_hit(l) && isfinite(value) && value != 0.0f && !depth &&
        strcmp(c->name, "coverage.A") != 0)
        tell_pixel(l, LEFTOVER, c->name, (double)value);
}

static void next_pixel(struct lint *l, size_t i)
{
    l->i = i;
    l->x = (int)(i % (size_t)l->exr->width);
    l->y = (int)(i / (size_t)l->exr->width);
}

static void check_channel(struct lint *l, const struct pbnds_gbuffer_channel *c)
{
    const size_t count = (size_t)l->exr->width * (size_t)l->exr->height;
    const struct pbnds_exr_channel *plane = pbnds_exr_find(l->exr, c->name);
    if (!plane) return;
    if (c->kind == PBNDS_CHANNEL_ID && plane->type == PBNDS_EXR_UINT) {
        const uint32_t *ids = plane->data;
        for (size_t i = 0; i < count; ++i) {
            next_pixel(l, i);
            if (is_hit(l) == (ids[i] == UINT32_MAX)) tell_pixel(l, ID, c->name, ids[i]);
        }
    } else if (plane->type != PBNDS_EXR_UINT) {
        const float *values = plane->data;
        for (size_t i = 0; i < count; ++i) {
            next_pixel(l, i);
            check_value(l, c, values[i]);
        }
    }
}

/* What several channels say together, where something was hit. */

static struct pbnds_vec3 at(const float *const planes[3], size_t i)
{
    return pbnds_vec3_make(planes[0][i], planes[1][i], planes[2][i]);
}

static bool finite3(struct pbnds_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

static void check_normal(struct lint *l, const struct pbnds_ray *ray)
{
    struct pbnds_vec3 n = at(l->normal, l->i);
    if (!finite3(n)) return;
    const float length = pbnds_length(n);
    if (fabsf(length - 1.0f) > 1e-2f) {
        tell_pixel(l, UNIT, "normal", (double)length);
    } else if (fabsf(length - 1.0f) > (l->half_normals ? 2e-3f : 1e-3f)) {
        tell_pixel(l, NEARLY_UNIT, "normal", (double)length);
    }
    if (l->origin.normal_space == PBNDS_NORMAL_CAMERA)
        n = pbnds_mat4_vector(&l->camera.world_from_camera, n);
    const float cosine = -pbnds_dot(n, ray->direction);
    if (cosine < -SLACK) tell_pixel(l, FACING, "normal", (double)cosine);
}

/* Planar depth as stored, whatever its kind. */
static float planar(const struct lint *l, const struct pbnds_ray *ray)
{
    const float z = l->depth[l->i];
    return l->origin.depth == PBNDS_DEPTH_DISTANCE
               ? z * pbnds_dot(ray->direction, l->view.forward)
               : z;
}

/* A position may be off by the rounding of coordinates that are far from the origin. The
 * mean position of an anti-aliased pixel lies in the pixel, that of a point at its
 * centre. */
/* Pixels that a position may be off beside rounding, and how many pixels may be further off:
 * barycentric coordinates of slivers are ill-conditioned (of ten million pixels of
 * procedural worlds five were off by 0.05 to 0.08, one by 0.9). A wrong camera, or pixel
 * centres at corners, put every pixel off by half of one or more. */
#define SLIVER_MISS  0.25f
#define SLIVER_SHARE 1e-4

static void check_position(struct lint *l, const struct pbnds_ray *ray)
{
    const struct pbnds_vec3 p = at(l->position, l->i);
    if (!finite3(p)) return;
    const float z = planar(l, ray);
    const float off = fabsf(pbnds_camera_depth(&l->camera, p) - z);
    const float largest = fmaxf(pbnds_length(p), pbnds_length(l->view.eye));
    const float rounding = 1e-6f * largest;
    if (off > 1e-3f * z + rounding) {
        tell_pixel(l, POSITION, "Z", (double)off);
        return;
    }
    float x = 0.0f, y = 0.0f;
    if (!pbnds_camera_view_project(&l->view, p, &x, &y)) return;
    const float miss =
        fmaxf(fabsf(x - (float)l->x - 0.5f), fabsf(y - (float)l->y - 0.5f));
    const float pixel = l->view.pixel * (l->view.orthographic ? 1.0f : z);
    const float most = (l->samples > 1 ? 0.5f : 0.0f) + SLIVER_MISS + rounding / pixel;
    if (miss > most) tell_pixel(l, PROJECTION, "position", (double)miss);
}

static void check_pixel(struct lint *l)
{
    const float z = l->depth[l->i];
    if (!is_hit(l)) {
        if (l->coverage && l->coverage[l->i] == 0.0f && z < DEPTH_NOTHING)
            tell_pixel(l, UNCOVERED, "Z", (double)z);
        return;
    }
    const struct pbnds_ray ray =
        pbnds_camera_view_ray(&l->view, (float)l->x + 0.5f, (float)l->y + 0.5f);
    if (l->normal[0]) check_normal(l, &ray);
    if (!(z > 0.0f)) {
        if (isfinite(z)) tell_pixel(l, DEPTH, "Z", (double)z);
    } else if (l->position[0]) {
        check_position(l, &ray);
    }
}

static void check_pixels(struct lint *l)
{
    const size_t count = (size_t)l->exr->width * (size_t)l->exr->height;
    for (size_t i = 0; i < count; ++i) {
        next_pixel(l, i);
        check_pixel(l);
    }
}

static void check_fresnel(struct lint *l)
{
    const float *const f0[3] = {float_plane(l->exr, "f0.R"),
                                float_plane(l->exr, "f0.G"),
                                float_plane(l->exr, "f0.B")};
    const float *specular = float_plane(l->exr, "specular.R");
    if (!f0[0] || !f0[1] || !f0[2] || !specular) return;
    const size_t count = (size_t)l->exr->width * (size_t)l->exr->height;
    for (size_t i = 0; i < count; ++i) {
        next_pixel(l, i);
        const float off = fabsf(pbnds_luminance(at(f0, i)) - specular[i]);
        if (is_hit(l) && off > 2.0f * SLACK)
            tell_pixel(l, FRESNEL, "specular.R", (double)off);
    }
}

/* One layer of ours: NAME00.R (id) .G (share) .B .A, NAME01 and so on. */
static void check_matte(struct lint *l, const char *layer)
{
    static const char parts[] = {'R', 'G', 'B', 'A'};
    const float *id[PBNDS_CRYPTOMATTE_RANKS], *share[PBNDS_CRYPTOMATTE_RANKS];
    for (int r = 0; r < PBNDS_CRYPTOMATTE_RANKS; ++r) {
        char name[64];
        snprintf(name, sizeof name, "%s%02d.%c", layer, r / 2, parts[2 * (r % 2)]);
        id[r] = float_plane(l->exr, name);
        snprintf(name, sizeof name, "%s%02d.%c", layer, r / 2, parts[2 * (r % 2) + 1]);
        share[r] = float_plane(l->exr, name);
        if (!id[r] || !share[r]) return;
    }
    const size_t count = (size_t)l->exr->width * (size_t)l->exr->height;
    for (size_t i = 0; i < count; ++i) {
        next_pixel(l, i);
        float sum = 0.0f;
        for (int r = 0; r < PBNDS_CRYPTOMATTE_RANKS; ++r) {
            const float s = share[r][i];
            sum += s;
            if ((s != 0.0f && !isnormal(id[r][i])) || !(s >= 0.0f) ||
                (r > 0 && s > share[r - 1][i]))
                tell_pixel(l, MATTE_ID, layer, (double)id[r][i]);
        }
        const float most = l->coverage ? l->coverage[i] : 1.0f;
        if (sum > most + SLACK) tell_pixel(l, MATTE_SUM, layer, (double)sum);
    }
}

static void find_planes(struct lint *l)
{
    static const char *const axes[] = {"X", "Y", "Z"};
    char name[64];
    for (int c = 0; c < 3; ++c) {
        snprintf(name, sizeof name, "normal.%s", axes[c]);
        l->normal[c] = float_plane(l->exr, name);
        snprintf(name, sizeof name, "position.%s", axes[c]);
        l->position[c] = float_plane(l->exr, name);
    }
    if (!l->normal[1] || !l->normal[2]) l->normal[0] = NULL;
    if (!l->position[1] || !l->position[2]) l->position[0] = NULL;
    l->depth = float_plane(l->exr, "Z");
    l->coverage = float_plane(l->exr, "coverage.A");
    const struct pbnds_exr_channel *nx = pbnds_exr_find(l->exr, "normal.X");
    l->half_normals = nx && nx->type == PBNDS_EXR_HALF;
}

/* A needle of a triangle here and there is no fault of the file. */
static void bear_slivers(struct lint *l)
{
    const double pixels = (double)l->exr->width * (double)l->exr->height;
    for (int k = 0; k < l->found->count; ++k) {
        struct pbnds_finding *item = &l->found->items[k];
        if (item->wants == rules[PROJECTION].wants &&
            (double)item->count <= SLIVER_SHARE * pixels)
            item->fault = false;
    }
}

void pbnds_gbuffer_check(const struct pbnds_exr *exr, const char *path,
                         struct pbnds_findings *findings)
{
    memset(findings, 0, sizeof *findings);
    findings->width = exr->width;
    findings->height = exr->height;
    struct lint l = {.exr = exr, .found = findings, .samples = 1};
    find_planes(&l);
    check_header(&l, path);
    check_types(&l);
    for (int c = 0; c < pbnds_gbuffer_channel_count(); ++c)
        check_channel(&l, pbnds_gbuffer_channel_at(c));
    if (l.depth) check_pixels(&l);
    bear_slivers(&l);
    check_fresnel(&l);
    check_matte(&l, "CryptoObject");
    check_matte(&l, "CryptoMaterial");
}

int pbnds_findings_faults(const struct pbnds_findings *findings)
{
    int faults = 0;
    for (int i = 0; i < findings->count; ++i)
        faults += findings->items[i].fault;
    return faults;
}
