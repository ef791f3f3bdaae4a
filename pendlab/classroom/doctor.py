"""Is this machine ready for a session? One finding per question, and what to do about it."""

import importlib.metadata
import importlib.util
import re
import socket
import sys
import tempfile
from dataclasses import dataclass
from html import escape
from pathlib import Path

from .files import command

ENVIRONMENT = Path(__file__).parents[2] / "environment.txt"
NEEDED = "numpy scipy control matplotlib ipywidgets anywidget sympy jupyterlab ipykernel".split()
SLOW = "simulations run in plain Python, about a hundred times slower"
INSTALL = "run  pip install -r environment.txt  in this environment."


@dataclass(frozen=True)
class Finding:
    """One question, what was found, and what to do where it is not well."""

    name: str
    well: bool
    found: str
    advice: str = ""

    def __str__(self):
        line = f"{'ok ' if self.well else 'NO '} {self.name}: {self.found}"
        return line if self.well else f"{line}\n     -> {self.advice}"


@dataclass(frozen=True)
class Findings:
    """All findings; prints as text, shows as a list in a notebook."""

    findings: tuple

    @property
    def ill(self):
        return [finding for finding in self.findings if not finding.well]

    @property
    def well(self):
        return not self.ill

    @property
    def summary(self):
        if self.well:
            return f"{len(self.findings)} checks, all well: the series runs here."
        count = f"{len(self.ill)} of {len(self.findings)}"
        return f"{count} checks need attention; each line says what to do."

    def __str__(self):
        return "\n".join([*map(str, self.findings), self.summary])

    def __repr__(self):
        # Short where all is well, so that a saved notebook is the same on every machine.
        return self.summary if self.well else str(self)

    def _repr_html_(self):
        if self.well:
            return f"<p>✓ {escape(self.summary)}</p>"
        told = (map(escape, (f.name, f.found, f.advice)) for f in self.ill)
        lines = ("<li>✗ {}: {}<br>→ {}</li>".format(*texts) for texts in told)
        return f"<ul>{''.join(lines)}</ul>"


def doctor():
    """Look at Python, packages, fonts, kernel, port, write access and the compiler's cache.

    It needs nothing but Python, so that it can say what is missing.
    """
    return Findings(tuple(_ask(*question) for question in QUESTIONS))


def _ask(name, look, advice):
    try:
        well, found, *other = look()
    except ImportError as problem:
        return Finding(name, False, f"cannot look without {problem.name}", INSTALL)
    return Finding(name, well, found, *(other or [advice]))


def _python():
    return sys.version_info >= (3, 11), ".".join(map(str, sys.version_info[:3]))


def _packages():
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        return False, f"{', '.join(missing)} missing"
    version = importlib.metadata.version
    other = [
        f"{name} {version(name)} (tested: {', '.join(tested)})"
        for name, tested in _tested().items()
        if version(name) not in tested
    ]
    if other:
        return False, "; ".join(other), f"it may work; for the tested versions {INSTALL}"
    return True, "all there, in tested versions"


def _tested():
    """Package -> versions named in environment.txt, for the packages of the series."""
    text = ENVIRONMENT.read_text(encoding="utf-8") if ENVIRONMENT.is_file() else ""
    versions = {}
    for name, version in re.findall(r"^([\w.-]+)==([^;\s]+)", text, re.M):
        if name in NEEDED:
            versions.setdefault(name, []).append(version)
    return versions


def _speed():
    if importlib.util.find_spec("numba"):
        return True, "numba is there"
    no_wheel = sys.platform == "darwin"
    return no_wheel, f"no numba on this Mac: {SLOW}" if no_wheel else f"numba missing: {SLOW}"


def _fonts():
    from matplotlib import font_manager

    from ..figures.style import STYLE

    wanted = STYLE["font.family"][0]
    there = wanted in font_manager.get_font_names()
    return there, f"{wanted} {'found' if there else 'missing'}"


def _kernel():
    from jupyter_client.kernelspec import KernelSpecManager, NoSuchKernel

    try:
        command = KernelSpecManager().get_kernel_spec("python3").argv[0]
    except NoSuchKernel:
        return False, "no python3 kernel", "run  python -m ipykernel install --user"
    ours = Path(command) in (Path(Path(command).name), Path(sys.executable))
    return ours, "python3 is this environment" if ours else f"python3 runs {command}"


def _data():
    from ..parameters import rigs

    found = rigs()
    return {"double", "triple"} <= set(found), f"rigs {', '.join(found) or 'none'}"


def _port():
    try:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
    except OSError as problem:
        return False, str(problem)
    return True, "JupyterLab can listen on this machine"


def _writing():
    try:
        with tempfile.TemporaryFile(dir=Path.cwd()):
            return True, "this folder can be written"
    except OSError as problem:
        return False, f"{Path.cwd()} cannot be written ({problem.strerror})"


def _cache():
    from ..bench.cache import cache_findings

    looked = cache_findings()
    return next((finding for finding in looked if not finding[0]), looked[-1])


# What is looked at, how, and what to do where it is not well.
QUESTIONS = (
    ("Python", _python, "install Python 3.11 or newer, then the environment anew (see README)."),
    ("packages", _packages, INSTALL),
    ("compiler", _speed, f"{INSTALL} Everything works without it, only slower."),
    ("fonts", _fonts, "it comes with matplotlib: run  pip install --force-reinstall matplotlib"),
    ("kernel", _kernel, "another comes first: run  python -m ipykernel install --sys-prefix"),
    ("data", _data, "the folder data/ is missing or incomplete: unpack the repository again."),
    ("port", _port, "a firewall forbids local servers: ask who runs this machine."),
    ("folder", _writing, "copy the series to a folder of yours; here no work can be saved."),
    ("compiler cache", _cache, ""),  # gives its own advice
)


def add_commands(commands):
    command(commands, "doctor", run, "Is this machine ready for a session?")


def run(_):
    findings = doctor()
    print(findings)
    return 0 if findings.well else 1
