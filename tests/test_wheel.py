"""The package as a wheel, without the repository: all works that needs no notebook."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A folder with the package as a wheel installs it, far from the repository."""
    source, site = (tmp_path_factory.mktemp(name) for name in ("source", "site"))
    for folder in ("pendlab", "data"):
        shutil.copytree(
            ROOT / folder, source / folder, ignore=shutil.ignore_patterns("__pycache__")
        )
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    pip = [sys.executable, "-m", "pip", "-q", "--disable-pip-version-check"]
    made = subprocess.run(
        [*pip, "wheel", "--no-deps", "-w", source, source], capture_output=True, text=True
    )
    if made.returncode and os.environ.get("CI") != "true":
        pytest.skip("pip could not build a wheel; is there a network?")
    assert made.returncode == 0, made.stderr
    (built,) = source.glob("*.whl")
    subprocess.run([*pip, "install", "--no-deps", "--target", site, built], check=True)
    return site


def run_far_away(wheel, tmp_path, *arguments):
    environment = {**os.environ, "PYTHONPATH": str(wheel)}
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)


def test_a_wheel_does_all_that_needs_no_notebook(wheel, tmp_path):
    code = """
import pathlib, pendlab as pl
print(pathlib.Path(pl.__file__).parents[1])
design = pl.paper_design("triple")
run = pl.simulate(design.rig, design.controller, 1, initial=(0.02, 0, 0),
                  imperfections=pl.bench_imperfections(design.rig))
print(run.fell, pl.scoreboard().totals, pl.rigs(), pl.check("02.1", 1).right)
pl.save(pl.figure(1), ".", "fig01")
pl.save(pl.figure(8), ".", "fig08")
print(len(pl.to_c(design.controller)) > 1000, pl.my_rig("Ada").n_links)
for name in pl.__all__:
    getattr(pl, name)
"""
    done = run_far_away(wheel, tmp_path, "-W", "error:::pendlab", "-c", code)
    assert (done.returncode, done.stderr) == (0, "")
    where, numbers, rest = done.stdout.splitlines()
    assert Path(where) == wheel and rest == "True 2"
    assert numbers.startswith("False {") and numbers.endswith("['double', 'triple'] False")
    assert {path.name for path in tmp_path.iterdir()} >= {"fig01.png", "fig08.svg"}


@pytest.mark.parametrize("command", ["doctor", "student", "teacher", "handout", "bundle"])
def test_a_command_without_the_repository_says_so(wheel, tmp_path, command):
    done = run_far_away(wheel, tmp_path, "-m", "pendlab", command)
    if command == "doctor":
        assert done.stderr == "" and "ok  data: rigs double, triple" in done.stdout
        return
    assert done.returncode == 2 and len(done.stderr.splitlines()) <= 3, done.stderr
    assert "notebooks" in done.stderr or "environment.txt" in done.stderr
    assert not list(tmp_path.iterdir())
