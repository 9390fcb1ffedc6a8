"""Policies of the tests of the league: an honest one, one that peeks, and faulty ones. Standard library only."""

import ctypes
import fcntl
import os
import socket
import subprocess
import sys
import time


class Honest:
    """Feedback on the error of the tip, for four tendons."""

    def reset(self):
        self.trial, self.bend = getattr(self, "trial", 0) + 1, [0.0, 0.0]

    def act(self, tip_m, target_m, pulls_m, time_s):
        error = [target_m[axis] - tip_m[axis] for axis in range(2)]
        self.bend = [0.8 * value + 0.05 * part for value, part in zip(self.bend, error)] if time_s else [0.1 * part for part in error]
        return [*self.bend, *(-value for value in self.bend)]


class ShortSample(Honest):
    """Samples with a displacement too few."""

    def sample(self, tip_m, pulls_m):
        return pulls_m[:3]


class LastSample(Honest):
    """Acts only where it has seen the tip at home and under both of its samples; answers the request after them, too."""

    closed_loop_only = True

    def sample(self, tip_m, pulls_m):
        self.seen_m = [*getattr(self, "seen_m", []), tip_m[0]]
        return [0.002 * len(self.seen_m), 0.0, -0.002 * len(self.seen_m), 0.0]

    def act(self, *view):
        assert len(self.seen_m) == 3 and sorted(self.seen_m) == self.seen_m, self.seen_m
        return super().act(*view)


def secrets():
    """Each way to learn something that the policy may not know; it returns something, or fails."""
    parent = os.getppid()
    yield lambda: open(f"/proc/{parent}/mem", "rb").read(1)
    yield lambda: open(f"/proc/{parent}/cmdline").read()
    yield lambda: open(f"/proc/{parent}/environ").read()
    yield lambda: os.listdir(f"/proc/{parent}/fd")
    yield lambda: open("/proc/self/environ").read()
    yield lambda: os.environ["SPINEBENCH_TEST_SECRET"]
    yield lambda: open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "secret.txt")).read()
    yield lambda: os.listdir("/tmp")
    yield lambda: open("/etc/passwd").read()
    yield lambda: open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "score", "beside.txt")).read()
    yield lambda: fcntl.lockf(open(__file__), fcntl.LOCK_SH)
    yield lambda: open("written.txt", "w").write("x")
    yield lambda: socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    yield lambda: subprocess.run(["/bin/true"], check=True)


def learnt():
    """Numbers of the ways that gave something."""
    found = []
    for number, way in enumerate(secrets()):
        try:
            way()
            found.append(number)
        except Exception:
            pass
    return found


class Peeking(Honest):
    """Fails where it has learnt something."""

    def act(self, *view):
        found = learnt()
        assert not found, f"learnt by {found}"
        return super().act(*view)


class Faulty(Honest):
    """Honest in its first trial, and faulty from the second on."""

    def act(self, *view):
        return super().act(*view) if self.trial < 2 else self.fail()


class NotFinite(Faulty):
    def fail(self):
        return [float("nan")] * 4


class WrongNumber(Faulty):
    def fail(self):
        return [0.0] * 3


class Late(Faulty):
    def fail(self):
        time.sleep(60)


class Crashing(Faulty):
    def fail(self):
        os._exit(7)


class Forking(Faulty):
    def fail(self):
        ctypes.CDLL(None).fork()


class Hungry(Faulty):
    def fail(self):
        return bytearray(8 << 30)


if __name__ == "__main__":
    print(learnt(), file=sys.stdout)
