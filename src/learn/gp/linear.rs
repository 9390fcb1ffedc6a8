//! Cholesky factors and inverses of covariance matrices, on one thread and in memory that is used
//! again.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::{factor, inverse, solve};
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{MatMut, MatRef, Par};

/// A square matrix of which only the lower triangle is used, column-major. Columns are padded: at
/// distances of a power of two they would compete for the same sets of a cache.
#[derive(Clone, Debug)]
pub(super) struct Lower {
    n: usize,
    stride: usize,
    values: Vec<f64>,
}

impl Lower {
    pub(super) fn zeros(n: usize) -> Self {
        // Whole cache lines, and never a power of two.
        let stride = n.next_multiple_of(8) + 8;
        Lower { n, stride, values: vec![0.0; stride * n] }
    }

    /// Column `j` from the diagonal down.
    #[inline]
    pub(super) fn column(&self, j: usize) -> &[f64] {
        &self.values[j * self.stride + j..j * self.stride + self.n]
    }

    /// Column `j` from the diagonal down.
    #[inline]
    pub(super) fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.values[j * self.stride + j..j * self.stride + self.n]
    }

    /// Columns `j` to `j + 3` from row `j` down; what stands above their diagonals is zero in an
    /// inverse factor.
    #[inline]
    pub(super) fn panel(&self, j: usize) -> [&[f64]; 4] {
        std::array::from_fn(|c| {
            &self.values[(j + c) * self.stride + j..(j + c) * self.stride + self.n]
        })
    }

    pub(super) fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice_with_stride(&self.values, self.n, self.n, self.stride)
    }

    pub(super) fn view_mut(&mut self) -> MatMut<'_, f64> {
        MatMut::from_column_major_slice_with_stride_mut(
            &mut self.values,
            self.n,
            self.n,
            self.stride,
        )
    }

    /// Replaces a symmetric matrix by its Cholesky factor L; false when it is not positive
    /// definite.
    pub(super) fn factor(&mut self, memory: &mut FactorBuffers) -> bool {
        let stack = MemStack::new(&mut memory.0);
        let result = factor::cholesky_in_place(
            self.view_mut(),
            Default::default(),
            Par::Seq,
            stack,
            Default::default(),
        );
        // NaN on the diagonal must not count as a success.
        result.is_ok() && (0..self.n).all(|j| self.column(j)[0] > 0.0)
    }

    /// Of a Cholesky factor: `x ← (L Lᵀ)⁻¹ x`.
    pub(super) fn solve(&self, x: &mut [f64], memory: &mut FactorBuffers) {
        let right = MatMut::from_column_major_slice_mut(x, self.n, 1);
        solve::solve_in_place(self.view(), right, Par::Seq, MemStack::new(&mut memory.0));
    }

    /// Of a Cholesky factor: `L⁻¹` applied to every column of n numbers in `columns`.
    pub(super) fn solve_half(&self, columns: &mut [f64]) {
        let count = columns.len() / self.n.max(1);
        let right = MatMut::from_column_major_slice_mut(columns, self.n, count);
        solve_lower_triangular_in_place(self.view(), right, Par::Seq);
    }

    /// Of a Cholesky factor: `L⁻ᵀ` applied to every column of n numbers in `columns`.
    pub(super) fn solve_transposed_half(&self, columns: &mut [f64]) {
        let count = columns.len() / self.n.max(1);
        let right = MatMut::from_column_major_slice_mut(columns, self.n, count);
        solve_upper_triangular_in_place(self.view().transpose(), right, Par::Seq);
    }

    /// Of a Cholesky factor: `L⁻¹` applied to every row of n numbers of the column-major `rows`.
    pub(super) fn solve_half_rows(&self, rows: &mut [f64]) {
        let count = rows.len() / self.n.max(1);
        let right = MatMut::from_column_major_slice_mut(rows, count, self.n).transpose_mut();
        solve_lower_triangular_in_place(self.view(), right, Par::Seq);
    }

    /// Of a Cholesky factor: `L⁻ᵀ` applied to every row of n numbers of the column-major `rows`.
    pub(super) fn solve_transposed_half_rows(&self, rows: &mut [f64]) {
        let count = rows.len() / self.n.max(1);
        let right = MatMut::from_column_major_slice_mut(rows, count, self.n).transpose_mut();
        solve_upper_triangular_in_place(self.view().transpose(), right, Par::Seq);
    }

    /// Of a Cholesky factor: `out ← (L Lᵀ)⁻¹`.
    pub(super) fn inverse(&self, out: &mut Lower, memory: &mut FactorBuffers) {
        inverse::inverse(out.view_mut(), self.view(), Par::Seq, MemStack::new(&mut memory.0));
    }

    /// Of a Cholesky factor: L⁻¹.
    pub(super) fn inverse_factor(&self) -> Lower {
        let mut out = Lower::zeros(self.n);
        invert_lower_triangular(out.view_mut(), self.view(), Par::Seq);
        out
    }

    /// Of a Cholesky factor: `ln det(L Lᵀ) / 2`.
    pub(super) fn half_log_determinant(&self) -> f64 {
        (0..self.n).map(|j| self.column(j)[0].ln()).sum()
    }
}

/// Working memory for matrices of one size.
pub(super) struct FactorBuffers(MemBuffer);

impl FactorBuffers {
    pub(super) fn new(n: usize) -> Self {
        let need = factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default())
            .or(solve::solve_in_place_scratch::<f64>(n, 1, Par::Seq))
            .or(inverse::inverse_scratch::<f64>(n, Par::Seq));
        FactorBuffers(MemBuffer::new(need))
    }
}
