"""Independent calls in threads, where Ctrl-C keeps the finished results."""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar, cast

from joblib import Parallel, delayed

Result = TypeVar("Result")


def run_threads(
    calls: Sequence[Callable[[], Result]],
    workers: int,
    on_result: Callable[[Result], None] | None = None,
) -> tuple[list[Result], bool]:
    """Makes all calls; returns the results in any order, and whether Ctrl-C ended it before.

    Args:
        calls: Functions that spend nearly all of their time in kernels that release the GIL.
        workers: Number of threads; -1 uses all cores.
        on_result: Function that gets each result as soon as it is known.

    Raises:
        KeyboardInterrupt: Nothing was finished by then.
    """
    finished: list[Result] = []
    parallel = Parallel(
        n_jobs=min(workers, len(calls)), prefer="threads", return_as="generator_unordered"
    )
    try:
        for result in cast(Iterable[Result], parallel(delayed(call)() for call in calls)):
            finished.append(result)
            if on_result is not None:
                on_result(result)
    except KeyboardInterrupt:
        if not finished:
            raise
        return finished, True
    return finished, False
