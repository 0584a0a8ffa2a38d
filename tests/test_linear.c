/* Dense linear algebra and rotations. Each factorisation is multiplied back, and each solution is
   put into the condition that defines it, in double arithmetic written out here.

   Tolerances are multiples of `linear_eps`, the rounding unit: the factor is of the order of the
   number of operations on a path through the algorithm, for matrices with entries in [-1, 1]. */
#include "test.h"

enum { LINEAR_MAX = 16 };

static double linear_eps(double factor) { return factor * (double)ECP_I_EPSILON; }

static void linear_random(int count, ecp_real *x)
{
    int i;
    for (i = 0; i < count; i++) x[i] = ECP_R(test_random());
}

static void linear_random_unit(int count, ecp_real *x)
{
    double sum = 0;
    int i;
    linear_random(count, x);
    for (i = 0; i < count; i++) sum += (double)x[i] * (double)x[i];
    for (i = 0; i < count; i++) x[i] = (ecp_real)((double)x[i] / sqrt(sum));
}

/* a random m x n matrix of the given rank with singular values near one: a sum of `rank` products
   u v^T of orthonormal u and v (Gram-Schmidt, twice, in double). V receives the v, rank rows. */
static void linear_orthonormal(int rank, int n, double *V)
{
    int i, j, k, sweep;
    for (i = 0; i < rank; i++) {
        double size = 0;
        for (j = 0; j < n; j++) V[i * n + j] = test_random();
        for (sweep = 0; sweep < 2; sweep++) {
            for (k = 0; k < i; k++) {
                double dot = 0;
                for (j = 0; j < n; j++) dot += V[i * n + j] * V[k * n + j];
                for (j = 0; j < n; j++) V[i * n + j] -= dot * V[k * n + j];
            }
        }
        for (j = 0; j < n; j++) size += V[i * n + j] * V[i * n + j];
        for (j = 0; j < n; j++) V[i * n + j] /= sqrt(size);
    }
}

static void linear_of_rank(int m, int n, int rank, ecp_real *A, int ld, double *V)
{
    double U[LINEAR_MAX * LINEAR_MAX];
    int i, j, k;
    linear_orthonormal(rank, m, U);
    linear_orthonormal(rank, n, V);
    for (i = 0; i < m; i++) {
        for (j = 0; j < n; j++) {
            double sum = 0;
            for (k = 0; k < rank; k++) sum += (1 + k % 3) * U[k * m + i] * V[k * n + j];
            A[i * ld + j] = (ecp_real)sum;
        }
    }
}

/* max |(A x - b)_i| */
static double linear_residual(int m, int n, const ecp_real *A, int ld, const ecp_real *x,
                              const ecp_real *b)
{
    double worst = 0;
    int i, j;
    for (i = 0; i < m; i++) {
        double sum = -(double)b[i];
        for (j = 0; j < n; j++) sum += (double)A[i * ld + j] * (double)x[j];
        if (fabs(sum) > worst) worst = fabs(sum);
    }
    return worst;
}

static double linear_largest(int count, const ecp_real *x)
{
    double worst = 0;
    int i;
    for (i = 0; i < count; i++) {
        if (fabs((double)x[i]) > worst) worst = fabs((double)x[i]);
    }
    return worst;
}

/* ---- vectors and 3 x 3 matrices */

static void linear_test_vectors(void)
{
    int round, k;
    for (round = 0; round < 20; round++) {
        ecp_real a[3], b[3], c[3], cross[3], other[3], A[9], B[9], AB[9], x[3], y[3], z[3];
        double triple, det;
        linear_random(3, a);
        linear_random(3, b);
        linear_random(3, c);
        linear_random(9, A);
        linear_random(9, B);
        ecp_i_cross(a, b, cross);
        CHECK_NEAR(ecp_i_dot(cross, a), 0, linear_eps(8));
        CHECK_NEAR(ecp_i_dot(cross, b), 0, linear_eps(8));
        /* a x (b x c) = b (a.c) - c (a.b) */
        ecp_i_cross(b, c, cross);
        ecp_i_cross(a, cross, x);
        for (k = 0; k < 3; k++) {
            double want = (double)b[k] * (double)ecp_i_dot(a, c);
            want -= (double)c[k] * (double)ecp_i_dot(a, b);
            CHECK_NEAR(x[k], want, linear_eps(32));
        }
        /* (a x b).c is the determinant of the rows */
        ecp_i_cross(a, b, cross);
        triple = (double)ecp_i_dot(cross, c);
        det = (double)a[0] * ((double)b[1] * (double)c[2] - (double)b[2] * (double)c[1]) -
              (double)a[1] * ((double)b[0] * (double)c[2] - (double)b[2] * (double)c[0]) +
              (double)a[2] * ((double)b[0] * (double)c[1] - (double)b[1] * (double)c[0]);
        CHECK_NEAR(triple, det, linear_eps(32));
        ecp_i_copy3(c, other);
        ecp_i_add_cross(a, b, other);
        for (k = 0; k < 3; k++)
            CHECK_NEAR(other[k], (double)c[k] + (double)cross[k], linear_eps(4));

        /* (A B) x = A (B x);  y.(A x) = (A^T y).x;  (A B A^T) x = A (B (A^T x)) */
        ecp_i_matmul(A, B, AB);
        ecp_i_mul(AB, a, x);
        ecp_i_mul(B, a, y);
        ecp_i_mul(A, y, z);
        for (k = 0; k < 3; k++) CHECK_NEAR(x[k], z[k], linear_eps(64));
        ecp_i_mul(A, a, x);
        ecp_i_mul_t(A, b, y);
        CHECK_NEAR(ecp_i_dot(b, x), ecp_i_dot(y, a), linear_eps(64));
        ecp_i_congruence(A, B, AB);
        ecp_i_mul(AB, a, x);
        ecp_i_mul_t(A, a, y);
        ecp_i_mul(B, y, z);
        ecp_i_mul(A, z, y);
        for (k = 0; k < 3; k++) CHECK_NEAR(x[k], y[k], linear_eps(128));

        ecp_i_copy3(a, x);
        CHECK(ecp_i_normalise(x));
        CHECK_NEAR(ecp_i_norm(x), 1, linear_eps(4));
        CHECK_NEAR(ecp_i_dot(x, a), ecp_i_norm(a), linear_eps(8));
    }
    {
        ecp_real zero[3] = {0, 0, 0};
        CHECK(!ecp_i_normalise(zero));
        CHECK(zero[0] == 0 && zero[1] == 0 && zero[2] == 0);
    }
}

/* ---- rotations */

/* w first: a quarter turn about z takes x to y, about x takes y to z, about y takes z to x */
static void linear_test_quaternion_order(void)
{
    ecp_real half = ECP_R(sqrt(0.5));
    int axis, k;
    for (axis = 0; axis < 3; axis++) {
        ecp_real q[4] = {0, 0, 0, 0}, R[9], from[3] = {0, 0, 0}, to[3];
        q[0] = half;
        q[1 + axis] = half;
        ecp_quat_to_matrix(q, R);
        from[(axis + 1) % 3] = 1;
        ecp_i_mul(R, from, to);
        for (k = 0; k < 3; k++) CHECK_NEAR(to[k], k == (axis + 2) % 3, linear_eps(4));
        from[(axis + 1) % 3] = 0;
        from[axis] = 1;
        ecp_i_mul(R, from, to);
        for (k = 0; k < 3; k++) CHECK_NEAR(to[k], k == axis, linear_eps(4));
    }
    {
        ecp_real q[4] = {1, 0, 0, 0}, R[9];
        ecp_quat_to_matrix(q, R);
        for (k = 0; k < 9; k++) CHECK(R[k] == (k % 4 == 0 ? 1 : 0));
    }
}

static void linear_test_quaternions(void)
{
    int round, i, j, k;
    linear_test_quaternion_order();
    for (round = 0; round < 20; round++) {
        ecp_real a[4], b[4], ab[4], A[9], B[9], AB[9], M[9];
        linear_random_unit(4, a);
        linear_random_unit(4, b);
        ecp_quat_to_matrix(a, A);
        ecp_quat_to_matrix(b, B);
        /* R R^T = I, det R = 1 */
        for (i = 0; i < 3; i++) {
            for (j = 0; j < 3; j++) {
                CHECK_NEAR(ecp_i_dot(A + 3 * i, A + 3 * j), i == j, linear_eps(32));
            }
        }
        ecp_i_cross(A, A + 3, M);
        CHECK_NEAR(ecp_i_dot(M, A + 6), 1, linear_eps(32));
        /* first b, then a, is R(a) R(b) */
        ecp_quat_multiply(a, b, ab);
        ecp_quat_to_matrix(ab, AB);
        ecp_i_matmul(A, B, M);
        for (k = 0; k < 9; k++) CHECK_NEAR(AB[k], M[k], linear_eps(64));
        /* out may be a or b */
        {
            ecp_real in_a[4], in_b[4];
            memcpy(in_a, a, sizeof a);
            memcpy(in_b, b, sizeof b);
            ecp_quat_multiply(in_a, b, in_a);
            ecp_quat_multiply(a, in_b, in_b);
            CHECK(memcmp(in_a, ab, sizeof ab) == 0 && memcmp(in_b, ab, sizeof ab) == 0);
        }
    }
}

/* The Cayley transform (I - U)^-1 (I + U), U = [h w / 2]x, by its definition: solved
   by Cramer's rule on the columns */
static void linear_cayley(const double w[3], double h, double C[9])
{
    double u[3], M[9], P[9], det;
    int i, j, k;
    for (k = 0; k < 3; k++) u[k] = h * w[k] / 2;
    for (k = 0; k < 9; k++) P[k] = k % 4 == 0 ? 1 : 0;
    P[1] = -u[2];
    P[2] = u[1];
    P[3] = u[2];
    P[5] = -u[0];
    P[6] = -u[1];
    P[7] = u[0];
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) M[3 * i + j] = P[3 * j + i]; /* I - U = (I + U)^T */
    }
    det = M[0] * (M[4] * M[8] - M[5] * M[7]) - M[1] * (M[3] * M[8] - M[5] * M[6]) +
          M[2] * (M[3] * M[7] - M[4] * M[6]);
    for (j = 0; j < 3; j++) {
        for (k = 0; k < 3; k++) {
            double N[9];
            for (i = 0; i < 9; i++) N[i] = i % 3 == k ? P[3 * (i / 3) + j] : M[i];
            C[3 * k + j] =
                (N[0] * (N[4] * N[8] - N[5] * N[7]) - N[1] * (N[3] * N[8] - N[5] * N[6]) +
                 N[2] * (N[3] * N[7] - N[4] * N[6])) /
                det;
        }
    }
}

static void linear_test_advance(void)
{
    int round, i, k;
    for (round = 0; round < 30; round++) {
        ecp_real q[4], out[4], w[3], h = ECP_R(0.4), R[9], R1[9], T[9], J[9], M[9];
        double C[9], wide[3], speed = round % 3 == 0 ? 0.01 : (round % 3 == 1 ? 1 : 20), angle, c;
        linear_random_unit(4, q);
        for (k = 0; k < 3; k++) {
            w[k] = ECP_R(speed * test_random());
            wide[k] = (double)w[k];
        }
        linear_cayley(wide, (double)h, C);
        ecp_i_cayley(w, h, T, J);
        for (k = 0; k < 9; k++)
            CHECK_NEAR((double)T[k] + (k % 4 == 0 ? 1 : 0), C[k], linear_eps(16));
        ecp_quat_advance(q, w, h, out);
        ecp_quat_to_matrix(q, R);
        ecp_quat_to_matrix(out, R1);
        for (i = 0; i < 9; i++) M[i] = (ecp_real)C[i];
        {
            ecp_real want[9];
            ecp_i_matmul(M, R, want);
            for (k = 0; k < 9; k++) CHECK_NEAR(R1[k], want[k], linear_eps(64));
        }
        /* a turn by 2 atan(h |w| / 2): trace = 1 + 2 cos */
        angle = 2 * atan((double)h * (double)ecp_i_norm(w) / 2);
        c = C[0] + C[4] + C[8];
        CHECK_NEAR(c, 1 + 2 * cos(angle), linear_eps(64));
        CHECK_NEAR(out[0] * out[0] + out[1] * out[1] + out[2] * out[2] + out[3] * out[3], 1,
                   linear_eps(8));
        ecp_quat_advance(q, w, h, q);
        CHECK(memcmp(q, out, sizeof q) == 0);
    }
}

/* J: d(I + T)/dw_k (I + T)^T = [J e_k]x, by sixth-order central differences. They are taken of the
   definition in double, so that the tolerance is one of truncation, (h d)^6 with h d = 1e-2, and
   of rounding, eps / d = 2e-14; in float of the rounding of J itself. */
static void linear_test_cayley_derivative(void)
{
    static const double weight[3] = {45, -9, 1};
    double d = 0.02;
    int round, i, j, k, l, s;
    for (round = 0; round < 10; round++) {
        ecp_real w[3], h = ECP_R(0.5), T[9], J[9];
        double wide[3], C[9], C0[9], D[9], spin[9];
        for (k = 0; k < 3; k++) {
            w[k] = ECP_R(3 * test_random());
            wide[k] = (double)w[k];
        }
        ecp_i_cayley(w, h, T, J);
        linear_cayley(wide, (double)h, C0);
        for (k = 0; k < 3; k++) {
            for (i = 0; i < 9; i++) D[i] = 0;
            for (s = 1; s <= 3; s++) {
                for (l = -1; l <= 1; l += 2) {
                    wide[k] = (double)w[k] + l * s * d;
                    linear_cayley(wide, (double)h, C);
                    for (i = 0; i < 9; i++) D[i] += l * weight[s - 1] * C[i] / (60 * d);
                }
            }
            wide[k] = (double)w[k];
            for (i = 0; i < 3; i++) {
                for (j = 0; j < 3; j++) {
                    spin[3 * i + j] = 0;
                    for (l = 0; l < 3; l++) spin[3 * i + j] += D[3 * i + l] * C0[3 * j + l];
                }
            }
            CHECK_NEAR(J[k], spin[7], test_by(1e-11, 1e-6));
            CHECK_NEAR(J[k], -spin[5], test_by(1e-11, 1e-6));
            CHECK_NEAR(J[3 + k], spin[2], test_by(1e-11, 1e-6));
            CHECK_NEAR(J[6 + k], spin[3], test_by(1e-11, 1e-6));
        }
    }
}

/* ---- LU and Cholesky */

static void linear_test_lu(void)
{
    int n, round, i, j;
    for (n = 1; n <= 12; n++) {
        for (round = 0; round < 5; round++) {
            ecp_real A[LINEAR_MAX * LINEAR_MAX] = {0}, F[LINEAR_MAX * LINEAR_MAX], b[LINEAR_MAX];
            ecp_real x[LINEAR_MAX];
            int piv[LINEAR_MAX], ld = n + round % 3;
            linear_random(n * ld, A);
            if (round == 1) A[0] = 0; /* needs the exchange of rows; n = 1: singular */
            linear_random(n, b);
            memcpy(F, A, sizeof A);
            memcpy(x, b, (size_t)n * sizeof *b);
            if (n == 1 && round == 1) {
                CHECK(ecp_lu_factor(n, F, ld, piv) == 1);
                continue;
            }
            CHECK(ecp_lu_factor(n, F, ld, piv) == 0);
            ecp_lu_solve(n, F, ld, piv, x);
            /* partial pivoting: backward stable up to a modest growth */
            CHECK(linear_residual(n, n, A, ld, x, b) <=
                  linear_eps(16 * n) * (1 + linear_largest(n, x)));
            /* partial pivoting keeps the multipliers at one or below */
            for (i = 0; i < n; i++) {
                for (j = 0; j < i; j++) CHECK(fabs((double)F[i * ld + j]) <= 1);
            }
        }
    }
    {
        /* the third column is zero from the start */
        ecp_real A[16];
        int piv[4];
        linear_random(16, A);
        for (i = 0; i < 4; i++) A[4 * i + 2] = 0;
        CHECK(ecp_lu_factor(4, A, 4, piv) == 3);
    }
}

static void linear_test_cholesky(void)
{
    int n, round, i, j, k;
    for (n = 1; n <= 12; n++) {
        for (round = 0; round < 4; round++) {
            ecp_real A[LINEAR_MAX * LINEAR_MAX], L[LINEAR_MAX * LINEAR_MAX],
                B[LINEAR_MAX * LINEAR_MAX];
            ecp_real b[LINEAR_MAX], x[LINEAR_MAX];
            int ld = n + round % 3;
            linear_random(n * n, B);
            linear_random(n, b);
            for (i = 0; i < n; i++) {
                for (j = 0; j < n; j++) {
                    double sum = i == j ? 0.5 : 0;
                    for (k = 0; k < n; k++) sum += (double)B[i * n + k] * (double)B[j * n + k];
                    A[i * ld + j] = (ecp_real)sum;
                    /* the upper triangle is not read */
                    L[i * ld + j] = j > i ? ECP_R(1e30) : A[i * ld + j];
                }
            }
            memcpy(x, b, (size_t)n * sizeof *b);
            CHECK(ecp_chol_factor(n, L, ld) == 0);
            for (i = 0; i < n; i++) {
                for (j = 0; j <= i; j++) {
                    double sum = 0;
                    for (k = 0; k <= j; k++) sum += (double)L[i * ld + k] * (double)L[j * ld + k];
                    CHECK_NEAR(sum, A[i * ld + j], linear_eps(4 * n * n));
                }
                CHECK(L[i * ld + i] > 0);
            }
            ecp_chol_solve(n, L, ld, x);
            CHECK(linear_residual(n, n, A, ld, x, b) <=
                  linear_eps(8 * n * n) * (1 + linear_largest(n, x)));
        }
    }
    {
        /* not positive: the pivot that says so */
        ecp_real I[9] = {1, 0, 0, 0, -1, 0, 0, 0, 1}, S[4] = {1, 0, 1, 1}, N[1];
        N[0] = ECP_R(NAN);
        CHECK(ecp_chol_factor(3, I, 3) == 2);
        CHECK(ecp_chol_factor(2, S, 2) == 2); /* [1 1; 1 1] */
        CHECK(ecp_chol_factor(1, N, 1) == 1);
    }
}

/* ---- QR and least squares */

static void linear_check_qr(int m, int n, int rank)
{
    ecp_real A[LINEAR_MAX * LINEAR_MAX] = {0}, F[LINEAR_MAX * LINEAR_MAX], tau[LINEAR_MAX];
    ecp_real Q[LINEAR_MAX][LINEAR_MAX], b[LINEAR_MAX], c[LINEAR_MAX];
    double V[LINEAR_MAX * LINEAR_MAX];
    int piv[LINEAR_MAX], seen[LINEAR_MAX], i, j, k, ld = n + 1, found;
    linear_of_rank(m, n, rank, A, ld, V);
    memcpy(F, A, sizeof A);
    found = ecp_qr_factor(m, n, F, ld, tau, piv, ECP_R(64) * ECP_I_EPSILON);
    CHECK(found == rank);
    if (found != rank) return;
    for (j = 0; j < m; j++) {
        for (i = 0; i < m; i++) Q[j][i] = i == j;
        ecp_qr_apply_q(m, rank, F, ld, tau, Q[j]); /* column j of Q */
    }
    for (i = 0; i < m; i++) {
        for (j = 0; j < m; j++) {
            double dot = 0;
            for (k = 0; k < m; k++) dot += (double)Q[i][k] * (double)Q[j][k];
            CHECK_NEAR(dot, i == j, linear_eps(16 * m));
        }
    }
    for (j = 0; j < n; j++) seen[j] = 0;
    for (j = 0; j < n; j++) seen[piv[j]]++;
    for (j = 0; j < n; j++) {
        CHECK(seen[j] == 1);
        /* column j of A P is Q R: the part of R below row `rank` is rounding */
        for (i = 0; i < m; i++) {
            double sum = 0;
            for (k = 0; k < rank && k <= j; k++) sum += (double)Q[k][i] * (double)F[k * ld + j];
            CHECK_NEAR(sum, A[i * ld + piv[j]], linear_eps(64 * m));
        }
    }
    for (k = 1; k < rank; k++) {
        CHECK(fabs((double)F[k * ld + k]) <=
              (1 + linear_eps(64)) * fabs((double)F[(k - 1) * ld + k - 1]));
    }
    /* Q^T undoes Q */
    linear_random(m, b);
    memcpy(c, b, (size_t)m * sizeof *b);
    ecp_qr_apply_q(m, rank, F, ld, tau, c);
    ecp_qr_apply_qt(m, rank, F, ld, tau, c);
    for (i = 0; i < m; i++) CHECK_NEAR(c[i], b[i], linear_eps(16 * m));
}

/* of all x that minimise |A x - b| the shortest: A^T (A x - b) = 0, and x is a combination of the
   rows of A, here of V */
static void linear_check_least_squares(int m, int n, int rank)
{
    ecp_real A[LINEAR_MAX * LINEAR_MAX] = {0}, F[LINEAR_MAX * LINEAR_MAX], b[LINEAR_MAX],
                            c[LINEAR_MAX];
    ecp_real x[LINEAR_MAX], work[ECP_LEAST_SQUARES_WORK(LINEAR_MAX, LINEAR_MAX) + 1];
    double V[LINEAR_MAX * LINEAR_MAX], r[LINEAR_MAX], rest[LINEAR_MAX];
    int iwork[2 * LINEAR_MAX + 1], i, j, k, ld = n + 1;
    linear_of_rank(m, n, rank, A, ld, V);
    linear_random(m, b);
    memcpy(F, A, sizeof A);
    memcpy(c, b, (size_t)m * sizeof *b);
    work[ECP_LEAST_SQUARES_WORK(m, n)] = ECP_R(77);
    iwork[2 * n] = 77;
    CHECK(ecp_least_squares(m, n, F, ld, c, x, work, iwork, ECP_R(64) * ECP_I_EPSILON) == rank);
    CHECK(work[ECP_LEAST_SQUARES_WORK(m, n)] == ECP_R(77) && iwork[2 * n] == 77);
    for (i = 0; i < m; i++) {
        r[i] = -(double)b[i];
        for (j = 0; j < n; j++) r[i] += (double)A[i * ld + j] * (double)x[j];
    }
    for (j = 0; j < n; j++) {
        double dot = 0;
        for (i = 0; i < m; i++) dot += (double)A[i * ld + j] * r[i];
        CHECK_NEAR(dot, 0, linear_eps(64 * (m + n)));
        rest[j] = (double)x[j];
    }
    for (k = 0; k < rank; k++) {
        double dot = 0;
        for (j = 0; j < n; j++) dot += V[k * n + j] * rest[j];
        for (j = 0; j < n; j++) rest[j] -= dot * V[k * n + j];
    }
    for (j = 0; j < n; j++) CHECK_NEAR(rest[j], 0, linear_eps(64 * (m + n)));
}

static void linear_test_orthogonal(void)
{
    static const int shapes[][3] = {{1, 1, 1},  {3, 3, 3},   {4, 7, 4},   {7, 4, 4}, {12, 12, 12},
                                    {5, 5, 2},  {9, 4, 3},   {4, 9, 3},   {6, 6, 5}, {10, 3, 1},
                                    {3, 10, 1}, {12, 12, 7}, {1, 6, 1},   {6, 1, 1}, {5, 8, 0},
                                    {15, 9, 9}, {9, 15, 9},  {15, 15, 14}};
    unsigned i;
    for (i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        linear_check_qr(shapes[i][0], shapes[i][1], shapes[i][2]);
        linear_check_least_squares(shapes[i][0], shapes[i][1], shapes[i][2]);
    }
    {
        /* squares of these entries would overflow or underflow */
        ecp_real big = ECP_R(test_by(1e300, 1e35)), A[4], b[2], x[2],
                 work[ECP_LEAST_SQUARES_WORK(2, 2)];
        int iwork[4];
        A[0] = A[3] = big;
        A[1] = big / 2;
        A[2] = -big / 2;
        b[0] = big;
        b[1] = 0;
        CHECK(ecp_least_squares(2, 2, A, 2, b, x, work, iwork, ECP_R(64) * ECP_I_EPSILON) == 2);
        CHECK_NEAR(x[0], 0.8, linear_eps(32));
        CHECK_NEAR(x[1], 0.4, linear_eps(32));
    }
}

/* ---- elimination */

typedef struct linear_block {
    ecp_real A[LINEAR_MAX * LINEAR_MAX], before[LINEAR_MAX * LINEAR_MAX];
    int row_tag[LINEAR_MAX], col_tag[LINEAR_MAX], row_order[LINEAR_MAX], col_order[LINEAR_MAX];
    int ld, all_rows, all_cols, rows, cols;
} linear_block;

static void linear_block_random(linear_block *k, int rows, int cols, int more_rows, int more_cols)
{
    int i;
    k->rows = rows;
    k->cols = cols;
    k->all_rows = rows + more_rows;
    k->all_cols = cols + more_cols;
    k->ld = k->all_cols + 2;
    linear_random(k->all_rows * k->ld, k->A);
    for (i = 0; i < LINEAR_MAX; i++) {
        k->row_tag[i] = k->col_tag[i] = 1;
        k->row_order[i] = k->col_order[i] = i;
    }
    memcpy(k->before, k->A, sizeof k->A);
}

static int linear_block_eliminate(linear_block *k, int first, int mask, double tolerance)
{
    return ecp_eliminate(k->A, k->ld, k->all_rows, k->all_cols, k->rows, k->cols, first, mask,
                         ECP_R(tolerance), k->row_tag, k->col_tag, k->row_order, k->col_order);
}

/* The rows and columns after the first `pivots` hold A22 - A21 A11^-1 A12 of the matrix in the
   order of row_order and col_order, whatever the pivots were; the rows of the pivots, times the
   inverse of their triangle, hold A11^-1 A12. */
static void linear_check_schur(const linear_block *k, int pivots)
{
    ecp_real A11[LINEAR_MAX * LINEAR_MAX], x[LINEAR_MAX];
    int piv[LINEAR_MAX], i, j, r;
    double growth = 0;
    for (i = 0; i < pivots; i++) {
        for (j = 0; j < pivots; j++) {
            A11[i * LINEAR_MAX + j] = k->before[k->row_order[i] * k->ld + k->col_order[j]];
        }
    }
    CHECK(ecp_lu_factor(pivots, A11, LINEAR_MAX, piv) == 0);
    for (j = pivots; j < k->all_cols; j++) {
        int column = j < k->cols ? k->col_order[j] : j;
        for (i = 0; i < pivots; i++) x[i] = k->before[k->row_order[i] * k->ld + column];
        ecp_lu_solve(pivots, A11, LINEAR_MAX, piv, x);
        if (linear_largest(pivots, x) > growth) growth = linear_largest(pivots, x);
        for (i = pivots; i < k->all_rows; i++) {
            int row = i < k->rows ? k->row_order[i] : i;
            double sum = (double)k->before[row * k->ld + column];
            for (r = 0; r < pivots; r++) {
                sum -= (double)k->before[row * k->ld + k->col_order[r]] * (double)x[r];
            }
            CHECK_NEAR(k->A[i * k->ld + j], sum, linear_eps(256) * (1 + growth));
        }
        /* back substitution with the triangle gives x again */
        for (i = 0; i < pivots; i++) {
            double sum = (double)k->A[i * k->ld + j];
            for (r = i; r < pivots; r++) sum -= (double)k->A[i * k->ld + r] * (double)x[r];
            CHECK_NEAR(sum, 0, linear_eps(256) * (1 + growth));
        }
    }
    /* below the pivots stand the multipliers: L U is the matrix in the order of its pivots */
    for (i = 0; i < k->all_rows; i++) {
        int row = i < k->rows ? k->row_order[i] : i;
        for (j = 0; j < pivots; j++) {
            double sum = 0, size = 0;
            for (r = 0; r <= j && r <= i; r++) {
                double l = r == i ? 1 : (double)k->A[i * k->ld + r];
                sum += l * (double)k->A[r * k->ld + j];
                size += fabs(l * (double)k->A[r * k->ld + j]);
            }
            CHECK_NEAR(sum, (double)k->before[row * k->ld + k->col_order[j]],
                       linear_eps(64) * (1 + size));
        }
    }
    /* beyond the columns nothing is touched */
    for (i = 0; i < k->all_rows; i++) {
        for (j = k->all_cols; j < k->ld; j++)
            CHECK(k->A[i * k->ld + j] == k->before[i * k->ld + j]);
    }
}

static void linear_test_eliminate(void)
{
    linear_block k;
    int round, i, j, r, pivots;
    for (round = 0; round < 20; round++) {
        linear_block_random(&k, 1 + round % 6, 1 + (round + round / 6) % 6, 4, 5);
        pivots = linear_block_eliminate(&k, 0, 1, 1e-6);
        CHECK(pivots == (k.rows < k.cols ? k.rows : k.cols));
        linear_check_schur(&k, pivots);
        /* complete pivoting: no multiplier above one inside the block */
        for (i = 0; i < pivots; i++) {
            for (j = i; j < k.cols; j++) {
                CHECK(fabs((double)k.A[i * k.ld + j]) <= fabs((double)k.A[i * k.ld + i]));
            }
        }
    }
    for (round = 0; round < 10; round++) {
        /* first pivots only where both tags have bit 1, then bit 2, then anywhere */
        linear_block_random(&k, 6, 7, 3, 2);
        for (i = 0; i < 6; i++) k.row_tag[i] = i % 2 ? 1 : 2;
        for (j = 0; j < 7; j++) k.col_tag[j] = j < 2 ? 1 : 2;
        pivots = linear_block_eliminate(&k, 0, 1, 1e-6);
        CHECK(pivots == 2); /* three rows, but two columns */
        for (i = 0; i < pivots; i++) CHECK(k.row_tag[i] == 1 && k.col_tag[i] == 1);
        linear_check_schur(&k, pivots);
        pivots = linear_block_eliminate(&k, pivots, 2, 1e-6);
        CHECK(pivots == 5);
        for (i = 2; i < pivots; i++) CHECK(k.row_tag[i] == 2 && k.col_tag[i] == 2);
        linear_check_schur(&k, pivots);
        pivots = linear_block_eliminate(&k, pivots, 3, 1e-6);
        CHECK(pivots == 6);
        linear_check_schur(&k, pivots);
        for (i = 0; i < 6; i++) CHECK(k.row_tag[i] == (k.row_order[i] % 2 ? 1 : 2));
        for (j = 0; j < 7; j++) CHECK(k.col_tag[j] == (k.col_order[j] < 2 ? 1 : 2));
    }
    for (round = 0; round < 10; round++) {
        /* a 6 x 6 block of rank r, and what is left of it below the tolerance */
        double V[LINEAR_MAX * LINEAR_MAX];
        r = round % 6;
        linear_block_random(&k, 6, 6, 3, 3);
        linear_of_rank(6, 6, r, k.A, k.ld, V);
        memcpy(k.before, k.A, sizeof k.A);
        pivots = linear_block_eliminate(&k, 0, 1, test_by(1e-10, 1e-4));
        CHECK(pivots == r);
        linear_check_schur(&k, pivots);
        for (i = pivots; i < 6; i++) {
            for (j = pivots; j < 6; j++)
                CHECK(fabs((double)k.A[i * k.ld + j]) <= test_by(1e-10, 1e-4));
        }
    }
    {
        /* the tolerance is that of the pivots: diag(1, 1e-1, 1e-2, 1e-3) */
        double tolerance;
        int want = 0;
        for (tolerance = 2; tolerance > 1e-4; tolerance /= 10, want++) {
            linear_block_random(&k, 4, 4, 1, 1);
            for (i = 0; i < 4; i++) {
                for (j = 0; j < 4; j++) k.A[i * k.ld + j] = i == j ? ECP_R(pow(0.1, i)) : 0;
            }
            CHECK(linear_block_eliminate(&k, 0, 1, tolerance) == want);
        }
        CHECK(want == 5);
    }
}

static void test_linear(void)
{
    test_seed = 11;
    CHECK(ecp_arithmetic() == 0); /* where it is not: tests/hashes.sh */
    linear_test_vectors();
    linear_test_quaternions();
    linear_test_advance();
    linear_test_cayley_derivative();
    linear_test_lu();
    linear_test_cholesky();
    linear_test_orthogonal();
    linear_test_eliminate();
}
