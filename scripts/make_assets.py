"""Remakes the shipped curves and suits: `python -m activesuit.scripts.make_assets`.

The paper's measurements are not public. The curves are therefore synthetic: responses of the
published parameters (Table 2, SA-PSO) along the paper's first-order transition curves, plus noise.
"""

import argparse
from pathlib import Path

import numpy as np

from ..assets import CURVES, FOLDER, Suit, SuitJoint, save_suit
from ..hysteresis import TABLE_2, JilesAtherton, nearest_certified
from ..identification import (
    Curve,
    bare,
    first_order_motions,
    identify,
    load_curves,
    measure,
    multi_order_motion,
    save_curves,
)
from .suit_export import fitted_joint, suit_joint

SOURCE = "Li et al. 2022, Int. J. Aerospace Eng. 7535450, Table 2, SA-PSO"
PUBLISHED = {joint: TABLE_2[f"{joint}-sa-pso"] for joint in ("shoulder", "elbow")}
LOWEST = {"shoulder": 0.35, "elbow": 0.52}  # rad, sections 3.1 and 5.1
TURNS = {"shoulder": (0.52, 0.70, 0.87, 1.05, 1.22), "elbow": (0.87, 1.05, 1.22, 1.40, 1.57)}
PREDICTED = {"shoulder": (0.70, 1.05), "elbow": (1.05, 1.40)}  # section 5.3
MOTIONS, REVERSALS = 3, 8  # random motions that turn more than once, within the fitted range
ANGLE_STEP = 0.004  # rad between samples: 785 and 1051 samples in the fitted curves
NOISE = 0.01  # standard deviation, as a fraction of the family's largest torque
SEED = 2022

# Nothing is published for these two; the factors scale the torque of a known joint.
ASSUMED = {
    "shoulder_abduction": (
        "shoulder",
        0.8,
        (0.0, 1.22),
        "assumed: the shoulder flexion model, 0.8 times its torque: the same fabric section bends "
        "about the orthogonal axis, with a little less material on the outside",
    ),
    "wrist_flexion": (
        "elbow",
        0.4,
        (-0.7, 0.7),
        "assumed: the elbow model, 0.4 times its torque, which gives 1.7 N·m at 40 degrees, "
        "inside the 1-3 N·m that spacesuit wrists are said to need",
    ),
}
LABEL = "SYNTHETIC: generated from the published parameters, not measured."


def curve_family(joint: str, rng: np.random.Generator) -> list[Curve]:
    """Returns the noisy first-order transition curves of "shoulder" or "elbow"."""
    return measure(
        PUBLISHED[joint],
        first_order_motions(TURNS[joint], start_angle=LOWEST[joint], angle_step=ANGLE_STEP),
        rng=rng,
        noise_fraction=NOISE,
        predict=[f"{turn:.2f}" for turn in PREDICTED[joint]],
    )


def multi_order_family(joint: str, rng: np.random.Generator) -> list[Curve]:
    """Returns noisy random motions that turn more than once, all with the role "predict"."""
    low, high = LOWEST[joint], TURNS[joint][-1]
    motions = {
        f"multi-order {i + 1}": multi_order_motion(
            low, high, turns=REVERSALS, angle_step=ANGLE_STEP, rng=rng
        )
        for i in range(MOTIONS)
    }
    # The noise is that of the family, a fraction of the torque of its widest curve.
    widest = first_order_motions([high], start_angle=low, angle_step=ANGLE_STEP)
    measured = measure(
        PUBLISHED[joint], widest | motions, rng=rng, noise_fraction=NOISE, predict=motions
    )
    return measured[len(widest) :]


def assumed_joints(models: dict[str, JilesAtherton]) -> dict[str, SuitJoint]:
    """Returns the entries of the joints without published data, scaled from known ones.

    Their ranges are assumptions too, so the identified suit takes models safe at all angles.
    """
    return {
        joint: suit_joint(
            models[known].scaled(torque=factor),
            range=span,
            start_angle=0.0,
            grade="assumed",
            source=reason,
        )
        for joint, (known, factor, span, reason) in ASSUMED.items()
    }


def main(folder: Path = FOLDER) -> None:
    """Writes curves and suits into `folder`."""
    rng = np.random.default_rng(SEED)
    published, identified, fits = {}, {}, {}
    for name, joint in CURVES.items():
        path = folder / "curves" / f"{name}.csv"
        path.parent.mkdir(parents=True, exist_ok=True)
        family, motions = curve_family(name, rng), multi_order_family(name, rng.spawn(1)[0])
        for file, curves, kind in (
            (path, family, "First-order transition curves"),
            (path.with_stem(f"{name}_multi_order"), motions, "Motions that turn more than once"),
        ):
            save_curves(
                file,
                curves,
                comments=(
                    f"{kind} of the {name}. {LABEL}",
                    f"Parameters: {SOURCE}; noise: {NOISE:.0%} of the largest torque, seed {SEED}.",
                    "Made by: python -m activesuit.scripts.make_assets",
                ),
            )
        published[joint] = suit_joint(
            PUBLISHED[name],
            range=(LOWEST[name], TURNS[name][-1]),
            start_angle=LOWEST[name],
            grade="published",
            source=SOURCE,
        )
        whole = [Curve(curve.angle, curve.torque, curve.name) for curve in load_curves(path)]
        fit = identify(whole, method="certified", seed=SEED)
        fits[name] = nearest_certified(bare(fit.model)).model
        identified[joint] = fitted_joint(fit, whole, path, LABEL)
    (folder / "suits").mkdir(exist_ok=True)
    save_suit(
        Suit(
            name="published-2022",
            description=f"{SOURCE}, as printed. The shoulder is not certified: outside 0.35-1.22 "
            "rad it can meet infinite torque. Abduction and wrist are assumptions.",
            joints=published | assumed_joints(PUBLISHED),
        ),
        folder / "suits" / "published-2022.json",
    )
    save_suit(
        Suit(
            name="mock-suit",
            description="The mock spacesuit of Li et al. 2022, re-identified with certified models "
            f"over each joint's whole range. {LABEL} Abduction and wrist are assumptions.",
            joints=identified | assumed_joints(fits),
        ),
        folder / "suits" / "mock-suit.json",
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder to write into")
    main(parser.parse_args().out)
