"""soromox: a rod of pieces of constant strain under tensions that are held for a while, compiled as a whole by JAX.

The pieces bend and twist; stretch and shear, which move the tip by less than 0.1 mm here, would make the equations stiff for its
explicit integrators.
"""

import jax

jax.config.update("jax_enable_x64", True)

import diffrax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
import worker  # noqa: E402
from soromox.actuation import ThreadlikeActuator, ThreadlikeRouting  # noqa: E402
from soromox.systems import PCS  # noqa: E402
from soromox.systems.components.links import LinkSpec  # noqa: E402
from soromox.systems.pcs.structures import PCSStructure  # noqa: E402
from soromox.systems.system_state import SystemState  # noqa: E402

# Local x along the world's z, local y along x, local z along y.
BASE_POSE = [0.0, 0.0, 0.0, 0.5, -0.5, -0.5, -0.5]
NEWTON_STEPS, LOAD_STEPS = 12, 4


def robot(case, segments):
    span, length = case["spans"][0], case["length_m"] / segments
    area = np.pi * case["radius_m"] ** 2
    links = []
    for k in range(segments):
        overlaps = [
            max(0.0, min((k + 1) * length, piece["end_m"]) - max(k * length, piece["start_m"])) * piece["mass_kg_m"]
            for piece in case["spans"]
        ]
        links.append(
            LinkSpec.circular(
                length=length, density=sum(overlaps) / (area * length), radius=case["radius_m"],
                young_modulus=span["axial_n"] / area, shear_modulus=span["shear_n"] / area,
                reference_strain=[0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            )
        )  # fmt: skip
    offsets = jnp.array([[0.0, x, y] for x, y in case["offsets_m"]])
    routing = ThreadlikeRouting.linear(intercept=offsets, end_segment_index=segments - 1)
    bending = jnp.array([True, True, True, False, False, False] * segments)
    return PCS.from_links(
        links, structure=PCSStructure(strain_selector=bending), gravity=jnp.array(case["gravity_m_s2"]),
        base_pose=jnp.array(BASE_POSE), actuators=ThreadlikeActuator.tendons(routing), backend="jax",
    )  # fmt: skip


class Rod:
    def __init__(self, case, segments, step_s, row_s, rows):
        self.rod = robot(case, segments)
        self.size = self.rod.num_internal_dofs
        length = jnp.array(case["length_m"])
        self.tip = jax.jit(lambda q: self.rod.forward_kinematics(q, length)[:3, 3])

        def accelerations(q, tensions):
            state = SystemState(t=jnp.array(0.0), y=jnp.concatenate([q, jnp.zeros(self.size)]), u=tensions)
            return self.rod.forward_dynamics(state.t, state.y, (tensions, None))[self.size :]

        slope = jax.jacfwd(accelerations)

        def rest(tensions):
            def newton(_, q):
                return q - jnp.linalg.solve(slope(q, tensions), accelerations(q, tensions))

            return jax.lax.fori_loop(0, NEWTON_STEPS, newton, jnp.zeros(self.size))

        self.rest = jax.jit(rest)
        term = diffrax.ODETerm(lambda t, y, tensions: self.rod.forward_dynamics(t, y, (tensions, None)))
        steps = round(row_s / step_s)
        solver = diffrax.Tsit5()

        def row(y, tensions):
            found = diffrax.diffeqsolve(
                term, solver, 0.0, row_s, row_s / steps, y, tensions, saveat=diffrax.SaveAt(t1=True),
                stepsize_controller=diffrax.ConstantStepSize(), max_steps=steps + 2, adjoint=diffrax.DirectAdjoint(),
            )  # fmt: skip
            return found.ys[0], found.ys[0][: self.size]

        self.march = jax.jit(lambda y, tensions: jax.lax.scan(row, y, tensions)[1])


MADE = {}


def tensions(values, row_s, setting):
    segments, step_s = setting
    values = jnp.array(values)
    key = (segments, step_s)
    if key not in MADE:
        MADE[key] = Rod(worker.case("paper_tension"), segments, step_s, row_s, len(values))
        start = MADE[key].rest(values[0])
        MADE[key].march(jnp.concatenate([start, jnp.zeros_like(start)]), values[:-1])  # compiles
    rod = MADE[key]
    start = rod.rest(values[0])
    y = jnp.concatenate([start, jnp.zeros_like(start)])
    places, times = worker.timed(lambda: rod.march(y, values[:-1]).block_until_ready())
    places = jnp.concatenate([start[None], places])[:: round(0.05 / row_s)]
    tips = np.array([rod.tip(q) for q in places])
    if not np.isfinite(tips).all():
        raise ArithmeticError("unstable")
    return {**times, "simulated_s": row_s * (len(values) - 1), "tips_m": tips.tolist()}


if __name__ == "__main__":
    worker.serve({"tensions": tensions}, ["soromox", "jax", "numpy"])
