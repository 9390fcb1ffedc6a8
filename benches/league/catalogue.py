"""Effects by the names and parameters of `spinebench effects`, put into a robot of robots.py.

benches/twin has most of them; here are those that concern segments, and what is refused. `tendon_friction`, `servo_lag` and
`contact` have no counterpart in the chain. Of benches/twin's own effects outside the catalogue, `wall`, `contact_sphere`,
`dead_zone` and `mullins` are accepted too. Where an effect occurs twice the last one counts, as in benches/twin; offsets,
pretensions, stretch, angles, radii, compressibility and laws with a memory accumulate.
"""

import math

from refusal import Refusal
from robots import ROBOTS, Segmented, segment_ends_m  # makes the modules of benches/twin known

import effects as twin
from drives import Faults

OUTSIDE = (twin.wall, twin.contact_sphere, twin.dead_zone, twin.mullins)


def bending_stiffness(hidden, scale, segment=0):
    """Of all segments (0) or of one of them."""
    if segment and isinstance(hidden.robot, Segmented):
        hidden.robot.segment_scales[segment] = scale
    else:
        hidden.robot.bending_scale = scale


def pretension(hidden, segment=1, change_m=0.0):
    """Tightens all tendons that end with the segment."""
    robot = hidden.robot
    end_m = segment_ends_m(robot)[segment - 1]
    for i, own_m in enumerate(robot.tendon_ends_m or [robot.length_m] * len(robot.tendon_angles_rad)):
        if own_m == end_m:
            robot.offsets_m[i] += change_m


EFFECTS = {effect.__name__: effect for effect in (*twin.CATALOGUE, *OUTSIDE, bending_stiffness, pretension)}
# What the chain's laws of these names cannot do: refused unless it is 0.
LACKING = {"friction": ("coupled", "segment"), "creep": ("relaxed",)}
# Numbers that may be negative. No other number may be, and a scale and the time of creep may not be 0.
SIGNED = (
    "force_n", "tilt_x_rad", "tilt_y_rad", "shift_m", "ratio", "angle_rad", "kappa_x_rad_m", "kappa_y_rad_m",
    "offset_m", "change_m", "y_m", "center_m",
)  # fmt: skip
NEEDS_SECTIONS = ("soft_section", "spine_compressibility")


def check_numbers(name, key, value):
    """Refuses anything but finite numbers, in lists of three or alone, and numbers that no robot has."""
    listed, vector = isinstance(value, list), key in ("force_n", "shift_m", "center_m")
    if listed != vector or listed and len(value) != 3:
        raise Refusal("refused", f"{name}: {key}: found {value!r}, expected {'three numbers' if vector else 'a number'}")
    for number in value if listed else [value]:
        if not isinstance(number, (int, float)) or not math.isfinite(number):
            raise Refusal("refused", f"{name}: {key}: found {value!r}, expected finite numbers")
        if key not in SIGNED and (number < 0 or number == 0 and (key == "scale" or (name, key) == ("creep", "time_s"))):
            raise Refusal("refused", f"{name}: {key}: found {value!r}, expected a positive number")


def check_place(name, key, value, count):
    """A tendon or a segment: an integer from 1 (a segment: 0 for all) to `count`."""
    least = 0 if (name, key) == ("bending_stiffness", "segment") else 1
    if value != int(value) or not least <= value <= count:
        raise Refusal("refused", f"{name}: {key}: found {value}, expected an integer from {least} to {count}")
    return int(value)


def add(hidden, name, parameters):
    if name not in EFFECTS:
        raise Refusal("refused", f"the effect {name} is not available on this robot")
    if name in NEEDS_SECTIONS and not hidden.robot.sections:
        raise Refusal("refused", f"the effect {name} is not available on this robot: it has no compressible sections")
    if not isinstance(parameters, dict):
        raise Refusal("refused", f"{name}: found {parameters!r}, expected parameters")
    counts = {"tendon": len(hidden.robot.tendon_angles_rad), "segment": len(segment_ends_m(hidden.robot))}
    given = {}
    for key, value in parameters.items():
        check_numbers(name, key, value)
        if key in LACKING.get(name, ()):
            if value:
                raise Refusal("refused", f"the effect {name} is not available on this robot with {key}")
        else:
            given[key] = check_place(name, key, value, counts[key]) if key in counts else value
    try:
        EFFECTS[name](hidden, **given)
    except TypeError as error:
        # A parameter is missing or unknown.
        raise Refusal("refused", f"{name}: {error}") from None


def build(robot, pieces, effects):
    """The robot of this name with these effects, [{name: parameters}, ...]; `pieces`: of the chain, None for its own."""
    made = ROBOTS[robot](pieces) if pieces else ROBOTS[robot]()
    hidden = twin.Hidden(robot=made, faults=Faults(gains=(1.0,) * len(made.tendon_angles_rad)))
    if not isinstance(effects, list) or not all(isinstance(effect, dict) for effect in effects):
        raise Refusal("refused", f"effects: found {effects!r}, expected a list of {{name: parameters}}")
    for effect in effects:
        for name, parameters in effect.items():
            add(hidden, name, parameters)
    return hidden
