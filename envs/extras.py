"""Extras by name: scores of motions beside effort, and drawings beside an arm that moves.

A package names its extras in the entry point group `activesuit.scores` or `activesuit.drawings`. An
extra is imported when its name is asked for, and no other module has to know the extra.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

from ..errors import InputError, unknown_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .evaluation import Trace
    from .rendering import Capsule
    from .simulation.simulation import Simulation

Extra = TypeVar("Extra")
Drawing = Callable[["Simulation"], Callable[[], Sequence["Capsule"]]]
"""Function of a simulation that returns a second function, or raises InputError if nothing can be
drawn. The second function is called in every control period, and returns what to draw beside the
first arm."""
STANDARD = "standard"  # convention under which costs are compared


class Scored(NamedTuple):
    """What motions of one policy cost.

    Attributes:
        costs: Costs by name and by convention, with one value per motion; NaN where a motion has
            none. Conventions are choices that nobody can settle: relief comes with its range over
            them, and the one that counts is "standard".
        facts: Other numbers about all motions, alone or by name.
    """

    costs: dict[str, dict[str, tuple[float, ...]]]
    facts: dict[str, float | dict[str, float]]


@dataclass(frozen=True, kw_only=True)
class Score:
    """A score of motions beside effort.

    Attributes:
        check: Function that raises InputError where the extra is not complete, or motions of a
            simulated arm cannot be scored.
        scored: Function of the motions of one policy, a sequence of `Trace`, with the keywords
            `threads`, where 0 is all cores, and `on_motion`, a function to call after each motion.
        least: Least cost of a suit for relief to have a meaning, by the name of a cost.
        units: Units of costs and facts by name, "1" for a ratio.
        limits: Facts that limit a score: the value from which a report says so, and the sentence.
        figure: Function that draws some motions, by the name of each; None for no figure.
    """

    check: "Callable[[Simulation], None]"
    scored: Callable[..., Scored]
    least: Mapping[str, float]
    units: Mapping[str, str]
    limits: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    figure: "Callable[[Mapping[str, Trace]], Figure] | None" = None


class Registry(Generic[Extra]):
    """Extras of one kind by name; iteration yields the names.

    The entry point group has the plural of the kind.
    """

    def __init__(self, kind: str) -> None:
        self._kind, self._registered = kind, dict[str, Extra]()

    def register(self, name: str, extra: Extra) -> None:
        """Registers an extra in this process."""
        if name in self:
            raise InputError(f"there is another {self._kind} {name!r}: choose another name")
        self._registered[name] = extra

    def find(self, name: str) -> Extra:
        """Returns an extra by its name."""
        if name not in self:
            raise unknown_name(self._kind, name, self)
        if name in self._registered:
            return self._registered[name]
        try:
            return self._installed[name].load()
        except Exception as error:  # an extension fails in any way that a module can
            raise InputError(
                f"the {self._kind} {name!r} cannot be imported ({type(error).__name__}: {error}): "
                "repair or uninstall its package"
            ) from error

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys((*self._registered, *self._installed)))

    @cached_property
    def _installed(self) -> dict[str, EntryPoint]:
        return {one.name: one for one in entry_points(group=f"activesuit.{self._kind}s")}


SCORES: Registry[Score] = Registry("score")
DRAWINGS: Registry[Drawing] = Registry("drawing")
