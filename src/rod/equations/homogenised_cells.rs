//! Homogenised material of cells that span jumps of the properties.

use crate::rod::discretisation::cell::GAUSS;
use crate::rod::equations::material::Section;
use crate::rod::params::rod_params::RodParams;

/// The laws at the Gauss points of the cells between `boundaries_m`. Both together have the
/// compliance and the mass of the cell and their first moments, so that what is linear along a cell
/// is integrated exactly.
pub(crate) fn sections(params: &RodParams, boundaries_m: &[f64]) -> Vec<Section> {
    boundaries_m.windows(2).flat_map(|cell| sections_of_cell(params, cell[0], cell[1])).collect()
}

fn sections_of_cell(params: &RodParams, start_m: f64, end_m: f64) -> [Section; 2] {
    let (length_m, middle_m) = (end_m - start_m, 0.5 * (start_m + end_m));
    let mut ends = vec![start_m];
    let jumps = params.spans.iter().map(|span| span.end_m);
    let spine = params
        .sections
        .iter()
        .flat_map(|section| [section.start_m, section.start_m + section.length_m]);
    ends.extend(jumps.chain(spine).filter(|end| (start_m..end_m).contains(end)));
    ends.push(end_m);
    // Within a piece between two jumps the material is even.
    ends.sort_by(f64::total_cmp);
    let mut points: Vec<Point> = Vec::new();
    for piece in ends.windows(2).filter(|piece| piece[1] > piece[0]) {
        let (half_m, between_m) = (0.5 * (piece[1] - piece[0]), 0.5 * (piece[0] + piece[1]));
        for side in [-2.0 * GAUSS, 2.0 * GAUSS] {
            let position_m = between_m + side * half_m;
            // The first moment needs the place within the whole cell.
            let place = (position_m - middle_m) / length_m;
            points.push(Point {
                section: Section::new(params, position_m),
                share: half_m / length_m,
                place,
            });
        }
    }
    [-1.0, 1.0].map(|side| equivalent_section(params, &points, side))
}

/// A Gauss point of an even piece of a cell.
struct Point {
    section: Section,
    /// Its share of the cell.
    share: f64,
    /// Its distance from the middle of the cell, over the cell's length.
    place: f64,
}

/// Least share of the mean compliance or mass at either Gauss point.
const MIN_SHARE: f64 = 0.05;

/// The equivalent section at the Gauss point on one `side` of a cell.
fn equivalent_section(params: &RodParams, points: &[Point], side: f64) -> Section {
    let mean = |of: &dyn Fn(&Section) -> f64| -> f64 {
        points.iter().map(|p| p.share * of(&p.section)).sum()
    };
    let first_moment = |of: &dyn Fn(&Section) -> f64| -> f64 {
        points.iter().map(|p| p.share * p.place / GAUSS * of(&p.section)).sum()
    };
    // If most of a property lies beyond the Gauss point, that point takes the largest admissible
    // share.
    let admissible_share = |of: &dyn Fn(&Section) -> f64| {
        ((1.0 - MIN_SHARE) * mean(of) / first_moment(of).abs()).min(1.0)
    };
    let positive = |of: &dyn Fn(&Section) -> f64| {
        if mean(of) == 0.0 {
            0.0
        } else {
            mean(of) + side * admissible_share(of) * first_moment(of)
        }
    };
    let signed = |of: &dyn Fn(&Section) -> [f64; 3], share: f64| -> [f64; 3] {
        std::array::from_fn(|k| mean(&|s| of(s)[k]) + side * share * first_moment(&|s| of(s)[k]))
    };
    let share = admissible_share(&|s| s.bend[0]).min(admissible_share(&|s| s.bend[2]));
    // Where principal axes rotate within a cell, the full first moment may leave no positive
    // definite compliance.
    let bends = [share, 0.5 * share, 0.0].map(|share| signed(&|s| s.bend, share));
    let [_, _, even] = bends;
    let bend = bends.into_iter().find(|[a, b, c]| a * c > b * b).unwrap_or(even);
    let (twist, shear, axial) =
        (positive(&|s| s.twist), positive(&|s| s.shear), positive(&|s| s.axial));
    let spine = positive(&|s| s.spine);
    let bending_n_m2 = 1.0 / positive(&|s| 1.0 / s.bending_n_m2);
    let saturated = |s: &Section| if s.spine == 0.0 { 0.0 } else { s.spine * s.saturation_n };
    // Infinite where there is no spine, or one that does not saturate.
    let saturation_n = Some(positive(&saturated) / spine)
        .filter(|force| force.is_finite())
        .unwrap_or(f64::INFINITY);
    let time_s = params.damping_time_s;
    Section {
        rest: signed(&|s| s.rest, 1.0),
        home: signed(&|s| s.home, 1.0),
        bend,
        twist,
        shear,
        axial,
        spine,
        saturation_n,
        viscosity: [
            bending_n_m2,
            bending_n_m2,
            1.0 / twist,
            1.0 / shear,
            1.0 / shear,
            1.0 / (axial + spine),
        ]
        .map(|stiffness| time_s * stiffness),
        bending_n_m2,
        mass_kg_m: positive(&|s| s.mass_kg_m),
    }
}
