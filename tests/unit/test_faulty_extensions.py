"""Own parts, drives and motions that are wrong: what is refused, and what the message says."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from annotated_types import Ge

import infinivar as iv

SHAKE = iv.DutyCycle(motion=iv.Sinusoid(distance=0.02, frequency=2.0), load_mass=0.8)


@dataclass(frozen=True, slots=True, kw_only=True)
class Magic(iv.Gearhead):
    """Leaves out a constant torque: over a symmetric cycle that adds up to nothing."""

    gain: float = iv.quantity("N m", Ge(0), "Torque left out", default=0.001)

    def operate(self, *, output_torque, output_speed, motor_rated_torque):
        true = iv.Gearhead.operate(
            self, output_torque=output_torque, output_speed=output_speed, motor_rated_torque=motor_rated_torque
        )
        return replace(true, motor_torque=true.motor_torque - self.gain)


@pytest.mark.parametrize("gain", [1e-8, 0.001, 0.05])
def test_the_balance_of_a_part_closes_at_each_instant(study, gain):
    drive = study.drives["motor1-gear1"]
    machine = replace(drive, gearhead=Magic(ratio=drive.gearhead.ratio, efficiency=0.9, gain=gain))
    with pytest.raises(iv.AuditError, match="power_in differs from power_out, losses and stored powers together by up to"):
        iv.duty_cycle(machine, SHAKE)


@pytest.mark.parametrize("name", ["motor1-gear1", "cobotic"])
def test_the_parts_of_the_program_close_at_each_instant(study, name):
    point = iv.duty_cycle(study.drives[name], SHAKE).point
    missing = point.power_in - point.power_out - sum(point.losses.values()) - sum(point.stored.values())
    assert np.max(np.abs(missing)) < 1e-12 * np.max(np.abs(point.power_in))
