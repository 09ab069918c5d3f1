"""An arm that moves without end, whose policy, task, suit and place may change while it does."""

from collections.abc import Iterator

import numpy as np

from ..assets import suit_names
from ..envs.arm_env import ArmEnv
from ..envs.extras import DRAWINGS
from ..envs.making import OURS, make_env
from ..envs.model.config import GRAVITY
from ..envs.policies import Policy, PolicySpec, make_policy, needed_options, policy_spec
from ..envs.policies.build import maker_of
from ..envs.tasks import TASKS
from ..errors import InputError
from .live import Live
from .runs import Scene

OFFERED = ("none", "feedforward", "compensation", "adaptive")  # beside the policy that is given
NEW = ("task", "suit", "place")  # what another choice of makes a new arm


class Stage:
    """The arm, and the policies that can move it.

    All policies get every observation, so that the memory of each is right when it takes over:
    another policy is a branch of the motion. Another task, suit or place begins a new motion.

    Args:
        chosen: Task, options, and the policy that moves the arm first.
        seed: Seed of the first motion.
        draw: Name of a drawing beside the arm; None for none.

    Attributes:
        env: The arm.
        live: What is shown and what may be chosen.
    """

    def __init__(self, chosen: Scene, seed: int, *, draw: str | None = None) -> None:
        (given,) = chosen.policies
        self._first = given if isinstance(given, PolicySpec) else policy_spec(given)
        self._scene, self._seed, self._draw = chosen, seed, draw
        own = {
            "policy": str(self._first),
            "task": chosen.env.removeprefix(OURS).removesuffix("-v0"),
            "suit": chosen.options["suit"],
            "place": chosen.options["gravity"],
        }
        self._own = own["task"]
        self.env, self._policies = self._made(own)
        known = {"task": TASKS, "suit": suit_names(), "place": GRAVITY, "policy": self._policies}
        choices = {kind: list(dict.fromkeys([name, *known[kind]])) for kind, name in own.items()}
        self.live = Live(choices=choices, chosen=own)

    def motion(self) -> Iterator[ArmEnv]:
        """Moves the arm without end; yields it after each reset and each step."""
        while True:
            chosen, restarted = dict(self.live.chosen), self.live.restarted
            observation, _ = self.env.reset(seed=self._seed)
            for policy in self._policies.values():
                policy.reset()
            self.live.samples.clear()
            ended = False
            while not ended:
                if self.env.renderer.beside is not None:
                    self.live.beside = self.env.renderer.beside()
                yield self.env
                now = dict(self.live.chosen)
                other = any(now[kind] != chosen[kind] for kind in NEW)
                if (other and self._replaced(now, chosen)) or self.live.restarted > restarted:
                    break
                if self.live.paused:
                    continue
                actions = {name: one.act(observation) for name, one in self._policies.items()}
                action = actions[now["policy"]]
                observation, _, terminated, truncated, info = self.env.step(action)
                self.live.measure(info)
                effort = float(np.sqrt(np.mean(np.square(info["effort"]))))
                self.live.status = (
                    f"motion {self._seed}, {info['time']:.1f} s: effort {effort:.0%} of strength"
                )
                ended = terminated or truncated
            self._seed += 1

    def _made(self, names: dict[str, str]) -> tuple[ArmEnv, dict[str, Policy]]:
        """Returns an arm, with what is drawn beside it, and the policies that can move it."""
        options = {**self._scene.options, "suit": names["suit"], "gravity": names["place"]}
        env_id = self._scene.env
        if names["task"] != self._own:
            options.pop("task", None)
            env_id = f"{OURS}{names['task']}-v0"
        specs = [self._first, *map(policy_spec, OFFERED)]
        needed = needed_options(self._first)
        if "sensors" in needed and maker_of(
            self._first.name
        ):  # no network, whose sensors are fixed
            sensors = [name for one in specs for name in needed_options(one).get("sensors", ())]
            needed = {**needed, "sensors": list(dict.fromkeys(sensors))}
        _, env = make_env(env_id, **{**options, **needed})
        policies = {str(specs[0]): make_policy(specs[0], env)}
        for spec in specs[1:]:
            try:
                policies.setdefault(str(spec), make_policy(spec, env))
            except InputError:  # this one cannot act here: it is not offered
                continue
        if self._draw is not None:
            env.renderer.beside = DRAWINGS.find(self._draw)(env.episodes.simulation)
        return env, policies

    def _replaced(self, names: dict[str, str], before: dict[str, str]) -> bool:
        """Takes the arm of other choices; or says why there is none, and takes the choices back."""
        try:
            env, policies = self._made(names)
        except InputError as error:
            self.live.note = str(error)
            self.live.chosen.update({kind: before[kind] for kind in NEW})
            return False
        self.env.close()
        self.env, self._policies = env, policies
        self.live.note = ""
        self.live.choices["policy"][:] = policies
        if names["policy"] not in policies:
            self.live.chosen["policy"] = next(iter(policies))
        return True
