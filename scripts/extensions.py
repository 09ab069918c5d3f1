"""Code from outside this package: extensions that are installed, and modules of a user.

Extensions have models and fits beside our own. The modules are policies, environments and rewards.
"""

import os
import sys
from functools import cache
from importlib.metadata import EntryPoint, entry_points

from ..errors import InputError

GROUP = "activesuit"  # entry points; each names a module that registers what it adds


@cache
def load_extensions() -> None:
    """Imports the modules that installed packages name in the entry point group "activesuit".

    That reads a file of every installed package, so only the first call does it.
    """
    for extension in entry_points(group=GROUP):
        _load(extension)


def import_from_here() -> None:
    """Lets a module of the working folder be imported, after all that are installed.

    Only where the user names a module, or trusts a file that names one: on the command line, or in
    the card of a training run of this user on this machine.
    """
    here = os.getcwd()
    if here not in sys.path:
        sys.path.append(here)


def _load(extension: EntryPoint) -> None:
    try:
        extension.load()
    except Exception as error:  # an extension fails in any way that a module can
        name = extension.dist.name if extension.dist else extension.name
        raise InputError(
            f"the extension {name!r} cannot be imported ({type(error).__name__}: {error}): repair "
            "or uninstall it"
        ) from error
