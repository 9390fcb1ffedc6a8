"""What can be hidden in a recording, by the names and parameters of the catalogue, each in the simulator's own terms;
and what is not in the catalogue.
"""

from dataclasses import dataclass, field

import numpy as np

from drives import Faults
from laws import Creep, Jenkins, Mullins
from robot import Robot


@dataclass
class Hidden:
    """A robot, its drives, the laws in its hinges and its tracking, with what is hidden in them."""

    robot: Robot = field(default_factory=Robot)
    faults: Faults = field(default_factory=Faults)
    laws: list = field(default_factory=list)
    shift_m: np.ndarray = field(default_factory=lambda: np.zeros(3))
    drift_m_per_s: np.ndarray = field(default_factory=lambda: np.zeros(3))
    noise_correlation: float = 0.0


def tip_load(hidden, mass_kg):
    hidden.robot.tip_mass_kg = mass_kg


def distributed_mass(hidden, scale):
    hidden.robot.mass_scale = scale


def tip_force(hidden, force_n):
    hidden.robot.tip_force_n = tuple(force_n)


def base_tilt(hidden, tilt_x_rad, tilt_y_rad):
    hidden.robot.base_tilt_rad = (tilt_x_rad, tilt_y_rad)


def frame_shift(hidden, shift_m):
    hidden.shift_m = np.array(shift_m)


def bending_stiffness(hidden, scale):
    hidden.robot.bending_scale = scale


def anisotropic_stiffness(hidden, ratio, angle_rad):
    hidden.robot.bending_ratio, hidden.robot.principal_angle_rad = ratio, angle_rad


def precurvature(hidden, kappa_x_rad_m, kappa_y_rad_m):
    hidden.robot.rest_curvature_rad_m = (kappa_x_rad_m, kappa_y_rad_m)


def soft_section(hidden, position_m, scale):
    hidden.robot.soft_position_m, hidden.robot.soft_scale = position_m, scale


def spine_compressibility(hidden, scale):
    hidden.robot.section_compliance_m_per_n *= scale


def friction(hidden, moment_nm, yield_rad_m=None):
    """Dry friction in every bending hinge: the simulator's own, or one that yields elastically before it slips."""
    if yield_rad_m is None:
        hidden.robot.hinge_friction_nm = moment_nm
    else:
        share = moment_nm / (yield_rad_m * hidden.robot.bending_n_m2())
        hidden.laws.append(Jenkins(share, yield_rad_m, elements=1))


def hysteresis(hidden, share, range_rad_m):
    hidden.laws.append(Jenkins(share, range_rad_m))


def creep(hidden, share, time_s):
    hidden.laws.append(Creep(share, time_s))


def damping(hidden, time_s):
    hidden.robot.damping_time_s = time_s


def delay(hidden, time_s):
    hidden.faults.delay_s = time_s


def backlash(hidden, width_m):
    hidden.faults.play_m = width_m


def actuator_gain(hidden, tendon, scale):
    gains = list(hidden.faults.gains)
    gains[tendon - 1] = scale
    hidden.faults.gains = tuple(gains)


def actuator_offset(hidden, tendon, offset_m):
    hidden.robot.offsets_m[tendon - 1] += offset_m


def tendon_stretch(hidden, compliance_m_per_n):
    hidden.robot.tendon_compliance_m_per_n += compliance_m_per_n


def tendon_angle(hidden, angle_rad):
    hidden.robot.tendon_angles_rad = tuple(angle + angle_rad for angle in hidden.robot.tendon_angles_rad)


def tendon_radius(hidden, scale):
    hidden.robot.tendon_radius_m *= scale


# Not in the catalogue.


def coloured_noise(hidden, correlation):
    """Tracking noise that remembers: AR(1) at the rate of the rows, with the same size as the white one."""
    hidden.noise_correlation = correlation


def wall(hidden, y_m):
    """A smooth half-space beyond y_m that no part of the backbone can enter."""
    hidden.robot.wall_y_m = y_m


def contact_sphere(hidden, center_m, radius_m, body_radius_m=0.002):
    """A smooth fixed sphere that the body, a round one along the backbone, cannot enter."""
    hidden.robot.sphere, hidden.robot.touching_radius_m = (tuple(center_m), radius_m), body_radius_m


def step_loss(hidden, tendon, loss_m, rows):
    """One drive loses `loss_m` of its place in the middle of each trial, from these rows on."""
    hidden.faults.lost_tendon, hidden.faults.lost_m, hidden.faults.lost_rows = tendon, loss_m, tuple(rows)


def dead_zone(hidden, width_m):
    """Drives do nothing within +- width of home, and the rest beyond; without memory."""
    hidden.faults.dead_zone_m = width_m


def frame_drift(hidden, drift_m_per_s):
    """The tracking frame moves slowly and is put right before each trial."""
    hidden.drift_m_per_s = np.array(drift_m_per_s)


def mullins(hidden, loss, scale_rad_m):
    """A hinge's stiffness falls with the largest curvature that it has seen in the trial."""
    hidden.laws.append(Mullins(loss, scale_rad_m))


def loose_base(hidden, stiffness_nm_per_rad):
    """Base and drives stand on a rotational spring."""
    hidden.robot.base_spring_nm_per_rad = stiffness_nm_per_rad


CATALOGUE = (
    tip_load, distributed_mass, tip_force, base_tilt, frame_shift, bending_stiffness, anisotropic_stiffness,
    precurvature, soft_section, spine_compressibility, friction, hysteresis, creep, damping, delay, backlash,
    actuator_gain, actuator_offset, tendon_stretch, tendon_angle, tendon_radius,
)  # fmt: skip
OUTSIDE = (coloured_noise, wall, contact_sphere, step_loss, dead_zone, frame_drift, mullins, loose_base)
NAMES = {effect.__name__: effect for effect in CATALOGUE + OUTSIDE}


def hide(effects, chain=None):
    """A robot with these effects, [{name: parameters}, ...], as a `chain` of other pieces or tendons."""
    hidden = Hidden(robot=Robot(**(chain or {})))
    for effect in effects:
        for name, parameters in effect.items():
            NAMES[name](hidden, **parameters)
    return hidden
