//! The Python package of spinebench: the rod, calibration, discovery and experiments, with arrays
//! in and out. The modules here hold what needs Rust; `spinebench/*.py` gives it names, types and
//! documents.

mod arrays;
mod calculations;
mod calls;
mod discovered;
mod episodes;
mod errors;
mod imports;
mod learn;
mod model;
mod plants;
mod policies;
mod recordings;
mod robots;
mod rod;
mod rods;
mod runs;

use pyo3::prelude::*;

/// What `spinebench/__init__.py` imports.
#[pymodule]
mod _spinebench {
    #[pymodule_export]
    use crate::calculations::{_calibrate, _discover, _simulate};
    #[pymodule_export]
    use crate::discovered::_save_discovery;
    #[pymodule_export]
    use crate::imports::{_export_mcap, _import_csv, _import_mcap};
    #[pymodule_export]
    use crate::learn::{PyGp, PyNetwork};
    #[pymodule_export]
    use crate::model::{_effects, PyModel};
    #[pymodule_export]
    use crate::robots::PyRobots;
    #[pymodule_export]
    use crate::rod::PyRod;
    #[pymodule_export]
    use crate::rods::PyRods;
    #[pymodule_export]
    use crate::runs::{_plan, _run};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("_VERSION", spinebench::VERSION)?;
        crate::calls::record_panics();
        crate::policies::provide();
        Ok(())
    }
}
