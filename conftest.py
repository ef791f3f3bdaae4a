"""What all tests share: rigs and designs, the examples tried, how notebooks are compared."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import pendlab as pl

# The same examples on every run; designs take too long for a deadline, and how long on a busy machine
# is no failure. `pytest --hypothesis-profile=thorough` tries many other examples.
PATIENT = dict(deadline=None, suppress_health_check=[HealthCheck.too_slow], database=None)
settings.register_profile("pendlab", derandomize=True, max_examples=20, **PATIENT)
settings.register_profile("thorough", max_examples=150, **PATIENT)
settings.load_profile("pendlab")


def pytest_configure(config):
    """Notebooks are compared by the same rules from whatever folder pytest is started in."""
    config.option.nbval_sanitize_with = str(Path(__file__).parent / "tests/nbval_sanitize.cfg")


def pytest_collection_modifyitems(items):
    """The two longest files come first, so that neither is what one process does alone at the end."""
    items.sort(key=lambda item: item.path.name not in ("test_browser.py", "test_course.py"))


@pytest.fixture(scope="session", autouse=True)
def name_in_examples(doctest_namespace):
    """Examples in docstrings begin after ``import pendlab as pl``."""
    doctest_namespace["pl"] = pl


@pytest.fixture(scope="session")
def double():
    return pl.load("double")


@pytest.fixture(scope="session")
def triple():
    return pl.load("triple")


@pytest.fixture(params=["double", "triple"])
def rig(request):
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="session")
def double_design():
    return pl.paper_design("double")


@pytest.fixture(scope="session")
def triple_design():
    return pl.paper_design("triple")


@pytest.fixture(params=["double", "triple"])
def design(request):
    return request.getfixturevalue(f"{request.param}_design")
