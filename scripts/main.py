"""The command `activesuit`."""

import os
import sys
from collections.abc import Callable, Sequence

from .. import __version__
from ..errors import InputError


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs one command; a user's mistake ends with one sentence on stderr and exit code 2."""
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    if arguments == ["--version"]:
        print(f"activesuit {__version__}")
        return
    try:
        _run(arguments)
    except InputError as error:
        _stop(f"error: {error}")
    except KeyboardInterrupt as interrupt:
        _stop(f"interrupted: {interrupt}" if interrupt.args else "interrupted")
    except BrokenPipeError:  # the reader of our output, `head` for one, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        _stop(f"error: {error}")


def _run(arguments: Sequence[str]) -> None:
    import tyro

    tyro.extras.subcommand_cli_from_dict(
        {command.__name__.replace("_", "-"): command for command in _commands()},
        prog="activesuit",
        description="Identify, simulate and compensate the hysteretic joints of a spacesuit.",
        args=arguments,
        config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
    )
    sys.stdout.flush()


def _commands() -> Sequence[Callable[..., None]]:
    from .bench import bench
    from .demo import demo
    from .evaluate import evaluate
    from .identify import identify
    from .kao_fung import kao_fung
    from .simulate import simulate
    from .study import study
    from .suits import suits
    from .train import train
    from .validate import validate

    return demo, identify, study, simulate, evaluate, validate, train, suits, kao_fung, bench


def _stop(message: str) -> None:
    print(f"activesuit: {message}", file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    main()
