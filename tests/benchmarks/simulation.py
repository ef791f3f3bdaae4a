"""Benchmark of the simulator: ``python tests/benchmarks/simulation.py``.

37 s of the triple pendulum with every imperfection on, each measured several times in this one run,
against the same equations as a plain C program with the same step (needs a C compiler),
scipy's solve_ivp called sample by sample, and MuJoCo stepping the rigid linkage (needs mujoco).
Then 1000 runs of 10 s, the time per control step, and the first simulation of a second session.
"""

import ctypes
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import pendlab as pl
from pendlab.bench.generated import load_kernel
from pendlab.bench.plant import integration, plant_numbers

HERE = Path(__file__).parent
T_END = 37.0


def best(function, repeats=7):
    """Shortest time of several calls, s, and the last result."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        result = function()
        times.append(time.perf_counter() - start)
    return min(times), result


def bench():
    rig = pl.load("triple")
    return (
        rig,
        pl.paper_design("triple").controller,
        pl.bench_imperfections(rig),
        pl.bench_start(rig),
    )


def in_c(flags):
    """(time, angles) of the plain C program, or None without a compiler."""
    compiler = next((c for c in ("cc", "gcc", "clang") if shutil.which(c)), None)
    if compiler is None:
        return None
    rig, c, on, start = bench()
    o, numbers = c.observer, plant_numbers(rig, on)
    links = [[getattr(k, f) for k in rig.links] for f in
             ("length", "mass", "inertia", "com", "friction")]  # fmt: skip
    motors = [[getattr(k, f) for k in rig.motors] for f in ("gain", "damping", "inertia")]
    gears = [
        on.each(f, 2) for f in ("gap", "contact_stiffness", "contact_damping", "gear_friction")
    ]
    rows = round(T_END / c.dt) + 1
    clock = integration(rig, on, c.dt, rows)
    x0 = np.concatenate([start, np.zeros(3)])
    ad = on.each("resolution", 4)
    read = ad[:3] * np.floor((x0[:3] + on.each("offset", 4)[:3]) / ad[:3] + 0.5)
    v0 = o.T @ np.concatenate([read, np.zeros(3)])
    assert not np.any(on.each("noise", 4)) and np.abs(o.H).max() < 1e-9
    parts = [*links, rig.g, *motors, *gears, numbers.dry, numbers.reach, numbers.w_in,
             numbers.w_out, on.each("offset", 4), ad, rig.u_max, on.each("voltage_resolution", 2),
             c.u_max, o.E, o.K, o.L1, o.L2, c.F, c.dt, on.delay, v0, x0]  # fmt: skip
    setup = np.concatenate([np.ravel(part) for part in parts]).astype(float)
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "triple.so"
        command = [compiler, "-std=c99", *flags, "-shared", "-fPIC", str(HERE / "triple.c"), "-o",
                   str(library), "-lm"]  # fmt: skip
        subprocess.run(command, check=True)
        run = ctypes.CDLL(str(library)).run
    out = np.zeros((rows, 5))
    pointer = lambda a: a.ctypes.data_as(ctypes.c_void_p)  # noqa: E731
    seconds, done = best(lambda: run(pointer(setup), rows, clock.late, clock.steps, pointer(out)))
    return seconds, out[:done, :3]


def by_solve_ivp(t_end):
    """The kernel's own right-hand side, compiled, under solve_ivp; dry contacts move per sample."""
    rig, c, on, start = bench()
    kernel, numbers = load_kernel(3, 2), plant_numbers(rig, on)
    x0 = np.array(start)
    x = np.concatenate([np.cumsum(x0), np.zeros(3), x0[1:], np.zeros(2), x0, [0.0]])
    anchor, torque, a, dx, load = (np.zeros(k) for k in (5, 3, 3, 14, 3))
    anchor[:] = [*x0, *x0[1:]]
    state = c.start(np.concatenate([x0, np.zeros(3)]))
    volts = np.zeros(2)

    def slope(t, z):  # the state with the two input filters at its end
        kernel.derivative(z, z[14:], load, anchor, numbers, torque, a, dx)
        return np.concatenate([dx, numbers.w_in * (u - z[14:])])

    z = np.concatenate([x, volts])
    for _ in range(round(t_end / c.dt)):
        u, state = c.step(state, z[10:14])
        z = solve_ivp(slope, (0, c.dt), z, rtol=1e-6, atol=1e-8).y[:, -1]
        kernel.drag(z, anchor, numbers)


def by_mujoco():
    """The rigid linkage, 1 ms Runge-Kutta steps, controller in Python every 10 steps; or None."""
    try:
        import mujoco
    except ImportError:
        return None
    sys.path.insert(0, str(HERE.parent))
    from test_simulation_plant import mujoco_xml

    rig, c, _, start = bench()
    model = mujoco.MjModel.from_xml_string(mujoco_xml(rig))

    def run():
        data = mujoco.MjData(model)
        data.qpos[:] = start
        state = c.start(np.concatenate([start, np.zeros(3)]))
        for _ in range(round(T_END / c.dt)):
            y = np.concatenate([data.qpos, data.qvel[:1]])
            data.ctrl[:], state = c.step(state, y)
            mujoco.mj_step(model, data, 10)

    return best(run, 3)[0]


def second_session():
    """Time from a warm cache to the first result of a new Python, after its imports."""
    code = (
        "import pendlab as pl, time; rig = pl.load('triple'); c = pl.paper_design('triple')"
        ".controller; t = time.perf_counter(); pl.simulate(rig, c, 1.0); "
        "print(time.perf_counter() - t)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(out.stdout)


def main():
    rig, c, on, start = bench()
    everything = dict(initial=start, imperfections=on)
    pl.simulate(rig, c, 0.1, **everything)  # compile
    ours, run = best(lambda: pl.simulate(rig, c, T_END, **everything))
    print(f"{T_END:g} s of the triple, everything on, inner step {run.inner_step * 1e3:.3g} ms")
    print(f"  pendlab                       {ours * 1e3:8.1f} ms")
    for flags in (["-O2"], ["-O3", "-march=native"]):
        reference = in_c(flags)
        if reference is None:
            print("  C: no compiler found")
            break
        seconds, angles = reference
        apart = np.abs(angles[:101] - run.angles[:101]).max()
        label = "plain C, " + " ".join(flags)
        print(f"  {label:29} {seconds * 1e3:8.1f} ms   ratio {ours / seconds:6.2f}   "
              f"(angles of the first second agree to {apart:.0e} rad)")  # fmt: skip
    slow = best(lambda: by_solve_ivp(T_END / 10), 1)[0] * 10
    print(f"  solve_ivp sample by sample    {slow * 1e3:8.0f} ms   ratio {ours / slow:6.4f}")
    ideal, _ = best(lambda: pl.simulate(rig, c, T_END, initial=start))
    print(f"{T_END:g} s of the rigid triple, nothing on, inner step 1 ms")
    print(f"  pendlab                       {ideal * 1e3:8.1f} ms")
    mujoco = by_mujoco()
    if mujoco is None:
        print("  MuJoCo: not installed")
    else:
        print(
            f"  MuJoCo, controller in Python  {mujoco * 1e3:8.0f} ms   ratio {ideal / mujoco:6.4f}"
        )
    cases = [dict(disturbance=pl.Pulse(1 + k % 3, 1.0, 0.1, 0.001 * k)) for k in range(1000)]
    many, _ = best(lambda: pl.simulate_many(rig, c, 10.0, cases, **everything, progress=False), 1)
    print(f"1000 runs of 10 s, everything on: {many:.1f} s")
    state, y = c.start(), np.zeros(4)
    step, _ = best(lambda: [c.step(state, y) for _ in range(1000)])
    print(f"control step in Python: {step * 1e3:.1f} us")
    print(f"first simulation of a second session: {second_session():.2f} s after the imports")


if __name__ == "__main__":
    main()
