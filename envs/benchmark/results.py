"""Results of the benchmark: each trial makes one, and files of JSON lines can be merged."""

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
    WrapValidator,
)

from ...errors import InputError, one_line, shortened, shown
from ...files import content_of
from ...json_files import parse_json
from ..domain.levels import LEVELS
from ..evaluation import BOUNDS, REFERENCES
from ..evaluation.best_known_plan import HOT
from ..evaluation.compare import least_effort
from ..evaluation.reasons import Frequent, most_frequent
from ..evaluation.run import Run, Runnable, run
from ..policies import policy_spec
from ..tasks import TASKS
from .suites import Suite, Trial

RESULTS = "results.jsonl"
Size = Annotated[float, Field(ge=0, le=1e6, strict=True)]  # an effort or an error
# The same in memory, where null is infinite.
Kept = Annotated[Size, WrapValidator(lambda one, check: math.inf if one is None else check(one))]
Name = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(one_line)]
LARGEST = 2**28  # bytes
SIZES = ("effort", "assisted_effort", "tracking")
SERIES = (*SIZES, "success")  # one value per motion
DIGITS = 6  # significant digits of efforts and errors
BEGINS = ("compensation", "observer")  # policies from whose torques a plan at the heat limit begins
SMALLEST = 12  # number of decimals; smaller errors are rounding


@dataclass(frozen=True, kw_only=True)
class Result:
    """Result of one trial; a tuple has one value per motion.

    Effort and tracking error are infinite for a failed policy.
    """

    __pydantic_config__ = ConfigDict(extra="forbid")

    task: str
    level: str
    believed: Name  # suit that controllers believe in
    policy: Name  # name of the policy in tables
    options: dict[str, Any]  # policy and options as plain values
    # Effort of the adapted wearer over strength, of four joints and of those that can have a motor.
    effort: Annotated[tuple[Kept, ...], Field(min_length=1)]
    assisted_effort: tuple[Kept, ...]
    tracking: tuple[Kept, ...]  # tracking error [rad]
    success: tuple[bool, ...]  # whether the motion exceeded no limit of success
    failed: str | None  # reason why the policy could not act
    protocol: dict[str, Any]  # version, contract, seeds, motions and packages of the run
    motion: tuple[int, ...] = ()  # number of the first motion with the same intention
    chatter: tuple[Kept, ...] = ()  # sum of the squared changes of the action
    why: tuple[Frequent, ...] = ()  # exceeded limits of success, the most frequent first

    def to_json(self) -> str:
        """Returns one line of strict JSON, with null for infinite values."""
        content = asdict(self)
        for name in (*SIZES, "chatter"):
            content[name] = [value if math.isfinite(value) else None for value in content[name]]
        return json.dumps(content, allow_nan=False, sort_keys=True, default=str)

    @classmethod
    def from_json(cls, text: str, name: str) -> "Result":
        """Returns the result in a line of JSON; error messages begin with `name`."""
        try:
            found = _RESULT.validate_python(parse_json(text, name, fix="delete it"))
        except ValidationError as error:
            problem: Any = error.errors()[0]
            place = ".".join(map(str, problem["loc"])) or "the whole"
            reason = shortened(f"{place}: {problem['msg']}", 120)
            raise InputError(
                f"{name} is no result of the benchmark ({reason}): delete it"
            ) from None
        for what, one, known in (("task", found.task, TASKS), ("level", found.level, LEVELS)):
            if one not in known:
                raise InputError(f"{name} has the {what} {shown(one)}: delete it")
        lengths = {len(getattr(found, series)) for series in SERIES}
        more = {len(found.motion), len(found.chatter)} - {0}  # absent in results of 0.2
        if len(lengths | more) > 1:
            raise InputError(f"{name} has series of different lengths: delete it")
        said, motions = found.protocol.get("episodes"), len(found.effort)
        if said not in (None, motions):
            raise InputError(
                f"{name} has {motions} motions, and its protocol {shown(said)}: delete the line"
            )
        return found


_RESULT = TypeAdapter(Result)


def lines(results: Iterable[Result]) -> str:
    """Returns the text of a file of results."""
    return "".join(one.to_json() + "\n" for one in results)


def read_results(paths: Sequence[Path]) -> list[Result]:
    """Reads and merges results of several runs: files of results, or folders with such a file.

    Results of different contracts cannot be compared, and are refused.
    """
    found: dict[tuple[str, ...], tuple[Result, str]] = {}
    contract = ""
    for given in paths:
        path = given / RESULTS if given.is_dir() else given
        for number, text in enumerate(read_text(path).splitlines(), start=1):
            result = Result.from_json(text, f"{str(path)!r}, line {number},")
            mine = str(result.protocol.get("contract"))
            contract = contract or mine
            if mine != contract:
                raise InputError(
                    f"{str(path)!r} has results of the contract {mine!r}, and earlier results have "
                    f"{contract!r}: run the trials again"
                )
            key = (result.task, result.level, result.believed, result.policy)
            known, first = found.setdefault(key, (result, str(path)))
            if known != result:
                raise InputError(
                    f"{str(path)!r} and {first!r} have different results of "
                    f"{result.policy} in {result.task} at {result.level}: leave one of them out"
                )
    if not found:
        raise InputError(
            "there are no results: give a file or folder of `activesuit benchmark run`"
        )
    return [result for result, _ in found.values()]


def read_text(path: Path, what: str = "results") -> str:
    """Returns the text of a file of results."""
    try:
        return content_of(path, what, LARGEST).decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"cannot read the {what} {str(path)!r}: not a UTF-8 text") from error


def run_trial(suite: Suite, trial: Trial) -> Result:
    """Runs one policy on all motions of a setting, with adapted wearers, on one thread.

    If the policy cannot act, every motion is failed, and the result has the reason.
    """
    episodes, name = suite.motions_of(trial.policy), trial.policy.name
    seeds = range(suite.first_seed, suite.first_seed + episodes)
    env = f"ActiveSuit/{trial.setting.task}-v0"
    given = name if name in (*REFERENCES, *BOUNDS) else trial.policy
    found: dict[str, Any] = {"failed": None}
    try:
        options = suite.environment(trial.setting)
        score = _run(trial.label, given, env, seeds, threads=1, **options).score
    except InputError as error:
        found = dict.fromkeys(SIZES, (math.inf,) * episodes)
        found |= {"success": (False,) * episodes, "failed": str(error)}
    else:
        found |= {size: tuple(map(_rounded, getattr(score, size))) for size in SIZES}
        found |= {"success": score.success, "why": most_frequent(score.why)}
        found |= {"motion": score.motion, "chatter": tuple(map(_rounded, score.costs["chatter"]))}
    return Result(
        **trial.setting._asdict(),
        policy=trial.label,
        options=trial.policy.to_dict(),
        protocol=suite.protocol(trial.policy),
        **found,
    )


def _run(name: str, given: Runnable, env: str, seeds: range, **options: Any) -> Run:
    """Runs a policy; where motors are hot the best known plan begins from policies, too."""
    found = run(name, given, env, seeds, **options)
    if given != BOUNDS[1] or max(found.score.costs["heat"]) < HOT:
        return found
    begins = [run(one, policy_spec(one), env, seeds, **options).traces for one in BEGINS]
    return run(name, given, env, seeds, rivals=least_effort(begins), **options)


def _rounded(value: float) -> float:
    """Returns a rounded value, and infinity for NaN."""
    return math.inf if math.isnan(value) else float(f"{round(value, SMALLEST):.{DIGITS}g}")
