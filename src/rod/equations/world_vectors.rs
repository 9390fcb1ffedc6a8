//! World-frame vectors linear in all unknowns, stored as three rows, so that inner loops run over
//! contiguous memory.

use nalgebra::Vector3;

/// Derivative of a vector: rows x, y, z over the unknowns, one after the other.
///
/// Rows are zero-padded to a multiple of the loop unrolling.
#[derive(Clone, Debug)]
pub(crate) struct VectorDerivative {
    values: Vec<f64>,
}

/// Loop unrolling.
const STRIP: usize = 16;

/// Padded length of a row.
pub(crate) fn padded(unknowns: usize) -> usize {
    unknowns.next_multiple_of(STRIP)
}

impl VectorDerivative {
    pub(crate) fn zeros(unknowns: usize) -> VectorDerivative {
        VectorDerivative { values: vec![0.0; 3 * padded(unknowns)] }
    }

    /// The derivative of one component.
    #[inline(always)]
    pub(crate) fn row(&self, axis: usize) -> &[f64] {
        let n = self.values.len() / 3;
        &self.values[axis * n..(axis + 1) * n]
    }

    /// Change of the vector for a change of the unknowns.
    pub(crate) fn times(&self, change: &[f64]) -> Vector3<f64> {
        Vector3::from(self.rows().map(|row| row.iter().zip(change).map(|(a, b)| a * b).sum()))
    }

    /// All three components.
    #[inline(always)]
    pub(crate) fn rows(&self) -> [&[f64]; 3] {
        let (x, yz) = self.values.split_at(self.values.len() / 3);
        let (y, z) = yz.split_at(x.len());
        [x, y, z]
    }

    /// All three components, to be written.
    #[inline(always)]
    pub(crate) fn rows_mut(&mut self) -> [&mut [f64]; 3] {
        let n = self.values.len() / 3;
        let (x, yz) = self.values.split_at_mut(n);
        let (y, z) = yz.split_at_mut(n);
        [x, y, z]
    }

    #[inline(always)]
    pub(crate) fn fill_zero(&mut self) {
        self.values.fill(0.0);
    }

    #[inline(always)]
    pub(crate) fn copy_from(&mut self, other: &VectorDerivative) {
        self.values.copy_from_slice(&other.values);
    }

    /// Becomes `start + a·first + b·second`.
    #[inline(always)]
    pub(crate) fn set_sum(
        &mut self,
        start: &VectorDerivative,
        first: (&VectorDerivative, f64),
        second: (&VectorDerivative, f64),
    ) {
        let terms = start.values.iter().zip(&first.0.values).zip(&second.0.values);
        for (out, ((s, x), y)) in self.values.iter_mut().zip(terms) {
            *out = s + first.1 * x + second.1 * y;
        }
    }

    /// Adds `scale · other`.
    pub(crate) fn add_scaled(&mut self, other: &VectorDerivative, scale: f64) {
        self.values.iter_mut().zip(&other.values).for_each(|(out, x)| *out += scale * x);
    }

    /// Adds `scale · (other × fixed)`.
    #[inline(always)]
    pub(crate) fn add_cross(&mut self, other: &VectorDerivative, fixed: &Vector3<f64>, scale: f64) {
        let f = fixed * scale;
        let [x, y, z] = self.rows_mut();
        let [p, q, r] = other.rows();
        let inputs = p.iter().zip(q).zip(r);
        let outputs = x.iter_mut().zip(y).zip(z);
        for (((x, y), z), ((p, q), r)) in outputs.zip(inputs) {
            *x += q * f.z - r * f.y;
            *y += r * f.x - p * f.z;
            *z += p * f.y - q * f.x;
        }
    }

    /// Adds `arm × (other × fixed)`: the moment about the origin of a rotating force.
    pub(crate) fn add_arm_cross(
        &mut self,
        arm: &Vector3<f64>,
        other: &VectorDerivative,
        fixed: &Vector3<f64>,
    ) {
        let n = self.values.len() / 3;
        for k in 0..n {
            let turned =
                Vector3::new(other.row(0)[k], other.row(1)[k], other.row(2)[k]).cross(fixed);
            let moment = arm.cross(&turned);
            for axis in 0..3 {
                self.values[axis * n + k] += moment[axis];
            }
        }
    }
}
