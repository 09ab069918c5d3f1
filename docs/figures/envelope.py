"""Draws what a wearer of the mock suit can hold on Earth, in three planes."""

import matplotlib.pyplot as plt
from activesuit.envs.envelope import BRANCHES, CONDITIONS, work_envelope
from activesuit.envs.envelope.figures import sections_figure
from activesuit.envs.model import ArmConfig

config = ArmConfig(suit="mock-suit", gravity="earth")
cases = [("unsuited", "loading")]
cases += [(condition, branch) for condition in CONDITIONS[1:] for branch in BRANCHES]
envelopes = [work_envelope(config, *case, spacing=0.025, wrist_angles=33) for case in cases]

plt.style.use("seaborn-v0_8-whitegrid")
sections_figure(envelopes).savefig("envelope.png", dpi=110)
