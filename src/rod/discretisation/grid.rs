//! The grid along the rod: cells with two Gauss–Legendre points each, and the polynomials on them.

use super::basis::Basis;
use super::cell::{COMPONENTS, GAUSS, Node};
use crate::math::polynomial::legendre;
use crate::rod::params::resolution::Resolution;
use crate::rod::params::rod_params::RodParams;
use crate::rod::params::span::Span;
use crate::rod::params::tendon::Tendon;

/// Element ends closer than this are merged, metres: a jump within so short a piece is treated as
/// smooth …
const SAME_END_M: f64 = 1e-6;
/// … but at most this share of the length.
const SAME_END_SHARE: f64 = 1e-4;
/// Cell ends closer than this are merged, metres: they differ by rounding only. Merging ends 0.8 µm
/// apart moved a tip by 15 µm (docs/evidence/design_log.md).
const SAME_PLACE_M: f64 = 1e-10;

/// The discretisation of one rod.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    /// Lengths of the integration cells, metres. No property jumps inside one unless cells are
    /// blended.
    pub(crate) cell_lengths_m: Vec<f64>,
    /// Two per cell.
    pub(crate) nodes: Vec<Node>,
    /// Ends of the cells; one more than there are cells.
    pub(crate) boundaries_m: Vec<f64>,
    /// Number of polynomials for each component.
    pub(crate) modes: [usize; COMPONENTS],
    /// Number of polynomial coefficients in all.
    pub(crate) unknowns: usize,
    /// The polynomials at all nodes at once.
    pub(crate) basis: Basis,
    /// Where the polynomials begin and end, metres.
    pub(crate) elements_m: Vec<f64>,
}

impl Grid {
    /// Divides the rod at masses and, unless cells are blended, at jumps of its properties, then to
    /// the requested resolution. The internal wrench is one polynomial per component between the
    /// points where it may jump: tendon ends, kinks of tendon paths and loads.
    pub(crate) fn new(params: &RodParams) -> Grid {
        let (elements, cuts) = (element_ends(params), cell_ends(params));
        let boundaries_m = subdivided(params, &elements, &cuts, &cuts);
        Grid::on(&params.resolution, boundaries_m, &elements)
    }

    /// The grid of a slightly different rod `changed`, where this is the grid of `params`: the same
    /// cells and polynomials, shifted. `None` when the two are not topologically equal, that is
    /// when parts were added or removed or coincident points separated.
    pub(crate) fn moved(params: &RodParams, changed: &RodParams) -> Option<Grid> {
        let (elements, cuts) = (element_ends(params), cell_ends(params));
        let moved = moved_along(&cuts, &cell_cuts(params), &cell_cuts(changed), SAME_PLACE_M)?;
        let ends = moved_along(
            &elements,
            &element_cuts(params),
            &element_cuts(changed),
            same_end_m(params),
        )?;
        let boundaries_m = subdivided(params, &elements, &cuts, &moved);
        (params.resolution == changed.resolution)
            .then(|| Grid::on(&params.resolution, boundaries_m, &ends))
    }

    /// The same polynomials on twice as many cells.
    pub(crate) fn halved(&self, resolution: &Resolution) -> Grid {
        // The polynomials stay, so that both grids differ in quadrature alone.
        let pairs = self.boundaries_m.windows(2);
        let mut boundaries_m: Vec<f64> =
            pairs.flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])]).collect();
        boundaries_m.extend(self.boundaries_m.last());
        Grid::on(resolution, boundaries_m, &self.elements_m)
    }

    /// The grid with cells between `boundaries_m` and polynomials between `elements`.
    fn on(resolution: &Resolution, boundaries_m: Vec<f64>, elements: &[f64]) -> Grid {
        let modes = [
            resolution.bending_modes,
            resolution.bending_modes,
            resolution.torsion_modes,
            resolution.shear_modes,
            resolution.shear_modes,
            resolution.axial_modes,
        ];
        let max_modes = modes.iter().copied().max().unwrap_or(0);
        let per_element: usize = modes.iter().sum();
        let mut grid = Grid {
            cell_lengths_m: Vec::new(),
            nodes: Vec::new(),
            unknowns: per_element * (elements.len() - 1),
            modes,
            boundaries_m,
            basis: Basis::new(&[], modes),
            elements_m: elements.to_vec(),
        };
        for window in grid.boundaries_m.windows(2) {
            let (start, length) = (window[0], window[1] - window[0]);
            grid.cell_lengths_m.push(length);
            let middle = start + 0.5 * length;
            // The middle lies inside an element even where ends were merged.
            let element =
                elements.iter().rposition(|&end| end < middle).unwrap_or(0).min(elements.len() - 2);
            let (low, high) = (elements[element], elements[element + 1]);
            for sign in [-1.0, 1.0] {
                let position_m = middle + sign * GAUSS * length;
                let mut basis = vec![0.0; max_modes];
                // Map the element to [−1, 1], where Legendre polynomials are orthogonal.
                legendre(2.0 * (position_m - low) / (high - low) - 1.0, &mut basis);
                let mut offset = [0; COMPONENTS];
                let mut next = element * per_element;
                for (slot, count) in offset.iter_mut().zip(modes) {
                    *slot = next;
                    next += count;
                }
                grid.nodes.push(Node { position_m, weight_m: 0.5 * length, offset, basis });
            }
        }
        grid.basis = Basis::new(&grid.nodes, modes);
        grid
    }

    /// The cell end nearest to `position_m`.
    pub(crate) fn nearest_end(&self, position_m: f64) -> usize {
        let distance = |k: &usize| (self.boundaries_m[*k] - position_m).abs();
        (0..self.boundaries_m.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }

    /// ∫ from the start of a cell to its Gauss point `row` of the line through the values at both
    /// Gauss points: the coefficients of the two-stage Gauss method.
    pub(crate) fn partial_weights(length_m: f64) -> [[f64; 2]; 2] {
        let quarter = 0.25 * length_m;
        let skewed = GAUSS * length_m;
        // Butcher's coefficients a = [[1/4, 1/4 − √3/6], [1/4 + √3/6, 1/4]] times the cell.
        [[quarter, quarter - skewed], [quarter + skewed, quarter]]
    }
}

/// Base, tip, ends and kinks of tendons, and loads, in a fixed order; also the jumps of the
/// material when the resolution splits elements there.
fn element_cuts(params: &RodParams) -> Vec<f64> {
    let mut cuts = vec![0.0, params.length_m()];
    cuts.extend(params.tendons.iter().flat_map(Tendon::borders_m));
    cuts.extend(params.point_loads.iter().map(|load| load.position_m));
    cuts.extend(params.line_loads.iter().flat_map(|load| [load.start_m, load.end_m]));
    if params.resolution.split_elements {
        cuts.extend(material_jumps(params));
    }
    cuts
}

/// Distance below which element ends are merged, metres.
fn same_end_m(params: &RodParams) -> f64 {
    SAME_END_M.min(SAME_END_SHARE * params.length_m())
}

/// Ends of the elements, metres: base, tip and the points where the internal wrench may jump.
pub(crate) fn element_ends(params: &RodParams) -> Vec<f64> {
    sorted_unique(element_cuts(params), params.length_m(), same_end_m(params))
}

/// Where stiffness, rest shape or spine change, and the lumped masses.
fn material_jumps(params: &RodParams) -> Vec<f64> {
    let alike = |a: &Span, b: &Span| {
        Span {
            end_m: a.end_m,
            mass_kg_m: a.mass_kg_m,
            spread_mass_kg_m: a.spread_mass_kg_m,
            ..b.clone()
        } == *a
    };
    let jumps = params.spans.windows(2).filter(|pair| !alike(&pair[0], &pair[1]));
    let mut places: Vec<f64> = jumps.map(|pair| pair[0].end_m).collect();
    places.extend(params.masses.iter().map(|mass| mass.position_m));
    places.extend(
        params
            .sections
            .iter()
            .flat_map(|section| [section.start_m, section.start_m + section.length_m]),
    );
    places
}

/// Element ends, masses and, unless cells are blended, all jumps of properties, in a fixed order.
fn cell_cuts(params: &RodParams) -> Vec<f64> {
    let mut cuts = element_cuts(params);
    if !params.resolution.blended {
        cuts.extend(params.spans.iter().map(|span| span.end_m));
    }
    cuts.extend(params.masses.iter().map(|mass| mass.position_m));
    for section in params.sections.iter().filter(|_| !params.resolution.blended) {
        cuts.extend([section.start_m, section.start_m + section.length_m]);
    }
    cuts
}

/// Required cell ends, metres.
fn cell_ends(params: &RodParams) -> Vec<f64> {
    sorted_unique(cell_cuts(params), params.length_m(), SAME_PLACE_M)
}

/// Ends of all cells: `places`, and between two of them as many cells as the resolution asks for
/// between the same two of `cuts`.
fn subdivided(params: &RodParams, elements: &[f64], cuts: &[f64], places: &[f64]) -> Vec<f64> {
    let resolution = &params.resolution;
    let mut ends = vec![0.0];
    for (window, place) in cuts.windows(2).zip(places.windows(2)) {
        let length = window[1] - window[0];
        let element =
            elements.windows(2).find(|element| window[0] < element[1] - 0.5 * SAME_PLACE_M);
        let share = element.map_or(1.0, |element| length / (element[1] - element[0]));
        // With too few Gauss points the polynomials of an element would be linearly dependent.
        let min_count = (share * resolution.min_cells() as f64 - 1e-9).ceil();
        // Rounding must not add a cell.
        let count = (length / resolution.cell_m - 1e-9).ceil().max(min_count).max(1.0) as usize;
        ends.extend(
            (1..=count).map(|k| place[0] + (place[1] - place[0]) * k as f64 / count as f64),
        );
    }
    ends
}

/// The shifted `places` when the cuts at each of them (within `same_m`) move from `from` to `to`.
/// `None` when coincident cuts separate or the counts differ.
fn moved_along(places: &[f64], from: &[f64], to: &[f64], same_m: f64) -> Option<Vec<f64>> {
    if from.len() != to.len() {
        return None;
    }
    let moved = places.iter().map(|&place| {
        let cuts_here =
            from.iter().zip(to).filter(|&(&cut, _)| (place..place + same_m).contains(&cut));
        let shifts: Vec<f64> = cuts_here.map(|(cut, target)| target - cut).collect();
        let first = *shifts.first()?;
        // Parts at one place must move as one, else a new cell would appear between them.
        let together =
            shifts.iter().all(|shift| (shift - first).abs() <= 1e-4 * first.abs() + 1e-14);
        together.then_some(place + first)
    });
    let moved: Vec<f64> = moved.collect::<Option<_>>()?;
    // A part that overtakes another changes the topology.
    moved.is_sorted_by(|a, b| a < b).then_some(moved)
}

/// Sorts the values, removes those outside [0, length] and merges those closer than `same_m`.
fn sorted_unique(mut values: Vec<f64>, length_m: f64, same_m: f64) -> Vec<f64> {
    values.retain(|&value| (0.0..=length_m + same_m).contains(&value));
    values.sort_by(f64::total_cmp);
    values.dedup_by(|b, a| *b - *a < same_m);
    values
}
