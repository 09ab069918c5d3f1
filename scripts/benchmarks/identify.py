"""Our own fit against the published one."""

from ...assets import curves_path
from ...identification import certified_fit, identify, load_curves
from .timing import Row, compare


def rows(repeats: int) -> list[Row]:
    """Times a certified fit of the elbow against one SA-PSO trial."""
    curves = [curve for curve in load_curves(curves_path("elbow")) if curve.role == "fit"]
    return [
        compare(
            "certified fit, elbow",
            lambda: certified_fit(curves, rng=0),
            "one SA-PSO trial",
            lambda: identify(curves, method="sa-pso", trials=1, workers=1),
            repeats=repeats,
            unit="ms",
        )
    ]
