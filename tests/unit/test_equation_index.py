"""Every equation of the paper has a function that implements it and a test that checks it, and a search finds both."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def _extension():
    spec = importlib.util.spec_from_file_location("equation_index", ROOT / "docs" / "_ext" / "equation_index.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


index = _extension()


@pytest.fixture(scope="module")
def implemented():
    return index.implementations()


@pytest.fixture(scope="module")
def checked():
    return index.checks()


@pytest.mark.slow
@pytest.mark.parametrize("number", index.EQUATIONS)
def test_every_equation_has_a_function_and_a_test(implemented, checked, number):
    place = f"Eq {number}"
    assert [entry.name for entry in implemented if entry.place == place]
    assert [entry.name for entry in checked if entry.place == place]


@pytest.mark.slow
@pytest.mark.parametrize("number", index.FIGURES)
def test_every_figure_has_a_source_and_a_test(implemented, checked, number):
    place = f"Fig {number}"
    drawn = [entry.name for entry in implemented if entry.place == place]
    assert drawn
    assert not drawn or [entry.name for entry in checked if entry.place == place]


def test_the_paper_has_18_equations_and_17_figures():
    assert (list(index.EQUATIONS), list(index.FIGURES)) == (list(range(1, 19)), list(range(1, 18)))


@pytest.mark.slow
def test_nothing_else_is_cited_or_marked(implemented, checked):
    known = {*(f"Eq {number}" for number in index.EQUATIONS), *(f"Fig {number}" for number in index.FIGURES)}
    assert {entry.place for entry in (*implemented, *checked)} <= known


def test_sources_cite_one_equation_at_a_time():
    """Ranges such as "Eqs 10-13" hide the equations in them from a search."""
    for path in (ROOT / "src").rglob("*.py"):
        assert not re.findall(r"Source:.*\b(?:Eqs|Figs) \d", path.read_text("utf-8")), path


@pytest.mark.parametrize(
    ("docstring", "found"),
    [
        ("Torque.\n\n    Source: faulring2006, Eq 10 and Eq 12 (b there); johnson1985, Eq 4.2.\n", ["Eq 10", "Eq 12"]),
        ("Source: johnson1985, Eq 3.\n\nAs in faulring2006, Eq 7.", []),
        ("Source: faulring2006, section V,\nFig 13.\n\nNo source: Eq 1.", ["Fig 13"]),
    ],
)
def test_citations_are_those_of_the_paper(docstring, found):
    assert index.places(docstring) == found


def test_a_search_finds_the_laws():
    """The words that a reader would search for, in the files that hold the law."""

    def files_with(words: str) -> set[str]:
        pattern = re.compile(rf"\b{words}\b", re.IGNORECASE)
        sources = (ROOT / "src" / "infinivar").rglob("*.py")
        return {path.stem for path in sources if pattern.search(path.read_text("utf-8"))}

    assert "hysteresis" in files_with("Eq 12")
    assert "rotary_linear" in files_with("slip limit")
