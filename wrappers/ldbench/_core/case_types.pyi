"""Types of the variables of a case, for type checkers. docs/make_tables.py makes this file of the core's list."""
from os import PathLike
from typing import Final, Literal, TypedDict

class Variables:
    name: Final[str]
    case_name: Final[str]
    title: Final[str]
    case_title: Final[str]
    mass: Final[float]
    wheelset_mass: Final[float]
    roll_inertia: Final[float]
    wheelset_roll_inertia: Final[float]
    pitch_inertia: Final[float]
    wheelset_pitch_inertia: Final[float]
    rolling_radius: Final[float]
    wheelset_rolling_radius: Final[float]
    back_to_back: Final[float]
    wheelset_back_to_back: Final[float]
    vertical_load: Final[float]
    wheelset_vertical_load: Final[float]
    gauge: Final[float]
    track_gauge: Final[float]
    gauge_depth: Final[float]
    track_gauge_depth: Final[float]
    friction: Final[float]
    track_friction: Final[float]
    rail_inclination: Final[float]
    track_rail_inclination: Final[float]
    rail_inclination_right: Final[str]
    track_rail_inclination_right: Final[str]
    youngs_modulus: Final[float]
    material_youngs_modulus: Final[float]
    poisson: Final[float]
    material_poisson: Final[float]
    shear_modulus: Final[float]
    material_shear_modulus: Final[float]
    wheel_profile: Final[str]
    profiles_wheel_profile: Final[str]
    rail_profile: Final[str]
    profiles_rail_profile: Final[str]
    wheel_profile_right: Final[str]
    profiles_wheel_profile_right: Final[str]
    rail_profile_right: Final[str]
    profiles_rail_profile_right: Final[str]
    Y: Final[float]
    initial_Y: Final[float]
    Z: Final[float]
    initial_Z: Final[float]
    initial_roll: Final[float]
    pitch: Final[float]
    initial_pitch: Final[float]
    vX: Final[float]
    initial_vX: Final[float]
    vY: Final[float]
    initial_vY: Final[float]
    vZ: Final[float]
    initial_vZ: Final[float]
    roll_rate: Final[float]
    initial_roll_rate: Final[float]
    roll_link: Final[Literal["none", "rails"]]
    initial_roll_link: Final[Literal["none", "rails"]]
    pitch_rate: Final[float]
    initial_pitch_rate: Final[float]
    lateral_force: Final[float]
    loading_lateral_force: Final[float]
    lateral_ramp: Final[float]
    loading_lateral_ramp: Final[float]
    formulation: Final[Literal["elastic", "bilateral", "unilateral"]]
    contact_formulation: Final[Literal["elastic", "bilateral", "unilateral"]]
    restitution: Final[float]
    contact_restitution: Final[float]
    model: Final[Literal["halfspace", "strip", "hertz"]]
    contact_model: Final[Literal["halfspace", "strip", "hertz"]]
    influence: Final[Literal["local", "flat", "apart", "bodies"]]
    contact_influence: Final[Literal["local", "flat", "apart", "bodies"]]
    bodies: Final[str]
    contact_bodies: Final[str]
    flange_angle: Final[float]
    contact_flange_angle: Final[float]
    stiffness_scale: Final[float]
    contact_stiffness_scale: Final[float]
    table_folder: Final[str]
    lateral: Final[float]
    table_lateral: Final[float]
    lift: Final[float]
    table_lift: Final[float]
    drop: Final[float]
    table_drop: Final[float]
    table_roll: Final[float]
    depth: Final[float]
    table_depth: Final[float]
    accuracy: Final[float]
    table_accuracy: Final[float]
    order: Final[int]
    integrator_order: Final[int]
    beta: Final[float]
    integrator_beta: Final[float]
    gamma: Final[float]
    integrator_gamma: Final[float]
    dt: Final[float]
    integrator_dt: Final[float]
    t_end: Final[float]
    integrator_t_end: Final[float]
    stop_at: Final[Literal["t_end", "return_to_centre", "derailment"]]
    integrator_stop_at: Final[Literal["t_end", "return_to_centre", "derailment"]]
    error_tolerance: Final[float]
    integrator_error_tolerance: Final[float]
    energy_tolerance: Final[float]
    integrator_energy_tolerance: Final[float]
    tolerance: Final[float]
    integrator_tolerance: Final[float]
    max_iterations: Final[int]
    integrator_max_iterations: Final[int]
    max_halvings: Final[int]
    integrator_max_halvings: Final[int]
    output_file: Final[str]
    interval: Final[float]
    output_interval: Final[float]
    rows: Final[Literal["interval_and_events", "contacts", "interval"]]
    output_rows: Final[Literal["interval_and_events", "contacts", "interval"]]
    pressures: Final[Literal["yes", "no"]]
    output_pressures: Final[Literal["yes", "no"]]
    judged: Final[Literal["yes", "no"]]
    output_judged: Final[Literal["yes", "no"]]

class Values(TypedDict, total=False):
    name: str | PathLike[str]
    case_name: str | PathLike[str]
    title: str | PathLike[str]
    case_title: str | PathLike[str]
    mass: float
    wheelset_mass: float
    roll_inertia: float
    wheelset_roll_inertia: float
    pitch_inertia: float
    wheelset_pitch_inertia: float
    rolling_radius: float
    wheelset_rolling_radius: float
    back_to_back: float
    wheelset_back_to_back: float
    vertical_load: float
    wheelset_vertical_load: float
    gauge: float
    track_gauge: float
    gauge_depth: float
    track_gauge_depth: float
    friction: float
    track_friction: float
    rail_inclination: float | str
    track_rail_inclination: float | str
    rail_inclination_right: float | str
    track_rail_inclination_right: float | str
    youngs_modulus: float
    material_youngs_modulus: float
    poisson: float
    material_poisson: float
    shear_modulus: float
    material_shear_modulus: float
    wheel_profile: str | PathLike[str]
    profiles_wheel_profile: str | PathLike[str]
    rail_profile: str | PathLike[str]
    profiles_rail_profile: str | PathLike[str]
    wheel_profile_right: str | PathLike[str]
    profiles_wheel_profile_right: str | PathLike[str]
    rail_profile_right: str | PathLike[str]
    profiles_rail_profile_right: str | PathLike[str]
    Y: float
    initial_Y: float
    Z: float
    initial_Z: float
    initial_roll: float
    pitch: float
    initial_pitch: float
    vX: float
    initial_vX: float
    vY: float
    initial_vY: float
    vZ: float
    initial_vZ: float
    roll_rate: float
    initial_roll_rate: float
    roll_link: Literal["none", "rails"]
    initial_roll_link: Literal["none", "rails"]
    pitch_rate: float
    initial_pitch_rate: float
    lateral_force: float
    loading_lateral_force: float
    lateral_ramp: float
    loading_lateral_ramp: float
    formulation: Literal["elastic", "bilateral", "unilateral"]
    contact_formulation: Literal["elastic", "bilateral", "unilateral"]
    restitution: float
    contact_restitution: float
    model: Literal["halfspace", "strip", "hertz"]
    contact_model: Literal["halfspace", "strip", "hertz"]
    influence: Literal["local", "flat", "apart", "bodies"]
    contact_influence: Literal["local", "flat", "apart", "bodies"]
    bodies: str | PathLike[str]
    contact_bodies: str | PathLike[str]
    flange_angle: float
    contact_flange_angle: float
    stiffness_scale: float
    contact_stiffness_scale: float
    table_folder: str | PathLike[str]
    lateral: float
    table_lateral: float
    lift: float
    table_lift: float
    drop: float
    table_drop: float
    table_roll: float
    depth: float
    table_depth: float
    accuracy: float
    table_accuracy: float
    order: int
    integrator_order: int
    beta: float
    integrator_beta: float
    gamma: float
    integrator_gamma: float
    dt: float
    integrator_dt: float
    t_end: float
    integrator_t_end: float
    stop_at: Literal["t_end", "return_to_centre", "derailment"]
    integrator_stop_at: Literal["t_end", "return_to_centre", "derailment"]
    error_tolerance: float
    integrator_error_tolerance: float
    energy_tolerance: float
    integrator_energy_tolerance: float
    tolerance: float
    integrator_tolerance: float
    max_iterations: int
    integrator_max_iterations: int
    max_halvings: int
    integrator_max_halvings: int
    output_file: str | PathLike[str]
    interval: float
    output_interval: float
    rows: Literal["interval_and_events", "contacts", "interval"]
    output_rows: Literal["interval_and_events", "contacts", "interval"]
    pressures: Literal["yes", "no"]
    output_pressures: Literal["yes", "no"]
    judged: Literal["yes", "no"]
    output_judged: Literal["yes", "no"]
