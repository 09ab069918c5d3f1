"""Every sentence on curves and fits by its code: judgements are data, and their words are here.

A new remark is an entry of `SENTENCES`, and `Remark(kind, values)` where its condition is tested.
"""

from dataclasses import dataclass, field
from typing import Any

DESCRIBES = "describes the curves"
NOT_BEYOND = "describes the curves, not beyond"
UNKNOWN = "cannot be judged by these curves: measure every curve twice"
NOT = "does not describe the curves"
SENTENCES = {
    # Mistakes of the recording.
    "unit angle": "the angles span only {span:.3g} rad: check their unit",
    "unit torque": "the torque peaks at {peak:,.3g} N·m, and that of a joint between {low:g} and "
    "{high:,g} N·m: check its unit",
    "clock rate": "the joint moves at {slowest:.2g} to {fastest:.2g} rad/s, and joints are "
    "measured between {low:g} and {high:g}: check that time_s is in seconds",
    "clock jump": "the clock jumps by {step:.3g} s between {place} and {next}, {times:.0f} times "
    "the usual step, while the angle goes on as usual: repair the times, or leave the column "
    "time_s out",
    "sign": "the torque{of} falls where the angle rises, as if the joint left by itself the place "
    "where it rests: check the signs of angle and torque, which must be positive against positive "
    "motion",
    "work": "the loops give back {work:.3g} J more than they take ({deviations:.1f} standard "
    "deviations), though the torque rises with the angle: check that the columns of angle and "
    "torque are not exchanged, and that both are measured at the same time; a magnetization over "
    "its field does so too",
    "copy": "curve {curve!r} is a copy of {other!r} to the last digits, and no second measurement: "
    "remove it",
    "copy scaled": "curve {curve!r} is {factor:.6g} times {other!r} to the last digits, and no "
    "second measurement: remove it",
    "clipped": "the torque stays at exactly {torque:.6g} N·m for {count} samples from {place} on: "
    "the sensor or its amplifier is at its limit; measure with a larger range, or smaller motions",
    "disorder rows": "the angle goes {times:.0f} times through its range in {count} samples (the "
    "largest step is at {place}): the rows are not in the order of measurement; sort them by time",
    "disorder error": "NRMSE {nrmse:.1%}: the curves are very noisy, or not in the order of "
    "measurement",
    "label": "curve {curve!r} comes back to the angle where it began {count} times: if these are "
    "several measurements, give each its own label",
    "turn jump": "between {place} and {next}, where the motion turns, {step:.3g} s pass and the "
    "torque jumps by {torque:.3g} N·m: record the turn too, or the whole time of a rest there",
    "turn rest": "between {place} and {next}, where the motion turns, {step:.3g} s have no sample, "
    "and the joint could go on by {away:.2g} rad and come back: if it did not rest there, record "
    "the turn too",
    "coarse": "samples of curve {curve!r} are up to {step:.2g} rad apart (at {place}), more than "
    "{most:.0%} of its range, and the torque between them is unknown: sample finer",
    "encoder steps": "the angles of curve {curve!r} come in steps of {step:.2g} rad, {count:.0f} "
    "over its range, and the torque changes within a step: measure with a finer encoder, or keep "
    "one sample of each step",
    "encoder noise": "the angles of curve {curve!r} have a noise of {degrees:.2g} degrees, "
    "{share:.1%} of its range, which the fit takes as motion: smooth the angle over time before "
    "the fit, or measure with a better encoder",
    "exchanged": "the angles of curve {curve!r} have a noise of {share:.1%} of their range, and "
    "the torques one of {percent:.1g} %, though angles are measured better: check whether the "
    "columns of angle and torque are exchanged",
    "outliers": "{count} samples are up to {torque:.2g} N·m off their neighbors, more than {far:g} "
    "times the usual deviation: remove these outliers, or search with an objective that bears "
    "them, such as by sa-pso",
    "outliers run": "{count} samples of curve {curve!r} from sample {begin} on are {torque:+.2g} "
    "N·m off those before and after, {times:.0f} times the usual deviation: remove this run",
    "thinned": "{used:,} of {samples:,} samples are used: one in {every} of each curve, its ends "
    "and its turning points, in the fit; errors are those of all",
    # Faults of the measurement that explain the residual of a fit.
    "tare": "a torque of {size:+.2g} N·m is in all samples, whatever the angle, which the model "
    "cannot describe: it is the sensor's offset (zero the sensor, or fit it), or the rest angle of "
    "a spring, which other models have",
    "rate": "the torque grows by {size:.2g} N·m with each rad/s: the joint is viscous; measure "
    "slower, or fit the rate too",
    "lag": "the torque is measured {length:.2g} s {when} the angle: shift one of them, use the "
    "same filter for both, or measure slower",
    "play": "the angle moves by {degrees:.2g} degrees after each reversal before the torque "
    "follows: there is play between encoder and joint; remove it, or measure the joint itself",
    "gap": "the joint moves by about {degrees:.2g} degrees where the torque is near zero: there "
    "the contact in the transmission changes from one face to another; remove that gap, or fit it "
    "too",
    "drift": "the torque changes by {percent:+.2g} % from curve to curve, or cycle to cycle: the "
    "sensor drifts, or the joint wears; measure in one go, or remove the change",
    "softening": "the torque begins {change:.2g} % {more} than it ends: the joint wears in; cycle "
    "it before, and fit only the last cycles, or remove the change",
    "offset": "a torque of {size:+.2g} N·m is in all samples of curve {curve!r}, and not in the "
    "others: zero the sensor before every curve; subtract it there, or measure that curve again",
    "gain": "the torque of curve {curve!r} is {percent:+.2g} % larger than that of the others: "
    "check the sensor's range and the unit of that curve, or measure it again",
    # The model, and terms that were asked for.
    "softening none": "no change from cycle to cycle was found",
    "softening incomplete": "the torque still changes at the end of {cycles:.2g} cycles, so that "
    "the steady one, {steady:.3g} times the last, is extrapolated: measure more cycles",
    "play none": "no gap was found",
    "rate none": "the torque was not found to depend on the rate",
    "rate viscous": "no relaxation was found beside the dashpot",
    "open": "no offset of the torque sensor is taken off, because these curves do not determine "
    "it: {tare:.3g} N·m by {model}, any by {rival}, which predicts them as well; zero the sensor, "
    "or give the tare as a number",
    "limit": "{name} = {value:.5g} is at the limit of the search ({limit:g})",
    "limit gap": "gap = {gap:.5g} is at the limit of the search: it may be wider",
    "limit given": "{names}: at the bound that was given; the curves ask for more",
    "range": "the model is safe between {low:.2f} and {high:.2f} rad only; its torque is kept "
    "constant outside, since curves that reach farther might show more",
    "certificate": "the fit ended at the limit of the certificate: a model that is not safe may "
    "fit better",
    "start": "the curves begin at {curves:.3g} N·m, and the model at {model:.3g} N·m: subtract the "
    "sensor's offset as a tare, if it has one; or let the model begin where they do",
    "form": "the curves do not distinguish the form {form} from {others}, whose parameters are "
    "other ones: measure with less noise, or name the form with every parameter",
    # The residual of a fit.
    "misfit": "the residual is {times:.2f} times the noise {origin} ({share:.2%} of the peak), and "
    "noise alone leaves so smooth a residual in at most {probability:.0e} of all fits (reported "
    "below {threshold:g}): check columns, order and beginning of the curves, or choose another "
    "model",
    "noise repeated": "of repeated curves",
    "noise smooth": "that smooth curves through the branches leave",
    "nothing": "the model explains next to nothing of the torque (NRMSE {nrmse:.2%}, a constant "
    "torque {constant:.2%}): check the columns, or measure larger motions",
    "search": "the search ended before the least error, which is about {less:.0%} less: give it "
    "more trials or a larger budget, or use the certified method",
    "wandering": "{doubts}: that may be noise or misfit; measure every curve twice to tell which: "
    "repeat the motion with as many samples, and fit both records together",
    "doubt residual": "the residual is {times:.2f} times what a smooth curve through each branch "
    "leaves, and wanders (correlation {memory:.2f} from sample to sample)",
    "doubt smooth": "the residual has a smooth part, which noise alone leaves in at most "
    "{probability:.0e} of all fits (reported below {threshold:g})",
    "doubt error": "the error is {nrmse:.1%} of the peak",
    "memoryless": "the curves are described as well by {baseline} (NRMSE {least:.2%} against "
    "{nrmse:.2%}): they show no memory that needs this model",
    "memoryless prediction": "{baseline} predicts the left-out data with NRMSE {least:.2%}, and "
    "{model}, the best choice among models with a memory, with {nrmse:.2%}: the curves show no "
    "memory that needs one",
    # Curves beside an intended motion.
    "coverage range": "the intended motion goes from {low:.3g} to {high:.3g} rad, the curves from "
    "{least:.3g} to {most:.3g} rad: {ends} the torque is a guess; measure the joint there too",
    "range below": "below {angle:.3g} rad",
    "range above": "above {angle:.3g} rad",
    "coverage nesting": "the intended motion has reversals nested {deep} deep, the curves at most "
    "{nesting}: {why}; measure the record that `nested_motion` (activesuit design) gives",
    "nesting 0": "curves that never turn back do not identify loops",
    "nesting 1": "first-order curves do not identify nested loops",
    "nesting 2": "models that agree with them may differ in the loops inside these",
    "coverage branches": "the intended motion turns back after {needed:.2g} rad, the curves after "
    "{shortest:.2g} rad at the least: how small loops differ from large ones is a guess; measure "
    "the record that `nested_motion` (activesuit design) gives",
    "coverage times": "the intended motion moves at up to {rate:.2g} rad/s, and the curves come "
    "without their time: whether the torque depends on the rate is unknown; add the column time_s "
    "to them",
    "coverage rates": "the intended motion moves at up to {rate:.2g} rad/s, the curves at "
    "{slowest:.2g} to {fastest:.2g} rad/s: whether the torque depends on the rate is unknown "
    "beyond; measure up to {asked:.2g} rad/s, or as fast as the rig can",
    "coverage cycles": "the intended motion goes through {needed} whole cycles, a curve through at "
    "most {cycles}: whether the torque softens from cycle to cycle is unknown; measure {enough} "
    "cycles without a pause",
    # The choice among kinds of model.
    "chosen simpler": "{name} predicts data left out of its fit with NRMSE {nrmse:.2%}, within "
    "10 % of the best ({best}, {least:.2%}), and has fewer parameters ({parameters} instead of "
    "{others})",
    "chosen best": "{name} predicts data left out of its fit best, with NRMSE {nrmse:.2%} (next is "
    "{next}, {second:.2%}), and no model within 10 % of that has fewer parameters than its "
    "{parameters}",
    "chosen alone": "{name} predicts data left out of its fit best, with NRMSE {nrmse:.2%}; no "
    "other model was fitted",
    "chosen beyond": "each cycle of the record is larger than those before, so that the "
    "predictions reach beyond the angles of the fits, where models differ more: a record that "
    "repeats its largest cycle tells more",
    "chosen interrupted": "interrupted after {tried} of {models} models",
    "agreement tested": "on the intended motion the torque is within {half_width:.2g} N·m "
    "({share:.1%} of the peak) at {level:.0%}, over all kinds of model and tested by predictions "
    "of {by}",
    "agreement": "on the intended motion the {members} kinds of model that predict the curves are "
    "within {half_width:.2g} N·m ({share:.1%} of the peak) of each other's middle, but no curve "
    "has loops inside loops to test them: all may be wrong together",
    "agreement unknown": "the kinds of model cannot be compared on the intended motion: {why}",
    # The answer of `identify`.
    "averaged": "mean of the cycles after the first: {counts}",
    "auto": "method auto, since this is one record of several cycles",
    "verdict": "verdict: the model {verdict}",
    "verdict beyond": "verdict: the model {verdict}: they have no loops inside loops (reversals "
    "nested {nesting} deep), no branch below {shortest:.0%} of the range, {rates}; and no intended "
    "motion is named (--for)",
    "rates": "no rates but {slowest:.2g} to {fastest:.2g} rad/s",
    "rates none": "no times",
    "noise": "noise: {constant:.2g} N·m",
    "noise uneven": "noise: {constant:.2g} N·m and {percent:.2g} % of the torque",
    "band": "band: along these curves the torque is within {half_width:.2g} N·m of the model "
    "({share:.1%} of the peak), at {level:.0%}, if its kind is right{kinds}",
    "band none": "band: none, because nothing tests the model beyond these curves; measure also "
    "the record of activesuit design",
    "offset open": "these curves do not determine the offset of the torque sensor (any, by "
    "{kinds}): if the sensor was not zeroed, its offset is in the model; zero the sensor, or give "
    "its offset (--tare NUMBER)",
    "open ends": "the curves set no {end} to {names}",
    "samples": "samples: {count}, of {kinds} of model, which the curves allow too; not among them: "
    "{without}",
    # What the samples of a model lack.
    "left open offset": "an offset of the torque sensor, if it was not zeroed",
    "left open rate": "torque that depends on the rate (the curves have rates up to {fastest:.2g} "
    "rad/s)",
    "left open times": "torque that depends on the rate (the curves have no times)",
    "left open kinds": "other kinds of model",
    f"left open {NOT}": "what the model does not describe in its own curves",
    f"left open {UNKNOWN}": "whether the kind of model is right",
    f"left open {NOT_BEYOND}": "motions unlike the curves",
}
OPTIONS = {  # option of `identify`, and its value, that would act on a remark
    "work": ("method", "magnetic"),
    "outliers": ("objective", "robust"),
    "tare": ("tare", "fit"),
    "rate": ("rate", "viscous"),
    "gap": ("play", "fit"),
    "drift": ("softening", "fit"),
    "softening": ("softening", "fit"),
    "softening none": ("softening", "none"),
    "play none": ("play", "none"),
    "rate none": ("rate", "none"),
    "rate viscous": ("rate", "viscous"),
    "start": ("initial_torque", "identified"),
    "misfit": ("method", "auto"),
    "search": ("method", "certified"),
}
_PARTS = {
    **dict.fromkeys(("tare", "rate", "play", "softening"), "corrections=Corrections({})"),
    "objective": "method=Search(..., {})",
}


def sentence(kind: str, **values: Any) -> str:
    """Returns the sentence of a kind with its values."""
    return SENTENCES[kind].format(**values)


@dataclass(frozen=True)
class Remark:
    """A reason to doubt a fit, or the curves: data, whose words are in `SENTENCES`.

    Attributes:
        kind: Key of `SENTENCES`; its first word is the code.
        values: Numbers and names in the sentence.
    """

    kind: str
    values: dict[str, Any] = field(default_factory=dict)

    @property
    def code(self) -> str:
        """Subject of the remark."""
        return self.kind.partition(" ")[0]

    @property
    def sentence(self) -> str:
        """The remark in words, with a remedy in the measurement."""
        return sentence(self.kind, **self.values)

    @property
    def option(self) -> tuple[str, str] | None:
        """Option of `identify`, and its value, that would act on the remark, if any."""
        return OPTIONS.get(self.kind)

    def to_dict(self) -> dict[str, Any]:
        """Returns code, sentence and option as plain values."""
        return {"code": self.code, "sentence": self.sentence, "option": self.option}

    def __str__(self) -> str:
        """Returns the sentence with the option as Python takes it."""
        if self.option is None:
            return self.sentence
        name, value = self.option
        argument = _PARTS.get(name, "{}").format(f"{name}={value!r}")
        return f"{self.sentence} ({'select(curves)' if value == 'auto' else argument})"

    @property
    def advice(self) -> str:
        """The sentence with the option as the command line takes it."""
        if self.code == "wandering":
            return f"{self.sentence} (activesuit identify FIRST.csv SECOND.csv --method auto)"
        if self.option is None:
            return self.sentence
        name, value = self.option
        return f"{self.sentence} (--{name.replace('_', '-')} {value})"
