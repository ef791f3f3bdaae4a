"""Gather a folder from which the whole series installs and runs on a PC without a network.

    python -m pendlab bundle pendlab-bundle --zip

The folder holds the repository's files, every wheel of ``environment.txt`` for this platform and
this version of Python, and an install script. Make it on a machine like those of the room.
"""

import contextlib
import platform
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

from .editions import student
from .files import as_text, command, opened, writable

ROOT = Path(__file__).parents[2]
SCRIPTS = Path(__file__).with_name("scripts")
# What a copy of the repository holds; nothing else that lies in it is anyone else's business.
COPIED = (
    ".ci .github .gitignore .pre-commit-config.yaml CHANGELOG.md CITATION.cff CONTRIBUTING.md "
    "LICENSE README.md conftest.py data environment.txt notebooks pendlab pyproject.toml tests"
).split()
MADE = ("__pycache__", "build", "dist", "wheels", "node_modules")
NOT_FOR_STUDENTS = (".ci", ".github", "notebooks/labs", "tests")


def bundle(folder, download=None, students=False):
    """Fill a folder, which must be new or empty, and give its path; on failure nothing is left.

    `download(requirements, folder)` puts wheels into a folder (default: pip does). `students` get
    their editions, and nothing that holds answers in words.
    """
    folder = check_place(folder)
    empty = folder.exists()
    try:
        copy_files(ROOT, folder, students)
        wheels = folder / "wheels"
        wheels.mkdir()
        print("Fetching wheels (some hundred megabytes) ...", flush=True)
        (download or pip_download)(requirements(ROOT), wheels)
        write_scripts(folder)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        if empty:
            folder.mkdir()
        raise
    return folder


def check_place(folder):
    """The folder's full path, or a sentence on why no bundle can be made there."""
    if not (ROOT / "environment.txt").exists():
        raise ValueError(
            "bundle: expected a copy of the repository (with environment.txt) round the package, "
            f"found {ROOT.name!r}; run it from such a copy."
        )
    folder = writable("folder", folder)
    if folder.exists() and any(folder.iterdir()):
        raise ValueError(f"folder: expected a new or empty folder, found {folder.name!r} in use.")
    return folder


def requirements(root):
    """Lines of environment.txt that come from an index, and what builds the package itself."""
    lines = (root / "environment.txt").read_text(encoding="utf-8").splitlines()
    listed = [line.split(" #")[0].strip() for line in lines]
    listed = [line for line in listed if line and not line.startswith(("#", "-e"))]
    return listed + project(root)["requires"]


def pip_download(requirements, folder):
    """Every wheel that the requirements need, for this platform and this Python."""
    command = [sys.executable, "-m", "pip", "download", "--only-binary", ":all:", "-q"]
    command += ["--disable-pip-version-check", "--dest", str(folder), *requirements]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise OSError(f"pip could not fetch the wheels: {done.stderr.strip()[-500:]}")


def copy_files(root, folder, students=False):
    """The repository's own files: no environments, marks, submissions or notebooks of others."""
    left_out = NOT_FOR_STUDENTS if students else ()
    for file in own_files(root):
        place = file.relative_to(root)
        if any(place.is_relative_to(name) for name in left_out):
            continue
        target = folder / place
        target.parent.mkdir(parents=True, exist_ok=True)
        if students and file.suffix == ".ipynb":
            target.write_text(as_text(student(opened(file))), encoding="utf-8")
        else:
            shutil.copy2(file, target)


def own_files(root):
    """Files that git knows; without git those that a fresh copy has, with the notebooks of the map."""
    git = ["git", "-C", str(root), "ls-files", "-z"]
    with contextlib.suppress(OSError):
        listed = subprocess.run(git, capture_output=True, text=True, check=False).stdout
        if listed:
            return [file for name in listed.split("\0") if (file := root / name).is_file()]
    kit = (root / "notebooks" / "labs" / "README.md").read_text(encoding="utf-8")
    mapped = set(re.findall(r"\.\./(?:\w+/)?(\w+)\.ipynb", kit))
    tops = [root / name for name in (*COPIED, *project(root).get("backend-path", ()))]
    files = [f for top in tops for f in (sorted(top.rglob("*")) if top.is_dir() else [top])]
    return [f for f in files if f.is_file() and _fresh(f.relative_to(root), mapped)]


def project(root):
    """How pyproject.toml says that the package is built."""
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]


def _fresh(place, mapped):
    """Whether a fresh copy has this file: nothing hidden or made by a command, no other notebook."""
    made = any(part.startswith(".") or part in MADE for part in place.parts[1:])
    return not made and (place.suffix != ".ipynb" or place.stem in mapped)


def write_scripts(folder):
    """Install and start scripts, and a README that says what the bundle is for."""
    wheels = list((folder / "wheels").glob("*.whl"))
    values = {
        "SYSTEM": platform.system(),
        "MACHINE": platform.machine(),
        "VERSION": ".".join(platform.python_version_tuple()[:2]),
        "FULL": platform.python_version(),
        "COUNT": str(len(wheels)),
        "SIZE": f"{sum(wheel.stat().st_size for wheel in wheels) / 1e6:.0f}",
    }
    for script in SCRIPTS.iterdir():
        text = script.read_text(encoding="utf-8")
        for name, value in values.items():
            text = text.replace(f"@{name}@", value)
        end = "\r\n" if script.suffix in (".bat", ".ps1") else "\n"
        (folder / script.name).write_text(text, encoding="utf-8", newline=end)
        if script.suffix == ".sh":
            (folder / script.name).chmod(0o755)


def add_commands(commands):
    about = "A folder from which the series installs without a network, for PCs like this one."
    parser = command(commands, "bundle", _run, about, "pendlab-bundle --student --zip")
    parser.add_argument(
        "folder",
        nargs="?",
        type=Path,
        default=Path("pendlab-bundle"),
        help="new or empty (default: %(default)s)",
    )
    for option, what in (
        ("--student", "student editions, no lab sheets or tests (default: all files)"),
        ("--zip", "a zip file of it too (default: the folder alone)"),
    ):
        parser.add_argument(option, action="store_true", help=what)


def _run(options):
    folder = check_place(options.folder)
    if options.zip and folder.with_name(f"{folder.name}.zip").exists():
        raise ValueError(f"folder: {folder.name}.zip is there already; move it or take a new name.")
    bundle(folder, students=options.student)
    print(f"{folder}: run install.sh or install.bat there, on a PC with the same Python.")
    if options.zip:
        print(shutil.make_archive(str(folder), "zip", folder.parent, folder.name))
    return 0
