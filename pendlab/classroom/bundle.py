"""Gather a folder from which the whole series installs and runs on a PC without a network.

    python -m pendlab bundle pendlab-bundle --zip

The folder holds the repository's files, every wheel of ``environment.txt`` for this platform and
this version of Python, and an install script. Make it on a machine like those of the room.
"""

import platform
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
NOT_COPIED = {
    "__pycache__",
    "build",
    "dist",
    "wheels",
    "node_modules",
    "pendlab-report",
    "pendlab-student",
    "pendlab-teacher",
    "pendlab-handout",
}
HIDDEN_BUT_COPIED = {".ci", ".gitignore", ".github"}

INSTALL_SH = """#!/bin/sh
# Installs the series from this folder alone; no network is used.
set -eu
cd "$(dirname "$0")"
python="${PYTHON:-@PYTHON@}"
"$python" -m venv .venv
PIP_CONFIG_FILE=/dev/null .venv/bin/python -m pip install --no-index --find-links wheels \\
    --disable-pip-version-check -q -r environment.txt
echo "Installed. Start with: ./start.sh"
"""

START_SH = """#!/bin/sh
# Opens the series in JupyterLab.
cd "$(dirname "$0")"
exec .venv/bin/jupyter lab notebooks/00_start_here.ipynb "$@"
"""

INSTALL_PS1 = """# Installs the series from this folder alone; no network is used.
$ErrorActionPreference = 'Stop'
Set-Location $PSScriptRoot
py -@VERSION@ -m venv .venv
if ($LASTEXITCODE) { throw 'Python @VERSION@ is needed: see README-BUNDLE.md' }
$env:PIP_CONFIG_FILE = 'NUL'
.venv\\Scripts\\python -m pip install --no-index --find-links wheels --disable-pip-version-check -q -r environment.txt
if ($LASTEXITCODE) { throw 'The installation failed.' }
Write-Output 'Installed. Start with: .\\start.bat'
"""

INSTALL_BAT = """@echo off
powershell -NoProfile -ExecutionPolicy Bypass -File "%~dp0install.ps1"
"""

START_BAT = """@echo off
cd /d "%~dp0"
.venv\\Scripts\\jupyter lab notebooks\\00_start_here.ipynb
"""

README = """# The pendlab series without a network

Made for {system} on {machine} with Python {version}; {count} wheels, {size:.0f} MB.

1. Copy this folder to the PC (a path that the user can write to).
2. Linux, macOS: `sh install.sh`. Windows: double-click `install.bat`.
3. Linux, macOS: `sh start.sh`. Windows: double-click `start.bat`.

Python {version} itself must be on the PC already, {full} or a later {version}: many wheels are made
for one version. Which Python is used can be chosen on Linux and macOS by
`PYTHON=/path/to/python{version} sh install.sh`. Tests: `.venv/bin/pytest` (Windows: `.venv\\Scripts\\pytest`).
"""


def bundle(folder, download=None):
    """Fill a folder, which must be new or empty, and give its path.

    Parameters
    ----------
    folder : where the bundle goes
    download : function (requirements, folder) that puts wheels into the folder; pip by default

    Raises
    ------
    ValueError
        when the folder holds something, or this is no copy of the repository
    """
    folder = Path(folder).resolve()
    if not (ROOT / "environment.txt").exists():
        raise ValueError(
            "bundle: expected a copy of the repository (with environment.txt) round the package, "
            f"found {ROOT.name!r}; run it from such a copy."
        )
    if folder.exists() and any(folder.iterdir()):
        raise ValueError(f"folder: expected a new or empty folder, found {folder.name!r} in use.")
    copy_files(ROOT, folder)
    wheels = folder / "wheels"
    wheels.mkdir()
    (download or pip_download)(requirements(ROOT), wheels)
    write_scripts(folder)
    return folder


def requirements(root):
    """Lines of environment.txt that come from an index, and what builds the package itself."""
    lines = (root / "environment.txt").read_text(encoding="utf-8").splitlines()
    listed = [line.split(" #")[0].strip() for line in lines]
    listed = [line for line in listed if line and not line.startswith(("#", "-e"))]
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    return listed + project["build-system"]["requires"]


def pip_download(requirements, folder):
    """Every wheel that the requirements need, for this platform and this Python."""
    listing = folder / "requirements.txt"
    listing.write_text("\n".join(requirements) + "\n", encoding="utf-8")
    command = [sys.executable, "-m", "pip", "download", "--only-binary", ":all:", "-q"]
    command += ["--disable-pip-version-check", "--dest", str(folder), "-r", str(listing)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    listing.unlink()
    if done.returncode:
        raise OSError(f"pip could not fetch the wheels: {done.stderr.strip()[-500:]}")


def copy_files(root, folder):
    """The repository's files without environments, caches and what commands made."""

    def skip(place, names):
        inside = Path(place).resolve()
        return [
            name
            for name in names
            if name in NOT_COPIED
            or (name.startswith(".") and name not in HIDDEN_BUT_COPIED)
            or name.endswith(".egg-info")
            or inside / name == folder
            or (inside / name / "pyvenv.cfg").exists()
        ]

    shutil.copytree(root, folder, ignore=skip, dirs_exist_ok=True)


def write_scripts(folder):
    """Install and start scripts, and a README that says what the bundle is for."""
    version = ".".join(platform.python_version_tuple()[:2])
    scripts = {
        "install.sh": INSTALL_SH.replace("@PYTHON@", f"python{version}"),
        "start.sh": START_SH,
        "install.ps1": INSTALL_PS1.replace("@VERSION@", version).replace("\n", "\r\n"),
        "install.bat": INSTALL_BAT.replace("\n", "\r\n"),
        "start.bat": START_BAT.replace("\n", "\r\n"),
    }
    for name, text in scripts.items():
        (folder / name).write_bytes(text.encode())
        if name.endswith(".sh"):
            (folder / name).chmod(0o755)
    wheels = list((folder / "wheels").glob("*.whl"))
    about = README.format(
        system=platform.system(),
        machine=platform.machine(),
        version=version,
        full=platform.python_version(),
        count=len(wheels),
        size=sum(wheel.stat().st_size for wheel in wheels) / 1e6,
    )
    (folder / "README-BUNDLE.md").write_text(about, encoding="utf-8")


def add_commands(commands):
    parser = commands.add_parser("bundle", help="a folder that installs without a network")
    parser.add_argument("folder", nargs="?", type=Path, default=Path("pendlab-bundle"))
    parser.add_argument("--zip", action="store_true", help="a zip file of it too")
    parser.set_defaults(run=_run)


def _run(options):
    print("Fetching wheels (some hundred megabytes) ...", flush=True)
    folder = bundle(options.folder)
    print(f"{folder}: run install.sh or install.bat there, on a PC with the same Python.")
    if options.zip:
        print(shutil.make_archive(str(folder), "zip", folder.parent, folder.name))
    return 0
