"""Write a network of dense layers as an ONNX file, so that a spec can name it: `policies: {mine: {onnx: {file: mine.onnx}}}`.

For PyTorch networks use `torch.onnx.export`. This module is for weights in numpy arrays and needs no further package.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import InputError

ACTIVATIONS = ("Tanh", "Relu", "Sigmoid")
"""Activations between layers."""


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def _number(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _bytes(field: int, value: bytes | str) -> bytes:
    data = value.encode() if isinstance(value, str) else value
    return _varint(field << 3 | 2) + _varint(len(data)) + data


def _tensor(name: str, array: NDArray[Any]) -> bytes:
    dims = b"".join(_number(1, size) for size in array.shape)
    return dims + _number(2, 1) + _bytes(8, name) + _bytes(9, array.astype("<f4").tobytes())


def _node(operator: str, inputs: Sequence[str], output: str) -> bytes:
    return b"".join(_bytes(1, name) for name in inputs) + _bytes(2, output) + _bytes(4, operator)


def _end(name: str, size: int) -> bytes:
    shape = b"".join(_bytes(1, _number(1, length)) for length in (1, size))
    return _bytes(1, name) + _bytes(2, _bytes(1, _number(1, 1) + _bytes(2, shape)))


def save_network(
    file: str | os.PathLike[str],
    layers: Sequence[tuple[Any, Any]],
    *,
    activation: str = "Tanh",
    last_activation: str | None = None,
) -> None:
    """Write the network x → W_k a(… a(W_1 x + b_1) …) + b_k.

    `layers` are pairs of weights (outputs, inputs) and biases (outputs,); `activation` a is `Tanh`, `Relu` or `Sigmoid`, and
    `last_activation` follows the last layer, if any.
    """
    for name in (activation, last_activation):
        if name is not None and name not in ACTIVATIONS:
            raise InputError(f"activation: found {name!r}, expected one of {', '.join(ACTIVATIONS)}")
    pairs = [(np.asarray(weights, dtype=float), np.asarray(biases, dtype=float)) for weights, biases in layers]
    for number, (weights, biases) in enumerate(pairs):
        fits = weights.ndim == 2 and biases.shape == weights.shape[:1]
        fits = fits and (number == 0 or weights.shape[1] == pairs[number - 1][0].shape[0])
        if not fits:
            raise InputError(f"layers: found shapes {weights.shape} and {biases.shape} in layer {number}, expected (outputs, inputs)")
        if not (np.isfinite(weights).all() and np.isfinite(biases).all()):
            raise InputError(f"layers: found a number that is not finite in layer {number}, expected finite numbers")
    if not pairs:
        raise InputError("layers: found none, expected at least one")
    nodes, constants, value = [], [], "input"
    for number, (weights, biases) in enumerate(pairs):
        last = number == len(pairs) - 1
        names = [f"weights_{number}", f"biases_{number}"]
        constants += [_tensor(names[0], weights.T), _tensor(names[1], biases)]
        nodes.append(_node("MatMul", [value, names[0]], f"product_{number}"))
        after = last_activation if last else activation
        made = "output" if last and after is None else f"sum_{number}"
        nodes.append(_node("Add", [f"product_{number}", names[1]], made))
        if after is not None:
            value = "output" if last else f"active_{number}"
            nodes.append(_node(after, [made], value))
    graph = b"".join(_bytes(1, node) for node in nodes) + _bytes(2, "policy")
    graph += b"".join(_bytes(5, constant) for constant in constants)
    graph += _bytes(11, _end("input", pairs[0][0].shape[1])) + _bytes(12, _end("output", pairs[-1][0].shape[0]))
    model = _number(1, 8) + _bytes(2, "spinebench") + _bytes(7, graph) + _bytes(8, _number(2, 13))
    Path(file).write_bytes(model)


