"""Relief over the steps of trainings, from the kept results of the docs."""

from activesuit.scripts.reports.learning import study_figure
from activesuit.tools.measure import kept
from activesuit.tools.results import BY_PPO, OTHERS

found = [kept(name)["result"] for name in (*BY_PPO, *OTHERS)]
curves = [curve for one in found for curve in one["curves"]]
study_figure(curves, found[0]["beside"]).savefig("learning.png", dpi=130)
