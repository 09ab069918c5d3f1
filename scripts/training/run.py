"""One training: from a card to a learner that has done all steps, or was stopped."""

from contextlib import closing, suppress
from pathlib import Path
from typing import Any

from ...assets import load_suit, suit_names
from ...envs.policies.network import CARD, WEIGHTS, Card, Network, card_file, files_of, read_card
from ...envs.policies.trained import OWN_SUIT
from ...errors import InputError
from ..html.writing import PAGE
from ..output import Bar, RunFolder, messages, progress
from ..reports.learning import learning_figure
from .checkpoints import (
    CHECKPOINT,
    Checkpoint,
    begin_as_before,
    note_missing,
    resumed_learner,
    save,
    write_own,
)
from .evaluations import EVALUATIONS, Evaluations, finished, nothing_left, relief_text
from .learners import (
    check_finite,
    new_learner,
    threads,
    training_environments,
    training_seeds,
)
from .page import advice, write_training_page

CHECKPOINTS = 10  # number per run
JUDGED = 200  # control periods after which the reward of a new training is judged
TRAINING_ONLY = ("reward", "randomize", "control")  # options that evaluations are without
RENEWED = ("steps", "patience")  # what may be new in a resume


def learn(
    folder: RunFolder,
    card: Card,
    options: dict[str, Any],
    checkpoint: Checkpoint | None,
    torch_threads: int,
) -> int:
    """Trains until all steps are done; returns how many were done.

    Args:
        folder: Folder of the run.
        card: Card of the policy, whose `training` has all that describes the training.
        options: Options of the environment.
        checkpoint: Checkpoint from which the training continues; None begins anew.
        torch_threads: Number of threads of torch.
    """
    env, training = card.environment["env"], card.training
    algo, seed, steps = training["algo"], training["seed"], training["steps"]
    own = {name: training[name] for name in TRAINING_ONLY if name in training}
    with (
        threads(torch_threads),
        closing(
            training_environments(env, training["rows"], {**options, **own}, card.residual)
        ) as environments,
    ):
        if checkpoint:
            learner = resumed_learner(algo, environments, checkpoint)
        else:
            learner = new_learner(algo, environments, folder, seed, training["hyperparameters"])
        environments.seed(training_seeds(seed, training["rows"]))  # the learner has set its own
        done = learner.num_timesteps
        if done >= steps and nothing_left(folder.path, steps):
            raise InputError(f"the run has {done} steps already: give --steps above that to go on")
        had_ended = finished(folder.path)
        card = begin(folder, card, resume=bool(checkpoint))
        run = _Run(learner, folder, card, options, had_ended=had_ended)
        interrupted = False
        with progress(f"{algo} on {env}", steps) as bar:
            try:
                with suppress(_PlateauError):
                    learner.learn(
                        steps - done,
                        callback=_callback(run, bar),
                        reset_num_timesteps=not checkpoint,
                        tb_log_name=algo,
                    )
            except KeyboardInterrupt:
                interrupted = True
            except ValueError:  # of torch, if the numbers of the network are not finite
                check_finite(learner)
                raise
            run.checkpoint(evaluate=not interrupted)
    if interrupted:
        raise KeyboardInterrupt(
            f"{learner.num_timesteps} steps are kept in {folder.path}; go on with --resume"
        )
    end(folder, card, learner.num_timesteps, run.evaluations, algo)
    for sentence in advice(card, run.evaluations.results):
        messages.print(f"note: {sentence}")
    return learner.num_timesteps


class _PlateauError(Exception):
    """The training ends, as its evaluations are no better any more."""


class _Run:
    """What happens between updates of a learner: checkpoints, and evaluations at each.

    Args:
        learner: The learner.
        folder: Folder of the run.
        card: Card of the policy.
        options: Options of the environment.
        had_ended: Whether the training had come to an end, perhaps on a plateau, and goes on.
    """

    def __init__(
        self,
        learner: Any,
        folder: RunFolder,
        card: Card,
        options: dict[str, Any],
        *,
        had_ended: bool,
    ) -> None:
        self._learner, self._folder, self._card = learner, folder, card
        done = learner.num_timesteps
        self.evaluations = Evaluations(folder, card, options, done)
        self._every = max(1, card.training["steps"] // CHECKPOINTS)
        results, wanted = self.evaluations.results, self.evaluations.wanted
        self._evaluated = results[-1]["steps"] if results else 0  # steps at the last evaluation
        self._kept = done if done else -1  # steps of the last checkpoint
        last = self._evaluated if wanted else done  # an evaluation that was stopped is still due
        self._next = self._every * (last // self._every + 1)
        self._plateau = not had_ended and self._stagnant()
        self.resumed = done > 0  # until the next rollout begins
        self._begun = False  # whether a rollout has begun, and no step of it is done

    def between_updates(self) -> None:
        """Makes a checkpoint where one is due.

        Raises:
            _PlateauError: The training is to end.
        """
        if self.resumed:
            begin_as_before(self._learner)
            self.resumed = False
        self._begun = True
        if self._learner.num_timesteps >= self._next:
            self._next += self._every
            self.checkpoint()
        if self._plateau:
            raise _PlateauError

    def stepped(self) -> None:
        """Notes that a step of the rollout is done."""
        self._begun = False

    def checkpoint(self, *, evaluate: bool = True) -> None:
        """Evaluates the policy, and keeps the learner and the best policy so far.

        Args:
            evaluate: Whether to evaluate.
        """
        from ...envs.policies.saving import network_of

        check_finite(self._learner)
        network, steps = network_of(self._learner), int(self._learner.num_timesteps)
        noted = steps == self._kept or save(self._learner, self._folder, begun=self._begun)
        self._kept = steps
        evaluations = self.evaluations
        if not evaluations.wanted or not (evaluations.results or evaluate):
            noted &= self._keep(network, steps, None)
        elif evaluate and steps > self._evaluated:
            self._evaluated = steps
            result = evaluations.add(steps, network)
            self._tell(result)
            if evaluations.last_is_best:
                noted &= self._keep(network, steps, result)
            evaluations.write()  # the last file: without it, the evaluation is done again
            self._plateau = self._stagnant()
        note_missing(noted)

    def _stagnant(self) -> bool:
        patience = self._card.training.get("patience")
        return bool(patience) and self.evaluations.stagnant(patience)

    def _keep(self, network: Network, steps: int, scores: dict[str, Any] | None) -> bool:
        training = {**self._card.training, "done": steps}
        card = self._card.model_copy(update={"training": training, "scores": scores})
        return write_own(self._folder, files_of(card, network))

    def _tell(self, result: dict[str, Any]) -> None:
        """Reports an evaluation, on the terminal and to TensorBoard."""
        messages.print(report(result))
        relief = result["relief"] or {}
        logger = self._learner.logger
        numbers = {name: one for name, one in result.items() if isinstance(one, float)}
        numbers |= {f"relief_{part}": one for part, one in relief.items()}
        for name, number in numbers.items():
            logger.record(f"adapted/{name}", number)
        logger.dump(result["steps"])


def report(result: dict[str, Any]) -> str:
    """Returns a line about an evaluation."""
    relief, text = result["relief"], "no relief, as the policy loses arms or the suit costs nothing"
    if relief is not None:
        text = f"relief {relief_text(relief)}"
    return f"{result['steps']} steps: {text}, success {result['success']:.0%}"


def judge(reward: float) -> None:
    """Says what follows where the mean reward of the first control periods is negative."""
    if reward < 0:
        messages.print(
            f"note: the mean reward begins at {reward:.2g}, and an episode that ends early has no "
            "more of it, so that it may pay to lose the arm: keep the reward above 0, as the "
            "shipped one is"
        )


def _callback(run: _Run, bar: Bar) -> Any:
    """Returns a callback that makes checkpoints, logs episodes and moves the progress bar."""
    from stable_baselines3.common.callbacks import BaseCallback

    class Between(BaseCallback):
        judged, rewards = run.resumed, 0.0

        def _on_rollout_start(self) -> None:  # between updates, so that a resume can be exact
            run.between_updates()

        def _on_step(self) -> bool:
            run.stepped()
            bar.move_to(self.num_timesteps)
            self.rewards += self.locals["rewards"].sum()
            for info in self.locals["infos"]:
                for name, cost in info.get("episode_costs", {}).items():
                    self.logger.record_mean(f"arm/{name}", cost)
            return True

        def _on_rollout_end(self) -> None:
            if not self.judged and self.num_timesteps >= JUDGED:
                self.judged = True
                judge(float(self.rewards) / self.num_timesteps)

    return Between()


def begin(folder: RunFolder, card: Card, *, resume: bool) -> Card:
    """Writes the card, and beside it a copy of the suit file if there is one; returns the card.

    In a resume the card of the policy that was kept gets what is new, which holds from now on. The
    report is removed, as it is the last file of a training that has ended.
    """
    for name in (PAGE,) if resume else (PAGE, CHECKPOINT, WEIGHTS, EVALUATIONS):
        folder.claim(name).unlink(missing_ok=True)
    suit = card.environment["suit"]
    if suit != "none" and suit not in suit_names():
        if Path(suit) != folder / OWN_SUIT:
            with folder.replacing(OWN_SUIT) as scratch:
                load_suit(suit).save(scratch)
        card = card.model_copy(update={"environment": {**card.environment, "suit": OWN_SUIT}})
    if not resume:
        write_own(folder, {CARD: card_file(card)})
        return card
    kept = read_card(folder.path)
    new = {name: one for name, one in card.training.items() if name in RENEWED}
    renewed = kept.model_copy(update={"training": {**kept.training, **new}})
    if renewed != kept:
        write_own(folder, {CARD: card_file(renewed)})
    return card


def end(folder: RunFolder, card: Card, done: int, evaluations: Evaluations, name: str) -> None:
    """Writes the figure of a training, notes that it has ended, and writes its report.

    Args:
        folder: Folder of the run.
        card: Card of the policy.
        done: Steps of the training.
        evaluations: Its evaluations.
        name: Name of the learning curve.
    """
    if evaluations.wanted:
        folder.figure("learning_curve", learning_figure({name: evaluations.results}))
    evaluations.finish()
    write_training_page(folder, card, done, evaluations.results)
