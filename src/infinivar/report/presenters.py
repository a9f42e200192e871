"""Functions that draw, save and tabulate each type of result.

Functions are named, not imported: to draw one result loads the figure of that result only.
"""

from __future__ import annotations

from infinivar._core.presentation import register

_IN_MOTION = {
    "animation": "figures.moving_machine:animation",
    "video": "report.video:save",
    "scene": "report.scene.export:save",
}

_TYPES: dict[str, dict[str, str]] = {
    "analysis.compare.Comparison": {
        "plot": "figures.operating_map:draw_all",
        "save": "report.comparison:save",
        "table": "report.tables:comparison",
        "notebook": "report.notebook:comparison",
    },
    "analysis.compare.DriveResult": {"plot": "figures.single:drive_result"},
    "analysis.cycles.duty_comparison.DutyComparison": {
        "plot": "figures.duty_cycle:draw_all",
        "table": "report.tables:duty_comparison",
    },
    "analysis.common_speed.CommonSpeed": {"plot": "figures.common_speed:draw_all"},
    "analysis.contact_sheet.ContactSheet": {
        "plot": "figures.contact_design:draw_all",
        "save": "report.contact:save",
    },
    "analysis.cycles.cylinder_policy.Policy": {"plot": "figures.single:policy"},
    "analysis.cycles.duty_result.DutyResult": {"plot": "figures.single:duty"},
    "analysis.cycles.mixed_use.MixedUse": {"table": "report.tables:mixed_use"},
    "analysis.cycles.shaking.DynamicMap": {"plot": "figures.single:dynamic_map"},
    "analysis.cycles.tracking.TwoWays": {"plot": "figures.single:two_ways", "table": "report.tables:two_ways"},
    "analysis.design_trends.Trend": {"plot": "figures.single:trend"},
    "analysis.hanging.Hanging": {"table": "report.tables:hanging"},
    "analysis.loss_ranking.LeastLoss": {"plot": "figures.least_loss:draw_all"},
    "analysis.machine_run.MachineRun": {
        "plot": "figures.machine_run:draw_all",
        "save": "report.run:save",
        "dataset": "report.datasets:machine_run",
        **_IN_MOTION,
    },
    "displays.comparison.DisplayComparison": {
        "plot": "figures.displays:draw_all",
        "table": "report.tables:display_comparison",
    },
    "analysis.sessions.session_result.Session": {
        "plot": "figures.session:draw_all",
        "save": "report.run:save_session",
        "dataset": "report.datasets:machine_run",
        **_IN_MOTION,
    },
    "analysis.machines.MachineComparison": {
        "plot": "figures.machine_tasks:draw_all",
        "save": "report.machines:save",
        "table": "report.tables:machine_comparison",
        "notebook": "report.notebook:comparison",
    },
    "analysis.pose_map.PoseMap": {"plot": "figures.machine_tasks:draw_pose_map"},
    "analysis.motion_summary.MotionSummary": {
        "plot": "figures.motion_summary:draw_all",
        "save": "report.motion_summary:save",
    },
    "analysis.robustness.sensitivity.Sensitivity": {
        "plot": "figures.sensitivity:draw_all",
        "save": "report.sensitivity:save",
    },
    "analysis.robustness.verdicts.Builds": {"plot": "figures.single:builds", "table": "report.tables:builds"},
    "analysis.robustness.verdicts.BuildsMap": {"plot": "figures.single:builds_map"},
    "analysis.robustness.verdicts.DutyBuilds": {
        "plot": "figures.single:duty_builds",
        "table": "report.tables:duty_builds",
    },
    "analysis.simulate.Simulation": {
        "plot": "figures.time_history:draw_all",
        "save": "report.run:save",
        "dataset": "report.datasets:simulation",
        "table": "report.tables:simulation",
    },
    "displays.stability.StabilityMap": {
        "plot": "figures.stability_map:draw_all",
        "dataset": "report.datasets:stability_map",
    },
    "displays.impedance_range.ZWidth": {"plot": "figures.z_width:draw_all"},
    "analysis.shared_motor.SharedMotor": {"plot": "figures.shared_motor:draw_all"},
    "analysis.sphere_efficiency.SphereMap": {"plot": "figures.sphere_map:draw_all"},
    "analysis.steering_step.SteeringStep": {
        "plot": "figures.steering_step:draw_all",
        "save": "report.contact:save_steps",
    },
    "analysis.steady_map.SteadyMap": {"plot": "figures.single:steady_map", "notebook": "report.notebook:steady_map"},
    "study.study.Study": {"notebook": "report.notebook:study"},
    "analysis.workspace.WorkspaceMap": {"plot": "figures.workspace:draw_all"},
    "bondgraph.audit.Trajectory": {
        "plot": "figures.single:trajectory",
        "dataset": "report.datasets:trajectory",
        "table": "report.tables:trajectory",
    },
    "calibration.measured.report.MeasuredReport": {
        "plot": "figures.measured:draw_all",
        "save": "report.measured:save",
    },
    "calibration.result.GearedCalibration": {
        "plot": "figures.calibration:draw_geared",
        "save": "report.calibration:save",
        "table": "report.tables:calibration",
    },
    "calibration.result.Calibration": {
        "plot": "figures.calibration:draw_all",
        "save": "report.calibration:save",
        "table": "report.tables:calibration",
    },
    "contact.exact.patch.SteadyRolling": {"plot": "figures.rolling_patch:draw_all"},
    "contact.exact.transient.TransientRolling": {
        "plot": "figures.transient_rolling:draw_all",
        "table": "report.tables:transient_rolling",
    },
    "drivetrain.drive.DrivePoint": {"plot": "figures.single:point"},
    "machines.many_legs.MachinePoint": {"plot": "figures.wheels:legs"},
    "drivetrain.drive.MovingPoint": {"plot": "figures.single:moving_point"},
    "parts.heat.Heat": {"plot": "figures.single:heat"},
    "sizing.builds.result.Doubt": {"table": "report.tables:doubt"},
    "sizing.result.Sizing": {
        "plot": "figures.sizing:draw_all",
        "save": "report.sizing:save",
        "table": "report.tables:sizing",
    },
    "transmission.legs.LegsPoint": {"plot": "figures.wheels:legs"},
    "transmission.contact_map.MechanismPoint": {"plot": "figures.wheels:mechanism"},
    "transmission.spherical_solve.SphericalPoint": {"plot": "figures.wheels:rollers"},
    "transmission.operating_point.OperatingPoint": {"plot": "figures.single:point"},
    "transmission.wrench_set.WrenchSet": {"plot": "figures.wrench_set:draw_all"},
}

for _name, _functions in _TYPES.items():
    register(f"infinivar.{_name}", **{kind: f"infinivar.{where}" for kind, where in _functions.items()})
