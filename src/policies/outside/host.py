"""Hosts a policy, a class in a file of Python, for the harness: `python3 -s -B host.py FILE CLASS`. A request a line on
standard input, a reply a line on standard output, in JSON. `-I` works too, but then Python ignores PYTHONHASHSEED."""

import sys
sys.path[: not sys.flags.isolated] = []  # No file of a submission in place of a module that this imports.
import importlib.util
import json
import math
import os
import queue  # noqa: F401  (it and what it imports keep the real clock: their waits must end)
import random
import time
import traceback

try:
    import numpy
    array, ndim = lambda values: numpy.array(values, dtype=numpy.float64), numpy.ndim
except ImportError:
    numpy, array, ndim = None, list, lambda value: int(hasattr(value, "__len__"))
FORBIDDEN = {"os.exec", "os.fork", "os.forkpty", "os.posix_spawn", "os.system", "subprocess.Popen", "socket.__new__"}


class Fault(Exception):
    """A kind of error of the protocol, and a sentence."""


def refuse(event, _):
    """Refuses with a line in the policy what the harness would end the process for; a library that only tries goes on."""
    if event in FORBIDDEN:
        raise PermissionError(f"{event}: a policy cannot start a program or open a socket")


class Host:
    def __init__(self, file, class_name):
        self.file, self.class_name = os.path.abspath(file), class_name
        self.policy, self.seed, self.trial, self.time_s = None, 0, 0, 0.0

    def hello(self, robot):
        self.seed = int(robot.get("seed", 0))
        self.repeatable()
        sys.addaudithook(refuse)
        os.environ["PATH"] = ""  # A library that asks for a compiler finds none, and goes on.
        for name in ("time", "monotonic", "perf_counter", "process_time", "thread_time"):
            setattr(time, name, lambda: self.time_s)
            setattr(time, name + "_ns", lambda: round(self.time_s * 1e9))
        sys.path.insert(0, os.path.dirname(self.file))
        name = "spinebench_policy_" + os.path.splitext(os.path.basename(self.file))[0]
        spec = importlib.util.spec_from_file_location(name, self.file)
        module = sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        self.repeatable()
        made = getattr(module, self.class_name, None)
        self.policy = made() if callable(made) else None
        if not callable(getattr(self.policy, "act", None)):
            policies = [name for name, value in vars(module).items() if callable(getattr(value, "act", None))]
            found = f"; found {', '.join(policies)}" if policies else ""
            file = os.path.basename(self.file)
            raise Fault("failed", f"no class `{self.class_name}` with a method act() in {file}{found}")
        self.optional("begin", robot)
        return {"ready": {"closed_loop_only": bool(getattr(self.policy, "closed_loop_only", False))}}

    def repeatable(self):
        seed = (self.seed + self.trial) % 2**32
        os.urandom = random._urandom = random.Random(seed).randbytes  # numpy's default_rng() asks it.
        for module, function in (("random", "seed"), ("numpy.random", "seed"), ("torch", "manual_seed")):
            if module in sys.modules:
                getattr(sys.modules[module], function)(seed)

    def optional(self, name, *arguments):
        return getattr(self.policy, name, lambda *_: None)(*arguments)

    def sample(self, view):
        pulls = self.optional("sample", array(view["tip_m"]), array(view["pulls_m"]))
        return {"enough": {}} if pulls is None else {"pulls_m": displacements(pulls, "sample")}

    def reset(self, _):
        self.trial, self.time_s = self.trial + 1, 0.0
        self.repeatable()
        self.optional("reset")
        return {"ready": {}}

    def act(self, view):
        self.time_s, settled = float(view["time_s"]), None
        decided = self.policy.act(*(array(view[key]) for key in ("tip_m", "target_m", "pulls_m")), self.time_s)
        if isinstance(decided, tuple) and len(decided) == 2 and ndim(decided[1]) == 0:
            decided, settled = decided[0], bool(decided[1])
        return {"pulls_m": displacements(decided, "act"), "settled": settled}

    def told(self, error):
        """An exception as a reply, with its line in the submission, or else where it was raised."""
        traceback.clear_frames(error.__traceback__)  # Of a MemoryError, they hold the memory.
        frames = [(frame.filename, frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]
        frames += [(error.filename, error.lineno)] if isinstance(error, SyntaxError) and error.filename else []
        own = [frame for frame in frames if frame[0].startswith(os.path.dirname(self.file) + os.sep)]
        place = "".join(f"{os.path.basename(file)}:{line}: " for file, line in (own or frames)[-1:])
        kind = "out_of_memory" if isinstance(error, MemoryError) else "failed"
        told = kind, " ".join(f"{place}{type(error).__name__}: {error}".split())[:2000]
        return {"error": dict(zip(("kind", "message"), error.args if isinstance(error, Fault) else told))}


def displacements(values, method):
    try:
        pulls = [float(value) for value in values] if numpy is None else numpy.asarray(values, dtype=numpy.float64)
    except (TypeError, ValueError):
        raise Fault("failed", f"{method}(): found a {type(values).__name__}, expected displacements of the tendons") from None
    if numpy and pulls.ndim != 1:
        raise Fault("failed", f"{method}(): found shape {pulls.shape}, expected one number per tendon")
    if not all(map(math.isfinite, pulls)):
        raise Fault("not_finite", f"{method}(): found {list(map(float, pulls))}, expected finite displacements")
    return list(map(float, pulls))


requests, replies = os.fdopen(os.dup(0), encoding="utf-8"), os.fdopen(os.dup(1), "w", encoding="utf-8")
os.dup2(2, 1)  # What the policy prints is not the protocol, and what it reads neither.
os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
host = Host(*sys.argv[1:3])
for request in requests:
    ((kind, content),) = json.loads(request).items()
    try:
        reply = getattr(host, kind)(content)
    except BaseException as error:  # SystemExit too: the harness hears of it.
        reply = host.told(error)
    print(json.dumps(reply), file=replies, flush=True)
