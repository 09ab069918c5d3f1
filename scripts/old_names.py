"""Commands and options of version 0.2, and their replacements."""

_EXAMPLE = "python examples/{}.py of the source repository"
_PAPER = "python -m activesuit.reproductions.{} of the source repository (make reproduce)"
MOVED = {  # removed commands, the longer names first, and the commands to run in their place
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
    **{name: f"activesuit list {name}" for name in ("suits", "tasks", "policies")},
}
OLD_OPTIONS = {  # removed options, and what to do in their place
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
