//! Where along the rod things are computed: cells with two Gauss–Legendre points each, and the polynomials on them.

use super::basis::Basis;
use super::cell::{COMPONENTS, Cell, GAUSS, Node};
use crate::math::polynomial::legendre;
use crate::rod::params::resolution::Resolution;
use crate::rod::params::rod_params::RodParams;
use crate::rod::params::span::Span;
use crate::rod::params::tendon::Tendon;

/// Ends of polynomials that are closer are one, metres: what jumps in so short a piece is as good as smooth.
const SAME_END_M: f64 = 1e-6;
/// … if that is no more than this share of the rod.
const SAME_END_SHARE: f64 = 1e-4;
/// Ends of cells that are closer are one, metres. A tendon that ends elsewhere has another length, so that this is rounding.
const SAME_PLACE_M: f64 = 1e-10;

/// The discretisation of one rod.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    pub(crate) cells: Vec<Cell>,
    /// Two per cell.
    pub(crate) nodes: Vec<Node>,
    /// Ends of the cells; one more than there are cells.
    pub(crate) boundaries_m: Vec<f64>,
    /// Number of polynomials for each component.
    pub(crate) modes: [usize; COMPONENTS],
    /// Number of polynomial coefficients in all.
    pub(crate) unknowns: usize,
    /// The polynomials at all nodes at once.
    pub(crate) all: Basis,
    /// Where the polynomials begin and end, metres.
    pub(crate) elements_m: Vec<f64>,
}

impl Grid {
    /// Cuts the rod at masses and, unless cells go across them, at jumps of its properties, and then to the wanted resolution. The internal
    /// wrench is one polynomial a component between the places where it may jump: tendon ends, kinks of their paths
    /// and loads.
    pub(crate) fn new(params: &RodParams) -> Grid {
        let (elements, cuts) = (element_ends(params), cell_ends(params));
        let boundaries_m = subdivided(params, &elements, &cuts, &cuts);
        Grid::on(&params.resolution, boundaries_m, &elements)
    }

    /// The discretisation of a rod that differs a little from `params`, the one that this grid is made for: the same
    /// cells and polynomials, moved along. `None` where there is none: parts came or went, or what had one place no
    /// longer has.
    pub(crate) fn moved(params: &RodParams, changed: &RodParams) -> Option<Grid> {
        let (elements, cuts) = (element_ends(params), cell_ends(params));
        let moved = moved_along(&cuts, &cell_cuts(params), &cell_cuts(changed), SAME_PLACE_M)?;
        let ends = moved_along(&elements, &element_cuts(params), &element_cuts(changed), same_end_m(params))?;
        let boundaries_m = subdivided(params, &elements, &cuts, &moved);
        (params.resolution == changed.resolution).then(|| Grid::on(&params.resolution, boundaries_m, &ends))
    }

    /// The same polynomials on twice as many cells.
    pub(crate) fn halved(&self, resolution: &Resolution) -> Grid {
        let pairs = self.boundaries_m.windows(2);
        let mut boundaries_m: Vec<f64> = pairs.flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])]).collect();
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
        let most = modes.iter().copied().max().unwrap_or(0);
        let per_element: usize = modes.iter().sum();
        let mut grid = Grid {
            cells: Vec::new(),
            nodes: Vec::new(),
            unknowns: per_element * (elements.len() - 1),
            modes,
            boundaries_m,
            all: Basis::new(&[], modes),
            elements_m: elements.to_vec(),
        };
        for window in grid.boundaries_m.windows(2) {
            let (start, length) = (window[0], window[1] - window[0]);
            grid.cells.push(Cell { length_m: length });
            let middle = start + 0.5 * length;
            let element = elements.iter().rposition(|&end| end < middle).unwrap_or(0).min(elements.len() - 2);
            let (low, high) = (elements[element], elements[element + 1]);
            for sign in [-1.0, 1.0] {
                let position_m = middle + sign * GAUSS * length;
                let mut basis = vec![0.0; most];
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
        grid.all = Basis::new(&grid.nodes, modes);
        grid
    }

    /// The cell end nearest to `position_m`.
    pub(crate) fn nearest_end(&self, position_m: f64) -> usize {
        let distance = |k: &usize| (self.boundaries_m[*k] - position_m).abs();
        (0..self.boundaries_m.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }

    /// ∫ from the start of a cell to its Gauss point `row` of the line through the values at both Gauss points: the
    /// coefficients of the two-stage Gauss method.
    pub(crate) fn partial_weights(length_m: f64) -> [[f64; 2]; 2] {
        let quarter = 0.25 * length_m;
        let skewed = GAUSS * length_m;
        [[quarter, quarter - skewed], [quarter + skewed, quarter]]
    }
}

/// Base, tip, ends and kinks of tendons, loads, in a fixed order; the jumps of the material as well if the resolution says
/// so.
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

/// Ends of polynomials that are closer are one, metres.
fn same_end_m(params: &RodParams) -> f64 {
    SAME_END_M.min(SAME_END_SHARE * params.length_m())
}

/// Base, tip and where the internal wrench may jump.
pub(crate) fn element_ends(params: &RodParams) -> Vec<f64> {
    sorted_unique(element_cuts(params), params.length_m(), same_end_m(params))
}

/// Where stiffness, rest shape or spine change, and the lumped masses.
fn material_jumps(params: &RodParams) -> Vec<f64> {
    let alike = |a: &Span, b: &Span| {
        Span { end_m: a.end_m, mass_kg_m: a.mass_kg_m, spread_mass_kg_m: a.spread_mass_kg_m, ..b.clone() } == *a
    };
    let jumps = params.spans.windows(2).filter(|pair| !alike(&pair[0], &pair[1]));
    let mut places: Vec<f64> = jumps.map(|pair| pair[0].end_m).collect();
    places.extend(params.masses.iter().map(|mass| mass.position_m));
    places.extend(params.sections.iter().flat_map(|section| [section.start_m, section.start_m + section.length_m]));
    places
}

/// Wherever a property jumps, unless cells go across that, or a mass sits, in a fixed order.
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

/// Where cells have to end.
fn cell_ends(params: &RodParams) -> Vec<f64> {
    sorted_unique(cell_cuts(params), params.length_m(), SAME_PLACE_M)
}

/// Ends of all cells: `places`, and between two of them as many as the resolution asks for between the same two of
/// `cuts`.
fn subdivided(params: &RodParams, elements: &[f64], cuts: &[f64], places: &[f64]) -> Vec<f64> {
    let resolution = &params.resolution;
    let mut ends = vec![0.0];
    for (window, place) in cuts.windows(2).zip(places.windows(2)) {
        let length = window[1] - window[0];
        let element = elements.windows(2).find(|element| window[0] < element[1] - 0.5 * SAME_PLACE_M);
        let share = element.map_or(1.0, |element| length / (element[1] - element[0]));
        // Too few Gauss points could not tell the polynomials of an element apart.
        let least = (share * resolution.least_cells() as f64 - 1e-9).ceil();
        let count = (length / resolution.cell_m - 1e-9).ceil().max(least).max(1.0) as usize;
        ends.extend((1..=count).map(|k| place[0] + (place[1] - place[0]) * k as f64 / count as f64));
    }
    ends
}

/// Where each of `places` goes when the cuts that stand there (within `same_m`) go from `from` to `to`; `None` when
/// they part, or when there are not as many.
fn moved_along(places: &[f64], from: &[f64], to: &[f64], same_m: f64) -> Option<Vec<f64>> {
    if from.len() != to.len() {
        return None;
    }
    let moved = places.iter().map(|&place| {
        let here = from.iter().zip(to).filter(|&(&cut, _)| (place..place + same_m).contains(&cut));
        let shifts: Vec<f64> = here.map(|(cut, then)| then - cut).collect();
        let first = *shifts.first()?;
        let together = shifts.iter().all(|shift| (shift - first).abs() <= 1e-4 * first.abs() + 1e-14);
        together.then_some(place + first)
    });
    let moved: Vec<f64> = moved.collect::<Option<_>>()?;
    moved.is_sorted_by(|a, b| a < b).then_some(moved)
}

/// Sorts, drops what lies outside [0, length] and merges what lies closer than `same_m`.
fn sorted_unique(mut values: Vec<f64>, length_m: f64, same_m: f64) -> Vec<f64> {
    values.retain(|&value| (0.0..=length_m + same_m).contains(&value));
    values.sort_by(f64::total_cmp);
    values.dedup_by(|b, a| *b - *a < same_m);
    values
}
