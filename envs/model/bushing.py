"""A six-axis spring and damper between two bodies: the compliance of a cuff, as an engine plugin.

A weld of MuJoCo is no calibrated cuff: its stiffness depends on mass and posture. A bushing has the
stiffness that it is given, adds no body and no constraint, and takes no energy or momentum from the
motion except what its dampers dissipate. Importing this module registers the plugin
`activesuit.bushing`, once per process; it works in plain MJCF too:

    <extension>
      <plugin plugin="activesuit.bushing">
        <instance name="cuff">
          <config key="limb" value="site on the limb"/> <config key="exo" value="site on the exo"/>
          <config key="stiffness" value="4500 4500 2100"/>
        </instance>
      </plugin>
    </extension>
    <sensor><plugin name="cuff_force" instance="cuff"/></sensor>

Further keys are rotational_stiffness, damping, rotational_damping and offset, three numbers each,
0 unless given. The name of a sensor ends in `force`, `torque` or `energy`, which it measures. A
process that reads a saved or pickled MjModel with bushings must import this module first.
"""

from dataclasses import dataclass, fields
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...errors import InputError, shown, unknown_name
from ...hysteresis.engine import native
from ._bushing_plugin import BITS, PARAMETER_SIZE, Layout, evaluate

PLUGIN_NAME = "activesuit.bushing"
SENSORS = "force", "torque", "energy"  # endings of the names of sensors, in the order of the word
LARGEST_OFFSET = 0.1  # m

Triple = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Bushing:
    """Springs and dampers along and about the axes x, y, z of the exoskeleton's site.

    The position d of the limb's site relative to the exoskeleton's, less `offset`, and the rotation
    vector phi between the two sites store the energy sum(K d^2 + Kr phi^2) / 2. The force is the
    exact gradient at any angle below pi, where the rotation vector jumps.

    Springs and dampers are integrated explicitly. With the effective mass m that the bushing moves,
    w = sqrt(k/m) and z = c / (2 sqrt(k m)), Euler's and the implicit integrators are stable for
    steps below 2 (sqrt(1 + z^2) - z) / w: 14 ms for 4500 N/m, 0.6 kg and z = 0.5.

    Attributes:
        stiffness: Stiffness K of the springs [N/m].
        rotational_stiffness: Stiffness Kr of the rotational springs [N·m/rad].
        damping: Damping of the relative velocity at the limb's site [N·s/m].
        rotational_damping: Damping of the relative angular velocity [N·m·s/rad].
        offset: Position of the limb's site at rest, in the axes of the exoskeleton's site [m].
    """

    stiffness: Triple = (0.0, 0.0, 0.0)
    rotational_stiffness: Triple = (0.0, 0.0, 0.0)
    damping: Triple = (0.0, 0.0, 0.0)
    rotational_damping: Triple = (0.0, 0.0, 0.0)
    offset: Triple = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, _triple(field.name, getattr(self, field.name)))

    @property
    def parameter_vector(self) -> NDArray[np.float64]:
        """All numbers in the order of the attributes, shape (15,)."""
        return np.concatenate([getattr(self, field.name) for field in fields(self)])


KEYS = ("limb", "exo", *(field.name for field in fields(Bushing)))
"""Config keys of the plugin: two sites, then the numbers in the order of the parameters."""


def attach_bushing(
    spec: mujoco.MjSpec, name: str, limb_site: str, exo_site: str, bushing: Bushing
) -> None:
    """Connects two bodies by a bushing, in place.

    The two sites are on different bodies, and the axes of the bushing are those of `exo_site`. The
    forces appear in `qfrc_passive`, under every integrator and in every batch. The parameters are
    part of the simulation's state (see `replace_bushing`).

    Three sensors are added, in the axes of the exoskeleton's site: `<name>_force`
    and `<name>_torque`, which act on the limb at its site [N, N·m], and `<name>_energy`, stored in
    the springs [J], which MuJoCo's own potential energy leaves out.

    Compose first, attach last: when a spec is attached to another spec under a name prefix, MuJoCo
    renames the sites, but not the sites in the plugin's config.
    """
    sites = {site.name: site for site in spec.sites}
    for site in (limb_site, exo_site):
        if site not in sites:
            raise unknown_name("site", site, filter(None, sites))
    if sites[limb_site].parent == sites[exo_site].parent:
        raise InputError(
            f"sites {limb_site!r} and {exo_site!r} are on one body: a bushing connects two"
        )
    if any(plugin.name == name for plugin in spec.plugins):
        raise InputError(f"there is a plugin instance {name!r} already: give another name")
    if PLUGIN_NAME not in {plugin.plugin_name for plugin in spec.plugins}:
        spec.activate_plugin(PLUGIN_NAME)
    native.compile_plugin(PLUGIN_NAME)
    plugin = spec.add_plugin(name=name, plugin_name=PLUGIN_NAME, active=True)
    numbers = {key: " ".join(map(repr, getattr(bushing, key))) for key in KEYS[2:]}
    plugin.config = {"limb": limb_site, "exo": exo_site, **numbers}
    for quantity in SENSORS:
        sensor = spec.add_sensor(name=f"{name}_{quantity}", type=mujoco.mjtSensor.mjSENS_PLUGIN)
        sensor.plugin = plugin


def replace_bushing(
    mj_model: mujoco.MjModel, plugin_state: NDArray[np.float64], name: str, bushing: Bushing
) -> None:
    """Gives one simulation another bushing, for example cuffs that are strapped on differently.

    `plugin_state` is `data.plugin_state`, or the row of one simulation of a batch, and is changed
    in place. A reset restores the bushing of the compiled model.
    """
    _parameters(mj_model, plugin_state, name)[:] = bushing.parameter_vector


def move_bushing(
    mj_model: mujoco.MjModel, plugin_state: NDArray[np.float64], name: str, by: Array
) -> None:
    """Moves the rest position of one simulation's bushing [m]; see `replace_bushing`."""
    _parameters(mj_model, plugin_state, name)[-3:] += by


def _parameters(
    mj_model: mujoco.MjModel, plugin_state: NDArray[np.float64], name: str
) -> NDArray[np.float64]:
    """Returns a view of the parameters of a bushing."""
    ours = np.flatnonzero(mj_model.plugin == register())
    kind = mujoco.mjtObj.mjOBJ_PLUGIN
    names = {mujoco.mj_id2name(mj_model, kind, i): i for i in ours}
    if name not in names:
        raise unknown_name("bushing", name, names)
    if plugin_state.shape != (mj_model.npluginstate,):
        raise InputError(
            f"plugin_state has the shape {plugin_state.shape}: this model's is "
            f"({mj_model.npluginstate},); give data.plugin_state or a row of a batch"
        )
    address = mj_model.plugin_stateadr[names[name]]
    return plugin_state[address : address + PARAMETER_SIZE]


def register() -> int:
    """Registers the plugin with MuJoCo, once; returns its slot (`mjModel.plugin`).

    Raises:
        RuntimeError: The structs of the installed MuJoCo differ from their own description.
    """
    at = native.layout(Layout)
    return native.register_plugin(
        PLUGIN_NAME, KEYS, lambda: _build(at), native.STAGE_VEL, sensors=True
    )


def _build(at: Layout) -> Any:
    """Returns the functions of the plugin; the compiled one is cached on disk per layout."""

    def nstate(instance: native.Instance) -> int:
        return PARAMETER_SIZE

    def nsensordata(instance: native.Instance, sensor: int) -> int:
        return 1 if instance.sensor_name(sensor).endswith("energy") else 3

    def init(instance: native.Instance) -> int:
        sites = [instance.find("site", end) for end in KEYS[:2]]
        if len({instance.integer("site_bodyid", site) for site in sites}) == 1:
            raise InputError(
                f"exo is {shown(instance.config['exo'])}: it is on the same body as the limb site; "
                "name one on another"
            )
        _configured(instance)
        return native.pack([*sites, *instance.sensors(SENSORS)], BITS)

    def reset(instance: native.Instance, state: Array, word: int) -> None:
        state[:] = _configured(instance).parameter_vector

    @native.callback
    def compute(m, d, instance, capability):
        evaluate(m, d, instance, capability, at)

    return nstate, nsensordata, init, reset, compute


def _configured(instance: native.Instance) -> Bushing:
    """Returns the bushing of an instance; missing numbers are 0."""
    given = {key: native.numbers(instance.config, key) for key in KEYS[2:]}
    return Bushing(**{key: tuple(values) for key, values in given.items() if values})  # type: ignore


def _triple(name: str, values: Triple) -> Triple:
    low, high = (-LARGEST_OFFSET, LARGEST_OFFSET) if name == "offset" else (0.0, np.inf)
    numbers = np.asarray(values, dtype=float)
    inside = numbers.shape == (3,) and np.isfinite(numbers).all()
    if not (inside and (low <= numbers).all() and (numbers <= high).all()):
        allowed = f"from {low:g} to {high:g} m" if name == "offset" else "of at least 0"
        raise InputError(f"{name} of a bushing is {values}: give three finite numbers {allowed}")
    x, y, z = numbers.tolist()
    return x, y, z


register()
