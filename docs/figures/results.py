"""Relief by place, in two suits, rigid and on cuffs, from the kept results of the docs."""

import matplotlib.pyplot as plt
from activesuit.tools.results import PLACES, settings

POLICIES = {"none": "0.5", "feedforward": "C1", "compensation": "C0", "best-known-plan": "k"}
PANELS = [(suit, how) for suit in ("mock-suit", "emu-like") for how in ("rigid", "cuffs")]
figure, axes = plt.subplots(2, 2, figsize=(7, 5.6), sharex=True, sharey=True, layout="constrained")
for ax, (suit, coupling) in zip(axes.flat, PANELS, strict=True):
    for name, color in POLICIES.items():
        found = [settings()[place, suit, coupling]["scores"][name]["relief"] for place in PLACES]
        middle = [one["value"] for one in found]
        low = [one["value"] - one["low"] for one in found]
        high = [one["high"] - one["value"] for one in found]
        places = list(PLACES.values())
        ax.errorbar(places, middle, (low, high), color=color, marker="o", ms=5, label=name)
    for relief in (0, 1):
        ax.axhline(relief, color="0.8", lw=0.8, zorder=0)
    ax.set_title(f"{suit}, {coupling}")
    ax.spines[["top", "right"]].set_visible(False)
for ax in axes[:, 0]:
    ax.set_ylabel("relief")
lines = axes[0, 0].get_legend_handles_labels()
figure.legend(*lines, loc="outside upper center", ncols=4, frameon=False)
figure.savefig("results.png", dpi=130)
