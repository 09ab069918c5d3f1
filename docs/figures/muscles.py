"""The activation of muscles in one motion on Earth, in the suit and with compensation."""

from activesuit.envs.evaluation import evaluate
from activesuit.envs.muscles.scores import activation_figure

found = evaluate("ActiveSuit/ArmTracking-v0", ["compensation"], motions=1, gravity="earth")
motions = {name: found.traces[name][0] for name in ("suited", "compensation")}
activation_figure(motions).savefig("muscles.png", dpi=110)
