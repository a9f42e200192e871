"""The command line run inside the test process, and one shared run of each slow command."""

import json
from pathlib import Path

import pytest

from internals import style
from made import made, made_run
from rendering import rendered
from run_cli import run

STUDY = Path(__file__).parents[2] / "studies" / "hand_controller.toml"
KNEE = STUDY.with_name("knee_walking.toml")


@pytest.fixture
def infinivar(tmp_path, request):
    """`infinivar(...)` runs the command line in a fresh folder, which is `tmp_path`, or in the `folder` given.

    Rendering takes most of the time of most commands. Figures are drawn in every test, but rendered only where the test has
    the mark `renders`, in the formats that it names, or in all; the other files are blank.
    """
    mark = request.node.get_closest_marker("renders")
    with rendered(() if mark is None else mark.args or style.FORMATS):
        yield lambda *arguments, folder=tmp_path: run(*arguments, folder=folder)


@pytest.fixture
def write(tmp_path):
    """`write(text)` makes study.toml in that folder."""

    def study(text: str | bytes) -> str:
        (tmp_path / "study.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
        return "study.toml"

    return study


@pytest.fixture(scope="session")
def compared():
    """One `infinivar compare` of the shipped study into a folder in use: outcome, folder, and the printed JSON."""
    before = (("notes.txt", "keep me"), ("report.html", "the report before"))
    outcome, folder = made_run("compare", STUDY, "--json", files=before)
    return outcome, folder, json.loads(outcome.out)


@pytest.fixture(scope="session")
def reproduced():
    """One `infinivar reproduce` of everything, of the claims as they are kept: outcome, folder, and the printed JSON."""
    claims = made("reproduce")  # before the patch, which it would call itself
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("infinivar.paper.reproduce.reproduce", lambda *_, **__: claims)
        outcome, folder = made_run("reproduce", "--json")
    return outcome, folder, json.loads(outcome.out)


@pytest.fixture(scope="session")
def walked():
    """One `infinivar compare` of the shipped knee study, with its duty cycle: outcome, folder, printed JSON.

    The cycle is not simulated. Of the figures only those of the page are rendered, here and below.
    """
    outcome, folder = made_run("compare", KNEE, "--json", figures=("svg",), simulated=False)
    return outcome, folder, json.loads(outcome.out)


@pytest.fixture(scope="session")
def followed():
    """The same with the cycle simulated."""
    outcome, folder = made_run("compare", KNEE, "--json", figures=("svg",))
    return outcome, folder, json.loads(outcome.out)


LARGE = """
title = "A press: large forces"
[requirement]
force = "1540 N"
speed = "0.02 m/s"
quadrants = 4
load_mass = "1500 kg"
[drives.press]
type = "conventional"
title = "Press"
output_inertia = "20 g m^2"
[drives.press.motor]
voltage = "48 V"
resistance = "0.05 ohm"
torque_constant = "60 mN m/A"
no_load_current = "0.5 A"
continuous_torque = "1.2 N m"
rotor_inertia = "1e-4 kg m^2"
winding_to_housing = "0.3 K/W"
housing_to_ambient = "1.2 K/W"
winding_time_constant = "60 s"
housing_time_constant = "1500 s"
max_winding_temperature = "155 degC"
[drives.press.gearhead]
ratio = 1500
efficiency = 0.7
loss_model = "coulomb"
[drives.press.pulley]
radius = "100 mm"
[duty.press]
title = "Press and hold"
shape = "hold"
time = "3600 s"
force = "-1540 N"
[uncertainty.press]
"gearhead.ratio" = { deviation = 15, kind = "assumed", where = "batch" }
"""


@pytest.fixture(scope="session")
def pressed():
    """`infinivar compare` and `sensitivity` of a press with large forces: the outcomes, and the folders of reports."""
    press = (("press.toml", LARGE),)
    runs = [
        made_run("compare", "press.toml", files=press, figures=("svg",)),
        made_run("sensitivity", "press.toml", "--of", "energy", files=press, figures=("svg",)),
    ]
    return [outcome for outcome, _ in runs], [folder for _, folder in runs]
