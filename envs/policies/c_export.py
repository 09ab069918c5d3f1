"""C99 headers of policies that cancel modelled torques: from encoders to the motors' torque."""

from pathlib import Path

import numpy as np

from ...arrays import Array
from ...assets import JOINTS, SuitJoint
from ...assets.c_export import INTRODUCTION, Part, joint_comment
from ...errors import InputError, shown
from ...hysteresis import Viscoelastic
from ...hysteresis.around import without_rate
from ...hysteresis.c_code import Header, comment, literal
from ...hysteresis.safety import require_certificate
from ..belief import BelievedSuit
from ..model import ASSISTED
from ..model.config import GRAVITY
from .base import Policy
from .model_based import TURNING, ModelBased
from .registry import POLICIES

GOLDEN = (  # rad and rad/s: angles and rates of the four joints
    ((0.0, 0.4, 1.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
    ((0.1, 0.6, 1.3, 0.1), (0.2, 0.5, 0.8, -0.1)),
    ((0.2, 0.9, 0.9, 0.2), (0.0, 0.7, -1.0, 0.1)),
    ((0.1, 0.5, 0.7, -0.1), (-0.3, -1.0, 0.3, 0.0)),
)
NO_WEIGHT = """
static inline void as_carry(const as_real angle[4], as_real torque[2])
{
    (void)angle;
    torque[0] = torque[1] = 0; /* nothing has weight */
}"""


def exportable() -> list[str]:
    """Returns the names of the policies that can be exported."""
    return [name for name, maker in POLICIES.items() if isinstance(maker, type) and _sums(maker)]


def policy_header(name: str, policy: Policy, prefix: str) -> tuple[str, list[Part]]:
    """Returns a C99 header of a policy of `exportable`, and the memory that the header needs.

    Comments show the policy's `name`; all names of the header begin with `prefix`.
    """
    if not isinstance(policy, ModelBased) or not _sums(type(policy)):
        raise InputError(
            f"the policy {shown(name)} cannot be exported as C code: use one of "
            f"{', '.join(exportable())}, without guard"
        )
    header = Header(prefix)
    joints = {} if policy.suit is None else policy.suit.joints
    state = len(ASSISTED)
    for joint, entry in joints.items():
        assert isinstance(entry, SuitJoint)  # a policy by name has no other beliefs
        if not policy.config.allow_uncertified:
            start = entry.model.start(entry.start_angle, entry.start_torque)
            require_certificate(entry.model, start, joint)
        header.add(comment(joint_comment(joint, entry)))
        state += header.model(f"as_{joint}", without_rate(entry.model), entry.begun())
        state += 2 * isinstance(entry.model, Viscoelastic)
    weight = np.zeros((81, 2)) if policy.weight is None else policy.weight.coefficients
    if weight.any():
        header.table("as_weight", weight.ravel())
        header.include(Path(__file__).with_name("carry.c"))
    else:
        header.add(NO_WEIGHT)
    friction = policy.friction
    header.table("as_peak", policy.peak)
    header.table("as_coulomb", friction.coulomb)
    header.table("as_viscous", friction.viscous)
    constants = {"lead": policy.lead, "friction_share": friction.share, "turning_rate": TURNING}
    for constant, value in constants.items():
        header.add(f"static const as_real as_{constant} = {literal(value)};")
    places = [JOINTS.index(joint) for joint in ASSISTED]
    header.add(f"static const int as_assisted[2] = {{{places[0]}, {places[1]}}};")
    header.add(_suit_code(policy.suit))
    header.include(Path(__file__).with_name("model_based.c"))
    part = Part(name, type(policy).__name__, state, header.constants)
    return header.text(_about(name, policy, prefix)), [part]


def _sums(maker: type) -> bool:
    """Returns whether a class gives the sum of `ModelBased` and no other torque."""
    sums = issubclass(maker, ModelBased)
    return sums and maker.torque is ModelBased.torque and maker.begin is ModelBased.begin


def _suit_code(suit: BelievedSuit | None) -> str:
    """Returns the C code of the state of a policy and of the suit's torque, as `BelievedSuit`."""
    fields, begins, adds = [], [], []
    for joint, entry in ({} if suit is None else suit.joints).items():
        assert suit is not None and isinstance(entry, SuitJoint)
        model = entry.model
        i, place = ASSISTED.index(joint), JOINTS.index(joint)
        fields.append(f"    as_{joint}_state {joint};")
        begins.append(f"    as_{joint}_init(&s->{joint});")
        adds.append(
            f"""
    if (isfinite(angle[{place}])
        && !(AS_(fabs)(angle[{place}] - s->followed[{i}]) <= {literal(suit.dead_band)}))
        s->followed[{i}] = angle[{place}]; /* also after a first angle that was not finite */
    as_{joint}_step(&s->{joint}, s->followed[{i}]);
    as_{joint}_state {joint} = s->{joint}; /* where the joint will be */
    torque[{i}] += as_{joint}_step(&{joint}, angle[{place}] + as_lead * rate[{place}]);"""
        )
        if not isinstance(model, Viscoelastic):
            continue
        fields.append(f"    as_real {joint}_angle, {joint}_torque; /* of the Maxwell element */")
        begins.append(f"    s->{joint}_angle = angle[{place}];\n    s->{joint}_torque = 0;")
        adds.append(f"    torque[{i}] += {literal(model.damping)} * rate[{place}];")
        if model.relaxation_stiffness > 0:
            product = literal(model.relaxation_stiffness * model.relaxation_time)
            tau, dt = literal(model.relaxation_time), literal(suit.dt)
            adds.append(
                f"""\
    as_real {joint}_motion = angle[{place}] - s->{joint}_angle;
    if (!isfinite({joint}_motion))
        {joint}_motion = 0; /* without a reading the element only relaxes */
    s->{joint}_torque = as_relaxed(s->{joint}_torque, {product} * {joint}_motion / {dt},
                                   {dt} / {tau});
    if (isfinite(angle[{place}]))
        s->{joint}_angle = angle[{place}];
    torque[{i}] += as_relaxed(s->{joint}_torque, {product} * rate[{place}], as_lead / {tau});"""
            )
    unused = "    (void)s;\n    (void)angle;\n"
    if not fields:
        adds.append(f"{unused}    (void)rate;\n    (void)torque;")
    if all("angle[" not in one for one in begins):
        begins.append(unused if not fields else "    (void)angle;")
    lines = "\n".join
    return f"""
typedef struct {{
    as_real followed[2]; /* angles that the suit's memory follows */
{lines(fields)}
}} as_state;

/* Returns the torque of a Maxwell element after a time over its relaxation time. */
static inline as_real as_relaxed(as_real torque, as_real steady, as_real time)
{{
    return steady + (torque - steady) * AS_(exp)(-time);
}}

static inline void as_begin_suit(as_state *s, const as_real angle[4])
{{
{lines(begins)}
}}

/* Adds the resistance of the suit where the joints will be when the motors have answered. */
static inline void as_add_suit(as_state *s, const as_real angle[4], const as_real rate[4],
                               as_real torque[2])
{{
{lines(adds).lstrip()}
}}"""


def _about(name: str, policy: ModelBased, prefix: str) -> list[str]:
    config, wearer = policy.config, policy.config.wearer
    place = f"{config.gravity} ({GRAVITY[config.gravity]:g} m/s2)"
    usage = f"""  {prefix}_state state;
  {prefix}_real angle[4], rate[4], torque[2];
  {prefix}_init(&state, angle);
  {prefix}_step(&state, angle, rate, torque);  once in each control period of {policy.dt:g} s"""
    return [
        f"Policy {name}: the torques of the motors of {' and '.join(ASSISTED)} from the measured "
        f"angles and rates of {', '.join(JOINTS)}.",
        f"It believes in a wearer of {wearer.stature:g} m and {wearer.mass:g} kg, a load of "
        f"{config.payload.mass:g} kg, the {config.side} arm, {place}, coupling {config.coupling}; "
        f"the motors answer after {policy.lead:g} s.",
        INTRODUCTION,
        "",
        usage,
        "",
        *_golden(policy),
    ]


def _golden(policy: ModelBased) -> list[str]:
    rows = []
    for i, (angle, rate) in enumerate(np.array(GOLDEN)):
        seen = {"angle": angle[None], "rate": rate[None]}
        if i == 0:
            policy.begin(seen)
        torque = np.clip(policy.torque(seen), -policy.peak, policy.peak)[0]
        rows.append(f"  {_row(angle, 1)}  {_row(rate, 1)}  {_row(torque, 12)}")
    return ["Golden values of the first steps (double): angles, rates, torques.", "", *rows]


def _row(values: Array, decimals: int) -> str:
    return " ".join(f"{value:.{decimals}f}" for value in values)
