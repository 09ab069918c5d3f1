"""Options of commands: flags of the environment, and options that several commands share.

A flag of the environment is declared by a field of a dataclass alone, which has name, type,
default, range and text: `--sensing.rate-cutoff` is `rate_cutoff` of `Sensing`.
"""

import functools
import inspect
import io
import re
from ast import literal_eval
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import redirect_stderr
from dataclasses import field, fields, is_dataclass, make_dataclass
from importlib import import_module
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import tyro
from tyro.constructors import PrimitiveConstructorSpec

from ..errors import InputError, shown

SHORT = re.compile("^--payload(=|$)")  # short form of --payload.mass
FRAME = " │╭╮╰╯"
ADVICE = ("Argument helptext", "For full helptext")  # long parts of tyro's message


def parsed(
    command: Callable[..., object], program: str, arguments: Sequence[str]
) -> Callable[[], object]:
    """Returns a call of the command with the arguments of a command line."""
    if any(one.kind is one.VAR_KEYWORD for one in inspect.signature(command).parameters.values()):
        arguments = [SHORT.sub(r"--payload.mass\1", one) for one in arguments]
    said, call = io.StringIO(), with_flags(command)
    try:
        with redirect_stderr(said):
            return tyro.cli(
                call, prog=program, args=arguments, config=(tyro.conf.FlagCreatePairsOff,)
            )
    except SystemExit as end:
        if not end.code:
            raise
        raise InputError(f"{_sentence(said.getvalue())}; see {program} --help") from None


def with_flags(command: Callable[..., object]) -> Callable[..., Callable[[], object]]:
    """Returns a function that has a parameter for each flag, and returns a call of the command."""
    kinds = inspect.Parameter
    own, hints = inspect.signature(command).parameters, get_type_hints(command, include_extras=True)
    of_scene = [name for name, one in own.items() if one.kind is kinds.VAR_KEYWORD]
    parameters = [one for one in own.values() if one.kind is not kinds.VAR_KEYWORD]
    more = flags(of_scene[0]) if of_scene else {}
    for name, (hint, default) in more.items():
        hints[name] = hint
        parameters.append(kinds(name, kinds.KEYWORD_ONLY, default=default, annotation=hint))

    def later(*given: Any, **options: Any) -> Callable[[], object]:
        own = {name: one for name, one in options.items() if name not in more}
        used = _given((name, options[name], default) for name, (_, default) in more.items())
        return functools.partial(command, *given, **own, **used)

    later.__doc__ = command.__doc__
    later.__annotations__ = {name: one for name, one in hints.items() if name not in of_scene}
    later.__annotations__["return"] = Callable[[], object]
    later.__signature__ = inspect.Signature(parameters)  # pyright: ignore
    return later


def _sentence(box: str) -> str:
    """Returns the problem and the hints from the box that tyro draws, without title and advice."""
    parts, part = [], []
    for line in box.splitlines()[1:]:
        text = line.strip(FRAME).strip()
        if text and not text.strip("─-"):  # a line between two parts
            parts.append(" ".join(part).rstrip("."))
            part = []
        else:
            part.append(" ".join(text.split()))
    sentences = [one.strip() for one in parts if not one.startswith(ADVICE)]
    return "; ".join(one for one in sentences if one)


def named_values(option: str, given: Sequence[str]) -> dict[str, str]:
    """Returns the values, by name, of an option that is given as NAME=VALUE."""
    found: dict[str, str] = {}
    for one in given:
        name, sign, value = one.partition("=")
        if not (sign and name and value):
            raise InputError(f"{option} has {shown(one)}: give NAME=VALUE")
        if name in found:
            raise InputError(f"{option} has {name!r} twice: give it once")
        found[name] = value
    return found


def flags(kind: str) -> dict[str, tuple[Any, Any]]:
    """Returns type and default, by name, of the flags that a parameter of a command stands for.

    `kind` is the name of the parameter: "arm" for a model, "environment" for an environment, or
    "options" for a scene, which is an environment with its task.
    """
    from ..envs.model import ArmConfig
    from ..envs.setup import DEFAULTS, Setup

    arm = _fields_of(ArmConfig, vars(ArmConfig()))
    if kind == "arm":
        return arm
    found = {**arm, **_fields_of(Setup, DEFAULTS | {"fatigue": None}, ("arm",))}
    steps = "Number of control periods after which an episode ends."
    found[LIMIT] = (Annotated[Any, optional_number("that of the task", int, 1, steps)], None)
    if kind == "environment":
        return found
    return {"task": (TaskName, None), "level": (Level, None), "env": (Env, None)} | found


def _fields_of(
    config: type, usual: Mapping[str, Any], without: Sequence[str] = ()
) -> dict[str, tuple[Any, Any]]:
    """Returns type and default, by name, of the flags of a dataclass."""
    from ..envs.person import Person

    hints, texts = get_type_hints(config), _texts(config)
    found = {}
    for one in fields(config):
        kind = _without_none(hints[one.name])
        if one.name in without or kind == tuple[Person, ...]:
            continue
        value, text = usual.get(one.name), texts[one.name]
        if isinstance(kind, type) and is_dataclass(kind):
            found[one.name] = _group(one.name, kind, value, text)
            continue
        found[one.name] = _flag(one.name, kind, value, text, one.metadata.get("setting"))
    return found


def _group(name: str, kind: type, value: Any, text: str) -> tuple[Any, Any]:
    """Returns a nested dataclass of flags, and its default, in which no flag is given."""
    inner = _fields_of(kind, vars(value if is_dataclass(value) else kind()))
    made = [(one, hint, field(default=default)) for one, (hint, default) in inner.items()]
    group = make_dataclass(name.title(), made, frozen=True)
    group.__doc__ = text
    return Annotated[group, tyro.conf.arg(help=text)], group()


def _flag(name: str, kind: Any, value: Any, text: str, setting: Any) -> tuple[Any, Any]:
    """Returns type and default of one flag; None, False or () mean that the flag is not given."""
    if kind is bool and value is False:
        return Annotated[bool, tyro.conf.arg(help=text)], False
    words = " ".join(map(str, value)) or "none" if isinstance(value, tuple) else str(value)
    usual = "" if value is None else f"default: {words}"
    if setting is not None:
        usual += f"{'; ' * bool(usual)}{setting.low:g} to {setting.high:g}"
    usual = f"({usual})" if usual else ""
    args, origin = get_args(kind), get_origin(kind)
    if kind is bool:
        values = {"true": True, "false": False}
        return Annotated[Any, choice(lambda: values, text, hint=usual, values=values)], None
    if origin is Literal:
        return Annotated[Any, choice(lambda: args, text, hint=usual)], None
    if origin is tuple and args[-1] is Ellipsis:
        return Annotated[tuple[str, ...], tyro.conf.arg(help=text, help_behavior_hint=usual)], ()
    if origin is tuple:
        return Annotated[Any, optional_number("", args[0], len(args), text, usual)], None
    if kind in (int, float):
        return Annotated[Any, optional_number("", kind, 1, text, usual)], None
    known = {"suit": suits, "gravity": gravities}.get(name, lambda: ("MODULE:FUNCTION",))
    return Annotated[Any, choice(known, text, hint=usual)], None


def _without_none(hint: Any) -> Any:
    kinds = [one for one in get_args(hint) if one is not NoneType]
    return kinds[0] if NoneType in get_args(hint) and len(kinds) == 1 else hint


def _texts(config: type) -> dict[str, str]:
    """Returns the texts of the fields in the docstring of a dataclass, by name."""
    _, _, attributes = inspect.cleandoc(config.__doc__ or "").partition("Attributes:\n")
    found = re.findall(r"^    (\w+): (.+(?:\n {8}.+)*)", attributes, re.MULTILINE)
    return {name: " ".join(text.split()) for name, text in found}


def _given(found: Iterable[tuple[str, Any, Any]]) -> dict[str, Any]:
    """Returns the values of the flags that are given, with a dict for each group."""
    given = {}
    for name, value, default in found:
        if is_dataclass(value):
            inner = ((one.name, getattr(value, one.name), one.default) for one in fields(value))
            if plain := _given(inner):
                given[name] = plain
        elif value is not default and value != ():
            given[name] = value
    return given


def choice(
    names: Callable[[], Iterable[str]],
    help: str | None = None,
    usual: str | None = None,
    values: Mapping[str, Any] | None = None,
    name: str | None = None,
    hint: str | None = None,
) -> Any:
    """Describes an option that takes a name from a registry.

    The help lists the names that the registry has when the command runs, with names of extensions.
    The option itself takes any text: the function that looks the name up refuses an unknown name,
    with a sentence that suggests the closest name.

    Args:
        names: Function that returns the names; a name in capitals stands for a file or a folder.
        help: Help text; by default the text in the docstring of the command.
        usual: Meaning of None, where None is the default.
        values: Values that names stand for; by default the names themselves.
        name: Name of the option, where the name is no name of a Python argument.
        hint: Text behind the help text; by default the default value.

    Returns:
        An annotation for the type of the option, as in `Annotated[str, choice(...)]`.
    """
    if hint is None and usual:
        hint = f"(default: {usual})"
    return tyro.conf.arg(
        name=name,
        constructor_factory=lambda: _one_of(names(), values or {}),
        help=help,
        help_behavior_hint=_default if hint is None else hint,
    )


def _one_of(names: Iterable[str], values: Mapping[str, Any]) -> Any:
    spec = PrimitiveConstructorSpec(
        nargs=1,
        metavar=f"{{{','.join(names)}}}",
        instance_from_str=lambda given: values.get(given[0], given[0]),
        is_instance=lambda value: isinstance(value, str),
        str_from_instance=lambda value: [value],
    )
    return Annotated[str, spec]


def optional_number(
    usual: str,
    kind: type[int] | type[float] = float,
    count: int = 1,
    help: str | None = None,
    hint: str | None = None,
) -> Any:
    """Describes an option that takes a number, or a tuple of `count` numbers, with default None.

    `usual` says what None means; `help` and `hint` are as in `choice`. The result is an annotation
    for the type of the option, as in `Annotated[float | None, optional_number(...)]`.
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
        help_behavior_hint=f"(default: {usual})" if hint is None else hint,
    )


def _default(label: str) -> str:
    # Beside a constructor of ours, tyro shows the default as a Python list.
    return f"(default: {' '.join(map(str, literal_eval(label)))})"


def names_of(module: str, registry: str, *others: str) -> Callable[[], list[str]]:
    """Returns a function that lists the names of a registry, and imports its module when called.

    `registry` may also be the name of a function that returns the names. `others` are listed behind
    the names; `others` in capitals stand for a file or a folder.
    """

    def names() -> list[str]:
        found: Any = getattr(import_module(f"...{module}", __name__), registry)
        if callable(found):
            found = found()
        return [*found, *others]

    return names


correctable = names_of("envs.policies", "POLICIES")  # policies that are no networks
networks = names_of("envs.policies.trained", "shipped_policies", "FOLDER")
bounds = names_of("envs.evaluation", "BOUNDS")
suits = names_of("assets", "suit_names", "FILE.json")
gravities = names_of("envs.model.config", "GRAVITY")
joints = names_of("assets", "JOINTS")
shipped_tasks = names_of("envs.tasks", "TASKS")
tasks = names_of("envs.tasks", "TASKS", "FILE.csv")
uses = names_of("envs.tasks", "TASKS", "FILE.csv", "any")  # intended uses of a model
levels = names_of("envs.domain.levels", "LEVELS")
scores = names_of("envs.extras", "SCORES")
drawings = names_of("envs.extras", "DRAWINGS")


def policies() -> list[str]:
    """Returns the names of the policies."""
    return [*correctable(), *networks()]


def evaluated() -> list[str]:
    """Returns the names of policies and bounds."""
    return [*policies(), *bounds()]


USUAL_TASK = "ArmTracking"
ENV, GRAVITY, LIMIT = f"ActiveSuit/{USUAL_TASK}-v0", "earth", "max_episode_steps"
Env = Annotated[
    str | None,
    choice(
        lambda: ("MODULE:ID",),
        "Id of an environment of your own as MODULE:ID, in place of --task; importing the module "
        "registers the id.",
        "that of the task",
    ),
]
TaskName = Annotated[
    str | None,
    choice(
        tasks,
        "Name of a shipped task; or a CSV file with the columns time [s] and the four joint angles "
        "[rad] of a motion.",
        f"that of a trained policy, else {USUAL_TASK}",
    ),
]
Level = Annotated[
    str | None,
    choice(
        levels,
        "Level of the differences from the arm that a controller was made for; options that are "
        "given replace options of the level.",
        "that of a trained policy, else nominal",
    ),
]
SuitName = Annotated[str, choice(suits, "Name of a shipped suit, or path of a suit file.")]
Use = Annotated[
    str | None,
    choice(
        uses,
        "Intended motions of the model: a shipped task; a CSV file with the column angle_rad, or "
        "the angles of all joints, and time_s; or any motion in the range of the curves. The "
        "command says what the curves do not determine about these motions.",
        "none",
        name="for",
    ),
]
_POLICY = (
    "Name of a {}, also with options (adaptive:suit=elbow.json,forgetting=10), or MODULE:CLASS of "
    "your own; or folder of a training run, whose task and options are then used."
)
PolicyName = Annotated[str, choice(policies, _POLICY.format("policy"))]
EvaluatedName = Annotated[str, choice(evaluated, _POLICY.format("policy or bound"))]
Scores = Annotated[
    tuple[Annotated[str, choice(scores)], ...],
    tyro.conf.arg(help="Scores of extras, which state the cost of motions in other numbers too."),
]
Draw = Annotated[str | None, choice(drawings, "Drawing of an extra beside the moving arm.", "none")]
Motions = Annotated[
    int,
    tyro.conf.arg(help="Number of motions of each policy, at least 8; the same for all policies."),
]
_SEED = "Seed of all random numbers; the same seed repeats the result."
Seed = Annotated[int, tyro.conf.arg(help=_SEED)]
RunSeed = Annotated[int | None, optional_number("0", int, help=_SEED)]
Json = Annotated[bool, tyro.conf.arg(help="Print the result as JSON in place of tables.")]
Trust = Annotated[
    bool,
    tyro.conf.arg(help="Let JSON files of policies name MODULE:CLASS, whose code then runs."),
]
Force = Annotated[bool, tyro.conf.arg(help="Replace existing files, and write into any folder.")]
