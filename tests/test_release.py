"""What the commands student, teacher and handout write: no answer in it, nothing lost, own sources safe."""

import ast
import base64
import html
import os
import re
import sys
import tomllib
from functools import lru_cache
from pathlib import Path

import nbformat
import pytest
from classroom import original, write
from refresh_notebooks import ROOT, notebooks

from pendlab.__main__ import main
from pendlab.classroom import exercises as paper
from pendlab.classroom.bundle import copy_files
from pendlab.classroom.files import embed_pictures
from pendlab.classroom.handout import html as page

REAL = {path.relative_to(ROOT).as_posix(): path for path in notebooks()}
PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)

# ---- No leaks


def plain(text):
    """Text without white space, so that no way of breaking lines hides a sentence."""
    return re.sub(r"\s+", "", text)


def read_page(path):
    """The text of a page, without its tags and pictures."""
    text = re.sub(r"<[^>]+>", "", path.read_text(encoding="utf-8"))
    return plain(html.unescape(text))


def shown(notebook):
    """All that a reader of a notebook file can find in it."""
    return plain("\n".join([nbformat.writes(notebook), *(c.source for c in notebook.cells)]))


def solution_lines(notebook):
    """Lines of solutions that stand nowhere else, without trivial ones and heads of functions."""
    given = plain("\n".join(c.source for c in notebook.cells if not paper.has_solution(c)))
    for cell in notebook.cells:
        lines = cell.source.splitlines()
        for first, last in paper.region(cell.source):
            for line in map(str.strip, lines[first + 1 : last]):
                if len(line) > 12 and not line.startswith("def ") and plain(line) not in given:
                    yield line


def printed(cell):
    data = [o.get("text", "") or o.get("data", {}) for o in cell.get("outputs", ())]
    return "\n".join(d if isinstance(d, str) else d.get("text/plain", "") for d in data)


def printed_by_solutions(notebook):
    """Lines with a number that solutions print and given cells do not."""
    cells = {c.id: c for c in notebook.cells if c.cell_type == "code"}
    mine = {name for e in paper.exercises(notebook) for name in e.solutions} & set(cells)
    text = {name: printed(cell) for name, cell in cells.items()}
    given = "\n".join(text[name] for name in set(cells) - mine)
    for name in mine:
        yield from (t for t in text[name].splitlines() if re.search(r"\d", t) and t not in given)


def hints():
    """The sentences of the checks: hints, and what follows "Right"."""
    for path in (ROOT / "pendlab" / "classroom" / "checks").glob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        docs = {id(n.value) for n in ast.walk(tree) if is_docstring(n)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and id(node) not in docs:
                if isinstance(node.value, str) and node.value.count(" ") >= 3:
                    yield node.value.strip()


def is_docstring(node):
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def marking():
    """Every sentence of the marker's notes."""
    notes = tomllib.loads((ROOT / "notebooks/labs/marking.toml").read_text(encoding="utf-8"))
    for exercise in notes.values():
        for value in exercise.values():
            yield from [value] if isinstance(value, str) else value


@lru_cache
def words():
    """The hints and the marker's sentences; a bare formula is neither."""
    told = (*hints(), *marking())
    return [text for text in told if text.count(" ") >= 3 and re.search("[a-z]{3}", text)]


def secrets(notebook):
    """Everything that a released file of this notebook may not hold and its given cells do not."""
    given = [c for c in notebook.cells if not paper.has_solution(c)]
    given = plain("\n".join(c.source + printed(c) for c in given if "-check" not in c.id))
    told = {text for text in words() if plain(text) not in given}
    return told | set(solution_lines(notebook)) | set(printed_by_solutions(notebook))


def leaks(released, notebook):
    return sorted(secret for secret in secrets(notebook) if plain(secret) in released)


@pytest.fixture(scope="module")
def released(tmp_path_factory):
    """Everything that students get: editions, pages, a bundle."""
    folder = tmp_path_factory.mktemp("released")
    source = str(ROOT / "notebooks")
    assert main(["student", source, "--folder", str(folder / "student")]) == 0
    assert main(["handout", source, "--folder", str(folder / "pages")]) == 0
    copy_files(ROOT, folder / "bundle", students=True)
    return folder


@pytest.mark.parametrize("name", REAL)
def test_nothing_released_holds_an_answer(released, name):
    notebook = nbformat.read(REAL[name], as_version=4)
    inside = REAL[name].relative_to(ROOT / "notebooks")
    if paper.exercises(notebook):
        assert leaks(shown(notebook), notebook), "the search finds what is there"
    for file in (released / "student" / inside, released / "bundle" / name):
        edition = nbformat.read(file, as_version=4)
        nbformat.validate(edition)
        assert leaks(shown(edition), notebook) == [], file
        assert "source_hidden" not in nbformat.writes(edition)
        assert not any(c.get("outputs") for c in edition.cells)
    assert leaks(read_page(released / "pages" / inside.with_suffix(".html")), notebook) == []


def test_bundle_for_students_has_no_file_with_answers(released):
    files = {p.relative_to(released / "bundle") for p in (released / "bundle").rglob("*")}
    assert not [f for f in files if f.parts[:1] == ("tests",) or "labs" in f.parts]
    notes = sorted(text for text in marking() if len(text) > 25)
    for file in files:
        file = released / "bundle" / file
        if file.suffix in {".md", ".toml", ".txt", ".json", ".cff", ".yml"}:
            text = plain(file.read_text(encoding="utf-8"))
            assert not [note for note in notes if plain(note) in text], file


def test_no_results_leaves_the_answers_of_predictions_out(tmp_path):
    source = ROOT / "notebooks" / "B_lemma_proof.ipynb"
    for options, pictures in ((), True), (("--no-results",), False):
        folder = tmp_path / str(pictures)
        assert main(["handout", str(source), *options, "--folder", str(folder)]) == 0
        text = (folder / "B_lemma_proof.html").read_text(encoding="utf-8")
        assert ("data:image/png" in text) == pictures


# ---- Places


def run(name, folder, *sources):
    return main([name, *map(str, sources), "--folder", str(folder)])


def files(folder):
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())


@pytest.mark.parametrize("name, end", [("student", "ipynb"), ("handout", "html")])
def test_two_notebooks_of_one_name_are_both_written(tmp_path, name, end):
    for folder in "AB":
        write(original(), tmp_path / folder / "x.ipynb")
    sources = [tmp_path / "A" / "x.ipynb", tmp_path / "B" / "x.ipynb", tmp_path / "A" / "x.ipynb"]
    assert run(name, tmp_path / "out", *sources) == 0
    assert files(tmp_path / "out") == [f"A/x.{end}", f"B/x.{end}"]


def test_a_target_inside_the_source_is_no_source(tmp_path, capsys):
    write(original(), tmp_path / "a.ipynb")
    for _ in range(3):
        assert run("student", tmp_path / "out", tmp_path) == 0
    assert files(tmp_path / "out") == ["a.ipynb"]
    assert "1 of 1" in capsys.readouterr().out


def test_targets_that_cannot_be_are_said_before_the_work(tmp_path, capsys):
    source = write(original(), tmp_path / "a.ipynb")
    (tmp_path / "file").write_text("")
    before = files(tmp_path)
    for folder in (tmp_path, tmp_path / "file", tmp_path / "file" / "deeper"):
        assert run("teacher", folder, source) == 2
        assert capsys.readouterr().err.startswith("pendlab: folder: ")
    assert run("student", tmp_path / "out", tmp_path / "none.ipynb") == 2
    assert files(tmp_path) == before


@pytest.mark.skipif(os.name == "nt", reason="permissions are other there")
def test_a_folder_without_permission_is_said(tmp_path, capsys):
    source = write(original(), tmp_path / "a.ipynb")
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    if os.geteuid() == 0:  # root may write wherever the kernel lets it
        locked = Path("/proc")
    assert run("student", locked / "out", source) == 2
    assert "cannot be written to" in capsys.readouterr().err


def test_a_refusal_leaves_no_half_of_the_work(tmp_path, capsys):
    broken = original()
    broken.cells[3].source = "### BEGIN SOLUTION"
    write(original(), tmp_path / "in" / "a.ipynb"), write(broken, tmp_path / "in" / "b.ipynb")
    assert run("student", tmp_path / "out", tmp_path / "in") == 2
    assert "BEGIN SOLUTION without" in capsys.readouterr().err and not (tmp_path / "out").exists()


# ---- Pictures


@pytest.fixture
def illustrated(tmp_path):
    """A notebook with a local picture, an HTML one, an attached one, and code that shows one."""
    (tmp_path / "in" / "pics").mkdir(parents=True)
    for name in ("p q.png", "p (1).png"):
        (tmp_path / "in" / "pics" / name).write_bytes(PNG)
    (tmp_path / "in" / "s.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    notebook = original()
    notebook.cells[0].source += (
        "\n\n![p](pics/p%20q.png) <img alt='h' src='pics/p q.png'> ![a](attachment:a.png)"
        " ![b](attachment:%C3%BC%20b.png) ![w](<pics/p (1).png>) ![s](s.svg) ![n][n]\n\n[n]: pics/p%20(1).png"
        "\n\n`![no](no.png)`\n\n```\n![no](no.png)\n```\n![web](https://x.org/p.png)"
    )
    pasted = {"image/png": base64.b64encode(PNG).decode()}
    notebook.cells[0]["attachments"] = {"a.png": pasted, "ü b.png": pasted}
    write(notebook, tmp_path / "in" / "a.ipynb")
    return tmp_path


@pytest.mark.parametrize("name", ["student", "teacher", "handout"])
def test_pictures_go_with_every_edition(illustrated, name):
    assert run(name, illustrated / "out", illustrated / "in" / "a.ipynb") == 0
    (made,) = (illustrated / "out").iterdir()
    text = made.read_text(encoding="utf-8")
    if name == "handout":
        assert text.count("data:image/png;base64,") == 6 and "attachment:" not in text
        assert text.count("data:image/svg+xml;base64,") == 1 and "harmful" not in text
        assert "pics/" not in text
    else:
        title = next(c for c in nbformat.reads(text, 4).cells if c.id == "90-title")
        assert len(title.attachments) == 5 and set(title.attachments) >= {"a.png", "pics-p%20q.png"}
        assert title.source.count("attachment:pics-p%20q.png") == 2
        assert title.source.count("](no.png)") == 2 and "https://x.org/p.png" in title.source


@pytest.mark.parametrize("link", ["pics/none.png", "attachment:none.png"])
def test_a_missing_picture_is_named(link):
    notebook = original()
    notebook.cells[0].source = f"![p]({link})"
    with pytest.raises(ValueError, match=f"cell 90-title: the picture {link} is missing"):
        embed_pictures(notebook, ROOT)


def test_real_pictures_are_on_the_page():
    path = ROOT / "notebooks" / "00_start_here.ipynb"
    notebook = nbformat.read(path, as_version=4)
    embed_pictures(notebook, path.parent)
    text = page(notebook, path)
    assert not re.search(r"<img[^>]+src=[\"'](?!data:)", text)


# ---- Help


def test_help_tells_what_each_command_does_with_defaults_and_an_example(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    names = re.findall(r"^    (\w+) +\w", capsys.readouterr().out, re.M)
    assert {"report", "doctor", "student", "teacher", "handout", "bundle"} <= set(names)
    names.remove("mark")  # it only says what took its place
    for name in names:
        with pytest.raises(SystemExit) as stopped:
            main([name, "--help"])
        told = capsys.readouterr().out
        assert stopped.value.code == 0 and f"example:\n  python -m pendlab {name}" in told
        about = told.split("\n\n")[1]
        assert about[0].isupper() and about.rstrip()[-1] in ".?"
        options = re.split(r"^  (?=\S)", told.split("options:")[1].split("example:")[0], flags=re.M)
        for option in options[2:]:  # after the heading and -h
            assert "default" in option, f"{name}: {option}"


def test_version(capsys):
    with pytest.raises(SystemExit):
        main(["--version"])
    assert re.fullmatch(r"pendlab \d+\.\d+\.\d+\n", capsys.readouterr().out)


@pytest.mark.parametrize("name, lacks", [("student", "nbformat"), ("handout", "latex2mathml")])
def test_a_missing_package_is_named(name, lacks, tmp_path, monkeypatch, capsys):
    source = write(original(), tmp_path / "a.ipynb")
    for module in [m for m in sys.modules if m.split(".")[0] == lacks or m.endswith("handout")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.delattr("pendlab.classroom.handout", raising=False)
    monkeypatch.setitem(sys.modules, lacks, None)
    assert run(name, tmp_path / "out", source) == 2
    assert f"{name} needs the package {lacks}" in capsys.readouterr().err
