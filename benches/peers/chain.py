"""MuJoCo: the robot as a chain of rigid bodies with hinges between them.

usage: chain.py CASE.json RUNS.json
The case comes from the benchmark: robot, drive, sample times, and settings [segments, time step, spatial tendons?].
The runs go back to it: settings, processor times, tips. docs/evidence/peers.md says why the model is built like this.
"""

import json
import sys
import time

import mujoco
import numpy as np

# Time to come to rest before the drive starts, with every damping time at this value, s.
SETTLE_S = 10.0
SETTLING_DAMPING_S = 0.3
LEAST_RUNS = 3
ENOUGH_S = 0.6
LONG_S = 1.0
# Stiffness and damping of a rigid tendon's limit in units of the time step: it holds at the end of every step.
STIFFNESS, DAMPING, IMPEDANCE = 1e4, 1e2, 0.9


def lump(case, start, end, value):
    """Integral of value(s) over [start, end], weighted by 1, s and s², where value is constant between cuts."""
    cuts = sorted({start, end, *(c for c in case["cuts_m"] if start < c < end)})
    sums = np.zeros(3)
    for a, b in zip(cuts, cuts[1:]):
        x = value(0.5 * (a + b))
        sums += [x * (b - a), x * (b**2 - a**2) / 2, x * (b**3 - a**3) / 3]
    return sums


def at(pieces, key):
    """The value of `key` at a distance along the robot."""

    def value(s):
        return next((p[key] for p in pieces if p["start_m"] <= s < p["end_m"]), 0.0)

    return value


def body(case, k, h, last):
    """Inertia of the rigid body between hinge k and the next one (or the tip)."""
    start, end = (k + 0.5) * h, case["length_m"] if last else (k + 1.5) * h
    mass, first, second = lump(case, start, end, at(case["spans"], "mass_kg_m"))
    centre = first / mass
    side = max(second - mass * centre**2, 1e-12)
    twist = min(mass * case["radius_m"] ** 2 / 2, 1.9 * side)
    return mass, centre - start, side, twist


def joints(case, k, h):
    """Hinges (and a slide where the spine is compressible) that stand for the piece k of the rod."""
    start, end = k * h, (k + 1) * h
    damping = case["damping_time_s"]
    bend = 1 / lump(case, start, end, lambda s: 1 / at(case["spans"], "bending_n_m2")(s))[0]
    twist = 1 / lump(case, start, end, lambda s: 1 / at(case["spans"], "torsion_n_m2")(s))[0]
    soft = lump(case, start, end, at(case["sections"], "compliance_per_n"))[0]
    out = []
    if soft > 0:
        hard = lump(case, start, end, lambda s: 1 / at(case["spans"], "axial_n")(s))[0]
        stiff = 1 / (soft + hard)
        most = soft * case["sections"][0]["saturation_n"]
        out.append(
            f'<joint name="z{k}" type="slide" axis="0 0 1" stiffness="{stiff}" damping="{damping * stiff}"'
            f' limited="true" range="{-most} {10 * most}"/>'
        )
    for name, axis, stiff in (("x", "1 0 0", bend), ("y", "0 1 0", bend), ("t", "0 0 1", twist)):
        out.append(f'<joint name="{name}{k}" type="hinge" axis="{axis}" stiffness="{stiff}" damping="{damping * stiff}"/>')
    return "".join(out), soft > 0


def model_xml(case, n, dt, spatial):
    """Bodies between hinges at the middles of n equal pieces: second order in the length of a piece."""
    h = case["length_m"] / n
    offsets = case["offsets_m"]
    chain, closing, slides = "", "", []
    for k in range(n):
        mass, centre, side, twist = body(case, k, h, k == n - 1)
        inner, slide = joints(case, k, h)
        slides.append(slide)
        sites = ""
        if spatial:
            ends = (0.25 * h,) if k == n - 1 else (0.25 * h, 0.75 * h)
            for place, z in enumerate(ends):
                sites += "".join(f'<site name="s{i}_{k}_{place}" pos="{x} {y} {z}"/>' for i, (x, y) in enumerate(offsets))
            if k == n - 1:
                sites += "".join(f'<site name="s{i}_{k}_1" pos="{x} {y} {0.5 * h}"/>' for i, (x, y) in enumerate(offsets))
        if k == n - 1:
            sites += f'<site name="tip" pos="0 0 {0.5 * h}"/>'
        chain += (
            f'<body pos="0 0 {0.5 * h if k == 0 else h}">{inner}'
            f'<inertial pos="0 0 {centre}" mass="{mass}" diaginertia="{side} {side} {twist}"/>{sites}'
        )
        closing += "</body>"
    base = ""
    if spatial:
        for place, z in enumerate((0.0, 0.25 * h)):
            base += "".join(f'<site name="b{i}_{place}" pos="{x} {y} {z}"/>' for i, (x, y) in enumerate(offsets))
    tendons = ""
    soft = case["compliance_m_per_n"]
    for i, (x, y) in enumerate(offsets):
        # An elastic tendon is a spring that does nothing while slack, a rigid one a limit of its length.
        kind = f'stiffness="{1 / soft}" springlength="-9 9"' if soft else 'limited="true" range="-9 9"'
        tag = f'name="tendon{i}" {kind.replace("-9", "0") if spatial else kind}'
        if spatial:
            path = "".join(f'<site site="b{i}_{place}"/>' for place in (0, 1))
            path += "".join(f'<site site="s{i}_{k}_{place}"/>' for k in range(n) for place in (0, 1))
            tendons += f"<spatial {tag}>{path}</spatial>"
        else:
            # Length of a path parallel to the backbone: stretch plus curvature times offset.
            path = "".join(f'<joint joint="x{k}" coef="{y}"/><joint joint="y{k}" coef="{-x}"/>' for k in range(n))
            path += "".join(f'<joint joint="z{k}" coef="1"/>' for k in range(n) if slides[k])
            tendons += f"<fixed {tag}>{path}</fixed>"
    g = " ".join(map(str, case["gravity_m_s2"]))
    # The inertia-box fluid model, quadratic in each body axis: this density gives the wanted lateral drag a length.
    density = case["drag_n_s2_m3"] / np.sqrt(0.75 * case["radius_m"] ** 2) if case["drag_n_s2_m3"] else 0.0
    return (
        f'<mujoco><compiler angle="radian" boundmass="0" balanceinertia="true"/>'
        f'<option timestep="{dt}" integrator="{integrator(case)}" solver="PGS" gravity="{g}" density="{density}"/>'
        f'<size memory="16M"/><worldbody>{base}{chain}{closing}</worldbody><tendon>{tendons}</tendon></mujoco>'
    )


def integrator(case):
    """The best one for each robot, of all that were tried: `discrete` solves limits and damping together and stands
    steps of 25 ms; with springs alone `Euler` (damping implicit) is as stable, cheaper and damps less of its own."""
    return "Euler" if case["compliance_m_per_n"] else "discrete"


class Chain:
    def __init__(self, case, n, dt, spatial):
        self.case, self.dt = case, dt
        self.model = mujoco.MjModel.from_xml_string(model_xml(case, n, dt, spatial))
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)
        # A fixed tendon has length 0 when the robot is straight, a spatial one the robot's length.
        self.straight = self.data.ten_length.copy()
        self.tip = self.model.site("tip").id
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_REFSAFE
        self.model.tendon_solimp_lim[:, :2] = IMPEDANCE
        self.model.tendon_solref_lim[:] = [-STIFFNESS / dt**2, -DAMPING / dt]
        # What the drive sets: the most that a tendon may be long, or is long before it is stretched.
        elastic = case["compliance_m_per_n"] > 0
        self.lengths = (self.model.tendon_lengthspring if elastic else self.model.tendon_range)[:, 1]
        self.times = np.array(case["times_s"])
        self.pulls = np.array(case["values"]) + case["pretension_m"]

    def limits(self, times):
        pulls = np.stack([np.interp(times, self.times, column) for column in self.pulls.T], axis=1)
        return self.straight - pulls

    def rest(self):
        """Home: tendons as at the start, until nothing moves; more damping changes the way there, not the end."""
        damping = self.model.dof_damping.copy()
        self.model.dof_damping *= max(1.0, SETTLING_DAMPING_S / self.case["damping_time_s"])
        self.lengths[:] = self.limits(np.array([0.0]))[0]
        mujoco.mj_step(self.model, self.data, nstep=int(round(SETTLE_S / self.dt)))
        self.model.dof_damping[:] = damping

    def tip_m(self):
        return self.data.site_xpos[self.tip].tolist()

    def run(self):
        """Tips at the samples. The limits move with the lead screws, every time step."""
        model, data, each = self.model, self.data, int(round(self.case["sample_s"] / self.dt))
        samples = self.case["samples"]
        limits = self.limits(self.dt * np.arange(1, each * (samples - 1) + 1))
        tips = [self.tip_m()]
        step = 0
        for _ in range(samples - 1):
            for _ in range(each):
                self.lengths[:] = limits[step]
                mujoco.mj_step(model, data)
                step += 1
            mujoco.mj_kinematics(model, data)
            tips.append(self.tip_m())
        return tips


def timed(case, n, dt, spatial):
    chain = Chain(case, n, dt, spatial)
    chain.rest()
    home = chain.data.qpos.copy()
    spent, tips = [], []
    while len(spent) < LEAST_RUNS or sum(spent) < ENOUGH_S:
        mujoco.mj_resetData(chain.model, chain.data)
        chain.data.qpos[:] = home
        mujoco.mj_forward(chain.model, chain.data)
        began = time.thread_time()
        tips = chain.run()
        spent.append(time.thread_time() - began)
        if spent[-1] > LONG_S:
            break
    # A chain that blows up is put back to its start with a warning.
    ok = bool(np.isfinite(tips).all()) and chain.data.warning.number[mujoco.mjtWarning.mjWARN_BADQACC] == 0
    return {
        "peer": "mujoco",
        "setting": f"{'spatial' if spatial else 'fixed'} tendons, {integrator(case)}",
        "segments": n,
        "dt_s": dt,
        "cpu_s": min(spent),
        "simulated_s": case["sample_s"] * (case["samples"] - 1),
        "tips_m": tips,
        "status": "ok" if ok else "unstable",
    }


def main(case_file, runs_file):
    with open(case_file) as file:
        case = json.load(file)
    runs = [timed(case, n, dt, spatial) for n, dt, spatial in case["settings"]]
    with open(runs_file, "w") as file:
        json.dump({"versions": {"mujoco": mujoco.__version__, "numpy": np.__version__}, "runs": runs}, file)


if __name__ == "__main__":
    main(*sys.argv[1:3])
