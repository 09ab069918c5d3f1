"""Relief by place, in two suits, rigid and on cuffs, from the kept results of the docs."""

import matplotlib.pyplot as plt
from activesuit.tools.results import PLACES, settings

POLICIES = {"none": "0.6", "feedforward": "C1", "compensation": "C0", "best-known-plan": "k"}
figure, axes = plt.subplots(1, 4, figsize=(11, 3.2), sharey=True, layout="constrained")
panels = [(suit, how) for suit in ("mock-suit", "emu-like") for how in ("rigid", "cuffs")]
for ax, (suit, coupling) in zip(axes, panels, strict=True):
    for name, color in POLICIES.items():
        found = [settings()[place, suit, coupling]["scores"][name]["relief"] for place in PLACES]
        middle = [one["value"] for one in found]
        low = [one["value"] - one["low"] for one in found]
        high = [one["high"] - one["value"] for one in found]
        places = list(PLACES.values())
        ax.errorbar(places, middle, (low, high), color=color, marker="o", ms=4, label=name)
    ax.axhline(0, color="0.8", lw=0.8, zorder=0)
    ax.axhline(1, color="0.8", lw=0.8, zorder=0)
    ax.set_title(f"{suit}, {coupling}", fontsize=10)
    ax.tick_params(axis="x", labelrotation=30)
    ax.spines[["top", "right"]].set_visible(False)
axes[0].set_ylabel("relief")
figure.legend(
    *axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=4, frameon=False
)
figure.savefig("results.png", dpi=130)
