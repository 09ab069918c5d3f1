"""What are five textbook controllers worth in a spacesuit?

Five laws of exoskeletons for rehabilitation and factories, which know no suit, are classes of their
own in `examples/controllers`; each file has law, tuning rule and source. Beside them are the
shipped `none`, motors off, and `compensation`, which knows the suit and all weights.

- `amplification.py`: amplifies the torque that the person gives to the suit (Kazerooni 1990).
- `proportional.py`: gives half of the wearer's voluntary torque (Lenzi et al. 2012).
- `oscillators.py`: compensates the angle that adaptive oscillators predict (Ronsse et al. 2011).
- `radial_basis.py`: pulls to the intention, with a network that learns (Li, Dai and Tang 2021).
- `admittance.py`: a virtual mass that the cuffs' forces push (Keemink et al. 2018).

Relief is the share of the suit's cost in effort that a controller gives back to an adapted wearer,
over eight motions of arm tracking; *a rhythm* is `Scoop`. At *wrong belief* the wearer has the
EMU-like suit at 40 kPa on Mars, and controllers believe in the mock suit. *A rhythm* and *on cuffs*
are weightless in the EMU-like suit. The error is that of tracking.

None of the first four comes near compensation with the right belief. On cuffs `admittance` has the
most relief, but carries no weight except the exoskeleton's. In a clone of the repository each is a
policy by the name of its class:

```bash
activesuit evaluate --policies compensation examples.controllers.proportional:ProportionalAssist
```
"""

import numpy as np
import tyro
from activesuit.envs.evaluation import FIRST_SEED, Evaluation, evaluate
from matplotlib.figure import Figure

OWN = {  # as `--policies` takes them, with "examples." before, from the root of the repository
    "amplification": "controllers.amplification:ForceAmplification",
    "proportional": "controllers.proportional:ProportionalAssist",
    "oscillators": "controllers.oscillators:AdaptiveOscillators",
    "radial-basis": "controllers.radial_basis:RadialBasisTracker",
    "admittance": "controllers.admittance:Admittance",
}
BESIDE = {"none": "none", "compensation": "compensation"}
BELIEVE = ("compensation", "oscillators", "radial-basis", "admittance")
STIFF = {"suit": "emu-like", "gravity": "microgravity"}
RIGID = ("amplification", "proportional", "oscillators", "radial-basis")
SETTINGS = {  # title: task, options of the environment, own controllers
    "Earth, mock suit": ("ArmTracking", {}, RIGID),
    "weightless, EMU-like": ("ArmTracking", STIFF, RIGID),
    "wrong belief": ("ArmTracking", {"level": "shift"}, RIGID),
    "a rhythm": ("Scoop", STIFF, ("oscillators",)),
    "on cuffs": ("ArmTracking", {**STIFF, "coupling": "cuffs"}, ("admittance",)),
}


def named(names: tuple[str, ...], wrong: bool) -> dict[str, str]:
    """Returns policies by their names; those that believe in a suit get the mock suit if wrong."""
    given = {**BESIDE, **{name: OWN[name] for name in names}}
    return {
        name: f"{policy}:suit=mock-suit" if wrong and name in BELIEVE else policy
        for name, policy in given.items()
    }


def report(title: str, names: tuple[str, ...], found: Evaluation) -> None:
    print(f"{title:<22}{'relief (95 % interval)':>24}{'success':>9}{'error [mrad]':>14}")
    for name in (*BESIDE, *names):
        score, relief = found.scores[name], found.relief(name)
        assert relief is not None  # in these settings the suit costs effort
        interval = f"{relief.value:.2f} ({relief.low:.2f} to {relief.high:.2f})"
        success, error = f"{np.mean(score.success):.0%}", 1e3 * np.mean(score.tracking)
        print(f"  {name:<20}{interval:>24}{success:>9}{error:>14.1f}")
    print()


def draw(evaluations: dict[str, Evaluation]) -> Figure:
    figure = Figure(figsize=(10, 3.6), layout="constrained")
    names = [*BESIDE, *OWN]
    (axes,) = figure.subplots(1, len(evaluations), sharex=True, sharey=True, squeeze=False)
    for axis, (title, found) in zip(axes, evaluations.items(), strict=True):
        for row, name in enumerate(names):
            relief = found.relief(name) if name in found.scores else None
            if relief is not None:
                color = "C0" if name in OWN else "k"
                axis.plot([relief.low, relief.high], [row, row], color, lw=2)
                axis.plot(relief.value, row, f"{color}o", ms=6)
        axis.grid(color="0.9", lw=0.8)
        axis.set(title=title, xlabel="relief")
        axis.title.set_fontsize(10)
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].set_yticks(range(len(names)), names)
    axes[0].invert_yaxis()
    return figure


def main(quick: bool = False) -> None:
    """Evaluate five controllers that are no part of the package.

    Args:
        quick: The last setting alone.
    """
    evaluations = {}
    for title, (task, options, names) in list(SETTINGS.items())[-1 if quick else 0 :]:
        policies = named(names, wrong=options.get("level") == "shift")
        found = evaluate(f"ActiveSuit/{task}-v0", policies, motions=8, seed=FIRST_SEED, **options)
        report(title, names, found)
        evaluations[title] = found
    draw(evaluations).savefig("own_controllers.png", dpi=150)


if __name__ == "__main__":
    tyro.cli(main)
