"""Tables of README and docs that are made from measured results.

The results are those that `measure.py` keeps in docs/measured, and docs/leaderboard.jsonl.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

import numpy as np

from ..benchmarks.device import columns
from ..benchmarks.gpu import columns as gpu_columns
from ..envs.benchmark.results import read_results
from ..envs.benchmark.standings import Standing, Standings
from ..envs.benchmark.suites import Setting
from ..envs.evaluation import REFERENCES
from ..envs.model.cuffs import FORCE_LIMITS
from ..envs.policies.network import read_card
from ..envs.policies.trained import shipped_policies
from ..tables import markdown_table
from .leaderboard import DOCS, RESULTS
from .measure import EXPERIMENTS, TRAININGS, kept

WEIGHTLESS = "microgravity"
CUFFS = DOCS / "cuffs.jsonl"
PLACES = {"earth": "Earth", "mars": "Mars", "moon": "Moon", WEIGHTLESS: "microgravity"}
CAUSAL = ("adaptive", "observer", "disturbance-observer", "iterative", "impedance", "predictive")


def percent(share: float, digits: int = 1) -> str:
    """Returns a share in percent, as "6.7 %"."""
    return f"{100 * share:.{digits}f} %"


def interval(found: Mapping[str, float] | None) -> str:
    """Returns a value with its 95 % interval, as "0.70 (0.66 to 0.73)"."""
    if found is None:
        return "-"
    value, low, high = (signed(found[name]) for name in ("value", "low", "high"))
    return f"{value} ({low} to {high})"


def signed(value: float) -> str:
    """Returns a number with two digits, and never as -0.00."""
    return f"{value:.2f}".replace("-0.00", "0.00")


# The demo.


def scores(place: str) -> dict[str, Any]:
    """Returns the scores of the demo at a place, by policy."""
    return kept("demo")["result"]["evaluation"][place]["scores"]


def _effects(names: Mapping[str, str]) -> str:
    header = ["", "effort, Earth", "relief, Earth", "effort, microgravity", "relief, microgravity"]
    rows = []
    for name, title in names.items():
        cells = [title]
        for place in ("earth", WEIGHTLESS):
            one = scores(place)[name]
            relief = {"unsuited": "1", "suited": "0"}.get(name) or interval(one["relief"])
            cells += [percent(one["effort"]), relief]
        rows.append(cells)
    return markdown_table(header, rows)


def door() -> str:
    """Returns README's table, and what it says in words."""
    table = _effects(
        {
            "suited": "suit, no exoskeleton",
            "none": "exoskeleton, motors off",
            "feedforward": "suit torque cancelled (`feedforward`)",
            "compensation": "suit, weight and friction (`compensation`)",
            "best-known-plan": "best known plan (`best-known-plan`)",
        }
    )
    earth, space = scores("earth"), scores(WEIGHTLESS)
    bare, suited = ([percent(p[name]["effort"]) for p in (earth, space)] for name in REFERENCES)
    policies = ("compensation", "best-known-plan")
    given = [signed(space[name]["relief"]["value"]) for name in policies]
    return (
        f"{table}\n\nThe suit raises effort from {bare[0]} to {suited[0]} of strength on Earth, "
        f"and from {bare[1]} to {suited[1]} in microgravity.\n"
        f"Compensation gives back {given[0]} of that in "
        f"microgravity, the best known plan {given[1]}. "
        "Motors that are off add weight and gear\nfriction, "
        "and on Earth cancelling the suit alone does not make up for that weight."
    )


def demo_results() -> str:
    """Returns the table of all policies of the demo."""
    names = {"suited": "suited, no exoskeleton", "unsuited": "unsuited"}
    policies = {name: f"`{name}`" for name in scores("earth") if name not in names}
    return _effects({**names, **policies})


def demo_fits() -> str:
    """Returns the table of the fits of the demo."""
    header = ["joint", "method", "fitness, eq. (7)", "NRMSE", "certificate margin"]
    header += ["model runs", "largest held-out errors [N·m]"]
    rows = []
    for joint, methods in kept("demo")["fits"].items():
        for method, fit in methods.items():
            errors = ", ".join(f"{error:.2f}" for error in fit["prediction_max_error"].values())
            quality = [f"{fit['fitness']:.2e}", percent(fit["nrmse"], 2)]
            margin = f"{fit['certificate']['margin']:.3f}"
            rows.append([joint, f"`{method}`", *quality, margin, f"{fit['evaluations']:,}", errors])
    return markdown_table(header, rows)


# Sixteen settings.


@cache
def settings() -> dict[tuple[str, str, str], dict[str, Any]]:
    """Returns the evaluations by place, suit and coupling."""
    found = kept("settings")["result"]["settings"]
    return {(one["gravity"], one["suit"], one["coupling"]): one for one in found}


def _matrix(columns: Mapping[str, Mapping[str, Any]]) -> str:
    """Returns relief by policy, with a column for each evaluation."""
    costs = [percent(one["suit_cost"]["value"]) for one in columns.values()]
    rows = [["the suit costs, of strength", *costs]]
    names = next(iter(columns.values()))["scores"]
    for name in names:
        if name not in REFERENCES:
            reliefs = (interval(one["scores"][name]["relief"]) for one in columns.values())
            rows.append([f"`{name}`", *reliefs])
    return markdown_table(["policy", *columns], rows)


def four_settings() -> str:
    """Returns relief in both suits on Earth and in microgravity, in the rigid exoskeleton."""
    columns = {
        f"{PLACES[place]}, {suit}": settings()[place, suit, "rigid"]
        for suit in ("mock-suit", "emu-like")
        for place in ("earth", WEIGHTLESS)
    }
    return _matrix(columns)


def all_settings() -> str:
    """Returns relief in all settings, then a table of each."""
    parts = []
    for suit, coupling in dict.fromkeys(key[1:] for key in settings()):
        here = {
            PLACES[place]: one
            for (place, *rest), one in settings().items()
            if tuple(rest) == (suit, coupling)
        }
        parts += [f"## Relief: {suit}, {coupling}", _matrix(here)]
    parts.append("## Each setting")
    for (place, suit, coupling), one in settings().items():
        parts += [f"**{PLACES[place]}, {suit}, {coupling}**", _setting(one["scores"])]
    return "\n\n".join(parts)


def _setting(found: Mapping[str, Any]) -> str:
    header = ["policy", "effort", "relief", "of the bound", "shoulder, elbow [N·m]"]
    rows = []
    for name, one in found.items():
        share, torque = one["share_of_bound"], one["torque"]
        rows.append(
            [
                f"`{name}`",
                percent(one["effort"]),
                interval(one["relief"]),
                "-" if share is None else percent(share["value"], 0),
                f"{torque['shoulder_flexion']:.2f}, {torque['elbow_flexion']:.2f}",
                f"{1e3 * one['tracking']:.0f}",
                percent(one["success"], 0),
                f"{one['reward']:.2f}",
            ]
        )
    return markdown_table([*header, "error [mrad]", "success", "reward"], rows)


def spread(values: Iterable[float]) -> str:
    """Returns the least and the greatest of some values, as "0.86 to 1.00"."""
    found = list(values)
    return f"{min(found):.2f} to {max(found):.2f}"


def findings() -> str:
    """Returns what the settings show, as a list."""
    found = settings()
    named = {"unsuited": "unsuited", "suited": "suited", "none": "motors off"}
    named |= {"compensation": "compensation", "best-known-plan": "best known plan"}
    levels = (
        f"{title} {spread(one['scores'][name]['reward'] for one in found.values())}"
        for name, title in named.items()
    )
    ranks = [_rank_correlation(one["scores"]) for one in found.values()]
    same = sum(rank > 0.999 for rank in ranks)
    stiff = found[WEIGHTLESS, "emu-like", "rigid"]["scores"]["compensation"]
    cuffs = found[WEIGHTLESS, "emu-like", "cuffs"]["scores"]
    drifting, cancelled, best = (
        cuffs[n] for n in ("compensation", "feedforward", "best-known-plan")
    )
    reliefs = [one["relief"]["value"] for one in (stiff, drifting, cancelled, best)]
    shares = [list(_each(one["scores"], "beginning")) for one in found.values()]
    first = 100 * np.mean(shares, axis=1)
    lines = [
        f"**The levels of the mean reward are alike everywhere**: {', '.join(levels)}.",
        f"**The first half second** has {first.min():.1f} to {first.max():.1f} % of "
        "the return, about its share of the time.",
        f"**The reward ranks policies as relief does** in {same} of the {len(ranks)} settings. In "
        f"the others the rank correlation is at least {min(ranks):.2f}: neighbours of almost the "
        "same relief change places, since the reward also charges tracking and chatter.",
        "**A strong suit on cuffs is another matter.** The cuffs yield, so that the encoders show "
        "another angle than the arm's. In microgravity and the emu-like suit `compensation` "
        f"falls from {reliefs[0]:.2f} to {reliefs[1]:.2f}, below `feedforward` ({reliefs[2]:.2f}). "
        f"It presses up to {drifting['cuff_peak']['upper_arm']:.0f} N on the upper arm, where "
        f"{FORCE_LIMITS['upper_arm']:.0f} N is what a person should bear, and "
        f"{percent(drifting['success'], 0)} of its motions succeed. The best known plan, which "
        f"allows for the cuffs, keeps {reliefs[3]:.2f}. `corrected` estimates the arm's angles "
        "from the cuffs' forces ([Controllers](controllers.md#the-policies)).",
    ]
    return "\n".join(f"- {line}" for line in lines)


def _each(found: Mapping[str, Any], field: str) -> Iterable[float]:
    return (one[field] for one in found.values())


def _rank_correlation(found: Mapping[str, Any]) -> float:
    """Returns Kendall's tau between mean reward and relief over the policies of a setting."""
    from scipy.stats import kendalltau

    judged = [one for name, one in found.items() if name not in REFERENCES]
    reliefs = [one["relief"]["value"] for one in judged]
    rank: Any = kendalltau(reliefs, [one["reward"] for one in judged])
    return float(rank.statistic)


# Laws of control, a branch, and speed.


def laws() -> str:
    """Returns relief of the laws that feed back what they measure, in three settings."""
    rows = []
    for coupling, names in (
        ("laws", kept("laws-earth")["result"]["scores"]),
        ("cuffs", kept("cuffs-earth")["result"]["scores"]),
    ):
        places = [kept(f"{coupling}-{where}")["result"] for where in ("earth", "weightless")]
        shift = kept(f"{coupling}-shift")["result"]["scores"]
        for name in names:
            if name not in REFERENCES:
                misled = shift[f"{name}:suit=mock-suit"]
                found = [*(place["scores"][name] for place in places), misled]
                title = f"`{name}`" + (", cuffs" if coupling == "cuffs" else "")
                rows.append([title, *(signed(one["relief"]["value"]) for one in found)])
    header = ["policy", "Earth, mock-suit", "microgravity, emu-like", "shift"]
    return markdown_table(header, rows)


def validation() -> str:
    """Returns torque error, verdict and relief of believed suits in simulated ones."""
    rows = []
    for name, pressure in (("validate", ""), ("validate-40kpa", " at 40 kPa")):
        for one in kept(name)["result"]["cells"]:
            error = {part: 100 * value for part, value in one["nrmse"].items()}
            shown = f"{error['value']:.1f} % ({error['low']:.1f} to {error['high']:.1f})"
            relief, share = interval(one["relief"]), interval(one["share_of_true"])
            plant = f"{one['plant']}{pressure}"
            said = one["verdict"] or "the same suit"
            rows.append([one["believed"], plant, shown, said, relief, share])
    header = ["believed", "simulated", "torque error of the peak", "verdict", "relief"]
    return markdown_table([*header, "of the true model's"], rows)


def speed(topic: str) -> str:
    """Returns the table of the rows of a bench that are compared with something.

    Args:
        topic: Part of the package, as in `python -m activesuit.benchmarks`.
    """
    rows = [
        [
            one["what"],
            one["against"].partition(" (")[0],
            f"{one['ratio']:.2f}",
            f"{one['lowest']:.2f} to {one['highest']:.2f}",
        ]
        for one in kept(f"bench-{topic}")["result"]["rows"]
        if one["ratio"] is not None
    ]
    return markdown_table(["ours", "against", "speed, median", "lowest to highest"], rows)


def training() -> str:
    """Returns the table of PPO in rows and in single arms, and where its time goes."""
    found = kept("bench-train")["result"]["training"]
    header = ["PPO in", "steps per second", "slowest to fastest"]
    rows = [
        [
            one["what"].removeprefix("PPO in "),
            f"{one['speed']:,.0f}",
            f"{one['slowest']:,.0f} to {one['fastest']:,.0f}",
            *(percent(share, 0) for share in one["shares"].values()),
            f"{one['minutes']:.1f} min",
        ]
        for one in found
    ]
    return markdown_table([*header, *found[0]["shares"], "a million steps"], rows)


# Assumed numbers, and changes of the bound.


def sensitivity() -> str:
    """Returns conclusions that flip where an assumed number is halved or doubled."""
    rows = []
    for one in kept("sensitivity")["result"]["cases"]:
        relief, success = one["relief"], one["success"]
        cells = [
            "-" if relief is None else f"{signed(relief[name])}, {percent(success[name], 0)}"
            for name in ("none", "feedforward", "compensation", "observer")
        ]
        flips = "; ".join(one["flipped"]) or "none"
        rows.append([one["task"], one["gravity"], one["change"], *cells, flips])
    header = ["task", "place", "changed number", "none", "feedforward"]
    return markdown_table([*header, "compensation", "observer", "conclusions that flip"], rows)


def bound() -> str:
    """Returns what random changes of the best known plan gain."""
    rows = []
    for one in kept("bound")["result"]["attacks"]:
        gain = "-" if one["gain"] is None else f"{one['gain']:+.3f}"
        better = "-" if one["better"] is None else percent(one["better"], 0)
        relief = "-" if one["relief"] is None else signed(one["relief"])
        setting = [one["task"], one["level"], one["suit"], relief]
        rows.append([*setting, percent(one["last_pass"], 2), gain, better])
    header = ["task", "level", "suit", "relief of the plan", "last pass took"]
    return markdown_table([*header, "best change of each motion", "changes that gain 0.01"], rows)


def hindered() -> str:
    """Returns what hindered arms reach in each task."""
    rows, names = [], ("locked", "thrown up", "thrown down")
    for one in kept("hindered")["result"]["tasks"]:
        reached = (
            f"{percent(one['success'][n], 0)}, {percent(one['effort'][n], 0)}" for n in names
        )
        angles = (f"{1e3 * one[name]:.0f} mrad" for name in ("tracking", "frozen"))
        rows.append([one["task"], *angles, *reached])
    header = ["task", "limit of the worst joint", "frozen at its mean"]
    return markdown_table([*header, *(f"{name}: success, effort" for name in names)], rows)


def shipped() -> str:
    """Returns a table of the trained policies that ship, from their cards."""
    rows = []
    for name, folder in shipped_policies().items():
        card = read_card(folder)
        assert card.scores is not None  # tools/ship.py keeps them
        trained = card.training
        steps = f"{trained['done']:,} of {trained['steps']:,}"
        seeds = str(len(trained["best_of_seeds"]))
        success = percent(card.scores["success"], 0)
        row = [f"`{name}`", card.summary, seeds, steps, interval(card.scores["relief"]), success]
        rows.append(row)
    return markdown_table(["policy", "is", "seeds", "best after steps", "relief", "success"], rows)


def weightless() -> str:
    """Returns a table of trainings in microgravity, by their options."""
    rows = []
    for name, options in TRAININGS.items():
        found = kept(f"weightless-{name}")["result"]
        reliefs = [one["relief"]["value"] for one in found["best"].values()]
        mean = f"{found['together']['value']:.2f}"
        rows.append([f"`{options}`", mean, f"{min(reliefs):.2f} to {max(reliefs):.2f}"])
    return markdown_table(["options", "interquartile mean", "lowest to highest"], rows)


BY_PPO = ("learning", "learning-history")
"""Results of trainings by PPO."""

OTHERS = ("learning-recurrent", "learning-sac", "learning-tqc")
"""Results of trainings with other algorithms."""


def learning(*names: str) -> str:
    """Returns the relief that ways of training reach in each task, beside other policies."""
    results = [kept(name)["result"] for name in names]
    found = [end for result in results for end in result["ends"]]
    settings = list(dict.fromkeys((one["task"], one["level"]) for one in found))
    ways = list(dict.fromkeys(one["way"] for one in found))
    compared = results[0]["beside"]
    beside = list(dict.fromkeys(one["policy"] for one in compared))
    rows = []
    for place in settings:
        at = [one for one in compared if (one["task"], one["level"]) == place]
        by_policy = {one["policy"]: signed(one["value"]) for one in at}
        ends = [one for one in found if (one["task"], one["level"]) == place]
        by_way = {
            one["way"]: interval(one) if "low" in one else signed(one["value"]) for one in ends
        }
        cells = (by_policy.get(name, "-") for name in beside)
        rows.append([*place, *cells, *(by_way.get(way, "-") for way in ways)])
    header = ["task", "level", *(name.partition(":")[0] for name in beside), *ways]
    return markdown_table(header, rows)


ON_POLICY = {
    "lambda": "gae_lambda",
    "steps a row": "n_steps",
    "batch": "batch_size",
    "epochs": "n_epochs",
    "periods of one exploration": "sde_sample_freq",
}
TUNED = {
    "ppo": ON_POLICY,
    "recurrent-ppo": ON_POLICY | {"greatest KL": "target_kl"},
    "sac": {"tau": "tau", "updates": "gradient_steps", "batch": "batch_size"},
}
USUAL = {"n_epochs": 10, "tau": 0.005, "batch_size": 256}  # those of Stable-Baselines3


def tuned(algo: str) -> str:
    """Returns the best hyperparameters of an algorithm that were tried, and the shipped ones."""
    found = kept(f"hyperparameters-{algo}")["rows"]
    tried = [{**USUAL, **one["settings"], **one["settings"]["policy_kwargs"]} for one in found]
    columns = {"learning rate": "learning_rate", "gamma": "gamma"} | TUNED[algo]
    columns |= {"log std": "log_std_init", "LSTM": "lstm_hidden_size"}
    columns = {title: name for title, name in columns.items() if name in tried[0]}
    rows = []
    for one, settings in zip(found, tried, strict=True):
        layers = settings["net_arch"]
        cells = (settings[name] for name in columns.values())
        rows.append(
            [
                *(str(one["trial"]), f"{one['alone']:.2f}", f"{one['correction']:.2f}"),
                *(f"{one:.3g}" if isinstance(one, float) else str(one) for one in cells),
                str((layers["pi"] if isinstance(layers, dict) else layers)[0]),
            ]
        )
    header = ["trial", "relief alone", "relief of the correction", *columns, "layer"]
    return markdown_table(header, rows)


# The leaderboard.


def difficulty() -> str:
    """Returns success and relief in each task: without help, with compensation, and at best."""
    policies = (*REFERENCES, "none", "compensation", "best-known-plan")
    header = ["task", "level", *policies[:-1], "compensation, other suit", policies[-1]]
    rows = []
    for setting in standings().settings:
        if setting.believed != "emu-like":
            continue
        cells = {name: _reached(setting, name) for name in policies}
        other = setting._replace(believed="mock-suit")
        wrong = _reached(other, "compensation") if setting.level == "shift" else "-"
        best = cells.pop("best-known-plan")
        rows.append([setting.task, setting.level, *cells.values(), wrong, best])
    return markdown_table(header, rows)


def _reached(setting: Setting, policy: str) -> str:
    found, relief = standings().of(setting, policy), standings().relief(setting, policy)
    if found is None:
        return "-"
    success = percent(float(np.mean(found.success)), 0)
    if relief is None or policy in REFERENCES:
        return success
    return f"{success}<br>{signed(float(relief.mean()))}"


@cache
def standings() -> Standings:
    """Returns the standings of the committed results."""
    return Standings(read_results([RESULTS]))


@cache
def standing(policy: str, level: str) -> Standing:
    """Returns how a policy stands at a level, over all tasks and both beliefs."""
    return standings().standing(policy, standings().settings_at(level))


def cuffs() -> str:
    """Returns relief and success of policies on cuffs, by level."""
    found = Standings(read_results([CUFFS]))
    by_level = {level: {one.policy: one for one in found.by_level(level)} for level in found.levels}
    rows = []
    for policy in list(by_level[found.levels[0]])[len(REFERENCES) :]:
        cells = [f"`{policy}`"]
        for level in found.levels:
            one = by_level[level][policy]
            relief = "-" if one.relief is None else interval(one.relief.to_dict())
            cells.append(f"{relief}, {percent(one.success, 0)}")
        rows.append(cells)
    return markdown_table(["policy", *found.levels], rows)


def better() -> str:
    """Returns the table of the best causal policies at each level."""
    header, rows = ["policy"], []
    for level in standings().levels:
        header += [f"{level}: success", "relief", "better / worse"]
    for policy in (*CAUSAL, "compensation"):
        cells = [f"`{policy}`"]
        for level in standings().levels:
            one = standing(policy, level)
            relief = "" if one.relief is None else interval(one.relief.to_dict())
            cells += [percent(one.success, 0), relief, shares(one)]
        rows.append(cells)
    return markdown_table(header, rows)


def shares(one: Standing) -> str:
    """Returns the shares of motions with more relief than compensation, and with less."""
    if one.compared is None:
        return ""
    better, _, worse = (percent(share, 0) for share in one.compared)
    return f"{better} / {worse}"


def relief_at(policy: str, level: str) -> str:
    """Returns the mean relief of a policy at a level of the leaderboard, as "0.87"."""
    found = standing(policy, level).relief
    return "-" if found is None else signed(found.value)


def device_models() -> str:
    """Returns the table of the C code of the models."""
    return markdown_table(*columns(kept("bench-device")["result"]["rows"]))


def warp_worlds() -> str:
    """Returns the table of steps of many worlds in MuJoCo Warp, on each device."""
    found = [kept(name)["result"] for name in EXPERIMENTS if name.startswith("bench-gpu")]
    return markdown_table(*gpu_columns(found))


RESULT_TABLES: dict[str, dict[str, Callable[[], str]]] = {
    "../README.md": {"results": door},
    "reproduction.md": {"fits": demo_fits},
    "controllers.md": {
        "laws": laws,
        "validation": validation,
        "demo": demo_results,
        "four settings": four_settings,
    },
    "results.md": {"findings": findings, "settings": all_settings},
    "benchmark.md": {"better": better, "cuffs": cuffs, "bound": bound},
    "model.md": {"sensitivity": sensitivity},
    "tasks.md": {"difficulty": difficulty, "hindered": hindered},
    "training.md": {
        **{"learning": lambda: learning(*BY_PPO), "others": lambda: learning(*OTHERS)},
        **{"drawn": lambda: learning("learning-drawn")},
        **{"tuned": lambda: tuned("ppo"), "tuned sac": lambda: tuned("sac")},
        **{"tuned recurrent": lambda: tuned("recurrent-ppo")},
        **{"weightless": weightless, "shipped": shipped},
        **{"speed of training": lambda: speed("train"), "time of training": training},
    },
    "environments.md": {"speed": lambda: speed("env")},
    "device.md": {"models": device_models},
    "gpu.md": {"warp": warp_worlds},
}
"""The tables by page and mark."""
