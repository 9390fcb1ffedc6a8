"""The smallest server of the robot protocol: an arm of constant curvature, on stdin and stdout, without other packages.

Copy it and put your own simulator or robot behind `home` and `drive`. It works as it stands: give the plant the command
["python3", "example_robot.py"]. In a frame with z along the straight robot from its base and x up, tendon 1 lies above the
backbone (at x = 1 cm), tendon 2 at y = 1 cm, 3 and 4 opposite them. A positive displacement pulls."""

import json
import math
import sys

LENGTH_M, RADIUS_M, TENDONS = 0.2, 0.01, 4


def home():
    """Displacements of the robot at rest."""
    return [0.0] * TENDONS


def drive(pulls_m):
    """Holds the displacements for a step and returns those of the tendons. None: the tendon is to follow freely, here by as
    much as the opposite one is pulled. With a real robot, sleep for the rest of the step."""
    opposite_m = [pulls_m[(i + 2) % TENDONS] or 0.0 for i in range(TENDONS)]
    return [-opposite_m[i] if pulls_m[i] is None else pulls_m[i] for i in range(TENDONS)]


def tip_m(pulls_m):
    """The difference of opposite tendons bends the arm towards the pulled one."""
    x, y = (pulls_m[0] - pulls_m[2]) / (2 * RADIUS_M), (pulls_m[1] - pulls_m[3]) / (2 * RADIUS_M)
    angle = max(math.hypot(x, y), 1e-9)
    aside = LENGTH_M * (1 - math.cos(angle)) / angle
    return [aside * x / angle, aside * y / angle, LENGTH_M * math.sin(angle) / angle]


def main():
    step_s, time_s, pulls_m = 0.2, 0.0, home()
    for line in sys.stdin:
        try:
            ((request, body),) = json.loads(line).items()
            if request == "bye":
                return
            if request == "hello":  # body["options"] and body["effects"] hold what the experiment asks for
                step_s = body["step_s"]
            elif request == "reset":
                time_s, pulls_m = 0.0, home()
            elif request == "command":
                asked = body["pulls_m"]
                if len(asked) != TENDONS or not all(pull is None or math.isfinite(pull) for pull in asked):
                    raise ValueError(f"pulls_m: expected {TENDONS} finite numbers")
                pulls_m, time_s = drive(asked), time_s + step_s
            else:
                raise ValueError(f"found the request {request}")
            reply = {"observe": {"time_s": time_s, "tip_m": tip_m(pulls_m), "pulls_m": pulls_m}}
            if request == "hello":
                reply = {"robot": {"protocol": 1, "name": "arm", "tendons": TENDONS, "length_m": LENGTH_M, "points": []}}
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            reply = {"error": {"kind": "refused", "message": repr(error)}}
        print(json.dumps(reply), flush=True)


main()
