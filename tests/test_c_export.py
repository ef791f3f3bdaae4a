"""The exported C controller against the Python one, sample by sample."""

import dataclasses
import shutil
import subprocess

import numpy as np
import pytest

import pendlab as pl

COMPILER = next((c for c in ("cc", "gcc", "clang") if shutil.which(c)), None)
needs_compiler = pytest.mark.skipif(
    COMPILER is None, reason="needs a C compiler (cc, gcc or clang)"
)

FLAGS = "-std=c99 -ffp-contract=off -pedantic -Wall -Wextra -Wconversion -Wmissing-prototypes -Werror".split()

# Reads the initial state, then y and y_ref per sample; writes u. The halves of `step`, called one by
# one as on a bench, do the same.
MAIN = """
#include <stdio.h>
#include <string.h>
int main(void)
{
    pendulum_state s, t;
    pendulum_real h[PENDULUM_MOTORS];
    pendulum_real x0[PENDULUM_STATES], y[PENDULUM_OUTPUTS], r[PENDULUM_TRACKED], u[PENDULUM_MOTORS];
    double value;
    for (int i = 0; i < PENDULUM_STATES; i++) {
        if (scanf("%lf", &value) != 1) return 1;
        x0[i] = (pendulum_real)value;
    }
    pendulum_init(&s, x0);
    pendulum_init(&t, x0);
    for (;;) {
        for (int i = 0; i < PENDULUM_OUTPUTS + PENDULUM_TRACKED; i++) {
            if (scanf("%lf", &value) != 1) return 0;
            if (i < PENDULUM_OUTPUTS) y[i] = (pendulum_real)value;
            else r[i - PENDULUM_OUTPUTS] = (pendulum_real)value;
        }
        pendulum_step(&s, y, r, u);
        pendulum_output(&t, y, h);
        pendulum_update(&t, y, r, h);
        if (memcmp(u, h, sizeof u) || memcmp(s.v, t.v, sizeof s.v) || memcmp(s.w, t.w, sizeof s.w))
            return 2;
        for (int i = 0; i < PENDULUM_MOTORS; i++) printf("%.17g ", (double)u[i]);
        printf("\\n");
    }
}
"""


def run_in_c(source, folder, x0, rows):
    (folder / "main.c").write_text(source + MAIN)
    subprocess.run(
        [COMPILER, *FLAGS, "-O2", "main.c", "-o", "main"], cwd=folder, check=True,
        capture_output=True, text=True,
    )  # fmt: skip
    text = "\n".join(" ".join(map(repr, map(float, row))) for row in [x0, *rows])
    out = subprocess.run([folder / "main"], input=text, capture_output=True, text=True, check=True)
    return np.array([line.split() for line in out.stdout.splitlines()], dtype=float)


@pytest.fixture(scope="module")
def recorded():
    """A run of the triple with all but noise on, pushed until its amplifiers saturate."""
    rig, controller = pl.load("triple"), pl.paper_design("triple").controller
    changes = dict(voltage_resolution=0.0, offset=0.0, noise=0.0)
    bench = dataclasses.replace(pl.bench_imperfections(rig), **changes)
    run = pl.simulate(
        rig, controller, 8.0, initial=(0.01, 0.0, 0.0), reference=lambda t: 0.1 * (t > 4),
        imperfections=bench, disturbance=pl.Pulse(3, 1.0, 0.1, 0.7),
    )  # fmt: skip
    assert not run.fell and run.saturated[0] > 0
    return controller, run


def rounding(controller, run, eps):
    """Volts by which u may differ in arithmetic of precision eps: its terms are large and cancel."""
    o, n = controller.observer, run.estimate.shape[1]
    terms = np.abs(run.y) @ np.abs(o.L1.T) + np.abs(run.estimate @ o.T.T) @ np.abs(o.L2.T)
    return 10 * eps * (terms @ np.abs(controller.F[:, :n].T)).max()


@needs_compiler
def test_whole_run_equals_the_python_controller(recorded, tmp_path):
    controller, run = recorded
    x0 = np.concatenate([run.y[0, :3], np.zeros(3)])
    state, expected = controller.start(x0), []
    for y, y_ref in zip(run.y, run.y_ref):
        u, state = controller.step(state, y, y_ref)
        expected.append(u)
    rows = np.hstack([run.y, run.y_ref])
    u = run_in_c(pl.to_c(controller), tmp_path, x0, rows)
    atol = rounding(controller, run, np.finfo(float).eps)
    assert atol < 1e-9
    np.testing.assert_allclose(u, expected, rtol=0, atol=atol)  # BLAS adds in another order
    np.testing.assert_array_equal(u, run.u)


@needs_compiler
def test_an_observer_that_hears_of_u_equals_the_simulator(triple_design, tmp_path):
    """H is not zero here, so that u, limited, counts in the update; two references are tracked."""
    model, rng = triple_design.model, np.random.default_rng(3)
    observer = pl.luenberger(model, [0.5, 0.6], rng.standard_normal((2, 4)))
    F = pl.lqr(pl.add_integrator(model, [1, 2]), np.ones(8), [1, 1])
    controller = pl.controller(F, observer, tracked=(1, 2), u_max=(3e-4, 3e-4))
    y_ref = 0.01 * rng.standard_normal((101, 2))
    run = pl.simulate(triple_design.rig, controller, 1.0, reference=y_ref)
    assert np.all(np.abs(run.u).max(axis=0) == controller.u_max) and np.ptp(run.u) > 0
    u = run_in_c(pl.to_c(controller), tmp_path, np.zeros(6), np.hstack([run.y, run.y_ref]))
    np.testing.assert_array_equal(u, run.u)


@needs_compiler
def test_single_precision_stays_close(recorded, tmp_path):
    controller, run = recorded
    x0 = np.concatenate([run.y[0, :3], np.zeros(3)])
    rows = np.hstack([run.y, run.y_ref])
    u = run_in_c(pl.to_c(controller, single=True), tmp_path, x0, rows)
    atol = rounding(controller, run, np.finfo(np.float32).eps)
    assert 0 < np.abs(u - run.u).max() < atol < 0.5  # volts


def test_file_is_written_and_needs_no_allocation(tmp_path):
    controller = pl.paper_design("double").controller
    source = pl.to_c(controller, tmp_path / "controller.c", single=True)
    assert (tmp_path / "controller.c").read_text() == source
    assert "malloc" not in source and "double" not in source.split("*/", 1)[1]


def test_controller_without_limits_writes_none():
    controller = dataclasses.replace(pl.paper_design("double").controller, u_max=None)
    assert "u_max" not in pl.to_c(controller)


@pytest.mark.parametrize("name", ["2nd", "my-controller", "größe", 3])
def test_bad_prefix_is_named(name):
    with pytest.raises(ValueError, match="name: expected a C identifier"):
        pl.to_c(pl.paper_design("double").controller, name=name)


def test_other_objects_are_refused():
    with pytest.raises(TypeError, match=r"controller: expected a pl\.Controller"):
        pl.to_c(pl.load("double"))


@pytest.fixture(params=[False, True], ids=["double", "single"])
def source(request, recorded):
    return pl.to_c(recorded[0], single=request.param)


@needs_compiler
@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", [0, 2, 3, 4], ids=["angle 1", "angle 3", "rate", "y_ref"])
def test_a_reading_that_is_no_number_is_survived(recorded, source, tmp_path, column, broken):
    """Readings: no voltage for that sample; y_ref too: the state stays, the next sample is good."""
    controller, run = recorded
    x0 = np.concatenate([run.y[0, :3], np.zeros(3)])
    rows = np.hstack([run.y, run.y_ref])[:60]
    bad = rows.copy()
    bad[30, column] = broken
    u, kept = (run_in_c(source, tmp_path, x0, r) for r in (bad, np.delete(rows, 30, axis=0)))
    assert np.array_equal(u[:30], kept[:30]) and np.array_equal(u[31:], kept[30:])
    assert np.array_equal(u[30], [0, 0]) == (column < 4)
    assert np.all(np.isfinite(u)) and np.all(np.abs(u) <= np.float32(controller.u_max))


@needs_compiler
def test_a_start_that_is_no_number_counts_as_upright(recorded, source, tmp_path):
    _, run = recorded
    rows = np.hstack([run.y, run.y_ref])[:20]
    broken, upright = (
        run_in_c(source, tmp_path, x0, rows) for x0 in ([np.nan, *[0.1] * 5], np.zeros(6))
    )
    assert np.array_equal(broken, upright)


@needs_compiler
def test_lost_samples_are_counted_until_a_good_one(tmp_path):
    source = pl.to_c(pl.paper_design("double").controller)
    main = """
int main(void)
{
    pendulum_state s;
    double x0[4] = {0, 0, 0, 0}, good[3] = {0, 0, 0}, bad[3] = {0, 0, 0}, r[1] = {0}, u[1];
    bad[1] = 0.0 / good[1];
    pendulum_init(&s, x0);
    pendulum_step(&s, bad, r, u);
    pendulum_step(&s, bad, r, u);
    if (s.lost != 2 || !(u[0] <= 0 && u[0] >= 0)) return 1;
    pendulum_step(&s, good, r, u);
    return s.lost != 0;
}
"""
    (tmp_path / "main.c").write_text(source + main)
    subprocess.run([COMPILER, *FLAGS, "main.c", "-o", "main"], cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"]).returncode == 0


@needs_compiler
@pytest.mark.parametrize("name, single", [("double", False), ("triple", True)])
def test_the_struct_is_as_wide_as_what_it_counts_and_holds(tmp_path, name, single):
    """Reals of the named precision and no padding but the counter's; twelve minutes lost, counted."""
    controller = pl.paper_design(name).controller
    source = pl.to_c(controller, single=single)
    reals, width = len(controller.observer.E) + len(controller.tracked), 4 if single else 8
    main = """
#include <stdio.h>
int main(void)
{
    static const pendulum_real x0[PENDULUM_STATES], r[PENDULUM_TRACKED], zero;
    pendulum_real y[PENDULUM_OUTPUTS] = {0}, u[PENDULUM_MOTORS];
    pendulum_state s;
    y[0] = 1 / zero;
    pendulum_init(&s, x0);
    for (long n = 0; n < 72000; n++)
        pendulum_step(&s, y, r, u);
    printf("%u %d %d %d", s.lost, (int)sizeof s.lost, (int)(sizeof s.v + sizeof s.w), (int)sizeof s);
    return !((pendulum_state){.lost = 0}.lost - 1 > 0); /* unsigned */
}
"""
    (tmp_path / "main.c").write_text(source + main)
    subprocess.run([COMPILER, *FLAGS, "main.c", "-o", "main"], cwd=tmp_path, check=True)
    out = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout
    lost, counter, held, whole = map(int, out.split())
    assert lost == 72000 and counter == 4 and held == reals * width
    assert whole == -(-(held + counter) // width) * width


@needs_compiler
def test_other_files_take_its_prototypes(tmp_path):
    """Two files make one program; what `update` reads is const, in the order that `step` has."""
    pl.to_c(pl.paper_design("double").controller, tmp_path / "controller.c")
    (tmp_path / "main.c").write_text("""
#define PENDULUM_PROTOTYPES_ONLY
#include "controller.c"
static void (*const update)(pendulum_state *, const double *, const double *, const double *)
    = pendulum_update;
static void (*const step)(pendulum_state *, const double *, const double *, double *)
    = pendulum_step;
int main(void) { return !(update && step); }
""")
    subprocess.run(
        [COMPILER, *FLAGS, "main.c", "controller.c", "-o", "main"], cwd=tmp_path, check=True
    )


@pytest.mark.parametrize("name, angles", [("double", 2), ("triple", 3)])
def test_comments_tell_what_is_inside(name, angles):
    design = pl.paper_design(name)
    slow = dataclasses.replace(design.controller, dt=0.02)
    head = pl.to_c(slow).split("#ifndef")[0]
    assert "sampling time 0.02 s" in head
    assert f"y: {angles} relative angles, then the rate of the lowest link (rad, rad/s)" in head
    for word in ("u: volts", "y_ref: rad", "codes", "no anti-windup", "finite", "-ffast-math"):
        assert word in head


def test_file_that_cannot_be_written_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"path: .*cannot be written"):
        pl.to_c(pl.paper_design("double").controller, tmp_path / "nowhere" / "c.c")


def test_numbers_beyond_a_float_are_refused():
    controller = pl.paper_design("double").controller
    large = dataclasses.replace(controller, F=1e38 * controller.F)
    assert "e+4" in pl.to_c(large)
    with pytest.raises(ValueError, match=r"single: .* too large for a float"):
        pl.to_c(large, single=True)


def test_a_controller_without_integrator_is_refused():
    controller = pl.paper_design("double").controller
    with pytest.raises(ValueError, match="integrator"):
        pl.to_c(dataclasses.replace(controller, F=controller.F[:, :4], tracked=()))
