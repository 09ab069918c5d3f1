"""Many arms at once: the same episodes as `ArmEnv`, as one vector environment of Gymnasium.

    >>> arms = ArmVectorEnv(3, "ElbowFlexion", autoreset_mode="SameStep", max_episode_steps=2)
    >>> observations, info = arms.reset(seed=[5, 6, 7])
    >>> ends = [arms.step(np.zeros((3, 2)))[3].tolist() for _ in range(2)]
    >>> ends
    [[False, False, False], [True, True, True]]

Row i is `ArmEnv` with the seed of row i to the last bit, whatever the other rows do and however
many threads work. Returned arrays are new: they never change afterwards.
"""

import os
from collections.abc import Sequence
from typing import Any, Literal, get_args

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ..checks import at_least, check_seed, flag
from ..errors import InputError, shown, unknown_name
from .episodes import Episodes
from .rendering import ArmRenderer, RenderQuality
from .setup import Setup
from .simulation.episode_plan import series
from .tasks import ARM_TRACKING, Task, task_of

InfoKind = Literal["none", "metrics", "full"]
METRICS = ("human_energy", "assist_energy", "dissipated_energy", "motor_load")
METRICS += ("is_success", "reward_terms")
MOST_THREADS = 1024
MASK, LEARNED = "reset_mask", ("learned_torque", "learned_contraction")  # options of a reset
Bools = NDArray[np.bool_]


class ArmVectorEnv(VectorEnv[NDArray[np.float32], NDArray[np.floating[Any]], NDArray[Any]]):
    """Rows of arms in one process: row i is `ArmEnv` with the seed of row i, to the last bit.

    Actions have the shape (num_envs, motors), observations (num_envs, size).

    Args:
        num_envs: Number of rows.
        task: Task, or the name of a shipped one.
        threads: Number of threads of the physics; 0 takes OMP_NUM_THREADS, or else all cores.
        max_episode_steps: Number of control periods after which an episode is truncated; None is
            the whole duration of the task.
        autoreset_mode: Begin of a row's next episode: "NextStep" (the step after the end resets
            the row and ignores its action), "SameStep" (the step that ends an episode returns the
            first observation of the next one, and the last of the old in `info["final_obs"]`) or
            "Disabled" (`reset(options={"reset_mask": mask})` resets the rows that the mask names).
        stagger: Whether the episodes after a reset of all rows end at random times, so that later
            ones do not all begin together.
        info: Content of `info`: "none"; "metrics" (energies, load of the motors, success, terms of
            the reward); or "full" (all that `ArmEnv` gives).
        render_mode: None or "rgb_array", a picture of each row.
        camera: Name of the camera to render from.
        width: Width of a picture [pixels].
        height: Height of a picture [pixels].
        render_quality: Quality of pictures, "fast" or "fine".
        learned_torque: Whether a reset takes the options `learned_torque` and
            `learned_contraction` of wearers who have learned.
        effort_scale: Effort by which the reward is scaled; by default that of the suited arm.
        **options: Options of the environment, as in `ArmEnv`. The draws of `randomize` differ
            between rows.

    Attributes:
        task: Task.
        control_dt: Time between actions [s].
        duration: Duration of an episode [s].
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 100}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        task: str | Task = ARM_TRACKING,
        *,
        threads: int = 0,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        stagger: bool = False,
        info: InfoKind = "none",
        render_mode: str | None = None,
        camera: str = "overview",
        width: int = 640,
        height: int = 480,
        render_quality: RenderQuality = "fast",
        learned_torque: bool = False,
        effort_scale: float | None = None,
        **options: Any,
    ) -> None:
        at_least("num_envs", num_envs, 1)
        at_least("threads", threads, 0, MOST_THREADS)
        flag("stagger", stagger)
        if max_episode_steps is not None:
            at_least("max_episode_steps", max_episode_steps, 1)
        if info not in get_args(InfoKind):
            raise unknown_name("info", info, get_args(InfoKind))
        if render_mode not in (None, "rgb_array"):
            raise InputError(f"render_mode is {render_mode!r}: use None or 'rgb_array'")
        self.autoreset_mode = _mode(autoreset_mode)
        task = task_of(task)
        self.episodes = Episodes(
            task,
            num_envs,
            Setup.of(task, options),
            threads=threads or _usual_threads(),
            max_periods=max_episode_steps,
            learned_torque=learned_torque,
            effort_scale=effort_scale,
        )
        simulation = self.episodes.simulation
        self.task, self.duration, self.control_dt = task, task.duration, simulation.control_dt
        fps = round(1 / self.control_dt)
        self.metadata = {**self.metadata, "render_fps": fps, "autoreset_mode": self.autoreset_mode}
        self.render_mode, self.num_envs = render_mode, num_envs
        self._info, self.staggered = info, stagger
        look = camera, width, height, render_quality
        self.renderer = ArmRenderer(simulation.config, task.edits, *look)
        self.layout = self.episodes.observer.layout
        self.single_observation_space = self.episodes.observer.space
        motors = (self.episodes.motors,)
        self.single_action_space = gymnasium.spaces.Box(-1.0, 1.0, motors, np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._rows, self._over = np.arange(num_envs), np.zeros(num_envs, np.bool_)
        self._every = np.ones(num_envs, np.bool_)

    # --- Gymnasium ----------------------------------------------------------------------------

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins a new episode in each row, or in those that a mask names.

        Args:
            seed: Seed of row 0, where row i has seed + i; or one seed for every row.
            options: None, or a dict: "reset_mask", an array of num_envs booleans that is true for
                the rows to reset; `learned_torque`, torques of the wearers, added to those of their
                bare arms, and `learned_contraction`, their co-contraction beyond the usual one
                [N·m], shape (rows to reset, samples, 4), where the environment was made with
                learned_torque=True.
        """
        rows = self._rows if options is None else self._masked(options)
        seeds = _seeds(seed, self.num_envs)
        self.episodes.reset(
            rows,
            None if seeds is None else [seeds[row] for row in rows],
            stagger=self.staggered and rows is self._rows,
            learned={} if options is None else self._checked_learned(options, len(rows)),
        )
        self._over[rows] = False
        if rows is self._rows:
            self.renderer.forget()
        begun = np.isin(self._rows, rows)
        return self.episodes.observe(), self._infos(begun)

    def step(
        self, actions: NDArray[np.floating[Any]]
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], Bools, Bools, dict[str, Any]]:
        """Moves every row by one control period."""
        self.episodes.require_reset("step")
        episodes, over = self.episodes, self._over
        if not over.any():
            episodes.step(actions)
        elif self.autoreset_mode is AutoresetMode.NEXT_STEP:
            episodes.step(actions, self._rows[~over])
            episodes.reset(self._rows[over])
            episodes.reward[over] = 0.0
        else:
            raise InputError(
                f"the episodes of rows {shown(self._rows[over].tolist())} are over: reset them "
                "with options={'reset_mask': mask}"
            )
        reward = episodes.reward.copy()
        terminated, truncated = episodes.terminated.copy(), episodes.truncated.copy()
        if over.any():
            terminated[over] = truncated[over] = False
        ended = terminated | truncated
        last: dict[str, Any] = {}
        if self.autoreset_mode is AutoresetMode.SAME_STEP:
            if ended.any():
                last = self._final(ended)
                episodes.reset(self._rows[ended])
            self._over[:] = False
        else:
            self._over = ended
        infos = {**self._infos(self._every), **last}
        return episodes.observe(), reward, terminated, truncated, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Returns a picture (height, width, 3) of every row."""
        if self.render_mode is None:
            raise InputError(
                "render_mode is None: make the environment with render_mode='rgb_array'"
            )
        simulation = self.episodes.simulation
        return tuple(
            self.renderer.picture(simulation.posture_of(row)) for row in range(self.num_envs)
        )

    def close_extras(self, **options: Any) -> None:
        """Frees the renderer."""
        del options
        self.renderer.close()

    @property
    def has_cuffs(self) -> bool:
        """Whether cuffs connect the exoskeletons to the arms."""
        return "cuff_force" in self.episodes.simulation.columns

    def measured(self) -> NDArray[np.float64]:
        """Returns a new array of all measurements, for an evaluation; see `simulation`."""
        return self.episodes.simulation.state.sensors.measured.copy()

    # --- State --------------------------------------------------------------------------------

    def get_state(self, rows: Sequence[int] | None = None) -> dict[str, Any]:
        """Returns the whole state of some rows, by default all; see `ArmEnv.get_state`."""
        self.episodes.require_reset("get_state")
        return self.episodes.state(self._checked_rows(rows))

    def set_state(
        self, state: dict[str, Any], rows: Sequence[int] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Restores a state in as many rows; returns the observations of all rows, and info.

        The state is a result of `get_state`, also of an `ArmEnv`. By default all rows are restored;
        `rows` may be others than the saved rows.
        """
        chosen = self._checked_rows(rows)
        self.episodes.restore(chosen, state)
        # The state may be of the end of an episode, before its reset.
        ended = self.episodes.terminated | self.episodes.truncated
        self._over[chosen] = ended[chosen]
        return self.episodes.observe(), self._infos(self._every)

    # --- Parts --------------------------------------------------------------------------------

    def _masked(self, options: dict[str, Any]) -> NDArray[np.int64]:
        if not isinstance(options, dict):
            raise InputError(
                f"reset got the options {shown(options)}: give a dict with {MASK!r}, or None"
            )
        unknown = [name for name in options if name not in (MASK, *LEARNED)]
        if unknown:
            raise InputError(
                f"reset got the options {shown(unknown)}: use {MASK!r}, {LEARNED[0]!r} and "
                f"{LEARNED[1]!r} only"
            )
        mask = options.get(MASK)
        if mask is None:
            return self._rows
        shape = (self.num_envs,)
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != shape:
            raise InputError(
                f"{MASK} is {shown(mask)}: give an array of {self.num_envs} booleans, true for "
                "the rows to reset"
            )
        if not mask.any():
            raise InputError(f"{MASK} names no row: set at least one to true")
        return self._rows[mask]

    def _checked_learned(
        self, options: dict[str, Any], rows: int
    ) -> dict[str, NDArray[np.float64]]:
        shape = (rows, *self.episodes.simulation.state.intention.learned_torque.shape[1:])
        found: dict[str, Any] = {}
        for name in LEARNED:
            given = options.get(name)
            if given is None:
                continue
            if not shape[1]:
                raise InputError(f"{name} is given: make the environment with learned_torque=True")
            found[name] = series(name, given, shape)
        if LEARNED[1] in found and found[LEARNED[1]].min() < 0:
            raise InputError(f"{LEARNED[1]} is {found[LEARNED[1]].min():g} N·m: give 0 or more")
        return found

    def _checked_rows(self, rows: Sequence[int] | None) -> NDArray[np.int64]:
        if rows is None:
            return self._rows
        try:
            chosen = np.asarray(rows)
        except ValueError:  # lists of several lengths
            chosen = np.empty((0, 0))
        inside = chosen.dtype.kind in "iu" and ((chosen >= 0) & (chosen < self.num_envs)).all()
        if chosen.ndim != 1 or not inside or len(set(chosen.tolist())) != chosen.size:
            raise InputError(
                f"rows is {shown(rows)}: give different whole numbers from 0 to {self.num_envs - 1}"
            )
        return chosen.astype(np.int64)

    def _infos(self, mask: Bools, *always: str) -> dict[str, Any]:
        """Returns the infos of the rows of a mask, in the form of Gymnasium."""
        chosen = {*always, *(METRICS if self._info == "metrics" else ())}
        if self._info == "none" and not always:
            return {}
        found = self.episodes.report()
        if self._info != "full":
            found = {name: value for name, value in found.items() if name in chosen}
        if "cost_terms" in found:
            costs = found["cost_terms"].items()
            found["cost_terms"] = {name: np.where(mask, value, 0.0) for name, value in costs}
        for name in ("cost_terms", "reward_terms") & found.keys():
            found[name] = _with_masks(found[name], mask)
        return _with_masks(found, mask)

    def _final(self, ended: Bools) -> dict[str, Any]:
        """Returns the last observations and measurements of the episodes that have ended."""
        observation = self.episodes.observe()
        last = np.full(self.num_envs, None, dtype=object)
        for row in self._rows[ended].tolist():
            last[row] = observation[row]
        final = {"final_obs": last, "final_info": self._infos(ended, "is_success", "cost_terms")}
        return _with_masks(final, ended)


def _with_masks(values: dict[str, Any], mask: Bools) -> dict[str, Any]:
    return {**values, **{f"_{name}": mask.copy() for name in values}}


def _usual_threads() -> int:
    """Returns OMP_NUM_THREADS, which users set who run several processes; 0, all cores, if unset.

    The threads of a batch wait for each other at every step, which takes long if other processes
    use the cores too.
    """
    given = os.environ.get("OMP_NUM_THREADS", "")
    return min(int(given), MOST_THREADS) if given.isdecimal() else 0


def _mode(given: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(given)
    except ValueError:
        modes = [mode.value for mode in AutoresetMode]
        raise unknown_name("autoreset_mode", given, modes) from None


def _seeds(given: Any, rows: int) -> list[int | None] | None:
    """Returns a seed for every row; None if none is given."""
    if given is None:
        return None
    if isinstance(given, np.ndarray) and given.ndim == 1:
        given = given.tolist()
    if isinstance(given, list | tuple | range):
        if len(given) != rows:
            raise InputError(f"seed has {len(given)} numbers: give one for each of {rows} rows")
        return [None if seed is None else check_seed(seed) for seed in given]
    first = check_seed(given)
    check_seed(first + rows - 1)
    return [first + row for row in range(rows)]
