"""`activesuit list tasks`: lists the tasks, or says what one is."""

from dataclasses import asdict
from typing import Annotated, Any

import tyro

from ...envs.making import OURS
from ...envs.tasks import TASKS, Task
from ...errors import unknown_name
from ...text import say
from ..folders import to_json
from ..options import Json, choice, shipped_tasks
from ..output import table


def tasks(
    name: Annotated[str | None, choice(shipped_tasks, usual="all"), tyro.conf.Positional] = None,
    /,
    json: Json = False,
) -> None:
    """List the tasks, or say what one is.

    Args:
        name: Name of a task.
    """
    if name not in (None, *TASKS):
        raise unknown_name("task", name, TASKS)
    chosen = {one: task for one, task in TASKS.items() if name in (None, one)}
    if json:
        print(to_json({one: _about(one, task) for one, task in chosen.items()}))
        return
    rows = [
        [f"{OURS}{one}-v0", f"{task.duration:g} s", task.place, task.about]
        for one, task in chosen.items()
    ]
    table("tasks", ["id", "duration", "place", "motion and load"], rows)
    for one, task in chosen.items():
        say(f"{one} succeeds with {task.rule}. Source: {task.source}.")


def _about(name: str, task: Task) -> dict[str, Any]:
    said = {one: getattr(task, one) for one in ("place", "about", "source", "rule")}
    return {**asdict(task), "id": f"{OURS}{name}-v0", **said}
