"""The wearer's control: stiffness, reflex, learning, and the strength that limits them all."""

import matplotlib.pyplot as plt
import numpy as np
from activesuit.assets import JOINTS
from activesuit.envs.evaluation import rollout
from activesuit.envs.person import Person, VoluntaryControl, isometric_strength, strength_limits
from activesuit.envs.person.control import FORGETTING, RATE
from activesuit.envs.policies import make_policy
from activesuit.envs.tasks import RandomMoves
from activesuit.envs.vector_env import ArmVectorEnv

DT = 0.01  # s, control period
SHOULDER, ELBOW = JOINTS.index("shoulder_flexion"), JOINTS.index("elbow_flexion")
COLOR = {SHOULDER: "tab:blue", ELBOW: "tab:orange"}
PERSON, CONTROL = Person(), VoluntaryControl()
# Repetitions with and without suit, motions at once, and the credit of learning [control periods].
REPEATS, MOTIONS, CREDIT = 25, 2, 10
SWING = RandomMoves(
    name="Swing",
    span={"elbow_flexion": (0.52, 1.57)},
    hold={"shoulder_flexion": (0.4, 1.0)},
    duration=3.0,
)
GOMI_OSU = {SHOULDER: 11.0, ELBOW: 9.0}  # N·m/rad, stiffness without torque


def stiffness(axis):
    """Draws stiffness over the torque of the muscles, with published values."""
    torque = np.linspace(0, 30, 2)
    for joint, name in ((SHOULDER, "shoulder"), (ELBOW, "elbow")):
        ours, growth = CONTROL.impedance(PERSON)[:2, joint]
        axis.plot(torque, ours + growth * torque, color=COLOR[joint], label=f"{name}, wearer")
        axis.plot(torque, GOMI_OSU[joint] + growth * torque, "--", color=COLOR[joint], lw=1)
    axis.plot([], [], "k--", lw=1, label="Gomi and Osu 1998, as cited by others, rounded")
    axis.plot(0, 25, "kx", label="Viviani 1976, movements")
    axis.set(title="Stiffness rises with torque", xlabel="|torque of the muscles| [N·m]")
    axis.set(ylabel="stiffness [N·m/rad]", ylim=(0, None))
    axis.legend(loc="upper left")


def pushed(joint, torque, **options):
    """Returns how far an arm is from its posture [mrad], from half a second before a push."""
    still = RandomMoves(name="Still", hold={"elbow_flexion": (0.8, 0.9)}, duration=5.0)
    arms = ArmVectorEnv(1, still, control={"adaptation": 0}, coupling="none", **options)
    arms.reset(seed=0)
    force = arms.episodes.simulation.batch.bind("qfrc_applied")[0]
    away = []
    for period in range(350):
        force[joint] = torque * (period >= 50)
        arms.step(np.zeros((1, 0)))
        info = arms.episodes.info(0)
        away.append((info["angle"] - info["target_angle"])[joint])
    return 1e3 * np.array(away)


def pushes(axis):
    """Draws how arms come back from pushes."""
    time = DT * (np.arange(350) - 50)
    space = {"gravity": "microgravity"}
    for label, style, options in (
        ("bare arm, weightless", "-", {"suit": "none", **space}),
        ("with 5 kg, on Earth", "--", {"suit": "none", "payload": {"mass": 5.0}}),
        ("in the mock suit, weightless", ":", space),
    ):
        for joint, torque in ((SHOULDER, 4.0), (ELBOW, 3.0)):
            axis.plot(time, pushed(joint, torque, **options), style, color=COLOR[joint])
        axis.plot([], [], style, color="k", label=label)
    axis.axvspan(0.1, 0.15, color="0.85", label="people begin to correct")
    axis.set(title="An arm is pushed with 4 N·m (shoulder), 3 N·m (elbow)", xlabel="time [s]")
    axis.set(ylabel="distance from the posture [mrad]", xlim=(-0.1, 3))
    axis.legend(loc="upper right")


def learning(axis):
    """Draws the errors of two motions of the elbow, repeated in a suit and then without it."""
    arms = {
        suit: ArmVectorEnv(
            *(MOTIONS, SWING),
            **{
                "suit": suit,
                "coupling": "none",
                "control": {"adaptation": 0},
                "learned_torque": True,
            },
        )
        for suit in ("mock-suit", "none")
    }
    samples = round(SWING.duration / DT) + 1
    learned, errors = np.zeros((MOTIONS, samples, len(JOINTS))), []
    for suit in ["mock-suit"] * REPEATS + ["none"] * REPEATS:
        traces = rollout(
            arms[suit],
            make_policy("none", arms[suit]),
            range(MOTIONS),
            learned={"learned_torque": learned},
        )
        error = [trace.angle - trace.target_angle for trace in traces]
        errors.append(np.sqrt(np.mean(np.square(error)[..., ELBOW])))
        torque = np.array([np.concatenate([t.human_torque[:1], t.human_torque]) for t in traces])
        own = arms[suit].episodes.simulation.own_torque(np.arange(MOTIONS))
        answer = torque - own - learned
        credited = np.concatenate([answer[:, CREDIT:], answer[:, -1:].repeat(CREDIT, 1)], 1)
        learned = (1 - FORGETTING) * learned + RATE * credited
    repeat = np.arange(1, len(errors) + 1)
    for part in (slice(REPEATS), slice(REPEATS, None)):
        axis.plot(repeat[part], 1e3 * np.array(errors[part]), "o-", ms=3, color=COLOR[ELBOW])
    axis.axvline(REPEATS + 0.5, color="k", ls=":", lw=1)
    high = 1e3 * max(errors)
    axis.text(REPEATS / 2, 1.06 * high, "in the mock suit", ha="center")
    axis.text(1.5 * REPEATS, 1.06 * high, "without the suit: after-effect", ha="center")
    axis.set(title="A motion is repeated", xlabel="repetition", ylim=(0, 1.18 * high))
    axis.set(ylabel="tracking error of the elbow, RMS [mrad]")
    first, last, after, end = (1e3 * errors[i] for i in (0, REPEATS - 1, REPEATS, -1))
    print(f"error {first:.1f} mrad at first, {last:.1f} mrad after {REPEATS} repetitions")
    print(f"without the suit {after:.1f} mrad at first, {end:.1f} mrad after as many")


def strength(axis):
    """Draws strength over angle, static and at speed, with published values."""
    degrees = np.linspace(0, 130, 200)
    fast = np.radians(50.0)
    peak = isometric_strength(PERSON)

    def flexion(joint, rate):
        angle, speed = np.zeros((2, len(degrees), len(JOINTS)))
        angle[:, joint], speed[:, joint] = np.radians(degrees), rate
        return strength_limits(peak, angle, speed)[1][:, joint]

    axis.plot(degrees, flexion(SHOULDER, 0), color=COLOR[SHOULDER], label="shoulder, static")
    axis.plot(degrees, flexion(SHOULDER, fast), "--", color=COLOR[SHOULDER], label="at ±50°/s")
    axis.plot(degrees, flexion(SHOULDER, -fast), "--", color=COLOR[SHOULDER])
    axis.plot(degrees, flexion(ELBOW, 0), color=COLOR[ELBOW], label="elbow, static")
    points = axis.plot([0, 45, 45, 45], [89.9, 68.6, 46.9, 75.3], "ko", ms=5)
    points[0].set_label("McGill et al. 1994, shoulder")
    axis.plot([0, 90], [35, 70], "k^", ms=6, label="elbow, values of the model")
    axis.set(title="Strength of the flexors of a man", xlabel="angle [°]", xlim=(-3, 130))
    axis.set(ylabel="greatest torque [N·m]", ylim=(0, 115))
    axis.legend(loc="upper right", ncols=2)


plt.style.use("seaborn-v0_8-whitegrid")
plt.rcParams["legend.fontsize"] = 9
figure, axes = plt.subplots(2, 2, figsize=(12, 8.4), layout="constrained")
for axis, draw in zip(axes.flat, (stiffness, pushes, learning, strength), strict=True):
    draw(axis)
figure.savefig("wearer.png", dpi=110)
