//! Arrays in and out: anything that numpy makes an array of numbers of, with its shape checked, and
//! arrays of f64.

use numpy::{Element, PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::Fault;

/// An array of finite numbers.
pub(crate) struct Numbers {
    pub(crate) shape: Vec<usize>,
    pub(crate) values: Vec<f64>,
}

fn shown(shape: &[usize]) -> String {
    let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    format!("shape ({}{})", sizes.join(", "), if shape.len() == 1 { "," } else { "" })
}

/// Reads `found`, called `name`, as an array of finite numbers.
pub(crate) fn numbers(found: &Bound<'_, PyAny>, name: &str) -> PyResult<Numbers> {
    // What learners give.
    if let Ok(array) = found.cast::<PyArrayDyn<f32>>() {
        let values = array.readonly().as_array().iter().copied().map(f64::from).collect();
        return finite(name, array.shape().to_vec(), values);
    }
    let converted;
    let array = match found.cast::<PyArrayDyn<f64>>() {
        Ok(array) => array,
        Err(_) => {
            let py = found.py();
            let numpy = py.import("numpy")?;
            let refused = || {
                let kind = found
                    .get_type()
                    .name()
                    .map_or_else(|_| "?".to_owned(), |name| name.to_string());
                Fault::argument(name, format!("a {kind}"), "an array of numbers")
            };
            let plain = numpy.call_method1("asarray", (found,)).map_err(|_| refused())?;
            let kind: String = plain.getattr("dtype")?.getattr("kind")?.extract()?;
            if !"fiu".contains(kind.as_str()) {
                let dtype = plain.getattr("dtype")?.str()?.to_string();
                return Err(Fault::argument(
                    name,
                    format!("dtype {dtype}"),
                    "an array of real numbers",
                )
                .into());
            }
            let options = PyDict::new(py);
            options.set_item("dtype", "float64")?;
            converted =
                numpy.call_method("asarray", (plain,), Some(&options)).map_err(|_| refused())?;
            converted.cast::<PyArrayDyn<f64>>().map_err(|_| refused())?
        }
    };
    let values = array.readonly().as_array().iter().copied().collect();
    finite(name, array.shape().to_vec(), values)
}

fn finite(name: &str, shape: Vec<usize>, values: Vec<f64>) -> PyResult<Numbers> {
    if let Some(place) = values.iter().position(|value| !value.is_finite()) {
        let what = format!("{} at flat index {place}", values[place]);
        return Err(Fault::argument(name, what, "finite numbers").into());
    }
    Ok(Numbers { shape, values })
}

/// Reads an array of this shape; `what` says it in words.
pub(crate) fn shaped(
    found: &Bound<'_, PyAny>,
    name: &str,
    shape: &[usize],
    what: &str,
) -> PyResult<Vec<f64>> {
    let read = numbers(found, name)?;
    if read.shape != shape {
        return Err(Fault::argument(
            name,
            shown(&read.shape),
            format!("{} ({what})", shown(shape)),
        )
        .into());
    }
    Ok(read.values)
}

/// An array whose last axes are `ends`, and the sizes of the `lead` axes before them.
pub(crate) fn led(
    found: &Bound<'_, PyAny>,
    name: &str,
    lead: usize,
    end: usize,
    what: &str,
) -> PyResult<Numbers> {
    let read = numbers(found, name)?;
    if read.shape.len() != lead + 1 || read.shape[lead] != end {
        return Err(Fault::argument(name, shown(&read.shape), what).into());
    }
    Ok(read)
}

/// An array of this shape.
pub(crate) fn array<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape.to_vec())
}

/// A positive finite number.
pub(crate) fn positive(name: &str, value: f64) -> Result<f64, Fault> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Fault::argument(name, value.to_string(), "a finite number above 0"))
}
