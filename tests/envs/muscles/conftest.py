"""Most tests of muscles run where the extra `muscles` is installed."""

from importlib.util import find_spec

NEED_EXTRA = ("drawing", "scores")
collect_ignore = [] if find_spec("myo_sim") else [f"test_{name}.py" for name in NEED_EXTRA]
