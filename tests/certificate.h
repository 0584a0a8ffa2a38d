/* How far apart the primitives of different bodies are at least, checked without the solver: for
   every pair the separation along a direction is a lower bound of the distance, whatever the
   direction is. Directions tried: the reported contact normals (turned into a half-space's own normal
   where there is one) and the line of the centres. Returns the least bound over all pairs that have a
   dynamic body; it is negative only if no tried direction separates a pair. */

static void certificate_farthest(const ecp_shape *s, const ecp_real x[3], const ecp_real Q[9],
                                 const double n[3], double out[3])
{
    ecp_real local[3], at[3];
    int i, k;
    for (k = 0; k < 3; k++) {
        local[k] =
            (ecp_real)((double)Q[k] * n[0] + (double)Q[3 + k] * n[1] + (double)Q[6 + k] * n[2]);
    }
    s->cls->support(s, local, 0, at);
    for (i = 0; i < 3; i++) {
        out[i] = (double)x[i];
        for (k = 0; k < 3; k++) out[i] += (double)Q[3 * i + k] * (double)at[k];
    }
}

static double certificate_along(const ecp_world *w, int i, int j, const double n[3])
{
    const ecp_shape *A, *B;
    ecp_real xa[3], xb[3], Qa[9], Qb[9];
    double pa[3], pb[3], back[3], gap = 0, size;
    int k;
    ecp_shape_get(w, i, &A, NULL, xa, Qa);
    ecp_shape_get(w, j, &B, NULL, xb, Qb);
    size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(size > 0)) return -1e300;
    for (k = 0; k < 3; k++) back[k] = -n[k] / size;
    {
        double unit[3];
        for (k = 0; k < 3; k++) unit[k] = n[k] / size;
        certificate_farthest(A, xa, Qa, unit, pa);
        if (B->kind == ECP_HALF_SPACE) {
            /* only its own outward normal bounds a half-space */
            double N[3], along = 0;
            int r;
            for (k = 0; k < 3; k++) {
                for (r = 0, N[k] = 0; r < 3; r++)
                    N[k] += (double)Qb[3 * k + r] * (double)B->size[r];
            }
            for (k = 0; k < 3; k++) back[k] = -N[k];
            certificate_farthest(A, xa, Qa, back, pa);
            for (k = 0; k < 3; k++) along += N[k] * (pa[k] - (double)xb[k]);
            return along - (double)B->size[3];
        }
        certificate_farthest(B, xb, Qb, back, pb);
        for (k = 0; k < 3; k++) gap += unit[k] * (pb[k] - pa[k]);
    }
    return gap;
}

static double certificate_pair(const ecp_world *w, int i, int j)
{
    const ecp_shape *A, *B;
    ecp_real xa[3], xb[3], Qa[9], Qb[9];
    double n[3], best;
    int k, r, c;
    ecp_shape_get(w, i, &A, NULL, xa, Qa);
    ecp_shape_get(w, j, &B, NULL, xb, Qb);
    if (A->kind == ECP_HALF_SPACE) return certificate_pair(w, j, i);
    for (k = 0; k < 3; k++) {
        n[k] = (double)xb[k] - (double)xa[k];
        for (r = 0; r < 3; r++) {
            n[k] += (double)Qb[3 * k + r] * (double)B->centre[r];
            n[k] -= (double)Qa[3 * k + r] * (double)A->centre[r];
        }
    }
    best = certificate_along(w, i, j, n);
    for (c = 0; c < ecp_contact_count(w); c++) {
        ecp_contact contact;
        double sign;
        if (ecp_contact_get(w, c, &contact) != ECP_OK) continue;
        if (!((contact.shape_a == i && contact.shape_b == j) ||
              (contact.shape_a == j && contact.shape_b == i))) {
            continue;
        }
        sign = contact.shape_a == i ? -1 : 1;
        for (k = 0; k < 3; k++) n[k] = sign * (double)contact.normal[k];
        if (certificate_along(w, i, j, n) > best) best = certificate_along(w, i, j, n);
    }
    return best;
}

static double certificate(const ecp_world *w)
{
    double least = 1e300;
    int i, j, body_i = 0, body_j = 0;
    for (i = 0; i < ecp_world_shape_count(w); i++) {
        for (j = i + 1; j < ecp_world_shape_count(w); j++) {
            const ecp_shape *a = NULL, *b = NULL;
            ecp_shape_get(w, i, &a, &body_i, NULL, NULL);
            ecp_shape_get(w, j, &b, &body_j, NULL, NULL);
            if (body_i == body_j || (a->kind == ECP_HALF_SPACE && b->kind == ECP_HALF_SPACE))
                continue;
            if (certificate_pair(w, i, j) < least) least = certificate_pair(w, i, j);
        }
    }
    return least;
}
