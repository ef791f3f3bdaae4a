/* Sampled controller for an inverted pendulum, sampling time $dt s.
 *
 *   xhat(n) = L1 y(n) + L2 v(n),          u(n) = -F [xhat(n); w(n)], limited
 *   v(n+1) = E v(n) + H u(n) + K y(n),    w(n+1) = w(n) + Ts (y_r(n) - y(n))
 *
 * y: $angles relative angles, then the rate of the lowest link (rad, rad/s); u: volts; y_ref: rad.
 * Converters count in codes: what one code is worth, and where zero lies, is for the caller to say.
 *
 * Call pendulum_init once with the first state (rates zero when held still), then at every sample
 * either pendulum_step, or pendulum_output, send u, pendulum_update: so the voltages leave
 * before the observer is updated. Arguments stand in one order, what is written last. No
 * allocation, no globals: one struct per pendulum. C99, without -ffast-math.
 *
 * A sample with a reading that is no finite number gives u = 0 and leaves the state as it was;
 * s->lost counts such samples in a row, for the caller to switch off when there are too many.
 * There is no anti-windup: w goes on integrating while u is limited or the pendulum is held.
 *
 * Other files see types and prototypes by
 *     #define PENDULUM_PROTOTYPES_ONLY
 *     #include "this file"
 */
#ifndef PENDULUM_H
#define PENDULUM_H
#include <stddef.h>

typedef $real pendulum_real;

enum {
    PENDULUM_STATES = $states,   /* entries of x0 and xhat */
    PENDULUM_OUTPUTS = $outputs,  /* entries of y */
    PENDULUM_MOTORS = $motors,   /* entries of u */
    PENDULUM_OBSERVER = $observer,
    PENDULUM_TRACKED = $tracked   /* entries of y_ref */
};

typedef struct {
    pendulum_real v[PENDULUM_OBSERVER]; /* observer */
    pendulum_real w[PENDULUM_TRACKED]; /* integrators */
    unsigned lost; /* samples in a row that could not be used */
} pendulum_state;

void pendulum_init(pendulum_state *s, const pendulum_real x0[PENDULUM_STATES]);
void pendulum_output(const pendulum_state *s, const pendulum_real y[PENDULUM_OUTPUTS],
    pendulum_real u[PENDULUM_MOTORS]);
void pendulum_update(pendulum_state *s, const pendulum_real y[PENDULUM_OUTPUTS],
    const pendulum_real y_ref[PENDULUM_TRACKED], const pendulum_real u[PENDULUM_MOTORS]);
void pendulum_step(pendulum_state *s, const pendulum_real y[PENDULUM_OUTPUTS],
    const pendulum_real y_ref[PENDULUM_TRACKED], pendulum_real u[PENDULUM_MOTORS]);
#endif

#ifndef PENDULUM_PROTOTYPES_ONLY
$matrices
static const int pendulum_tracked[PENDULUM_TRACKED] = {$indices};

/* Whether all of a[0] to a[n - 1] are finite numbers. */
static int pendulum_finite(const pendulum_real *a, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!(a[i] - a[i] <= 0))
            return 0;
    return 1;
}

/* v(0) = T x(0), w(0) = 0 */
void pendulum_init(pendulum_state *s, const pendulum_real x0[PENDULUM_STATES])
{
    int known = pendulum_finite(x0, PENDULUM_STATES); /* else from upright */
    for (size_t i = 0; i < PENDULUM_OBSERVER; i++) {
        s->v[i] = 0;
        for (size_t j = 0; known && j < PENDULUM_STATES; j++)
            s->v[i] += pendulum_T[i][j] * x0[j];
    }
    for (size_t i = 0; i < PENDULUM_TRACKED; i++)
        s->w[i] = 0;
    s->lost = 0;
}

/* Steps 2 to 4: estimate, control, limit. */
void pendulum_output(const pendulum_state *s, const pendulum_real y[PENDULUM_OUTPUTS],
    pendulum_real u[PENDULUM_MOTORS])
{
    pendulum_real xhat[PENDULUM_STATES];
    for (size_t i = 0; i < PENDULUM_STATES; i++) {
        xhat[i] = 0;
        for (size_t j = 0; j < PENDULUM_OUTPUTS; j++)
            xhat[i] += pendulum_L1[i][j] * y[j];
        for (size_t j = 0; j < PENDULUM_OBSERVER; j++)
            xhat[i] += pendulum_L2[i][j] * s->v[j];
    }
    for (size_t i = 0; i < PENDULUM_MOTORS; i++) {
        pendulum_real sum = 0;
        for (size_t j = 0; j < PENDULUM_STATES; j++)
            sum += pendulum_F[i][j] * xhat[j];
        for (size_t j = 0; j < PENDULUM_TRACKED; j++)
            sum += pendulum_F[i][PENDULUM_STATES + j] * s->w[j];
        u[i] = -sum;
        if (u[i] > pendulum_u_max[i])
            u[i] = pendulum_u_max[i];
        if (u[i] < -pendulum_u_max[i])
            u[i] = -pendulum_u_max[i];
        if (!pendulum_finite(&u[i], 1) || !pendulum_finite(y, PENDULUM_OUTPUTS))
            u[i] = 0;
    }
}

/* Step 6: observer and integrators, with the limited u that was sent. */
void pendulum_update(pendulum_state *s, const pendulum_real y[PENDULUM_OUTPUTS],
    const pendulum_real y_ref[PENDULUM_TRACKED], const pendulum_real u[PENDULUM_MOTORS])
{
    pendulum_real v[PENDULUM_OBSERVER], w[PENDULUM_TRACKED];
    for (size_t i = 0; i < PENDULUM_OBSERVER; i++) {
        v[i] = 0;
        for (size_t j = 0; j < PENDULUM_OBSERVER; j++)
            v[i] += pendulum_E[i][j] * s->v[j];
        for (size_t j = 0; j < PENDULUM_MOTORS; j++)
            v[i] += pendulum_H[i][j] * u[j];
        for (size_t j = 0; j < PENDULUM_OUTPUTS; j++)
            v[i] += pendulum_K[i][j] * y[j];
    }
    for (size_t i = 0; i < PENDULUM_TRACKED; i++)
        w[i] = s->w[i] + $dt * (y_ref[i] - y[pendulum_tracked[i]]);
    if (!pendulum_finite(y, PENDULUM_OUTPUTS) || !pendulum_finite(v, PENDULUM_OBSERVER)
        || !pendulum_finite(w, PENDULUM_TRACKED)) {
        s->lost++;
        return;
    }
    for (size_t i = 0; i < PENDULUM_OBSERVER; i++)
        s->v[i] = v[i];
    for (size_t i = 0; i < PENDULUM_TRACKED; i++)
        s->w[i] = w[i];
    s->lost = 0;
}

/* One sample: steps 2 to 6. */
void pendulum_step(pendulum_state *s, const pendulum_real y[PENDULUM_OUTPUTS],
    const pendulum_real y_ref[PENDULUM_TRACKED], pendulum_real u[PENDULUM_MOTORS])
{
    pendulum_output(s, y, u);
    pendulum_update(s, y, y_ref, u);
}
#endif
