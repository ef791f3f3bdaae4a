"""The controller as a C99 file, for a microcontroller or a PC on the bench."""

import numpy as np

from .._arguments import flag, found, instance
from ..bench import arguments
from ..controllers import Controller

TEMPLATE = """\
/* Sampled controller for an inverted pendulum, sampling time {dt} s.
 *
 *   xhat(n) = L1 y(n) + L2 v(n),          u(n) = -F [xhat(n); w(n)], limited
 *   v(n+1) = E v(n) + H u(n) + K y(n),    w(n+1) = w(n) + Ts (y_r(n) - y(n))
 *
 * y: {angles} relative angles, then the rate of the lowest link (rad, rad/s); u: volts; y_ref: rad.
 * Converters count in codes: what one code is worth, and where zero lies, is for the caller to say.
 *
 * Call {name}_init once with the first state (rates zero when held still), then at every sample
 * either {name}_step, or {name}_output, send u, {name}_update: so the voltages leave
 * before the observer is updated. Arguments stand in one order, what is written last. No
 * allocation, no globals: one struct per pendulum. C99, without -ffast-math.
 *
 * A sample with a reading that is no finite number gives u = 0 and leaves the state as it was;
 * s->lost counts such samples in a row, for the caller to switch off when there are too many.
 * There is no anti-windup: w goes on integrating while u is limited or the pendulum is held.
 *
 * Other files see types and prototypes by
 *     #define {NAME}_PROTOTYPES_ONLY
 *     #include "this file"
 */
#ifndef {NAME}_H
#define {NAME}_H
#include <stddef.h>

typedef {real} {name}_real;

enum {{
    {NAME}_STATES = {states},   /* entries of x0 and xhat */
    {NAME}_OUTPUTS = {outputs},  /* entries of y */
    {NAME}_MOTORS = {motors},   /* entries of u */
    {NAME}_OBSERVER = {observer},
    {NAME}_TRACKED = {tracked}   /* entries of y_ref */
}};

typedef struct {{
    {name}_real v[{NAME}_OBSERVER]; /* observer */
    {name}_real w[{NAME}_TRACKED]; /* integrators */
    unsigned lost; /* samples in a row that could not be used */
}} {name}_state;

void {name}_init({name}_state *s, const {name}_real x0[{NAME}_STATES]);
void {name}_output(const {name}_state *s, const {name}_real y[{NAME}_OUTPUTS],
    {name}_real u[{NAME}_MOTORS]);
void {name}_update({name}_state *s, const {name}_real y[{NAME}_OUTPUTS],
    const {name}_real y_ref[{NAME}_TRACKED], const {name}_real u[{NAME}_MOTORS]);
void {name}_step({name}_state *s, const {name}_real y[{NAME}_OUTPUTS],
    const {name}_real y_ref[{NAME}_TRACKED], {name}_real u[{NAME}_MOTORS]);
#endif

#ifndef {NAME}_PROTOTYPES_ONLY
{matrices}
static const int {name}_tracked[{NAME}_TRACKED] = {{{indices}}};

/* Whether all of a[0] to a[n - 1] are finite numbers. */
static int {name}_finite(const {name}_real *a, size_t n)
{{
    for (size_t i = 0; i < n; i++)
        if (!(a[i] - a[i] <= 0))
            return 0;
    return 1;
}}

/* v(0) = T x(0), w(0) = 0 */
void {name}_init({name}_state *s, const {name}_real x0[{NAME}_STATES])
{{
    int known = {name}_finite(x0, {NAME}_STATES); /* else from upright */
    for (size_t i = 0; i < {NAME}_OBSERVER; i++) {{
        s->v[i] = 0;
        for (size_t j = 0; known && j < {NAME}_STATES; j++)
            s->v[i] += {name}_T[i][j] * x0[j];
    }}
    for (size_t i = 0; i < {NAME}_TRACKED; i++)
        s->w[i] = 0;
    s->lost = 0;
}}

/* Steps 2 to 4: estimate, control, limit. */
void {name}_output(const {name}_state *s, const {name}_real y[{NAME}_OUTPUTS],
    {name}_real u[{NAME}_MOTORS])
{{
    {name}_real xhat[{NAME}_STATES];
    for (size_t i = 0; i < {NAME}_STATES; i++) {{
        xhat[i] = 0;
        for (size_t j = 0; j < {NAME}_OUTPUTS; j++)
            xhat[i] += {name}_L1[i][j] * y[j];
        for (size_t j = 0; j < {NAME}_OBSERVER; j++)
            xhat[i] += {name}_L2[i][j] * s->v[j];
    }}
    for (size_t i = 0; i < {NAME}_MOTORS; i++) {{
        {name}_real sum = 0;
        for (size_t j = 0; j < {NAME}_STATES; j++)
            sum += {name}_F[i][j] * xhat[j];
        for (size_t j = 0; j < {NAME}_TRACKED; j++)
            sum += {name}_F[i][{NAME}_STATES + j] * s->w[j];
        u[i] = -sum;{limits}
        if (!{name}_finite(&u[i], 1) || !{name}_finite(y, {NAME}_OUTPUTS))
            u[i] = 0;
    }}
}}

/* Step 6: observer and integrators, with the limited u that was sent. */
void {name}_update({name}_state *s, const {name}_real y[{NAME}_OUTPUTS],
    const {name}_real y_ref[{NAME}_TRACKED], const {name}_real u[{NAME}_MOTORS])
{{
    {name}_real v[{NAME}_OBSERVER], w[{NAME}_TRACKED];
    for (size_t i = 0; i < {NAME}_OBSERVER; i++) {{
        v[i] = 0;
        for (size_t j = 0; j < {NAME}_OBSERVER; j++)
            v[i] += {name}_E[i][j] * s->v[j];
        for (size_t j = 0; j < {NAME}_MOTORS; j++)
            v[i] += {name}_H[i][j] * u[j];
        for (size_t j = 0; j < {NAME}_OUTPUTS; j++)
            v[i] += {name}_K[i][j] * y[j];
    }}
    for (size_t i = 0; i < {NAME}_TRACKED; i++)
        w[i] = s->w[i] + {dt} * (y_ref[i] - y[{name}_tracked[i]]);
    if (!{name}_finite(y, {NAME}_OUTPUTS) || !{name}_finite(v, {NAME}_OBSERVER)
        || !{name}_finite(w, {NAME}_TRACKED)) {{
        s->lost++;
        return;
    }}
    for (size_t i = 0; i < {NAME}_OBSERVER; i++)
        s->v[i] = v[i];
    for (size_t i = 0; i < {NAME}_TRACKED; i++)
        s->w[i] = w[i];
    s->lost = 0;
}}

/* One sample: steps 2 to 6. */
void {name}_step({name}_state *s, const {name}_real y[{NAME}_OUTPUTS],
    const {name}_real y_ref[{NAME}_TRACKED], {name}_real u[{NAME}_MOTORS])
{{
    {name}_output(s, y, u);
    {name}_update(s, y, y_ref, u);
}}
#endif
"""

LIMITS = """
        if (u[i] > {name}_u_max[i])
            u[i] = {name}_u_max[i];
        if (u[i] < -{name}_u_max[i])
            u[i] = -{name}_u_max[i];"""


def to_c(controller, path=None, single=False, name="pendulum"):
    """The text of a self-contained C99 source file with the arithmetic of `Controller.step`.

    It holds prototypes, a state struct, ``<name>_init``, ``<name>_step`` (and its halves
    ``_output`` and ``_update``), the limits, and no allocation. What `Controller.step` does not
    meet on a simulated bench: a reading that is no number gives u = 0 and leaves the state alone.

    Parameters
    ----------
    controller : Controller with n >= 1 observer states and at least one integrator
    path : where to write the file, or None
    single : floats instead of doubles
    name : prefix of everything in the file, a C identifier

    >>> print(pl.to_c(pl.paper_design("double").controller).splitlines()[0])
    /* Sampled controller for an inverted pendulum, sampling time 0.01 s.
    """
    instance("controller", controller, Controller, "design.controller")
    if not controller.tracked:
        raise ValueError(
            "controller: expected at least one integrator, found none; C has no empty arrays."
        )
    if not (isinstance(name, str) and name.isidentifier() and name.isascii()):
        raise ValueError(f"name: expected a C identifier such as 'pendulum', {found(name)}.")
    flag("single", single)
    file = None if path is None else arguments.path("path", path)
    o = controller.observer
    matrices = dict(E=o.E, H=o.H, K=o.K, L1=o.L1, L2=o.L2, T=o.T, F=controller.F)
    if controller.u_max is not None:
        matrices["u_max"] = np.array(controller.u_max)
    source = TEMPLATE.format(
        name=name,
        NAME=name.upper(),
        real="float" if single else "double",
        dt=_literal(controller.dt, single),
        angles=o.K.shape[1] - 1,
        states=o.T.shape[1],
        outputs=o.K.shape[1],
        motors=len(controller.F),
        observer=len(o.E),
        tracked=len(controller.tracked),
        indices=", ".join(map(str, controller.tracked)),
        matrices="\n".join(_table(f"{name}_{key}", name, a, single) for key, a in matrices.items()),
        limits="" if controller.u_max is None else LIMITS.format(name=name),
    )
    if file is not None:
        try:
            file.write_text(source, encoding="ascii")
        except (OSError, ValueError) as problem:
            raise ValueError(f"path: {str(file)!r} cannot be written ({problem}).") from None
    return source


def _table(label, name, values, single):
    """A constant array of one or two dimensions."""
    size = "".join(f"[{count}]" for count in values.shape)
    rows = [", ".join(_literal(value, single) for value in row) for row in np.atleast_2d(values)]
    if values.ndim == 1:
        body = f"{{{rows[0]}}}"
    else:
        body = "{\n" + ",\n".join(f"    {{{row}}}" for row in rows) + "\n}"
    return f"static const {name}_real {label}{size} = {body};"


def _literal(value, single):
    """A C constant that reads back as the same number (as the nearest float where single)."""
    if np.isinf(value):  # an amplifier without limit: larger than any voltage
        text = "1e30" if value > 0 else "-1e30"
    else:
        if single and abs(value) > np.finfo(np.float32).max:
            raise ValueError(f"single: {value:g} is too large for a float; use doubles.")
        text = str(np.float32(value)) if single else repr(float(value))
    return text + "f" if single else text
