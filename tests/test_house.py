"""Who imports whom: the rules that CONTRIBUTING states, read from the source."""

import ast
from pathlib import Path

import pytest

import pendlab

HOUSE = Path(pendlab.__file__).parent
FOLDERS = ["bench", "paper", "studies", "figures", "widgets", "classroom"]
# From left to right: a module of the core imports only from its left.
CORE = (
    "_arguments parameters lagrange models sampled gain observers controllers loop nyquist design"
).split()
ALLOWED = {
    "bench": {"core", "bench"},
    "paper": {"core", "bench", "paper"},
    "studies": {"core", "bench", "studies"},
    "figures": {"core", "bench", "paper", "studies", "figures"},
    "widgets": {"core", "bench", "paper", "studies", "figures", "widgets"},
    "classroom": {"core", "bench", "paper", "studies", "figures", "classroom"},
}
FILES = sorted(HOUSE.rglob("*.py"))


def imports(path):
    """Full names of the modules that a file imports, inside functions too, or uses as pl.name."""
    package = ["pendlab", *path.relative_to(HOUSE).parts[:-1]]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.Attribute) and getattr(node.value, "id", None) == "pl":
            yield f"pendlab.{pendlab._HOME[node.attr]}"
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            if node.module and module != "pendlab":
                yield module
            else:  # from . import name: a module, or a name of the package
                yield from (f"{module}.{alias.name}" for alias in node.names)


def home(module):
    """Which part of the house a module of pendlab belongs to."""
    part = module.split(".")[1] if "." in module else "core"
    return part if part in FOLDERS else "core"


def test_the_house_is_what_it_is_said_to_be():
    folders = {path.name for path in HOUSE.iterdir() if (path / "__init__.py").exists()}
    assert folders - {"data"} == set(FOLDERS)
    assert {path.stem for path in HOUSE.glob("*.py")} == {*CORE, "__init__", "__main__"}


@pytest.mark.parametrize("name", CORE)
def test_core_imports_from_its_left(name):
    mine = [m for m in imports(HOUSE / f"{name}.py") if m.split(".")[0] == "pendlab"]
    left = CORE[: CORE.index(name)]
    assert {module.split(".")[1] for module in mine} <= set(left)


@pytest.mark.parametrize("folder", FOLDERS)
def test_folders_import_downward(folder):
    for path in (HOUSE / folder).rglob("*.py"):
        for module in imports(path):
            if module.split(".")[0] == "pendlab":
                assert home(module) in ALLOWED[folder], f"{path.name} imports {module}"


@pytest.mark.parametrize(
    "library, where",
    [
        ("sympy", {"lagrange.py", "bench/equations.py"}),
        ("matplotlib", {"figures", "classroom/doctor.py"}),
        ("ipywidgets", {"widgets"}),
        ("anywidget", {"widgets"}),
    ],
)
def test_libraries_stay_where_they_belong(library, where):
    for path in FILES:
        place = path.relative_to(HOUSE).as_posix()
        if library in {module.split(".")[0] for module in imports(path)}:
            assert place in where or place.split("/")[0] in where, f"{place} imports {library}"
