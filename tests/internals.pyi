"""Where the names of `internals` lie in the package."""

# ruff: noqa: F401

from infinivar._core import c_library, collocation, complex_step, engine, extras, kept, plugins, presentation
from infinivar._core import files as core_files
from infinivar._core import stored as stored_values
from infinivar._core import toml as toml_tables
from infinivar._core.array_namespace import accumulated, rising_root
from infinivar._core.bounds import FINITE, QUARTER_TURN, NonZero
from infinivar._core.bounds import fits as fits_bounds
from infinivar._core.bounds import permitted as permitted_bounds
from infinivar._core.bounds import within as within_bounds
from infinivar._core.bounds import words as bounds_in_words
from infinivar._core.c_library import compiler
from infinivar._core.described import arrays as labelled_arrays
from infinivar._core.described import at, dictionary, finite, is_labelled, named, plain, reported, rows, suffix, unit_of
from infinivar._core.described import derived as described_derived
from infinivar._core.engine import local as local_engine
from infinivar._core.fields import (
    check_value,
    described,
    hints,
    in_kinds,
    part_of,
    quantities_of,
    value_at,
    with_values,
)
from infinivar._core.frozen import FrozenDict, frozen
from infinivar._core.frozen import Room as FrozenRoom
from infinivar._core.labels import Labels
from infinivar._core.presentation import presenter
from infinivar._core.processes import ahead as ahead
from infinivar._core.processes import apart as apart
from infinivar._core.processes import opened as opened_processes
from infinivar._core.result import Frozen, result
from infinivar._core.threads import at_most, in_order, products_on_one_thread
from infinivar.analysis import loss_ranking as least_loss_analysis
from infinivar.analysis import marching, run_limits, sampled_springs
from infinivar.analysis import steady_map as steady_maps
from infinivar.analysis import workspace as workspaces
from infinivar.analysis.compare import work_through
from infinivar.analysis.cycles import cylinder_policy, performance
from infinivar.analysis.cycles.cylinder_policy import RANGE as POLICY_RANGE
from infinivar.analysis.cycles.cylinder_policy import schedule as policy_schedule
from infinivar.analysis.cycles.duty_cycle import warmed
from infinivar.analysis.cycles.mixed_use import mixed_use
from infinivar.analysis.cycles.performance import demands as cycle_demands
from infinivar.analysis.cycles.shaking import amplitude as shaking_amplitude
from infinivar.analysis.design_trends import SWEPT as SWEPT_QUANTITIES
from infinivar.analysis.design_trends import Duty, elasticities, with_friction
from infinivar.analysis.design_trends import sweep as swept_design
from infinivar.analysis.machine_motion import _Run as run_setup
from infinivar.analysis.machine_sensitivity import machine_sensitivity
from infinivar.analysis.machine_study import simulated
from infinivar.analysis.machines import compare_machines, evaluate_machine, tasks_and_paths
from infinivar.analysis.marching import March
from infinivar.analysis.motion_summary import advice as motion_advice
from infinivar.analysis.moving_parts import STICK_SPEED as DRAWN_STICK_SPEED
from infinivar.analysis.moving_parts import parts_of
from infinivar.analysis.options import CompareOptions, MotionOptions, SensitivityOptions, StepOptions
from infinivar.analysis.performing import Prepared, power_and_margin
from infinivar.analysis.plane import MAP_REACH, of_drives, of_study
from infinivar.analysis.plane import path as plane_path
from infinivar.analysis.pose_map import pose_map
from infinivar.analysis.region import best_efficiency
from infinivar.analysis.robustness import outcomes, sampling, verdicts
from infinivar.analysis.robustness.derivatives import METHODS as DERIVATIVE_METHODS
from infinivar.analysis.robustness.derivatives import designs, gradient, values_of, varied
from infinivar.analysis.robustness.foremost import foremost
from infinivar.analysis.robustness.outcomes import KINDS as OUTCOME_KINDS
from infinivar.analysis.robustness.outcomes import loss as loss_outcome
from infinivar.analysis.robustness.sampling import Batch, evaluated, low_discrepancy
from infinivar.analysis.robustness.sampling import draw as draw_samples
from infinivar.analysis.robustness.sensitivity import index_values, sobol
from infinivar.analysis.robustness.sensitivity import indices as sobol_indices
from infinivar.analysis.robustness.verdicts import BAND as VERDICT_BAND
from infinivar.analysis.robustness.verdicts import Mapper, percent
from infinivar.analysis.robustness.verdicts import band as verdict_band
from infinivar.analysis.sessions.guides import Line as LineGuideShape
from infinivar.analysis.sessions.guides import Plane as PlaneGuideShape
from infinivar.analysis.sessions.guides import Rod as RodGuideShape
from infinivar.analysis.sessions.guides import Round as RoundGuideShape
from infinivar.analysis.sessions.guides import Solid as SolidGuideShape
from infinivar.analysis.sessions.guides import Track as TrackGuideShape
from infinivar.analysis.sessions.guides import guides_of
from infinivar.analysis.sessions.measures import measures
from infinivar.analysis.sessions.of_study import check_sessions
from infinivar.analysis.sessions.session import Setup as SessionSetup
from infinivar.analysis.sessions.session_result import touches
from infinivar.analysis.shared_motor import run_up_energy
from infinivar.analysis.simulate import Event as RunEvent
from infinivar.analysis.simulate import demands_at
from infinivar.analysis.sphere_efficiency import efficiency_by_ratio
from infinivar.analysis.steering_step import RELAXED
from infinivar.analysis.tightest import tightest_of as tightest_of_drives
from infinivar.analysis.whole_mass import DOUBT as MASS_DOUBT
from infinivar.analysis.whole_mass import mass_of
from infinivar.axis import LINEAR, PLANE, ROTARY, Axis, force_axis, speed_axis
from infinivar.bondgraph import audit as bond_graph_audit
from infinivar.bondgraph import compiled_step, solver
from infinivar.bondgraph import graph as bond_graph_elements
from infinivar.bondgraph import march as bond_graph_march
from infinivar.bondgraph import model as bond_graph_models
from infinivar.bondgraph import solver as bond_graph_solver
from infinivar.bondgraph.audit import CLOSURE as AUDIT_CLOSURE
from infinivar.bondgraph.c_code import c_code
from infinivar.bondgraph.compiled_step import recorded as recorded_controller
from infinivar.bondgraph.compiled_step import run_text
from infinivar.bondgraph.loops import LawValue
from infinivar.bondgraph.loops import ordered as ordered_loops
from infinivar.bondgraph.march import Instants
from infinivar.bondgraph.model import model as bond_graph_model
from infinivar.bondgraph.namespaces import FloatNamespace, casadi_namespace
from infinivar.bondgraph.solver import stepper
from infinivar.bondgraph.trace import Traced
from infinivar.bondgraph.trace import clip as clip_traced
from infinivar.bondgraph.trace import trace as trace_law
from infinivar.calibration import fit as fitting
from infinivar.calibration import geared as geared_model
from infinivar.calibration import laws as calibration_laws
from infinivar.calibration import misread, pendulum, virtual_rig
from infinivar.calibration import plan as calibration_plan
from infinivar.calibration import reduce as reduced_data
from infinivar.calibration import transmission as calibration_model
from infinivar.calibration.dynamometer import Dynamometer, read_dynamometer
from infinivar.calibration.fit import fit as fit_problem
from infinivar.calibration.measured.actuator import BACKDRIVE
from infinivar.calibration.measured.heating import temperatures as heated_temperatures
from infinivar.calibration.measured.law import At as MeasuredAt
from infinivar.calibration.measured.sets import read_rows as read_measured_rows
from infinivar.calibration.measured.sets import read_set, shipped_sets
from infinivar.calibration.options import CalibrateOptions, RigOptions
from infinivar.calibration.problem import Problem
from infinivar.calibration.transmission import COLUMNS as CALIBRATION_COLUMNS
from infinivar.calibration.transmission import known_values, predict
from infinivar.calibration.virtual_rig import experiment, protocol
from infinivar.console import run as run_console
from infinivar.contact import elliptic
from infinivar.contact import laws as contact_laws
from infinivar.contact.bodies import Cylinder, plane_strain_modulus
from infinivar.contact.bodies import Wheel as ContactWheel
from infinivar.contact.creep import LAWS as CREEP_LAWS
from infinivar.contact.creep import check_flow, check_law
from infinivar.contact.exact import equations as exact_equations
from infinivar.contact.exact import grid as exact_grid
from infinivar.contact.exact import spin_calls, spin_map
from infinivar.contact.exact import spin_map as spin_maps
from infinivar.contact.exact.equations import equations as equations_of_cells
from infinivar.contact.exact.equations import influence as influence_of_cells
from infinivar.contact.exact.many import extrapolated as extrapolated_forces
from infinivar.contact.exact.newton import Friction
from infinivar.contact.exact.newton import opposed as opposed_friction
from infinivar.contact.exact_tables import lateral_creep
from infinivar.contact.friction import STICK_SPEED as FRICTION_STICK_SPEED
from infinivar.contact.friction import coulomb
from infinivar.displays.handle_session import PARTS as SESSION_PARTS
from infinivar.displays.handle_session import cobotic_part, geared_part
from infinivar.displays.pair import CONVENTIONAL as CONVENTIONAL_ROUND
from infinivar.displays.pair import display_choices
from infinivar.displays.passivity_check import (
    general_required_damping,
    required_damping,
    required_friction,
    virtual_coupling,
    wall_transfer,
)
from infinivar.displays.plants import Contact as DisplayContact
from infinivar.displays.rounds import DISPLAYS as DISPLAY_ROUNDS
from infinivar.displays.rounds import RESTING, STOPPED, TURNING, round_of
from infinivar.displays.sampled_loop import impedance, run_in_time, sampled_loop
from infinivar.drivetrain import chain
from infinivar.drivetrain.body import own_mass, total
from infinivar.drivetrain.control import CoboticControl, ConventionalControl
from infinivar.drivetrain.drive import GEAR_LIMITS, MovingDrive, is_machine, operated, refuse_machine, with_rated_gear
from infinivar.drivetrain.envelope import Envelope
from infinivar.drivetrain.graphs import bandwidths, compliances
from infinivar.drivetrain.graphs import plants as plant_graphs
from infinivar.drivetrain.graphs.closed_loop import _passed as passed_both_ways
from infinivar.drivetrain.graphs.closed_loop import closed_loop
from infinivar.drivetrain.graphs.compliances import hardening, hardening_energy
from infinivar.drivetrain.layout import estimated_size
from infinivar.drivetrain.masses import cobotic_bodies, with_tube
from infinivar.drivetrain.service import Service, service_of
from infinivar.exports import plant as plants_of_exports
from infinivar.exports.description import base_units as export_base_units
from infinivar.exports.export import _usual as default_export_scenario
from infinivar.exports.laws import law_files, laws
from infinivar.exports.machine_plant import moving_machine as machine_of_export
from infinivar.exports.machine_plant import moving_plant
from infinivar.exports.plant import plant as exported_plant
from infinivar.figures import arm as arm_figure
from infinivar.figures import bond_graph as bond_graph_figure
from infinivar.figures import calibration as calibration_figure
from infinivar.figures import design_trends as design_trends_figure
from infinivar.figures import displays as displays_figure
from infinivar.figures import duty_cycle as duty_cycle_figure
from infinivar.figures import energy_flow, moving_machine, operating_map, session_motion, style, time_history
from infinivar.figures import gear_points as gear_points_figure
from infinivar.figures import kinds as kinds_figure
from infinivar.figures import least_loss as least_loss_figure
from infinivar.figures import losses as losses_figure
from infinivar.figures import machine as machine_figure
from infinivar.figures import machine_run as machine_run_figure
from infinivar.figures import machine_tasks as machine_tasks_figure
from infinivar.figures import motion_summary as motion_summary_figure
from infinivar.figures import pictures as pictures_figure
from infinivar.figures import rolling_patch as rolling_patch_figure
from infinivar.figures import session as session_figure
from infinivar.figures import shared_motor as shared_motor_figure
from infinivar.figures import sheet as sheet_figure
from infinivar.figures import sizing as sizing_figure
from infinivar.figures import sphere_gears as sphere_gears_figure
from infinivar.figures import sphere_map as sphere_map_figure
from infinivar.figures import stability_map as stability_map_figure
from infinivar.figures import steering_step as steering_step_figure
from infinivar.figures import wheels as wheels_figure
from infinivar.figures import workspace as workspace_figure
from infinivar.figures import wrench_set as wrench_set_figure
from infinivar.figures import z_width as z_width_figure
from infinivar.figures.duty_cycle import data as duty_cycle_data
from infinivar.limits import binding, binding_demand, codes, words_of
from infinivar.machines.bodies import planar_arm
from infinivar.machines.compiled import compiled_motion, inputs_of, machine_code
from infinivar.machines.control.controller import Plant as GuidedPlant
from infinivar.machines.control.controller import begun as controllers_begun
from infinivar.machines.control.impedance import wall_force
from infinivar.machines.control.legs import nearest_within
from infinivar.machines.control.planar_fixtures import PlanarFixtureGuide, PlanarHoldGuide, locking_headings
from infinivar.machines.control.tasks import SETTLING_LENGTH, controller_of
from infinivar.machines.course import on_path as course_on_path
from infinivar.machines.course import through as course_through
from infinivar.machines.hand import PointGrip
from infinivar.machines.kind import MovingMachine
from infinivar.machines.kinds.arm import ArmLoad
from infinivar.machines.kinds.linked import SeparateMachine, motor_mass
from infinivar.machines.linkage import SeparateMechanics
from infinivar.machines.machine import as_machine
from infinivar.machines.pictures import robots as robot_picture
from infinivar.machines.pictures import rollers as sphere_picture
from infinivar.machines.pictures import wheeled as wheeled_picture
from infinivar.machines.platform_load import PlatformLoad
from infinivar.machines.registry import MACHINES as MOVING_MACHINES
from infinivar.machines.sampled import SampledSteps
from infinivar.machines.system import Defaults, Forces, Place, System
from infinivar.machines.system import Inputs as SystemInputs
from infinivar.machines.system import Outside as SystemOutside
from infinivar.motion.duty_cycles import CYCLES
from infinivar.motion.files.choice import family_of
from infinivar.motion.files.table import Column as TableColumn
from infinivar.motion.files.timing import read_timed, windowed
from infinivar.motion.files.timing import resampled as resampled_table
from infinivar.motion.fourier import Series as FourierSeries
from infinivar.motion.machine_scenario import check_continuous
from infinivar.motion.machine_tasks import angular_velocity
from infinivar.motion.runs import RunSeries
from infinivar.motion.scenario import FORCES, MOTIONS
from infinivar.motion.strides import find_strides
from infinivar.motion.strides import resampled as resampled_strides
from infinivar.motion.task import check_motion
from infinivar.motion.virtual.constrained import free_basis
from infinivar.motion.virtual.fixtures import ByRows
from infinivar.motion.virtual.fixtures import Row as FixtureRow
from infinivar.motion.virtual.meshes import MeshFile
from infinivar.motion.virtual.surfaces import FlatWalls, Surface
from infinivar.motion.virtual.tasks import TASKS as VIRTUAL_TASKS
from infinivar.motion.virtual.triangles import closest_on_triangles
from infinivar.paper.claims import design as claims_of_design
from infinivar.paper.claims import element as claims_of_elements
from infinivar.paper.claims import plane_measures
from infinivar.paper.claims import plants as claims_of_plants
from infinivar.paper.claims import shaking as claims_of_shaking
from infinivar.paper.claims import system as claims_of_systems
from infinivar.paper.claims.bench import MOVES as BENCH_MOVES
from infinivar.paper.claims.bench import Bench
from infinivar.paper.claims.claim import FACTOR as VERDICT_FACTOR
from infinivar.paper.claims.claim import (
    Checked,
    Claim,
    Found,
    PaperMachine,
    at_ratio,
    counted,
    efficiency_by,
    statements,
)
from infinivar.paper.claims.claim import near as near_verdict
from infinivar.paper.claims.claim import row as verdict_row
from infinivar.paper.claims.claim import turned as turned_verdict
from infinivar.paper.claims.element import excess_creep, fitted, with_groups
from infinivar.paper.claims.planes import PLANES
from infinivar.paper.displays import _sessions as varied_sessions
from infinivar.paper.figures import FIGURES as PAPER_FIGURES
from infinivar.paper.figures import architectures, steered_wheel
from infinivar.paper.figures import curves as paper_curves
from infinivar.paper.figures import maps as paper_maps
from infinivar.paper.figures import polygons as paper_polygons
from infinivar.paper.report import left_out
from infinivar.paper.report import save as save_reproduction
from infinivar.paper.reproduce import CHECKS as PAPER_CHECKS
from infinivar.paper.reproduce import STEERED, two_6004
from infinivar.parts import catalogue, elastic
from infinivar.parts import history as parts_history
from infinivar.parts.bearing import COEFFICIENTS, SIZE_POWERS, BearingPair, BearingType, Lubrication
from infinivar.parts.bearing import Series as BearingSeries
from infinivar.parts.gear_friction import friction_budget, stribeck_friction
from infinivar.parts.gear_friction import terms as gear_friction_terms
from infinivar.parts.gear_law import Torsion
from infinivar.parts.heat import heat_over_run as heat_over_run
from infinivar.parts.heat import warm as warm_motor
from infinivar.parts.heat_steps import over as heat_over
from infinivar.parts.heat_steps import rates as heat_rates
from infinivar.parts.heat_steps import windings as heat_windings
from infinivar.parts.shaft_bearings import WheelLoad, spread
from infinivar.parts.strain_wave import strain_wave_friction
from infinivar.parts.structure import beams, shells
from infinivar.parts.structure.bodies import bar_height, crowned_volume, ring_moments, ring_volume, wire_mass
from infinivar.parts.structure.stock import SHEAR_MODULUS, coiled_mass, wire_rate, wire_stress
from infinivar.parts.structure.tube import Tube as CylinderTube
from infinivar.parts.structure.tube import thinnest
from infinivar.parts.tables import importing, stores
from infinivar.parts.tables.columns import number_columns, text_columns
from infinivar.parts.tables.consistency import contradictions_of
from infinivar.parts.tables.relations import RELATIONS
from infinivar.parts.tables.search import Rows as DerivedRows
from infinivar.parts.tables.search import condition as search_condition
from infinivar.parts.tables.search import derived, derived_columns
from infinivar.parts.tables.stores import shipped
from infinivar.parts.tables.table import part_set
from infinivar.parts.tables.table import table as part_table
from infinivar.power import audit as power_audit
from infinivar.report import numbers as report_numbers
from infinivar.report import page as report_page
from infinivar.report import saving as report_saving
from infinivar.report import video
from infinivar.report.calibration import save_data as save_calibration_data
from infinivar.report.measured import HEAD as HEAD_OF_MEASURED
from infinivar.report.measured import rows as rows_of_measured
from infinivar.report.motion_summary import rows as motion_summary_rows
from infinivar.report.output import all_or_nothing
from infinivar.report.output import claimed as claimed_output
from infinivar.report.page import finished, write_csv
from infinivar.report.scene.export import in_space as scene_in_space
from infinivar.report.scene.export import recorded as recorded_scene
from infinivar.report.sizing import html as sizing_html
from infinivar.report.sizing import text as sizing_text
from infinivar.report.step import save_step
from infinivar.sizing import of_cobotic
from infinivar.sizing.builds.compiled import structure as compiled_structure
from infinivar.sizing.builds.evaluation import built as built_rows
from infinivar.sizing.builds.evaluation import decisive
from infinivar.sizing.builds.evaluation import judge as judge_builds
from infinivar.sizing.builds.result import interval as builds_interval
from infinivar.sizing.builds.spreads import draw as draw_builds
from infinivar.sizing.builds.spreads import varied_of
from infinivar.sizing.carrying import at_cost, best_carried, carried_lines
from infinivar.sizing.cobotic import size_cobotic
from infinivar.sizing.cobotic.bounds import MOTOR as MOTOR_BOUND
from infinivar.sizing.cobotic.bounds import cylinder_signals, lower_bounds, steering_signals
from infinivar.sizing.cobotic.choice import Behind, best_behind
from infinivar.sizing.cobotic.choice import least_power as cobotic_least_power
from infinivar.sizing.cobotic.evaluation import NOT_FEASIBLE
from infinivar.sizing.cobotic.evolution import _Space as SearchSpace
from infinivar.sizing.cobotic.sampled import SideSampled
from infinivar.sizing.cobotic.sampled import sample as cobotic_sample
from infinivar.sizing.cobotic.search import prepared as prepared_search
from infinivar.sizing.cobotic.space import FREE as FREE_LIMIT
from infinivar.sizing.cobotic.space import Points as WheelPoints
from infinivar.sizing.cobotic.space import values_of as wheel_values
from infinivar.sizing.cobotic.space import with_own_inertias
from infinivar.sizing.cobotic.wheels import AXLE as AXLE_LIMIT
from infinivar.sizing.cobotic.wheels import CONTACT as CONTACT_LIMIT
from infinivar.sizing.cobotic.wheels import CompiledWheels, static_demands
from infinivar.sizing.cobotic.wheels import critical as critical_wheels
from infinivar.sizing.cobotic.wheels import evaluate as evaluate_wheels
from infinivar.sizing.design import AXLE_BEARING, STEERING_MOTOR, SizedDrive, exceeded_words
from infinivar.sizing.geared import over_radius, size_geared
from infinivar.sizing.geared.at_stages import closed_forms
from infinivar.sizing.geared.candidates import candidates
from infinivar.sizing.geared.closed_form import SPARE as SPARE_WARMTH
from infinivar.sizing.geared.extremes import braking_places
from infinivar.sizing.geared.radius_bounds import Laurent, Radii, Resting, mean_square_below
from infinivar.sizing.geared.radius_bounds import below as radius_below
from infinivar.sizing.geared.radius_limits import least_power as geared_least_power
from infinivar.sizing.geared.radius_limits import limits as geared_limits
from infinivar.sizing.geared.radius_limits import load_of, region_points
from infinivar.sizing.geared.regeneration import returning as regeneration_returning
from infinivar.sizing.geared.regeneration import union as union_of_windows
from infinivar.sizing.geared.regeneration import windows as regeneration_windows
from infinivar.sizing.geared.sampled import HOT as HOT_GEARED
from infinivar.sizing.geared.sampled import UNCHECKED as UNCHECKED_GEARED
from infinivar.sizing.geared.sampled import Laws as GearedLaws
from infinivar.sizing.geared.sampled import sample as geared_sample
from infinivar.sizing.geared.search import nearest_miss
from infinivar.sizing.geared.tasks import REQUIREMENT, MotionTask, RegionTask, judging_points, tasks_of
from infinivar.sizing.geared.tasks import outer as outer_region
from infinivar.sizing.levers import levers
from infinivar.sizing.machine_changes import sufficient_changes, with_changes
from infinivar.sizing.machines.work import MachineWork
from infinivar.sizing.margins import margin_of, shortfalls
from infinivar.sizing.margins import nearest_of as nearest_of_margins
from infinivar.sizing.margins import tightest_of as tightest_of_margins
from infinivar.sizing.options import SizeOptions
from infinivar.sizing.pool import ChosenPart
from infinivar.sizing.pool import pool as pool_of_parts
from infinivar.sizing.robustness import judged_designs
from infinivar.sizing.studies import motion_file, not_simulated, scenario_of, study_of
from infinivar.sizing.tables import CoboticRequest, GearedRequest
from infinivar.sizing.tries import BESIDE as TRIED_BESIDE
from infinivar.sizing.tries import VALUES as TRIED_FIRST
from infinivar.sizing.what_if import change_words, what_if
from infinivar.study import load as study_loading
from infinivar.study import schema as study_schema
from infinivar.study.build import built as built_from_study
from infinivar.study.build import built_part
from infinivar.study.check import check as check_study
from infinivar.study.check import check_duty
from infinivar.study.choices import variants, variants_of
from infinivar.study.default_spreads import FRICTION, TORQUE_CONSTANT, default_spreads
from infinivar.study.default_spreads import defaults as default_spread_rules
from infinivar.study.inputs import input_files
from infinivar.study.json_schema import extended_schema, json_schema
from infinivar.study.layers import annotated
from infinivar.study.load import shipped_study, study_from
from infinivar.study.messages import StudyError
from infinivar.study.provenance import text_of
from infinivar.study.save import _raw as study_tables
from infinivar.study.schema import DRIVES as SCHEMA_DRIVES
from infinivar.study.schema import KINDS as SCHEMA_KINDS
from infinivar.study.schema import keys as schema_keys
from infinivar.study.sessions import session_arguments
from infinivar.study.shipped import parameter_set, parameter_sets, shipped_studies, study_file
from infinivar.study.shipped import template as study_template
from infinivar.study.spreads import Spread
from infinivar.sweeps import sweep as sweeping
from infinivar.sweeps import workers
from infinivar.sweeps.fingerprint import fingerprint
from infinivar.sweeps.problem import Best as BestReducer
from infinivar.sweeps.problem import Chunk as SweepChunk
from infinivar.sweeps.problem import Rows as RowsReducer
from infinivar.sweeps.problem import added as added_rows
from infinivar.sweeps.problem import merged_order, reducer_of
from infinivar.sweeps.problem import stacked as stacked_rows
from infinivar.sweeps.problem import taken as taken_rows
from infinivar.sweeps.storage import DESCRIPTION, DamagedError, SweepFolder
from infinivar.sweeps.storage import decoded as decoded_chunk
from infinivar.sweeps.storage import encoded as encoded_chunk
from infinivar.sweeps.workers import Job as SweepJob
from infinivar.sweeps.workers import compute_apart, in_processes
from infinivar.sweeps.workers import versions as worker_versions
from infinivar.tables import formats as file_formats
from infinivar.tables import sheet as sheets
from infinivar.tables.headings import heading_of, unit_and_per_kg
from infinivar.tables.named import Named as NamedColumns
from infinivar.tables.sheet import TextSheet
from infinivar.transmission import legs, spin_law, turning
from infinivar.transmission.driven_contact import DrivenContact
from infinivar.transmission.geometry import MEASURED_FULL_SLIP
from infinivar.transmission.guiding import largest_turn_rate, overrun, stopping_distance
from infinivar.transmission.kinematics import Steering, contact_balance, relative_velocities
from infinivar.transmission.legs import creep_drift, reflected_mass
from infinivar.transmission.mechanism_forward import slopes
from infinivar.transmission.omniwheels import Omniwheels, in_fixed_axes
from infinivar.transmission.planar import drift, driving_creepage, instant_centre
from infinivar.transmission.platform import rotated, rotation_matrix, rotation_vector
from infinivar.transmission.rates import Varying, steering_rates
from infinivar.transmission.sphere_layout import LAYOUTS
from infinivar.transmission.turning_chain import TurningChain
from infinivar.units import parse
from infinivar.units import plain as plain_units
from infinivar.web.answers import contact as contact_answer
from infinivar.web.answers import document as document_answer
from infinivar.web.answers import drawing as drawing_answer
from infinivar.web.answers import motion as motion_answer
from infinivar.web.answers import places as places_answer
from infinivar.web.answers import point as point_answer
from infinivar.web.answers import shapes as shapes_answer
from infinivar.web.answers.answer import Answer, FaultyError, RefusedError
from infinivar.web.answers.answer import plain as plain_answer
from infinivar.web.answers.answer import unpack as unpack_answer
from infinivar.web.answers.dispatch import ANSWERS, function_of
from infinivar.web.answers.dispatch import answered as answered_request
from infinivar.web.answers.document import tables_of
from infinivar.web.answers.jobs import stated as job_options
from infinivar.web.answers.jobs import worked as worked_job
from infinivar.web.server import work as server_work
from infinivar.web.server import worker as server_worker
from infinivar.web.server.app import PAGE as SERVED_PAGE
from infinivar.web.server.recovery import Recovery
from infinivar.web.server.start import serve as serve_explorer
from infinivar.web.server.work import BusyError, FailedError, StaleError, TooLongError, UnusableError
from infinivar.web.server.work import Lane as ServerLane
from infinivar.web.server.work import Worker as ServerWorker
