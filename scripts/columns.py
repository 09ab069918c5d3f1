"""What the columns of tables mean whose names do not say it, for a line below each table."""

from collections.abc import Sequence

MEANINGS = {
    "relief, 95 % interval": "share of the suit's cost in effort that is given back",
    "of the bound": "relief over that of the best known plan, which knows the whole motion",
    "went well": "share of motions within all limits of success",
    "late by [ms]": "time by which the believed torque comes after the true one",
    "RMS of the peak [%]": "root mean square of the error over the largest true torque",
    "over fit noise": "root mean square of the error over what the fit left of its curves",
    "smoothness SPARC": "spectral arc length, nearer to 0 is smoother",
    "hand SPARC": "spectral arc length of the hand's motion, nearer to 0 is smoother",
    "predicts: NRMSE": "error on data left out of the fit, over the largest torque",
    "fits: NRMSE": "error on the fitted data, over the largest torque",
    "weight in band": "share of the model in the band and the samples over kinds of model",
    "starts that agree": "how many starts of the fit ended at this model",
}


def explained(header: Sequence[str]) -> str:
    """Returns a line on the columns of a table whose names do not say what they are."""
    names = [" ".join(name.split()) for name in header]
    return "; ".join(f"{name}: {MEANINGS[name]}" for name in names if name in MEANINGS)
