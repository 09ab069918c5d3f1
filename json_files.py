"""Reads JSON files of users; any mistake in such a file is reported in one sentence."""

import json
import os
from collections import Counter
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from .errors import InputError, shown
from .files import content_of

LARGEST = 64 * 2**20  # bytes; a suit file takes some thousand
DEEPEST = 50  # greatest depth of nested lists and objects; a suit file has a depth of 7
MOST_DIGITS = 400  # most digits of a whole number; a number of more than 309 digits is no float
REMAKE = "restore or remake it"
Model = TypeVar("Model", bound=BaseModel)


def read_json(path: str | os.PathLike[str], what: str) -> Any:
    """Returns the content of a JSON file (UTF-8, with or without a byte order mark).

    `what` names the file in the error sentence ("suit").
    """
    content = content_of(path, what, LARGEST)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"cannot read the {what} {shown(str(path))}: not a UTF-8 text file"
        ) from error
    return parse_json(text, str(path))


def modelled(content: Any, model: type[Model], name: str, what: str, fix: str = REMAKE) -> Model:
    """Returns the content of a JSON file as a model of pydantic."""
    try:
        return model.model_validate(content)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"])) or "content"
        raise InputError(
            f"{name!r} is no {what}: its {place} is wrong ({first['msg']}); {fix}"
        ) from None


def parse_json(text: str, name: str, fix: str = REMAKE) -> Any:
    """Returns the content of JSON text; `name` begins the error messages, and `fix` ends them."""

    def without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            twice = Counter(one for one, _ in pairs).most_common(1)[0][0]
            raise InputError(f"{name} has {shown(twice)} twice in one object: remove one of them")
        return found

    def integer(digits: str) -> int:
        if len(digits) > MOST_DIGITS:
            raise InputError(
                f"{name} has a number of {len(digits):,} digits: give at most {MOST_DIGITS}"
            )
        return int(digits)

    try:
        content = json.loads(text, object_pairs_hook=without_repeats, parse_int=integer)
        _check_depth(content)
    except json.JSONDecodeError as error:
        raise InputError(
            f"{name} is not complete JSON (line {error.lineno}: {error.msg}): {fix}"
        ) from error
    except RecursionError:
        raise InputError(
            f"{name} has more than {DEEPEST} lists or objects inside each other: {fix}"
        ) from None
    return content


def _check_depth(content: Any) -> None:
    level = [content]
    for _ in range(DEEPEST + 1):
        level = [
            inner
            for outer in level
            if isinstance(outer, (dict, list))
            for inner in (outer.values() if isinstance(outer, dict) else outer)
        ]
        if not level:
            return
    raise RecursionError
