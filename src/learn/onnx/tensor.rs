//! Arrays of any number of axes, row by row.

use super::OnnxError;

/// An array.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tensor {
    pub(super) dims: Vec<usize>,
    pub(super) values: Vec<f64>,
}

impl Tensor {
    /// An array whose number of values is that of its shape.
    pub(super) fn new(dims: Vec<usize>, values: Vec<f64>) -> Option<Tensor> {
        let count = dims.iter().try_fold(1_usize, |count, &dim| count.checked_mul(dim))?;
        (count == values.len()).then_some(Tensor { dims, values })
    }

    pub(super) fn map(&self, function: impl Fn(f64) -> f64) -> Tensor {
        Tensor {
            dims: self.dims.clone(),
            values: self.values.iter().map(|&value| function(value)).collect(),
        }
    }

    /// The same numbers in a shape of as many.
    pub(super) fn reshaped(&self, dims: Vec<usize>) -> Tensor {
        Tensor { dims, values: self.values.clone() }
    }

    /// Rows and columns of a matrix; a vector is one row.
    fn matrix(&self, operator: &str) -> Result<(usize, usize), OnnxError> {
        match self.dims.as_slice() {
            [columns] => Ok((1, *columns)),
            [rows, columns] => Ok((*rows, *columns)),
            dims => Err(shape(
                operator,
                format!("found an array of {} axes, expected a matrix", dims.len()),
            )),
        }
    }

    pub(super) fn transposed(&self, operator: &str) -> Result<Tensor, OnnxError> {
        let (rows, columns) = self.matrix(operator)?;
        let values = (0..columns)
            .flat_map(|j| (0..rows).map(move |i| self.values[i * columns + j]))
            .collect();
        Ok(Tensor { dims: vec![columns, rows], values })
    }

    /// The product with a matrix: of a matrix, or of each row of an array of more axes.
    pub(super) fn times(&self, other: &Tensor, operator: &str) -> Result<Tensor, OnnxError> {
        let inner = self.dims.last().copied().unwrap_or(0);
        let rows = self.values.len().checked_div(inner).unwrap_or(0);
        let (given, columns) = other.matrix(operator)?;
        if inner != given {
            return Err(shape(operator, format!("found {rows}×{inner} times {given}×{columns}")));
        }
        let mut values = vec![0.0; rows * columns];
        for (row, sums) in values.chunks_exact_mut(columns.max(1)).enumerate() {
            for k in 0..inner {
                let factor = self.values[row * inner + k];
                let terms = &other.values[k * columns..][..columns];
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += factor * term);
            }
        }
        let mut dims = self.dims.clone();
        dims.pop();
        dims.push(columns);
        Ok(Tensor { dims, values })
    }

    /// Element by element, axes of length 1 repeated.
    pub(super) fn with(
        &self,
        other: &Tensor,
        operator: &str,
        function: impl Fn(f64, f64) -> f64,
    ) -> Result<Tensor, OnnxError> {
        let axes = self.dims.len().max(other.dims.len());
        // ONNX broadcasts as NumPy: missing axes stand in front.
        let padded = |dims: &[usize]| [vec![1; axes - dims.len()], dims.to_vec()].concat();
        let (left, right) = (padded(&self.dims), padded(&other.dims));
        let mut dims = Vec::with_capacity(axes);
        for (&a, &b) in left.iter().zip(&right) {
            match (a, b) {
                (a, b) if a == b => dims.push(a),
                (1, b) => dims.push(b),
                (a, 1) => dims.push(a),
                _ => {
                    return Err(shape(
                        operator,
                        format!("found shapes {:?} and {:?}", self.dims, other.dims),
                    ));
                }
            }
        }
        let index_in = |source: &[usize], place: usize| {
            let (mut remainder, mut index, mut stride) = (place, 0, 1);
            for axis in (0..axes).rev() {
                let along = remainder % dims[axis];
                remainder /= dims[axis];
                index += if source[axis] == 1 { 0 } else { along * stride };
                stride *= source[axis];
            }
            index
        };
        let count: usize = dims.iter().product();
        let values = (0..count)
            .map(|place| {
                function(self.values[index_in(&left, place)], other.values[index_in(&right, place)])
            })
            .collect();
        Ok(Tensor { dims, values })
    }
}

pub(super) fn shape(operator: &str, what: String) -> OnnxError {
    OnnxError::Shape { operator: operator.to_owned(), what }
}
