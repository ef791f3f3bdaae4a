/* The triple pendulum with every imperfection on, as one would write it in plain C.
 *
 * Reference for tests/benchmarks/simulation.py: the same equations, controller and fixed Runge-Kutta
 * step as pendlab's simulator, written by hand from Lagrange's equations in absolute angles.
 */
#include <math.h>
#include <string.h>

enum { N = 3, M = 2, Q = N + 1, SIZE = 3 * N + 2 * M + 1 };

typedef struct { /* all doubles, in the order in which Python packs them */
    double length[N], mass[N], inertia[N], com[N], friction[N], g;
    double gain[M], damping[M], rotor[M], gap[M], stiffness[M], impact[M], dry_gear[M];
    double dry_hinge[N], presliding, w_in[M], w_out[Q];
    double offset[Q], ad[Q], limit[M], da[M], u_max[M];
    double E[2][2], K[2][Q], L1[2 * N][Q], L2[2 * N][2], F[M][2 * N + 1];
    double dt, delay, v0[2], x0[2 * N];
} setup;

typedef struct {
    double q[N], v[N], phi[M], w[M], z[Q];
} plant;

static double clip(double x, double limit)
{
    return x > limit ? limit : x < -limit ? -limit : x;
}

static void solve(double A[N][N], double b[N])
{
    for (int j = 0; j < N; j++)
        for (int i = j + 1; i < N; i++) {
            double f = A[i][j] / A[j][j];
            for (int k = j; k < N; k++)
                A[i][k] -= f * A[j][k];
            b[i] -= f * b[j];
        }
    for (int i = N - 1; i >= 0; i--) {
        for (int k = i + 1; k < N; k++)
            b[i] -= A[i][k] * b[k];
        b[i] /= A[i][i];
    }
}

static void derivative(const setup *s, const double *moment, const double *above, const plant *x,
    const double *volts, const double *anchor, plant *dx)
{
    double A[N][N], r[N] = {0};
    for (int i = 0; i < N; i++) {
        double rate = i ? x->v[i] - x->v[i - 1] : x->v[i];
        double turned = i ? x->q[i] - x->q[i - 1] : x->q[i];
        double f = s->friction[i] * rate
            + s->dry_hinge[i] * clip((turned - anchor[i]) / s->presliding, 1);
        r[i] -= f;
        if (i)
            r[i - 1] += f;
    }
    for (int j = 0; j < M; j++) {
        double slip = x->phi[j] - (x->q[j + 1] - x->q[j]);
        double slip_rate = x->w[j] - (x->v[j + 1] - x->v[j]);
        double depth = fabs(slip) - s->gap[j] / 2, tau = 0;
        if (depth > 0) {
            double sign = slip > 0 ? 1 : -1;
            double closing = 1 + s->impact[j] * sign * slip_rate;
            if (closing > 0)
                tau = sign * s->stiffness[j] * depth * closing;
        }
        r[j + 1] += tau;
        r[j] -= tau;
        dx->phi[j] = x->w[j];
        dx->w[j] = (s->gain[j] * clip(volts[j], s->limit[j]) - s->damping[j] * x->w[j] - tau
            - s->dry_gear[j] * clip((x->phi[j] - anchor[N + j]) / s->presliding, 1)) / s->rotor[j];
    }
    for (int i = 0; i < N; i++) {
        A[i][i] = s->inertia[i] + s->mass[i] * s->com[i] * s->com[i]
            + s->length[i] * s->length[i] * above[i];
        r[i] += s->g * moment[i] * sin(x->q[i]);
        for (int j = 0; j < N; j++)
            if (j != i) {
                double c = i < j ? s->length[i] * moment[j] : s->length[j] * moment[i];
                A[i][j] = c * cos(x->q[i] - x->q[j]);
                r[i] -= c * sin(x->q[i] - x->q[j]) * x->v[j] * x->v[j];
            }
    }
    solve(A, r);
    for (int i = 0; i < N; i++) {
        double turned = i ? x->q[i] - x->q[i - 1] : x->q[i];
        dx->q[i] = x->v[i];
        dx->v[i] = r[i];
        dx->z[i] = s->w_out[i] * (turned - x->z[i]);
    }
    dx->z[N] = s->w_out[N] * (x->v[0] - x->z[N]);
}

static plant moved(const plant *x, double h, const plant *k)
{
    plant y;
    const double *from = (const double *)x, *slope = (const double *)k;
    for (int i = 0; i < SIZE; i++)
        ((double *)&y)[i] = from[i] + h * slope[i];
    return y;
}

static int integrate(const setup *s, const double *moment, const double *above, plant *x,
    double *anchor, double *volts, const double *u, double duration, int steps)
{
    double h = duration / steps, middle[M], end[M];
    for (int n = 0; n < steps; n++) {
        plant k1, k2, k3, k4, y;
        for (int j = 0; j < M; j++) {
            middle[j] = u[j] + (volts[j] - u[j]) * exp(-0.5 * h * s->w_in[j]);
            end[j] = u[j] + (volts[j] - u[j]) * exp(-h * s->w_in[j]);
        }
        derivative(s, moment, above, x, volts, anchor, &k1);
        y = moved(x, h / 2, &k1);
        derivative(s, moment, above, &y, middle, anchor, &k2);
        y = moved(x, h / 2, &k2);
        derivative(s, moment, above, &y, middle, anchor, &k3);
        y = moved(x, h, &k3);
        derivative(s, moment, above, &y, end, anchor, &k4);
        for (int i = 0; i < SIZE; i++)
            ((double *)x)[i] += h / 6 * (((double *)&k1)[i] + 2 * ((double *)&k2)[i]
                + 2 * ((double *)&k3)[i] + ((double *)&k4)[i]);
        memcpy(volts, end, sizeof end);
        for (int i = 0; i < N + M; i++) {
            double at = i >= N ? x->phi[i - N] : i ? x->q[i] - x->q[i - 1] : x->q[i];
            anchor[i] = at - clip(at - anchor[i], s->presliding);
        }
        for (int i = 0; i < N; i++)
            if (!(fabs(x->q[i]) < 1.5707963267948966))
                return 1;
    }
    return 0;
}

static double rounded(double x, double step)
{
    return step > 0 ? step * floor(x / step + 0.5) : x;
}

/* Rows of 3 relative angles and 2 voltages; returns the number of rows before a fall. */
int run(const setup *s, int rows, int late, int steps, double *out)
{
    double moment[N], above[N], v[2], w = 0, volts[M] = {0}, before[M] = {0}, u[M], anchor[N + M];
    plant x = {{0}};
    memcpy(v, s->v0, sizeof v);
    for (int i = N - 1; i >= 0; i--) {
        above[i] = i < N - 1 ? above[i + 1] + s->mass[i + 1] : 0;
        moment[i] = s->mass[i] * s->com[i] + s->length[i] * above[i];
    }
    for (int i = 0; i < N; i++) {
        x.q[i] = s->x0[i] + (i ? x.q[i - 1] : 0);
        x.v[i] = s->x0[N + i] + (i ? x.v[i - 1] : 0);
        x.z[i] = anchor[i] = s->x0[i];
    }
    for (int j = 0; j < M; j++) {
        x.phi[j] = anchor[N + j] = s->x0[j + 1];
        x.w[j] = s->x0[N + j + 1];
    }
    x.z[N] = x.v[0];
    for (int k = 0; k < rows; k++) {
        double y[Q], xhat[2 * N], next[2];
        for (int i = 0; i < Q; i++)
            y[i] = rounded(x.z[i] + s->offset[i], s->ad[i]);
        for (int i = 0; i < 2 * N; i++) {
            xhat[i] = s->L2[i][0] * v[0] + s->L2[i][1] * v[1];
            for (int j = 0; j < Q; j++)
                xhat[i] += s->L1[i][j] * y[j];
        }
        for (int j = 0; j < M; j++) {
            u[j] = -s->F[j][2 * N] * w;
            for (int i = 0; i < 2 * N; i++)
                u[j] -= s->F[j][i] * xhat[i];
            u[j] = clip(u[j], s->u_max[j]);
        }
        for (int i = 0; i < 2; i++) { /* H = 0 */
            next[i] = s->E[i][0] * v[0] + s->E[i][1] * v[1];
            for (int j = 0; j < Q; j++)
                next[i] += s->K[i][j] * y[j];
        }
        memcpy(v, next, sizeof v);
        w -= s->dt * y[1];
        for (int i = 0; i < N; i++)
            out[5 * k + i] = i ? x.q[i] - x.q[i - 1] : x.q[i];
        for (int j = 0; j < M; j++)
            out[5 * k + N + j] = clip(u[j] = rounded(u[j], s->da[j]), s->limit[j]);
        if (k + 1 == rows)
            break;
        if (integrate(s, moment, above, &x, anchor, volts, before, s->delay, late)
            || integrate(s, moment, above, &x, anchor, volts, u, s->dt - s->delay, steps - late))
            return k + 1;
        memcpy(before, u, sizeof u);
    }
    return rows;
}
