"""The motor model against figures of the same catalogue pages that are not among its inputs.

Source: maxon2020. The model has one constant friction torque (the no-load current) and one resistance. Tolerances:
- no-load speed and stall torque: catalogue figures are rounded to three digits, and the torque constant to as many:
  1.3 % and 1.1 %;
- peak efficiency is rounded to whole percents: 1 point;
- continuous current: 1 %.
Where a motor is farther off, the reason stands with it.
"""

import math

import pytest

from infinivar import motors

# key, no-load speed [rpm], stall torque [mN m], peak efficiency [%], continuous current [A]
CATALOGUE = [
    ("dc-max-26-s-24v", 8920, 287, 87, 1.08),
    ("dc-max-26-s-24v-low-friction", 8930, 287, 89, 1.08),
    ("a-max-26-24v", 4510, 40.1, 81, 0.312),
    ("a-max-32-24v", 6460, 212, 84, 1.33),
    ("dcx-16-l-24v", 12800, 68.5, 84, 0.652),
    ("dcx-19-s-24v", 12700, 74.6, 82, 0.675),
    ("dcx-22-s-24v", 12400, 120, 86, 0.869),
    ("dcx-22-l-18v", 11700, 386, 89, 2.15),
    ("dcx-26-l-24v", 10700, 695, 91, 2.76),
    ("dcx-32-l-24v", 8270, 1980, 89, 4.12),
    ("dcx-35-l-24v", 7720, 2030, 89, 4.26),
    ("re-40-24v", 7580, 2420, 91, 6),
    ("re-50-24v", 5950, 8920, 94, 10.8),
    ("re-65-24v", 4090, 15700, 83, 10),
    ("ec-max-30-24v", 9250, 160, 75, 1.49),
    ("ec-max-30-24v-272763", 9340, 458, 81, 2.66),
    ("ec-4pole-22-24v", 16300, 639, 88, 3.34),
    ("ec-4pole-30-24v", 17500, 1270, 88, 5.56),
    ("ec-45-flat-24v", 6710, 780, 83, 2.33),
    ("ec-45-flat-24v-397172", 6110, 1460, 85, 3.21),
    ("ec-i-40-36v", 10700, 1460, 87, 2.43),
    ("ec-90-flat-24v", 3170, 7910, 85, 9.44),
]

# Large graphite-brush motors: the voltage drop of the brushes, about 1 V, is in the catalogue's speeds but in no data
# that it prints. Brushless motors: iron losses grow with speed, and the torque constant falls in saturation.
BRUSH_DROP = {"re-65-24v": (0.045, 8.0), "dcx-32-l-24v": (0.015, 2.1), "dcx-35-l-24v": (0.015, 2.1)}
BRUSHLESS = {"speed": 0.02, "stall": 0.025, "efficiency": 3.1, "current": 0.17}


@pytest.mark.parametrize(("key", "no_load_speed", "stall_torque", "efficiency", "current"), CATALOGUE)
def test_motor(key, no_load_speed, stall_torque, efficiency, current):
    motor = motors()[key]
    brushless = key.startswith("ec-")
    speed_tolerance, efficiency_tolerance = BRUSH_DROP.get(key, (0.013, 1.0))
    if brushless:
        speed_tolerance, efficiency_tolerance = BRUSHLESS["speed"], BRUSHLESS["efficiency"]

    def voltage_left(speed):
        return motor.voltage - float(motor.operate(torque=0.0, speed=speed).voltage)

    # At no load the supply voltage is used up exactly.
    assert voltage_left(no_load_speed * math.pi / 30) == pytest.approx(0.0, abs=speed_tolerance * motor.voltage)
    # A stalled motor held at full voltage: friction, which the catalogue takes off, helps neither way at rest.
    stall = motor.torque_constant * motor.voltage / motor.resistance - motor.friction_torque
    assert stall == pytest.approx(stall_torque * 1e-3, rel=BRUSHLESS["stall"] if brushless else 0.011)
    assert 100 * motor.peak_efficiency == pytest.approx(efficiency, abs=efficiency_tolerance)
    assert motor.continuous_current == pytest.approx(current, rel=BRUSHLESS["current"] if brushless else 0.01)


def test_the_paper_s_motor_has_a_like_substitute():
    """Re-max 29, maxon 226806: 87 % at best (faulring2006, VI-A); Motor 2 scales it and keeps that."""
    motor = motors()["dc-max-26-s-24v"]
    assert motor.peak_efficiency == pytest.approx(0.87, abs=0.005)
    assert motor.scaled(2.7).peak_efficiency == pytest.approx(motor.peak_efficiency, rel=1e-12)
