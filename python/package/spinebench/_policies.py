"""User-defined policies: a class as a policy of a run."""

from __future__ import annotations

import importlib.util
import inspect
import itertools
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ._errors import InputError

Array = NDArray[np.float64]


class Policy(Protocol):
    """A policy. An optional method `reset()` is called when a trial begins."""

    def act(self, tip_m: Array, target_m: Array, pulls_m: Array, time_s: float) -> Any:
        """Return the displacement of each tendon, (tendons,), metres; or a pair of it and whether the policy has settled.

        `tip_m` (3,) is the last valid measurement, `target_m` (3,) the target, `pulls_m` (tendons,) the command in force, as
        limited by the drive, all in metres; `time_s` is the time since the trial began.
        """
        ...


PolicyClass = Callable[[], Policy]
"""A class, or any function without arguments, that creates a policy. Each set of trials creates its own."""

GIVEN = "given:"
"""Prefix of the names of classes that are objects of this process."""
_given: dict[str, PolicyClass] = {}
_modules: dict[str, tuple[bytes, ModuleType]] = {}
_numbers = itertools.count()


def spec_entry(name: str, policy: PolicyClass) -> dict[str, Any]:
    """The entry of a spec for an object of this process. Results of a class are stored under the content of its file; those of
    anything else are never read again."""
    if not callable(policy):
        raise InputError(f"policies: found a {type(policy).__name__} for {name!r}, expected a class with a method act()")
    if inspect.isclass(policy) and not callable(getattr(policy, "act", None)):
        raise InputError(f"policies: found the class {policy.__name__} for {name!r}, expected one with a method act()")
    file: str | None = None
    if inspect.isclass(policy):
        try:
            file = inspect.getsourcefile(policy)
        except (OSError, TypeError):
            file = None
    known = f"{GIVEN}{getattr(policy, '__qualname__', name)}"
    if file is None or not Path(file).is_file():
        import uuid

        file, known = __file__, f"{GIVEN}{name}:{next(_numbers)}:{uuid.uuid4().hex}"
    _given[known] = policy
    return {"python": {"file": str(Path(file).resolve()), "class": known}}


def _make(file: str, class_name: str) -> Any:
    """An instance of a class: one of this process, or one of a file."""
    if class_name.startswith(GIVEN):
        if class_name not in _given:
            raise InputError(f"policies: found {class_name!r} of another process, expected spinebench.run(policies=…)")
        return _given[class_name]()
    module = _module(Path(file))
    if not hasattr(module, class_name):
        raise InputError(f"no class `{class_name}` in {file}")
    return getattr(module, class_name)()


def _closed_loop_only(file: str, class_name: str) -> bool | tuple[str, str]:
    """Whether a class says that open loop means nothing to it; or what is wrong with it, and what was expected."""
    if not class_name.startswith(GIVEN):
        module = _module(Path(file))
        policies = [name for name, value in vars(module).items() if inspect.isclass(value) and hasattr(value, "act")]
        expected = f"a class with a method act(), such as {', '.join(f'`{name}`' for name in policies)}"
        if not policies:
            expected = "a class with a method act()"
        made = getattr(module, class_name, None)
        if made is None:
            return f"`{class_name}`, which {Path(file).name} does not define", expected
        if not callable(made) or (inspect.isclass(made) and not callable(getattr(made, "act", None))):
            return f"`{class_name}`, which has no method act()", expected
    # A network that cannot be loaded is told before anything runs, too.
    return bool(getattr(_make(file, class_name), "closed_loop_only", False))


def _module(file: Path) -> ModuleType:
    """The module of a file, loaded anew when its content has changed."""
    content = file.read_bytes()
    kept = _modules.get(str(file))
    if kept is not None and kept[0] == content:
        return kept[1]
    name = f"spinebench_policy_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise InputError(f"{file}: found no Python file, expected one with the ending .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    _modules[str(file)] = (content, module)
    return module


def _decide(policy: Any, tip_m: Array, target_m: Array, pulls_m: Array, time_s: float) -> tuple[Array, bool | None]:
    """The decision of a policy, as numbers."""
    decided = policy.act(tip_m, target_m, pulls_m, time_s)
    settled: bool | None = None
    if isinstance(decided, tuple) and len(decided) == 2 and np.ndim(decided[1]) == 0:
        decided, settled = decided[0], bool(decided[1])
    try:
        pulls = np.asarray(decided, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"act(): found a {type(decided).__name__}, expected displacements of the tendons") from None
    if pulls.ndim != 1:
        raise InputError(f"act(): found shape {pulls.shape}, expected one number per tendon")
    return pulls, settled
