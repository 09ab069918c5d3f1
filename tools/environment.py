"""Remakes the tables in the docstring of `ArmEnv`: `python -m activesuit.tools.environment`."""

from pathlib import Path
from textwrap import indent, wrap

from gymnasium.spaces import Box

from ..envs import ArmEnv, arm_env
from ..envs.interface.observation import BELIEF, SUITES
from ..envs.interface.reward import CHANGE_SCALE, COST_MEANINGS, ERROR_SCALE, TERMS
from ..envs.model import ASSISTED
from ..envs.simulation.measurements import COLUMNS
from ..files import write_text
from ..tables import markdown_table

FILE = Path(arm_env.__file__)
BEGIN, END = "    Action, ", "    Version history"


def tables() -> str:
    """Returns tables of action, observation, reward and costs, as they stand in the docstring."""
    env = ArmEnv()
    space, motors = env.action_space, env.config.exo.motors
    assert isinstance(space, Box)
    actions = [
        [str(i), joint, f"{space.low[i]:g}", f"{space.high[i]:g}", f"{motors[joint].peak_torque:g}"]
        for i, joint in enumerate(ASSISTED)
    ]
    parts, shown = [], []
    for suite, every in SUITES.items():
        for part in every:
            columns = COLUMNS.get(part.measurement, BELIEF)
            size, limit = columns.stop - columns.start, f"{part.limit:.4g}"
            parts.append([suite, part.name, str(size), limit, f"{part.scale:.4g}", part.unit])
            shown.append(f"- {part.name}: {part.shows}.")
    scales = ("effort of the suited arm", f"{ERROR_SCALE} rad", f"{CHANGE_SCALE} of the peak")
    terms = [list(row) for row in zip(TERMS, REWARDED, scales, strict=True)]
    costs = [f"- {name}: {meaning}." for name, meaning in COST_MEANINGS.items()]
    text = "\n\n".join(
        (
            f"Action, `Box({space.low[0]:g}, {space.high[0]:g}, {space.shape}, {space.dtype})`:",
            markdown_table(["index", "motor", "low", "high", "torque at 1 [N·m]"], actions),
            "Observation, `Box` of float32, the parts of the chosen suites one after the other:",
            markdown_table(["suite", "part", "numbers", "limit", "1 if normalized", "unit"], parts),
            _lines(shown),
            "Reward, 1 / (1 + the sum of three terms), in [0, 1]; 0 where the arm is lost:",
            markdown_table(["term", "square of", "over"], terms),
            'Costs of an episode, `info["cost_terms"]`:',
            _lines(costs),
        )
    )
    return indent(text, "    ") + "\n\n"


REWARDED = (
    "torque over strength, root mean square of four joints",
    "tracking error, root mean square of four joints",
    "change of the action, root mean square of the motors",
)


def _lines(items: list[str]) -> str:
    return "\n".join(line for item in items for line in wrap(item, 96, subsequent_indent="  "))


def remade(text: str) -> str:
    """Returns the text of the module with today's tables."""
    begin, end = text.index(BEGIN), text.index(END)
    return text[:begin] + tables() + text[end:]


if __name__ == "__main__":
    write_text(FILE, remade(FILE.read_text(encoding="utf-8")))
