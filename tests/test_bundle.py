"""The offline bundle: what is gathered, and that its script installs with no index at all.

No test uses the network: pip sees a folder with one tiny wheel and builds with a tiny back end.
"""

import os
import shutil
import subprocess
import sys
import zipfile

import nbformat
import pytest
from classroom import original

from pendlab.__main__ import main
from pendlab.classroom import bundle as bundling

BACKEND = """
import zipfile

def build_editable(folder, settings=None, metadata=None):
    name = "little-1.0-py3-none-any.whl"
    with zipfile.ZipFile(f"{folder}/{name}", "w") as wheel:
        wheel.writestr("little.py", "import tinydep; answer = tinydep.answer")
        wheel.writestr("little-1.0.dist-info/METADATA", "Metadata-Version: 2.1\\nName: little\\nVersion: 1.0\\n")
        wheel.writestr("little-1.0.dist-info/WHEEL", "Wheel-Version: 1.0\\nRoot-Is-Purelib: true\\nTag: py3-none-any\\n")
        wheel.writestr("little-1.0.dist-info/RECORD", "")
    return name
"""
PROJECT = """
[build-system]
requires = []
build-backend = "backend"
backend-path = ["building"]
[project]
name = "little"
version = "1.0"
"""


def tiny_wheel(folder):
    """A wheel of one module, as an index would give it."""
    about = "tinydep-1.0.dist-info"
    with zipfile.ZipFile(folder / "tinydep-1.0-py3-none-any.whl", "w") as wheel:
        wheel.writestr("tinydep.py", "answer = 42")
        wheel.writestr(f"{about}/METADATA", "Metadata-Version: 2.1\nName: tinydep\nVersion: 1.0\n")
        wheel.writestr(
            f"{about}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        )
        wheel.writestr(f"{about}/RECORD", "")


@pytest.fixture
def offline(tmp_path, monkeypatch):
    """pip with nothing but a folder to take wheels from."""
    index = tmp_path / "index"
    index.mkdir()
    tiny_wheel(index)
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(index))


@pytest.fixture
def repository(tmp_path, monkeypatch):
    """A small repository in which a user has worked."""
    root = tmp_path / "little"
    for name, text in {
        "environment.txt": "# all\ntinydep==1.0  # needed\n\n-e .\n",
        "pyproject.toml": PROJECT,
        "building/backend.py": BACKEND,
        "notebooks/00_start_here.ipynb": nbformat.writes(original()),
        "notebooks/00_start_here_bob.ipynb": "{}",
        "notebooks/homework/01_small.ipynb": nbformat.writes(original()),
        "notebooks/labs/README.md": "[00](../00_start_here.ipynb) [1](../homework/01_small.ipynb)",
        "notebooks/labs/marking.toml": "x = 1",
        "course/submitted/bob/90/90.ipynb": "{}",
        "course/gradebook.db": "marks",
        "grades.csv": "marks",
        "leaderboard.json": "{}",
        "pendlab-student/00_start_here.ipynb": "{}",
        "tests/test_a.py": "answers",
        ".gitignore": "x",
        ".git/config": "secret",
        "env/pyvenv.cfg": "",
        "env/lib.py": "",
        ".venv/lib.py": "",
        "pendlab/__pycache__/a.pyc": "",
        "pendlab/a.py": "",
        "little.egg-info/PKG-INFO": "",
    }.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    monkeypatch.setattr(bundling, "ROOT", root)
    return root


def files(folder):
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


def test_bundle_holds_files_wheels_and_scripts(repository, offline):
    folder = bundling.bundle(repository / "out")
    assert files(folder) == {
        "environment.txt",
        "pyproject.toml",
        "building/backend.py",
        "notebooks/00_start_here.ipynb",
        ".gitignore",
        "pendlab/a.py",
        "notebooks/homework/01_small.ipynb",
        "notebooks/labs/README.md",
        "notebooks/labs/marking.toml",
        "tests/test_a.py",
        "wheels/tinydep-1.0-py3-none-any.whl",
        "README-BUNDLE.md",
        *("install.sh", "start.sh", "install.ps1", "install.bat", "start.bat"),
    }
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    assert f"Python {version}; 1 wheels" in (folder / "README-BUNDLE.md").read_text()
    assert "@" not in (folder / "install.sh").read_text().replace('"$@"', "")
    assert f"py -{version} -m venv" in (folder / "install.ps1").read_text()


def test_with_git_what_it_does_not_know_stays(repository, tmp_path):
    git = ["git", "-C", str(repository), "-c", "user.name=a", "-c", "user.email=a@b.c"]
    shutil.rmtree(repository / ".git")
    subprocess.run([*git, "init", "-q"], check=True)
    known = ["environment.txt", "pyproject.toml", "pendlab/a.py", "notebooks/00_start_here.ipynb"]
    subprocess.run([*git, "add", *known], check=True)
    (repository / "pendlab/b.py").write_text("private")
    bundling.copy_files(repository, tmp_path / "out")
    assert files(tmp_path / "out") == set(known)


def test_bundle_for_students_holds_gaps_and_no_sheets(repository, tmp_path):
    folder = bundling.bundle(tmp_path / "out", lambda lines, wheels: None, students=True)
    assert not any(name.startswith(("tests", "notebooks/labs")) for name in files(folder))
    for name in ("00_start_here", "homework/01_small"):
        text = (folder / "notebooks" / f"{name}.ipynb").read_text()
        assert "answer = ..." in text and "answer = k * 3" not in text and "friction" not in text


def test_a_failed_bundle_leaves_nothing(repository, tmp_path):
    def fail(lines, wheels):
        raise OSError("no index")

    (tmp_path / "kept").mkdir()
    for name in ("new", "kept"):
        with pytest.raises(OSError, match="no index"):
            bundling.bundle(tmp_path / name, fail)
    assert not (tmp_path / "new").exists() and not any((tmp_path / "kept").iterdir())


def test_refusals_come_before_the_fetching(repository, tmp_path, capsys):
    (tmp_path / "used").mkdir()
    (tmp_path / "used" / "a").write_text("")
    (tmp_path / "file").write_text("")
    (tmp_path / "new.zip").write_text("")
    for arguments, sentence in (
        (["used"], "new or empty folder"),
        (["file/bundle"], "found the file 'file' in its place"),
        (["new", "--zip"], "new.zip is there already"),
    ):
        assert main(["bundle", str(tmp_path / arguments[0]), *arguments[1:]]) == 2
        told = capsys.readouterr()
        assert sentence in told.err and "Fetching" not in told.out


@pytest.mark.skipif(os.name == "nt" or not shutil.which("sh"), reason="needs a POSIX shell")
def test_install_script_works_without_an_index(repository, offline, tmp_path):
    folder = bundling.bundle(tmp_path / "bundle")
    shutil.move(folder, tmp_path / "copied to a PC")
    folder = tmp_path / "copied to a PC"
    environment = {"PATH": os.environ["PATH"], "PYTHON": sys.executable, "PIP_NO_INDEX": "1"}
    done = subprocess.run(
        ["sh", str(folder / "install.sh")], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0 and "Installed." in done.stdout, done.stderr
    python = folder / ".venv" / "bin" / "python"
    done = subprocess.run(
        [python, "-c", "import little; print(little.answer)"], capture_output=True
    )
    assert done.stdout.strip() == b"42"


def test_requirements_of_the_series_are_all_bundled():
    listed = bundling.requirements(bundling.ROOT)
    names = " ".join(listed)
    for name in ("numpy", "control", "jupyterlab", "pytest", "setuptools"):
        assert name in names
    assert not any(line.startswith(("-", "#")) for line in listed)


def test_missing_wheel_is_said(repository, offline, tmp_path, capsys):
    (repository / "environment.txt").write_text("no-such-thing==9\n")
    assert main(["bundle", str(tmp_path / "bundle")]) == 2
    assert "no-such-thing" in capsys.readouterr().err


def test_zip(repository, offline, tmp_path):
    assert main(["bundle", str(tmp_path / "bundle"), "--zip"]) == 0
    names = zipfile.ZipFile(tmp_path / "bundle.zip").namelist()
    assert "bundle/install.sh" in names and "bundle/wheels/tinydep-1.0-py3-none-any.whl" in names


def test_folder_in_use_and_no_repository(repository, tmp_path, monkeypatch):
    with pytest.raises(ValueError, match="new or empty folder"):
        bundling.bundle(repository)
    monkeypatch.setattr(bundling, "ROOT", tmp_path)
    with pytest.raises(ValueError, match="copy of the repository"):
        bundling.bundle(tmp_path / "new")
