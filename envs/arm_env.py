"""The Gymnasium environment: the wearer moves a suited arm, and the agent drives the motors."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any, ClassVar, Literal

import gymnasium
import mujoco
import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..checks import within
from ..errors import InputError, shown
from .meter import Meter
from .model import ASSISTED, ArmConfig, bare_arm, compose, resisting_joints, start_encoders
from .model.config import nested
from .motors import Motors, checked
from .observation import PREVIEW, Observer
from .person import VoluntaryControl
from .reference import Reference, follow, random_motion, valid_motion
from .rendering import Renderer, RenderQuality
from .reward import LOST, reward_terms
from .state import check_state, physics_of, restore_physics
from .wearer import Wearer
from .wiring import Wiring

DIVERGENCE = slice(mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQACC + 1)
FAR_OFF = (LOST,) * len(ASSISTED)  # rad, the tracking error that a diverged step counts


class ArmEnv(gymnasium.Env):
    """Base class of the tasks: physics, observation, reward and state; a task adds its motion.

    The wearer tracks a minimum-jerk intention with engine-native PID actuators, delayed feedback
    and a feed-forward of the bare arm, within human strength (see `envs.person`). The suit resists
    every joint inside the physics. The agent sets the assist torque of shoulder and elbow.

    Action: `Box(-1, 1, (2,), float32)`, assist torque of shoulder and elbow flexion over the
    motors' peak. Values outside are clipped and counted in `info["clipped_actions"]`. A motor that
    has reached its highest temperature gives no more than its continuous torque. Without an
    exoskeleton (`coupling="none"`) there are no motors, and the shape is (0,).

    Observation: `Box` of float32, the parts of `layout` one after the other: joint angles [rad] and
    rates [rad/s] of the exoskeleton's four encoders, motor torque over peak, target angles of
    shoulder and elbow 0.02, 0.1 and 0.24 s ahead [rad], previous action; with cuffs their forces on
    upper arm, forearm and hand [N]; with `observe="oracle"` also the suit torque [N·m] of the four
    joints. Positions, rates, cuff forces and suit torques are those of this instant; the torques of
    motors and wearer are the ones applied in the last physics step.

    `info` holds what no sensor measures: angle, rate and target_angle of the arm, human_torque,
    suit_torque and assist_torque, energies; with an exoskeleton motor_load, the running root mean
    square of the motors' torque over the continuous one; with cuffs cuff_force [N], with `fatigue`
    the fatigued part of every muscle group, (2, 4): extensors and flexors of each joint.

    An episode is truncated at the end of its intention (10 s), and terminated when the arm is lost:
    more than 1 rad from the intention, or in a suit whose torque met its pole, or diverged.

    Reward: the sum of `info["reward_terms"]`: minus human effort, tracking error and unsteadiness;
    never below -271 for the default wearer, whose strength bounds the effort.

    Where MuJoCo reports that the physics diverged, `info["diverged"]` is true, and that step shows
    the last valid observation and measurements; its reward is that of a tracking error of 1 rad at
    both joints. All numbers stay finite.

    Args:
        observe: Content of the observation: "sensors" (what an exoskeleton can measure) or
            "oracle" (also the suit torque).
        control_dt: Time between actions [s]; it is a multiple of the physics step and divides
            0.02 s.
        control: The wearer's control of the arm, or a dict of the fields that differ from the
            default, whose delay is the multiple of `control_dt` that is nearest to 0.05 s.
        fatigue: Whether the wearer's muscles tire, from a rested start in every episode.
        render_mode: Render mode of Gymnasium: None, "rgb_array" or "human".
        camera: Name of the camera to render from.
        width: Width of the picture [pixels].
        height: Height of the picture [pixels].
        render_quality: Quality of pictures: "fast", which needs no graphics card, or "fine", with
            shadows, smooth edges and reflections.
        picture_dt: Simulated time between new pictures [s], in which `render` returns the last one
            again; 0 draws each anew. A recorder asks after every step: with 0.04 it draws 25
            pictures a second, and its film still plays in real time.
        **arm: Fields of `ArmConfig`: suit, pressure, gravity, wearer, exo, coupling, payload,
            side, tilt, misalignment, sim_dt, allow_uncertified. Give nested fields as dicts if you
            need `EnvSpec.to_json`.

    Raises:
        InputError: An argument is out of its range; the message names it.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 100}  # noqa: RUF012

    span: ClassVar[dict[str, tuple[float, float]]]  # rad, of the joints that move
    hold: ClassVar[dict[str, tuple[float, float]]]  # rad, of joints held at a random angle
    duration: ClassVar[float] = 10.0  # s
    move_time: ClassVar[tuple[float, float]] = (1.2, 2.4)  # s
    dwell_time: ClassVar[tuple[float, float]] = (0.0, 0.5)  # s

    def __init__(
        self,
        *,
        observe: Literal["sensors", "oracle"] = "sensors",
        control_dt: float = 0.01,
        control: VoluntaryControl | Mapping[str, Any] | None = None,
        fatigue: bool = False,
        render_mode: str | None = None,
        camera: str = "overview",
        width: int = 640,
        height: int = 480,
        render_quality: RenderQuality = "fast",
        picture_dt: float = 0.0,
        **arm: Any,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError(f"render_mode is {render_mode!r}: use None, 'rgb_array' or 'human'")
        within("control_dt", control_dt, 0, PREVIEW[0], " s")
        self.config = ArmConfig.from_dict(arm)
        self.model = compose(self.config)
        self.control_dt, sim_dt = control_dt, self.config.timestep
        self.substeps = round(control_dt / sim_dt)
        if self.substeps < 1 or abs(self.substeps * sim_dt - control_dt) > 1e-9:
            raise InputError(
                f"control_dt is {control_dt} and sim_dt {sim_dt}: control_dt must be a multiple"
            )
        # Gymnasium's recorders ask for a picture after each step, and play them at this rate.
        self.metadata = {**self.metadata, "render_fps": round(1 / control_dt)}
        self.data = mujoco.MjData(self.model)
        self.render_mode = render_mode
        self.renderer = Renderer(
            camera=camera,
            width=width,
            height=height,
            quality=render_quality,
            picture_dt=picture_dt,
        )
        self.wiring = Wiring.of(self.model)
        self._observer = Observer(self.wiring, self.config.exo.encoder_bits, control_dt, observe)
        usual = VoluntaryControl()
        usual = replace(usual, delay=round(usual.delay / control_dt) * control_dt)
        settings = nested("control", {} if control is None else control, usual)
        self.wearer = Wearer(self.config.wearer, settings, fatigue, self.wiring, control_dt)
        self._motors = Motors(self.config.exo, self.wiring, control_dt)
        self._previous_action = np.zeros(self.wiring.motors.size)
        self._meter = Meter(self.wiring, control_dt)
        self._bare_arm = bare_arm(self.config)
        self._known_suit = resisting_joints(self.config) if settings.suit_learning > 0 else {}
        self.layout = self._observer.layout
        self.observation_space = self._observer.space
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, self._previous_action.shape, np.float32)

    # --- Gymnasium ----------------------------------------------------------------------------

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode with a new intention; the suit's memory begins at its start angle.

        There are no `options`: each one raises an error.
        """
        if options is not None and options != {}:
            raise InputError(f"reset got the options {shown(options)}: it knows none; leave it out")
        super().reset(seed=seed)
        mujoco.mj_resetData(self.model, self.data)
        self._pursue(self._new_reference(self.np_random))
        self._step = self._clipped = 0
        self._diverged = False
        self._previous_action[:] = 0
        self._motors.mean_square[:] = 0
        self.wearer.settle(self.model, self.data, self.reference)
        start_encoders(self.model, self.data)
        mujoco.mj_forward(self.model, self.data)
        self._meter.begin(self.data)
        self._look()
        if self.render_mode == "human":
            self.render()
        change = np.zeros_like(self._previous_action)
        return self._answer(self._reward_terms(self._tracking_error(), change))

    def step(
        self, action: NDArray[np.floating[Any]]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Applies `action` for one control period.

        Raises:
            InputError: The action has the wrong shape or is not finite, or there was no reset.
        """
        self._require_reset("step")
        command, clipped = checked(action, self._previous_action.shape)
        self._clipped += clipped
        if not self._diverged:
            self._motors.drive(self.data, command)
            self.wearer.act(self.data, self.reference, self._step + 1, self.np_random)
        # mj_step1 of the last substep comes last: positions, velocities and the forces that
        # depend on them are then those of the new state.
        mujoco.mj_step2(self.model, self.data)
        if self.substeps > 1:
            mujoco.mj_step(self.model, self.data, self.substeps - 1)
        mujoco.mj_step1(self.model, self.data)
        self._step += 1
        change, self._previous_action = command - self._previous_action, command
        self._diverged = self._has_diverged()
        if self._diverged:
            error, terminated = FAR_OFF, True
        else:
            self._motors.heat(self.data)
            self.wearer.tire(self.data)
            self._look()
            self._meter.count(self.data)
            error = self._tracking_error()
            terminated = self._lost(error)
        observation, info = self._answer(self._reward_terms(error, change))
        if self.render_mode == "human":
            self.render()
        truncated = self._step >= len(self.reference.angle) - 1
        return observation, sum(info["reward_terms"].values()), terminated, truncated, info

    def render(self) -> NDArray[np.uint8] | None:
        """Returns a picture (height, width, 3) for "rgb_array"; updates the window for "human"."""
        if self.render_mode is None:
            raise InputError(
                "render_mode is None: make the environment with render_mode='rgb_array'"
            )
        if self.render_mode == "human":
            return self.renderer.show(self.model, self.data, self.control_dt)
        return self.renderer.picture(self.model, self.data)

    def close(self) -> None:
        """Frees the renderer; later calls do nothing."""
        self.renderer.close()

    # --- State --------------------------------------------------------------------------------

    def get_state(self) -> dict[str, Any]:
        """Returns the whole state of the episode, to save it or to continue from it more than once.

        The state holds the physics with the suit's memory, the intention, the counters and the
        random generator, as arrays and plain values (picklable).

        Raises:
            InputError: There was no reset.
        """
        self._require_reset("get_state")
        return {
            "config": self._identity(),
            "physics": physics_of(self.model, self.data),
            "actuator_force": self.data.actuator_force.copy(),
            "reference": self.reference,
            "step": self._step,
            "clipped_actions": self._clipped,
            "energy": dict(self._meter.energy),
            "dissipated_at_reset": self._meter.dissipated_at_reset,
            "diverged": self._diverged,
            "random": self.np_random.bit_generator.state,
            **{name: values.copy() for name, values in self._memory().items()},
        }

    def set_state(self, state: dict[str, Any]) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Restores a state of `get_state`; the episode then continues bit for bit.

        Returns:
            The observation and info of that moment, without new reward terms.

        Raises:
            InputError: The state belongs to another suit, gravity or step, or to an episode that
                has diverged, or does not come from `get_state`; nothing has changed.
        """
        memory = self._memory()
        identity, samples = self._identity(), self._samples()
        check_state(state, identity, self.model, samples, memory, self.np_random)
        restore_physics(self.model, self.data, state)
        self._pursue(state["reference"])
        self._step = state["step"]
        self._clipped = state["clipped_actions"]
        self._meter.energy = dict(state["energy"])
        self._meter.dissipated_at_reset = state["dissipated_at_reset"]
        for name, values in memory.items():
            values[:] = state[name]
        self._diverged = False
        self.np_random.bit_generator.state = state["random"]
        self._look()
        return self._answer({})

    # --- Parts --------------------------------------------------------------------------------

    def _identity(self) -> dict[str, Any]:
        return {
            "task": type(self).__name__,
            **self.config.to_dict(),
            "control_dt": self.control_dt,
            "control": asdict(self.wearer.settings),
            "fatigue": self.wearer.tires,
        }

    def _memory(self) -> dict[str, Array]:
        """The memory of wearer, motors and agent, as the arrays themselves."""
        return {
            "previous_action": self._previous_action,
            "motor_heat": self._motors.mean_square,
            "past_torque": self.wearer.control.past,
            "variation": self.wearer.control.variation,
            "fatigued": self.wearer.fatigued,
        }

    def _require_reset(self, what: str) -> None:
        if not hasattr(self, "reference"):
            raise InputError(f"{what} before the first reset: call reset() first")

    def intended_motion(self, rng: np.random.Generator) -> tuple[Array, Array, Array]:
        """Returns the angles [rad] of an episode and two derivatives, (samples, 4) each.

        Override it for a motion of your own, with the same arm and the same wearer.
        """
        samples, dt = self._samples(), self.control_dt
        return random_motion(
            rng, self.span, self.hold, samples, dt, self.move_time, self.dwell_time
        )

    def _samples(self) -> int:
        return round(self.duration / self.control_dt) + 1

    def _new_reference(self, rng: np.random.Generator) -> Reference:
        motion = valid_motion(self.intended_motion(rng), self._samples(), self._bare_arm.jnt_range)
        return follow(self._bare_arm, self.wiring.joints, motion, self._known_suit)

    def _pursue(self, reference: Reference) -> None:
        self.reference = reference
        self._observer.begin(reference)
        self.renderer.forget()

    def _has_diverged(self) -> bool:
        warned = any(self.data.warning.number[DIVERGENCE].tolist())
        torque = sum(self.data.sensordata[self.wiring.suit_torque].tolist())
        return warned or not math.isfinite(torque + self._meter.dissipated_in(self.data))

    def _look(self) -> None:
        """Keeps the present values; they are shown again if the physics diverges later."""
        now = self.reference.at(self._step)
        self._observation = self._observer(self.data, now, self._previous_action)
        others = {}
        if self.wiring.motors.size:
            others["motor_load"] = self._motors.load
        if self.wearer.tires:
            others["fatigue"] = self.wearer.fatigued
        self._meter.read(self.data, self.reference.angle[now], others)

    def _tracking_error(self) -> list[float]:
        error = self._meter.values["angle"] - self._meter.values["target_angle"]
        return error[self.wiring.assisted].tolist()

    def _lost(self, error: list[float]) -> bool:
        faults = self.data.plugin_state[self.wiring.faults]
        return max(map(abs, error)) > LOST or any(faults.tolist())

    def _reward_terms(self, error: Sequence[float], change: Array) -> dict[str, float]:
        human_torque = self._meter.values["human_torque"][self.wiring.assisted]
        return reward_terms(human_torque.tolist(), error, change.tolist())

    def _answer(self, terms: dict[str, float]) -> tuple[NDArray[np.float32], dict[str, Any]]:
        return self._observation.copy(), {
            "time": float(self.data.time),
            **self._meter.report(),
            "clipped_actions": self._clipped,
            "diverged": self._diverged,
            "reward_terms": terms,
        }
