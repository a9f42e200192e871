"""Strain-wave gearheads of tables behind every motor: the search against single drives and against itself without pruning."""

import math
from dataclasses import replace

import numpy as np
import pytest

import infinivar as iv
from internals import candidates, closed_forms, shipped_study, size_geared, tasks_of
from part_tables import part_tables
from sampled import sampled

TEMPLATE = shipped_study("faulring2006").drives["motor2-gear4"]
REACH = iv.DutyCycle(motion=iv.motion.Reaches(distance=0.2, time=0.6, pause=1.5), load_mass=0.8, force=-25.0)
RADII = (0.003, 0.006, 0.012, 0.02)
SHAKE = iv.DutyCycle(motion=iv.motion.Sinusoid(distance=0.06, frequency=2.0), load_mass=1.5, force=-20.0)


def tables(seed=1, motors=8, gearheads=8):
    """The tables of other searches, with catalogue values of strain-wave gears in place of efficiencies; some contradict."""
    of_motors, of_gearheads, pairs = part_tables(seed, motors, gearheads, thermal=0.0)
    random = np.random.default_rng(seed)
    ratio, rated = of_gearheads["ratio"], random.uniform(1.0, 5.0, gearheads)
    running = random.uniform(0.03, 0.15, gearheads) * rated / ratio
    starting = running * random.uniform(0.3, 0.9, gearheads)
    most = 1.0 / (1.0 + ratio * running / rated)
    some = random.random(gearheads) < 0.5
    said = {
        "efficiency": random.uniform(0.8, 1.0, gearheads) * most,
        "rated_torque": rated,
        "starting_torque": starting,
        "running_torque": running,
        "backdriving_torque": np.where(some, random.uniform(1.05, 1.4, gearheads) * ratio * starting, np.nan),
        "ratcheting_torque": np.where(some, 6.0 * rated, np.nan),
        "temperature": np.where(some, 280.0, np.nan),
    }
    said["efficiency"][0] = 1.0
    del of_gearheads["efficiency"], of_gearheads["backdriving_efficiency"]
    return of_motors, {**of_gearheads, **{f"strain_wave.{name}": one for name, one in said.items()}}, pairs


@pytest.mark.slow
def test_closed_forms_are_what_single_drives_do():
    """Demands of all candidates without sampling, against the public analysis of each as a study would have it."""
    duty = {"reach": REACH, "shake": SHAKE}
    found = candidates(TEMPLATE, *tables(), loss_model="strain wave", moving=True, stated=())
    assert found.excluded == {"gearhead strain_wave.efficiency above what its running torque leaves": 8}
    seen = 0
    for task in tasks_of(TEMPLATE, duty, None, travel=None, samples=200):
        forms = dict(closed_forms(found, task, TEMPLATE.stage))
        for place, row in enumerate(found.usable):
            drive = found.drive(int(row), TEMPLATE.stage)
            assert drive.gearhead.strain_wave is not None
            for key, expected in iv.duty_cycle(drive, task.duty, samples=200).demands.items():
                if key in forms and math.isfinite(expected):
                    assert forms[key][place] == pytest.approx(expected, rel=1e-9), key
                    seen += 1
    assert seen > 500


@sampled("over", ["stages", "radius"], every=2)
def test_pruning_changes_nothing(over):
    """The same winners, whose energy and feasibility are those of the drive alone."""
    options = {"duty": {"reach": REACH}, "loss_model": "strain wave", "samples": 100}
    options |= (
        {"radius": (0.004, 0.03)} if over == "radius" else {"stages": [iv.parts.Pulley(radius=one) for one in RADII]}
    )
    pruned = size_geared(TEMPLATE, *tables(), **options)
    whole = size_geared(TEMPLATE, *tables(), prune=False, **options)
    assert [one.pair for one in pruned.designs] == [one.pair for one in whole.designs]
    best = pruned.designs[0]
    cycle = iv.duty_cycle(best.drive, REACH, samples=100)
    assert cycle.feasible
    assert cycle.power_in == pytest.approx(best.power, rel=1e-9)
    assert best.drive.gearhead.loss_words == "strain wave"


SET = """[motors.a]
kind = "assumed"
voltage = "48 V"
resistance = "1 ohm"
torque_constant = "40 mN m/A"
no_load_current = "50 mA"
continuous_torque = "90 mN m"
rotor_inertia = "50 g cm^2"
mass = "0.3 kg"
[gearheads.sw10]
kind = "assumed"
ratio = 10
mass = "0.2 kg"
[gearheads.sw10.strain_wave]
efficiency = 0.7
rated_torque = "2 N m"
starting_torque = "3 mN m"
running_torque = "6 mN m"
[gearheads.plain]
kind = "assumed"
ratio = 10
mass = "0.2 kg"
efficiency = 0.7
"""


@pytest.mark.slow
def test_a_set_of_a_file_and_a_template_that_has_such_a_gear(tmp_path):
    """The search takes the kind of gear from the template; another kind in the set is left out with the reason."""
    (tmp_path / "set.toml").write_text(SET, "utf-8")
    gear = replace(
        TEMPLATE.gearhead,
        loss_model="strain wave",
        efficiency=None,
        strain_wave=iv.parts.StrainWave(efficiency=0.7, rated_torque=2.0, starting_torque=0.003, running_torque=0.006),
    )
    duty = {"reach": iv.DutyCycle(motion=iv.motion.Reaches(distance=0.1, time=0.6, pause=0.3), load_mass=1.0)}
    study = iv.Study(name="s", drives={"geared": replace(TEMPLATE, gearhead=gear)}, duty=duty)
    found = iv.size(study, sets=tmp_path / "set.toml")
    best = found.best
    assert best.parts["gearhead"].key == "sw10"
    assert best.drive.gearhead.strain_wave == gear.strain_wave
    (table,) = [iv.load_parts(tmp_path / "set.toml").gearheads]
    assert table.part("sw10").loss_words == "strain wave"
    assert table.part("plain").loss_words == "constant torque"
