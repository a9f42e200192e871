"""Springs, linkages and motions about a joint in study files: read, and refused where they do not fit."""

import math

import pytest

import infinivar as iv
from internals import ROTARY, check_duty

HEAD = """
[requirement]
moment = "1 N m"
angular_speed = "3 rad/s"
[drives.ankle]
base = "faulring2006.cobotic"
"""
CRANK = """
[drives.ankle.output.linkage]
shape = "crank"
arm = "50 mm"
base = "300 mm"
offset = "90 deg"
"""
REACHES = """
[duty.swing]
shape = "reaches"
angle = "20 deg"
time = "0.5 s"
load_inertia = "0.01 kg m^2"
"""
SERIES = '[drives.ankle.output.series_spring]\nstiffness = "30 N/mm"\n'


def loaded(tmp_path, text):
    path = tmp_path / "study.toml"
    path.write_text(HEAD + text, "utf-8")
    return iv.load_study(path)


def test_a_joint_with_springs_is_read_and_followed(tmp_path):
    table = """
[drives.ankle.output.parallel_torsion_spring]
shape = "progressive"
deflections = { value = [-20, -10, 0, 10, 20], unit = "deg" }
forces = ["-2 N m", "-1 N m", "0 N m", "1 N m", "2.2 N m"]
"""
    walk = (
        '[duty.walk]\nshape = "walking"\njoint = "ankle"\nbody_mass = "70 kg"\nstride_time = "1.1 s"\nshare = 0.003\n'
    )
    study = loaded(tmp_path, CRANK + SERIES + 'hysteresis = "2 N"\n' + table + walk)
    drive, duty = study.drives["ankle"], study.duty["walk"]
    assert drive.axis is duty.axis is ROTARY
    assert drive.output.linkage.offset == math.pi / 2
    assert drive.output.parallel_torsion_spring.deflections[0] == pytest.approx(math.radians(-20))
    check_duty(study)
    found = iv.duty_cycle(drive, duty)
    assert found.closure < 1e-12
    assert found.losses["series spring hysteresis"] > 0
    assert {"series_spring_deflection_m", "drive_speed_m_s", "lever_arm_m"} <= found.columns.keys()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            REACHES,
            "duty.swing is about a joint; drives.ankle moves along a line: give it a linkage, [drives.ankle.output.linkage]",
        ),
        (CRANK + '[duty.h]\nshape = "hold"\ntime = "1 s"\n', "duty.h is along a line; drives.ankle moves a joint"),
        (CRANK + SERIES + REACHES, "set profile = 'smooth'"),
    ],
)
def test_drive_and_motion_that_do_not_fit_are_refused(tmp_path, text, said):
    study = loaded(tmp_path, text)
    with pytest.raises(iv.InputError) as caught:
        check_duty(study)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            CRANK.replace('offset = "90 deg"', ""),
            "drives.ankle.output.linkage.offset is missing: shape = 'crank' needs it",
        ),
        ('[drives.ankle.output.series_spring]\nshape = "one-sided"\n', "output.series_spring.stiffness is missing"),
        (SERIES + 'forces = ["1 N", "2 N"]\n', "forces does not apply with shape = 'linear'; remove it"),
        (
            '[drives.ankle.output.parallel_torsion_spring]\nstiffness = "3 N m/rad"\n',
            "output.parallel_torsion_spring does not apply: the drive moves along a line and has no linkage to a joint",
        ),
        (
            CRANK.replace("crank", "four-bar") + 'crank = "30 mm"\ncoupler = "300 mm"\n',
            "output.linkage.shape = 'four-bar' needs a drive that moves about a shaft; use lever, table or crank",
        ),
        (
            '[drives.ankle.output.parallel_spring]\nshape = "progressive"\ndeflections = ["0 mm", "5 mm", "9 mm"]\n'
            'forces = ["0 N", "20 N", "19 N"]\n',
            "forces must rise with the deflection, also on the smooth curve through them",
        ),
    ],
)
def test_faults_of_springs_and_linkages_are_named(tmp_path, text, said):
    with pytest.raises(iv.InputError) as caught:
        loaded(tmp_path, text)
    assert said in str(caught.value)
