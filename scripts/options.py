"""Options that several commands share: each has one name, one type and one help text."""

from ast import literal_eval
from collections.abc import Callable, Iterable
from typing import Annotated, Any

import tyro
from tyro.constructors import PrimitiveConstructorSpec


def choice(names: Callable[[], Iterable[str]], help: str | None = None) -> Any:
    """Describes an option that takes a name from a registry.

    The help lists the names that the registry has when the command runs, so that those of
    extensions are among them. The option itself takes any text: the function that looks the name up
    refuses an unknown one, with a sentence that also tells the closest name.

    Args:
        names: Function that returns the names; one in capitals stands for a file or a folder.
        help: Help text; by default what the docstring of the command says.

    Returns:
        An annotation for the type of the option, as in `Annotated[str, choice(...)]`.
    """
    return tyro.conf.arg(
        constructor_factory=lambda: _one_of(names()), help=help, help_behavior_hint=_default
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


def _default(label: str) -> str:
    # With a constructor of our own, tyro shows the default as a Python list.
    return f"(default: {' '.join(map(str, literal_eval(label)))})"


def environments() -> list[str]:
    """Returns the ids of the registered environments of this package."""
    import gymnasium

    return [name for name in gymnasium.registry if name.startswith("ActiveSuit/")]


def policies() -> list[str]:
    """Returns the names of the policies; the folder of a training run is one too."""
    from ..envs.policies import POLICIES

    return [*POLICIES, "FOLDER"]


def suits() -> list[str]:
    """Returns the names of the shipped suits; a suit file is one too."""
    from ..assets import suit_names

    return [*suit_names(), "FILE.json"]


def gravities() -> Iterable[str]:
    """Returns the names of the places."""
    from ..envs.model.config import GRAVITY

    return GRAVITY


def joints() -> Iterable[str]:
    """Returns the names of the joints that a suit may resist."""
    from ..assets import JOINTS

    return JOINTS


Env = Annotated[str, choice(environments, "Id of the environment to simulate.")]
PolicyName = Annotated[str, choice(policies, "Name of a policy, or folder of a training run.")]
SuitName = Annotated[str, choice(suits, "Name of a shipped suit, or path of a suit file.")]
Gravity = Annotated[str, choice(gravities, "Place whose gravity acts on the arm.")]
Seed = Annotated[
    int, tyro.conf.arg(help="Seed of all random numbers; the same one repeats the result.")
]
Json = Annotated[bool, tyro.conf.arg(help="Print the result as JSON instead of tables.")]
