"""A robot that is driven step by step, and that may become another one during a trial.

The change: both robots are brought to rest at home beforehand. At the time of the change the second one takes over the
posture and the speeds of the first, the history of the laws that both have, and the current command; new laws begin with
the history that they have at home. The motion continues from there: it does not start from a new equilibrium. A drive with
another gain or play moves to where that puts the current command, in the time that any command takes.
"""

import mujoco
import numpy as np
from catalogue import build
from chain import Chain
from drive import Drive
from refusal import Refusal
from robots import TIME_STEP_S

UNSTABLE = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
# Longer than any tendon: it does not pull.
LOOSE_M = 9.0


class Driven:
    """A chain at rest at home, with its hidden effects."""

    def __init__(self, robot, pieces, effects, dt_s):
        try:
            self.hidden = build(robot, pieces, effects)
            self.chain = Chain(self.hidden.robot, self.hidden.laws, dt_s)
            self.chain.rest(np.zeros(len(self.chain.straight_m)))
        except (ValueError, ArithmeticError) as error:
            raise Refusal("refused", f"effects: there is no such robot: {error}") from None
        self.check()

    def check(self):
        data = self.chain.data
        if any(data.warning[kind].number for kind in UNSTABLE) or not np.isfinite(data.qpos).all():
            raise Refusal("solver", "the simulation became unstable")

    def set_places(self, places_m):
        self.chain.set_pulls(places_m)
        self.chain.lengths_m[np.isnan(places_m)] = LOOSE_M

    def slack_m(self):
        """Displacements at which the tendons have neither slack nor tension in the present posture."""
        model, data = self.chain.model, self.chain.data
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        robot = self.hidden.robot
        return self.chain.straight_m - data.ten_length - robot.pretension_m - robot.offsets_m

    def take_over(self, other):
        """The state of another chain with the same joints."""
        self.chain.restart()
        self.chain.data.qpos[:], self.chain.data.qvel[:] = other.chain.data.qpos, other.chain.data.qvel
        for own, old in zip(self.hidden.laws, other.hidden.laws):
            own.state = old.state.copy()


class Trial:
    """`change`: {"at_s": time of the trial, "effects": [...]}, or None. `pieces`, `most_dt_s`: None for the robot's own."""

    def __init__(self, robot, pieces, effects, change, step_s, most_dt_s):
        self.step_s = step_s
        self.step_ticks = int(np.ceil(step_s / (most_dt_s or TIME_STEP_S) - 1e-9))
        self.dt_s = step_s / self.step_ticks
        self.before = self.after = Driven(robot, pieces, effects, self.dt_s)
        self.change_tick = None
        if change:
            self.change_tick = round(change["at_s"] / self.dt_s)
            self.after = Driven(robot, pieces, effects + change["effects"], self.dt_s)

    def reset(self):
        changed = self.change_tick is not None and self.change_tick <= 0
        self.tick, self.now = 0, self.after if changed else self.before
        self.now.chain.restart()
        self.pulls_m = np.zeros(len(self.now.chain.straight_m))
        self.drive = Drive(self.now.hidden.faults, self.dt_s, self.step_ticks)
        self.set_lengths()

    def set_lengths(self):
        self.now.set_places(self.drive.places_m)

    def command(self, pulls_m):
        """One step with these displacements; NaN: the tendon follows without slack and tension."""
        self.pulls_m = pulls_m
        self.drive.command(self.tick, pulls_m)
        end = self.tick + self.step_ticks
        while self.tick < end:
            self.change_if_due()
            self.drive.start_due(self.tick, self.now.slack_m)
            if self.drive.moving():
                self.now.set_places(self.drive.move())
                count = 1
            else:
                stops = [end, self.drive.next_start(), self.change_tick]
                count = min(stop for stop in stops if stop is not None and stop > self.tick) - self.tick
            self.now.chain.step(count)
            self.tick += count
        self.now.check()
        self.change_if_due()

    def change_if_due(self):
        if self.now is self.after or self.tick < self.change_tick:
            return
        self.after.take_over(self.now)
        self.now = self.after
        drive = Drive(self.now.hidden.faults, self.dt_s, self.step_ticks)
        drive.go_on(self.drive)
        self.drive = drive
        self.set_lengths()

    def observe(self):
        """What the robot shows: metres, newtons, seconds."""
        chain, data, hidden = self.now.chain, self.now.chain.data, self.now.hidden
        slack_m = self.now.slack_m()
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, data.site_xmat[chain.tip])
        following = np.isnan(self.pulls_m)
        stretch_m = np.maximum(data.ten_length - chain.lengths_m, 0.0)
        return {
            "time_s": rounded(self.tick * self.dt_s, 9),
            "tip_m": rounded(data.site_xpos[chain.tip] + hidden.shift_m, 9),
            "tip_quaternion": rounded(quaternion, 9),
            "pulls_m": rounded(np.where(following, slack_m / hidden.faults.gains, self.pulls_m), 9),
            "tensions_n": rounded(stretch_m / hidden.robot.tendon_compliance_m_per_n, 6),
        }


def rounded(values, digits):
    """Plain numbers, without a negative zero."""
    return (np.round(values, digits) + 0.0).tolist()
