"""The commands of `activesuit`, in the order of its help; each is a function in a file here.

The first word of a command is the name of the file, the last word is the name of the function. Only
the file of the given command is imported, since importing all files takes more than a second. The
sentence of a command is the first sentence of the help of the function.
"""

from collections.abc import Callable
from importlib import import_module

GROUPS = {
    "Start": {
        "demo": "Do the whole job once: identify, simulate, compensate, report.",
        "doctor": "Check this installation, and say how to repair failures.",
        "list suits": "List the shipped suits, or show and check one suit.",
        "list tasks": "List the tasks, or describe one task.",
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
        "evaluate": "Compare assist policies by the effort of the wearer.",
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
PARTS = {  # commands that need one of these words
    one: [name.split()[1] for name in COMMANDS if name.startswith(f"{one} ")]
    for one in MAIN_COMMANDS
    if one not in COMMANDS
}


def function_of(command: str) -> Callable[..., object]:
    """Returns the function of a command."""
    words = command.split()
    return getattr(import_module(f".{words[0]}", __name__), words[-1])
