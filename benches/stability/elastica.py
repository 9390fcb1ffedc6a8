"""elastica.csv: rests of a clamped rod buckled by a dead axial force, on the side of a small lateral one.

Method: shooting from the free tip (DOP853, rtol 1e-12) for the tip's angle, all roots in (0, pi) bracketed by a scan; the
rest has no conjugate point (stable in the plane) and a positive second variation out of it.
Check (printed): the inextensible elastica by elliptic integrals, Timoshenko & Gere, Theory of Elastic Stability, 2.7.
"""

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from planar_rod import R0, WIRE, from_tip, write
from second_variation import least_out_of_plane, zeros_in_plane

CASES = [("r0", R0, share) for share in (1.1, 1.3, 1.5, 2.0, 3.0)] + [("wire", WIRE, share) for share in (1.3, 2.0)]


def rest(rod, force):
    """Tip angles of all equilibria on the side of +x."""
    angles = np.linspace(1e-7, np.pi - 1e-4, 200)
    ends = [from_tip(rod, angle, force)[0] for angle in angles]
    solve = lambda angle: from_tip(rod, angle, force)[0]
    return [
        brentq(solve, a, b, xtol=1e-14, rtol=1e-14)
        for a, b, u, v in zip(angles, angles[1:], ends, ends[1:])
        if u * v < 0
    ]


def inextensible(share):
    """(x / L, z / L, angle) without a lateral force."""
    k = brentq(lambda k: ellipk(k * k) - np.pi / 2 * np.sqrt(share), 1e-9, 1 - 1e-12, xtol=1e-15)
    whole = ellipk(k * k)
    return 2 * k / whole, 2 * ellipe(k * k) / whole - 1, 2 * np.arcsin(k)


def main():
    rows = []
    for name, rod, share in CASES:
        for lateral in (1e-3, 1e-5):
            force = (lateral * rod.euler_n, -share * rod.euler_n)
            (angle,) = rest(rod, force)
            _, x, z = from_tip(rod, angle, force)
            zeros, least = zeros_in_plane(rod, angle, force), least_out_of_plane(rod, angle, force)
            known = inextensible(share)[:2]
            print(
                name, share, lateral, (x / rod.length_m, z / rod.length_m), known, "ways down", zeros, least, flush=True
            )
            assert zeros == 0 and least > 0
            rows.append([name, share, lateral, *force, x, z, angle, "shooting, extensible and shearable"])
    header = "rod,axial_share,lateral_share,force_x_n,force_z_n,tip_x_m,tip_z_m,tip_angle_rad,method".split(",")
    write("elastica.csv", header, rows)


if __name__ == "__main__":
    main()
