//! The three small matrix products behind a network, with the batch as the vector axis: a chunk is
//! sixteen samples.

use crate::learn::simd::Real;

/// Samples per chunk.
pub(super) const LANES: usize = 16;

/// Sixteen samples of one quantity.
pub(super) type Chunk<T> = [T; LANES];

/// A table of chunks: row `r` (a unit or an input) holds `width` chunks (times and groups of
/// samples).
#[derive(Clone, Debug)]
pub(super) struct ChunkTable<T> {
    pub(super) width: usize,
    pub(super) chunks: Vec<Chunk<T>>,
}

impl<T: Real> ChunkTable<T> {
    pub(super) fn zeros(rows: usize, width: usize) -> Self {
        ChunkTable { width, chunks: vec![[T::default(); LANES]; rows * width] }
    }

    #[inline(always)]
    pub(super) fn row(&self, row: usize) -> &[Chunk<T>] {
        &self.chunks[row * self.width..(row + 1) * self.width]
    }
}

/// `acc[u] += Σ_r weights[r][first + u] · table[r][at]` for `U` units; `weights` has rows of
/// `stride` numbers.
#[inline(always)]
pub(super) fn accumulate<T: Real, const U: usize>(
    acc: &mut [Chunk<T>; U],
    weights: &[T],
    stride: usize,
    first: usize,
    table: &ChunkTable<T>,
    at: usize,
    rows: usize,
) {
    let columns = table.chunks.get(at..).unwrap_or_default();
    for (weights, x) in
        weights.chunks_exact(stride).zip(columns.iter().step_by(table.width)).take(rows)
    {
        let Some(w) = weights.get(first..).and_then(|w| w.first_chunk::<U>()) else { return };
        for u in 0..U {
            for lane in 0..LANES {
                acc[u][lane] = w[u].fma(x[lane], acc[u][lane]);
            }
        }
    }
}

/// Rows of a table, each from chunk `from` on. `from` may lie beyond a row's chunks: the rows that
/// follow are then meant.
#[derive(Clone, Copy)]
pub(super) struct TableRows<'a, T> {
    pub(super) table: &'a ChunkTable<T>,
    pub(super) from: usize,
    pub(super) count: usize,
}

/// `out[r][u] += Σ_l a[r][l] · b[u][l]` over all lanes of `len` chunks, for the rows of `a` and of
/// `b`; `out` has rows of `stride` numbers.
#[inline(always)]
pub(super) fn outer<T: Real>(
    out: &mut [T],
    stride: usize,
    a: TableRows<T>,
    b: TableRows<T>,
    len: usize,
) {
    let mut r = 0;
    while r + 3 <= a.count {
        outer_rows::<T, 3>(out, stride, a, r, b, len);
        r += 3;
    }
    while r < a.count {
        outer_rows::<T, 1>(out, stride, a, r, b, len);
        r += 1;
    }
}

/// [`outer`] for the rows `row..row + R` of `a`.
#[inline(always)]
fn outer_rows<T: Real, const R: usize>(
    out: &mut [T],
    stride: usize,
    a: TableRows<T>,
    row: usize,
    b: TableRows<T>,
    len: usize,
) {
    let lines: [&[Chunk<T>]; R] =
        std::array::from_fn(|r| &a.table.row(row + r)[a.from..a.from + len]);
    for u in (0..b.count).step_by(2) {
        let left = &b.table.chunks[u * b.table.width + b.from..][..len];
        let right = &b.table.chunks[(u + 1) * b.table.width + b.from..][..len];
        let mut acc = [[[T::default(); LANES]; 2]; R];
        for l in 0..len {
            for r in 0..R {
                fma(&mut acc[r][0], &lines[r][l], &left[l]);
                fma(&mut acc[r][1], &lines[r][l], &right[l]);
            }
        }
        for r in 0..R {
            out[(row + r) * stride + u] += total(acc[r][0]);
            out[(row + r) * stride + u + 1] += total(acc[r][1]);
        }
    }
}

/// The chunk whose lanes are `value(lane)`.
#[inline(always)]
pub(super) fn each<T: Real>(value: impl Fn(usize) -> T) -> Chunk<T> {
    let mut out = [T::default(); LANES];
    for (lane, out) in out.iter_mut().enumerate() {
        *out = value(lane);
    }
    out
}

/// `acc += a · b` lane by lane.
#[inline(always)]
pub(super) fn fma<T: Real>(acc: &mut Chunk<T>, a: &Chunk<T>, b: &Chunk<T>) {
    for lane in 0..LANES {
        acc[lane] = a[lane].fma(b[lane], acc[lane]);
    }
}

/// Pairwise sum of a chunk.
#[inline(always)]
pub(super) fn total<T: Real>(mut chunk: Chunk<T>) -> T {
    for half in [8, 4, 2, 1] {
        for lane in 0..half {
            chunk[lane] += chunk[lane + half];
        }
    }
    chunk[0]
}
