"""The command `activesuit`."""

import sys
from collections.abc import Sequence

import tyro

from ..envs.rendering import RenderingUnavailableError
from ..errors import InputError
from .bench import bench
from .demo import demo
from .evaluate import evaluate
from .identify import identify
from .simulate import simulate
from .suits import suits
from .train import train
from .validate import validate

COMMANDS = {
    command.__name__: command
    for command in (demo, identify, simulate, evaluate, validate, train, suits, bench)
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs one command; a user's mistake ends with one sentence on stderr and exit code 2."""
    try:
        tyro.extras.subcommand_cli_from_dict(
            COMMANDS,
            prog="activesuit",
            description="Identify, simulate and compensate the hysteretic joints of a spacesuit.",
            args=arguments,
            config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
        )
    except (InputError, RenderingUnavailableError) as error:
        print(f"activesuit: error: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt as interrupt:
        print(f"activesuit: interrupted: {interrupt or 'nothing is kept'}", file=sys.stderr)
        sys.exit(2)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output has gone: nothing is left to say
        sys.exit(1)


if __name__ == "__main__":
    main()
