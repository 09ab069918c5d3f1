"""Remakes the shipped curves and suits: `python -m activesuit.tools.make_assets`.

The paper's measurements are not public. The curves are therefore synthetic: responses of the
published parameters (Table 2, SA-PSO) along the paper's first-order transition curves, plus noise.
"""

import argparse
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..assets import CURVES, FOLDER, Suit, SuitJoint
from ..benchmarks.honesty.truths import multi_order_motion
from ..hysteresis import TABLE_2, JilesAtherton, nearest_certified
from ..identification import (
    Curves,
    bare,
    first_order_motions,
    fit_curves,
    load_curves,
    measure,
    save_curves,
)
from ..published import LI_LOWEST, LI_TURNS

SOURCE = "Li et al. 2022, Int. J. Aerospace Eng. 7535450, Table 2, SA-PSO"
# Section 5.3: the turns of the curves that the identified models predict [rad].
PREDICTED_TURNS = {"shoulder": (0.70, 1.05), "elbow": (1.05, 1.40)}
PUBLISHED = {joint: TABLE_2[f"{joint}-sa-pso"] for joint in ("shoulder", "elbow")}
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
NO_PRESSURE = "The paper does not print its pressure."

# The EMU's arm alone, measured by Holschuh 2010 (thesis, MIT): its plots of elbow torque run from
# 25 to 105 degrees and up to 20 N·m. That elbow bends to 115 degrees. All else here is assumed.
EMU_PRESSURE = 29.6  # kPa
EMU_ELBOW = (math.radians(105), 17.5)  # rad, N·m
EMU_WRIST = (math.radians(40), 3.0)  # rad, N·m: the most that wrists are said to need
EMU_RANGES = {
    "shoulder_abduction": (0.0, 1.22),
    "shoulder_flexion": (0.0, 1.57),
    "elbow_flexion": (0.0, 2.0),
    "wrist_flexion": (-0.7, 0.7),
}
EXPLORATION_PRESSURE = 56.5  # kPa, 8.2 psi


def curve_family(joint: str, rng: np.random.Generator) -> Curves:
    """Returns the noisy first-order transition curves of "shoulder" or "elbow"."""
    return measure(
        PUBLISHED[joint],
        first_order_motions(LI_TURNS[joint], start_angle=LI_LOWEST[joint], angle_step=ANGLE_STEP),
        rng=rng,
        noise_fraction=NOISE,
        predict=[f"{turn:.2f}" for turn in PREDICTED_TURNS[joint]],
    )


def multi_order_family(joint: str, rng: np.random.Generator) -> Curves:
    """Returns noisy random motions that turn more than once, all with the role "predict"."""
    low, high = LI_LOWEST[joint], LI_TURNS[joint][-1]
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
    return Curves(measured[len(widest) :])


def assumed_joints(models: dict[str, JilesAtherton]) -> dict[str, SuitJoint]:
    """Returns the entries of the joints without published data, scaled from known ones.

    Their ranges are assumptions too, so the identified suit takes models safe at all angles.
    """
    return {
        joint: SuitJoint.from_model(
            models[known].scaled(torque=factor),
            range=span,
            start_angle=0.0,
            grade="assumed",
            source=reason,
        )
        for joint, (known, factor, span, reason) in ASSUMED.items()
    }


GAS_SHARE = 0.9  # share of the elastic torque that the displaced gas causes
GAS = (
    "volume_share assumed: the effect of volume dominates in an EMU's elbow (Holschuh 2010, MIT), "
    "and friction is taken to be the same at all pressures"
)


def emu_like(models: dict[str, JilesAtherton]) -> Suit:
    """Returns the loops of the mock suit with torques of the size of a pressurized suit's.

    Args:
        models: Models of "shoulder" and "elbow", certified at all angles: the torque goes on rising
            when an arm bends further than the mock suit did.
    """
    factor = EMU_ELBOW[1] / _torque_at(models["elbow"], LI_LOWEST["elbow"], EMU_ELBOW[0])
    aside = ASSUMED["shoulder_abduction"][1]
    wrist = EMU_WRIST[1] / _torque_at(models["elbow"], 0.0, EMU_WRIST[0])
    target = f"{EMU_ELBOW[1]:g} N·m at {math.degrees(EMU_ELBOW[0]):.0f} degrees"
    wrist_target = f"{EMU_WRIST[1]:g} N·m at {math.degrees(EMU_WRIST[0]):.0f} degrees"
    joints = {
        "shoulder_abduction": ("shoulder", 0.0, aside * factor, f"{aside:g} of flexion's"),
        "shoulder_flexion": ("shoulder", LI_LOWEST["shoulder"], factor, "the elbow's factor"),
        "elbow_flexion": ("elbow", LI_LOWEST["elbow"], factor, f"{target} when first bent"),
        "wrist_flexion": ("elbow", 0.0, wrist, f"{wrist_target}, as wrists are said to need"),
    }
    return Suit(
        name="emu-like",
        description="Of the size of a pressurized suit such as the EMU, but no real suit's: the "
        f"loops of mock-suit, scaled until the elbow resists {target} (Holschuh 2010, MIT: up "
        "to 20 N·m). Shoulder and abduction take the elbow's factor, the wrist gets "
        f"{wrist_target}. Trust the size of the elbow's torque, hardly its course, and the other "
        "joints less.",
        label="illustrative",
        pressure_kpa=EMU_PRESSURE,
        joints={
            joint: SuitJoint.from_model(
                models[known].scaled(torque=scale),
                range=EMU_RANGES[joint],
                start_angle=start,
                grade="assumed",
                source=f"assumed: the mock suit's {known} model, certified at all angles, "
                f"{scale:.3g} times its torque: {reason}; {GAS}",
            ).model_copy(update={"volume_share": GAS_SHARE})
            for joint, (known, start, scale, reason) in joints.items()
        },
    )


def exploration(emu: Suit) -> Suit:
    """Returns `emu` at the pressure that is assumed for exploration suits."""
    suit = emu.at_pressure(EXPLORATION_PRESSURE)
    return suit.model_copy(update={"name": "exploration-56kpa"})


def _torque_at(model: JilesAtherton, start: float, angle: float) -> float:
    """Returns the resistance [N·m] at `angle` when first bent from `start` [rad]."""
    return float(model.response([start, angle])[-1])


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
                    "Made by: python -m activesuit.tools.make_assets",
                ),
            )
        published[joint] = SuitJoint.from_model(
            PUBLISHED[name],
            range=(LI_LOWEST[name], LI_TURNS[name][-1]),
            start_angle=LI_LOWEST[name],
            grade="published",
            source=SOURCE,
        )
        measured = load_curves(path)
        whole = Curves(
            (replace(curve, role="fit") for curve in measured),
            source=measured.source,
            sha256=measured.sha256,
        )
        fit = fit_curves(whole, method="certified", seed=SEED)
        fits[name] = nearest_certified(bare(fit.model)).model
        entry = SuitJoint.from_fit(fit)
        identified[joint] = entry.model_copy(update={"source": f"{entry.source} {LABEL}"})
    published_suit = Suit(
        name="published-2022",
        description=f"{SOURCE}, as printed. The shoulder is not certified: outside 0.35-1.22 rad "
        f"it can meet infinite torque. Abduction and wrist are assumptions. {NO_PRESSURE}",
        label="from paper",
        joints=published | assumed_joints(PUBLISHED),
    )
    mock_suit = Suit(
        name="mock-suit",
        description="The mock spacesuit of Li et al. 2022, re-identified with certified models "
        f"over each joint's whole range. {LABEL} Abduction and wrist are assumptions. "
        f"{NO_PRESSURE}",
        label="from paper",
        joints=identified | assumed_joints(fits),
    )
    emu = emu_like(fits)
    (folder / "suits").mkdir(exist_ok=True)
    for suit in (published_suit, mock_suit, emu, exploration(emu)):
        suit.save(folder / "suits" / f"{suit.name}.json")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder to write into")
    main(parser.parse_args().out)
