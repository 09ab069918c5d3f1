"""Registers a MuJoCo plugin for each hysteresis model of the registry that is no wrapper."""

import zlib
from functools import cache
from pathlib import Path
from types import ModuleType

from .. import polynomial_kernels
from ..around import Wrapper, backlash_kernels, viscoelastic_kernels
from ..protocol import HysteresisModel
from ..registry import MODELS
from ._callbacks import build
from ._configuration import A_LIST, A_NUMBER, A_WORD, OPTIONAL
from ._faults import COMMON_KEYS
from ._layout import Layout
from .native import STAGE_POS, layout, register_plugin

KINDS = {"number": A_NUMBER, "list": A_LIST, "word": A_WORD}


def plugin_name(model: type[HysteresisModel]) -> str:
    """Returns the name of a model's plugin in MJCF."""
    return f"activesuit.{model.name.replace('-', '_')}"


def register() -> dict[str, int]:
    """Registers a plugin for each model with MuJoCo, once; returns their slots by plugin name.

    Raises:
        RuntimeError: The structs of the installed MuJoCo are not as it describes them.
    """
    bare = [model for model in MODELS.values() if not issubclass(model, Wrapper)]
    return {plugin_name(model): _register(model) for model in bare}


@cache
def _register(model: type[HysteresisModel]) -> int:
    own, at = model.config_keys, layout(Layout)
    return register_plugin(
        plugin_name(model),
        [*COMMON_KEYS, *(key.name for key in own)],
        lambda: build(
            model.kernels,
            tuple(KINDS[key.kind] + OPTIONAL * key.optional for key in own),
            tuple(" ".join(key.words).encode() for key in own),
            at._replace(stamp=_stamp(model.kernels)),
        ),
        STAGE_POS,
        sensors=True,
    )


def _stamp(kernels: ModuleType) -> int:
    """Returns a number that changes with any file of the engine or of the kernels' folder.

    Numba's own check of its cache reads the file of a callback, not those of inlined functions.
    """
    own = Path(str(kernels.__file__)).parent.glob("*.py")
    engine = Path(__file__).parent.rglob("*.py")
    shared = (backlash_kernels, viscoelastic_kernels, polynomial_kernels)
    around = [Path(str(module.__file__)) for module in shared]
    files = [*sorted(own), *sorted(engine), *around]
    stats = [(path.name, path.stat().st_mtime_ns, path.stat().st_size) for path in files]
    return zlib.crc32(repr(stats).encode())
