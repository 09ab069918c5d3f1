"""The Gymnasium environment: a suited arm follows an intention, the agent drives the motors."""

from typing import Any, ClassVar, Literal

import gymnasium
import mujoco
import numpy as np
from numpy.typing import NDArray

from ..assets import JOINTS
from ..errors import InputError
from .composition import ASSISTED, ArmConfig, bare_arm, compose
from .observation import Observer
from .reference import Reference, follow, random_moves
from .rendering import Renderer
from .wiring import Wiring

Array = NDArray[np.float64]
EFFORT_SCALE = np.array([20.0, 10.0])  # N·m at shoulder and elbow that cost 1
ERROR_SCALE = 0.1  # rad that cost 1
SMOOTHNESS = 0.1
SETTLING_ITERATIONS = 8  # each one shrinks the error by stiffness of suit and weight over kp
LOST = 1.0  # rad of tracking error at which an episode ends


class ArmEnv(gymnasium.Env):
    """Base of the tasks: physics, observation, reward, state; a task adds only its motion.

    The wearer tracks a minimum-jerk intention with engine-native PID actuators whose torque is
    limited to human strength. The suit resists every joint inside the physics. The agent sets the
    assist torque of shoulder and elbow.

    Action: `Box(-1, 1, (2,), float32)`, assist torque of shoulder and elbow flexion over the
    motors' peak (40 and 25 N·m). What lies outside is clipped and counted in
    `info["clipped_actions"]`.

    Observation: `Box` of float32, the parts of `layout` one after the other: joint angles [rad] and
    rates [rad/s] of the four encoders, motor torque over peak, target angles of shoulder and elbow
    0.02, 0.1 and 0.24 s ahead [rad], previous action; with `observe="oracle"` also the suit
    torque [N·m] of the four joints. Positions, rates and suit torques are those of this instant;
    the torques of motors and wearer are the ones applied in the last physics step.

    An episode is truncated at the end of its intention (10 s), and terminated when the arm is lost.

    Reward: the sum of `info["reward_terms"]`: minus human effort, tracking error and unsteadiness.

    Args:
        suit: name of a shipped suit, or path of a suit file.
        gravity: "earth", "mars", "moon" or "microgravity".
        observe: "sensors" (what an exoskeleton can measure) or "oracle" (with the suit torque).
        control_dt: time between actions [s], a multiple of `sim_dt` that divides 0.02 s.
        sim_dt: physics step [s].
        allow_uncertified: accept suits whose torque could become infinite in some motion.
        render_mode: None, "rgb_array" or "human".
        camera: name of the camera to render from.
        width: picture width [pixels].
        height: picture height [pixels].

    Raises:
        InputError: an argument is out of its range; the message names it.
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
        suit: str = "mock-suit",
        gravity: str = "earth",
        observe: Literal["sensors", "oracle"] = "sensors",
        control_dt: float = 0.01,
        sim_dt: float = 0.002,
        allow_uncertified: bool = False,
        render_mode: str | None = None,
        camera: str = "overview",
        width: int = 640,
        height: int = 480,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError(f"render_mode is {render_mode!r}: use None, 'rgb_array' or 'human'")
        self.config = ArmConfig(
            suit=suit, gravity=gravity, sim_dt=sim_dt, allow_uncertified=allow_uncertified
        )
        self.model = compose(self.config)
        self.substeps = round(control_dt / sim_dt)
        if self.substeps < 1 or abs(self.substeps * sim_dt - control_dt) > 1e-9:
            raise InputError(
                f"control_dt is {control_dt} and sim_dt {sim_dt}: control_dt must be a multiple"
            )
        self.control_dt = control_dt
        self.metadata = {**self.metadata, "render_fps": round(1 / control_dt)}
        self.data = mujoco.MjData(self.model)
        self.render_mode = render_mode
        self.renderer = Renderer(camera=camera, width=width, height=height)
        self.wiring = Wiring.of(self.model)
        self._observer = Observer(self.wiring, control_dt, observe)
        self._bare_arm = bare_arm(gravity)
        self.layout = self._observer.layout
        self.observation_space = self._observer.space
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(ASSISTED),), np.float32)

    # --- Gymnasium ----------------------------------------------------------------------------

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode with a new intention; the suit's memory begins at its start angle.

        No `options` are known; any is an error.
        """
        super().reset(seed=seed)
        if options:
            raise InputError(f"reset got the options {sorted(options)}: it knows none")
        mujoco.mj_resetData(self.model, self.data)
        self.reference = self._new_reference(self.np_random)
        self._step = 0
        self._clipped = 0
        self._energy = {"assist_energy": 0.0, "human_energy": 0.0}
        self._previous_action = np.zeros(len(ASSISTED))
        self._intend()
        self._settle()
        self._dissipated_at_reset = float(self.data.sensordata[self.wiring.dissipated].sum())
        if self.render_mode == "human":
            self.render()
        return self._observation(), self._info(
            self._reward_terms(self._tracking_error(), np.zeros(len(ASSISTED)))
        )

    def step(
        self, action: NDArray[np.floating[Any]]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Applies `action` for one control period.

        Raises:
            InputError: the action has the wrong shape or is not finite.
        """
        command = self._checked(action)
        self.data.ctrl[self.wiring.motors] = command
        self._intend()
        # mj_step1 of the last substep comes last: positions, velocities and the forces that
        # depend on them are then those of the new state.
        mujoco.mj_step2(self.model, self.data)
        if self.substeps > 1:
            mujoco.mj_step(self.model, self.data, self.substeps - 1)
        mujoco.mj_step1(self.model, self.data)
        self._step += 1
        rate = np.abs(self.data.qvel[self.wiring.joints])
        force = np.abs(self.data.actuator_force)
        human_power, assist_power = (
            force[self.wiring.human] @ rate,
            force[self.wiring.assist] @ rate[self.wiring.assisted],
        )
        self._energy["human_energy"] += float(human_power) * self.control_dt
        self._energy["assist_energy"] += float(assist_power) * self.control_dt
        error = self._tracking_error()
        terms = self._reward_terms(error, command - self._previous_action)
        self._previous_action = command
        terminated = self._failed(error)
        if self.render_mode == "human":
            self.render()
        truncated = self._step >= len(self.reference.angle) - 1
        info = self._info(terms)
        return self._observation(), float(sum(terms.values())), terminated, truncated, info

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
        """Frees the renderer; may be called any number of times."""
        self.renderer.close()

    # --- State --------------------------------------------------------------------------------

    def get_state(self) -> dict[str, Any]:
        """Returns everything that the future depends on, to branch from or to save.

        It holds the physics with the suit's memory, the intention, the counters and the random
        generator, as arrays and plain values (picklable).
        """
        signature = mujoco.mjtState.mjSTATE_INTEGRATION
        physics = np.empty(mujoco.mj_stateSize(self.model, signature))
        mujoco.mj_getState(self.model, self.data, physics, signature)
        return {
            "config": self._identity(),
            "physics": physics,
            "actuator_force": self.data.actuator_force.copy(),
            "reference": self.reference,
            "step": self._step,
            "clipped_actions": self._clipped,
            "energy": dict(self._energy),
            "dissipated_at_reset": self._dissipated_at_reset,
            "previous_action": self._previous_action.copy(),
            "random": self.np_random.bit_generator.state,
        }

    def set_state(self, state: dict[str, Any]) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Continues from what `get_state` returned, bit for bit.

        Returns:
            The observation and info of that moment, without new reward terms.

        Raises:
            InputError: the state is of an environment with another suit, gravity or step.
        """
        signature = mujoco.mjtState.mjSTATE_INTEGRATION
        size = mujoco.mj_stateSize(self.model, signature)
        if state["config"] != self._identity() or np.shape(state["physics"]) != (size,):
            raise InputError(
                f"the state is of {state['config']} and this environment is {self._identity()}: "
                "make it with the same options"
            )
        mujoco.mj_setState(self.model, self.data, state["physics"], signature)
        self.reference = state["reference"]
        self._step = state["step"]
        self._clipped = state["clipped_actions"]
        self._energy = dict(state["energy"])
        self._dissipated_at_reset = state["dissipated_at_reset"]
        self._previous_action = state["previous_action"].copy()
        self.np_random.bit_generator.state = state["random"]
        mujoco.mj_step1(self.model, self.data)
        self.data.actuator_force[:] = state["actuator_force"]
        return self._observation(), self._info({})

    # --- Parts --------------------------------------------------------------------------------

    def _identity(self) -> str:
        return f"{type(self).__name__}({self.config}, control_dt={self.control_dt})"

    def _new_reference(self, rng: np.random.Generator) -> Reference:
        samples = round(self.duration / self.control_dt) + 1
        motion = np.zeros((3, samples, len(JOINTS)))
        for joint, span in self.span.items():
            motion[:, :, JOINTS.index(joint)] = random_moves(
                rng, span, samples, self.control_dt, self.move_time, self.dwell_time
            )
        for joint, span in self.hold.items():
            motion[0, :, JOINTS.index(joint)] = rng.uniform(*span)
        return follow(self._bare_arm, self.wiring.joints, (motion[0], motion[1], motion[2]))

    def _at(self, step: int) -> int:
        return min(step, len(self.reference.angle) - 1)

    def _intend(self) -> None:
        """Gives the wearer the intention of the end of the coming control period."""
        i = self._at(self._step + 1)
        ctrl, where = self.data.ctrl, self.wiring.intention
        ctrl[where[:, 0]] = self.reference.angle[i]
        ctrl[where[:, 1]] = self.reference.rate[i] * (i == self._step + 1)  # 0 past the end
        ctrl[where[:, 2]] = self.reference.feedforward[i]

    def _settle(self) -> None:
        """Puts the arm where the wearer holds it at rest: feedback carries what is not foreseen."""
        data, joints = self.data, self.wiring.joints
        intended, feedforward = self.reference.angle[0], self.reference.feedforward[0]
        angle = intended
        for _ in range(SETTLING_ITERATIONS):
            data.qpos[joints] = angle
            mujoco.mj_forward(self.model, data)
            load = data.qfrc_bias[joints] - data.qfrc_passive[joints]
            angle = intended - (load - feedforward) / self.wiring.stiffness
        data.qpos[joints] = angle
        mujoco.mj_forward(self.model, data)

    def _checked(self, action: NDArray[np.floating[Any]]) -> Array:
        command = np.asarray(action, dtype=np.float64)
        if command.shape != (len(ASSISTED),):
            raise InputError(
                f"action has shape {command.shape}: give ({len(ASSISTED)},), shoulder and elbow"
            )
        if not np.isfinite(command).all():
            raise InputError(f"action is {command.tolist()}: give finite numbers from -1 to 1")
        if np.abs(command).max() > 1.0:
            self._clipped += 1
            command = np.clip(command, -1.0, 1.0)
        return command

    def _tracking_error(self) -> Array:
        angle = self.data.qpos[self.wiring.joints[self.wiring.assisted]]
        return angle - self.reference.angle[self._at(self._step), self.wiring.assisted]

    def _reward_terms(self, error: Array, change: Array) -> dict[str, float]:
        effort = self.data.actuator_force[self.wiring.human[self.wiring.assisted]] / EFFORT_SCALE
        error = error / ERROR_SCALE
        return {
            "effort": -float(effort @ effort),
            "tracking": -float(error @ error),
            "smoothness": -SMOOTHNESS * float(change @ change),
        }

    def _failed(self, error: Array) -> bool:
        followed = np.abs(error).max() <= LOST  # false where the physics has become NaN
        return not followed or bool(self.data.plugin_state[self.wiring.faults].any())

    def _observation(self) -> NDArray[np.float32]:
        return self._observer(self.data, self.reference, self._step, self._previous_action)

    def _info(self, terms: dict[str, float]) -> dict[str, Any]:
        data = self.data
        dissipated = (
            float(data.sensordata[self.wiring.dissipated].sum()) - self._dissipated_at_reset
        )
        return {
            "time": float(data.time),
            "angle": data.qpos[self.wiring.joints].copy(),
            "target_angle": self.reference.angle[self._at(self._step)].copy(),
            "human_torque": data.actuator_force[self.wiring.human].copy(),
            "suit_torque": self.wiring.suit_torque_of(data),
            "assist_torque": data.actuator_force[self.wiring.assist].copy(),
            **self._energy,
            "dissipated_energy": dissipated,
            "clipped_actions": self._clipped,
            "reward_terms": terms,
        }
