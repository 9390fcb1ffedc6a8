"""The robot as a chain of rigid bodies in MuJoCo: two bending hinges and a twist hinge in the middle of each of equal
pieces, a slide in the pieces that hold the middle of a compressible section, and tendons through guide holes.
"""

import mujoco
import numpy as np

TIME_STEP_S = 0.001
# Time to come to rest, with all damping times at least this: more damping changes the way there, not the end.
SETTLE_S = 8.0
SETTLING_DAMPING_S = 0.3
# The drives carry out a command in this time, at constant speed.
DRIVE_S = 0.02
# Dry friction in MuJoCo is viscous below its limit, the more so the less inertia there is. With the largest impedance
# and this much inertia in each hinge (too little to matter beside its damping) it does not crawl during a recording.
FRICTION_IMPEDANCE, FRICTION_ARMATURE_KG_M2 = 0.9999, 1e-4
WALL_STIFFNESS, WALL_DAMPING = 2e4, 3e2
# A sphere gives way by some hundredths of a millimetre under a newton.
SPHERE_TIME_S, SPHERE_IMPEDANCE = 0.004, "0.99 0.999 0.0001"
# A limit of length gives way by as little as a time step of 1 ms allows.
LIMIT_TIME_S, LIMIT_IMPEDANCE = 0.002, "0.999 0.9999 0.0001"


def joint(name, kind, axis, stiffness, damping, rest=0.0, more=""):
    return (
        f'<joint name="{name}" type="{kind}" axis="{axis}" stiffness="{stiffness!r}" damping="{damping!r}"'
        f' springref="{rest!r}" {more}/>'
    )


def joints(robot, k, h, slides):
    """Hinges, and a slide where there is a section, that stand for the piece k of the robot."""
    time = robot.damping_time_s
    out = ""
    if k in slides:
        stiff = 1 / robot.section_compliance_m_per_n
        most = robot.saturation_n / stiff
        out += joint(f"z{k}", "slide", "0 0 1", stiff, time * stiff, 0.0, f'limited="true" range="{-most} {10 * most}"')
    mean = robot.bending_n_m2() / (h * robot.softness(k * h, (k + 1) * h))
    cos, sin = float(np.cos(robot.principal_angle_rad)), float(np.sin(robot.principal_angle_rad))
    kx, ky = robot.rest_curvature_rad_m
    friction = ""
    if robot.hinge_friction_nm:
        friction = f'frictionloss="{robot.hinge_friction_nm}" armature="{FRICTION_ARMATURE_KG_M2}"'
    for name, (a, b), ratio in (("x", (cos, sin), robot.bending_ratio), ("y", (-sin, cos), -robot.bending_ratio)):
        rest = h * (a * kx + b * ky)
        out += joint(f"{name}{k}", "hinge", f"{a!r} {b!r} 0", float(mean * (1 + ratio)), float(mean * time), rest, friction)
    twist = robot.torsion_n_m2() / h
    return out + joint(f"t{k}", "hinge", "0 0 1", twist, twist * time)


def sites(robot, name, places):
    return "".join(
        f'<site name="{name}_{i}_{place}" pos="{x!r} {y!r} {z!r}"/>'
        for place, z in enumerate(places)
        for i, (x, y) in enumerate(robot.holes_m().tolist())
    )


def ends_within(robot, i, start, end):
    """Whether the tendon i is anchored on the body from start to end, and not at the tip."""
    ends = robot.tendon_ends_m
    return ends is not None and start < ends[i] - 1e-9 <= end and ends[i] < robot.length_m - 1e-9


def anchors(robot, k, start, end):
    """Sites on the body k where tendons end before the tip."""
    return "".join(
        f'<site name="s{k}_{i}_end" pos="{x!r} {y!r} {robot.tendon_ends_m[i] - start!r}"/>'
        for i, (x, y) in enumerate(robot.holes_m().tolist())
        if ends_within(robot, i, start, end)
    )


def path(robot, i):
    """Names of the sites that the tendon i runs through."""
    h = robot.length_m / robot.pieces
    names = [f"b_{i}_0", f"b_{i}_1"]
    for k in range(robot.pieces):
        start, end = (k + 0.5) * h, min((k + 1.5) * h, robot.length_m)
        if ends_within(robot, i, start, end):
            length = robot.tendon_ends_m[i] - start - 1e-9
            names += [f"s{k}_{i}_{place}" for place, z in enumerate((0.25 * h, 0.75 * h)) if z < length]
            return [*names, f"s{k}_{i}_end"]
        names += [f"s{k}_{i}_0", f"s{k}_{i}_1"]
    return names


def tendons(robot):
    """A tendon is a stiff spring that does nothing while slack, or a limit of its length: it pulls and never pushes."""
    out = ""
    kind = f'stiffness="{1 / robot.tendon_compliance_m_per_n}" springlength="0 9"'
    if robot.tendons == "limit":
        kind = f'limited="true" range="0 9" solreflimit="{LIMIT_TIME_S} 1" solimplimit="{LIMIT_IMPEDANCE}"'
    for i in range(len(robot.tendon_angles_rad)):
        through = "".join(f'<site site="{name}"/>' for name in path(robot, i))
        out += f'<spatial name="tendon{i}" {kind}>{through}</spatial>'
    return out


def xml(robot, dt_s):
    """Body k runs from the hinges of piece k, in its middle, to those of the next one, or to the tip."""
    h = robot.length_m / robot.pieces
    slides = {int(middle / h - 1e-9) for middle in robot.section_middles_m()}
    chain = ""
    for k in range(robot.pieces):
        start, end = (k + 0.5) * h, min((k + 1.5) * h, robot.length_m)
        mass, centre, side, axial = robot.inertia(start, end)
        ball = f'<geom type="sphere" size="0.001" pos="0 0 {end - start}"/>' if robot.wall_y_m is not None else ""
        if robot.sphere:
            ball += f'<geom type="capsule" size="{robot.touching_radius_m}" fromto="0 0 0 0 0 {end - start}" conaffinity="0"/>'
        chain += (
            f'<body name="s{k}" pos="0 0 {0.5 * h if k == 0 else h}">{joints(robot, k, h, slides)}'
            f'<inertial pos="0 0 {centre - start}" mass="{mass}" diaginertia="{side} {side} {axial}"/>{ball}'
            + sites(robot, f"s{k}", (0.25 * h, 0.75 * h if k < robot.pieces - 1 else 0.5 * h))
            + anchors(robot, k, start, end)
        )
    # What hangs on the tip is a body of its own, so that a force on it acts at the tip.
    tip_mass = robot.tip_mass_kg + 1e-9
    tip = (
        f'<body name="tip" pos="0 0 {0.5 * h}"><inertial pos="0 0 0" mass="{tip_mass}" diaginertia="1e-12 1e-12 1e-12"/>'
        '<site name="tip"/></body>'
    )
    return base(robot, sites(robot, "b", (0.0, 0.25 * h)) + chain + tip + "</body>" * robot.pieces, dt_s)


def base(robot, chain, dt_s):
    tilt = np.array([*robot.base_tilt_rad, 0.0])
    angle = np.linalg.norm(tilt)
    axis = tilt / angle if angle else np.array([1.0, 0.0, 0.0])
    turned = " ".join(map(repr, [*axis.tolist(), float(angle)]))
    spring = ""
    if robot.base_spring_nm_per_rad:
        stiff = robot.base_spring_nm_per_rad
        held = [joint(f"base{name}", "hinge", axis, stiff, 0.1 * stiff) for name, axis in (("x", "1 0 0"), ("y", "0 1 0"))]
        spring = "".join(held) + '<inertial pos="0 0 0" mass="0.2" diaginertia="1e-4 1e-4 1e-4"/>'
    wall = ""
    if robot.wall_y_m is not None:
        facing = -1 if robot.wall_y_m > 0 else 1
        wall = (
            f'<geom type="plane" size="1 1 1" pos="0 {robot.wall_y_m} 0" zaxis="0 {facing} 0" condim="1"'
            f' solref="{-WALL_STIFFNESS} {-WALL_DAMPING}" priority="1"/>'
        )
    if robot.sphere:
        (x, y, z), radius = robot.sphere
        wall += (
            f'<geom type="sphere" size="{radius}" pos="{x} {y} {z}" contype="0" condim="1" priority="1"'
            f' solref="{SPHERE_TIME_S} 1" solimp="{SPHERE_IMPEDANCE}"/>'
        )
    gravity = " ".join(map(str, robot.gravity_m_s2))
    return (
        '<mujoco><compiler angle="radian" boundmass="0" boundinertia="0" balanceinertia="true"/>'
        f'<option timestep="{dt_s}" integrator="discrete" solver="PGS" gravity="{gravity}"/><size memory="32M"/>'
        f'<worldbody>{wall}<body name="base" axisangle="{turned}">{spring}{chain}</body></worldbody>'
        f"<tendon>{tendons(robot)}</tendon></mujoco>"
    )


class Chain:
    """A robot that can be brought to rest and driven. `memory` are laws whose moments act in the bending hinges."""

    def __init__(self, robot, memory=(), dt_s=TIME_STEP_S):
        self.dt_s, self.memory, self.robot = dt_s, memory, robot
        self.model = model = mujoco.MjModel.from_xml_string(xml(robot, dt_s))
        self.data = mujoco.MjData(model)
        mujoco.mj_forward(model, self.data)
        self.straight_m = self.data.ten_length.copy()
        self.tip = model.site("tip").id
        self.data.xfrc_applied[model.body("tip").id, :3] = robot.tip_force_n
        model.dof_solimp[:, :2] = FRICTION_IMPEDANCE
        model.dof_solref[:, 0] = 2 * dt_s
        limits = robot.tendons == "limit"
        self.lengths_m = model.tendon_range[:, 1] if limits else model.tendon_lengthspring[:, 1]
        bending = [j for j in range(model.njnt) if model.joint(j).name[0] in "xy" and model.joint(j).name[1:].isdigit()]
        self.dofs = model.jnt_dofadr[bending]
        self.piece_m = robot.length_m / robot.pieces
        self.stiffness = np.full(len(bending), robot.bending_n_m2() / self.piece_m)

    def set_pulls(self, pulls_m):
        """Lengths at which the tendons begin to pull, for displacements from home."""
        self.lengths_m[:] = self.straight_m - pulls_m - self.robot.pretension_m - self.robot.offsets_m

    def step(self, count=1):
        if not self.memory:
            mujoco.mj_step(self.model, self.data, nstep=count)
            return
        data, force, angles = self.data, self.data.qfrc_applied, self.data.qpos
        for _ in range(count):
            bent = angles[self.dofs]
            force[self.dofs] = sum(law.moments(bent, self.dt_s) for law in self.memory)
            mujoco.mj_step(self.model, data)

    def rest(self, pulls_m):
        """From straight and without history to rest at home; what is found there is the start of every trial."""
        damping = self.model.dof_damping.copy()
        self.model.dof_damping *= max(1.0, SETTLING_DAMPING_S / self.robot.damping_time_s)
        self.set_pulls(pulls_m)
        for law in self.memory:
            law.begin(self.stiffness, self.piece_m)
        self.step(int(round(SETTLE_S / self.dt_s)))
        self.model.dof_damping[:] = damping
        for law in self.memory:
            law.at_home()
        self.home = self.data.qpos.copy()

    def restart(self):
        forces = self.data.xfrc_applied.copy()
        mujoco.mj_resetData(self.model, self.data)
        self.data.xfrc_applied[:] = forces
        self.data.qpos[:] = self.home
        # Drives that act late stand at home until the first command reaches them.
        self.set_pulls(np.zeros_like(self.straight_m))
        mujoco.mj_forward(self.model, self.data)
        for law in self.memory:
            law.go_home()

    def tip_m(self):
        mujoco.mj_kinematics(self.model, self.data)
        return self.data.site_xpos[self.tip].copy()

    def trial(self, drives, rows, period_s):
        """Tips at each row; `drives(time)` are the pulls so long after the start."""
        each = int(round(period_s / self.dt_s))
        self.restart()
        tips = [self.tip_m()]
        for row in range(rows - 1):
            done = 0
            for start, until in drives.moving(row * period_s, (row + 1) * period_s):
                first, last = (int(round((t - row * period_s) / self.dt_s)) for t in (start, until))
                self.step(first - done)
                for tick in range(first, last):
                    self.set_pulls(drives(row * period_s + (tick + 1) * self.dt_s))
                    self.step()
                done = last
            self.step(each - done)
            tips.append(self.tip_m())
        if self.data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number or not np.isfinite(tips).all():
            raise FloatingPointError("the chain blew up")
        return np.array(tips)
