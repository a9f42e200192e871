"""Machines of many contacts in motion: how much slower than real time a closed loop simulates, and by which code.

A run is a platform on six legs that follows a circle under a wrench, with all controllers at 1 kHz. Its time is that
of the processor, as the machine may be busy otherwise. The other code is what the engine of bond graphs generates from the graph
of the platform, in plain floats, at one state and one configuration.
"""

from __future__ import annotations

import math
import time
import timeit
from collections.abc import Iterator

import numpy as np

import infinivar as iv
from benchmarks._measure import STUDY, Line
from infinivar.bondgraph.model import model
from infinivar.bondgraph.namespaces import FloatNamespace
from infinivar.machines.system import System

SLOWER = 1.0
"""Most times slower than real time, compiled."""

_DURATION = 0.4
_PERIOD = 0.4
_ROWS = (1, 3, 26)
"""States in one call: one, the points of a step, and the columns of a Jacobian."""


def platform() -> tuple[iv.machines.PlatformMachine, iv.motion.MachineScenario]:
    """The machine and its scenario."""
    leg = iv.load_study(STUDY).drives["cobotic"]
    assert isinstance(leg, iv.CoboticDrive)
    machine = iv.machines.PlatformMachine(
        leg=leg, platform=iv.transmission.Platform.hexapod(), mass=1.0, inertia=[1e-3, 1e-3, 2e-3]
    )

    def pose(at: float) -> np.ndarray:
        angle = 2.0 * math.pi * at / _PERIOD - math.sin(2.0 * math.pi * at / _PERIOD)
        rise = 1.0 - math.cos(angle)
        return machine.home + np.array([-0.004 * rise, 0.004 * math.sin(angle), 0.0015 * rise, 0.0, 0.0, 0.026 * rise])

    motion = iv.motion.VectorHistory.of(pose, _DURATION)
    return machine, iv.motion.MachineScenario(
        duration=_DURATION, motion=motion, wrench=[-5.0, 0.0, 20.0, 0.0, -0.1, 0.0]
    )


def run() -> Iterator[Line]:
    """Measure a run, and both codes at one state."""
    machine, scenario = platform()
    spent = []
    for _ in range(3):
        start = time.process_time()
        found = iv.simulate_machine(machine, scenario)
        spent.append(time.process_time() - start)
        assert found.complete
        assert found.closure < 1e-6
    ratio = float(np.median(spent)) / _DURATION
    yield Line(
        what="six-leg closed loop at 1 kHz, processor time over real time",
        ours=f"{ratio:.3g} ({min(spent) / _DURATION:.3g} to {max(spent) / _DURATION:.3g})",
        theirs="",
        ratio="",
        target=f"<= {SLOWER:g}",
        passed=ratio <= SLOWER,
    )
    generated = _of_graph(machine)
    for rows in _ROWS:
        ours = _of_functions(machine, rows)
        yield Line(
            what=f"rates of the platform at {rows} states",
            ours=f"{1e6 * ours:.0f} us",
            theirs=f"code of the graph: {1e6 * rows * generated:.0f} us without kinematics and steering",
            ratio=f"{ours / (rows * generated):.2f}",
        )


def _of_functions(machine: iv.machines.PlatformMachine, rows: int) -> float:
    """Seconds of one call of the functions that are integrated."""
    mechanics = machine.mechanics(1e-4)
    system = System(mechanics=mechanics, motor=machine.power_motor(1e-4), servo=machine.servo(1e-4))
    state = np.concatenate([machine.home, [0.01, 0.02, 0.03, 0.1, 0.2, 0.3], [14.0], np.full(6, 0.05), np.zeros(6)])
    states, times, inputs = np.repeat(state[None], rows, 0), np.zeros(rows), system.idle()
    return _seconds(lambda: system.rates(inputs, times, states))


def _of_graph(machine: iv.machines.PlatformMachine) -> float:
    """Seconds of one call of the code of the graph, for one state."""
    graph = iv.machine_graph(machine, servos=False)
    made = model(graph)
    parameters = {symbol: parameter.value for symbol, parameter in graph.parameters.items()}
    dynamics = made.function("dynamics", FloatNamespace, parameters)
    jacobian = machine.platform.at(machine.home[:3]).jacobian
    inputs = [
        float(jacobian[int(name[2]) - 1, int(name[3]) - 1]) if name.startswith("J_") else 0.05 for name in made.inputs
    ]
    states = [14.0 if name == "J_c" else 0.01 for name in made.states]
    rates = [0.0] * len(made.rates)
    return _seconds(lambda: dynamics(states, inputs, rates))


def _seconds(call) -> float:
    return min(timeit.repeat(call, timer=time.process_time, number=100, repeat=5)) / 100
