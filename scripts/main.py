"""The program `activesuit`: finds the command, runs it, and reports a mistake."""

import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from .. import __version__
from ..errors import InputError, unknown_name
from ..text import visible
from .commands import COMMANDS, GROUPS, MAIN_COMMANDS, PARTS, function_of
from .engine_log import engine_warnings
from .names import check_names
from .old_names import MOVED

SIGNALS = (signal.SIGINT, signal.SIGTERM)


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs one command; after a user's mistake, prints one sentence and exits with code 2.

    SIGTERM, by which a scheduler ends a job, has the same effect as Ctrl-C.
    """
    with mistakes_reported():
        _run(sys.argv[1:] if arguments is None else list(arguments))


@contextmanager
def mistakes_reported() -> Iterator[None]:
    """Runs the block as a program; a user's mistake ends it with one sentence and code 2."""
    try:
        with _interruptible():
            yield
            sys.stdout.flush()
    except InputError as error:
        _stop(f"error: {error}")
    except KeyboardInterrupt as interrupt:
        # After Ctrl-C inside code that a library executes from a text, `python -m` ends by SIGINT,
        # whatever the exit code; executing another text resets that state.
        exec("")
        _stop(f"interrupted: {interrupt}" if interrupt.args else "interrupted")
    except MemoryError as error:
        _stop(f"error: there is not enough memory ({error}): ask for less at once")
    except BrokenPipeError:  # the reader of our output, such as `head`, has ended
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        _stop(f"error: {InputError(error)}")  # InputError makes the message one short line
    finally:
        if folders := sys.modules.get(f"{__package__}.folders"):
            folders.close_folders()


@contextmanager
def _interruptible() -> Iterator[None]:
    """Makes Ctrl-C and SIGTERM raise KeyboardInterrupt, even where a library replaces it."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread gets signals
        return
    came = []

    def interrupt(number: int, frame: object) -> None:
        came.append(number)
        raise KeyboardInterrupt

    handled = [one for one in SIGNALS if signal.getsignal(one) is not signal.SIG_IGN]
    before = {one: signal.signal(one, interrupt) for one in handled}
    try:
        yield
    except Exception as error:
        if came:  # a compiled module turns a KeyboardInterrupt at its import into an ImportError
            raise KeyboardInterrupt from error
        raise
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)


def _run(arguments: Sequence[str]) -> None:
    if not arguments:
        raise InputError(f"give a command: {', '.join(MAIN_COMMANDS)}; --help says what they do")
    name, *rest = arguments
    if name == "--version":
        print(f"activesuit {__version__}")
    elif name in ("-h", "--help", "help"):
        print(_help())
    elif name in PARTS and (not rest or rest[0] in ("-h", "--help")):
        lines = (f"  {part:15}{COMMANDS[f'{name} {part}']}" for part in PARTS[name])
        print(f"usage: activesuit {name} PART [arguments]", "", "parts:", *lines, sep="\n")
    else:
        _run_command(*command_of(arguments))


def command_of(arguments: Sequence[str]) -> tuple[str, Sequence[str]]:
    """Returns the name of a command, and the arguments behind the name."""
    for old, new in MOVED.items():
        if list(arguments[: old.count(" ") + 1]) == old.split():
            raise InputError(f"{old!r} is no command since version 0.3: run {new}")
    name, *rest = arguments
    if rest and f"{name} {rest[0]}" in COMMANDS:
        return f"{name} {rest[0]}", rest[1:]
    if name in COMMANDS:
        return name, rest
    if name in PARTS:
        raise unknown_name(f"part of {name}", rest[0], PARTS[name])
    raise unknown_name("command", name, MAIN_COMMANDS)


def _help() -> str:
    width = max(map(len, COMMANDS))
    lines = [
        "usage: activesuit COMMAND [arguments]",
        "       activesuit COMMAND --help",
        "       activesuit --version",
        "",
        "Identify, simulate and compensate the hysteretic joints of a spacesuit.",
    ]
    for title, commands in GROUPS.items():
        lines += ["", f"{title}:"]
        lines += [f"  {name:{width}}  {sentence}" for name, sentence in commands.items()]
    return "\n".join(lines)


def _run_command(name: str, arguments: Sequence[str]) -> None:
    check_names(name, arguments)
    from .extensions import import_from_here, load_extensions
    from .options import parsed

    load_extensions()
    # The user names a policy or an environment as module:name, or trusts files that may do so.
    if "--trust" in arguments or any(":" in given for given in arguments):
        import_from_here()
    call = parsed(function_of(name), f"activesuit {name}", arguments)
    with engine_warnings():
        call()


def _stop(message: str) -> None:
    print(visible(f"activesuit: {message}".replace("\n", " ")), file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    main()
