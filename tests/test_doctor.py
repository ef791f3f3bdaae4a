"""The environment check says what is wrong and what to do about it."""

import subprocess
import sys
from pathlib import Path

import pytest

import pendlab as pl
from pendlab.classroom import doctor as clinic


def test_all_well_here_and_short_in_a_notebook(monkeypatch):
    monkeypatch.setattr(clinic, "_tested", dict)  # the lower bounds are tried too
    findings = pl.doctor()
    assert findings.well, str(findings)
    assert len(repr(findings).splitlines()) == 1
    assert str(findings).count("ok ") == len(findings.findings)


def finding(name):
    return next(f for f in pl.doctor().findings if f.name == name)


def test_missing_package_is_named(monkeypatch):
    monkeypatch.setattr(clinic, "NEEDED", ("numpy", "no_such_package"))
    found = finding("packages")
    assert not found.well
    assert "no_such_package" in found.found
    assert "environment.txt" in found.advice


def test_other_version_is_named(monkeypatch, tmp_path):
    environment = tmp_path / "environment.txt"
    environment.write_text("numpy==0.0.1\n")
    monkeypatch.setattr(clinic, "ENVIRONMENT", environment)
    assert "tested: 0.0.1" in finding("packages").found


def test_missing_data_is_found(monkeypatch):
    monkeypatch.setattr("pendlab.parameters.rigs", list)
    assert not finding("data").well


def test_closed_ports_are_found(monkeypatch):
    class Closed:
        def __init__(self, *_):
            raise OSError("forbidden")

    monkeypatch.setattr(clinic.socket, "socket", Closed)
    assert "firewall" in finding("port").advice


def test_unwritable_folders_are_found(monkeypatch, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setattr("pendlab.bench.cache.cache_folders", lambda: [blocked / "cache"])
    assert "PENDLAB_CACHE" in finding("compiler cache").advice


def test_command_prints_advice_and_fails(monkeypatch, capsys):
    monkeypatch.setattr("pendlab.parameters.rigs", list)
    assert clinic.run(None) == 1
    assert "-> the folder data/ is missing" in capsys.readouterr().out


def test_ill_report_lists_only_what_is_ill(monkeypatch):
    monkeypatch.setattr(clinic, "_tested", dict)
    monkeypatch.setattr("pendlab.parameters.rigs", list)
    html = pl.doctor()._repr_html_()
    assert html.count("<li>") == 1


@pytest.mark.parametrize("text", ["numpy==2.4.6; python_version < '3.12'", "numpy==2.5.5"])
def test_tested_versions_are_read(monkeypatch, tmp_path, text):
    environment = tmp_path / "environment.txt"
    environment.write_text(f"# comment\n{text}\nunlisted==1\n")
    monkeypatch.setattr(clinic, "ENVIRONMENT", environment)
    assert list(clinic._tested()) == ["numpy"]


def test_without_any_package_it_says_what_is_missing():
    """`-S -E`: Python and this folder, nothing else; the state in which a beginner asks for help."""
    command = [sys.executable, "-S", "-E", "-m", "pendlab", "doctor"]
    root = Path(pl.__file__).parents[1]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (1, "")
    assert "NO  packages: numpy, scipy, control, matplotlib" in done.stdout
    assert "pip install -r environment.txt" in done.stdout and "cannot look without" in done.stdout
    assert "ok  Python" in done.stdout and "ok  folder" in done.stdout


def test_it_looks_into_the_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("PENDLAB_CACHE", str(tmp_path))
    (tmp_path / "kernel_2_1_0.py").write_text("")
    found = finding("compiler cache")
    assert not found.well and "1 damaged, among them kernel_2_1_0.py" in found.found
    assert "made anew" in found.advice
