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
    X, y, u = (pack(kernel, np.zeros((count, k))) for k in (2 * n, n + 1, m))
    estimate = [] if callable(getattr(controller, "estimate", None)) else None
    state, fell = None, -1.0
    if callable(getattr(controller, "start", None)):
        state = called("controller: start", 0.0, controller.start, first)
    for k in range(count):
        t = k * clock.dt
        kernel.record(k, x, X)
        kernel.read(x, ports.error[k], ports.ad, bench.plant.w_out, y[k])
        if estimate is not None:
            xhat = called("controller: estimate", t, controller.estimate, state, np.array(y[k]))
            estimate.append(array(f"controller: estimate at t = {t:.4g} s", xhat, (2 * n,)))
        target = float(y_ref[k, 0]) if y_ref.shape[1] == 1 else y_ref[k].copy()
        answer = called("controller: step", t, controller.step, state, np.array(y[k]), target)
        u[k][:], state = voltages(answer, m, t)
        kernel.send(u[k], bench.state.sent, ports.da, bench.plant.limit)
        if k + 1 < count:
            loads = bench.held[k % len(bench.held)]
            fell = kernel.hold(bench.state, t, clock, bench.plant, loads, bench.work)
            if fell >= 0:
                break
    estimates = None if estimate is None else np.array(estimate)
    return k + 1, fell, *map(np.asarray, (X, y, u)), estimates


def first_estimate(bench, x0):
    """x(0) as the bench knows it: the angles that its sensors read, and the rates it starts with."""
    n, ports = bench.kernel.N, bench.ports
    y = pack(bench.kernel, np.zeros(n + 1))
    bench.kernel.read(bench.state.x, ports.error[0], ports.ad, bench.plant.w_out, y)
    return np.concatenate([np.asarray(y)[:n], x0[n:]])
