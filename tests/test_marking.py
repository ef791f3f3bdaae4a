"""Marking a class of honest, careless and hostile students: each costs only their own rows."""

import csv
import io
import json
import subprocess
import sys
from fractions import Fraction

import numpy as np
import psutil
import pytest
from classroom import original, submission, write

import pendlab as pl
from pendlab.__main__ import main
from pendlab.classroom.answers import decode, encode
from pendlab.classroom.confinement import Limits, can_confine, confined, end, environment, family
from pendlab.classroom.judge import Pupil, Remote, run_check, slice_for_checks
from pendlab.classroom.marking import Row, leaderboard, mark, own_problems, write_csv

RIGHT = "answer = 6.0\nrow = np.zeros(2)"
SQUARE = "def square(x):\n    return x * x"
FORGED = {"exercise": "90.1", "points": 3, "max": 3, "verdict": "right", "reason": "", "score": 9}
HONEST = {"ex1_solution": RIGHT, "ex2_solution": SQUARE}
SLEEPER = "pendlab-marking-test-sleeper"


def hostile():
    """{student: changed cells, or the file's text}."""
    attack = (
        "import pendlab, pendlab.checks, builtins, os, sys\n"
        "pendlab.check = pendlab.checks.check = lambda *a, **k: True\n"
        "np.asarray = lambda *a: 6.0\nbuiltins.abs = lambda x: 0.0\n"
    )
    forge = (
        f"import os\nline = {json.dumps(json.dumps(FORGED))} + '\\n'\n"
        "print(line)\n"
        "for fd in range(3, 64):\n"
        "    try:\n        os.write(fd, line.encode())\n    except OSError:\n        pass"
    )
    liar = (
        "class Liar(float):\n    def __eq__(self, other): return True\n"
        "    def __sub__(self, other): return 0.0\n    def __rmul__(self, other): return 12.0\n"
        "    def __array__(self, *a, **k): return np.array(6.0)\n"
        "answer, row = Liar(5.0), np.zeros(2)"
    )
    orphan = (
        "import subprocess, sys\nsubprocess.Popen([sys.executable, '-c', "
        f"'import time; time.sleep(600) # {SLEEPER}'], start_new_session=True)\n{RIGHT}"
    )
    forks = (
        "import subprocess, sys\nwhile True:\n"
        f"    subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(600) # {SLEEPER}'])"
    )
    return {
        "attack": {"ex1_solution": attack + "answer, row = 5.0, np.zeros(2)"},
        "empty": {**HONEST, "ex1_solution": ""},
        "exits": {**HONEST, "ex2_solution": "import os\nos._exit(0)"},
        "flood": {**HONEST, "ex1_solution": f"print('x' * 10**8)\n{RIGHT}"},
        "forge": {"ex1_solution": forge},
        "forks": {"ex1_solution": forks},
        "good": HONEST,
        "leaves": {**HONEST, "ex1_solution": f"import sys\n{RIGHT}\nsys.exit(1)"},
        "liar": {"ex1_solution": liar},
        "loop": {**HONEST, "ex2_solution": "while True:\n    pass"},
        "memory": {**HONEST, "ex1_solution": "answer = bytearray(10**11)"},
        "notjson": "{",
        "orphan": {**HONEST, "ex1_solution": orphan},
        "syntax": {**HONEST, "ex1_solution": "answer = = 6"},
        "tampered": {**HONEST, "ex1_solution": "answer = 5.0", "ex1_check": "pass"},
        "untouched": {},
        "wrong": {**HONEST, "ex1_solution": "answer = -6.0\nrow = np.zeros(2)"},
        "zeroed": {"given": "k = 0.0", "ex1_solution": "answer = k * 3\nrow = np.zeros(2)"},
    }


@pytest.fixture(scope="module")
def classroom(tmp_path_factory):
    """Rows of the whole class by student; marked once for all tests."""
    top = tmp_path_factory.mktemp("class")
    against = write(original(), top / "solved" / "90_small.ipynb")
    for student, work in hostile().items():
        notebook = work if isinstance(work, str) else submission(**work)
        write(notebook, top / "in" / student / "90_small.ipynb")
    gone = submission(**HONEST)
    gone.cells = [cell for cell in gone.cells if cell.id != "90-ex1-solution"]
    write(gone, top / "in" / "gone.ipynb")
    rows = mark(top / "in", [against], Limits(seconds=10, memory=3000), jobs=3)
    result = {}
    for row in rows:
        result.setdefault(row.student, []).append(row)
    return result


ALL_POINTS = {"good", "flood", "leaves", "orphan"}


def test_every_student_has_every_row_in_order(classroom):
    assert list(classroom) == sorted([*hostile(), "gone"])
    for rows in classroom.values():
        assert [row.exercise for row in rows] == ["90.1", "90.2", "90.3"]
        assert [row.max for row in rows] == [3, 1, 1]


@pytest.mark.parametrize("student", sorted(ALL_POINTS))
def test_honest_work_gets_its_points(classroom, student):
    rows = classroom[student]
    assert [row.points for row in rows[:2]] == [3, 1], rows
    assert rows[2].verdict == "by hand"


@pytest.mark.parametrize("student", sorted({*hostile(), "gone"} - ALL_POINTS - {"exits", "loop"}))
def test_no_points_for_what_is_not_right(classroom, student):
    first = classroom[student][0]
    assert first.points == 0 and first.verdict != "right" and first.reason, first


@pytest.mark.parametrize(
    "student, verdict, reason",
    [
        ("attack", "wrong", "hint: the gain multiplies"),
        ("empty", "wrong", "NameError: name 'answer' is not defined"),
        ("forge", "stopped", "disturbed its channel"),
        ("forks", "stopped", "too many processes"),
        ("gone", "missing", "cell 90-ex1-solution is missing"),
        ("memory", "wrong", "MemoryError"),
        ("notjson", "stopped", "the file is not JSON"),
        ("syntax", "wrong", "SyntaxError"),
        ("tampered", "wrong", "check cell changed or missing, the original was used: 90-ex1-check"),
        ("untouched", "missing", "not attempted"),
        ("wrong", "wrong", "hint: the gain multiplies"),
        ("zeroed", "wrong", "given cells changed or missing: 90-given"),
    ],
)
def test_the_reason_is_given(classroom, student, verdict, reason):
    first = classroom[student][0]
    assert (first.verdict, reason in first.reason) == (verdict, True), first


def test_other_exercises_are_marked_all_the_same(classroom):
    for student in ("gone", "memory", "syntax", "tampered", "wrong", "empty"):
        assert classroom[student][1].points == 1, student


def test_what_ended_a_notebook_is_said_after_what_was_right(classroom):
    for student, reason in (("loop", "stopped after 10 s"), ("exits", "ended its process")):
        first, second, _ = classroom[student]
        assert first.points == 3
        assert second.verdict == "stopped" and reason in second.reason
        assert "90-ex2-solution" in second.reason


def test_no_process_is_left(classroom):
    assert classroom["orphan"][0].points == 3
    left = [p for p in psutil.process_iter(["cmdline"]) if SLEEPER in str(p.info["cmdline"])]
    assert left == []


def test_original_passes_its_own_checks_or_nothing_is_marked(tmp_path, capsys):
    solved = write(original(), tmp_path / "90.ipynb")
    assert own_problems([solved], Limits(seconds=30)) == []
    broken = original()
    broken.cells[3].source = broken.cells[3].source.replace("k * 3", "k * 4")
    broken = write(broken, tmp_path / "broken.ipynb")
    write(submission(**HONEST), tmp_path / "in" / "ann.ipynb")
    marks = tmp_path / "marks.csv"
    assert main(["mark", str(tmp_path / "in"), "--against", str(broken), "--csv", str(marks)]) == 1
    assert "does not pass its own checks" in capsys.readouterr().out and not marks.exists()


def test_command_writes_marks_and_leaderboard(tmp_path, capsys):
    solved = write(original(), tmp_path / "90_small.ipynb")
    write(submission(**HONEST), tmp_path / "in" / "90_small_ann.ipynb")
    marks, board = tmp_path / "marks.csv", tmp_path / "board.csv"
    arguments = ["mark", tmp_path / "in", "--against", solved, "--csv", marks]
    assert main([*map(str, arguments), "--leaderboard", str(board)]) == 0
    table = list(csv.DictReader(io.StringIO(marks.read_text())))
    assert [(row["student"], row["points"]) for row in table] == [
        ("ann", "3"),
        ("ann", "1"),
        ("ann", "0"),
    ]
    assert board.read_text().strip() == "student,exercise,score,claimed"
    assert "4/5" in capsys.readouterr().out
    assert main(["mark", str(tmp_path / "none"), "--against", str(solved)]) == 2


def test_one_exercise_not_handed_in_and_one_unknown_file(tmp_path):
    solved = [write(original(), tmp_path / "90_small.ipynb")]
    other = original()
    for cell in other.cells:
        cell.id = cell.id.replace("90", "91")
        cell.metadata.get("pendlab", {}).pop("exercise", None)
    solved.append(write(other, tmp_path / "91_other.ipynb"))
    write("{", tmp_path / "in" / "bob" / "essay.ipynb")
    write("{", tmp_path / "in" / "bob" / "week1" / "my_90_small.ipynb")
    rows = mark(tmp_path / "in", solved)
    assert {(row.exercise, row.verdict) for row in rows} == {
        *((f"90.{k}", "stopped") for k in (1, 2, 3)),
        *((f"91.{k}", "missing") for k in (1, 2, 3)),
        ("", "unreadable"),
    }


def test_leaderboard_is_recomputed_and_ordered():
    rows = [
        Row(who, "hw9", "hw9.1", 1, 1, "right", "", score, claimed)
        for who, score, claimed in (("a", 1.5, 9.9), ("b", 2.5, None), ("c", None, 7.0))
    ]
    assert leaderboard(rows) == [("b", "hw9.1", 2.5, None), ("a", "hw9.1", 1.5, 9.9)]


def test_csv_runs_no_formula(tmp_path):
    write_csv(tmp_path / "m.csv", ("student", "reason"), [("=1+1", "@x\n\x1b[31m"), ("+a", "b")])
    table = list(csv.reader(io.StringIO((tmp_path / "m.csv").read_text())))
    assert table[1:] == [["'=1+1", "'@x  [31m"], ["'+a", "b"]]


def test_judge_runs_only_what_checks_need():
    notebook = json.loads(json.dumps(original()))
    notebook["cells"].insert(
        2, {"id": "slow", "cell_type": "code", "metadata": {}, "source": "unused = 1 / 0"}
    )
    plan = slice_for_checks(notebook, {"90-ex1-check", "90-ex2-check"})
    assert "slow" not in plan and plan["90-ex1-solution"] == ("offset = 1.0", ["answer", "row"])
    assert set(plan) >= {"90-given", "90-between", "90-ex2-solution"}


def test_verdicts_count_and_silence_does_not():
    from pendlab.checks import Verdict

    said = []
    namespace = {"check": lambda right: said.append(Verdict(right, "hint"))}
    assert run_check("check(True)", namespace, said) == (True, "", None)
    assert run_check("check(True); check(False)", namespace, said) == (False, "hint", None)
    assert run_check("1 + 1", namespace, said)[0] is False
    namespace["check"] = lambda score: said.append(Verdict(True, "Right.", score))
    assert run_check("check(2.5)", namespace, said) == (True, "", 2.5)
    assert run_check("assert 1 == 1", namespace, said)[0] is True


class Secret:
    def __init__(self):
        self.kept = []

    def __call__(self, value):
        self.kept.append(value)
        return len(self.kept) - 1


@pytest.mark.parametrize(
    "value",
    [
        None,
        True,
        3,
        2.5,
        "text",
        1 + 2j,
        [1, (2, {"a": 3.0}), {4}],
        np.float64(2.0),
        np.arange(6.0).reshape(2, 3),
        np.array([1 + 1j, 2]),
        np.array([True, False]),
        np.array(["a", None], dtype=object),
        float("inf"),
    ],
    ids=repr,
)
def test_plain_answers_come_back(value):
    keep = Secret()
    back = decode(json.loads(json.dumps(encode(value, keep))), None)
    np.testing.assert_equal(back, value)
    assert type(back) is type(value) and keep.kept == []


def test_package_objects_come_back(double):
    plant = pl.sample(pl.linearize(double))
    for value in (double, plant):
        back = decode(json.loads(json.dumps(encode(value, Secret()))), None)
        assert type(back) is type(value)
    assert decode(json.loads(json.dumps(encode(double, Secret()))), None) == double
    assert back.dt == plant.dt and back.state_labels == plant.state_labels
    np.testing.assert_array_equal(back.A, plant.A)


def test_symbolic_answers_come_back():
    import sympy as sp

    t, m = sp.symbols("t m", positive=True)
    q = sp.Function("q")(t)
    X = sp.Symbol("X", commutative=False)
    for value in (
        sp.Rational(2, 3) * m * sp.sin(q) ** 2 + sp.pi,
        sp.Derivative(q, t),
        sp.Matrix([[m, X * m * X], [0, sp.I]]),
        sp.MatrixSymbol("A", 2, 3) * sp.MatrixSymbol("B", 3, 2),
    ):
        back = decode(json.loads(json.dumps(encode(value, Secret()))), None)
        assert back == value


def test_what_has_no_plain_form_stays_behind():
    keep = Secret()
    assert encode(Fraction(1, 2), keep) == {"remote": 0}
    assert encode([len], keep) == {"list": [{"remote": 1}]}


@pytest.mark.parametrize(
    "data",
    [
        [],
        {},
        {"eval": "1"},
        {"made": "simulate", "fields": {}},
        {"made": "os.system", "fields": {}},
        {"array": [1], "dtype": "O", "shape": [1]},
        {"array": [1], "dtype": "U999999999", "shape": [1]},
        {"sympy": ["apply", "sympify", ["text", "1"]]},
        {"sympy": ["apply", "lambdify"]},
    ],
    ids=str,
)
def test_only_known_forms_are_decoded(data):
    with pytest.raises((ValueError, TypeError, KeyError)):
        decode(data, None)


def test_a_function_is_called_where_it_lives(classroom):
    """Exercise 2's answer is a function; the good student's is called by the original's check."""
    assert classroom["good"][1].verdict == "right"


@pytest.mark.skipif(not can_confine(), reason="this machine does not let users make namespaces")
def test_confined_process_sees_and_writes_nothing_else(tmp_path):
    own, secret = tmp_path / "own", tmp_path / "secret"
    own.mkdir(), secret.mkdir()
    (secret / "solution").write_text("42")
    code = (
        "import os, socket\n"
        "print(os.listdir('.'), os.path.exists(r'%s'))\n"
        % (secret / "solution")
        + "open('mine', 'w').close()\n"
        "try:\n    open(r'%s', 'w')\nexcept OSError: print('read-only')\n"
        % (tmp_path / "x")
        + "try:\n    socket.create_connection(('192.0.2.1', 80), 2)\n"
        "except OSError as problem: print(problem.strerror)\n"
        "print(len([p for p in os.listdir('/proc') if p.isdigit()]))"
    )
    done = subprocess.run(
        confined([sys.executable, "-c", code], own, [secret]),
        cwd=own,
        env=environment(own),
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split("\n")[:4] == ["[] False", "read-only", "Network is unreachable", "1"]
    assert (own / "mine").exists() and not (tmp_path / "x").exists()


def test_whole_family_is_ended():
    code = (
        "import subprocess as s, sys, time; s.Popen([sys.executable, '-c', '%s']); time.sleep(60)"
    )
    head = subprocess.Popen([sys.executable, "-c", code % "import time; time.sleep(60)"])
    while len(family(head.pid)) < 2:
        pass
    members = family(head.pid)
    end(head.pid)
    head.wait()
    psutil.wait_procs(members, timeout=5)
    assert not any(m.is_running() and m.status() != psutil.STATUS_ZOMBIE for m in members)


def test_limits_must_be_positive():
    with pytest.raises(ValueError, match="memory: expected a limit above 0"):
        Limits(memory=0)


@pytest.fixture
def pupil(tmp_path):
    opened = []

    def start(source):
        cells = [{"id": "own", "cell_type": "code", "source": source, "metadata": {}}]
        opened.append(Pupil(cells, tmp_path, [], Limits(seconds=60)))
        opened[-1].run_to(1, set(), lambda message: None)
        return opened[-1]

    yield start
    for one in opened:
        end(one.process.pid)
        one.process.wait()
        one.process.stdin.close(), one.process.stdout.close()


OWN = """
import numpy as np

class Memory:
    def __init__(self, rates):
        self.rates = rates

class Mine:
    gain = np.array([-40.0, -12.0, -9.0, -3.0])

    def start(self, x0):
        return Memory(np.zeros(2))

    def step(self, state, y, y_ref):
        return np.atleast_1d(-self.gain[:2] @ y[:2]), Memory(state.rates + 1)

answer = Mine()
"""


def test_own_controller_is_run_on_the_judges_bench(pupil, double):
    """The student's object stays where it is; the bench is the judge's, with equal results."""
    remote, found = pupil(OWN).value(do="get", name="answer")
    assert found and isinstance(remote, Remote) and not hasattr(remote, "nothing")
    here = {}
    exec(OWN, here)
    ours = pl.simulate(double, here["answer"], 0.2, initial=[0.01, 0.0])
    theirs = pl.simulate(double, remote, 0.2, initial=[0.01, 0.0])
    np.testing.assert_array_equal(theirs.u, ours.u)
    np.testing.assert_array_equal(theirs.angles, ours.angles)


def test_score_comes_from_the_check_and_the_claim_is_only_shown(tmp_path):
    """A leaderboard entry that a notebook writes is put beside the recomputed score."""
    boast = 'import json\njson.dump({"score": 1e9}, open("leaderboard.json", "w"))\n'
    solved = write(original(), tmp_path / "90.ipynb")
    write(submission(ex1_solution=boast + RIGHT), tmp_path / "in" / "ann.ipynb")
    rows = mark(tmp_path / "in", [solved], Limits(seconds=30))
    assert {(row.score, row.claimed) for row in rows} == {(None, 1e9)}


def test_object_of_the_student_that_fails_is_a_sentence(pupil):
    source = "def answer(x):\n    raise KeyError(x)"
    remote, _ = pupil(source).value(do="get", name="answer")
    with pytest.raises(RuntimeError, match="KeyError: 3"):
        remote(3)
    with pytest.raises(TypeError, match="cannot be handed"):
        remote(object())
