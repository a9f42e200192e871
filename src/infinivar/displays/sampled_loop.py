r"""The loop of a display with its sampled controller: exact discretisation, eigenvalues, response and steps in time.

Between samples the plant moves under a current that is held, so that its state after a sample follows from the matrix exponential
without error. The controller's law, evaluated at unit values, gives the rest of the closed loop's matrix.

**Response.** Under a force :math:`F e^{j\omega t}` the held current is a staircase, and the handle's motion contains
frequencies :math:`\omega + 2\pi k/T`. An impedance is that of the fundamental at :math:`\omega`, which is exact here: only it
takes power from a sinusoidal force in the mean. With the zero-order hold :math:`H = (1 - e^{-j\omega T})/(j\omega)` and the
phasor I of the current at the samples,

.. math:: P = (j\omega - A)^{-1}\left(b\, \frac{H}{T} I + e F\right) .

Source: franklin1998, zero-order hold and sampled-data response.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from infinivar._core.arrays import real_array
from infinivar.displays.kinds import Display
from infinivar.displays.plants import Held, Plant, Sensed
from infinivar.errors import ParameterError, require
from infinivar.motion.users import ArmModel

NEUTRAL = 1e-9
"""Growth per sample that still counts as stable, which is rounding. [-]"""

_RIGID = 1e-6
"""Distance from 1 of an eigenvalue that counts as 1: rounding splits the two of a free mass by about 1e-8. [-]"""

_LARGEST = 1e100
"""Entry of a closed loop's matrix from which it counts as overflowing."""


class SampledLoop(NamedTuple):
    """Closed loop from one sample to the next: state of the plant, memory of the controller, and current that waits."""

    plant: Plant
    period: float
    after: np.ndarray
    """Of the plant's state, over a sample. (n, n)"""
    held: np.ndarray
    """Of the plant's state by a held current. (n,)"""
    kept: np.ndarray
    """Memory and current by memory and what is sensed: (c + 1, c + 5)."""
    late: int

    @property
    def matrix(self) -> np.ndarray:
        """Of the closed loop, (n + c + late,) squared."""
        n, c = len(self.after), len(self.kept) - 1
        size = n + c + self.late
        # Rows of memory and computed current over the closed loop's state.
        found = np.zeros((c + 1, size))
        found[:, :n] = self.kept[:, c:] @ self.plant.sensed
        found[:, n : n + c] = self.kept[:, :c]
        closed = np.zeros((size, size))
        closed[:n, :n] = self.after
        closed[n : n + c] = found[:c]
        if self.late:
            closed[-1] = found[c]
            closed[:n, -1] = self.held
        else:
            closed[:n] += np.outer(self.held, found[c])
        return closed

    @property
    def growth(self) -> float:
        """Largest growth over a sample; above 1 the loop is unstable."""
        return float(growths([self])[0])

    @property
    def stable(self) -> bool:
        """Whether nothing grows."""
        return self.growth <= 1.0 + NEUTRAL


def sampled_loop(display: Display, held: Held, known: dict | None = None) -> SampledLoop:
    """Closed loop of a display.

    Parameters
    ----------
    display : AdmittanceDisplay or ImpedanceDisplay
    held : ArmModel, "free" or "clamped"   What is at the handle.
    known : dict   Discretised plants of earlier calls, by plant and period, to be used again.

    Source: franklin1998, zero-order hold.
    """
    from scipy.linalg import expm

    plant, period, n = display.plant(held), display.period, 0
    n = len(plant.states)
    key = (plant.system.tobytes(), plant.current.tobytes(), period)
    if known is None or key not in known:
        system = np.zeros((n + 1, n + 1))
        system[:n, :n], system[:n, n] = plant.system, plant.current
        step = expm(period * system)[:n]
        if known is not None:
            known[key] = step
    else:
        step = known[key]
    c = len(display.memory)
    unit = np.eye(c + len(Sensed._fields))
    memory, current = display.act(unit[:c], Sensed(*unit[c:]))
    return SampledLoop(
        plant, period, step[:, :n], step[:, n], np.array([*memory, current], dtype=float), display.samples_late
    )


def growths(loops: Iterable[SampledLoop]) -> np.ndarray:
    """Largest growth over a sample of each of several loops; inf for one whose numbers overflow."""
    matrices = [loop.matrix for loop in loops]
    found = np.full(len(matrices), np.inf)
    # What overflows in the product of two matrices would overflow in the eigenvalues.
    sizes = np.array([len(one) if np.max(np.abs(one), initial=0.0) < _LARGEST else 0 for one in matrices])
    for size in set(sizes.tolist()) - {0}:
        these = np.flatnonzero(sizes == size)
        # A balanced matrix has smaller rounding errors; scales of the states differ by six orders.
        stacked = _balanced(np.stack([matrices[place] for place in these]))
        values = np.linalg.eigvals(stacked)
        size = np.abs(values)
        found[these] = np.max(np.where(np.abs(values - 1.0) <= _RIGID, np.minimum(size, 1.0), size), axis=-1)
    return found


def _balanced(matrices: np.ndarray) -> np.ndarray:
    """Similar matrices whose rows and columns are of like size.

    Source: none; powers of 2, so that nothing is rounded.
    """
    away = ~np.eye(matrices.shape[-1], dtype=bool)
    for _ in range(4):
        size = np.abs(matrices) * away
        rows, columns = size.sum(-1), size.sum(-2)
        known = (rows > 0) & (columns > 0)
        scale = np.exp2(np.round(0.5 * np.log2(np.where(known, rows, 1.0) / np.where(known, columns, 1.0))))
        matrices = matrices * scale[:, None, :] / scale[:, :, None]
    return matrices


def impedance(display: Display, frequency: Sequence[float] | np.ndarray, held: Held = "free") -> np.ndarray:
    r"""Impedance that the display shows at its handle: force over speed at the fundamental.

    Parameters
    ----------
    display : AdmittanceDisplay or ImpedanceDisplay
    frequency : (n,) float   > 0, below half of the sample rate. [Hz]
    held : ArmModel or "free"
        What is at the handle while it is measured. The impedance of the arm itself is taken off, so that the result differs
        only by what the sampler folds back of the arm's reaction to the staircase.

    Returns
    -------
    (n,) complex   Positive real part where the display takes power. [N s m^-1]

    Raises
    ------
    ParameterError
        If a frequency is out of range, or the handle is clamped.

    Source: franklin1998, sampled-data response; see the module.
    """
    frequency = checked_frequency(display, frequency)
    check_moving(held)
    loop = sampled_loop(display, held)
    plant, period, late = loop.plant, loop.period, loop.late
    n, c = len(plant.states), len(loop.kept) - 1
    omega = 2.0 * np.pi * frequency
    turn = np.exp(1j * omega * period)
    resolvent = 1j * omega[:, None, None] * np.eye(n) - plant.system
    pushed = np.linalg.solve(resolvent, np.broadcast_to(plant.force[:, None], (len(omega), n, 1)))[..., 0]
    # Over a sample the force moves the state by this, beside what its start does.
    driven = turn[:, None] * pushed - pushed @ loop.after.T
    closed = loop.matrix
    size = len(closed)
    forced = np.zeros((len(omega), size), dtype=complex)
    forced[:, :n] = driven
    # A force may also pass straight to the sensor.
    direct = loop.kept[:, c:] @ plant.passed
    forced[:, n : n + c] += direct[:c]
    if late:
        forced[:, -1] += direct[c]
    else:
        forced[:, :n] += loop.held * direct[c]
    state = np.linalg.solve(turn[:, None, None] * np.eye(size) - closed, forced[..., None])[..., 0]
    if late:
        current = state[:, -1]
    else:
        seen = state[:, :n] @ plant.sensed.T + plant.passed
        current = state[:, n : n + c] @ loop.kept[c, :c] + seen @ loop.kept[c, c:]
    hold = (1.0 - np.exp(-1j * omega * period)) / (1j * omega * period)
    answer = np.linalg.solve(resolvent, plant.current[:, None] * (hold * current)[:, None, None])[..., 0] + pushed
    speed = 1j * omega * answer[:, plant.states.index("x_m")]
    return 1.0 / speed - arm_impedance(held, omega)


def check_moving(held: Held) -> None:
    """Raise ParameterError if the handle cannot move."""
    if isinstance(held, str) and held == "clamped":
        raise ParameterError("held must be an ArmModel or 'free', got 'clamped': a clamped handle has no speed")


def arm_impedance(held: Held, omega: np.ndarray) -> np.ndarray:
    """Impedance of what is at the handle: that of an arm, or 0. [N s m^-1]"""
    if not isinstance(held, ArmModel):
        return np.zeros(np.shape(omega), dtype=complex)
    return held.damping + 1j * (omega * held.mass - held.stiffness / omega)


def checked_frequency(display: Display, frequency: Sequence[float] | np.ndarray) -> np.ndarray:
    """The frequencies as an array; ParameterError if one is out of range."""
    found = np.atleast_1d(real_array("frequency", frequency))
    half = 0.5 / display.period
    require(found.ndim == 1 and found.size > 0, "frequency", f"shape {found.shape}", "a row of numbers", "in Hz")
    wrong = ~((found > 0.0) & (found < half))
    require(not wrong.any(), "frequency", found[wrong][:1], f"> 0 and < {half:g} (half of the sample rate)", "Hz")
    return found


class Steps(NamedTuple):
    """A run in time, at the ends of equal steps within the samples."""

    time: np.ndarray
    state: np.ndarray
    """Of the plant. (n, states)"""
    current: np.ndarray
    """Held over the step that ends there. (n,) [A]"""
    observed: np.ndarray
    """Energy that the motor of an impedance display has taken, by its encoder, at the samples. (samples + 1,) [J]"""


def run_in_time(
    display: Display,
    held: Held,
    start: Sequence[float] | np.ndarray,
    samples: int,
    force: np.ndarray | None = None,
    within: int = 8,
    *,
    passivity_control: bool = False,
    seed: int = 0,
) -> Steps:
    """Step a display through time: plant by an implicit Runge-Kutta method, controller sample by sample.

    Nothing here is that of the eigenvalues but the equations themselves: no matrix exponential, no closed loop. Position is known
    in whole counts, the force with its noise, and Coulomb friction acts on the drive after each step.

    Parameters
    ----------
    display, held : as in `sampled_loop`
    start : (states,) float       State of the plant, by `Plant.states`.
    samples : int                 > 0.
    force : (samples within 2,) float
        Force on the handle at a third and at the end of each step; none by default. [N]
    within : int                  Steps in a sample, > 0.
    passivity_control : bool      Whether a passivity controller brakes an impedance display by the energy that it has given more
        than taken, as observed at its encoder.
    seed : int                    Of the noise.

    Returns
    -------
    Steps   With the start, ``samples within + 1`` instants.

    Raises
    ------
    ParameterError
        If the start or the force is of another length, or an admittance display is to have a passivity controller.

    Source: hairer1996, Radau IIA of order 3: stiffly accurate, as the creep of the contact needs; hannaford2002, with the force
    held over a sample times the travel in it as energy, which is exact.
    """
    if passivity_control and not hasattr(display, "force_per_current"):
        raise ParameterError(
            "passivity_control does not apply to an AdmittanceDisplay: its motor does not act on the handle"
        )
    noise = np.random.default_rng(seed)
    plant, step = display.plant(held), display.period / within
    n = len(plant.states)
    state = real_array("start", start)
    require(state.shape == (n,), "start", f"shape {state.shape}", f"{n} values: {', '.join(plant.states)}")
    pushes = np.zeros(2 * samples * within) if force is None else real_array("force", force)
    if pushes.shape != (2 * samples * within,):
        raise ParameterError(f"force must have {2 * samples * within} values, got {pushes.shape}")
    pushes = pushes.reshape(samples * within, 2)
    moved = _radau(plant, step)
    rub = _rubbing(display, plant, step)
    memory, waiting, acting = np.zeros(len(display.memory)), 0.0, 0.0
    states, currents = np.empty((samples * within + 1, n)), np.zeros(samples * within + 1)
    states[0], before = state, 0.0 if force is None else float(pushes[0, 0])
    gain = getattr(display, "force_per_current", 0.0)
    observed, last, at = np.zeros(samples + 1), float((plant.sensed @ state)[1]), 0
    for sample in range(samples):
        seen = _seen(display, plant.sensed @ state + plant.passed * before, noise)
        travel, last = (seen.position - last if sample else 0.0), seen.position
        observed[sample] = observed[max(sample - 1, 0)] - gain * acting * travel
        kept, computed = display.act(memory, seen)
        memory = np.array(kept)
        acting, waiting = (waiting, float(computed)) if display.samples_late else (float(computed), 0.0)
        if passivity_control and observed[sample] < 0.0 and travel:
            # At most what stops drive and handle within a sample.
            most = (display.drive_mass + display.handle_mass) * abs(travel) / display.period**2
            acting -= min(-observed[sample] / abs(travel), most) * np.sign(travel) / gain
        for _ in range(within):
            state = rub(moved @ np.concatenate([state, [acting], pushes[at]]))
            at += 1
            states[at], currents[at] = state, acting
        before = float(pushes[at - 1, 1])
    seen = _seen(display, plant.sensed @ state + plant.passed * before, noise)
    observed[-1] = observed[-2] - gain * acting * (seen.position - last)
    return Steps(np.arange(samples * within + 1) * step, states, currents, observed)


def _seen(display: Display, exact: np.ndarray, noise: np.random.Generator) -> Sensed:
    """What the controller gets of what is there: whole counts, and a force with noise."""
    found, count = Sensed(*exact), display.encoder_resolution
    if count:
        found = found._replace(position=count * np.floor(found.position / count))
    if display.force_noise:
        found = found._replace(force=found.force + display.force_noise * noise.standard_normal())
    return found


def _rubbing(display: Display, plant: Plant, step: float) -> Callable[[np.ndarray], np.ndarray]:
    """What Coulomb friction leaves of a state: the drive is slowed, at most to rest."""
    hung = "v_drive_m_s" in plant.states
    name = "v_drive_m_s" if hung else "v_m_s"
    if not display.coulomb_friction or name not in plant.states:
        return lambda state: state
    place = plant.states.index(name)
    mass = display.drive_mass if hung else 1.0 / plant.force[place]
    most = display.coulomb_friction * step / mass

    def rub(state: np.ndarray) -> np.ndarray:
        lost = min(max(state[place], -most), most)
        state[place] -= lost
        state[place - 1] -= 0.5 * step * lost  # as a constant force within the step, so that what sticks does not creep
        return state

    return rub


def _radau(plant: Plant, step: float) -> np.ndarray:
    """State after a step by the state, the current, and the forces at a third and at the end: (n, n + 3)."""
    n = len(plant.states)
    weights = np.array([[5.0, -1.0], [9.0, 3.0]]) / 12.0
    given = np.zeros((2 * n, n + 3))
    for stage, rows in enumerate((slice(0, n), slice(n, 2 * n))):
        given[rows, :n], given[rows, n], given[rows, n + 1 + stage] = plant.system, plant.current, plant.force
    slopes = np.linalg.solve(np.eye(2 * n) - step * np.kron(weights, plant.system), given)
    return np.eye(n, n + 3) + step * (0.75 * slopes[:n] + 0.25 * slopes[n:])
