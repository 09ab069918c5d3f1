"""Loads MuJoCo models from files after the plugins of this package are registered."""

import os
from pathlib import Path

import mujoco

from ...errors import InputError, shown
from ...hysteresis import engine
from . import bushing

READERS = {
    ".xml": mujoco.MjModel.from_xml_path,
    ".mjb": mujoco.MjModel.from_binary_path,
}


def load_model(path: str | os.PathLike[str]) -> mujoco.MjModel:
    """Returns the model in a file of MJCF (.xml) or in MuJoCo's binary format (.mjb).

    A binary file has the numbers of its plugins, and not their names: what else registers plugins
    must have done so in the same order as in the process that saved it, or MuJoCo ends the process.
    MJCF has the names, and MuJoCo reports one that it does not know.

    Args:
        path: Path of the file.

    Raises:
        InputError: There is no such file, its name ends otherwise, or MuJoCo refuses its content,
            which is truncated, damaged or of another version.
    """
    engine.register()
    bushing.register()
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"the model is {shown(path)}: give the path of a .xml or .mjb file")
    file = Path(path)
    read = READERS.get(file.suffix.lower())
    if read is None:
        raise InputError(
            f"{shown(str(path))} is no .xml and no .mjb file: give one of these, or save the model "
            "as one"
        )
    if not file.is_file():
        raise InputError(f"there is no file {shown(str(path))}: give the path of a model")
    try:
        return read(str(file))
    except ValueError as error:
        why = " ".join(str(error).split())
        raise InputError(
            f"MuJoCo {mujoco.__version__} cannot load {shown(str(path))} ({why}): repair the file, "
            "or save the model again with this version"
        ) from error
