"""The plant between two samples, and the sampled loop round it, as scalar code.

This text is not used as it stands: `generated.load_kernel` puts the numbers of links N and motors M
and the generated functions `constants` and `accelerate` in front of it, and numba, where present,
compiles the result; where it is not, the same text runs on lists. So it keeps to loops and floats.

The named tuples among the arguments are those of `tuples.py`. State x of the plant, all angles
absolute: link angles and rates (N each), rotor angles and rates (M each, seen at the output shaft
relative to the lower link of the hinge; used by gears with a gap), filtered outputs (N + 1).
"""
# ruff: noqa: F821  (N, M, sin, cos, exp, floor, accelerate: see above)

# Columns of `gear`, one row per motor.
GAIN, DAMPING, INERTIA, HALF_GAP, STIFFNESS, IMPACT, DRY = range(7)


def derivative(x, volts, load, anchor, plant, torque, a, dx):
    """dx/dt under the filtered voltages, amplified within limits, and the torques `load` on the links."""
    rotor, speed, filtered = 2 * N, 2 * N + M, 2 * N + 2 * M
    gear, dry, reach, w_out = plant.gear, plant.dry, plant.reach, plant.w_out
    limit = plant.limit
    for i in range(N):
        torque[i] = load[i]
        dx[i] = x[N + i]
    for i in range(N):
        if dry[i] > 0.0:
            turned = x[i] - x[i - 1] if i > 0 else x[i]
            friction = dry[i] * min(max((turned - anchor[i]) / reach, -1.0), 1.0)
            torque[i] -= friction
            if i > 0:
                torque[i - 1] += friction
    for j in range(M):
        angle = x[j + 1] - x[j]
        tau = gear[j][GAIN] * min(max(volts[j], -limit[j]), limit[j])
        dx[rotor + j] = 0.0
        dx[speed + j] = 0.0
        if gear[j][HALF_GAP] > 0.0:
            # The rotor turns by itself; the tooth pushes once the gap is closed and never pulls.
            drive = tau - gear[j][DAMPING] * x[speed + j]
            if gear[j][DRY] > 0.0:
                held = (x[rotor + j] - anchor[N + j]) / reach
                drive -= gear[j][DRY] * min(max(held, -1.0), 1.0)
            slip = x[rotor + j] - angle
            slip_rate = x[speed + j] - (x[N + j + 1] - x[N + j])
            tau = 0.0
            if slip > gear[j][HALF_GAP]:
                closing = max(1.0 + gear[j][IMPACT] * slip_rate, 0.0)
                tau = gear[j][STIFFNESS] * (slip - gear[j][HALF_GAP]) * closing
            elif slip < -gear[j][HALF_GAP]:
                closing = max(1.0 - gear[j][IMPACT] * slip_rate, 0.0)
                tau = gear[j][STIFFNESS] * (slip + gear[j][HALF_GAP]) * closing
            dx[rotor + j] = x[speed + j]
            dx[speed + j] = (drive - tau) / gear[j][INERTIA]
        elif gear[j][DRY] > 0.0:
            tau -= gear[j][DRY] * min(max((angle - anchor[N + j]) / reach, -1.0), 1.0)
        torque[j + 1] += tau
        torque[j] -= tau
    accelerate(x, x[N:], torque, plant.c, a)
    for i in range(N):
        dx[N + i] = a[i]
        measured = x[i] - x[i - 1] if i > 0 else x[i]
        dx[filtered + i] = w_out[i] * (measured - x[filtered + i])
    dx[filtered + N] = w_out[N] * (x[N] - x[filtered + N])


def drag(x, anchor, plant):
    """Let each dry contact that has slipped hold on where it is now."""
    gear, dry, reach = plant.gear, plant.dry, plant.reach
    for i in range(N):
        if dry[i] > 0.0:
            turned = x[i] - x[i - 1] if i > 0 else x[i]
            anchor[i] = min(max(anchor[i], turned - reach), turned + reach)
    for j in range(M):
        if gear[j][DRY] > 0.0:
            turned = x[2 * N + j] if gear[j][HALF_GAP] > 0.0 else x[j + 1] - x[j]
            anchor[N + j] = min(max(anchor[N + j], turned - reach), turned + reach)


def mean_load(t, h, pulses, load, held):
    """Torque on each link averaged over [t, t + h], so that a pulse keeps its impulse."""
    for i in range(N):
        load[i] = held[i]
    for k in range(len(pulses)):
        overlap = min(t + h, pulses[k][2]) - max(t, pulses[k][1])
        if overlap > 0.0:
            load[int(pulses[k][0])] += pulses[k][3] * overlap / h


def advance(state, sent, t, duration, steps, plant, held, work):
    """Integrate over `duration` with the voltages `sent`, by classical Runge-Kutta steps.

    Returns the time at which a link has passed the horizontal, or -1.
    """
    x, anchor, volts, w_in = state.x, state.anchor, state.volts, plant.w_in
    size = 3 * N + 2 * M + 1
    k1, k2, k3, k4, y = work[0], work[1], work[2], work[3], work[4]
    torque, a, load, middle, end = work[5], work[6], work[7], work[8], work[9]
    half_decay, decay = work[10], work[11]
    h = duration / steps
    for j in range(M):  # a first-order filter under a constant input is known exactly
        half_decay[j] = exp(-0.5 * h * w_in[j]) if w_in[j] > 0.0 else 0.0
        decay[j] = exp(-h * w_in[j]) if w_in[j] > 0.0 else 0.0
        if w_in[j] == 0.0:
            volts[j] = sent[j]
    for step in range(steps):
        now = t + step * h
        mean_load(now, h, plant.pulses, load, held)
        for j in range(M):
            middle[j] = sent[j] + (volts[j] - sent[j]) * half_decay[j]
            end[j] = sent[j] + (volts[j] - sent[j]) * decay[j]
        derivative(x, volts, load, anchor, plant, torque, a, k1)
        for i in range(size):
            y[i] = x[i] + 0.5 * h * k1[i]
        derivative(y, middle, load, anchor, plant, torque, a, k2)
        for i in range(size):
            y[i] = x[i] + 0.5 * h * k2[i]
        derivative(y, middle, load, anchor, plant, torque, a, k3)
        for i in range(size):
            y[i] = x[i] + h * k3[i]
        derivative(y, end, load, anchor, plant, torque, a, k4)
        for i in range(size):
            x[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])
        for j in range(M):
            volts[j] = end[j]
        drag(x, anchor, plant)
        for i in range(N):
            if not abs(x[i]) < 1.5707963267948966:
                return now + h
    return -1.0


def read(x, error, quantum, w_out, y):
    """Step 1: the N + 1 outputs, filtered where a filter is on, with errors and A/D resolution."""
    for i in range(N + 1):
        if w_out[i] > 0.0:
            y[i] = x[2 * N + 2 * M + i]
        elif i == N:
            y[i] = x[N]
        else:
            y[i] = x[i] - x[i - 1] if i > 0 else x[i]
        y[i] += error[i]
        if quantum[i] > 0.0:
            y[i] = quantum[i] * floor(y[i] / quantum[i] + 0.5)


def send(u, sent, quantum, limit):
    """Step 5: the D/A holds `sent`; u becomes what the amplifier makes of it once the filter settles."""
    for j in range(M):
        sent[j] = u[j]
        if quantum[j] > 0.0:
            sent[j] = quantum[j] * floor(u[j] / quantum[j] + 0.5)
        u[j] = min(max(sent[j], -limit[j]), limit[j])


def hold(state, t, clock, plant, held, work):
    """One sampling interval: the old voltage until the delay has passed, then the new one."""
    late, rest, fell = clock.late, clock.steps - clock.late, -1.0
    if late > 0:
        fell = advance(state, state.before, t, clock.delay, late, plant, held, work)
    if fell < 0.0 and rest > 0:
        fresh, left = t + clock.delay, clock.dt - clock.delay
        fell = advance(state, state.sent, fresh, left, rest, plant, held, work)
    for j in range(M):
        state.before[j] = state.sent[j]
    return fell


def record(k, x, X):
    """Row k of the record: relative angles, then relative rates."""
    for i in range(N):
        X[k][i] = x[i] - x[i - 1] if i > 0 else x[i]
        X[k][N + i] = x[N + i] - x[N + i - 1] if i > 0 else x[N + i]


def run(state, memory, law, y_ref, clock, plant, held, ports, work, rows):
    """The loop with the paper's controller from `clock.first` on; (rows written, a fall or -1)."""
    E, H, K, L1, L2, F = law.E, law.H, law.K, law.L1, law.L2, law.F
    tracked, u_max = law.tracked, law.u_max
    v, w, v_next = memory.v, memory.w, memory.v_next
    p, states, r = len(E), len(L1), len(tracked)
    for k in range(len(rows.X)):
        last = clock.first + k - 1
        if last >= 0:
            fell = hold(state, last * clock.dt, clock, plant, held[last % len(held)], work)
            if fell >= 0.0:
                return k, fell
        y, u, xhat = rows.Y[k], rows.U[k], rows.XH[k]
        record(k, state.x, rows.X)
        read(state.x, ports.error[k], ports.ad, plant.w_out, y)
        for i in range(states):
            total = 0.0
            for j in range(N + 1):
                total += L1[i][j] * y[j]
            for j in range(p):
                total += L2[i][j] * v[j]
            xhat[i] = total
        for j in range(M):
            total = 0.0
            for i in range(states):
                total += F[j][i] * xhat[i]
            for i in range(r):
                total += F[j][states + i] * w[i]
            u[j] = min(max(-total, -u_max[j]), u_max[j])
        for i in range(p):
            total = 0.0
            for j in range(p):
                total += E[i][j] * v[j]
            for j in range(M):
                total += H[i][j] * u[j]
            for j in range(N + 1):
                total += K[i][j] * y[j]
            v_next[i] = total
        for i in range(p):
            v[i] = v_next[i]
        for i in range(r):
            w[i] += clock.dt * (y_ref[k][i] - y[tracked[i]])
        send(u, state.sent, ports.da, plant.limit)
    return len(rows.X), -1.0
