"""A million random calls in total of exported plants, closed loops, machines and sessions, under the sanitizers of gcc."""

import pytest

import infinivar as iv
from fmu_unit import assert_defined
from internals import c_library
from made import loaded

pytestmark = pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler on this machine")

CASES = {
    "plant": ("hand_controller", "cobotic", None),
    "loop": ("hand_controller", "cobotic", "reach"),
    "machine": ("sphere_joint", "cubic", None),
    "session": ("guided_cart", "cart", "path"),
}
CALLS = 1_000_000 // (2 * len(CASES))


@pytest.mark.full
@pytest.mark.parametrize("version", ["fmu2", "fmu3"])
@pytest.mark.parametrize("case", CASES)
def test_a_million_random_calls_do_nothing_undefined(case, version, tmp_path):
    """The eighth of them that is of one kind and version."""
    study, name, task = CASES[case]
    study = loaded(study)
    scenario = {**study.sessions, **study.scenarios}[task] if task else None
    (file,) = iv.export(
        study.drives[name], version, tmp_path, name=name, scenario=scenario, closed=task is not None
    ).files
    assert_defined(file, tmp_path, CALLS)
