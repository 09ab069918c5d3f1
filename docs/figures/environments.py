"""What happens in one control period of an environment, as blocks."""

import matplotlib.pyplot as plt

BLOCKS = {  # center of each block, and what it does
    "policy": (0.08, 0.70, "policy\nobservation to action"),
    "motors": (0.34, 0.70, "motors\nlag, friction, limits, heat"),
    "arm": (0.64, 0.70, "arm in the suit (MuJoCo)\nhysteresis at every physics step"),
    "sensors": (0.92, 0.70, "sensors\nnoise, delay, counts"),
    "task": (0.08, 0.15, "task\nintended motion, loads"),
    "wearer": (0.34, 0.15, "wearer\nfeed-forward, reflex, correction"),
}
ARROWS = [  # from, to, label, its place, bend of the arrow
    ("policy", "motors", "action", (0.2, 0.75), 0.0),
    ("motors", "arm", "assist torque", (0.482, 0.75), 0.0),
    ("arm", "sensors", "", (0, 0), 0.0),
    ("task", "wearer", "intention", (0.2, 0.2), 0.0),
    ("wearer", "arm", "human torque", (0.39, 0.46), -0.12),
    ("arm", "wearer", "angles, 50 ms late", (0.63, 0.32), -0.3),
    ("sensors", "policy", "observation, every 10 ms", (0.5, 1.12), 0.22),
]
figure, ax = plt.subplots(figsize=(11, 3.4), layout="constrained")
style = {"boxstyle": "round,pad=0.6", "facecolor": "#eef1fb", "edgecolor": "#4051b5"}
center = {"ha": "center", "va": "center"}
boxes = {
    name: ax.text(x, y, text, fontsize=9.5, bbox=style, **center).get_bbox_patch()
    for name, (x, y, text) in BLOCKS.items()
}
ax.set(xlim=(-0.02, 1.02), ylim=(0.0, 1.2))
ax.axis("off")
figure.canvas.draw()  # the boxes get their sizes
for first, second, label, place, bend in ARROWS:
    look = {"arrowstyle": "-|>", "color": "0.25", "connectionstyle": f"arc3,rad={bend}"}
    look |= {"patchA": boxes[first], "patchB": boxes[second], "shrinkA": 3, "shrinkB": 3}
    ax.annotate("", BLOCKS[second][:2], BLOCKS[first][:2], arrowprops=look)
    ax.text(*place, label, fontsize=8.5, color="0.25", **center)
figure.savefig("environments.png", dpi=130)
