//! Whether a rod touches itself. The solver lets it pass through: this only says so.

use super::rod::Rod;

/// Angle through which a rod must turn to touch itself, rad.
const MIN_TURN_RAD: f64 = std::f64::consts::PI;
/// Places nearer along the rod than this multiple of their radii touch only where the rod bends
/// tighter than it is thick.
const NEIGHBOURS: f64 = 4.0;

/// Two places of a rod that touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfContact {
    /// The places, metres from the base along the relaxed rod.
    pub s_m: [f64; 2],
    /// How far one surface is inside the other, metres.
    pub penetration_m: f64,
}

impl Rod {
    /// Where the surface of the rod (its contact radius, disks left out) penetrates itself deepest;
    /// `None` where it does not.
    pub fn self_contact(&self) -> Option<SelfContact> {
        let (shape, nodes) = (&self.state.shape, &self.system.grid.nodes);
        let turn = |(g, node): (usize, &crate::rod::discretisation::cell::Node)| {
            node.weight_m * shape.strain[g][0].hypot(shape.strain[g][1])
        };
        if nodes.iter().enumerate().map(turn).sum::<f64>() < MIN_TURN_RAD {
            return None;
        }
        let width_m = 2.0 * self.system.params.contact.radius_m;
        let boundaries_m = &self.system.grid.boundaries_m;
        let mut deepest: Option<SelfContact> = None;
        for (i, p) in shape.end_p.iter().enumerate() {
            for (j, q) in shape.end_p.iter().enumerate().skip(i + 1) {
                let apart_m = boundaries_m[j] - boundaries_m[i];
                let penetration_m = width_m - (p - q).norm();
                let deeper = deepest.is_none_or(|contact| penetration_m > contact.penetration_m);
                if apart_m > 0.5 * NEIGHBOURS * width_m && penetration_m > 0.0 && deeper {
                    deepest = Some(SelfContact {
                        s_m: [boundaries_m[i], boundaries_m[j]],
                        penetration_m,
                    });
                }
            }
        }
        deepest
    }
}
