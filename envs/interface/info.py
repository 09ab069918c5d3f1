"""An info dict whose content is computed when it is first read."""

from collections.abc import Callable
from typing import Any


class Info(dict[str, Any]):
    """A dict that is filled when it is first read; most infos are never read.

    `time` is the entry "time", which exists at once, since `json` writes an empty dict unread.
    `read` returns the content, as of the moment when the info was made.
    """

    __slots__ = ("_read",)

    def __init__(self, time: float, read: Callable[[], dict[str, Any]]) -> None:
        dict.__init__(self, time=time)
        self._read: Callable[[], dict[str, Any]] | None = read

    def _fill(self) -> None:
        read, self._read = self._read, None
        if read is not None:
            for name, value in read().items():
                dict.setdefault(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        self._fill()
        return dict, (dict(self.items()),)


def _filled(name: str) -> Callable[..., Any]:
    method = getattr(dict, name)

    def call(self: Info, *arguments: Any, **named: Any) -> Any:
        self._fill()
        return method(self, *arguments, **named)

    call.__name__ = name
    return call


for _name in (
    *("__contains__", "__delitem__", "__eq__", "__getitem__", "__ior__", "__iter__", "__len__"),
    *("__ne__", "__or__", "__repr__", "__reversed__", "__ror__", "clear", "copy", "get", "items"),
    *("keys", "pop", "popitem", "setdefault", "update", "values"),
):
    setattr(Info, _name, _filled(_name))
