"""Code from outside this package: extensions that are installed, and modules of a user.

Extensions add models and fits; the modules of a user have policies, environments and rewards.
"""

import os
import sys
from functools import cache
from importlib.metadata import entry_points

from ..errors import InputError

GROUP = "activesuit"  # entry points; each names a module that registers models or fits


@cache
def load_extensions() -> None:
    """Imports the modules that installed packages name in the entry point group "activesuit".

    Only the first call looks for them, since the search reads a file of every installed package.
    """
    for extension in entry_points(group=GROUP):
        try:
            extension.load()
        except Exception as error:  # an extension fails in any way that a module can
            name = extension.dist.name if extension.dist else extension.name
            raise InputError(
                f"the extension {name!r} cannot be imported ({type(error).__name__}: {error}): "
                "repair or uninstall it"
            ) from error


def import_from_here() -> None:
    """Makes the modules of the working folder importable, after all installed modules.

    Call this only where the user names a module on the command line, trusts a file that names a
    module, or resumes a training run of this user on this machine.
    """
    here = os.getcwd()
    if here not in sys.path:
        sys.path.append(here)
