"""A drive as an actuator of MuJoCo: force, power, heat and energy are those of the program, within the limits."""

import functools
import itertools
import shutil
import subprocess
import tempfile
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import infinivar as iv
from infinivar.motion import Sinusoid
from internals import c_library, default_export_scenario, heat_rates, operated, warm_motor, warmed
from made import loaded
from run_cli import run

mujoco = pytest.importorskip("mujoco", reason="no MuJoCo: it comes with the extra robots")
pytestmark = pytest.mark.skipif(c_library.compiler() is None, reason="no C compiler: the plugin cannot be made")

CASES = [
    ("hand_controller", "cobotic"),
    ("hand_controller", "motor1-gear1"),
    ("knee_walking", "geared"),
    ("ankle_walking", "geared-series"),
    ("ankle_walking", "cobotic"),
]
LIMITS = ("SLIP", "VOLTAGE", "PEAK", "DEMAGNETISATION", "TEMPERATURE")
REFERENCE = 298.15
FOLDER = tempfile.TemporaryDirectory(prefix="infinivar-mujoco-")
COUNT = itertools.count()


@functools.cache
def exported(drive, load=0.8):
    """Files of a drive, whose plugin is loaded, and the name of the actuator: plugins of one process need names of their own."""
    name = f"drive_{next(COUNT)}"
    files = iv.export(drive, "mujoco", FOLDER.name, name=name, load_mass=load).files
    mujoco.mj_loadPluginLibrary(str(files[0]))
    return files, name


class Actuator:
    """The model that comes with a drive."""

    def __init__(self, drive, load=0.8, **options):
        files, self.name = exported(drive, load)
        self.model = mujoco.MjModel.from_xml_path(str(files[3]))
        for option, value in options.items():
            setattr(self.model.opt, option, value)
        self.data = mujoco.MjData(self.model)

    def at(self, *, position=0.0, speed=0.0, command=0.0, rise=0.0):
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos, self.data.qvel, self.data.ctrl = position, speed, command
        self.data.act[1:] = rise
        mujoco.mj_forward(self.model, self.data)
        return self.data.actuator_force[0]

    def get(self, what):
        return float(self.data.sensor(f"{self.name}.{what}").data[0])

    @property
    def measured(self):
        names = (self.model.sensor(place).name.rpartition(".")[2] for place in range(self.model.nsensor))
        return {name: self.get(name) for name in names}


def drive_of(case):
    return loaded(case[0]).drives[case[1]]


def hottest(drive, position, speed, force, rise):
    """Largest demand among the limits of the program's own point, and whether there is one."""
    point = operated(warmed(drive, {"motor": REFERENCE + rise}), position=position, speed=speed, force=force)
    found = [float(value) for limit, value in point.utilisation.items() if limit.name in LIMITS]
    return max(found) if np.isfinite(found).all() and np.isfinite(point.power_in) else np.inf


@pytest.mark.parametrize("case", CASES, ids=" ".join)
def test_force_power_and_losses_at_random_states_are_those_of_the_program(case):
    """To 1e-9, with warm windings; where the force is cut, a limit is reached, and a little more is beyond it."""
    drive, random = drive_of(case), np.random.default_rng(3)
    actuator, cut = Actuator(drive), 0
    for _ in range(50):
        position, rise = random.uniform(-0.2, 0.2), random.uniform(0.0, 60.0)
        speed, command = random.choice([-1, 1], 2) * 10.0 ** random.uniform((-2.0, 0.0), (0.0, 3.7))
        force = actuator.at(position=position, speed=speed, command=command, rise=rise)
        warm_drive = warmed(drive, {"motor": REFERENCE + rise})
        point = operated(warm_drive, position=position, speed=speed, force=force)
        wanted = {"power_in_W": point.power_in, **point.states}
        wanted |= {f"loss_{name.replace(' ', '_')}_W": loss for name, loss in point.losses.items()}
        wanted |= {f"demand_{limit.name}": demand for limit, demand in point.utilisation.items()}
        found = actuator.measured
        for name, value in wanted.items():
            assert found[name] == pytest.approx(float(value), rel=1e-9, abs=1e-12, nan_ok=True), name
        within = hottest(drive, position, speed, command, rise) <= 1.0 and found["demand_TEMPERATURE"] <= 1.0
        if within:
            assert force == command
        elif force and abs(force) <= abs(command) and force * command > 0.0:
            cut += 1
            worst = max(found[f"demand_{name}"] for name in LIMITS if f"demand_{name}" in found)
            assert worst <= 1.0 + 1e-9
            beyond = hottest(drive, position, speed, force * (1.0 + 1e-6), rise)
            assert beyond > 1.0 or found["demand_TEMPERATURE"] == pytest.approx(1.0, abs=1e-9)
    assert cut


def test_the_force_ends_where_the_voltage_of_the_program_is_that_of_the_supply():
    drive = drive_of(CASES[1])
    actuator, speed = Actuator(drive), 0.2

    def over(force):
        return drive.operate(speed=speed, force=force).utilisation[iv.Limit.VOLTAGE] - 1.0

    force = actuator.at(speed=speed, command=1e4)
    assert force == pytest.approx(brentq(over, 1.0, 1e4, xtol=1e-12), rel=1e-9)
    assert actuator.get("motor_voltage_V") == pytest.approx(drive.motor.voltage, rel=1e-9)


def test_the_force_ends_where_the_wheel_of_the_program_slips():
    """In both directions, at a point where the supply would permit more."""
    drive = drive_of(CASES[0])
    actuator, speed = Actuator(drive), 0.05

    def over(force):
        return drive.operate(speed=speed, force=force).utilisation[iv.Limit.SLIP] - 1.0

    for sign in (1.0, -1.0):
        force = actuator.at(speed=speed, command=sign * 1e4)
        least = brentq(lambda size, sign=sign: over(sign * size), 1.0, 1e3, xtol=1e-12)
        assert force == pytest.approx(sign * least, rel=1e-9)
        assert actuator.get("demand_VOLTAGE") < 1.0


def test_above_the_no_load_speed_the_voltage_of_the_motor_brakes():
    drive = drive_of(CASES[1])
    actuator = Actuator(drive)
    fastest = brentq(lambda v: drive.operate(speed=v, force=0.0).utilisation[iv.Limit.VOLTAGE] - 1.0, 0.1, 1.0)
    for speed in (1.01 * fastest, -1.5 * fastest, 4.0 * fastest):
        force = actuator.at(speed=speed, command=0.0)
        assert force * speed < 0.0
        assert abs(actuator.get("motor_voltage_V")) == pytest.approx(drive.motor.voltage, rel=1e-9)
    assert abs(actuator.at(speed=0.99 * fastest)) == 0.0


def sinusoid(actuator, amplitude, frequency):
    """Energy of the supply over a cycle whose inertial force is commanded, from the middle."""
    turn = 2.0 * np.pi * frequency
    model, data = actuator.model, actuator.data
    moved = float(model.body_mass[1] + model.dof_armature[0])
    mujoco.mj_resetData(model, data)
    data.qvel = amplitude * turn
    for _ in range(round(1.0 / (frequency * model.opt.timestep))):
        data.ctrl = -moved * amplitude * turn**2 * np.sin(turn * data.time)
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    assert data.qpos[0] == pytest.approx(0.0, abs=1e-3 * amplitude)
    return actuator.get("energy_J")


def cold(drive, **values):
    return replace(drive, motor=replace(drive.motor, winding_to_housing=None, **values))


@pytest.mark.parametrize(
    ("integrator", "off"), [(mujoco.mjtIntegrator.mjINT_EULER, 4e-4), (mujoco.mjtIntegrator.mjINT_RK4, 1e-5)]
)
def test_energy_of_the_supply_is_that_of_the_duty_cycle(integrator, off):
    """Of first order in the step with Euler's method, as MuJoCo's motion itself; the rotor has no inertia here."""
    drive = cold(drive_of(CASES[1]), rotor_inertia=1e-15)
    cycle = iv.duty_cycle(drive, iv.DutyCycle(motion=Sinusoid(distance=0.02, frequency=1.0), load_mass=0.8))
    errors = [
        sinusoid(Actuator(drive, timestep=step, integrator=integrator), 0.02, 1.0) / cycle.energy - 1.0
        for step in (2e-3, 1e-3)
    ]
    assert abs(errors[1]) < off
    assert abs(errors[1]) < 0.6 * abs(errors[0])


def test_energy_with_a_rotor_is_that_of_the_duty_cycle_but_for_the_gear_loss_of_its_inertia():
    """The armature of the joint stands for the rotor: the gear here also transmits what accelerates it."""
    drive = cold(drive_of(CASES[1]))
    actuator = Actuator(drive, timestep=1e-3)
    assert actuator.model.dof_armature[0] == pytest.approx(8.0116, rel=1e-9)
    cycle = iv.duty_cycle(drive, iv.DutyCycle(motion=Sinusoid(distance=0.02, frequency=1.0), load_mass=0.8))
    assert sinusoid(actuator, 0.02, 1.0) == pytest.approx(cycle.energy, rel=2e-3)


def test_energy_of_a_cobotic_drive_is_that_of_the_duty_cycle_without_steering():
    drive = cold(drive_of(CASES[0]))
    cycle = iv.duty_cycle(drive, iv.DutyCycle(motion=Sinusoid(distance=0.02, frequency=1.0), load_mass=0.8))
    steering = sum(float(np.mean(loss)) for name, loss in cycle.point.losses.items() if name.startswith("steering"))
    assert 0.01 < steering / cycle.energy < 0.1
    assert sinusoid(Actuator(drive, timestep=1e-3), 0.02, 1.0) == pytest.approx(cycle.energy - steering, rel=1e-4)


def test_temperatures_are_those_of_the_thermal_model():
    """A stalled motor for a minute, against the program's matrix of rates, integrated by SciPy."""
    drive = drive_of(CASES[1])
    actuator = Actuator(drive, timestep=1e-2)
    command = 60.0
    model, data = actuator.model, actuator.data
    mujoco.mj_resetData(model, data)
    data.ctrl = command
    data.qfrc_applied = -command
    for _ in range(6000):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    current = float(drive.operate(speed=0.0, force=command).states["motor_current_A"])

    def slopes(_, temperatures):
        matrix, vector = heat_rates(drive.motor, current**2, 0.0, REFERENCE)
        return matrix[0] @ temperatures + vector[0]

    wanted = solve_ivp(slopes, (0.0, 60.0), [REFERENCE, REFERENCE], rtol=1e-10, atol=1e-8).y[:, -1]
    assert wanted[0] > REFERENCE + 5.0
    assert actuator.get("winding_K") - REFERENCE == pytest.approx(wanted[0] - REFERENCE, rel=2e-3)
    assert actuator.get("housing_K") - REFERENCE == pytest.approx(wanted[1] - REFERENCE, rel=2e-3)


def test_the_winding_stops_at_its_limit_and_the_force_falls():
    """From there on the force is what holds it there."""
    drive = drive_of(CASES[2])
    actuator = Actuator(drive, timestep=2e-3)
    model, data = actuator.model, actuator.data
    model.dof_damping[:] = 1e6  # nearly stalled
    data.ctrl = 1e5
    forces = []
    for _ in range(100000):
        mujoco.mj_step(model, data)
        forces.append(float(data.actuator_force[0]))
        assert data.act[1] + REFERENCE <= drive.motor.max_winding_temperature + 1e-6
    assert data.act[1] + REFERENCE == pytest.approx(drive.motor.max_winding_temperature, abs=0.01)
    assert 0.0 < forces[-1] < 0.9 * forces[0]
    hot = warm_motor(drive.motor, drive.motor.max_winding_temperature)
    across = data.act[1] - data.act[2]
    held = float(np.sqrt(across / drive.motor.winding_to_housing / hot.resistance))
    assert actuator.get("motor_current_A") == pytest.approx(held, rel=0.01)


def test_ranges_of_command_and_force_hold():
    actuator = Actuator(drive_of(CASES[1]))
    model = actuator.model
    model.actuator_ctrllimited[0], model.actuator_ctrlrange[0] = 1, (-3.0, 3.0)
    assert actuator.at(speed=0.1, command=5.0) == 3.0
    model.opt.disableflags = mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL
    assert actuator.at(speed=0.1, command=5.0) == 5.0
    model.opt.disableflags = 0
    model.actuator_forcelimited[0], model.actuator_forcerange[0] = 1, (-2.0, 2.0)
    assert actuator.at(speed=0.1, command=-5.0) == -2.0
    held = float(drive_of(CASES[1]).operate(speed=0.1, force=-2.0).power_in)
    assert actuator.get("power_in_W") == pytest.approx(held, rel=1e-9)


def several(drives):
    """A model with a joint, an actuator and a battery meter for each drive."""
    names = [exported(drive)[1] for drive in drives]
    known = list(enumerate(names))
    plugins = "".join(
        f'<plugin plugin="infinivar.{name}">'
        + "".join(f'<instance name="i{place}"/>' for place, other in known if other == name)
        + "</plugin>"
        for name in dict.fromkeys(names)
    )
    bodies = "".join(
        f'<body><joint name="j{place}" type="slide" axis="1 0 0" damping="3"/>'
        '<inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/></body>'
        for place, _ in known
    )
    actuators = "".join(
        f'<plugin joint="j{place}" plugin="infinivar.{name}" instance="i{place}" actdim="3"/>' for place, name in known
    )
    sensors = "".join(
        f'<plugin name="{place}.energy_J" plugin="infinivar.{name}" instance="i{place}"/>' for place, name in known
    )
    text = (
        f'<mujoco><option gravity="0 0 0"/><extension>{plugins}</extension><worldbody>{bodies}</worldbody>'
        f"<actuator>{actuators}</actuator><sensor>{sensors}</sensor></mujoco>"
    )
    return mujoco.MjModel.from_xml_string(text)


def moved(model, commands, steps=500):
    data = mujoco.MjData(model)
    data.ctrl = commands
    for _ in range(steps):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    return np.stack([data.qvel, data.sensordata])


def test_instances_do_not_disturb_each_other():
    """Two of one drive and one of another move as each alone, to the last bit."""
    drives = [drive_of(CASES[1]), drive_of(CASES[1]), drive_of(CASES[0])]
    commands = [3.0, 1e4, -5.0]
    together = moved(several(drives), commands)
    alone = [moved(several([drive]), [command]) for drive, command in zip(drives, commands, strict=True)]
    np.testing.assert_array_equal(together, np.hstack(alone))


def test_fragments_of_several_drives_go_into_one_model(tmp_path):
    files, names = zip(*(exported(drive_of(case)) for case in CASES[:2]), strict=True)
    for one in files:
        (tmp_path / one[2].name).write_bytes(one[2].read_bytes())
    parts = "".join(f'<include file="{one[2].name}"/>' for one in files)
    body = '<body><joint name="{}" type="slide"/><geom size="0.1" mass="1"/>'
    bodies = "".join(map(body.format, names)) + "</body></body>"
    (tmp_path / "robot.xml").write_text(f"<mujoco>{parts}<worldbody>{bodies}</worldbody></mujoco>", "utf-8")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert [model.actuator(place).name for place in range(model.nu)] == list(names)
    assert model.na == 6


def test_threads_do_not_disturb_each_other():
    model = several([drive_of(CASES[1]), drive_of(CASES[0])])
    commands = [(place, -2.0 * place) for place in range(8)]
    found = {}
    threads = [threading.Thread(target=lambda one=one: found.update({one: moved(model, one)})) for one in commands]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    for one in commands:
        np.testing.assert_array_equal(found[one], moved(model, one))


def test_a_saved_state_goes_on_as_if_it_had_not_been_saved():
    actuator = Actuator(drive_of(CASES[0]))
    model, data = actuator.model, actuator.data
    data.ctrl = 20.0
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    for _ in range(100):
        mujoco.mj_step(model, data)
    state = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    other = mujoco.MjData(model)
    mujoco.mj_setState(model, other, state, kind)
    for one in (data, other):
        for _ in range(100):
            mujoco.mj_step(model, one)
    np.testing.assert_array_equal(data.act, other.act)
    assert data.act[0] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("sanitizers", ["address,undefined", "thread"])
def test_sanitizers_find_nothing(sanitizers, tmp_path):
    """Steps of eight threads, at commands within limits, beyond them, and not finite."""
    files, name = exported(drive_of(CASES[0]))
    package = Path(mujoco.__file__).parent
    (library,) = package.glob("libmujoco.so.*")
    source = tmp_path / "run.c"
    source.write_text(MAIN.replace("NAME", name), "utf-8")
    flags = ["-std=gnu99", "-g", "-O1", "-Wall", "-Wextra", "-Werror", f"-fsanitize={sanitizers}", "-isystem"]
    plugin = [str(files[1]), str(library), f"-Wl,-rpath,{package}", "-lm", "-lpthread"]
    made = [*c_library.compiler(), *flags, str(package / "include"), str(source), *plugin, "-o", "run"]
    done = subprocess.run(made, cwd=tmp_path, capture_output=True, text=True)
    if "cannot find" in done.stderr:
        pytest.skip(f"the compiler has no library of the sanitizer {sanitizers}")
    assert not done.returncode, done.stderr
    done = subprocess.run(["./run", str(files[3])], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert not done.returncode, done.stderr
    assert "ERROR" not in done.stderr
    assert "runtime error" not in done.stderr
    assert float(done.stdout) > 0.0


MAIN = """#include <math.h>
#include <mujoco/mujoco.h>
#include <pthread.h>
#include <stdio.h>

static mjModel *m;

static void *moved(void *out)
{
    static const double commands[] = {5.0, -1e5, NAN, 0.0, INFINITY, 60.0};
    mjData *d = mj_makeData(m), *other = mj_makeData(m);
    for (int i = 0; i < 1200; i++) {
        d->ctrl[0] = commands[i / 200];
        mj_step(m, d);
    }
    mj_copyData(other, m, d);
    mj_step(m, other);
    *(double *)out = other->act[0];
    mj_deleteData(other);
    mj_deleteData(d);
    return NULL;
}

int main(int count, char **arguments)
{
    char problem[500] = "";
    double energies[8];
    pthread_t threads[8];
    m = count > 1 ? mj_loadXML(arguments[1], NULL, problem, sizeof problem) : NULL;
    if (!m) {
        fputs(problem, stderr);
        return 1;
    }
    for (int i = 0; i < 8; i++) {
        pthread_create(threads + i, NULL, moved, energies + i);
    }
    for (int i = 0; i < 8; i++) {
        pthread_join(threads[i], NULL);
        if (energies[i] != energies[0]) {
            return 2;
        }
    }
    printf("%g\\n", energies[0]);
    mj_deleteModel(m);
    return 0;
}
"""


@pytest.mark.parametrize(
    ("written", "instead", "said"),
    [
        (".energy_J", ".energie_J", "must end in '.' and one of: energy_J, winding_K"),
        ('value="298.15"', 'value="warm"', "ambient must be a temperature in K, such as 298.15"),
        ('value="298.15"', 'value="-1"', "ambient must be a temperature in K"),
        ('actdim="3"', "", 'needs exactly one actuator, with actdim="3"'),
        ('type="slide"', 'type="hinge"', "the joint of the actuator must be of type slide"),
    ],
)
def test_a_model_with_a_fault_says_what_is_right(written, instead, said, tmp_path):
    files, _ = exported(drive_of(CASES[1]))
    for file in files[2:]:
        (tmp_path / file.name).write_text(file.read_text("utf-8").replace(written, instead), "utf-8")
    with pytest.raises(ValueError, match=r"plugin->init failed") as raised:
        mujoco.MjModel.from_xml_path(str(tmp_path / files[3].name))
    assert said in str(raised.value)


def test_ambient_of_an_instance_is_where_temperatures_begin(tmp_path):
    files, name = exported(drive_of(CASES[1]))
    for file in files[2:]:
        (tmp_path / file.name).write_text(file.read_text("utf-8").replace("298.15", "310"), "utf-8")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / files[3].name))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.sensor(f"{name}.winding_K").data[0] == 310.0
    assert data.sensor(f"{name}.motor_voltage_V").data[0] == 0.0


def test_a_second_plugin_of_a_name_is_refused(tmp_path):
    """The library loads, as an error within the loader would leave it locked; models of the other drive are refused."""
    files, name = exported(drive_of(CASES[1]))
    for case, same in ((CASES[0], False), (CASES[1], True)):
        other = iv.export(drive_of(case), "mujoco", tmp_path / str(same), name=name).files
        mujoco.mj_loadPluginLibrary(str(other[0]))
        if same:
            mujoco.MjModel.from_xml_path(str(other[3]))
            continue
        with pytest.raises(ValueError, match="plugin->init failed") as raised:
            mujoco.MjModel.from_xml_path(str(other[3]))
        assert f"infinivar.{name}: this process has loaded another drive of that name before" in str(raised.value)
    mujoco.MjModel.from_xml_path(str(files[3]))


def test_the_same_drive_gives_the_same_text(tmp_path):
    drive = drive_of(CASES[0])
    one, other = (iv.export(drive, "mujoco", tmp_path / place, name="a-b").files for place in "ab")
    assert [file.name for file in one[1:]] == ["a_b_mujoco.c", "a_b_actuator.xml", "a_b.xml"]
    assert [file.read_bytes() for file in one] == [file.read_bytes() for file in other]
    assert "malloc" not in one[1].read_text("utf-8")


def test_the_command_writes_a_model_and_names_what_it_assumes(tmp_path):
    done = run("export", "knee_walking", "geared", "--as", "mujoco", "--out", "out", folder=tmp_path)
    assert done.code == 0
    assert "the load of geared.xml is 1 kg: none is stated" in done.out
    assert {one.name for one in (tmp_path / "out").iterdir()} >= {
        "geared_mujoco.c",
        "geared_actuator.xml",
        "geared.xml",
    }


def test_without_mujoco_or_a_compiler_the_command_says_what_to_install(tmp_path, monkeypatch):
    arguments = ("export", "hand_controller", "cobotic", "--as", "mujoco", "--out", "out")
    with monkeypatch.context() as patch:
        patch.setenv("INFINIVAR_COMPILE", "0")
        done = run(*arguments, folder=tmp_path)
    assert done.code == 2
    assert (
        "--as mujoco needs a C compiler: cc, gcc, clang or that of the variable CC, and INFINIVAR_COMPILE not 0"
        in done.err
    )
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    done = run(*arguments, folder=tmp_path)
    assert done.code == 2
    assert "--as mujoco needs mujoco; install it with: pip install 'infinivar[robots]'" in done.err
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_a_scenario_does_not_apply():
    drive = drive_of(CASES[0])
    with pytest.raises(iv.ParameterError, match="scenario must be left out: MuJoCo has the load and the motion"):
        iv.export(drive, "mujoco", scenario=default_export_scenario(drive, 0.8))


def test_a_law_without_c_and_a_compiler_that_fails_are_input_errors(tmp_path, monkeypatch):
    drive = drive_of(CASES[0])

    def force(creepage):
        known = np.clip(creepage, -1.25, 1.25)
        return 2.0 * known / (1.0 + np.sqrt(1.0 + np.abs(known)))

    own = {"creepage": lambda x: x + 0.25 * x * abs(x), "slope": lambda x: 1.0 + 0.5 * abs(x), "force": force}
    law = iv.contact.CreepLaw(name="own", slip_creepage=1.25, **own)
    with pytest.raises(iv.InputError, match="a law of the drive has no C"):
        iv.export(replace(drive, transmission=replace(drive.transmission, creep_law=law)), "mujoco", tmp_path)
    broken = tmp_path / "broken"
    broken.write_text(
        "#!/bin/sh\necho 'in file mujoco.h:' >&2\necho 'mujoco.h:3: error: no such type' >&2\nexit 1\n", "utf-8"
    )
    broken.chmod(0o755)
    for compiler, words in (
        (shutil.which("false"), "without a word"),
        (str(broken), "mujoco.h:3: error: no such type"),
    ):
        monkeypatch.setattr(c_library, "_found", lambda own, compiler=compiler: compiler)
        with pytest.raises(
            iv.InputError, match=f"the C compiler {compiler} failed with the headers of MuJoCo in .*: {words}"
        ):
            iv.export(drive, "mujoco", tmp_path / "out")
    assert not (tmp_path / "out").exists()
