"""The package's table of contents: names resolve, hide nothing, and load only what they need."""

import pkgutil
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import pendlab as pl

ROOT = Path(__file__).parents[1]
MODULES = [m.name for m in pkgutil.iter_modules(pl.__path__) if not m.name.startswith("__")]


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", pl.__all__)
def test_public_name_resolves(name):
    assert getattr(pl, name) is not None and name in dir(pl)


def test_functions_are_not_hidden_by_submodules():
    assert not set(MODULES) & set(pl.__all__), "a submodule's import would replace the function"
    for module in reversed(MODULES):
        import_module(f"pendlab.{module}")
    for name, home in pl._HOME.items():
        assert getattr(pl, name) is getattr(import_module(f"pendlab.{home}"), name)


@pytest.mark.parametrize(
    "use, absent",
    [
        ("", "numpy control sympy matplotlib scipy ipywidgets"),
        ("pl.load('triple')", "control sympy matplotlib ipywidgets"),
        ("pl.derive", "control matplotlib ipywidgets"),
        ("pl.Design", "ipywidgets"),
    ],
)
def test_import_is_lazy(use, absent):
    code = f"import sys, pendlab as pl\n{use}\nprint(*(m for m in {absent.split()} if m in sys.modules))"
    done = run(code)
    assert (done.returncode, done.stdout.strip()) == (0, ""), done.stderr


def test_a_wheel_carries_every_package():
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = {path.parent.relative_to(ROOT) for path in ROOT.glob("pendlab/**/*.py")}
    folders = {".".join(folder.parts) for folder in folders}
    assert {*setup["tool"]["setuptools"]["packages"]} == folders | {"pendlab.data"}


def test_unknown_name():
    with pytest.raises(AttributeError, match="no attribute 'lqrr'"):
        _ = pl.lqrr


@pytest.mark.parametrize("module", ["pendlab.loop", "test_loop", "conftest", "prose"])
def test_a_warning_of_our_own_is_an_error(module):
    with pytest.raises(DeprecationWarning, match="old"):
        warn_in(module)


def test_a_warning_of_a_dependency_is_none():
    with pytest.warns(DeprecationWarning, match="old"):
        warn_in("control.statesp")


def warn_in(module):
    exec("import warnings; warnings.warn('old', DeprecationWarning)", {"__name__": module})
