"""Rows of arms as a vector environment of Stable-Baselines3 (needs the extra `train`)."""

from collections.abc import Iterable, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from ..errors import InputError, shown
from .reward import COSTS
from .vector_env import ArmVectorEnv


class ArmVecEnv(VecEnv):
    """Adapter of an `ArmVectorEnv` for Stable-Baselines3, with the same episodes.

    The info of a row whose episode goes on is empty, and one dict is shared by all of them. Where
    an episode has ended it contains `terminal_observation`, `TimeLimit.truncated` and `is_success`,
    which learners log, and `episode_costs`, the `cost_terms` of the episode.

    Args:
        arms: Vector environment with `autoreset_mode="SameStep"`.

    Raises:
        InputError: The vector environment has another mode.
    """

    def __init__(self, arms: ArmVectorEnv) -> None:
        if not isinstance(arms, ArmVectorEnv):
            raise InputError(f"arms is {shown(arms)}: give an ArmVectorEnv")
        if arms.autoreset_mode is not AutoresetMode.SAME_STEP:
            raise InputError(
                f"autoreset_mode is {arms.autoreset_mode.value!r}: Stable-Baselines3 needs "
                "autoreset_mode='SameStep'"
            )
        self.arms, self.render_mode = arms, arms.render_mode
        super().__init__(arms.num_envs, arms.single_observation_space, arms.single_action_space)
        self.metadata = arms.metadata
        self._actions = np.zeros(arms.action_space.shape or (), np.float32)

    def reset(self) -> NDArray[np.float32]:
        """Begins a new episode in every row, with the seeds that `seed` has set."""
        seeds = self._seeds if any(seed is not None for seed in self._seeds) else None
        if any(self._options):
            raise InputError(f"reset got the options {self._options[0]}: it knows none")
        observation, _ = self.arms.reset(seed=seeds)
        self.reset_infos = [{}] * self.num_envs
        self._reset_seeds()
        self._reset_options()
        return observation

    def step_async(self, actions: NDArray[np.floating[Any]]) -> None:
        """Takes the actions of the next control period, shape (num_envs, motors)."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Moves all rows; returns observations, rewards, ends of episodes and infos."""
        observation, reward, terminated, truncated, info = self.arms.step(self._actions)
        ended = terminated | truncated
        infos: list[dict[str, Any]] = [{}] * self.num_envs
        for row in np.flatnonzero(ended).tolist():
            costs = info["final_info"]["cost_terms"]
            infos[row] = {
                "terminal_observation": info["final_obs"][row],
                "TimeLimit.truncated": bool(truncated[row] and not terminated[row]),
                "is_success": bool(info["final_info"]["is_success"][row]),
                "episode_costs": {name: float(costs[name][row]) for name in COSTS},
            }
        return observation, reward.astype(np.float32), ended, infos

    def close(self) -> None:
        """Frees the renderer."""
        self.arms.close()

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """Returns a picture of every row, None without a render mode."""
        pictures = self.arms.render() if self.render_mode else None
        return pictures or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Returns an attribute of the vector environment, once for each of some rows."""
        return [getattr(self.arms, attr_name)] * len(self._rows(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Sets an attribute of the vector environment, which all rows share.

        Raises:
            InputError: The indices are only some of the rows.
        """
        self._all_of("set_attr", indices)
        setattr(self.arms, attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Calls a method of the vector environment once, and returns the result for each row.

        Raises:
            InputError: The indices are only some of the rows.
        """
        self._all_of("env_method", indices)
        return [getattr(self.arms, method_name)(*method_args, **method_kwargs)] * self.num_envs

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]], indices: Any = None
    ) -> list[bool]:
        """Returns False for each row: there are no single environments to wrap."""
        del wrapper_class
        return [False] * len(self._rows(indices))

    def _rows(self, indices: Any) -> list[int]:
        if isinstance(indices, Iterable):
            return list(indices)
        return list(range(self.num_envs)) if indices is None else [indices]

    def _all_of(self, what: str, indices: Any) -> None:
        if self._rows(indices) != list(range(self.num_envs)):
            raise InputError(
                f"{what} got the indices {indices}: all rows are one environment, so leave them out"
            )
