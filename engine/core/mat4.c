#include "engine/core/mat4.h"

struct pbnds_mat4 pbnds_mat4_identity(void)
{
    return (struct pbnds_mat4){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
}

struct pbnds_mat4 pbnds_mat4_mul(const struct pbnds_mat4 *a, const struct pbnds_mat4 *b)
{
    struct pbnds_mat4 out;
    for (int c = 0; c < 4; ++c) {
        for (int r = 0; r < 4; ++r) {
            float sum = 0.0f;
            for (int k = 0; k < 4; ++k) sum += a->m[4 * k + r] * b->m[4 * c + k];
            out.m[4 * c + r] = sum;
        }
    }
    return out;
}

struct pbnds_mat4 pbnds_mat4_from_trs(struct pbnds_vec3 t, struct pbnds_vec4 q,
                                      struct pbnds_vec3 s)
{
    const float xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
    const float xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
    const float wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    return (struct pbnds_mat4){{
        s.x * (1 - 2 * (yy + zz)), s.x * 2 * (xy + wz), s.x * 2 * (xz - wy), 0,
        s.y * 2 * (xy - wz), s.y * (1 - 2 * (xx + zz)), s.y * 2 * (yz + wx), 0,
        s.z * 2 * (xz + wy), s.z * 2 * (yz - wx), s.z * (1 - 2 * (xx + yy)), 0,
        t.x, t.y, t.z, 1,
    }};
}

struct pbnds_mat4 pbnds_mat4_look_at(struct pbnds_vec3 eye, struct pbnds_vec3 target,
                                     struct pbnds_vec3 up)
{
    const struct pbnds_vec3 z = pbnds_normalize(pbnds_sub(eye, target));
    struct pbnds_vec3 x = pbnds_cross(up, z);
    if (pbnds_dot(x, x) < 1e-8f) x = pbnds_cross(pbnds_vec3_make(0, 0, 1), z);
    if (pbnds_dot(x, x) < 1e-8f) x = pbnds_vec3_make(1, 0, 0);
    x = pbnds_normalize(x);
    const struct pbnds_vec3 y = pbnds_cross(z, x);
    return (struct pbnds_mat4){{x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0,
                                eye.x, eye.y, eye.z, 1}};
}

bool pbnds_mat4_inverse(const struct pbnds_mat4 *a, struct pbnds_mat4 *out)
{
    /* Gauss-Jordan with partial pivoting, in double: the matrices are few. */
    double w[4][8];
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) {
            w[r][c] = (double)a->m[4 * c + r];
            w[r][c + 4] = r == c ? 1.0 : 0.0;
        }
    }
    for (int c = 0; c < 4; ++c) {
        int pivot = c;
        for (int r = c + 1; r < 4; ++r) {
            if (fabs(w[r][c]) > fabs(w[pivot][c])) pivot = r;
        }
        if (!(fabs(w[pivot][c]) > 1e-30)) return false;
        for (int k = 0; k < 8; ++k) {
            const double swap = w[c][k];
            w[c][k] = w[pivot][k];
            w[pivot][k] = swap;
        }
        const double scale = 1.0 / w[c][c];
        for (int k = 0; k < 8; ++k) w[c][k] *= scale;
        for (int r = 0; r < 4; ++r) {
            if (r == c) continue;
            const double factor = w[r][c];
            for (int k = 0; k < 8; ++k) w[r][k] -= factor * w[c][k];
        }
    }
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 4; ++c) out->m[4 * c + r] = (float)w[r][c + 4];
    }
    return true;
}

float pbnds_mat4_det3(const struct pbnds_mat4 *a)
{
    const float *m = a->m;
    return m[0] * (m[5] * m[10] - m[9] * m[6]) - m[4] * (m[1] * m[10] - m[9] * m[2]) +
           m[8] * (m[1] * m[6] - m[5] * m[2]);
}

struct pbnds_vec3 pbnds_mat4_point(const struct pbnds_mat4 *a, struct pbnds_vec3 p)
{
    const float *m = a->m;
    return pbnds_vec3_make(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
                           m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
                           m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]);
}

struct pbnds_vec3 pbnds_mat4_vector(const struct pbnds_mat4 *a, struct pbnds_vec3 v)
{
    const float *m = a->m;
    return pbnds_vec3_make(m[0] * v.x + m[4] * v.y + m[8] * v.z,
                           m[1] * v.x + m[5] * v.y + m[9] * v.z,
                           m[2] * v.x + m[6] * v.y + m[10] * v.z);
}

struct pbnds_vec3 pbnds_mat4_normal(const struct pbnds_mat4 *a, struct pbnds_vec3 n)
{
    const float *m = a->m;
    const struct pbnds_vec3 c0 = {m[0], m[1], m[2]}, c1 = {m[4], m[5], m[6]},
                            c2 = {m[8], m[9], m[10]};
    return pbnds_add(pbnds_scale(pbnds_cross(c1, c2), n.x),
                     pbnds_add(pbnds_scale(pbnds_cross(c2, c0), n.y),
                               pbnds_scale(pbnds_cross(c0, c1), n.z)));
}
