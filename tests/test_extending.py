"""The four ways in which students extend the package, each gone once, with the worked example's code."""

import inspect
import os
import re
import shutil
import subprocess
import sys
from dataclasses import fields, replace

import control
import nbformat
import numpy as np
import pytest
from refresh_notebooks import ROOT

import pendlab as pl
from pendlab import parameters
from pendlab.classroom import exercises as paper
from pendlab.classroom.editions import student


@pytest.fixture(scope="module")
def example():
    """What the cells of notebooks/extending.ipynb define: LIGHT, Differences, Drifting."""
    notebook = nbformat.read(ROOT / "notebooks/extending.ipynb", as_version=4)
    names = {"np": np, "pl": pl, "control": control}
    for cell in notebook.cells:
        if cell.id in (
            "ext-rig-file",
            "ext-controller-class",
            "ext-controller-system",
            "ext-imperfection-class",
        ):
            exec(cell.source, names)
    return names


# ---- A rig: a data file only


@pytest.fixture
def rig_folder(example, tmp_path, monkeypatch):
    """A data folder with one rig more than the package's."""
    folder = tmp_path / "rigs"
    folder.mkdir()
    for name in pl.rigs():
        source = parameters.DATA / "rigs" / f"{name}.toml"
        (folder / source.name).write_text(source.read_text(encoding="utf-8"), encoding="utf-8")
    (folder / "light.toml").write_text(example["LIGHT"], encoding="utf-8")
    monkeypatch.setattr(parameters, "DATA", tmp_path)
    return folder


def test_a_file_in_the_rigs_folder_is_a_rig(rig_folder):
    assert pl.rigs() == ["double", "light", "triple"]
    assert pl.load("light") == pl.load(rig_folder / "light.toml")


def test_new_rig_is_designed_for_and_stands(rig_folder):
    rig = pl.load("light")
    design = pl.Design(rig, Q=(0.1, 100, 0, 0.01, 1), R=(3,), E=(0.9,))
    assert np.abs(pl.closed_loop_eigenvalues(design.nominal_loop)).max() < 1
    run = pl.simulate(rig, design.controller, 100.0, initial=(0.02, 0.0), reference=0.05)
    assert not run.fell and run.angles[-1, 1] == pytest.approx(0.05, abs=1e-4)


@pytest.mark.parametrize(
    "old, new, words",
    [
        ('unit = "kg m^2", source = "guess"', 'unit = "g m^2", source = "guess"', r"'kg m\^2'"),
        ("mass     = {value = 0.30", "mass     = {value = -0.30", "Link mass"),
        ("damping =", "dampng =", "'damping'"),
    ],
)
def test_damaged_new_rig_is_named_with_its_entry(rig_folder, old, new, words):
    path = rig_folder / "light.toml"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(ValueError, match=words) as error:
        pl.load("light")
    assert "light.toml" in str(error.value)


@pytest.mark.parametrize("name", pl.rigs())
def test_every_rig_file_gives_a_model_that_motors_reach(name):
    model = pl.sample(pl.linearize(pl.load(name)))
    distance, _ = pl.distance_to_uncontrollability(model.A, model.B)
    assert distance > 1e-6


# ---- A controller: any object with step


class FromScratch:
    """Equations (29) and (30) written out, for a rig with one motor and H = 0."""

    def __init__(self, design):
        self.design = design

    def start(self, x0):
        observer = self.design.observer
        return observer.T @ x0, 0.0

    def step(self, state, y, y_ref):
        (v, w), o, F = state, self.design.observer, self.design.F
        u = -F @ np.append(o.L1 @ y + o.L2 @ v, w)
        u = np.clip(u, -np.array(self.design.rig.u_max), self.design.rig.u_max)
        return u, (o.E @ v + o.K @ y, w + self.design.dt * (y_ref - y[1]))


def test_own_controller_does_what_the_same_equations_do_in_the_package(double_design):
    rig = double_design.rig
    case = dict(initial=(0.02, -0.01), reference=0.1, imperfections=pl.bench_imperfections(rig))
    own = pl.simulate(rig, FromScratch(double_design), 1.0, **case)
    known = pl.simulate(rig, double_design.controller, 1.0, **case)
    np.testing.assert_allclose(own.u, known.u, atol=1e-9)
    np.testing.assert_allclose(own.angles, known.angles, atol=1e-9)


def test_own_controller_as_a_system_is_what_it_does_step_by_step(example, double_design):
    """The four matrices of the worked example against its `step`, and margins from `open_loop`."""
    F, dt = double_design.F, double_design.dt
    controller, system = example["Differences"](F, dt, (np.inf,)), example["as_system"](F, dt)
    state, x, rng = (0.0, 0.0), np.zeros(2), np.random.default_rng(0)
    for _ in range(20):
        y = rng.standard_normal(3)
        u, state = controller.step(state, y, 0.0)
        np.testing.assert_allclose(u, system.C @ x + system.D @ y)
        x = system.A @ x + system.B @ y
    ours = pl.open_loop(double_design.controller.system, double_design.filtered)
    known = pl.open_loop(double_design.controller, double_design.filtered)
    np.testing.assert_allclose(ours.A, known.A)
    np.testing.assert_allclose(ours.C, known.C)
    with pytest.raises(ValueError, match="controller"):
        pl.open_loop(double_design.plant, double_design.filtered)


def test_own_controller_keeps_no_state_between_runs(example, double_design):
    rig = double_design.rig
    simple = example["Differences"](double_design.F, double_design.dt, rig.u_max)
    on = pl.bench_imperfections(rig)
    one, two = (
        pl.simulate(rig, simple, 5.0, initial=pl.bench_start(rig), imperfections=on)
        for _ in range(2)
    )
    np.testing.assert_array_equal(one.u, two.u)
    assert not one.fell


def test_simple_controller_is_right_about_a_slow_motion(example, double_design):
    """The difference of readings is the mean rate over a sample."""
    F, dt = double_design.F, 0.01
    controller = example["Differences"](F, dt, (np.inf,))
    u, _ = controller.step((0.03, 0.0), np.array([0.01, 0.035, 0.2]), 0.0)
    np.testing.assert_allclose(u, -F @ np.array([0.01, 0.035, 0.2, 0.5, 0.0]))


# ---- An imperfection: round the controller, beside the rig, or in the simulator


def test_wrapped_controller_without_drift_is_the_controller(example, design):
    rig, none = design.rig, np.zeros(design.rig.n_links + 1)
    wrapped = example["Drifting"](design.controller, none, none)
    one, two = (pl.simulate(rig, c, 2.0, reference=0.05) for c in (wrapped, design.controller))
    np.testing.assert_allclose(one.angles, two.angles, atol=1e-9)


def test_constant_wrapper_is_the_known_offset(example, design):
    rig = design.rig
    b = np.array([0.003, -0.002, 0.001, 0.0])[-rig.n_links - 1 :]
    wrapped = example["Drifting"](design.controller, 0 * b, b)
    start = 0.01 * np.eye(rig.n_links)[0]
    one = pl.simulate(rig, wrapped, 2.0, initial=start)
    two = pl.simulate(
        rig, design.controller, 2.0, initial=start, imperfections=pl.Imperfections(offset=tuple(b))
    )
    np.testing.assert_allclose(one.angles, two.angles, atol=1e-8)
    np.testing.assert_allclose(one.y + b, two.y, atol=1e-8)


def test_drift_leaves_an_error_in_proportion(example, double_design):
    """One integrator follows a constant; a ramp leaves a constant error, linear in its slope."""
    left = []
    for slope in (1e-5, 1e-4):
        wrapped = example["Drifting"](double_design.controller, (slope, 0, 0))
        run = pl.simulate(double_design.rig, wrapped, 120.0)
        left.append(run.angles[-1, 1] / slope)
    assert left[0] == pytest.approx(left[1], rel=5e-3) and abs(left[0]) > 100


def test_disturbance_and_another_rig_need_no_class(double_design):
    rig, controller = double_design.rig, double_design.controller
    assert pl.simulate(rig, controller, 5.0, disturbance=lambda t: [0.0, 10.0]).fell
    (motor,) = rig.motors
    weak = replace(rig, motors=(replace(motor, gain=0.7 * motor.gain),))
    one, two = (pl.simulate(r, controller, 1.0, initial=(0.01, 0.0)) for r in (rig, weak))
    assert np.abs(one.angles - two.angles).max() > 1e-3 and not two.fell


# Each entry of pl.Imperfections: what must be on for it to matter, and a value that shows.
SHOWS = {
    "filters": ({}, True),
    "saturation": ({}, True),
    "resolution": ({}, 2e-3),
    "voltage_resolution": ({}, 0.5),
    "delay": ({}, 0.005),
    "offset": ({}, 0.002),
    "noise": ({}, 1e-3),
    "seed": (dict(noise=1e-3), 1),
    "hinge_friction": ({}, 0.05),
    "gear_friction": ({}, 0.5),
    "gap": ({}, 0.02),
    "contact_stiffness": (dict(gap=0.02), 300.0),
    "contact_damping": (dict(gap=0.02), 0.1),
    "presliding": (dict(gear_friction=0.5), 1e-2),
    "start_torque": ({}, 0.02),
    "start_torque_time": (dict(start_torque=0.02), 1.0),
}


def strong_push(imperfections, double_design):
    """The double, unlimited by its controller, from a lean that takes more than its voltage."""
    controller = replace(double_design.controller, u_max=None)
    case = dict(initial=(0.04, 0.0), imperfections=imperfections)
    return pl.simulate(double_design.rig, controller, 1.0, **case).angles


SWITCHES = [field.name for field in fields(pl.Imperfections)]


def test_every_imperfection_is_tried_here():
    assert set(SHOWS) == set(SWITCHES)


@pytest.mark.parametrize("name", SWITCHES)
def test_imperfection_is_off_by_default_and_has_an_effect(name, double_design):
    needed, value = SHOWS[name]
    without = strong_push(pl.Imperfections(**needed), double_design)
    with_it = strong_push(pl.Imperfections(**needed | {name: value}), double_design)
    rows = min(len(without), len(with_it))
    assert np.abs(without[:rows] - with_it[:rows]).max() > 1e-6
    if not needed:
        np.testing.assert_array_equal(without, strong_push(None, double_design))


@pytest.mark.parametrize("field", fields(pl.Imperfections), ids=lambda field: field.name)
def test_imperfection_is_documented_and_off_at_zero(field):
    text = inspect.getdoc(pl.Imperfections)
    entries = text[text.index("Parameters\n") : text.index("Notes\n")]
    line = re.search(rf"^{field.name} : (.+)$", entries, re.M)
    assert line and len(line[1]) > 8
    describes_another = {"seed", "contact_stiffness", "contact_damping", "presliding"}
    describes_another.add("start_torque_time")
    assert field.name in describes_another or not field.default


# ---- From outside: a copy of the repository with a rig and a notebook more, tried by the one command


@pytest.fixture(scope="module")
def copy(example, tmp_path_factory):
    """The repository as a student has it after adding ``light`` and a notebook about it."""
    folder = tmp_path_factory.mktemp("copy") / "pendlab"
    for part in ("pendlab", "data", "tests", "notebooks"):
        ignored = shutil.ignore_patterns("__pycache__", ".ipynb_checkpoints", "_build")
        shutil.copytree(ROOT / part, folder / part, ignore=ignored)
    for name in ("pyproject.toml", "conftest.py", "environment.txt", "README.md", "CHANGELOG.md"):
        shutil.copy(ROOT / name, folder / name)
    (folder / "data/rigs/light.toml").write_text(example["LIGHT"], encoding="utf-8")
    template = (folder / "notebooks/own/template.ipynb").read_text(encoding="utf-8")
    mine = template.replace("rig = pl.my_rig(name)", 'rig = pl.load(\\"light\\")')
    mine = mine.replace("template.ipynb", "mine.ipynb").replace(
        "pl.figure(8, design)", "pl.figure(7, design)"
    )
    mine = mine.replace("(False, True)]", "(False,)]").replace(
        "with {distances[1]:.3f}", "rig {rig.name}"
    )
    mine = mine.replace("design.filtered_loop", "design.nominal_loop")
    (folder / "notebooks/own/mine.ipynb").write_text(mine, encoding="utf-8")
    return folder


def run_in(folder, *command):
    environment = os.environ | {"PYTHONPATH": str(folder), "PYTEST_ADDOPTS": ""}
    return subprocess.run(
        [sys.executable, *command], cwd=folder, env=environment, capture_output=True, text=True, timeout=600
    )  # fmt: skip


def test_one_command_tries_a_notebook_about_a_new_rig(copy):
    done = run_in(copy, "tests/try_notebook.py", "notebooks/own/mine.ipynb")
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-2000:]
    stored = nbformat.read(copy / "notebooks/own/mine.ipynb", as_version=4)
    assert "2 links, 1 motor, at most 12 V" in str(stored.cells)
    gap = next(cell for cell in student(stored).cells if cell.id == "own-ex1-solution")
    assert "recoverable_tilt" not in gap.source and "lean = ..." in gap.source
    (exercise,) = paper.exercises(student(stored))
    assert exercise.name == "own.1" and exercise.points == 2


def test_one_command_names_what_is_wrong(copy):
    path = copy / "notebooks/own/bad.ipynb"
    text = (copy / "notebooks/own/template.ipynb").read_text(encoding="utf-8")
    text = text.replace("../extending.ipynb", "../nowhere.ipynb")
    path.write_text(text.replace("(5 min): how far", "(7 min): how far"), encoding="utf-8")
    done = run_in(copy, "tests/try_notebook.py", "notebooks/own/bad.ipynb")
    path.unlink()
    assert done.returncode != 0
    assert "links to ../nowhere.ipynb" in done.stdout and "AssertionError: own.1" in done.stdout


def test_a_rig_and_a_notebook_more_break_no_test_that_counts_them(copy):
    (copy / "notebooks/07_mine.ipynb").write_text(
        (copy / "notebooks/own/template.ipynb").read_text(encoding="utf-8").replace("](../", "]("),
        encoding="utf-8",
    )
    tests = [f"tests/test_{name}.py" for name in ("parameters", "labs")]
    done = run_in(copy, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *tests)
    (copy / "notebooks/07_mine.ipynb").unlink()
    assert done.returncode == 0, done.stdout[-3000:]


# ---- The page that tells how


def test_places_named_in_the_texts_exist():
    notebook = nbformat.read(ROOT / "notebooks/extending.ipynb", as_version=4)
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    extending = page[page.index("## Extending") :]
    texts = [extending, *(c.source for c in notebook.cells if c.cell_type == "markdown")]
    named = set(re.findall(r"`((?:pendlab|tests|data|notebooks)/[\w./-]+)`", "\n".join(texts)))
    assert {
        "pendlab/bench/imperfections.py",
        "pendlab/bench/kernel.py",
        "tests/test_extending.py",
    } <= named
    invented = {
        "data/rigs/name.toml",
        "pendlab/classroom/checks/nb07.py",
        "notebooks/own/my_pendulum.ipynb",
    }
    assert [path for path in sorted(named - invented) if not (ROOT / path).exists()] == []
    assert "(notebooks/extending.ipynb)" in extending
