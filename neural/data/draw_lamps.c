#include "neural/data/draw_lamps.h"

#include "neural/data/draw_random.h"

static const float degree = PBNDS_PI / 180.0f;

float pbnds_texel_solid_angle(int width, int height, int y)
{
    const double step = 3.14159265358979323846 / (double)height;
    return (float)(2.0 * 3.14159265358979323846 / (double)width *
                   (cos(step * (double)y) - cos(step * (double)(y + 1))));
}

float pbnds_map_luminance(const struct pbnds_image *map)
{
    double sum = 0.0;
    for (int y = 0; y < map->height; ++y) {
        double row = 0.0;
        for (int x = 0; x < map->width; ++x) {
            const float *p = pbnds_image_at(map, x, y);
            row += (double)pbnds_luminance(pbnds_vec3_make(p[0], p[1], p[2]));
        }
        sum += row * (double)pbnds_texel_solid_angle(map->width, map->height, y);
    }
    return (float)(sum / (4.0 * 3.14159265358979323846));
}

/* Chromaticity of the Planckian locus: Kim et al. 2002, "Design of Advanced Color
 * Temperature Control System for HDTV Applications" (cubic splines in 1000 / T). */
struct pbnds_vec3 pbnds_black_body(float kelvin)
{
    const float t = 1000.0f / pbnds_clamp(kelvin, 1667.0f, 25000.0f);
    float x, y;
    if (t > 0.25f) {
        x = ((-0.2661239f * t - 0.2343589f) * t + 0.8776956f) * t + 0.179910f;
    } else {
        x = ((-3.0258469f * t + 2.1070379f) * t + 0.2226347f) * t + 0.240390f;
    }
    if (kelvin < 2222.0f) {
        y = ((-1.1063814f * x - 1.34811020f) * x + 2.18555832f) * x - 0.20219683f;
    } else if (kelvin < 4000.0f) {
        y = ((-0.9549476f * x - 1.37418593f) * x + 2.09137015f) * x - 0.16748867f;
    } else {
        y = ((3.0817580f * x - 5.87338670f) * x + 3.75112997f) * x - 0.37001483f;
    }
    const float cx = x / y, cz = (1.0f - x - y) / y; /* XYZ with Y = 1 */
    struct pbnds_vec3 c = {3.2404542f * cx - 1.5371385f - 0.4985314f * cz,
                           -0.9692660f * cx + 1.8760108f + 0.0415560f * cz,
                           0.0556434f * cx - 0.2040259f + 1.0572252f * cz};
    c = pbnds_vec3_make(fmaxf(c.x, 0.0f), fmaxf(c.y, 0.0f), fmaxf(c.z, 0.0f));
    return pbnds_scale(c, 1.0f / pbnds_luminance(c));
}

/* Direction of a place in the map, in texels. */
static struct pbnds_vec3 map_direction(const struct pbnds_image *map, float x, float y)
{
    const float azimuth = 2.0f * PBNDS_PI * (x / (float)map->width - 0.5f);
    const float polar = PBNDS_PI * y / (float)map->height;
    return pbnds_vec3_make(sinf(polar) * cosf(azimuth), cosf(polar),
                           sinf(polar) * sinf(azimuth));
}

static bool is_lit(const struct pbnds_lamp *lamp, struct pbnds_vec3 w)
{
    const float z = pbnds_dot(w, lamp->direction);
    if (!(z > 0.0f)) return false;
    if (!(lamp->half_y > 0.0f)) return z >= cosf(lamp->half_x);
    const struct pbnds_vec3 up = pbnds_cross(lamp->direction, lamp->side);
    return fabsf(pbnds_dot(w, lamp->side)) <= z * tanf(lamp->half_x) &&
           fabsf(pbnds_dot(w, up)) <= z * tanf(lamp->half_y);
}

/* Share of a texel that the lamp covers, by n x n points. */
static float covered_share(const struct pbnds_lamp *lamp, const struct pbnds_image *map,
                           int x, int y, int n)
{
    int lit = 0;
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const float u = (float)x + ((float)i + 0.5f) / (float)n;
            const float v = (float)y + ((float)j + 0.5f) / (float)n;
            lit += is_lit(lamp, map_direction(map, u, v));
        }
    }
    return (float)lit / (float)(n * n);
}

/* What of a lamp's power goes into which texel. */
struct splat {
    const struct pbnds_lamp *lamp;
    struct pbnds_image *map;
    int points;  /* along a side of a texel: several across the lamp's radius */
    float reach; /* cosine of the angle beyond which no texel is lit           */
    float scale; /* radiance of a covered texel, over the lamp's power         */
};

/* Sum of the solid angles covered; adds light where scale > 0. */
static double sweep(const struct splat *s)
{
    double sum = 0.0;
    for (int y = 0; y < s->map->height; ++y) {
        const double area =
            (double)pbnds_texel_solid_angle(s->map->width, s->map->height, y);
        for (int x = 0; x < s->map->width; ++x) {
            const struct pbnds_vec3 w =
                map_direction(s->map, (float)x + 0.5f, (float)y + 0.5f);
            if (pbnds_dot(w, s->lamp->direction) < s->reach) continue;
            const float share = covered_share(s->lamp, s->map, x, y, s->points);
            sum += area * (double)share;
            float *p = pbnds_image_at(s->map, x, y);
            p[0] += s->scale * share * s->lamp->power.x;
            p[1] += s->scale * share * s->lamp->power.y;
            p[2] += s->scale * share * s->lamp->power.z;
        }
    }
    return sum;
}

static void add_to_texel(const struct pbnds_lamp *lamp, struct pbnds_image *map)
{
    const struct pbnds_vec3 d = lamp->direction;
    const float u = 0.5f + atan2f(d.z, d.x) / (2.0f * PBNDS_PI);
    const float v = acosf(pbnds_clamp(d.y, -1.0f, 1.0f)) / PBNDS_PI;
    const int x = (int)(u * (float)map->width) % map->width;
    const int y =
        (int)pbnds_clamp(v * (float)map->height, 0.0f, (float)map->height - 1.0f);
    const float scale = 1.0f / pbnds_texel_solid_angle(map->width, map->height, y);
    float *p = pbnds_image_at(map, x, y);
    p[0] += scale * lamp->power.x;
    p[1] += scale * lamp->power.y;
    p[2] += scale * lamp->power.z;
}

void pbnds_lamp_add(const struct pbnds_lamp *lamp, struct pbnds_image *map)
{
    const float texel = PBNDS_PI / (float)map->height;
    const float narrow =
        lamp->half_y > 0.0f ? fminf(lamp->half_x, lamp->half_y) : lamp->half_x;
    const float wide =
        1.5f * (lamp->half_y > 0.0f ? lamp->half_x + lamp->half_y : lamp->half_x);
    struct splat s = {.lamp = lamp, .map = map};
    s.points = (int)pbnds_clamp(4.0f * texel / narrow, 4.0f, 48.0f);
    s.reach = cosf(fminf(wide + 1.5f * texel, PBNDS_PI));
    const double sum = sweep(&s);
    if (sum > 0.0) {
        s.scale = (float)(1.0 / sum);
        (void)sweep(&s);
    } else {
        add_to_texel(lamp, map); /* it fell between the points */
    }
}

/* What is drawn. */

static struct pbnds_vec3 draw_color(struct pbnds_rng *rng, float *kelvin)
{
    *kelvin = pbnds_draw_log_uniform(rng, 1900.0f, 12000.0f);
    const struct pbnds_vec3 gel = pbnds_draw_vec3(rng, 0.08f, 1.0f);
    if (pbnds_draw_chance(rng, 0.12)) { /* coloured glass */
        *kelvin = 0.0f;
        return pbnds_scale(gel, 1.0f / pbnds_luminance(gel));
    }
    return pbnds_black_body(*kelvin);
}

static void note_lamp(cJSON *array, const struct pbnds_lamp *lamp, float kelvin)
{
    cJSON *item = cJSON_CreateObject();
    const float d[3] = {lamp->direction.x, lamp->direction.y, lamp->direction.z};
    const float p[3] = {lamp->power.x, lamp->power.y, lamp->power.z};
    cJSON_AddItemToObject(item, "direction", cJSON_CreateFloatArray(d, 3));
    cJSON_AddItemToObject(item, "power", cJSON_CreateFloatArray(p, 3));
    cJSON_AddNumberToObject(item, "half_x_deg", (double)(lamp->half_x / degree));
    if (lamp->half_y > 0.0f)
        cJSON_AddNumberToObject(item, "half_y_deg", (double)(lamp->half_y / degree));
    if (kelvin > 0.0f) cJSON_AddNumberToObject(item, "kelvin", (double)kelvin);
    cJSON_AddItemToArray(array, item);
}

/* Ground, horizon and zenith, each a colour, blended: a sky or a dim room. */
static void draw_surroundings(struct pbnds_rng *rng, struct pbnds_image *map)
{
    const struct pbnds_vec3 tint = pbnds_draw_vec3(rng, 0.75f, 1.25f);
    const float ground = pbnds_draw_log_uniform(rng, 0.05f, 0.8f);
    const float zenith = pbnds_draw_log_uniform(rng, 0.15f, 1.5f);
    const float kelvin = pbnds_draw_log_uniform(rng, 4000.0f, 25000.0f);
    const float sharp = pbnds_draw_log_uniform(rng, 2.0f, 40.0f);
    const struct pbnds_vec3 top = pbnds_scale(pbnds_black_body(kelvin), zenith);
    const struct pbnds_vec3 bottom = pbnds_scale(tint, ground);
    for (int y = 0; y < map->height; ++y) {
        const float h = cosf(PBNDS_PI * ((float)y + 0.5f) / (float)map->height);
        const struct pbnds_vec3 sky =
            pbnds_lerp(pbnds_splat(1.0f), top, sqrtf(fmaxf(h, 0.0f)));
        const struct pbnds_vec3 c =
            pbnds_lerp(bottom, sky, 0.5f + 0.5f * tanhf(sharp * h));
        for (int x = 0; x < map->width; ++x) {
            float *p = pbnds_image_at(map, x, y);
            p[0] = c.x;
            p[1] = c.y;
            p[2] = c.z;
        }
    }
}

static void scale_map(struct pbnds_image *map, float scale)
{
    const size_t n = 3 * (size_t)map->width * (size_t)map->height;
    for (size_t i = 0; i < n; ++i)
        map->data[i] *= scale;
}

static void draw_suns(struct pbnds_rng *rng, struct pbnds_image *map, float share,
                      cJSON *array)
{
    const float u = pbnds_rng_float(rng);
    const int count = u < 0.55f ? 1 : u < 0.8f ? 2 : u < 0.93f ? 3 : 4;
    float weight[4], sum = 0.0f;
    for (int i = 0; i < count; ++i)
        sum += weight[i] = pbnds_draw_log_uniform(rng, 0.15f, 1.0f);
    for (int i = 0; i < count; ++i) {
        struct pbnds_lamp lamp = {.half_y = 0.0f};
        float kelvin;
        lamp.direction = pbnds_draw_direction(rng, -0.15f, 1.0f);
        lamp.half_x = pbnds_draw_log_uniform(rng, 0.2f, 5.0f) * degree;
        const struct pbnds_vec3 color = draw_color(rng, &kelvin);
        lamp.power = pbnds_scale(color, 4.0f * PBNDS_PI * share * weight[i] / sum);
        pbnds_lamp_add(&lamp, map);
        note_lamp(array, &lamp, kelvin);
    }
}

static void draw_box(struct pbnds_rng *rng, struct pbnds_image *map, float share,
                     cJSON *array)
{
    struct pbnds_lamp lamp = {.half_y = 0.0f};
    float kelvin;
    lamp.direction = pbnds_draw_direction(rng, -0.3f, 1.0f);
    lamp.half_x = pbnds_draw_log_uniform(rng, 5.0f, 25.0f) * degree;
    const float flatness = pbnds_draw_log_uniform(rng, 0.3f, 1.0f);
    const float roll = pbnds_draw_uniform(rng, 0.0f, PBNDS_PI);
    if (!pbnds_draw_chance(rng, 0.35)) lamp.half_y = flatness * lamp.half_x;
    const struct pbnds_frame f = pbnds_frame_from_normal(lamp.direction);
    lamp.side = pbnds_mad(pbnds_scale(f.t, cosf(roll)), f.b, sinf(roll));
    const struct pbnds_vec3 color = draw_color(rng, &kelvin);
    lamp.power = pbnds_scale(color, 4.0f * PBNDS_PI * share);
    pbnds_lamp_add(&lamp, map);
    note_lamp(array, &lamp, kelvin);
}

void pbnds_draw_lamps(struct pbnds_rng *rng, struct pbnds_image *map, cJSON *notes)
{
    /* Share of the light that is all around: none (one in five), dim, or a sky's. */
    const float around = pbnds_draw_log_uniform(rng, 0.004f, 0.5f);
    const float rest = pbnds_draw_chance(rng, 0.2) ? 0.0f : around;
    const bool suns = pbnds_draw_chance(rng, 0.6);
    cJSON *array = cJSON_AddArrayToObject(notes, "lamps");
    draw_surroundings(rng, map);
    scale_map(map, rest / pbnds_map_luminance(map));
    if (suns) {
        draw_suns(rng, map, 1.0f - rest, array);
    } else {
        draw_box(rng, map, 1.0f - rest, array);
    }
    cJSON_AddNumberToObject(notes, "surroundings", (double)rest);
}
