#include <stdlib.h>
#include <string.h>

#include "engine/scene/gltf/load.h"

/* glTF 2.0, section 3.11 and appendix C. Before its first key and after its last a
 * sampler holds their values. Only the keys around the time are read, so that many
 * channels on a long accessor cost little. */

/** The keys around a time: key k and the next, t = (time - t_k) / dt of the way. */
struct keys {
    uint64_t k;
    double t, dt;
    bool exact; /* the value is that of key k */
};

static const char *animation_name(const struct pbnds_gltf_document *d, size_t i)
{
    return d->animations[i].name;
}

static enum pbnds_status map_weights(struct pbnds_gltf_load_state *g)
{
    const size_t nodes = g->doc.node_count;
    g->weights_channel = malloc((nodes + 1) * sizeof *g->weights_channel);
    if (!g->weights_channel) {
        return pbnds_fail(g->error, PBNDS_ERROR_MEMORY, "%s: no memory for nodes",
                          g->name);
    }
    for (size_t i = 0; i < nodes; ++i)
        g->weights_channel[i] = -1;
    for (size_t i = 0; i < g->animation->channel_count; ++i) {
        const struct pbnds_gltf_channel *c = &g->animation->channels[i];
        if (c->path == PBNDS_GLTF_WEIGHTS && c->node >= 0)
            g->weights_channel[c->node] = (int64_t)i;
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_choose_animation(struct pbnds_gltf_load_state *g)
{
    const struct pbnds_gltf_options *o = g->options;
    size_t chosen = 0;
    if (o->animation) {
        PBNDS_TRY(pbnds_gltf_choose(g, o->animation, "animation",
                                    g->doc.animation_count, animation_name, &chosen));
    }
    g->pose_count = o->posed && o->motion ? 2 : 1;
    g->pose[0].time = o->time;
    g->pose[1].time = o->earlier;
    if (!o->posed) return PBNDS_OK;
    if (g->doc.animation_count == 0) {
        pbnds_warn(g->report, "%s: has no animation, it is the same at every time",
                   g->name);
        return PBNDS_OK;
    }
    g->animation = &g->doc.animations[chosen];
    return map_weights(g);
}

static enum pbnds_status time_of(struct pbnds_gltf_load_state *g,
                                 const struct pbnds_gltf_accessor *input, uint64_t key,
                                 double *time)
{
    float value = 0.0f;
    PBNDS_TRY(
        pbnds_gltf_read_some(g, input, "the input of an animation", key, 1, &value));
    *time = (double)value;
    return PBNDS_OK;
}

static enum pbnds_status input_of(struct pbnds_gltf_load_state *g,
                                  const struct pbnds_gltf_animation_sampler *s,
                                  const struct pbnds_gltf_accessor **input)
{
    PBNDS_TRY(
        pbnds_gltf_accessor_at(g, s->input, 1, "the input of an animation", input));
    if ((*input)->count > 0 && (*input)->component == PBNDS_GLTF_FLOAT) return PBNDS_OK;
    return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                      "%s: the input of an animation has no keys, or is not of floats",
                      g->name);
}

/** The last key that is not after `time`, by halving. */
static enum pbnds_status find_keys(struct pbnds_gltf_load_state *g,
                                   const struct pbnds_gltf_accessor *input, double time,
                                   struct keys *keys)
{
    uint64_t low = 0, high = input->count; /* key `low` or an earlier one is it */
    double before = 0.0, after = 0.0;
    *keys = (struct keys){.exact = true};
    PBNDS_TRY(time_of(g, input, 0, &before));
    while (high - low > 1) {
        const uint64_t middle = low + (high - low) / 2;
        double at = 0.0;
        PBNDS_TRY(time_of(g, input, middle, &at));
        if (at <= time) {
            low = middle;
            before = at;
        } else {
            high = middle;
            after = at;
        }
    }
    keys->k = low;
    if (high == input->count || !(after > before)) return PBNDS_OK;
    keys->dt = after - before;
    keys->t = (time - before) / keys->dt;
    keys->exact = keys->t <= 0.0;
    return PBNDS_OK;
}

/** Unit quaternions on the shorter arc (appendix C.3); nearly equal ones are mixed. */
static void slerp(const float *a, const float *b, double t, double *out)
{
    double cosine = 0.0;
    for (int i = 0; i < 4; ++i)
        cosine += (double)a[i] * (double)b[i];
    const double sign = cosine < 0.0 ? -1.0 : 1.0;
    const double angle = acos(fmin(fabs(cosine), 1.0));
    double wa = 1.0 - t, wb = t;
    if (angle > 1e-4) {
        wa = sin((1.0 - t) * angle) / sin(angle);
        wb = sin(t * angle) / sin(angle);
    }
    for (int i = 0; i < 4; ++i)
        out[i] = wa * (double)a[i] + sign * wb * (double)b[i];
}

/** Cubic Hermite spline (appendix C.5): p are in-tangent, value, out-tangent of key k,
 *  then of the next; tangents are per second. */
static double hermite(const double p[6], const struct keys *k)
{
    const double t = k->t, t2 = t * t, t3 = t2 * t;
    return (2.0 * t3 - 3.0 * t2 + 1.0) * p[1] + k->dt * (t3 - 2.0 * t2 + t) * p[2] +
           (3.0 * t2 - 2.0 * t3) * p[4] + k->dt * (t3 - t2) * p[3];
}

static const struct pbnds_gltf_animation_sampler *
sampler_of(const struct pbnds_gltf_load_state *g, int64_t channel)
{
    return &g->animation->samplers[g->animation->channels[channel].sampler];
}

/** What a sampler has around a time. `width` components an element, `elements` of them
 *  a key: weights have one element for each target. */
struct output {
    const struct pbnds_gltf_accessor *accessor;
    enum pbnds_gltf_interpolation interpolation;
    struct keys keys;
    uint64_t elements;
};

static enum pbnds_status open_output(struct pbnds_gltf_load_state *g,
                                     const struct pbnds_gltf_animation_sampler *s,
                                     int width, uint64_t elements, double time,
                                     struct output *out)
{
    static const char what[] = "the output of an animation";
    const struct pbnds_gltf_accessor *input = NULL;
    PBNDS_TRY(input_of(g, s, &input));
    PBNDS_TRY(pbnds_gltf_accessor_at(g, s->output, width, what, &out->accessor));
    PBNDS_TRY(find_keys(g, input, time, &out->keys));
    out->interpolation = s->interpolation;
    out->elements = elements;
    const uint64_t parts = s->interpolation == PBNDS_GLTF_CUBICSPLINE ? 3 : 1;
    /* A count is below 2^31, targets take bytes of the JSON: below 2^28. No overflow. */
    if (input->count * parts * elements <= out->accessor->count) return PBNDS_OK;
    return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                      "%s: %s has %llu values for %llu keys", g->name, what,
                      (unsigned long long)out->accessor->count,
                      (unsigned long long)input->count);
}

/** Element `e` of the keys around the time, interpolated; rotations not yet unit. */
static enum pbnds_status evaluate(struct pbnds_gltf_load_state *g,
                                  const struct output *o, uint64_t e, bool rotation,
                                  double *out)
{
    const uint64_t n = o->elements, k = o->keys.k;
    const size_t width = (size_t)o->accessor->width;
    const bool cubic = o->interpolation == PBNDS_GLTF_CUBICSPLINE;
    const bool alone = o->keys.exact || o->interpolation == PBNDS_GLTF_STEP;
    float value[6][4] = {{0}};
    const int parts = cubic ? 6 : 2;
    for (int i = 0; i < parts; ++i) {
        /* Two parts are key k and the next; of six, the middle one of three is it. */
        if (alone && i != (cubic ? 1 : 0)) continue;
        PBNDS_TRY(pbnds_gltf_read_some(g, o->accessor, "the output of an animation",
                                       (k * (cubic ? 3 : 1) + (uint64_t)i) * n + e, 1,
                                       value[i]));
    }
    if (!alone && !cubic && rotation) {
        slerp(value[0], value[1], o->keys.t, out);
        return PBNDS_OK;
    }
    for (size_t c = 0; c < width; ++c) {
        double p[6];
        for (int i = 0; i < 6; ++i)
            p[i] = (double)value[i][c];
        if (alone)
            out[c] = cubic ? p[1] : p[0];
        else
            out[c] = cubic ? hermite(p, &o->keys) : p[0] + o->keys.t * (p[1] - p[0]);
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_animate(struct pbnds_gltf_load_state *g, double time,
                                     struct pbnds_gltf_trs *nodes)
{
    for (size_t i = 0; i < g->animation->channel_count; ++i) {
        const struct pbnds_gltf_channel *c = &g->animation->channels[i];
        if (c->node < 0 || c->path >= PBNDS_GLTF_WEIGHTS) continue;
        struct pbnds_gltf_trs *n = &nodes[c->node];
        if (n->matrix) { /* section 3.11: such a node must not be animated */
            g->matrix_animated = true;
            continue;
        }
        const bool rotation = c->path == PBNDS_GLTF_ROTATION;
        double *target =
            rotation ? n->rotation
                     : (c->path == PBNDS_GLTF_SCALE ? n->scale : n->translation);
        struct output o;
        PBNDS_TRY(
            open_output(g, sampler_of(g, (int64_t)i), rotation ? 4 : 3, 1, time, &o));
        PBNDS_TRY(evaluate(g, &o, 0, rotation, target));
    }
    return PBNDS_OK;
}

static enum pbnds_status animated_weights(struct pbnds_gltf_load_state *g,
                                          int64_t channel, double time, size_t count,
                                          float *weights)
{
    struct output o;
    PBNDS_TRY(open_output(g, sampler_of(g, channel), 1, count, time, &o));
    for (size_t i = 0; i < count; ++i) {
        double value = 0.0;
        PBNDS_TRY(evaluate(g, &o, i, false, &value));
        weights[i] = (float)value;
    }
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_morph_weights(struct pbnds_gltf_load_state *g,
                                           const struct pbnds_gltf_pose *pose,
                                           size_t node, size_t count, float *weights)
{
    const struct pbnds_gltf_node *n = &g->doc.nodes[node];
    const struct pbnds_gltf_mesh *mesh = &g->doc.meshes[n->mesh];
    const int64_t channel = g->weights_channel ? g->weights_channel[node] : -1;
    if (channel >= 0) return animated_weights(g, channel, pose->time, count, weights);
    const double *from = n->weight_count ? n->weights : mesh->weights;
    const size_t known = n->weight_count ? n->weight_count : mesh->weight_count;
    for (size_t i = 0; i < count; ++i)
        weights[i] = i < known ? (float)from[i] : 0.0f;
    return PBNDS_OK;
}

enum pbnds_status pbnds_gltf_animation_end(struct pbnds_gltf_load_state *g,
                                           const struct pbnds_gltf_animation *animation,
                                           double *seconds)
{
    *seconds = 0.0;
    for (size_t i = 0; i < animation->channel_count; ++i) {
        const struct pbnds_gltf_accessor *input = NULL;
        double last = 0.0;
        PBNDS_TRY(
            input_of(g, &animation->samplers[animation->channels[i].sampler], &input));
        PBNDS_TRY(time_of(g, input, input->count - 1, &last));
        *seconds = fmax(*seconds, last);
    }
    return PBNDS_OK;
}
