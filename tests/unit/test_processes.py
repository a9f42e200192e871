"""Work in several processes: the same results in the same order, and none is left behind."""

import os

import pytest

import infinivar as iv
from internals import ahead, apart, opened_processes, style
from internals import design_trends_figure as design_trends

HERE = "__import__('os').getpid()"


@pytest.fixture
def two(monkeypatch):
    monkeypatch.setenv("INFINIVAR_PROCESSES", "2")


def test_results_come_in_order_from_other_processes(two):
    assert list(apart(eval, [HERE, HERE])) == [os.getpid()] * 2
    with opened_processes():
        assert os.getpid() not in apart(eval, [HERE, HERE])
        assert list(apart(abs, [-3, 2, -1])) == [3, 2, 1]
        assert list(apart(eval, [HERE])) == [os.getpid()]  # alone, there is nothing to gain
    assert list(apart(eval, [HERE, HERE])) == [os.getpid()] * 2


def test_what_is_begun_ahead_is_waited_for(two):
    assert ahead(eval, HERE)() == os.getpid()
    with opened_processes():
        begun = ahead(eval, HERE)
        assert begun() not in (os.getpid(), None)
        with pytest.raises(iv.InputError, match="refused"):
            ahead(exec, "import infinivar as iv; raise iv.InputError('refused')")()


@pytest.mark.slow
def test_figures_drawn_in_processes_are_the_same(two, tmp_path, study):
    drives = [name for name in study.drives if name.startswith("cobotic")]
    drawings = {name: (design_trends.draw_all, study.drives[name]) for name in drives}
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    with opened_processes(design_trends.__name__), style.written_as(*style.FORMATS):
        apart_files = style.write_all(there, drawings)
    with style.written_as(*style.FORMATS):
        files = style.write_all(here, drawings)
    assert [[one.name for one in some] for some in files.values()] == [
        [f"{name}.{kind}" for kind in style.FORMATS] for name in drives
    ]
    for one, other in zip(files.values(), apart_files.values(), strict=True):
        assert [file.read_bytes() for file in one] == [file.read_bytes() for file in other]


def test_an_error_ends_the_others(two):
    with pytest.raises(ZeroDivisionError), opened_processes():
        list(apart(eval, ["1 / 0", "__import__('time').sleep(600)"]))
