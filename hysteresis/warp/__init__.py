"""The package's hysteresis in any model of MuJoCo Warp, on a GPU (experimental, extra `gpu`).

`attach` puts a callback into a model of MuJoCo Warp, which computes the torque of some joints in
all worlds by the models' C code, with 32-bit numbers. docs/gpu.md has an example.
"""

from ._attach import attach

__all__ = ["attach"]
