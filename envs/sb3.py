"""Rows of arms as a vector environment of Stable-Baselines3 (needs the extra `train`)."""

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper

from ..errors import InputError, shown
from .interface.reward import COSTS
from .plant import Plant
from .policies import AnyPolicy, make_policy
from .policies.registry import base_of, residual_of
from .policies.residual import SCALE, Cohorts, corrected
from .vector_env import ArmVectorEnv


class ArmVecEnv(VecEnv):
    """Adapter of an `ArmVectorEnv` for Stable-Baselines3, with the same episodes.

    The infos of all rows whose episode goes on are one empty dict. The info of an ended episode has
    `terminal_observation`, `TimeLimit.truncated` and `is_success`, which learners log, and
    `episode_costs`, the `cost_terms` of the episode.

    Args:
        arms: Vector environment with `autoreset_mode="SameStep"`.
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

    def seed(self, seed: int | Sequence[int] | None = None) -> Sequence[int | None]:
        """Sets the seeds of the next reset; returns the seeds.

        A single seed is that of row 0, and row i has seed + i. None draws the seeds.
        """
        if isinstance(seed, Sequence | np.ndarray):
            self._seeds = [*seed]
            return self._seeds
        return super().seed(seed)

    def reset(self) -> NDArray[np.float32]:
        """Begins a new episode in every row, with the seeds that `seed` has set."""
        seeds = self._seeds if any(seed is not None for seed in self._seeds) else None
        if any(self._options):
            raise InputError(
                f"reset got the options {shown(self._options[0])}: there are no such options; "
                "leave them out"
            )
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
        """Sets an attribute of the vector environment, which all rows share."""
        self._all_of("set_attr", indices)
        setattr(self.arms, attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Calls a method of the vector environment once, and returns the result for each row."""
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
                f"{what} got the indices {indices}: all rows are one environment; leave indices out"
            )


class ResidualVecEnv(VecEnvWrapper):
    """Lets a learner correct a policy: the motors get policy + scale x action.

    The actions of the policy follow the other parts of the observation. A learner begins as the
    policy if its last layer begins at zero.

    Args:
        venv: Rows of arms with the sensors that the policy needs.
        policy: Policy of this package, as `make_policy` takes it.
        scale: Scale of the learner's action, 0.01 to 2.

    Attributes:
        residual: Policy and scale as plain data, for the card of what is trained.
    """

    def __init__(self, venv: ArmVecEnv, policy: AnyPolicy, scale: float = SCALE) -> None:
        self.residual = residual_of(policy, scale)
        plant = Plant.of(venv.arms.episodes)
        seen = plant.observation_space
        spec, ones = base_of(self.residual), np.ones(plant.motors, np.float32)
        low, high = np.concatenate([seen.low, -ones]), np.concatenate([seen.high, ones])
        space = gymnasium.spaces.Box(low, high, dtype=np.float32)
        super().__init__(venv, observation_space=space)
        self._rows = venv
        self._policy = Cohorts(partial(make_policy, spec, plant), venv.num_envs, plant.motors)
        self._given = np.zeros((venv.num_envs, plant.motors))

    def reset(self) -> NDArray[np.float32]:
        """Begins a new episode in every row."""
        observation = self._rows.reset()
        self._given = self._policy.begin(np.arange(self.num_envs), observation)
        return self.seen(observation)

    def step_async(self, actions: NDArray[np.floating[Any]]) -> None:
        """Takes the corrections of the next control period, shape (num_envs, motors)."""
        self.venv.step_async(corrected(self._given, actions, self.residual.scale))

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Moves all rows; returns observations, rewards, ends of episodes and infos."""
        observation, reward, ended, infos = self._rows.step_wait()
        rows, last = np.flatnonzero(ended), observation.copy()
        for row in rows.tolist():
            last[row] = infos[row]["terminal_observation"]
        self._given = self._policy.act(last)
        for row, seen in zip(rows.tolist(), self.seen(last)[rows], strict=True):
            infos[row]["terminal_observation"] = seen
        if rows.size:
            self._given[rows] = self._policy.begin(rows, observation)
        return self.seen(observation), reward, ended, infos

    def get_memory(self) -> dict[str, Any]:
        """Returns the memory of the policy in all rows, which can be pickled."""
        return {"policy": self._policy, "given": self._given}

    def set_memory(self, memory: dict[str, Any]) -> None:
        """Restores what `get_memory` returned."""
        self._policy.restore(memory["policy"])
        self._given = memory["given"]

    def seen(self, observation: NDArray[np.float32]) -> NDArray[np.float32]:
        """Returns the observations of the learner: those of the arms, then the policy's actions."""
        return np.concatenate([observation, self._given], axis=1, dtype=np.float32)
