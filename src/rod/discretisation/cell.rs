//! The two Gauss–Legendre points of a cell.

/// Half the distance between the two Gauss points, as a share of the cell: √3/6.
pub(crate) const GAUSS: f64 = 0.288_675_134_594_812_9;

/// Internal wrench components in the body frame: moments about x, y, z, then forces along x, y, z.
pub(crate) const COMPONENTS: usize = 6;

/// A Gauss point.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// Distance from the base, metres.
    pub(crate) position_m: f64,
    /// Quadrature weight, metres.
    pub(crate) weight_m: f64,
    /// Index of the first unknown of each component in the element that holds this node.
    pub(crate) offset: [usize; COMPONENTS],
    /// Values of the Legendre polynomials of the element here.
    pub(crate) basis: Vec<f64>,
}
