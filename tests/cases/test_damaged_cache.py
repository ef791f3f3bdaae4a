"""A cache of compiled code that was cut short, filled up, locked or misnamed never stops a run."""

import json
import os
import shutil
import subprocess
import sys

import pytest

import pendlab as pl
from pendlab.bench import cache
from pendlab.bench.warm import warm

TEXT = "def twice(x):\n    return 2 * x\n"


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """The user's cache alone, in a folder of the test."""
    mine = tmp_path / "mine"
    monkeypatch.setattr(cache, "cache_folders", lambda: [mine])
    monkeypatch.delenv("PENDLAB_SEED", raising=False)
    return mine


@pytest.mark.parametrize("damage", [b"", b"def twice(x):\n", TEXT.encode(), b"\xff\xfe\x00"])
def test_damaged_source_is_written_anew(folders, damage):
    path = cache.keep("kernel_one", lambda: TEXT)
    whole = path.read_bytes()
    assert path == folders / "kernel_one.py" and TEXT.encode() in whole and cache.intact(path)
    path.write_bytes(damage)
    assert [well for well, _, _ in cache.cache_findings()] == [False]
    assert cache.keep("kernel_one", lambda: TEXT).read_bytes() == whole
    [(well, found, _)] = cache.cache_findings()
    assert well and "1 kernels, none damaged" in found
    # What is whole is not made again.
    assert cache.keep("kernel_one", lambda: pytest.fail("written again")) == path


def test_a_full_disk_leaves_nothing_behind(folders, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    assert cache.keep("kernel_one", lambda: TEXT) is None
    assert list(folders.iterdir()) == []


def test_the_next_folder_is_taken_where_the_first_cannot_be_written(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a folder")
    blocked, free = tmp_path / "file" / "below", tmp_path / "free"
    monkeypatch.setattr(cache, "cache_folders", lambda: [blocked, free])
    assert cache.keep("kernel_one", lambda: TEXT) == free / "kernel_one.py"
    (first, found, advice), (second, *_) = cache.cache_findings()
    assert (first, second) == (False, True) and "below" in found and "PENDLAB_CACHE" in advice
    monkeypatch.setattr(cache, "cache_folders", lambda: [blocked])
    assert cache.keep("kernel_one", lambda: TEXT) is None
    assert cache.cache_findings()[-1][1] == "no folder of yours can be written"


@pytest.mark.parametrize("named, expected", [
    ("", None), ("  ", None), ("~/kept", "home/kept"), ("~nobody-of-this-name/x", None),
])  # fmt: skip
def test_the_variable_may_be_empty_or_begin_at_home(tmp_path, monkeypatch, named, expected):
    for variable in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(variable, str(tmp_path / "home"))
    for variable in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(
            variable, "relative"
        )  # to be ignored: it would follow the working folder
    monkeypatch.setenv("PENDLAB_CACHE", named)
    folders = list(cache.cache_folders())
    assert folders[-1] == tmp_path / "home" / ".cache" / "pendlab"
    assert folders[:-1] == ([] if expected is None else [tmp_path / expected])


# ---- numba's files


@pytest.fixture(scope="module")
def seed(tmp_path_factory):
    """The kernel of the double, compiled into a folder of an administrator."""
    pytest.importorskip("numba", reason="there is nothing compiled without it")
    folder = tmp_path_factory.mktemp("seed")
    (path,) = warm([pl.load("double"), pl.my_rig("Ada")], folder)
    assert path.parent == folder
    return folder


SCRIPT = """
import json, resource, signal, sys, warnings
warnings.filterwarnings("error", module="pendlab")
if {limit}:
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
import pendlab as pl
from pendlab.bench.generated import load_kernel
design = pl.paper_design("double")
run = pl.simulate(design.rig, design.controller, 0.1, initial=(0.02, 0.0))
kernel = load_kernel(2, 1)
stats = getattr(kernel.run, "stats", None)
print(json.dumps([run.angles[-1].tolist(), sum(stats.cache_hits.values()) if stats else None]))
"""


def simulated(tmp_path, limit=0, **environment):
    """(last angles, kernels found ready) in a new process whose working folder stays clean."""
    work = tmp_path / "work"
    work.mkdir(exist_ok=True)
    home = dict(HOME=str(tmp_path / "home"), XDG_CACHE_HOME=str(tmp_path / "xdg"))
    variables = {k: v for k, v in os.environ.items() if not k.startswith("PENDLAB_")}
    root = str(pl.parameters.HERE.parent)
    out = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(limit=limit)], cwd=work,
        env=variables | home | dict(PYTHONPATH=root) | environment,
        capture_output=True, text=True, timeout=240,
    )  # fmt: skip
    assert out.returncode == 0, out.stderr
    assert list(work.iterdir()) == []
    return json.loads(out.stdout)


@pytest.fixture(scope="module")
def expected(double_design):
    run = pl.simulate(double_design.rig, double_design.controller, 0.1, initial=(0.02, 0.0))
    return run.angles[-1].tolist()


def test_a_seed_fills_the_cache_of_a_student(tmp_path, seed, expected):
    before = {p: p.stat().st_mtime_ns for p in seed.rglob("*") if p.is_file()}
    mine = tmp_path / "mine"
    assert simulated(tmp_path, PENDLAB_CACHE=str(mine), PENDLAB_SEED=str(seed)) == [expected, 1]
    names = {p.relative_to(seed) for p in before}
    assert names <= {p.relative_to(mine) for p in mine.rglob("*")}
    assert before == {p: p.stat().st_mtime_ns for p in seed.rglob("*") if p.is_file()}


@pytest.mark.parametrize("pattern, keep", [("*.read-*.nbi", 0.0), ("*.run-*.nbc", 0.5)])
def test_shortened_files_are_compiled_anew(tmp_path, seed, expected, pattern, keep):
    mine = tmp_path / "mine"
    shutil.copytree(seed, mine)
    (file,) = (mine / "__pycache__").glob(pattern)
    file.write_bytes(file.read_bytes()[: int(keep * file.stat().st_size)])
    assert cache._damaged(file)
    ready = int("run" not in pattern)
    assert simulated(tmp_path, PENDLAB_CACHE=str(mine)) == [expected, ready]
    assert not any(map(cache._damaged, [*mine.glob("kernel_*.py"), *cache._compiled(mine)]))


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of files there")
def test_a_quota_on_the_cache_costs_time_only(tmp_path, seed, expected):
    mine = tmp_path / "mine"
    shutil.copytree(seed, mine)
    (file,) = (mine / "__pycache__").glob("*.read-*.nbc")
    file.write_bytes(b"")
    assert simulated(tmp_path, limit=2000, PENDLAB_CACHE=str(mine)) == [expected, 1]
    assert not list(mine.rglob("*.tmp.*")) and not list(mine.rglob("*.draft"))
    assert simulated(tmp_path, PENDLAB_CACHE=str(mine)) == [expected, 1]
    assert file.stat().st_size > 2000


@pytest.mark.parametrize("bad, kind, message", [
    (dict(rigs="double"), TypeError, "rigs: entry 1: expected a pl.Pendulum, found 'double'"),
    (dict(rigs=[pl.load("double"), 3]), TypeError, "rigs: entry 2: expected a pl.Pendulum, found 3"),
    (dict(rigs=[], folder=""), ValueError, "folder: expected text, found none"),
    (dict(rigs=[], folder=3), TypeError, "folder: expected the path of a file or folder, found 3"),
    (dict(rigs=[], folder=__file__), ValueError, "folder: .* cannot be written"),
])  # fmt: skip
def test_warming_says_what_it_needs(bad, kind, message):
    with pytest.raises(kind, match=message):
        warm(**bad)
