"""Tests of serve.py and example_robot.py: `python3 test_serve.py`, or pytest. They need MuJoCo (requirements.txt)."""

import json
import math
import re
import socket
import subprocess
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
SERVE = [sys.executable, str(HERE / "serve.py")]
WAIT_S = 120


def hello(effects=(), step_s=0.2, **options):
    return {"hello": {"protocol": 1, "step_s": step_s, "options": options, "effects": list(effects)}}


def commands(*pulls):
    return [{"reset": {"seed": 1}}, *({"command": {"pulls_m": list(row)}} for row in pulls)]


def raw(requests, program=SERVE):
    """Reply lines of a process to requests (objects, or lines as they are); it must end by itself."""
    lines = [request if isinstance(request, str) else json.dumps(request) for request in requests]
    done = subprocess.run(program, input="\n".join([*lines, ""]).encode(), capture_output=True, timeout=WAIT_S)
    assert done.returncode == 0, done.stderr.decode()
    return done.stdout.splitlines()


def ask(*requests, program=SERVE):
    return [json.loads(line) for line in raw(requests, program)]


def tips(replies):
    return np.array([reply["observe"]["tip_m"] for reply in replies if "observe" in reply])


def refused(reply, *words, kind="refused"):
    assert reply["error"]["kind"] == kind, reply
    assert all(word in reply["error"]["message"] for word in words), reply


def test_the_three_robots_over_a_pipe():
    for name, tendons, length_m in (("paper", 4, 0.22), ("two_segment", 6, 0.4), ("nine_tendon", 9, 0.3)):
        robot, start, end = ask(hello(robot=name), *commands([0.004] + [-0.004] * (tendons - 1)))
        said = {"protocol": 1, "name": f"mujoco {name}", "tendons": tendons, "length_m": length_m, "points": []}
        assert robot == {"robot": said}
        first, last = start["observe"], end["observe"]
        assert first["time_s"] == 0 and last["time_s"] == 0.2
        assert first["pulls_m"] == [0.0] * tendons and last["pulls_m"][0] == 0.004
        assert 0.9 * length_m < first["tip_m"][2] <= length_m and first["tip_m"][0] <= 0
        assert last["tip_m"][0] > first["tip_m"][0] + 0.002 and last["tensions_n"][0] > 0
        assert math.isclose(sum(x * x for x in last["tip_quaternion"]), 1, abs_tol=1e-6)


def test_the_process_ends_with_bye_and_with_its_input():
    assert raw([{"bye": {}}, hello()]) == []
    assert raw([]) == []


def test_equal_requests_get_equal_bytes():
    trial = commands([0.01, 0, None, 0], [0.004, 0.01, -0.004, None], [0, 0, 0, 0])
    other = commands([-0.02, 0.02, 0.02, -0.02], [None] * 4)
    effects = [
        {"hysteresis": {"share": 0.2, "range_rad_m": 5}},
        {"creep": {"share": 0.1, "time_s": 2}},
        {"delay": {"time_s": 0.05}},
    ]
    change = {"at_s": 0.3, "effects": [{"friction": {"moment_nm": 0.01}}, {"tip_load": {"mass_kg": 0.02}}]}
    first = raw([hello(effects, change=change), *trial])
    again = raw([hello(robot="two_segment"), hello(effects, change=change), *other, *trial])
    assert first[1:] == again[-len(trial) :]
    assert again[-len(trial) :] == raw([hello(effects, change=change), *trial, *other, *trial])[-len(trial) :]


def test_clients_of_a_port_come_one_after_the_other():
    requests = [hello(), *commands([0.01, 0, -0.01, 0], [None] * 4)]
    server = subprocess.Popen([*SERVE, "--port", "0"], stderr=subprocess.PIPE)
    try:
        port = int(re.fullmatch(r"listening on 127.0.0.1:(\d+)\n", server.stderr.readline().decode())[1])
        for leave in (b'{"bye": {}}\n', b"", b""):
            with socket.create_connection(("127.0.0.1", port), WAIT_S) as client, client.makefile("rb") as replies:
                got = []
                for request in requests:
                    client.sendall(json.dumps(request).encode() + b"\n")
                    got.append(replies.readline().rstrip(b"\n"))
                client.sendall(leave)
                assert got == raw(requests)
        assert server.poll() is None
    finally:
        server.kill()
        server.wait()
        server.stderr.close()


def test_requests_that_cannot_be_met():
    bad = [
        "no json", "[1]", "{}", '{"dance": {}}', '{"reset": 1}', '{"command": {}}', '{"command": {"pulls_m": [0, 0, 0]}}',
        '{"command": {"pulls_m": [NaN, 0, 0, 0]}}', '{"command": {"pulls_m": [0, 1e999, 0, 0]}}',
        '{"command": {"pulls_m": [0, 0, "1", 0]}}', '{"command": {"pulls_m": [0, 0, true, 0]}}',
        '{"command": {"pulls_m": [0.061, 0, 0, 0]}}', f'{{"command": {{"pulls_m": [1{400 * "0"}, 0, 0, 0]}}}}', 100000 * "[",
    ]  # fmt: skip
    good = commands([0.01, 0, None, 0], [0.0, 0.01, 0, 0])
    plain = ask(hello(), *good)
    replies = ask(hello(), good[0], *bad, good[1], *bad, good[2])
    for reply in replies[2 : 2 + len(bad)] + replies[3 + len(bad) : -1]:
        refused(reply)
    assert [reply for reply in replies if "error" not in reply] == plain
    refused(ask({"reset": {}})[0], "hello")
    refused(ask(hello(), {"command": {"pulls_m": [0] * 4}})[1], "reset")
    refused(ask({"hello": {"protocol": 2, "step_s": 0.2}})[0], "protocol")
    refused(ask({"hello": {"protocol": 1, "step_s": 0}})[0], "step_s")
    refused(ask(hello(robot="snake"))[0], "snake")
    refused(ask(hello(colour="red"))[0], "colour")


def test_effects_that_are_not_available():
    for name in ("tendon_friction", "servo_lag", "contact", "magic"):
        refused(ask(hello([{name: {}}]))[0], name)
        refused(ask(hello(change={"at_s": 1, "effects": [{name: {}}]}))[0], name)
    refused(ask(hello([{"soft_section": {"position_m": 0.1, "scale": 0.5}}], robot="nine_tendon"))[0], "soft_section")
    refused(ask(hello([{"creep": {"share": 0.1, "time_s": 1, "relaxed": 1}}]))[0], "creep", "relaxed")
    refused(ask(hello([{"tip_load": {"mass_g": 1}}]))[0], "tip_load", "mass_g")
    refused(ask(hello([{"tip_load": {"mass_kg": -1}}]))[0], "tip_load", "mass_kg")
    refused(ask(hello([{"tip_force": {"force_n": 1}}]))[0], "tip_force", "three numbers")
    refused(ask(hello([{"friction": {"moment_nm": 0.01, "yield_rad_m": 0}}]))[0], "division")
    refused(ask(hello([{"creep": {"share": 0.1, "time_s": 0}}]))[0], "creep", "time_s")
    refused(ask(hello([{"actuator_gain": {"tendon": 5, "scale": 1.1}}]))[0], "actuator_gain", "tendon")


def test_a_simulation_that_fails_says_so_until_a_reset():
    wild = [[0.06 * sign for sign in signs] for signs in ((1, 1, 1, 1, 1, 1), (1, -1, 1, -1, 1, -1), (1, 1, 1, 1, 1, 1))]
    replies = ask(hello(robot="two_segment"), *commands(*wild), *commands([0] * 6))
    failed = [reply for reply in replies if "error" in reply]
    refused(failed[0], "unstable", kind="solver")
    assert all(reply["error"]["kind"] == "refused" for reply in failed[1:])
    assert replies[-2] == replies[1] and "observe" in replies[-1]


def test_a_tendon_that_follows_has_neither_slack_nor_tension():
    follow = [[0.012, 0, None, None]] * 8
    moved = ask(hello(), *commands(*follow))[-1]["observe"]
    assert moved["tensions_n"][2:] == [0, 0] and moved["tensions_n"][0] > 1
    held = ask(hello(), *commands(*follow, *[moved["pulls_m"]] * 8))[-1]["observe"]
    assert max(held["tensions_n"][2:]) < 0.001
    assert np.linalg.norm(np.subtract(held["tip_m"], moved["tip_m"])) < 1e-6
    tighter = np.add(moved["pulls_m"], [0, 0, 0.001, 0]).tolist()
    assert ask(hello(), *commands(*follow, tighter))[-1]["observe"]["tensions_n"][2] > 0.1


def test_the_robot_changes_at_the_time_of_a_trial():
    load = [{"tip_load": {"mass_kg": 0.02}}]
    rows = [[0.01, 0, -0.01, 0]] * 20
    plain, loaded = (tips(ask(hello(effects), *commands(*rows))) for effects in ([], load))
    late = tips(ask(hello(change={"at_s": 0.5, "effects": load}), *commands(*rows), *commands(*rows)))
    assert (late[:21] == late[21:]).all()
    assert (late[:3] == plain[:3]).all()
    # In the step of the change the tip is between, at the end it is where it would have been all along.
    assert loaded[-1, 0] < late[3, 0] < plain[3, 0] or late[3, 0] < loaded[-1, 0]
    assert np.linalg.norm(late[20] - loaded[-1]) < 1e-5 < np.linalg.norm(late[20] - plain[-1])
    assert (tips(ask(hello(change={"at_s": 0, "effects": load}), *commands(*rows))) == loaded).all()
    # The tip moves on from where it is.
    small = tips(ask(hello(step_s=0.005, change={"at_s": 0.5, "effects": load}), *commands(*([[0.01, 0, -0.01, 0]] * 120))))
    assert np.linalg.norm(np.diff(small[95:], axis=0), axis=1).max() < 1.5e-3


def test_changed_drives_and_segments():
    gain = {"at_s": 0.4, "effects": [{"actuator_gain": {"tendon": 1, "scale": 0.5}}]}
    rows = [[0.01, 0, None, 0]] * 20
    halved = ask(hello(gain["effects"]), *commands(*rows))[-1]["observe"]
    late = ask(hello(change=gain), *commands(*rows))[-1]["observe"]
    assert np.linalg.norm(np.subtract(late["tip_m"], halved["tip_m"])) < 1e-5 and late["pulls_m"][0] == 0.01
    for robot, tendons in (("two_segment", 6), ("nine_tendon", 9)):
        ends = [
            tips(ask(hello(effects, robot=robot), *commands([0.004] + [0.0] * (tendons - 1))))[-1]
            for effects in (
                [],
                [{"bending_stiffness": {"scale": 0.7, "segment": 1}}],
                [{"bending_stiffness": {"scale": 0.7, "segment": 2}}],
                [{"pretension": {"segment": 1, "change_m": 0.001}}],
            )
        ]
        assert all(np.linalg.norm(a - b) > 1e-5 for i, a in enumerate(ends) for b in ends[:i])


def test_the_paper_robot_is_that_of_the_twin():
    sys.path[:0] = [str(HERE.parent / "twin")]
    from chain import Chain
    from drives import Drives
    from effects import hide

    rows = np.array([[0, 0, 0, 0], [0.003, 0, -0.003, 0], [0.005, 0.002, -0.005, -0.002], [0.001, 0.004, -0.001, -0.004]])
    effects = [
        {"hysteresis": {"share": 0.2, "range_rad_m": 5}}, {"backlash": {"width_m": 0.001}}, {"delay": {"time_s": 0.05}},
        {"actuator_gain": {"tendon": 2, "scale": 1.1}}, {"frame_shift": {"shift_m": [0.001, 0, 0.002]}},
    ]  # fmt: skip
    hidden = hide(effects, {"pieces": 11})
    chain = Chain(hidden.robot, hidden.laws)
    chain.rest(np.zeros(4))
    twin = chain.trial(Drives(rows, 0.2, hidden.faults, 0), len(rows), 0.2) + hidden.shift_m
    served = tips(ask(hello(effects), *commands(*rows[:-1].tolist())))
    assert abs(served - twin).max() < 2e-9


def test_the_example_robot():
    program = [sys.executable, str(HERE / "example_robot.py")]
    requests = [
        hello(),
        *commands([0.005, 0, None, 0], [0, 0, 0, 0]),
        "no json",
        {"command": {"pulls_m": [0]}},
        {"bye": {}},
        hello(),
    ]
    robot, start, bent, back, *errors = ask(*requests, program=program)
    assert robot["robot"]["tendons"] == 4 and start["observe"]["tip_m"] == [0, 0, 0.2]
    assert bent["observe"]["tip_m"][0] > 0.04 and bent["observe"]["pulls_m"] == [0.005, 0, -0.005, 0]
    assert back["observe"]["tip_m"] == [0, 0, 0.2] and back["observe"]["time_s"] == 0.4
    assert len(errors) == 2
    for error in errors:
        refused(error)


if __name__ == "__main__":
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            test()
            print(f"{name}: passed", flush=True)
