"""Results that are kept for several tests: made once, and anew whenever something changes that they depend on."""

import pytest

import made

CALLS = []


HASHES = made.fingerprint


def forget():
    """As in a process that begins."""
    made.folder.cache_clear()
    HASHES.cache_clear()


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setenv(made.PLACE, str(tmp_path))
    forget()
    yield tmp_path
    forget()


def counted(number, twice=1):
    CALLS.append(number)
    return number * twice


def made_by_another_process(number, **options):
    """`kept` remembers within a process; a new one has only what is on the disk."""
    return made.kept(counted)(number, **options)


def test_it_is_made_once_for_the_same_arguments(place):
    CALLS.clear()
    assert [made_by_another_process(3), made_by_another_process(3), made_by_another_process(4)] == [3, 3, 4]
    assert made_by_another_process(3, twice=2) == 6
    assert CALLS == [3, 4, 3]


@pytest.mark.slow
def test_a_change_of_what_it_depends_on_makes_it_anew(place, monkeypatch, tmp_path):
    CALLS.clear()
    source = tmp_path / "source.py"
    monkeypatch.setattr(made, "sources", lambda: [source])
    for text in ("a = 1", "a = 2", "a = 2"):
        source.write_text(text)
        forget()
        made_by_another_process(3)
    assert CALLS == [3, 3]
    monkeypatch.setenv("JAX_DISABLE_MOST_OPTIMIZATIONS", "other")
    forget()
    made_by_another_process(3)
    assert CALLS == [3, 3, 3]


def test_only_recent_ones_stay(place, monkeypatch):
    for name in "abcde":
        monkeypatch.setattr(made, "fingerprint", lambda name=name: name)
        made.folder.cache_clear()
        made.folder()
    assert len(list(place.iterdir())) == made.RECENT


def test_program_studies_and_helpers_are_hashed():
    names = {path.relative_to(made.ROOT).as_posix() for path in made.sources()}
    for one in (
        "src/infinivar/analysis/compare.py",
        "studies/knee_walking.toml",
        "tests/made.py",
        "tests/cli/conftest.py",
    ):
        assert one in names
    assert any(name.startswith("src/infinivar/contact/data/") for name in names)
    assert not any(name.endswith(".pyc") or "/test_" in name for name in names)
