"""A MuJoCo robot that a league plays behind the JSON-lines protocol of a robot.

usage: serve.py             one client on stdin and stdout; ends with `bye` or at the end of input
       serve.py --port N    clients on 127.0.0.1:N, one after the other; `bye` and hanging up make room for the next.
                            N = 0: a free port. Prints `listening on 127.0.0.1:PORT` to stderr

options of hello, all optional:
    robot       "paper" (default), "two_segment", "nine_tendon": see robots.py
    change      {"at_s": 12.4, "effects": [...]}: from that time of each trial on the robot has these effects too; it goes on
                from its posture, see trial.py
    pieces      rigid pieces of the chain in place of the robot's own
    dt_s        longest time step in place of the robot's own

A refused command changes nothing. After an error of kind "solver" a trial needs `reset`. Nothing is random: the seed of
`reset` is not used, and equal requests after `hello` get equal bytes on one machine. measure.py has figures.
"""

import json
import math
import socket
import sys

import mujoco
import numpy as np
from refusal import Refusal
from robots import ROBOTS
from trial import Trial

LARGEST_PULL_M = 0.06
OPTIONS = ("robot", "change", "pieces", "dt_s")
# MuJoCo's warnings are found in its data; by default it writes them to a file in the working directory.
mujoco.set_mju_user_warning(lambda message: None)


def refuse_unless(holds, message):
    if not holds:
        raise Refusal("refused", message)


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


class Conversation:
    """Answers the requests of one client."""

    def __init__(self):
        self.trial, self.started, self.ended = None, False, False

    def answer(self, line):
        """The reply to a line, as a line; None after `bye`."""
        try:
            reply = self.reply(line)
        except Refusal as refusal:
            if refusal.kind == "solver":
                self.started = False
            reply = {"error": {"kind": refusal.kind, "message": str(refusal)}}
        return None if reply is None else json.dumps(reply) + "\n"

    def reply(self, line):
        try:
            # An integer of any length is a number; one of 400 digits is infinite.
            request = json.loads(line, parse_int=float)
        except (ValueError, RecursionError) as error:
            raise Refusal("refused", f"not a line of JSON: {error}") from None
        refuse_unless(isinstance(request, dict) and len(request) == 1, 'expected an object with one key, {"request": {...}}')
        ((name, body),) = request.items()
        known = {"hello": self.hello, "reset": self.reset, "command": self.command, "bye": self.bye}
        refuse_unless(name in known, f"found the request {name!r}, expected one of {', '.join(known)}")
        refuse_unless(isinstance(body, dict), f"{name}: found {body!r}, expected an object")
        return known[name](body)

    def hello(self, body):
        self.trial, self.started = None, False
        refuse_unless(body.get("protocol") == 1, f"found protocol {body.get('protocol')!r}, expected 1")
        step_s = body.get("step_s")
        refuse_unless(is_number(step_s) and 0.001 <= step_s <= 10, f"step_s: found {step_s!r}, expected 0.001 to 10 s")
        options = body.get("options") or {}
        refuse_unless(isinstance(options, dict), "options: expected an object")
        for key in options:
            refuse_unless(key in OPTIONS, f"found the option {key!r}, expected one of {', '.join(OPTIONS)}")
        pieces, dt_s, change = options.get("pieces"), options.get("dt_s"), options.get("change")
        refuse_unless(pieces is None or pieces in range(3, 101), f"pieces: found {pieces!r}, expected 3 to 100")
        fine = dt_s is None or is_number(dt_s) and 1e-5 <= dt_s <= 0.002
        refuse_unless(fine, f"dt_s: found {dt_s!r}, expected 1e-5 to 0.002 s")
        if change is not None:
            shaped = isinstance(change, dict) and set(change) == {"at_s", "effects"} and isinstance(change["effects"], list)
            refuse_unless(shaped and is_number(change["at_s"]), 'change: expected {"at_s": seconds, "effects": [...]}')
        name, effects = options.get("robot", "paper"), body.get("effects") or []
        refuse_unless(name in list(ROBOTS), f"found the robot {name!r}, expected one of {', '.join(ROBOTS)}")
        refuse_unless(isinstance(effects, list), f"effects: found {effects!r}, expected a list")
        self.trial = Trial(name, pieces and int(pieces), effects, change, step_s, dt_s)
        robot = self.trial.before.hidden.robot
        tendons = len(robot.tendon_angles_rad)
        said = {"protocol": 1, "name": f"mujoco {name}", "tendons": tendons, "length_m": robot.length_m, "points": []}
        return {"robot": said}

    def reset(self, body):
        refuse_unless(self.trial, "reset before hello")
        self.trial.reset()
        self.started = True
        return {"observe": self.trial.observe()}

    def command(self, body):
        refuse_unless(self.started, "command before reset")
        pulls, tendons = body.get("pulls_m"), len(self.trial.pulls_m)
        refuse_unless(isinstance(pulls, list) and len(pulls) == tendons, f"pulls_m: expected a list of {tendons}")
        for number, pull in enumerate(pulls, start=1):
            allowed = pull is None or is_number(pull) and abs(pull) <= LARGEST_PULL_M
            refuse_unless(allowed, f"tendon {number}: found {pull!r}, expected null or at most {LARGEST_PULL_M} m either way")
        self.trial.command(np.array([np.nan if pull is None else float(pull) for pull in pulls]))
        return {"observe": self.trial.observe()}

    def bye(self, body):
        self.ended = True


def converse(lines, write):
    """Until `bye` or the end of the lines (bytes)."""
    conversation = Conversation()
    for line in lines:
        answer = conversation.answer(line)
        if conversation.ended:
            return
        write(answer.encode())


def over_pipe():
    def write(answer):
        sys.stdout.buffer.write(answer)
        sys.stdout.buffer.flush()

    converse(sys.stdin.buffer, write)


def over_port(port):
    with socket.create_server(("127.0.0.1", port)) as server:
        print(f"listening on 127.0.0.1:{server.getsockname()[1]}", file=sys.stderr, flush=True)
        while True:
            client, _ = server.accept()
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            try:
                with client, client.makefile("rb") as lines:
                    converse(lines, client.sendall)
            except OSError as error:
                print(f"the client is gone: {error}", file=sys.stderr, flush=True)


def main(arguments):
    if not arguments:
        return over_pipe()
    if len(arguments) == 2 and arguments[0] == "--port" and arguments[1].isdigit():
        return over_port(int(arguments[1]))
    sys.exit(__doc__)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except (KeyboardInterrupt, BrokenPipeError):
        sys.exit(1)
