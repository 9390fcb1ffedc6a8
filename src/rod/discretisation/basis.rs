//! The polynomials of the internal wrench at all Gauss points at once: fields are six rows of
//! numbers, one a wrench component, over the Gauss points, so that inner loops run over contiguous
//! memory.

use std::ops::Range;

use super::cell::{COMPONENTS, Node};

/// Values of the polynomials at the Gauss points.
#[derive(Clone, Debug)]
pub(crate) struct Basis {
    elements: Vec<PolynomialElement>,
    modes: [usize; COMPONENTS],
    /// Number of Gauss points.
    pub(crate) points: usize,
    /// Row j: the j-th polynomial of the element that holds each Gauss point.
    rows: Vec<f64>,
}

/// A part of the rod with its own polynomials.
#[derive(Clone, Debug)]
struct PolynomialElement {
    /// Its Gauss points.
    points: Range<usize>,
    /// Its first coefficient of each component.
    offset: [usize; COMPONENTS],
}

impl Basis {
    pub(crate) fn new(nodes: &[Node], modes: [usize; COMPONENTS]) -> Basis {
        let points = nodes.len();
        let max_modes = modes.iter().copied().max().unwrap_or(0);
        let mut rows = vec![0.0; max_modes * points];
        let mut elements: Vec<PolynomialElement> = Vec::new();
        for (g, node) in nodes.iter().enumerate() {
            (0..max_modes).for_each(|j| rows[j * points + g] = node.basis[j]);
            // Gauss points are ordered, so that those of one element are contiguous.
            match elements.last_mut().filter(|element| element.offset == node.offset) {
                Some(element) => element.points.end = g + 1,
                None => elements.push(PolynomialElement { points: g..g + 1, offset: node.offset }),
            }
        }
        Basis { elements, modes, points, rows }
    }

    /// The field with these polynomial coefficients.
    #[inline(always)]
    pub(crate) fn expand(&self, coefficients: &[f64], field: &mut [f64]) {
        field.fill(0.0);
        for element in &self.elements {
            for c in 0..COMPONENTS {
                let values = &mut field[c * self.points..][element.points.clone()];
                for j in 0..self.modes[c] {
                    let factor = coefficients[element.offset[c] + j];
                    let row = &self.rows[j * self.points..][element.points.clone()];
                    values.iter_mut().zip(row).for_each(|(value, basis)| *value += factor * basis);
                }
            }
        }
    }

    /// Adds the Galerkin projection of a field: its sum over the Gauss points times each
    /// polynomial.
    #[inline(always)]
    pub(crate) fn test(&self, field: &[f64], out: &mut [f64]) {
        for element in &self.elements {
            for c in 0..COMPONENTS {
                let values = &field[c * self.points..][element.points.clone()];
                for j in 0..self.modes[c] {
                    out[element.offset[c] + j] +=
                        dot(values, &self.rows[j * self.points..][element.points.clone()]);
                }
            }
        }
    }

    /// Adds the sums over the Gauss points of `weights` times the polynomials of components `row`
    /// and `column` to the block of a square matrix that belongs to them.
    #[inline(always)]
    pub(crate) fn test_pair(
        &self,
        weights: &[f64],
        row: usize,
        column: usize,
        matrix: &mut [f64],
        size: usize,
    ) {
        for element in &self.elements {
            let weights = &weights[element.points.clone()];
            for i in 0..self.modes[row] {
                let left = &self.rows[i * self.points..][element.points.clone()];
                for j in 0..self.modes[column] {
                    let right = &self.rows[j * self.points..][element.points.clone()];
                    matrix[(element.offset[row] + i) * size + element.offset[column] + j] +=
                        triple_dot(weights, left, right);
                }
            }
        }
    }
}

/// Dot product in eight partial sums: the result does not depend on the vector width.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut partial_sums = [0.0; 8];
    let (a_chunks, b_chunks) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a_chunks.zip(b_chunks) {
        for k in 0..8 {
            partial_sums[k] += x[k] * y[k];
        }
    }
    // A fixed tree of additions: every vector width rounds alike.
    let [s0, s1, s2, s3, s4, s5, s6, s7] = partial_sums;
    ((s0 + s4) + (s1 + s5)) + ((s2 + s6) + (s3 + s7)) + tail
}

/// Sum of triple products in four partial sums.
#[inline(always)]
fn triple_dot(a: &[f64], b: &[f64], c: &[f64]) -> f64 {
    let mut partial_sums = [0.0; 4];
    let (a_chunks, b_chunks, c_chunks) = (a.chunks_exact(4), b.chunks_exact(4), c.chunks_exact(4));
    let remainder = a_chunks.remainder().iter().zip(b_chunks.remainder()).zip(c_chunks.remainder());
    let tail: f64 = remainder.map(|((x, y), z)| x * y * z).sum();
    for ((x, y), z) in a_chunks.zip(b_chunks).zip(c_chunks) {
        for k in 0..4 {
            partial_sums[k] += x[k] * y[k] * z[k];
        }
    }
    (partial_sums[0] + partial_sums[2]) + (partial_sums[1] + partial_sums[3]) + tail
}
