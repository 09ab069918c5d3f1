"""The program `activesuit`: finds the command, runs it, and reports a mistake."""

import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module

from .. import __version__
from ..errors import InputError, refuse_old_names, unknown_name
from .engine_log import engine_warnings
from .folders import close_folders
from .text import visible

SIGNALS = (signal.SIGINT, signal.SIGTERM)

# Each is a function in a module of `commands` with the same name. Only the module that is asked for
# is imported, because all of them together take more than a second. The sentence is the beginning
# of that function's own help.
GROUPS = {
    "Start": {
        "demo": "Do the whole job once: identify, simulate, compensate, report.",
    },
    "Measure and identify": {
        "identify": "Identify a hysteresis model from measured angle-torque curves.",
        "design": "Design the next record to measure: nested reversals at varied speed.",
        "rig": "Measure first-order curves of a suit joint on a simulated rig.",
        "suits": "List the shipped suits, or show and check one.",
    },
    "Simulate and look": {
        "simulate": "Simulate one assisted arm motion, headless.",
        "view": "Watch the assisted arm move, in a window or a browser; or take a picture of it.",
        "animate": "Draw an assisted motion and its torque-angle loops as an animation.",
        "tasks": "List the tasks, or measure how difficult each is.",
        "envelope": "Measure the work envelope: unsuited, suited and assisted.",
    },
    "Control": {
        "policies": "List the policies, with the sensors that they need and their options.",
        "evaluate": "Compare assist policies by what the wearer has to do.",
        "validate": "Validate an identified suit model in closed loop.",
        "train": "Train an assist policy with Stable-Baselines3.",
        "tune": "Tune the options of a policy within a budget that is the same for all.",
        "benchmark": "Compare controllers over tasks, levels and suits.",
    },
    "Experiments and papers": {
        "knowledge": "Measure how much a hysteresis model improves assistance.",
        "branch": "Show what the next second of a motion would be under each of some policies.",
        "reproduce": "Repeat a paper: li-2022 or kao-fung-2009.",
        "bench": "Measure speed, each row against something else in turn in this very run.",
    },
}
PAPERS = {  # module of `commands`, and what it does
    "li-2022": ("study", "Compare identification methods by many trials, and judge the claims."),
    "kao-fung-2009": ("kao_fung", "Repeat the cost benchmark and the piezo mechanism."),
}
RENAMED = {"study": "reproduce li-2022", "kao-fung": "reproduce kao-fung-2009"}
COMMANDS = {name: help for commands in GROUPS.values() for name, help in commands.items()}


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs one command; after a user's mistake, prints one sentence and exits with code 2.

    SIGTERM, by which a scheduler ends a job, does what Ctrl-C does.
    """
    try:
        with _interruptible():
            _run(sys.argv[1:] if arguments is None else list(arguments))
            sys.stdout.flush()
    except InputError as error:
        _stop(f"error: {error}")
    except KeyboardInterrupt as interrupt:
        # If it came while a library ran a text as code, `python -m` would end by SIGINT, whatever
        # the exit code; another text makes it forget that.
        exec("")
        _stop(f"interrupted: {interrupt}" if interrupt.args else "interrupted")
    except BrokenPipeError:  # the reader of our output, `head` for one, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        _stop(f"error: {InputError(error)}")  # which is short, and one line
    finally:
        close_folders()


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
        raise InputError(f"give a command: {', '.join(COMMANDS)}; --help says what they do")
    name, *rest = arguments
    if name == "--version":
        print(f"activesuit {__version__}")
    elif name in ("-h", "--help", "help"):
        print(_help())
    elif name == "reproduce":
        _reproduce(rest)
    elif name in COMMANDS:
        _run_command(name.replace("-", "_"), name, rest)
    else:
        refuse_old_names([name], RENAMED)
        raise unknown_name("command", name, COMMANDS)


def _help() -> str:
    width = max(map(len, COMMANDS))
    return "\n".join(
        [
            "usage: activesuit COMMAND [arguments]",
            "       activesuit COMMAND --help",
            "       activesuit --version",
            "",
            "Identify, simulate and compensate the hysteretic joints of a spacesuit.",
        ]
        + [
            line
            for title, commands in GROUPS.items()
            for line in (
                "",
                f"{title}:",
                *(f"  {name:{width}}  {sentence}" for name, sentence in commands.items()),
            )
        ]
    )


def _reproduce(arguments: Sequence[str]) -> None:
    paper, *rest = arguments or ["--help"]
    if paper in ("-h", "--help"):
        lines = [f"  {name:15}{sentence}" for name, (_, sentence) in PAPERS.items()]
        usage = "usage: activesuit reproduce [-h] PAPER [arguments]\n\n"
        print(f"{usage}{COMMANDS['reproduce']}\n\npapers:\n" + "\n".join(lines))
        raise SystemExit(0)
    if paper not in PAPERS:
        raise unknown_name("paper", paper, PAPERS)
    _run_command(PAPERS[paper][0], f"reproduce {paper}", rest)


def _run_command(function: str, name: str, arguments: Sequence[str]) -> None:
    from .extensions import load_extensions
    from .parsing import parsed

    load_extensions()
    # A policy or an environment as module:name, or a file of a policy that may have one.
    if "--trust" in arguments or any(":" in given for given in arguments):
        _import_from_here()
    command = getattr(import_module(f".commands.{function}", __package__), function)
    call = parsed(command, name, arguments)
    with engine_warnings():
        call()


def _import_from_here() -> None:
    """Lets a module of the working folder be imported, after all that are installed."""
    here = os.getcwd()
    if here not in sys.path:
        sys.path.append(here)


def _stop(message: str) -> None:
    print(visible(f"activesuit: {message}".replace("\n", " ")), file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    main()
