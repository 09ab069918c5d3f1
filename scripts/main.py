"""The program `activesuit`: finds the command, runs it, and reports a mistake."""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module

from .. import __version__
from ..errors import InputError, refuse_old_names, unknown_name
from ..text import visible
from .engine_log import engine_warnings
from .names import check_names

SIGNALS = (signal.SIGINT, signal.SIGTERM)

# The first word of each is a module of `commands`, the last one its function. Only the module that
# is asked for is imported, because all of them together take more than a second. The sentence is
# the beginning of that function's own help.
GROUPS = {
    "Start": {
        "demo": "Do the whole job once: identify, simulate, compensate, report.",
        "doctor": "Check this installation, and say how to mend what fails.",
        "list suits": "List the shipped suits, or show and check one.",
        "list tasks": "List the tasks, or say what one is.",
        "list policies": "List the policies, with the sensors that they need and their options.",
    },
    "Identify": {
        "identify": "Identify a hysteresis model from measured angle-torque curves.",
        "design": "Design the next record to measure: nested reversals at varied speed.",
        "rig": "Measure first-order curves of a suit joint on a simulated rig.",
    },
    "Simulate and look": {
        "simulate": "Simulate one assisted arm motion, headless.",
        "view": "Watch the assisted arm move in a window; film or picture it.",
    },
    "Evaluate": {
        "evaluate": "Compare assist policies by what the wearer has to do.",
        "validate": "Validate an identified suit model in closed loop.",
    },
    "Train": {
        "train": "Train an assist policy with Stable-Baselines3.",
        "export": "Export a policy as an ONNX model, or a suit or a policy as C code for a device.",
    },
    "Benchmark": {
        "benchmark": "Compare controllers over tasks, levels and suits.",
    },
}
COMMANDS = {name: help for commands in GROUPS.values() for name, help in commands.items()}
MAIN_COMMANDS = sorted({name.split()[0] for name in COMMANDS})
PARTS = {  # commands that are nothing without one of these words
    one: [name.split()[1] for name in COMMANDS if name.startswith(f"{one} ")]
    for one in MAIN_COMMANDS
    if one not in COMMANDS
}
RENAMED = {
    **{name: f"list {name}" for name in ("suits", "tasks", "policies")},
}
_EXAMPLE = "python examples/{}.py of the source repository"
_PAPER = "python -m activesuit.reproductions.{} of the source repository (make reproduce)"
MOVED = {  # commands that are gone, and what to run in their place
    **{f"measure {name}": f"activesuit {name}" for name in ("design", "rig")},
    "measure": "activesuit design or activesuit rig",
    "animate": "activesuit view --film FILE",
    "warm": "activesuit doctor --compile",
    "report": "the command of that folder again, which makes its page",
    "tasks --table": "activesuit benchmark run --tasks NAME",
    "bench": "make bench in a clone of the source repository",
    **{name: _EXAMPLE.format(name) for name in ("knowledge", "branch", "envelope", "tune")},
    **{
        f"evaluate {name}": _EXAMPLE.format(name)
        for name in ("knowledge", "faults", "branch", "envelope")
    },
    **{f"benchmark {name}": _EXAMPLE.format(name) for name in ("learning", "tune")},
    **dict.fromkeys(("reproduce li-2022", "study"), _PAPER.format("li_2022")),
    **dict.fromkeys(("reproduce kao-fung-2009", "kao-fung"), _PAPER.format("kao_fung_2009")),
}
OLD_OPTIONS = {  # of version 0.2, and what to do in their place
    **{
        f"--{old}": f"write --{new}"
        for old, new in {
            **{name: f"wearer.{name}" for name in ("stature", "mass", "sex", "strength")},
            **{"episodes": "motions", "naive": "unadapted", "suits": "randomize.suits"},
            **{"samples": "randomize.suit samples", "belief": "belief.suit"},
        }.items()
    },
    "--set": "write --NAME VALUE for each, as in --fatigue true --sensing.rate-cutoff 10",
    "--video": "run activesuit view --film FILE",
    **dict.fromkeys(("--web", "--host", "--port"), "run activesuit view --film FILE"),
    "--export": "run load_suit(SUIT).at_pressure(KPA).save(FILE) in Python",
    "--pose": "leave it out, since a picture shows the beginning of the motion",
    **dict.fromkeys(("--width", "--height"), "write --size WIDTH HEIGHT"),
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs one command; after a user's mistake, prints one sentence and exits with code 2.

    SIGTERM, by which a scheduler ends a job, does what Ctrl-C does.
    """
    with mistakes_reported():
        _run(sys.argv[1:] if arguments is None else list(arguments))


@contextmanager
def mistakes_reported() -> Iterator[None]:
    """Runs the block as a program; after a user's mistake it ends with one sentence and code 2."""
    try:
        with _interruptible():
            yield
            sys.stdout.flush()
    except InputError as error:
        _stop(f"error: {error}")
    except KeyboardInterrupt as interrupt:
        # If it came while a library ran a text as code, `python -m` would end by SIGINT, whatever
        # the exit code; another text makes it forget that.
        exec("")
        _stop(f"interrupted: {interrupt}" if interrupt.args else "interrupted")
    except MemoryError as error:
        _stop(f"error: there is not enough memory ({error}): ask for less at once")
    except BrokenPipeError:  # the reader of our output, `head` for one, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        _stop(f"error: {InputError(error)}")  # which is short, and one line
    finally:
        if folders := sys.modules.get(f"{__package__}.folders"):
            folders.close_folders()


@contextmanager
def _interruptible() -> Iterator[None]:
    """Makes Ctrl-C and SIGTERM raise KeyboardInterrupt, whatever a library makes of it."""
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
        if came:  # compiled modules turn it into an ImportError while they are loaded
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
        print(_help_of_parts(name))
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
    refuse_old_names([name], RENAMED)
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


def _help_of_parts(name: str) -> str:
    lines = (f"  {part:15}{COMMANDS[f'{name} {part}']}" for part in PARTS[name])
    return "\n".join([f"usage: activesuit {name} PART [arguments]", "", "parts:", *lines])


def function_of(name: str) -> Callable[..., object]:
    """Returns the function of a command."""
    words = name.split()
    return getattr(import_module(f".commands.{words[0]}", __package__), words[-1])


def _run_command(name: str, arguments: Sequence[str]) -> None:
    check_names(name, arguments, OLD_OPTIONS)
    from .extensions import import_from_here, load_extensions
    from .options import parsed

    load_extensions()
    # A policy or an environment as module:name, or a file of a policy that may have one.
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
