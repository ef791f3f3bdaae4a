"""The sampled loop: of the paper's controller inside the kernel, of any other sample by sample."""

import numpy as np

from .._arguments import array
from .inputs import called, voltages
from .plant import pack
from .tuples import Law, Memory, Rows

PATIENCE = 200_000  # integration steps, some 0.1 s: an interrupt is heard after as many


def paper_loop(bench, controller, y_ref, first):
    """The whole loop inside the kernel, with the arithmetic of `Controller.step`."""
    kernel, clock, ports = bench.kernel, bench.clock, bench.ports
    start, o = controller.start(first), controller.observer
    m, n, count = kernel.M, kernel.N, len(y_ref)
    u_max = np.full(m, np.inf) if controller.u_max is None else np.array(controller.u_max)
    matrices = [np.ascontiguousarray(a) for a in (o.E, o.H, o.K, o.L1, o.L2, controller.F)]
    law = pack(kernel, Law(*matrices, np.array(controller.tracked, dtype=np.int64), u_max))
    memory = pack(kernel, Memory(start.v.copy(), start.w.copy(), np.zeros(len(o.E))))
    rows = pack(kernel, Rows(*(np.zeros((count, k)) for k in (2 * n, n + 1, m, 2 * n))))
    y_ref, fell, done = pack(kernel, y_ref), -1.0, 0
    stretch = max(1, PATIENCE // clock.steps)
    while done < count and fell < 0:
        part = slice(done, done + stretch)
        more, fell = kernel.run(
            bench.state,
            memory,
            law,
            y_ref[part],
            clock._replace(first=done),
            bench.plant,
            bench.held,
            ports._replace(error=ports.error[part]),
            bench.work,
            Rows(*(record[part] for record in rows)),
        )
        done += more
    return done, fell, *(np.asarray(record) for record in rows)


def any_loop(bench, controller, y_ref, first):
    """Sample by sample, with any controller that has `step`."""
    kernel, clock, ports, count = bench.kernel, bench.clock, bench.ports, len(y_ref)
    n, m, x = kernel.N, kernel.M, bench.state.x
    X, y, u = (np.zeros((count, k)) for k in (2 * n, n + 1, m))
    estimate = [] if callable(getattr(controller, "estimate", None)) else None
    reading, volts = (pack(kernel, np.zeros(k)) for k in (n + 1, m))
    state, fell = None, -1.0
    if callable(getattr(controller, "start", None)):
        state = called("controller: start", 0.0, controller.start, first)
    for k in range(count):
        t = k * clock.dt
        X[k] = _relative(np.asarray(x[: 2 * n]), n)
        kernel.read(x, ports.error[k], ports.ad, bench.plant.w_out, reading)
        y[k] = reading
        if estimate is not None:
            estimate.append(_estimate(controller, state, y[k].copy(), t))
        target = float(y_ref[k, 0]) if y_ref.shape[1] == 1 else y_ref[k].copy()
        answer = called("controller: step", t, controller.step, state, y[k].copy(), target)
        volts[:], state = voltages(answer, m, t)
        kernel.send(volts, bench.state.sent, ports.da, bench.plant.limit)
        u[k] = volts
        if k + 1 < count:
            loads = bench.held[k % len(bench.held)]
            fell = kernel.hold(bench.state, t, clock, bench.plant, loads, bench.work)
            if fell >= 0:
                break
    return k + 1, fell, X, y, u, None if estimate is None else np.array(estimate)


def _estimate(controller, state, y, t):
    value = called("controller: estimate", t, controller.estimate, state, y)
    return array(f"controller: estimate at t = {t:.4g} s", value, (2 * (len(y) - 1),))


def _relative(absolute, n):
    return np.concatenate([np.diff(absolute[:n], prepend=0.0), np.diff(absolute[n:], prepend=0.0)])


def first_estimate(bench, x0):
    """x(0) as the bench knows it: the angles that its sensors read, and the rates it starts with."""
    n, ports = bench.kernel.N, bench.ports
    y = pack(bench.kernel, np.zeros(n + 1))
    bench.kernel.read(bench.state.x, ports.error[0], ports.ad, bench.plant.w_out, y)
    return np.concatenate([np.asarray(y)[:n], x0[n:]])
