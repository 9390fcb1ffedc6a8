//! Where along the rod things are computed: cells with two Gauss–Legendre points each, and the polynomials on them.

use super::basis::Basis;
use super::params::RodParams;
use super::span::Span;
use super::tendon::Tendon;
use crate::math::polynomial::legendre;

/// Half the distance between the two Gauss points, as a share of the cell: √3/6.
pub(super) const GAUSS: f64 = 0.288_675_134_594_812_9;

/// Internal wrench components in the body frame: moments about x, y, z, then forces along x, y, z.
pub(super) const COMPONENTS: usize = 6;

/// A piece of the rod without a jump inside.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// Length, metres.
    pub(super) length_m: f64,
}

/// A Gauss point.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// Distance from the base, metres.
    pub(super) position_m: f64,
    /// Quadrature weight, metres.
    pub(super) weight_m: f64,
    /// Index of the first unknown of each component in the element that holds this node.
    pub(super) offset: [usize; COMPONENTS],
    /// Values of the Legendre polynomials of the element here.
    pub(super) basis: Vec<f64>,
}

/// The discretisation of one rod.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    pub(super) cells: Vec<Cell>,
    /// Two per cell.
    pub(super) nodes: Vec<Node>,
    /// Ends of the cells; one more than there are cells.
    pub(super) boundaries_m: Vec<f64>,
    /// Number of polynomials for each component.
    pub(super) modes: [usize; COMPONENTS],
    /// Number of polynomial coefficients in all.
    pub(super) unknowns: usize,
    /// The polynomials at all nodes at once.
    pub(super) all: Basis,
    /// Where the polynomials begin and end, metres.
    pub(super) elements_m: Vec<f64>,
}

impl Grid {
    /// Cuts the rod at every jump of its properties and at masses, and then to the wanted resolution. The internal
    /// wrench is one polynomial a component between the places where it may jump: tendon ends, kinks of their paths
    /// and loads.
    pub(super) fn new(params: &RodParams) -> Grid {
        let elements = element_ends(params);
        let resolution = &params.resolution;
        let modes = [
            resolution.bending_modes,
            resolution.bending_modes,
            resolution.torsion_modes,
            resolution.shear_modes,
            resolution.shear_modes,
            resolution.axial_modes,
        ];
        let most = modes.iter().copied().max().unwrap_or(0);
        let boundaries_m = cell_ends(params);
        let per_element: usize = modes.iter().sum();
        let mut grid = Grid {
            cells: Vec::new(),
            nodes: Vec::new(),
            unknowns: per_element * (elements.len() - 1),
            modes,
            boundaries_m,
            all: Basis::new(&[], modes),
            elements_m: elements.clone(),
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
    pub(super) fn nearest_end(&self, position_m: f64) -> usize {
        let distance = |k: &usize| (self.boundaries_m[*k] - position_m).abs();
        (0..self.boundaries_m.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }

    /// ∫ from the start of a cell to its Gauss point `row` of the line through the values at both Gauss points: the
    /// coefficients of the two-stage Gauss method.
    pub(super) fn partial_weights(length_m: f64) -> [[f64; 2]; 2] {
        let quarter = 0.25 * length_m;
        let skewed = GAUSS * length_m;
        [[quarter, quarter - skewed], [quarter + skewed, quarter]]
    }
}

/// Base, ends and kinks of tendons, loads, tip; the jumps of the material as well if the resolution says so.
pub(super) fn element_ends(params: &RodParams) -> Vec<f64> {
    let mut ends = vec![0.0, params.length_m()];
    ends.extend(params.tendons.iter().flat_map(Tendon::borders_m));
    ends.extend(params.point_loads.iter().map(|load| load.position_m));
    ends.extend(params.line_loads.iter().flat_map(|load| [load.start_m, load.end_m]));
    if params.resolution.split_elements {
        ends.extend(material_jumps(params));
    }
    sorted_unique(ends, params.length_m())
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

/// Ends of all cells: wherever a property jumps, subdivided to the wanted resolution.
fn cell_ends(params: &RodParams) -> Vec<f64> {
    let elements = element_ends(params);
    let mut cuts = elements.clone();
    cuts.extend(params.spans.iter().map(|span| span.end_m));
    cuts.extend(params.masses.iter().map(|mass| mass.position_m));
    for section in &params.sections {
        cuts.extend([section.start_m, section.start_m + section.length_m]);
    }
    let cuts = sorted_unique(cuts, params.length_m());
    let mut ends = vec![0.0];
    for window in cuts.windows(2) {
        let length = window[1] - window[0];
        let element = elements.windows(2).find(|element| window[0] < element[1] - 5e-7);
        let share = element.map_or(1.0, |element| length / (element[1] - element[0]));
        // Too few Gauss points could not tell the polynomials of an element apart.
        let least = (share * params.resolution.least_cells() as f64 - 1e-9).ceil();
        let count = (length / params.resolution.cell_m - 1e-9).ceil().max(least).max(1.0) as usize;
        ends.extend((1..=count).map(|k| window[0] + length * k as f64 / count as f64));
    }
    ends
}

/// Sorts, drops what lies outside [0, length] and merges what lies closer than a micrometre.
fn sorted_unique(mut values: Vec<f64>, length_m: f64) -> Vec<f64> {
    values.retain(|&value| (0.0..=length_m + 1e-6).contains(&value));
    values.sort_by(f64::total_cmp);
    values.dedup_by(|b, a| *b - *a < 1e-6);
    values
}
