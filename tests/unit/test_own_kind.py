"""A kind of machine that is defined here alone moves, is held and is measured as the shipped ones."""

from dataclasses import dataclass

import numpy as np
from numpy.testing import assert_allclose

import infinivar as iv
from internals import CoboticControl, Defaults, Forces, MovingMachine, Place, PointGrip, coulomb

MASS, FRICTION = 2.0, 1.0


@dataclass(frozen=True, kw_only=True)
class CarriageMechanics(Defaults):
    """A mass on a rail."""

    stick_speed: float
    coordinates: tuple = ("v_x_m_s",)
    configuration: tuple = ("x_m",)
    steered: tuple = ()
    demands: tuple = ()
    losses: tuple = ("rail",)

    def at(self, configuration, rates):
        return Place(rates, np.full((1, 1, 1), MASS), 0.0 * rates, None)

    def act(self, place, rates, angles, turning):
        force = coulomb(rates[:, 0], FRICTION, self.stick_speed)
        return Forces(-force[:, None], angles, lambda: {"rail": force * rates[:, 0]}, lambda: np.zeros((len(rates), 0)))

    def grip(self, handle=(0.0, 0.0)):
        return PointGrip(axes=("x",), coordinates=1)


class Carriage(MovingMachine):
    """Pushed by a user."""

    control = CoboticControl()
    home = np.zeros(1)
    pushed = True

    def mechanics(self, stick_speed):
        return CarriageMechanics(stick_speed=stick_speed)


def test_it_is_simulated():
    scenario = iv.motion.MachineScenario(duration=0.5, wrench=[-3.0], servos=False, steering="locked", source="none")
    run = iv.simulate_machine(Carriage(), scenario)
    assert_allclose(run.columns["v_x_m_s"][-1], (3.0 - FRICTION) / MASS * 0.5, rtol=1e-3)
    assert run.closure < 1e-6


def test_a_user_holds_it():
    found = iv.session(Carriage(), user=[3.0], duration=0.2)
    assert_allclose(found.velocity[-1, 0], (3.0 - FRICTION) / MASS * 0.2, rtol=1e-3)
