#include "engine/scene/gltf/load.h"

struct pbnds_mat4 pbnds_gltf_rigid(const struct pbnds_mat4 *m)
{
    struct pbnds_mat4 out = pbnds_mat4_identity();
    struct pbnds_vec3 z = {m->m[8], m->m[9], m->m[10]}, y = {m->m[4], m->m[5], m->m[6]};
    if (pbnds_length(z) > 0.0f)
        z = pbnds_normalize(z);
    else
        z = pbnds_vec3_make(0, 0, 1);
    y = pbnds_mad(y, z, -pbnds_dot(y, z));
    if (pbnds_length(y) > 0.0f)
        y = pbnds_normalize(y);
    else
        y = pbnds_frame_from_normal(z).b;
    const struct pbnds_vec3 x = pbnds_cross(y, z);
    const struct pbnds_vec3 columns[3] = {x, y, z};
    for (int c = 0; c < 3; ++c) {
        out.m[4 * c] = columns[c].x;
        out.m[4 * c + 1] = columns[c].y;
        out.m[4 * c + 2] = columns[c].z;
        out.m[12 + c] = m->m[12 + c];
    }
    return out;
}

static bool is_finite(const struct pbnds_mat4 *m)
{
    bool finite = true;
    for (int i = 0; i < 16; ++i)
        finite = finite && isfinite(m->m[i]);
    return finite;
}

/** The camera at both times: only its place differs. */
enum pbnds_status pbnds_gltf_add_camera(struct pbnds_gltf_load_state *g, size_t node)
{
    const struct pbnds_gltf_node *n = &g->doc.nodes[node];
    const struct pbnds_gltf_camera *source = &g->doc.cameras[n->camera];
    struct pbnds_camera *c = &g->scene->cameras[g->scene->camera_count];
    pbnds_gltf_name(c->name, source->name[0] ? source->name : n->name, "camera",
                    (size_t)g->scene->camera_count);
    c->world_from_camera = pbnds_gltf_rigid(&g->pose[0].world[node]);
    c->orthographic = source->orthographic;
    c->yfov = (float)source->yfov;
    c->ymag = (float)fabs(source->ymag);
    const bool fine = c->orthographic ? c->ymag > 0.0f && isfinite(c->ymag)
                                      : c->yfov > 0.0f && c->yfov < PBNDS_PI;
    bool finite = is_finite(&c->world_from_camera);
    if (g->pose_count == 2) {
        struct pbnds_camera *before =
            &g->scene->previous_cameras[g->scene->camera_count];
        *before = *c;
        before->world_from_camera = pbnds_gltf_rigid(&g->pose[1].world[node]);
        finite = finite && is_finite(&before->world_from_camera);
    }
    if (!fine || !finite) {
        return pbnds_fail(g->error, PBNDS_ERROR_FORMAT,
                          "%s: the camera of node %zu has no valid %s", g->name, node,
                          !finite ? "place" : (c->orthographic ? "ymag" : "yfov"));
    }
    ++g->scene->camera_count;
    return PBNDS_OK;
}
