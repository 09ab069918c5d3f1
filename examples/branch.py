"""What the next second of a motion would be under each of some policies.

From one and the same state of 20 arms, two seconds after their start, the next second goes on under
each policy in turn, with the same past, intention, wearer and noise. The wearers are unadapted, the
suit is `emu-like`, and there is no gravity.

Effort is the root mean square of the wearer's torque over strength. Regret is the effort less that
under the best known plan, motion by motion, with its 95 % interval; it can be below 0, since that
plan is of the whole motion. The error is the root mean square of the actual less the intended
angles. The figure shows the first of the motions, and the regret in all.

Policies with a model of the suit leave little regret in the next second, too.
[Controllers and scores](../../controllers.md) explains policies and effort.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import tyro
from activesuit.arrays import Array
from activesuit.assets import JOINTS
from activesuit.envs.evaluation import FIRST_SEED, Interval
from activesuit.envs.evaluation.best_known_plan import clairvoyant
from activesuit.envs.evaluation.statistics import mean_interval
from activesuit.envs.evaluation.wearers import Wearers
from activesuit.envs.model import ASSISTED
from activesuit.envs.policies import Policy, make_policy, needed_options
from activesuit.envs.simulation.measurements import COLUMNS
from activesuit.envs.vector_env import ArmVectorEnv
from matplotlib.figure import Figure

PLAN = "best-known-plan"
SHOWN = 0.5  # [s], time that the figure shows before the branches


def main(
    task: str = "ArmTracking",
    base: str = "feedforward",
    policies: tuple[str, ...] = ("none", "transparent", "feedforward", "compensation"),
    at: float = 2.0,
    horizon: float = 1.0,
    motions: int = 20,
    quick: bool = False,
) -> None:
    """Compares the next second of the same motions under policies.

    Args:
        task: Task of the wearers.
        base: Policy up to the branch point.
        policies: Policies from there on.
        at: Time of the branch point [s].
        horizon: Duration of a branch [s].
        motions: Number of motions, at least 8.
        quick: Few motions of a short task, to see that the program runs.
    """
    if quick:
        task, motions = "ElbowFlexion", 8
    suites = [name for one in (base, *policies) for name in needed_options(one).get("sensors", ())]
    wearers = Wearers(
        f"ActiveSuit/{task}-v0",
        motions,
        suit="emu-like",
        gravity="microgravity",
        sensors=list(dict.fromkeys(suites)) or ["encoders"],
        normalize=False,
    )
    arms, seeds = wearers.arms, range(FIRST_SEED, FIRST_SEED + motions)
    made = {name: make_policy(name, arms) for name in policies}
    made[PLAN] = clairvoyant(wearers, seeds)
    seen, past = moved(arms, make_policy(base, arms), seeds, round(at / arms.control_dt))
    state, futures = arms.get_state(), {}
    for name, policy in made.items():
        arms.set_state(state)
        futures[name] = branch(arms, policy, seen, round(horizon / arms.control_dt))
    best = effort(futures[PLAN])
    regrets = {name: mean_interval(effort(future) - best) for name, future in futures.items()}
    wearers.close()
    print(f"{task}, {motions} motions, after {at:g} s of {base}, for {horizon:g} s\n")
    show(futures, regrets)
    drawn(past[at - past[:, 0, 0] <= SHOWN], futures, regrets).savefig("branch.png", dpi=150)


def moved(
    arms: ArmVectorEnv, policy: Policy, seeds: Sequence[int], periods: int
) -> tuple[list[Any], Array]:
    """Moves the arms under a policy; returns all observations, and measurements over time."""
    observation, _ = arms.reset(seed=list(seeds))
    policy.reset()
    seen, measured = [observation], []
    for _ in range(periods):
        observation, _, lost, _, _ = arms.step(policy.act(observation))
        assert not lost.any(), "the base policy loses an arm before the branch point"
        seen.append(observation)
        measured.append(arms.measured())
    return seen, np.array(measured)


def branch(arms: ArmVectorEnv, policy: Policy, seen: Sequence[Any], periods: int) -> Array:
    """Moves the arms on under a policy that has watched their past; returns the measurements."""
    policy.reset()
    for observation in seen[:-1]:
        policy.act(observation)
    observation, measured = seen[-1], []
    for _ in range(periods):
        observation, _, lost, over, _ = arms.step(policy.act(observation))
        measured.append(arms.measured())
        assert not lost.any(), "a policy loses an arm: branch elsewhere"
        assert len(measured) == periods or not over.any(), "the motion ends before the branch"
    return np.array(measured)


def effort(measured: Array) -> Array:
    """Returns the root mean square over time and joints of torque over strength, by motion."""
    return np.sqrt(np.mean(measured[:, :, COLUMNS["effort"]] ** 2, axis=(0, 2)))


def show(futures: dict[str, Array], regrets: dict[str, Interval]) -> None:
    """Prints a row for each policy."""
    print(f"{'':18}effort  {'regret':24}human torque [N·m]    error")
    print(f"{'policy':18}{'[%]':8}{'[%]':24}{'shoulder, elbow':22}[mrad]")
    for name, future in futures.items():
        regret, error = regrets[name], future[:, :, COLUMNS["angle"]]
        error = np.sqrt(np.mean((error - future[:, :, COLUMNS["target_angle"]]) ** 2))
        torque = np.sqrt(np.mean(future[:, :, COLUMNS["human_torque"]] ** 2, axis=(0, 1)))
        both = ", ".join(f"{torque[JOINTS.index(joint)]:.2f}" for joint in ASSISTED)
        print(f"{name:18}{100 * effort(future).mean():<8.1f}{percent(regret):24}{both:22}", end="")
        print(f"{1e3 * error:.0f}")


def percent(one: Interval) -> str:
    """Returns an interval in percent."""
    return f"{100 * one.value:.1f} ({100 * one.low:.1f} to {100 * one.high:.1f})"


def drawn(past: Array, futures: dict[str, Array], regrets: dict[str, Interval]) -> Figure:
    """Draws torques of the first motion, its past in gray, and the regret in all motions."""
    figure = Figure(figsize=(9, 8), layout="constrained")
    grid = figure.subplots(3, 2)
    for axes, of in zip(grid, ("human_torque", "assist_torque"), strict=False):
        axes[0].set_ylabel(f"{of.replace('_', ' ')} [N·m]")
        for i, (ax, joint) in enumerate(zip(axes, ASSISTED, strict=True)):
            column = COLUMNS[of].start + (JOINTS.index(joint) if of == "human_torque" else i)
            ax.set_title(joint.replace("_", " "), loc="left", fontsize=10)
            for color, (name, future) in enumerate(futures.items()):
                ax.plot(future[:, 0, 0], future[:, 0, column], color=f"C{color}", label=name)
            ax.plot(past[:, 0, 0], past[:, 0, column], color="0.5", label="past")
            ax.set_xlabel("time [s]")
            ax.grid(alpha=0.3)
    for ax in grid[2]:
        ax.remove()
    ax = figure.add_subplot(grid[2, 0].get_gridspec()[2, :])
    for place, (name, regret) in enumerate(regrets.items()):
        low, middle, high = 100 * regret.low, 100 * regret.value, 100 * regret.high
        ends = [[middle - low], [high - middle]]
        ax.errorbar(place, middle, ends, fmt="o", capsize=4, color=f"C{place}", label=name)
    ax.set_xticks(range(len(regrets)), list(regrets))
    ax.set_ylabel("regret [% of strength]")
    ax.grid(axis="y", alpha=0.3)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return figure


if __name__ == "__main__":
    tyro.cli(main)
