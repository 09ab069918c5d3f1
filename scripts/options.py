"""Options that several commands share: each has one name, one type and one help text."""

from ast import literal_eval
from collections.abc import Callable, Iterable
from typing import Annotated, Any

import tyro
from tyro.constructors import PrimitiveConstructorSpec


def choice(
    names: Callable[[], Iterable[str]],
    help: str | None = None,
    usual: str | None = None,
    name: str | None = None,
) -> Any:
    """Describes an option that takes a name from a registry.

    The help lists the names that the registry has when the command runs, so that those of
    extensions are among them. The option itself takes any text: the function that looks the name up
    refuses an unknown one, with a sentence that also tells the closest name.

    Args:
        names: Function that returns the names; one in capitals stands for a file or a folder.
        help: Help text; by default what the docstring of the command says.
        usual: What None stands for, where the option has that default.
        name: Name of the option, where it is no name of a Python argument.

    Returns:
        An annotation for the type of the option, as in `Annotated[str, choice(...)]`.
    """
    return tyro.conf.arg(
        name=name,
        constructor_factory=lambda: _one_of(names()),
        help=help,
        help_behavior_hint=f"(default: {usual})" if usual else _default,
    )


def _one_of(names: Iterable[str]) -> Any:
    spec = PrimitiveConstructorSpec(
        nargs=1,
        metavar=f"{{{','.join(names)}}}",
        instance_from_str=lambda given: given[0],
        is_instance=lambda value: isinstance(value, str),
        str_from_instance=lambda value: [value],
    )
    return Annotated[str, spec]


def optional_number(
    usual: str, kind: type[int] | type[float] = float, count: int = 1, help: str | None = None
) -> Any:
    """Describes an option that takes numbers and is None if it is not given.

    Args:
        usual: What None stands for.
        kind: Type of the numbers.
        count: Number of the numbers; several make a tuple.
        help: Help text; by default what the docstring of the command says.

    Returns:
        An annotation for the type of the option, as in `Annotated[float | None, ...]`.
    """

    def parsed(given: list[str]) -> Any:
        found = tuple(map(kind, given))
        return found if count > 1 else found[0]

    spec = PrimitiveConstructorSpec(
        nargs=count,
        metavar=" ".join([kind.__name__.upper()] * count),
        instance_from_str=parsed,
        is_instance=lambda value: value is not None,
        str_from_instance=lambda value: [str(value)],
    )
    constructor: Any = Annotated[float, spec]
    return tyro.conf.arg(
        constructor_factory=lambda: constructor,
        help=help,
        help_behavior_hint=f"(default: {usual})",
    )


def _default(label: str) -> str:
    # With a constructor of our own, tyro shows the default as a Python list.
    return f"(default: {' '.join(map(str, literal_eval(label)))})"


def environments() -> list[str]:
    """Returns the ids of the registered arms of this package, and the form of others."""
    from .. import TASKS

    return [*(f"ActiveSuit/{task}-v0" for task in TASKS), "MODULE:ID"]


def correctable() -> Iterable[str]:
    """Returns the names of the policies that are no trained networks."""
    from ..envs.policies import POLICIES

    return POLICIES


def policies() -> list[str]:
    """Returns the names of the policies; the folder of a training run is one too."""
    from ..envs.policies.trained import shipped_policies

    return [*correctable(), *shipped_policies(), "FOLDER"]


def evaluated() -> list[str]:
    """Returns the names of policies and bounds; the folder of a training run is one too."""
    from ..envs.evaluation import BOUNDS

    return [*policies(), *BOUNDS]


def suits() -> list[str]:
    """Returns the names of the shipped suits; a suit file is one too."""
    from ..assets import suit_names

    return [*suit_names(), "FILE.json"]


def gravities() -> Iterable[str]:
    """Returns the names of the places."""
    from ..envs.model.config import PLACES

    return PLACES


def joints() -> Iterable[str]:
    """Returns the names of the joints that a suit may resist."""
    from ..assets import JOINTS

    return JOINTS


def env_option(usual: str) -> Any:
    """Describes `--env`, which is `usual` if neither it nor a training run says otherwise."""
    help = (
        "Id of the environment to simulate; one of your own as MODULE:ID, where importing the "
        "module registers the id."
    )
    return choice(environments, help, usual)


def suit_option(usual: str) -> Any:
    """Describes `--suit`, which is `usual` if neither it nor a training run says otherwise."""
    return choice(suits, "Name of a shipped suit, or path of a suit file.", usual)


def gravity_option(usual: str) -> Any:
    """Describes `--gravity`, which is `usual` if neither it nor a training run says otherwise."""
    return choice(
        gravities, "Place whose gravity acts on the arm; weightless means microgravity.", usual
    )


def shipped_tasks() -> Iterable[str]:
    """Returns the names of the shipped tasks."""
    from ..envs.tasks import TASKS

    return TASKS


def tasks() -> list[str]:
    """Returns the names of the shipped tasks; a file of a motion is one too."""
    return [*shipped_tasks(), "FILE.csv"]


def uses() -> list[str]:
    """Returns what curves may be for: a shipped task, any motion, or a file of a motion."""
    return [*tasks(), "any"]


def levels() -> Iterable[str]:
    """Returns the names of the levels."""
    from ..envs.levels import LEVELS

    return LEVELS


def scores() -> Iterable[str]:
    """Returns the names of the scores of extras."""
    from ..envs.extras import SCORES

    return SCORES


def drawings() -> Iterable[str]:
    """Returns the names of the drawings of extras."""
    from ..envs.extras import DRAWINGS

    return DRAWINGS


ENV, SUIT, GRAVITY = "ActiveSuit/ArmTracking-v0", "mock-suit", "earth"

# None where the option is not given: a training run may say what it is then (`runs.scene`).
Env = Annotated[str | None, env_option(ENV)]
Suit = Annotated[str | None, suit_option(SUIT)]
Gravity = Annotated[str | None, gravity_option(f"that of the task, mostly {GRAVITY}")]
TaskName = Annotated[
    str | None,
    choice(
        tasks,
        "Name of a shipped task, instead of --env; or a CSV file with the columns time [s] and the "
        "four joint angles [rad] of a motion.",
        "that of --env",
    ),
]
Use = Annotated[
    str | None,
    choice(
        uses,
        "Motions that the model is for; the answer is what the curves leave open about them: a "
        "shipped task; a CSV file with the column angle_rad, or the angles of all joints, and "
        "time_s; or any motion in the range of the curves.",
        "none",
        "for",
    ),
]
Level = Annotated[
    str | None,
    choice(
        levels,
        "How much differs from what a controller was made for; options that are given replace "
        "those of the level.",
        "that of a trained policy, else nominal",
    ),
]
SuitName = Annotated[str, choice(suits, "Name of a shipped suit, or path of a suit file.")]
PolicyName = Annotated[
    str,
    choice(
        policies,
        "Name of a policy, also with options (adaptive:suit=elbow.json,forgetting=10), or "
        "MODULE:CLASS of your own; or folder of a training run, whose task and options then hold.",
    ),
]
EvaluatedName = Annotated[
    str,
    choice(
        evaluated,
        "Name of a policy or bound, also with options (adaptive:suit=elbow.json,forgetting=10), or "
        "MODULE:CLASS of your own; or folder of a training run, whose task and options then hold.",
    ),
]
Scores = Annotated[
    tuple[Annotated[str, choice(scores)], ...],
    tyro.conf.arg(
        name="score", help="Scores of extras, which say what motions cost in other numbers too."
    ),
]
Draw = Annotated[
    str | None,
    choice(drawings, "Drawing of an extra beside the moving arm.", "none"),
]
_SEED = "Seed of all random numbers; the same one repeats the result."
Seed = Annotated[int, tyro.conf.arg(help=_SEED)]
RunSeed = Annotated[int | None, optional_number("0", int, help=_SEED)]
Json = Annotated[bool, tyro.conf.arg(help="Print the result as JSON instead of tables.")]
Trust = Annotated[
    bool,
    tyro.conf.arg(help="Let JSON files of policies name MODULE:CLASS, whose code then runs."),
]
Force = Annotated[
    bool, tyro.conf.arg(help="Replace files that are there, and write into any folder.")
]
