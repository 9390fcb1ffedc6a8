//! Operators that move numbers and compute none: other axes, parts, and shapes themselves.

use super::OnnxError;
use super::graph::OnnxNode;
use super::tensor::{Tensor, shape};

/// Most numbers that an operator may make; a damaged file may ask for any.
const MAX_NUMBERS: usize = 10_000_000;

/// What the operator makes of its inputs; `None` for an operator of another kind.
pub(super) fn apply(
    node: &OnnxNode,
    inputs: &[Option<&Tensor>],
) -> Result<Option<Vec<Tensor>>, OnnxError> {
    let name = node.operator.as_str();
    let wrong = |what: String| shape(name, what);
    let at = |place: usize| {
        let missing = || wrong(format!("found {} inputs, expected more", inputs.len()));
        inputs.get(place).copied().flatten().ok_or_else(missing)
    };
    // Whole numbers that later versions of the standard take from an input, earlier ones from a
    // setting.
    let whole = |key: &str, place: usize| -> Option<Vec<i64>> {
        let input = inputs.get(place).copied().flatten();
        let of_input = input.map(|input| input.values.iter().map(|value| *value as i64).collect());
        of_input.or_else(|| node.attributes.get(key).map(|given| given.integers.clone()))
    };
    let one = |tensor: Tensor| Ok(Some(vec![tensor]));
    match name {
        "Concat" => one(concatenated(inputs, node.integer("axis", 0), name)?),
        "ConstantOfShape" => {
            let dims = sizes(&at(0)?.values);
            let value = node.attributes.get("value").and_then(|given| given.tensor.as_ref());
            let value = value.and_then(|tensor| tensor.values.first().copied()).unwrap_or(0.0);
            one(filled(dims, value).ok_or_else(|| wrong("found too large a shape".to_owned()))?)
        }
        "Expand" => {
            let ones = filled(sizes(&at(1)?.values), 1.0);
            let ones = ones.ok_or_else(|| wrong("found too large a shape".to_owned()))?;
            one(at(0)?.with(&ones, name, |value, _| value)?)
        }
        "Flatten" => {
            let dims = &at(0)?.dims;
            let axis = usize::try_from(node.integer("axis", 1)).unwrap_or(0).min(dims.len());
            let dims = vec![dims[..axis].iter().product(), dims[axis..].iter().product()];
            one(at(0)?.reshaped(dims))
        }
        "Gather" => {
            let axis = node.integer("axis", 0);
            one(gathered(at(0)?, at(1)?, axis).ok_or_else(|| wrong(outside(at(0).ok())))?)
        }
        "Reshape" => one(reshaped(at(0)?, &at(1)?.values, name)?),
        "Shape" => {
            let values: Vec<f64> = at(0)?.dims.iter().map(|&dim| dim as f64).collect();
            one(Tensor { dims: vec![values.len()], values })
        }
        "Slice" => {
            let (starts, ends) = (whole("starts", 1), whole("ends", 2));
            let (axes, steps) = (whole("axes", 3), whole("steps", 4));
            let ranges = Ranges { starts, ends, axes, steps };
            one(ranges.of(at(0)?).ok_or_else(|| wrong(outside(at(0).ok())))?)
        }
        "Split" => {
            let parts = split(node, at(0)?, whole("split", 1));
            Ok(Some(parts.ok_or_else(|| wrong(outside(at(0).ok())))?))
        }
        "Squeeze" | "Unsqueeze" => {
            let axes = whole("axes", 1).unwrap_or_default();
            let dims = with_axes(name, &at(0)?.dims, &axes);
            one(at(0)?.reshaped(dims.ok_or_else(|| wrong(outside(at(0).ok())))?))
        }
        "Transpose" => {
            let perm = node.attributes.get("perm").map(|given| given.integers.clone());
            one(transposed(at(0)?, perm).ok_or_else(|| wrong(outside(at(0).ok())))?)
        }
        _ => Ok(None),
    }
}

fn outside(input: Option<&Tensor>) -> String {
    format!("axes or indices outside an array of shape {:?}", input.map_or(&[][..], |i| &i.dims))
}

fn sizes(values: &[f64]) -> Vec<usize> {
    values.iter().map(|size| *size as usize).collect()
}

fn filled(dims: Vec<usize>, value: f64) -> Option<Tensor> {
    let count = dims.iter().try_fold(1_usize, |count, &dim| count.checked_mul(dim))?;
    (count <= MAX_NUMBERS).then(|| Tensor { dims, values: vec![value; count] })
}

/// An axis that may be counted from the last.
fn axis_of(axis: i64, axes: usize) -> Option<usize> {
    let axis = if axis < 0 { axis + i64::try_from(axes).ok()? } else { axis };
    usize::try_from(axis).ok().filter(|axis| *axis < axes)
}

/// The shape without, or with, these axes of length 1.
fn with_axes(name: &str, dims: &[usize], axes: &[i64]) -> Option<Vec<usize>> {
    if name == "Squeeze" {
        let dropped: Vec<usize> =
            axes.iter().map(|&axis| axis_of(axis, dims.len())).collect::<Option<_>>()?;
        let stays = |(axis, dim): (usize, &usize)| {
            let drops = if axes.is_empty() { *dim == 1 } else { dropped.contains(&axis) };
            (!drops).then_some(*dim)
        };
        return Some(dims.iter().enumerate().filter_map(stays).collect());
    }
    let added = axes.len().max(1);
    let mut places: Vec<usize> =
        axes.iter().map(|&axis| axis_of(axis, dims.len() + added)).collect::<Option<_>>()?;
    places.sort_unstable();
    let mut all = dims.to_vec();
    places.into_iter().for_each(|place| all.insert(place.min(all.len()), 1));
    Some(all)
}

/// The array with its axes in the order `perm`, by default reversed.
fn transposed(input: &Tensor, perm: Option<Vec<i64>>) -> Option<Tensor> {
    let axes = input.dims.len();
    let order: Vec<usize> = match perm {
        Some(perm) => perm.iter().map(|&axis| axis_of(axis, axes)).collect::<Option<_>>()?,
        None => (0..axes).rev().collect(),
    };
    let mut sorted = order.clone();
    sorted.sort_unstable();
    if sorted != (0..axes).collect::<Vec<_>>() {
        return None;
    }
    let dims: Vec<usize> = order.iter().map(|&axis| input.dims[axis]).collect();
    let strides = strides(&input.dims);
    let source =
        |place: &[usize]| place.iter().zip(&order).map(|(k, axis)| k * strides[*axis]).sum();
    Some(picked(input, dims, source))
}

/// The parts of `input` that `places` names along an axis.
fn gathered(input: &Tensor, places: &Tensor, axis: i64) -> Option<Tensor> {
    let axis = axis_of(axis, input.dims.len())?;
    let chosen: Vec<usize> = places
        .values
        .iter()
        .map(|place| axis_of(*place as i64, input.dims[axis]))
        .collect::<Option<_>>()?;
    let dims = [&input.dims[..axis], &places.dims, &input.dims[axis + 1..]].concat();
    let (strides, inner) = (strides(&input.dims), strides(&places.dims));
    let source = |place: &[usize]| {
        let (before, rest) = place.split_at(axis);
        let (of_places, after) = rest.split_at(places.dims.len());
        let which: usize = of_places.iter().zip(&inner).map(|(k, stride)| k * stride).sum();
        let before: usize = before.iter().zip(&strides).map(|(k, stride)| k * stride).sum();
        let after: usize =
            after.iter().zip(&strides[axis + 1..]).map(|(k, stride)| k * stride).sum();
        before + chosen[which] * strides[axis] + after
    };
    Some(picked(input, dims, source))
}

/// Ranges of places along axes.
struct Ranges {
    starts: Option<Vec<i64>>,
    ends: Option<Vec<i64>>,
    axes: Option<Vec<i64>>,
    steps: Option<Vec<i64>>,
}

impl Ranges {
    fn of(&self, input: &Tensor) -> Option<Tensor> {
        let (starts, ends) = (self.starts.as_ref()?, self.ends.as_ref()?);
        let mut first = vec![0_i64; input.dims.len()];
        let mut step = vec![1_i64; input.dims.len()];
        let mut dims = input.dims.clone();
        for (number, (&start, &end)) in starts.iter().zip(ends).enumerate() {
            let axis = self
                .axes
                .as_ref()
                .map_or(Some(i64::try_from(number).ok()?), |axes| axes.get(number).copied())?;
            let axis = axis_of(axis, input.dims.len())?;
            let by = self.steps.as_ref().and_then(|steps| steps.get(number)).copied().unwrap_or(1);
            let size = i64::try_from(input.dims[axis]).ok()?;
            let from_end = |place: i64| if place < 0 { place.saturating_add(size) } else { place };
            // The standard holds both ends within the array.
            let (low, high) = if by > 0 { (0, size) } else { (-1, size - 1) };
            let (start, end) = (from_end(start).clamp(low, high), from_end(end).clamp(low, high));
            let count = (end - start + by - by.signum()).checked_div(by)?.max(0);
            (first[axis], step[axis], dims[axis]) = (start, by, usize::try_from(count).ok()?);
        }
        let strides = strides(&input.dims);
        let source = |place: &[usize]| {
            let along = |axis: usize| first[axis] + step[axis] * place[axis] as i64;
            (0..place.len()).map(|axis| along(axis).max(0) as usize * strides[axis]).sum()
        };
        Some(picked(input, dims, source))
    }
}

/// Parts along an axis, of the sizes `split` or as many equal ones as there are outputs.
fn split(node: &OnnxNode, input: &Tensor, split: Option<Vec<i64>>) -> Option<Vec<Tensor>> {
    let axis = axis_of(node.integer("axis", 0), input.dims.len())?;
    let equal = || {
        let part = input.dims[axis].div_ceil(node.outputs.len().max(1));
        let size = |k: usize| part.min(input.dims[axis].saturating_sub(k * part)) as i64;
        (0..node.outputs.len()).map(size).collect()
    };
    let mut start = 0_i64;
    let part = |size: i64| {
        let ranges = Ranges {
            starts: Some(vec![start]),
            ends: Some(vec![start + size]),
            axes: Some(vec![axis as i64]),
            steps: None,
        };
        start += size;
        ranges.of(input)
    };
    split.unwrap_or_else(equal).into_iter().map(part).collect()
}

/// Arrays one after another along an axis.
fn concatenated(inputs: &[Option<&Tensor>], axis: i64, name: &str) -> Result<Tensor, OnnxError> {
    let parts: Vec<&Tensor> = inputs.iter().copied().flatten().collect();
    let wrong = || {
        let found = "found arrays of different shapes, expected equal shapes except along the \
                     joined axis";
        shape(name, found.to_owned())
    };
    let first = parts.first().ok_or_else(wrong)?;
    let axis = axis_of(axis, first.dims.len()).ok_or_else(wrong)?;
    let others = |part: &Tensor| {
        part.dims.iter().enumerate().filter(|(k, _)| *k != axis).map(|(_, dim)| *dim).collect()
    };
    let expected: Vec<usize> = others(first);
    if parts.iter().any(|part| part.dims.len() != first.dims.len() || others(part) != expected) {
        return Err(wrong());
    }
    let blocks: usize = first.dims[..axis].iter().product();
    let block = |part: &Tensor| part.dims[axis..].iter().product::<usize>();
    let mut values = Vec::with_capacity(parts.iter().map(|part| part.values.len()).sum());
    for number in 0..blocks {
        for part in &parts {
            values.extend_from_slice(&part.values[number * block(part)..][..block(part)]);
        }
    }
    let mut dims = first.dims.clone();
    dims[axis] = parts.iter().map(|part| part.dims[axis]).sum();
    Ok(Tensor { dims, values })
}

/// The array in another shape, in which 0 keeps an axis and −1 takes what remains.
fn reshaped(input: &Tensor, requested: &[f64], name: &str) -> Result<Tensor, OnnxError> {
    let explicit = |(axis, size): (usize, &f64)| {
        if *size == 0.0 { input.dims.get(axis).map_or(1.0, |&dim| dim as f64) } else { *size }
    };
    let sizes: Vec<f64> = requested.iter().enumerate().map(explicit).collect();
    let explicit_count: f64 = sizes.iter().filter(|size| **size > 0.0).product();
    let inferred = input.values.len() as f64 / explicit_count;
    let dims = sizes
        .iter()
        .map(|&size| if size < 0.0 { inferred as usize } else { size as usize })
        .collect();
    let wrong =
        || shape(name, format!("found {} numbers for the shape {sizes:?}", input.values.len()));
    Tensor::new(dims, input.values.clone()).ok_or_else(wrong)
}

/// Distance of neighbours along each axis, row by row.
fn strides(dims: &[usize]) -> Vec<usize> {
    (0..dims.len()).map(|axis| dims[axis + 1..].iter().product()).collect()
}

/// An array of shape `dims` whose numbers stand in `input` at `source` of their places.
fn picked(input: &Tensor, dims: Vec<usize>, source: impl Fn(&[usize]) -> usize) -> Tensor {
    let count: usize = dims.iter().product();
    let mut place = vec![0; dims.len()];
    let mut values = Vec::with_capacity(count);
    for _ in 0..count {
        values.push(input.values[source(&place)]);
        // The next place, the last axis fastest.
        for axis in (0..dims.len()).rev() {
            place[axis] += 1;
            if place[axis] < dims[axis] {
                break;
            }
            place[axis] = 0;
        }
    }
    Tensor { dims, values }
}
