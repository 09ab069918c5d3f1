"""Extensions: installed packages whose models and fits the command line has beside our own."""

from functools import cache
from importlib.metadata import EntryPoint, entry_points

from ..errors import InputError

GROUP = "activesuit"  # entry points; each names a module that registers what it adds


@cache
def load_extensions() -> None:
    """Imports the modules that installed packages name in the entry point group "activesuit".

    That reads a file of every installed package, so only the first call does it.

    Raises:
        InputError: One of them cannot be imported.
    """
    for extension in entry_points(group=GROUP):
        _load(extension)


def _load(extension: EntryPoint) -> None:
    try:
        extension.load()
    except Exception as error:  # an extension fails in any way that a module can
        name = extension.dist.name if extension.dist else extension.name
        raise InputError(
            f"the extension {name!r} cannot be imported ({type(error).__name__}: {error}): repair "
            "or uninstall it"
        ) from error
