"""The four ways in which students extend the package, each gone once, with the worked example's code."""

import inspect
import re
from dataclasses import fields, replace

import nbformat
import numpy as np
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook
from refresh_notebooks import ROOT, refresh
from test_notebooks import problems

import pendlab as pl
from pendlab import parameters
from pendlab.bench.imperfections import switches
from pendlab.classroom import exercises as paper
from pendlab.classroom.editions import student


@pytest.fixture(scope="module")
def example():
    """What the cells of notebooks/extending.ipynb define: LIGHT, Differences, Drifting."""
    notebook = nbformat.read(ROOT / "notebooks/extending.ipynb", as_version=4)
    names = {"np": np, "pl": pl}
    for cell in notebook.cells:
        if cell.id in ("ext-rig-file", "ext-controller-class", "ext-imperfection-class"):
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


def test_every_imperfection_is_tried_here():
    assert set(SHOWS) == set(switches())


@pytest.mark.parametrize("name", switches())
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


# ---- A notebook: stored by the one command, passed by the audit


def small_notebook():
    """Title, eight short cells and one exercise with a check that the package has."""
    cells = [
        new_markdown_cell("# My pendulum\n\n[Start](00_start_here.ipynb)", id="07-title"),
        new_code_cell("import numpy as np\n\nimport pendlab as pl", id="07-imports"),
        new_code_cell('rig = pl.my_rig("Ada")\nplant = pl.linearize(rig)', id="07-rig"),
    ]
    for k, expression in enumerate(
        ("rig.n_links", "rig.n_motors", "plant.nstates", "plant.ninputs", "plant.noutputs", "rig.g",
         "bool(np.linalg.eigvals(plant.A).real.max() > 0)")
    ):  # fmt: skip
        cells.append(new_code_cell(expression, id=f"07-beat-{k}"))
    return new_notebook(
        cells=[
            *cells,
            new_markdown_cell(
                "### Exercise 1: states (3 min)",
                id="07-ex1-task",
                metadata={"tags": ["exercise"], "pendlab": {"exercise": "07.1", "points": 2}},
            ),
            new_code_cell(
                '### BEGIN SOLUTION\nstates = pl.linearize(pl.load("triple")).nstates\n### END SOLUTION',
                id="07-ex1-solution",
                metadata={"tags": ["solution"]},
            ),
            new_code_cell(
                'pl.check("00.1", states)', id="07-ex1-check", metadata={"tags": ["check"]}
            ),
        ]
    )


def test_notebook_is_stored_audited_and_made_an_edition(tmp_path):
    path = tmp_path / "07_mine.ipynb"
    nbformat.write(small_notebook(), path)
    assert len(problems(nbformat.read(path, as_version=4))) == 2  # not executed yet
    assert refresh(path)
    stored = nbformat.read(path, as_version=4)
    assert problems(stored) == []
    assert stored.cells[-1].metadata.nbgrader.points == 2
    assert "Right" in str(stored.cells[-1].outputs)
    (exercise,) = paper.exercises(student(stored))
    assert exercise.name == "07.1"
    gap = next(cell for cell in student(stored).cells if cell.id == "07-ex1-solution")
    assert "nstates" not in gap.source and "states = ..." in gap.source
    assert not refresh(path), "stored twice, the file must be the same"


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
    invented = {"data/rigs/name.toml", "pendlab/classroom/checks/nb07.py"}
    assert [path for path in sorted(named - invented) if not (ROOT / path).exists()] == []
    assert "(notebooks/extending.ipynb)" in extending
