"""Figures of pages, drawn from the program when the documentation is built, and the page parts that go with them."""

import multiprocessing
import types
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import infinivar
from infinivar import units
from infinivar.study.load import shipped_study


def figure_of_paper(number: int, title: str, caption: str, claims: list) -> str:
    """Image, caption and claims of a figure of the paper; number 0 stands for claims without a figure."""
    text = [f"![{title}](reference/generated/fig{number}.svg)\n", f"{caption}\n"] if number else []
    for claim in claims:
        found = f"{_claimed(claim.computed, claim.unit)} (threshold: {claim.threshold})"
        said = f"Paper, section {claim.section}: {_claimed(claim.paper, claim.unit)}. Computed: {found}. {claim.why}"
        text.append(f"{claim.id} {claim.claim}: **{claim.verdict}**\n: {said}\n")
    return "\n".join(text)


def _claimed(value, unit: str) -> str:
    return value if isinstance(value, str) else "none" if value is None else units.show(value, unit, 4)


def draw(app) -> None:
    """Draw the paper's figures, write their claims, and draw the figures of its contact and of a rolling patch."""
    from infinivar.analysis.contact_sheet import contact_sheet
    from infinivar.analysis.steering_step import steering_steps
    from infinivar.figures import contact_design, design_trends, steering_step, style
    from infinivar.paper.figures import FIGURES

    reproduction, folder = infinivar.reproduce(), Path(app.srcdir) / "reference" / "generated"
    machine = reproduction.machine
    for number, drawn in FIGURES.items():
        style.write(drawn.draw_all(machine), folder / f"fig{number}", ("svg",))
        claims = [claim for claim in reproduction.claims if claim.figure == number]
        (folder / f"paper_fig{number}.md").write_text(
            figure_of_paper(number, drawn.title, drawn.caption, claims), "utf-8"
        )
    others = [claim for claim in reproduction.claims if claim.figure not in FIGURES]
    (folder / "paper_claims_without_figure.md").write_text(figure_of_paper(0, "", "", others), "utf-8")
    style.write(contact_design.draw_all(contact_sheet(machine.study, "cobotic")), folder / "contact_design", ("svg",))
    (step,) = steering_steps(machine.study, "cobotic")
    style.write(steering_step.draw_all(step), folder / "steering_step", ("svg",))
    style.write(design_trends.draw_all(machine.drive), folder / "design_trends", ("svg",))
    style.write(infinivar.contact.RollingPatch(1.0).steady(lateral=0.3).plot(), folder / "rolling_patch", ("svg",))
    (folder / "design_trends_caption.md").write_text(f"{design_trends.CAPTION}\n", "utf-8")


def example(app, page: str, defines: str) -> dict:
    """Names of the first example of a page that defines a name, as `defines = ...`."""
    import re

    text = (Path(app.srcdir) / f"{page}.md").read_text("utf-8")
    names: dict = {}
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.S | re.M)
    exec(next(block for block in blocks if re.search(rf"^{defines} = ", block, re.M)), names)
    return names


def draw_sphere(app) -> None:
    """Draw the figures of a sphere between rollers, with the transmissions of the example on the page on machines."""
    import numpy as np

    import infinivar as iv
    from infinivar.figures import sphere_gears, sphere_map, style

    folder = Path(app.srcdir) / "reference" / "generated"
    page = example(app, "machines", "spheres")
    angle, load = np.radians(np.linspace(-90.0, 90.0, 73)), np.linspace(0.0, 1.45, 59) * page["roller"].slip_force
    maps = [iv.analysis.sphere_map(one, angle, load, sphere_speed=20.0) for one in page["spheres"].values()]
    style.write(sphere_map.draw_all(maps), folder / "sphere_map", ("svg",))
    style.write(sphere_gears.draw_all(page["spheres"], 20.0), folder / "sphere_gears", ("svg",))
    ivt = page["spheres"]["cubic"]
    point = ivt.operate(steering_angle=np.radians(30.0), sphere_speed=20.0, load=25.0)
    style.write(point.plot(ivt=ivt), folder / "sphere", ("svg",))


def draw_shared_motor(app) -> None:
    """Draw the figure of the page on machines: one motor against a motor for each joint."""
    import numpy as np

    import infinivar as iv
    from infinivar.figures import shared_motor, style

    study = iv.load_study("hand_controller")
    found = [
        iv.analysis.share_motor(
            study.drives[name],
            study.drives["motor2-gear4"],
            force=np.linspace(0.0, 55.0, 111),
            legs=(1, 2, 3, 6, 12),
            duty=np.linspace(0.02, 1.0, 50),
            period=10.0,
        )
        for name in ("cobotic", "cobotic-b")
    ]
    made = shared_motor.draw_all(found, ["cobotic (A)", "cobotic-b (B)"])
    style.write(made, Path(app.srcdir) / "reference" / "generated" / "shared_motor", ("svg",))


def draw_displays(app) -> None:
    """Draw the figures of the page on cobotic and conventional displays."""
    import numpy as np

    import infinivar as iv
    from infinivar.figures import displays, shared_motor, style

    folder = Path(app.srcdir) / "reference" / "generated"
    drives = iv.load_study("hand_controller").drives
    pairs = [
        iv.displays.DisplayPair(cobotic=drives[name], conventional=drives["motor2-gear4"])
        for name in ("cobotic", "cobotic-b")
    ]
    variants = iv.displays.assumed_variants(pairs[0], {"reconstruction B": drives["cobotic-b"]})
    style.write(
        displays.draw_all(iv.displays.compare_displays(pairs[0], variants=variants)),
        folder / "display_energy",
        ("svg",),
    )
    grid = {"force": np.linspace(0.0, 55.0, 111), "duty": np.linspace(0.02, 1.0, 50)}
    made = shared_motor.draw_map([iv.displays.display_break_even(pair, **grid) for pair in pairs], ["A", "B"])
    style.write(made, folder / "display_break_even", ("svg",))


def draw_legs(app) -> None:
    """Draw the platform of the page on machines under a load, and the wrenches that it can hold."""
    import infinivar as iv
    from infinivar.figures import machine as drawn
    from infinivar.figures import style, wrench_set

    folder = Path(app.srcdir) / "reference" / "generated"
    machine = iv.machines.LeggedDrive.of(iv.load_study("hand_controller").drives["cobotic"], 6)
    platform = iv.transmission.Platform.hexapod()
    home = platform.at([0.0, 0.0, platform.home])
    sets = [machine.wrench_set(home), machine.wrench_set(home, twist=[0.0, 0.0, 0.3, 0.0, 0.0, 0.0])]
    style.write(wrench_set.draw_all(sets, ["at rest", "rising at 0.3 m/s"]), folder / "wrench_set", ("svg",))
    pose = [0.01, 0.0, platform.home], [0.0, 0.1, 0.0]
    point = machine.operate(
        platform.at(*pose), wrench=[-30.0, 15.0, 60.0, 0.0, 0.0, 0.0], twist=[0.0, 0.1, 0.15, 0.0, 0.0, 0.0]
    )
    style.write(drawn.draw_all(platform, machine.legs, point.legs, *pose), folder / "machine", ("svg",))


COBOTS = {
    "planar_cart": ("three-wheels", "wall"),
    "driven_cart": ("rear", "corner"),
    "omniwheel_platform": ("one-motor", "push"),
    "sphere_joint": ("tetrahedral", "slow"),
    "six_leg_display": ("one-motor", "push"),
    "two_joint_arm": ("one-motor", "push"),
}
"""Machine and task drawn of each study."""


def draw_cobots(app) -> None:
    """Draw the machines of the page that says which cobot is for what, as reports do."""
    import infinivar as iv
    from infinivar.figures import kinds, style

    for study, (name, task) in COBOTS.items():
        found = iv.load_study(study)
        done = iv.perform_task(found.drives[name], found.tasks[task])
        each = kinds.drawings(name, found.titles[name], found.drives[name], done)
        draw = next(draw for file, draw, _ in each if file.startswith("machine"))
        style.write(draw(), Path(app.srcdir) / "reference" / "generated" / f"cobot_{study}", ("svg",))


def draw_planar(app) -> None:
    """Draw the cart of the page on machines under a load."""
    from infinivar.figures import style

    page = example(app, "machines", "cart")
    cart, twist = page["cart"], [0.5, 0.0, 0.7]
    point = cart.mechanism.operate(rates=twist, heading=cart.headings(twist, {"y": 50.0, "angle": 4.0}))
    made = point.plot(cobot=cart)
    style.write(made, Path(app.srcdir) / "reference" / "generated" / "planar_cobot", ("svg",))


def draw_machine_run(app) -> None:
    """Draw the run of the page on motion: a platform on six legs."""
    from infinivar.figures import machine_run, style

    run = example(app, "motion-and-control", "machine")["run"]
    style.write(machine_run.draw_all(run), Path(app.srcdir) / "reference" / "generated" / "machine_run", ("svg",))


def draw_motion(app) -> None:
    """Draw the bond graph of the page on motion, and a simulated reach."""
    import infinivar as iv
    from infinivar.figures import bond_graph, energy_flow, style, time_history

    folder = Path(app.srcdir) / "reference" / "generated"
    study = shipped_study("faulring2006")
    cobotic = study.drives["cobotic"]
    motor = example(app, "motion-and-control", "motor")["motor"]
    style.write(bond_graph.draw_all(motor), folder / "graph_motor", ("svg",))
    reach = iv.simulate(cobotic, study.scenarios["reach"])
    style.write(energy_flow.draw_all(reach), folder / "energy_reach", ("svg",))
    style.write(time_history.draw_all(reach), folder / "history_reach", ("svg",))


def draw_measurements(app) -> None:
    """Draw a calibration, a tornado chart, and models compared with measurements."""
    import numpy as np

    import infinivar as iv
    from infinivar.calibration import virtual_rig
    from infinivar.figures import calibration, sensitivity, style
    from measured import figures as measurements

    folder = Path(app.srcdir) / "reference" / "generated"
    study = shipped_study("faulring2006")
    drive = study.drives["cobotic"]
    runs = virtual_rig.experiment(drive, study.rig, virtual_rig.protocol(drive, study.rig), simulated=False).data
    style.write(calibration.draw_all(iv.calibrate(study, "cobotic", runs)), folder / "calibration", ("svg",))
    speed, torque = (part.ravel() for part in np.meshgrid(np.linspace(10, 60, 6), np.linspace(-0.25, 0.25, 8)))
    points = virtual_rig.dynamometer(
        study.drives["motor1-gear1"],
        study.rig,
        speed=speed,
        torque=torque,
        noise={"current": 0.005, "voltage": 0.02},
        values={"friction": 0.015, "load_share": 0.03, "viscous": 1e-4},
    )
    geared = iv.calibrate(study, "motor1-gear1", points)
    style.write(calibration.draw_geared(geared), folder / "geared_calibration", ("svg",))
    found = iv.sensitivity(study, "cobotic", "energy", duty="shake", samples=128)
    style.write(sensitivity.draw_all(found), folder / "sensitivity", ("svg",))
    style.write(measurements.draw_map(), folder / "motor_map", ("svg",))
    style.write(measurements.draw_gears(), folder / "gear_friction", ("svg",))


def draw_measured_sets(app) -> None:
    """Draw the shipped measured sets, and write their table."""
    from infinivar.calibration import measured_report
    from infinivar.calibration.measured.sets import read_set, shipped_sets
    from infinivar.figures import style
    from infinivar.report.measured import table

    folder = Path(app.srcdir) / "reference" / "generated"
    found = [measured_report(name) for name in shipped_sets() if read_set(name).rows is not None]
    (folder / "measured_table.md").write_text(table(found), "utf-8")
    for one in found:
        style.write(one.plot(), folder / f"measured_{one.set.name}", ("svg",))


DRAWINGS = (
    draw,
    draw_sphere,
    draw_shared_motor,
    draw_displays,
    draw_legs,
    draw_cobots,
    draw_planar,
    draw_machine_run,
    draw_motion,
    draw_measurements,
    draw_measured_sets,
)


def begin(app) -> None:
    """Draw in a process of its own, while the examples of the gallery run."""
    pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"))
    place = types.SimpleNamespace(srcdir=str(app.srcdir))
    app.drawings = [pool.submit(one, place) for one in DRAWINGS]


def end(app, *_) -> None:
    """Wait for the drawings, before pages that show them are read."""
    for one in app.drawings:
        one.result()


def setup(app):
    # After the tables, which make the folder, and before the gallery, with the default priority of 500.
    app.connect("builder-inited", begin, priority=450)
    app.connect("env-before-read-docs", end)
    return {"parallel_read_safe": True}
