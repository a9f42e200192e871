"""Springs, hysteresis and linkages between drive and load, simulated: energy closes, and inverse dynamics says the same."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_simulation import SHIPPED, check_energy, cobotic_drives, conventional_drives

import infinivar as iv
from infinivar import DutyCycle, Limit, Output, ParameterError, Scenario, plant_graph
from infinivar.analysis import two_ways
from infinivar.motion import ConstantForce, Reach, Sinusoid, SinusoidalForce, StepForce, Walking
from infinivar.parts import Linkage, Shaft, Spring, TorsionSpring
from sampled import examples, sampled

PROGRESSIVE = Spring(
    shape="progressive", deflections=(-0.01, -0.005, 0.0, 0.005, 0.01), forces=(-300.0, -100.0, 0.0, 100.0, 300.0)
)
CRANK = Linkage(shape="crank", arm=0.05, base=0.2, offset=1.5)
TABLE = Linkage(shape="table", angles=(-1.0, -0.5, 0.0, 0.5, 1.0), arms=(0.03, 0.04, 0.05, 0.04, 0.03))
FOUR_BAR = Linkage(shape="four-bar", arm=0.05, base=0.2, offset=1.5, crank=0.05, coupler=0.2)

OUTPUTS = {
    "parallel": Output(parallel_spring=Spring(stiffness=1e3, rest=0.01, preload=3.0)),
    "series": Output(series_spring=Spring(stiffness=1e4)),
    "progressive": Output(series_spring=PROGRESSIVE),
    "one-sided": Output(parallel_spring=Spring(shape="one-sided", stiffness=1e3, contact_width=1e-3)),
    "one-sided, negative": Output(
        parallel_spring=Spring(shape="one-sided", stiffness=1e3, contact_width=1e-3, side="negative")
    ),
    "hysteresis": Output(series_spring=Spring(stiffness=1e4, hysteresis=5.0)),
    "parallel hysteresis": Output(parallel_spring=Spring(stiffness=500.0, hysteresis=3.0)),
    "lever": Output(linkage=Linkage(arm=0.05)),
    "crank": Output(linkage=CRANK),
    "table": Output(linkage=TABLE),
    "all": Output(
        linkage=CRANK,
        series_spring=PROGRESSIVE,
        parallel_spring=Spring(stiffness=300.0, rest=0.2, at="drive"),
        parallel_torsion_spring=TorsionSpring(stiffness=1.0, hysteresis=0.05),
        series_torsion_spring=TorsionSpring(stiffness=300.0),
    ),
}


def with_output(name, output):
    return replace(SHIPPED.drives[name], output=output)


def cycle(output):
    """One cycle per second, with the load pushed to one side."""
    if output.linkage is not None:
        return DutyCycle(motion=Sinusoid(angle=0.3, frequency=1.0), load_inertia=0.004, moment=0.5)
    return DutyCycle(motion=Sinusoid(distance=0.03, frequency=1.0), load_mass=1.5, force=-10.0)


def check_both_ways(drive, duty):
    """2 % of the energy; of the cobotic drive at the cylinder speed as simulated, which is not constant."""
    found = two_ways(drive, duty)
    assert found.simulation.complete
    prescribed = found.as_turning if found.speed_ripple else found.prescribed
    assert found.followed == pytest.approx(prescribed, rel=0.02)
    assert found.simulation.trajectory.closure < 1e-6
    for name, energy in found.lost_prescribed.items():
        assert found.lost_followed.get(name, 0.0) == pytest.approx(energy, abs=0.02 * found.followed)
    return found


@sampled("name", OUTPUTS, slow=3)
def test_a_geared_drive_takes_the_energy_that_inverse_dynamics_gives(name):
    found = check_both_ways(with_output("motor2-gear4", OUTPUTS[name]), cycle(OUTPUTS[name]))
    assert found.rms_error < 1e-3 * (0.3 if found.rotary else 0.03)


@sampled("name", OUTPUTS, slow=5)
def test_a_cobotic_drive_takes_the_energy_that_inverse_dynamics_gives(name):
    check_both_ways(with_output("cobotic", OUTPUTS[name]), cycle(OUTPUTS[name]))


@pytest.mark.slow
@sampled("drive", ["motor2-gear4", pytest.param("cobotic", marks=pytest.mark.slow)], every=2)
@sampled("hysteresis", [2.0, None], slow=2)
def test_a_joint_without_inertia_behind_a_spring(drive, hysteresis):
    """The moment alone determines the deflection: a compliance without a state of its own."""
    output = Output(linkage=Linkage(arm=0.06), series_spring=Spring(stiffness=3e4, hysteresis=hysteresis))
    duty = DutyCycle(motion=Walking(joint="knee", body_mass=2.0, stride_time=1.2))
    found = check_both_ways(with_output(drive, output), duty)
    run = found.simulation.trajectory
    assert "series_spring" not in run.states or hysteresis
    moment = found.simulation.columns["moment_Nm"]
    np.testing.assert_allclose(run.at("series_spring_node")[0] * 0.06, -moment, atol=1e-9 * np.abs(moment).max())


@pytest.mark.slow
@sampled("linkage", [None, FOUR_BAR], every=2)
def test_a_shaft_with_torsion_springs_or_a_four_bar(linkage):
    geared = SHIPPED.drives["motor2-gear4"]
    output = Output(linkage=linkage, series_torsion_spring=TorsionSpring(stiffness=10.0))
    drive = replace(geared, pulley=None, shaft=Shaft(), guideway=iv.parts.Guideway(), output=output)
    check_both_ways(drive, DutyCycle(motion=Sinusoid(angle=0.4, frequency=1.0), load_inertia=5e-4, moment=0.02))


def test_a_massless_load_that_cannot_determine_a_deflection_is_refused():
    drive = with_output("motor2-gear4", OUTPUTS["progressive"])
    with pytest.raises(ParameterError, match="load_mass is missing: a progressive series spring can be simulated only"):
        iv.simulate(drive, Scenario(duration=0.1, force=ConstantForce(size=3.0)))
    linear = with_output("motor2-gear4", OUTPUTS["series"])
    with pytest.raises(ParameterError, match=r"load_mass is missing: the force jumps at 0.05 s"):
        iv.simulate(linear, Scenario(duration=0.1, force=StepForce(size=3.0, start=0.05)))


def test_a_scenario_along_a_line_is_refused_by_a_joint():
    with pytest.raises(ParameterError, match="the scenario is along a line; the drive moves a joint"):
        iv.simulate(with_output("motor2-gear4", OUTPUTS["lever"]), Scenario(duration=0.1, load_mass=1.0))


@st.composite
def springs(draw, kind, size, deflection):
    """A spring of a force at a deflection, of any shape, with or without hysteresis."""
    shape = draw(st.sampled_from(["linear", "progressive", "one-sided"]))
    force = draw(st.floats(0.1, 1.0)) * size
    hysteresis = draw(st.sampled_from([None, 0.1 * force]))
    if shape == "linear":
        return kind(stiffness=force / deflection, preload=draw(st.floats(-0.3, 0.3)) * force, hysteresis=hysteresis)
    if shape == "one-sided":
        side = draw(st.sampled_from(["positive", "negative"]))
        return kind(shape=shape, stiffness=force / deflection, contact_width=0.1 * deflection, side=side)
    bend = draw(st.floats(0.6, 0.9))
    reach = tuple(deflection * share for share in (-1.0, -0.5, 0.0, 0.5, 1.0))
    forces = tuple(force * share for share in (-1.0, -0.5 * bend, 0.0, 0.5 * bend, 1.0))
    return kind(shape=shape, deflections=reach, forces=forces, hysteresis=hysteresis)


@st.composite
def outputs(draw):
    """Any springs and linkage; a series spring that cannot pull is left out, as its load would fly away."""
    linkage = draw(st.sampled_from([None, Linkage(arm=0.05), CRANK, TABLE]))
    series = draw(springs(Spring, 100.0, 0.005).filter(lambda spring: spring.shape != "one-sided"))
    parallel = draw(springs(Spring, 10.0, 0.03))
    torsion = draw(springs(TorsionSpring, 0.5, 0.5)) if linkage is not None else None
    return Output(
        linkage=linkage,
        series_spring=draw(st.sampled_from([None, series])),
        parallel_spring=draw(st.sampled_from([None, parallel, replace(parallel, at="drive")])),
        parallel_torsion_spring=draw(st.sampled_from([None, torsion])),
    )


@st.composite
def runs(draw, output):
    """At rest, driven, or back-driven by the load."""
    kind = draw(st.sampled_from(["rest", "sinusoid", "reach", "imposed", "pushed"]))
    joint = output.linkage is not None
    size = {"angle": draw(st.floats(-0.3, 0.3).filter(bool))} if joint else {"distance": draw(st.floats(0.002, 0.02))}
    push = {"moment": draw(st.floats(0.05, 0.5))} if joint else {"size": draw(st.floats(1.0, 20.0))}
    motion = {
        "sinusoid": Sinusoid(**size, frequency=draw(st.floats(0.5, 3.0))),
        "imposed": Sinusoid(**size, frequency=draw(st.floats(0.5, 3.0))),
        "reach": Reach(**size, time=0.1, start=0.02),
    }.get(kind)
    mass = draw(st.floats(0.3, 2.0))
    return Scenario(
        duration=0.15,
        output_step=0.01,
        motion=motion,
        link="imposed" if kind == "imposed" else "controlled",
        force=None if kind in ("imposed", "rest") else SinusoidalForce(**push, frequency=draw(st.floats(1.0, 10.0))),
        load_mass=None if joint else mass,
        load_inertia=0.0025 * mass if joint else None,
    )


@pytest.mark.slow
@given(st.data())
@examples(3)
def test_energy_closes_behind_any_output(data):
    check_any(data, conventional_drives())


@pytest.mark.slow
@given(st.data())
@examples(2)
def test_energy_closes_behind_more_outputs(data):
    """Deriving the equations of one random drive takes up to half a minute, so this is a small sample."""
    check_any(data, conventional_drives())
    check_any(data, cobotic_drives())


@pytest.mark.full
@given(st.data())
@examples(15)
def test_energy_closes_behind_many_outputs(data):
    check_any(data, conventional_drives())
    check_any(data, cobotic_drives())


def check_any(data, drives):
    output = data.draw(outputs())
    check_energy(replace(data.draw(drives), output=output), data.draw(runs(output)))


@pytest.mark.slow
def test_resonance_of_a_locked_drive_with_a_series_spring():
    """The locked link holds one end of the spring: the load oscillates at sqrt(k/m) about its rest position."""
    stiffness, mass = 20000.0, 0.8
    drive = with_output("cobotic", Output(series_spring=Spring(stiffness=stiffness)))
    scenario = Scenario(
        duration=0.25,
        output_step=1e-3,
        steering="locked",
        cylinder="at rest",
        force=ConstantForce(size=0.5),
        load_mass=mass,
    )
    found = iv.simulate(drive, scenario).columns
    swing = found["position_m"] - 0.5 / stiffness
    rising = np.flatnonzero((swing[:-1] < 0) & (swing[1:] >= 0))
    crossings = found["time_s"][rising] - swing[rising] * 1e-3 / (swing[rising + 1] - swing[rising])
    assert len(crossings) >= 5
    assert np.diff(crossings) == pytest.approx(2.0 * np.pi * np.sqrt(mass / stiffness), rel=2e-3)


def test_limits_of_springs_and_linkage_are_events():
    short = Spring(shape="progressive", deflections=(-0.002, 0.0, 0.002), forces=(-5.0, 0.0, 5.0))
    push = Scenario(duration=0.3, load_mass=1.0, force=SinusoidalForce(size=8.0, frequency=2.0))
    result = iv.simulate(with_output("motor2-gear4", Output(series_spring=short)), push)
    assert {(event.limit, event.what) for event in result.events} >= {(Limit.SPRING, "series spring")}
    found = result.columns
    deflection = found["drive_position_m"] - found["position_m"]
    np.testing.assert_allclose(found["series_spring_deflection_m"], deflection, atol=1e-9)
    over = next(event for event in result.events if event.limit == Limit.SPRING)
    # The peak lies between outputs 0.3 ms apart: of an 8 N push at 2 Hz, (w dt)^2/8 = 2e-6 above them.
    assert over.worst == pytest.approx(np.abs(deflection).max() / 0.002, rel=3e-6)
    assert over.worst >= np.abs(deflection).max() / 0.002

    narrow = replace(TABLE, angles=(-0.1, -0.05, 0.0, 0.05, 0.1))
    swing = Scenario(duration=0.5, load_inertia=0.004, motion=Sinusoid(angle=0.2, frequency=1.0))
    result = iv.simulate(with_output("motor2-gear4", Output(linkage=narrow)), swing)
    beyond = next(event for event in result.events if event.limit == Limit.LINKAGE)
    assert beyond.start == pytest.approx(np.arcsin(0.5) / (2.0 * np.pi), abs=1e-3)
    assert "angle error" in result.verdict


def test_load_and_drive_start_as_planned():
    """A motion that begins at full speed behind springs and a crank has no jolt."""
    duty = cycle(OUTPUTS["all"])
    scenario = Scenario(duration=0.05, output_step=1e-3, motion=duty.motion, load_inertia=duty.load_inertia)
    result = iv.simulate(with_output("motor2-gear4", OUTPUTS["all"]), scenario)
    assert result.position_error.max() < 1e-4
    speed = 0.3 * 2.0 * np.pi * np.cos(2.0 * np.pi * result.columns["time_s"])
    np.testing.assert_allclose(result.columns["speed_rad_s"], speed, rtol=2e-2)


@pytest.mark.parametrize("drive", ["cobotic", "motor2-gear4"])
def test_a_drive_without_an_output_has_the_graph_it_had(drive):
    names = {element.name for element in plant_graph(SHIPPED.drives[drive], load_mass=0.8).elements}
    added = {e.name for e in plant_graph(with_output(drive, OUTPUTS["all"]), load_mass=0.8).elements} - names
    assert added == {
        *(["line"] if drive == "motor2-gear4" else []),
        "parallel_torsion_spring",
        "parallel_torsion_spring_friction",
        "parallel_torsion_spring_hysteresis",
        "parallel_torsion_spring_yield",
        "series_torsion_spring",
        "series_torsion_spring_end",
        "series_torsion_spring_node",
        "linkage",
        "linkage_end",
        "series_spring",
        "series_spring_node",
        "parallel_spring",
    }
