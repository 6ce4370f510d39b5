/*
 * Sixteen surfaces at once. The lanes of one mesh go together; what is written here is the
 * common case, with the expressions of surface.c in their order, so that the bits are
 * those of pbnds_scene_surface(). A lane that needs more (an odd material, a degenerate
 * triangle, a normal that has to be turned) is handed to that function.
 */
#include "engine/core/lanes.h"
#include "engine/scene/lookup.h"
#include "engine/scene/packet.h"

enum { LANES = PBNDS_PACKET };

/* What the vertices of every lane's triangle say: [component][lane]. */
struct corners {
    float p[4][LANES], n[4][LANES], t[4][LANES]; /* interpolated; p[3], n[3]: u and v */
    float e1[4][LANES], e2[4][LANES]; /* vertex 1 and 2 less vertex 0; [3]: of u */
    float v1[LANES], v2[LANES];       /* the same of v */
};

/* One mesh of the packet. */
struct group {
    const struct pbnds_mesh *mesh;
    const struct pbnds_material *material;
    const struct pbnds_bundle *bundle; /* of all its maps; NULL: it has none */
    int member[LANES];                 /* 1: the lane hit this mesh */
    int odd[LANES];                    /* 1: pbnds_scene_surface() is needed */
};

/* What the first half of the work hands to the second, beside the surface. */
struct frame {
    float tangent[3][LANES], bitangent[3][LANES], smooth[3][LANES];
    float lod[LANES];
};

static inline struct pbnds_vec3 lane3(const float (*a)[LANES], int k)
{
    return pbnds_vec3_make(a[0][k], a[1][k], a[2][k]);
}

static inline void put3(float (*a)[LANES], int k, struct pbnds_vec3 v)
{
    a[0][k] = v.x;
    a[1][k] = v.y;
    a[2][k] = v.z;
}

static inline float unit(float x)
{
    return pbnds_clamp(x, 0.0f, 1.0f);
}

/* Is the squared length in the range in which normalising needs no care? */
static inline int plain_square(float square)
{
    return (square > 1e-30f ? 1 : 0) & (square < 1e30f ? 1 : 0);
}

/* Are all maps of the material in one bundle, and can the mesh be looked up in it? */
static inline bool find_bundle(const struct pbnds_scene *scene, struct group *g)
{
    const struct pbnds_material *m = g->material;
    const struct pbnds_texture_ref *const refs[5] = {
        &m->base_color_texture, &m->metallic_roughness_texture, &m->normal_texture,
        &m->emissive_texture, &m->occlusion_texture};
    int bundle = -1;
    for (int map = 0; map < 5; ++map) {
        if (refs[map]->texture < 0) continue;
        if (map == PBNDS_MAP_EMISSIVE && !(pbnds_max3(m->emissive) > 0.0f)) continue;
        if (!scene->maps) return false;
        const int in = scene->maps->materials[g->mesh->material].bundle[map];
        if (in < 0 || (bundle >= 0 && in != bundle)) return false;
        bundle = in;
    }
    if (bundle < 0) return true;
    g->bundle = &scene->maps->bundles[bundle];
    return g->bundle->texcoord == 0 && g->mesh->uv[0] &&
           (g->bundle->first[PBNDS_MAP_NORMAL] < 0 || g->mesh->tangent);
}

static inline bool is_plain(const struct pbnds_scene *scene, struct group *g)
{
    const struct pbnds_material *m = g->material;
    return g->mesh->packed && g->mesh->normal && !g->mesh->color && !m->unlit &&
           !m->specular_glossiness && m->specular_texture.texture < 0 &&
           m->specular_color_texture.texture < 0 && find_bundle(scene, g);
}

static inline void mix4(const float *a, const float *b, const float *c,
                        const float w[3], float *out)
{
    for (int i = 0; i < 4; ++i)
        out[i] = a[i] * w[0] + b[i] * w[1] + c[i] * w[2];
}

static inline void less4(const float *a, const float *b, float *out)
{
    for (int i = 0; i < 4; ++i)
        out[i] = a[i] - b[i];
}

static inline void turn(const float (*rows)[4], float (*columns)[LANES])
{
    for (int k = 0; k < LANES; k += 4)
        pbnds_transpose4(rows[k], 4, &columns[0][k], LANES);
}

/* Lanes of other meshes get the triangle of a member: any numbers do, but sane ones. */
static inline void load_corners(const struct group *g,
                                const struct pbnds_hit_packet *hits, int any,
                                struct corners *c)
{
    const struct pbnds_vertex *vertices = g->mesh->packed;
    _Alignas(64) float p[LANES][4], n[LANES][4], t[LANES][4], e1[LANES][4],
        e2[LANES][4];
    for (int k = 0; k < LANES; ++k) {
        const int from = g->member[k] ? k : any;
        const uint32_t *index = g->mesh->index + 3 * (size_t)hits->triangle[from];
        const struct pbnds_vertex *a = vertices + index[0], *b = vertices + index[1],
                                  *d = vertices + index[2];
        const float u = hits->u[from], v = hits->v[from];
        const float w[3] = {1.0f - u - v, u, v};
        mix4(a->position_u, b->position_u, d->position_u, w, p[k]);
        mix4(a->normal_v, b->normal_v, d->normal_v, w, n[k]);
        mix4(a->tangent, b->tangent, d->tangent, w, t[k]);
        less4(b->position_u, a->position_u, e1[k]);
        less4(d->position_u, a->position_u, e2[k]);
        c->v1[k] = b->normal_v[3] - a->normal_v[3];
        c->v2[k] = d->normal_v[3] - a->normal_v[3];
    }
    turn((const float(*)[4])p, c->p);
    turn((const float(*)[4])n, c->n);
    turn((const float(*)[4])t, c->t);
    turn((const float(*)[4])e1, c->e1);
    turn((const float(*)[4])e2, c->e2);
}

/* Position, face normal, smooth normal. */
static inline void geometry(struct group *g, const struct corners *c,
                            const struct pbnds_ray_packet *rays,
                            const float footprint[LANES],
                            struct pbnds_surface_packet *s, struct frame *f)
{
    const float density = g->bundle ? g->bundle->density : 0.0f;
    for (int k = 0; k < LANES; ++k) {
        const struct pbnds_vec3 wo = pbnds_scale(lane3(rays->direction, k), -1.0f);
        const struct pbnds_vec3 cross = pbnds_cross(lane3(c->e1, k), lane3(c->e2, k));
        const float square = pbnds_dot(cross, cross), area = sqrtf(square);
        const struct pbnds_vec3 face = pbnds_scale(cross, 1.0f / area);
        const float facing = pbnds_dot(face, wo);
        const float side = facing < 0.0f ? -1.0f : 1.0f;
        put3(s->ng, k, pbnds_scale(face, side));

        const struct pbnds_vec3 mixed = lane3(c->n, k);
        const float length2 = pbnds_dot(mixed, mixed);
        put3(f->smooth, k, pbnds_scale(mixed, 1.0f / sqrtf(length2)));
        g->odd[k] = 1 - (plain_square(square) & plain_square(length2));

        const float det = c->e1[3][k] * c->v2[k] - c->e2[3][k] * c->v1[k];
        f->lod[k] =
            pbnds_cone_lod(footprint[k], fabsf(facing), fabsf(det), area, density);
    }
}

/* Tangent and bitangent about the smooth normal. */
static inline void tangents(struct group *g, const struct corners *c, struct frame *f)
{
    const struct frame *in = f;
    for (int k = 0; k < LANES; ++k) {
        const struct pbnds_vec3 n = lane3(in->smooth, k);
        struct pbnds_vec3 t = lane3(c->t, k);
        const float square = pbnds_dot(t, t);
        t = pbnds_scale(t, 1.0f / sqrtf(square));
        t = pbnds_mad(t, n, -pbnds_dot(t, n));
        const float across = pbnds_dot(t, t);
        t = pbnds_scale(t, 1.0f / sqrtf(across));
        put3(f->tangent, k, t);
        put3(f->bitangent, k,
             pbnds_scale(pbnds_cross(n, t), c->t[3][k] < 0.0f ? -1.0f : 1.0f));
        g->odd[k] |= 1 - (plain_square(square) & (across > 1e-12f ? 1 : 0));
    }
}

/* Asks for the rows of texels of all lanes before the first is worked on. */
static inline void fetch_ahead(const struct pbnds_bundle *b,
                               const struct pbnds_taps *taps)
{
    const size_t stride = (size_t)b->channels;
    for (int level = 0; level < 2; ++level) {
        for (int k = 0; k < LANES; ++k) {
            PBNDS_PREFETCH(b->texels + taps->texel[level][0][k] * stride);
            PBNDS_PREFETCH(b->texels + taps->texel[level][2][k] * stride);
        }
    }
}

/* The values of all maps: [channel][lane]. */
static inline void look_up(const struct group *g, const struct pbnds_surface_packet *s,
                           const struct frame *f,
                           float values[PBNDS_BUNDLE_CHANNELS][LANES])
{
    const struct pbnds_bundle *b = g->bundle;
    struct pbnds_lookup at;
    struct pbnds_taps taps;
    _Alignas(64) float gathered[LANES][PBNDS_BUNDLE_CHANNELS];
    memcpy(at.u, s->uv[0], sizeof at.u);
    memcpy(at.v, s->uv[1], sizeof at.v);
    memcpy(at.lod, f->lod, sizeof at.lod);
    pbnds_lookup_taps(b, LANES, &at, &taps);
    fetch_ahead(b, &taps);
    if (b->channels == 8) { /* the common case as a constant */
        for (int k = 0; k < LANES; ++k)
            pbnds_taps_gather(b, &taps, k, 8, gathered[k]);
    } else {
        for (int k = 0; k < LANES; ++k)
            pbnds_taps_gather(b, &taps, k, b->channels, gathered[k]);
    }
    for (int c = 0; c < b->channels; c += 4)
        for (int k = 0; k < LANES; k += 4)
            pbnds_transpose4(&gathered[k][c], PBNDS_BUNDLE_CHANNELS, &values[c][k],
                             LANES);
}

/* The shading normal; `map` is the first channel of the normal map, or NULL. */
static inline void normals(struct group *g, const struct pbnds_ray_packet *rays,
                           const struct frame *f, const float (*map)[LANES],
                           struct pbnds_surface_packet *s)
{
    const float scale = g->material->normal_scale;
    const struct pbnds_surface_packet *in = s;
    for (int k = 0; k < LANES; ++k) {
        const struct pbnds_vec3 wo = pbnds_scale(lane3(rays->direction, k), -1.0f);
        const struct pbnds_vec3 ng = lane3(in->ng, k), smooth = lane3(f->smooth, k);
        struct pbnds_vec3 n = smooth;
        int odd = 0;
        if (map) {
            const float x = (2.0f * map[0][k] - 1.0f) * scale;
            const float y = (2.0f * map[1][k] - 1.0f) * scale;
            const float z = 2.0f * map[2][k] - 1.0f;
            n = pbnds_mad(pbnds_mad(pbnds_scale(lane3(f->tangent, k), x),
                                    lane3(f->bitangent, k), y),
                          smooth, z);
            const float square = pbnds_dot(n, n);
            n = pbnds_scale(n, 1.0f / sqrtf(square));
            odd = 1 - plain_square(square);
        }
        n = pbnds_scale(n, pbnds_dot(smooth, ng) < 0.0f ? -1.0f : 1.0f);
        put3(s->n, k, n);
        const int above = pbnds_dot(n, ng) < 0.0f ? 0 : 1;
        const float cosine = pbnds_dot(n, wo);
        const int facing = cosine > 0.5f * PBNDS_FACING ? 1 : 0;
        /* More than leave_face() asks for: another rounding must not let one through. */
        const float mirror = 2.0f * cosine * pbnds_dot(n, ng) - pbnds_dot(wo, ng);
        const int leaves = mirror > 1.5f * PBNDS_LEAVING ? 1 : 0;
        g->odd[k] |= odd | (1 - (above & facing & leaves));
    }
}

/* What loops write to is local here and then copied: only then are they vector
 * instructions. */
static inline void fill(float value, float *out)
{
    float lanes[LANES];
    for (int k = 0; k < LANES; ++k)
        lanes[k] = value;
    memcpy(out, lanes, sizeof lanes);
}

static inline void fill_ids(uint32_t value, uint32_t *out)
{
    uint32_t lanes[LANES];
    for (int k = 0; k < LANES; ++k)
        lanes[k] = value;
    memcpy(out, lanes, sizeof lanes);
}

/* factor * map, or the factor alone; clamped. */
static inline void factor_times(float factor, const float *map, float *out)
{
    if (!map) {
        fill(unit(factor), out);
        return;
    }
    float lanes[LANES];
    for (int k = 0; k < LANES; ++k)
        lanes[k] = unit(factor * map[k]);
    memcpy(out, lanes, sizeof lanes);
}

/* factor * map for the three channels of a colour, not clamped; or the factor alone. */
static inline void color_times(const float factor[3], float (*map)[LANES],
                               float (*out)[LANES])
{
    float r[LANES], g[LANES], b[LANES];
    for (int k = 0; k < LANES; ++k)
        r[k] = map ? factor[0] * map[0][k] : factor[0];
    for (int k = 0; k < LANES; ++k)
        g[k] = map ? factor[1] * map[1][k] : factor[1];
    for (int k = 0; k < LANES; ++k)
        b[k] = map ? factor[2] * map[2][k] : factor[2];
    memcpy(out[0], r, sizeof r);
    memcpy(out[1], g, sizeof g);
    memcpy(out[2], b, sizeof b);
}

static inline void material(const struct group *g, float (*values)[LANES],
                            struct pbnds_surface_packet *s)
{
    const struct pbnds_material *m = g->material;
    const int none[PBNDS_MAP_COUNT] = {-1, -1, -1, -1, -1, -1, -1};
    const int *first = g->bundle ? g->bundle->first : none;
    const float emissive[3] = {m->emissive.x, m->emissive.y, m->emissive.z};
    const struct pbnds_vec3 color = m->specular_color;
    const int base = first[PBNDS_MAP_BASE_COLOR], glow = first[PBNDS_MAP_EMISSIVE];
    const int mr = first[PBNDS_MAP_METALLIC_ROUGHNESS];
    const int ao = first[PBNDS_MAP_OCCLUSION];
    /* One by one: in a loop over the channels these would not be vector instructions. */
    factor_times(m->base_color.x, base < 0 ? NULL : values[base], s->base_color[0]);
    factor_times(m->base_color.y, base < 0 ? NULL : values[base + 1], s->base_color[1]);
    factor_times(m->base_color.z, base < 0 ? NULL : values[base + 2], s->base_color[2]);
    color_times(emissive, glow < 0 ? NULL : values + glow, s->emission);
    fill(unit(fminf(m->ior_f0 * color.x, 1.0f) * m->specular), s->f0[0]);
    fill(unit(fminf(m->ior_f0 * color.y, 1.0f) * m->specular), s->f0[1]);
    fill(unit(fminf(m->ior_f0 * color.z, 1.0f) * m->specular), s->f0[2]);
    fill(unit(m->specular), s->f90);
    factor_times(m->roughness, mr < 0 ? NULL : values[mr], s->roughness);
    factor_times(m->metallic, mr < 0 ? NULL : values[mr + 1], s->metallic);
    if (m->alpha_mode == PBNDS_ALPHA_OPAQUE)
        fill(1.0f, s->alpha);
    else
        factor_times(m->base_color.w, base < 0 ? NULL : values[base + 3], s->alpha);
    fill(1.0f, s->occlusion);
    for (int k = 0; k < LANES && ao >= 0; ++k)
        s->occlusion[k] = unit(1.0f + m->occlusion_strength * (values[ao][k] - 1.0f));
    fill_ids(g->mesh->object_id, s->object_id);
    fill_ids((uint32_t)g->mesh->material, s->material);
}

/* All that the lanes of one mesh need. */
PBNDS_LANES_CODE
static void shade_group(struct group *g, const struct pbnds_ray_packet *rays,
                        const struct pbnds_hit_packet *hits, int any,
                        const float *footprint, struct pbnds_surface_packet *s)
{
    struct corners c;
    struct frame f;
    float values[PBNDS_BUNDLE_CHANNELS][LANES];
    load_corners(g, hits, any, &c);
    geometry(g, &c, rays, footprint, s, &f);
    for (int i = 0; i < 3; ++i)
        memcpy(s->position[i], c.p[i], sizeof c.p[i]);
    memcpy(s->uv[0], c.p[3], sizeof c.p[3]);
    memcpy(s->uv[1], c.n[3], sizeof c.n[3]);
    const float(*normal_map)[LANES] = NULL;
    if (g->bundle) {
        look_up(g, s, &f, values);
        if (g->bundle->first[PBNDS_MAP_NORMAL] >= 0) {
            normal_map =
                (const float(*)[LANES])(values + g->bundle->first[PBNDS_MAP_NORMAL]);
            tangents(g, &c, &f);
        }
    }
    normals(g, rays, &f, normal_map, s);
    material(g, values, s);
}

static void put_lane(const struct pbnds_surface *from, int k,
                     struct pbnds_surface_packet *s)
{
    put3(s->position, k, from->position);
    put3(s->ng, k, from->ng);
    put3(s->n, k, from->n);
    put3(s->base_color, k, from->base_color);
    put3(s->emission, k, from->emission);
    put3(s->f0, k, from->f0);
    s->f90[k] = from->f90;
    s->metallic[k] = from->metallic;
    s->roughness[k] = from->roughness;
    s->alpha[k] = from->alpha;
    s->occlusion[k] = from->occlusion;
    s->uv[0][k] = from->uv.x;
    s->uv[1][k] = from->uv.y;
    s->object_id[k] = from->object_id;
    s->material[k] = (uint32_t)from->material;
}

static void shade_lane(const struct pbnds_scene *scene,
                       const struct pbnds_ray_packet *rays,
                       const struct pbnds_hit_packet *hits, int k, float footprint,
                       struct pbnds_surface_packet *s)
{
    const struct pbnds_hit hit = {hits->t[k], hits->u[k], hits->v[k], hits->mesh[k],
                                  hits->triangle[k]};
    struct pbnds_surface surface;
    pbnds_scene_surface(scene, &hit, pbnds_scale(lane3(rays->direction, k), -1.0f),
                        footprint, &surface);
    put_lane(&surface, k, s);
}

/* The lanes of g from one packet into another; both are arrays of 4-byte values. */
static void merge(const struct group *g, const struct pbnds_surface_packet *from,
                  struct pbnds_surface_packet *to)
{
    enum { ARRAYS = sizeof *from / (LANES * sizeof(float)) };
    uint32_t a[ARRAYS][LANES], b[ARRAYS][LANES];
    _Static_assert(sizeof a == sizeof *from, "a packet is arrays of lanes");
    memcpy(a, from, sizeof a);
    memcpy(b, to, sizeof b);
    for (int i = 0; i < ARRAYS; ++i)
        for (int k = 0; k < LANES; ++k)
            b[i][k] = g->member[k] ? a[i][k] : b[i][k];
    memcpy(to, b, sizeof b);
}

/* Have all lanes hit one mesh? */
PBNDS_LANES_CODE
static bool is_whole(const struct pbnds_hit_packet *hits)
{
    uint32_t differ = 0;
    for (int k = 0; k < LANES; ++k)
        differ |= hits->mesh[k] ^ hits->mesh[0];
    return differ == 0 && hits->mesh[0] != UINT32_MAX;
}

/* The lanes of a group that need it, or all of them, by pbnds_scene_surface(). */
static void shade_odd(const struct pbnds_scene *scene,
                      const struct pbnds_ray_packet *rays,
                      const struct pbnds_hit_packet *hits, const struct group *g,
                      bool plain, const float *footprint,
                      struct pbnds_surface_packet *surface)
{
    for (int k = 0; k < LANES; ++k)
        if (g->member[k] && (!plain || g->odd[k]))
            shade_lane(scene, rays, hits, k, footprint[k], surface);
}

static bool any_of(const int flags[LANES])
{
    int any = 0;
    for (int k = 0; k < LANES; ++k)
        any |= flags[k];
    return any != 0;
}

/* The common case: no lanes to choose. @return false: it is not that */
static bool shade_whole(const struct pbnds_scene *scene,
                        const struct pbnds_ray_packet *rays,
                        const struct pbnds_hit_packet *hits, const float *footprint,
                        struct pbnds_surface_packet *surface)
{
    if (!is_whole(hits)) return false;
    struct group g;
    g.mesh = &scene->meshes[hits->mesh[0]];
    g.material = &scene->materials[g.mesh->material];
    g.bundle = NULL;
    if (!is_plain(scene, &g)) return false;
    for (int k = 0; k < LANES; ++k)
        g.member[k] = 1;
    shade_group(&g, rays, hits, 0, footprint, surface);
    if (any_of(g.odd)) shade_odd(scene, rays, hits, &g, true, footprint, surface);
    return true;
}

void pbnds_scene_surface_packet(const struct pbnds_scene *scene,
                                const struct pbnds_ray_packet *rays,
                                const struct pbnds_hit_packet *hits,
                                const float footprint[PBNDS_PACKET],
                                struct pbnds_surface_packet *surface)
{
    if (shade_whole(scene, rays, hits, footprint, surface)) return;
    int todo[LANES], left = 0;
    for (int k = 0; k < LANES; ++k) {
        todo[k] = hits->mesh[k] != UINT32_MAX;
        left += todo[k];
    }
    const bool full = left == LANES;
    if (!full) memset(surface, 0, sizeof *surface);
    for (int first = 0; left > 0; ++first) {
        if (!todo[first]) continue;
        struct group g = {.mesh = &scene->meshes[hits->mesh[first]]};
        g.material = &scene->materials[g.mesh->material];
        int count = 0;
        for (int k = 0; k < LANES; ++k) {
            g.member[k] = todo[k] & (hits->mesh[k] == hits->mesh[first]);
            todo[k] -= g.member[k];
            count += g.member[k];
        }
        left -= count;
        const bool plain = is_plain(scene, &g);
        if (plain) {
            struct pbnds_surface_packet part;
            shade_group(&g, rays, hits, first, footprint, &part);
            merge(&g, &part, surface);
        }
        shade_odd(scene, rays, hits, &g, plain, footprint, surface);
    }
}
