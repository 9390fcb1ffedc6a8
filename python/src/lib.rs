//! The Python package of spinebench: the rod, calibration, discovery and experiments, with arrays
//! in and out. The modules here hold what needs Rust; `spinebench/*.py` gives it names, types and
//! documents.

mod arrays;
mod calculations;
mod calls;
mod errors;
mod imports;
mod learn;
mod model;
mod plants;
mod policies;
mod recordings;
mod rod;
mod rods;

use pyo3::prelude::*;

/// What `spinebench/__init__.py` imports.
#[pymodule]
mod _spinebench {
    #[pymodule_export]
    use crate::calculations::{_calibrate, _discover, _run, _simulate};
    #[pymodule_export]
    use crate::imports::{_export_mcap, _import_csv, _import_mcap};
    #[pymodule_export]
    use crate::learn::{PyGp, PyNetwork};
    #[pymodule_export]
    use crate::model::PyModel;
    #[pymodule_export]
    use crate::plants::PyPlants;
    #[pymodule_export]
    use crate::rod::PyRod;
    #[pymodule_export]
    use crate::rods::PyRods;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::calls::record_panics();
        crate::policies::provide();
        Ok(())
    }
}
