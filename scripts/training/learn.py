"""Reinforcement learning of a policy, with checkpoints between the updates of the learner."""

from contextlib import closing, suppress
from functools import partial
from typing import Any

from stable_baselines3.common.callbacks import BaseCallback

from ...envs.policies.saving import network_of
from ..output import Bar, messages, progress
from .evaluations import EVALUATIONS, Evaluations
from .learner import (
    check_finite,
    draw_anew,
    new_learner,
    resumed_learner,
    save_learner,
    training_environments,
    training_seeds,
    update_length,
)
from .report import advice, write_report_of
from .run import CHECKPOINT, Run, finished

CHECKPOINTS = 10  # number of checkpoints of a run
JUDGED = 200  # control periods after which the reward of a new training is judged
TRAINING_ONLY = ("reward", "randomize")  # options without effect on evaluations


def learn(run: Run) -> int:
    """Trains until all steps are done; returns the number of steps."""
    env, training, folder = run.card.environment["env"], run.card.training, run.folder
    algo, seed, rows = training["algo"], training["seed"], training["rows"]
    own = {name: training[name] for name in TRAINING_ONLY if name in training}
    arms = training_environments(env, rows, {**run.options, **own}, run.card.residual)
    with closing(arms):
        if run.checkpoint is None:
            learner = new_learner(algo, arms, folder, seed, training["hyperparameters"])
        else:
            learner = resumed_learner(algo, arms, run.checkpoint, folder / CHECKPOINT)
        arms.seed(training_seeds(seed, rows))  # in place of the seeds that the learner has set
        going_on, done = bool(run.checkpoint) and finished(folder.path), learner.num_timesteps
        run = run.begun(EVALUATIONS)
        evaluations = Evaluations(run, done)
        total = run.rounded(update_length(learner), "updates", done)
        checkpoints = _Checkpoints(run, learner, evaluations, going_on=going_on)
        with progress(f"{algo} on {env}", total) as bar:
            callbacks = [checkpoints, _Progress(bar, new=run.checkpoint is None)]
            try:
                with suppress(_PlateauError):
                    learner.learn(
                        total - done, callbacks, reset_num_timesteps=not done, tb_log_name=algo
                    )
                checkpoints.evaluate()
            except KeyboardInterrupt:
                checkpoints.keep()
                if learner.num_timesteps and not evaluations.results:
                    evaluations.keep(learner.num_timesteps, network_of(learner))
                raise
            except ValueError:  # torch raises it if numbers of the network are not finite
                check_finite(learner)
                raise
    write_report_of(run, learner.num_timesteps, evaluations, algo)
    for sentence in advice(run.card, evaluations.results):
        messages.print(f"note: {sentence}")
    return learner.num_timesteps


class _PlateauError(Exception):
    """The evaluations have stopped improving, so the training ends."""


class _Checkpoints(BaseCallback):
    """Saves the learner ten times during a training, and evaluates its policy.

    A finished run that is resumed continues even if its evaluations had stopped improving.
    """

    def __init__(self, run: Run, learner: Any, evaluations: Evaluations, *, going_on: bool) -> None:
        super().__init__()
        self._run, self._learner, self._evaluations = run, learner, evaluations
        self._every = max(1, run.card.training["steps"] // CHECKPOINTS)
        self._kept = self._evaluated = learner.num_timesteps
        if evaluations.wanted:
            self._evaluated = evaluations.last  # an interrupted evaluation is repeated
        self._ends = evaluations.stagnant and not going_on

    def _on_rollout_start(self) -> None:
        if self._learner.num_timesteps // self._every > self._evaluated // self._every:
            self.evaluate()
        if self._ends:
            raise _PlateauError
        draw_anew(self._learner, self._run.card.training["seed"])

    def _on_step(self) -> bool:
        return True

    def keep(self) -> None:
        """Writes a checkpoint, from which the training can be resumed."""
        check_finite(self._learner)
        if self._kept != self._learner.num_timesteps:
            self._run.write({CHECKPOINT: partial(save_learner, self._learner)})
            self._kept = self._learner.num_timesteps

    def evaluate(self) -> None:
        """Writes a checkpoint, evaluates its policy, and saves the policy if it is the best."""
        self.keep()
        steps = self._learner.num_timesteps
        if steps == self._evaluated and self._evaluations.wanted:
            return
        result = self._evaluations.add(steps, network_of(self._learner))
        self._evaluated = steps
        if result is None:
            return
        self._ends = self._evaluations.stagnant
        numbers = {name: one for name, one in result.items() if isinstance(one, float)}
        numbers |= {f"relief_{part}": one for part, one in (result["relief"] or {}).items()}
        for name, number in numbers.items():
            self.logger.record(f"adapted/{name}", number)
        self.logger.dump(steps)


class _Progress(BaseCallback):
    """Moves the progress bar, logs the costs of episodes, and warns of a negative reward."""

    def __init__(self, bar: Bar, *, new: bool) -> None:
        super().__init__()
        self._bar, self._judges, self._rewards = bar, new, 0.0

    def _on_step(self) -> bool:
        self._bar.move_to(self.num_timesteps)
        self._rewards += self.locals["rewards"].sum()
        for info in self.locals["infos"]:
            for name, cost in info.get("episode_costs", {}).items():
                self.logger.record_mean(f"arm/{name}", cost)
        return True

    def _on_rollout_end(self) -> None:
        if not self._judges or self.num_timesteps < JUDGED:
            return
        self._judges = False
        reward = float(self._rewards) / self.num_timesteps
        if reward < 0:
            messages.print(
                f"note: the mean reward begins at {reward:.2g}, and an episode that ends early has "
                "no more of it, so that it may pay to lose the arm: keep the reward above 0, as "
                "the shipped one is"
            )
