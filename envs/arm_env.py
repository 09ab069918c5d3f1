"""The Gymnasium environment: a suited arm follows an intention, the agent drives the motors."""

import math
from copy import copy, deepcopy
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
from .reward import LOST, reward_terms
from .state import ENERGIES, check_state, physics_of, restore_physics
from .wearer import intend, settle
from .wiring import Wiring

Array = NDArray[np.float64]
DIVERGENCE = slice(mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQACC + 1)


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

    An episode is truncated at the end of its intention (10 s), and terminated when the arm is lost:
    more than 1 rad from the intention, or in a suit whose torque met its pole, or diverged.

    Reward: the sum of `info["reward_terms"]`: minus human effort, tracking error and unsteadiness;
    never below -270.

    Where MuJoCo reports that the physics diverged, `info["diverged"]` is true, and that step shows
    the last valid observation and measurements; its reward is that of a tracking error of 1 rad at
    both joints. All numbers stay finite.

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
        self._energy = dict.fromkeys(ENERGIES, 0.0)
        self._previous_action = np.zeros(len(ASSISTED))
        intend(self.data, self.wiring, self.reference, 1)
        settle(self.model, self.data, self.wiring, self.reference)
        self._dissipated_at_reset = float(self.data.sensordata[self.wiring.dissipated].sum())
        if self.render_mode == "human":
            self.render()
        return self._present(
            reward_terms(self._human_torque(), self._tracking_error(), np.zeros(len(ASSISTED)))
        )

    def step(
        self, action: NDArray[np.floating[Any]]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Applies `action` for one control period.

        Raises:
            InputError: the action has the wrong shape or is not finite, or there was no reset.
        """
        self._require_reset("step")
        command = self._checked(action)
        self.data.ctrl[self.wiring.motors] = command
        intend(self.data, self.wiring, self.reference, self._step + 1)
        # mj_step1 of the last substep comes last: positions, velocities and the forces that
        # depend on them are then those of the new state.
        mujoco.mj_step2(self.model, self.data)
        if self.substeps > 1:
            mujoco.mj_step(self.model, self.data, self.substeps - 1)
        mujoco.mj_step1(self.model, self.data)
        self._step += 1
        change, self._previous_action = command - self._previous_action, command
        if self._diverged():
            terminated = True
            observation, info = self._last_valid(change)
        else:
            self._count_energy()
            error = self._tracking_error()
            terminated = self._lost(error)
            observation, info = self._present(reward_terms(self._human_torque(), error, change))
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
        """Frees the renderer; may be called any number of times."""
        self.renderer.close()

    # --- State --------------------------------------------------------------------------------

    def get_state(self) -> dict[str, Any]:
        """Returns everything that the future depends on, to branch from or to save.

        It holds the physics with the suit's memory, the intention, the counters and the random
        generator, as arrays and plain values (picklable).

        Raises:
            InputError: there was no reset.
        """
        self._require_reset("get_state")
        return {
            "config": self._identity(),
            "physics": physics_of(self.model, self.data),
            "actuator_force": self.data.actuator_force.copy(),
            "reference": self.reference,
            "step": self._step,
            "clipped_actions": self._clipped,
            "energy": dict(self._energy),
            "dissipated_at_reset": self._dissipated_at_reset,
            "previous_action": self._previous_action.copy(),
            "diverged": self._diverged(),
            "random": self.np_random.bit_generator.state,
        }

    def set_state(self, state: dict[str, Any]) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Continues from what `get_state` returned, bit for bit.

        Returns:
            The observation and info of that moment, without new reward terms.

        Raises:
            InputError: the state is of an environment with another suit, gravity or step, or of an
                episode that has diverged, or not what `get_state` returned; nothing has changed.
        """
        check_state(state, self._identity(), self.model, self._samples(), self.np_random)
        restore_physics(self.model, self.data, state)
        self.reference = state["reference"]
        self._step = state["step"]
        self._clipped = state["clipped_actions"]
        self._energy = dict(state["energy"])
        self._dissipated_at_reset = state["dissipated_at_reset"]
        self._previous_action = state["previous_action"].copy()
        self.np_random.bit_generator.state = state["random"]
        return self._present({})

    # --- Parts --------------------------------------------------------------------------------

    def _identity(self) -> str:
        return f"{type(self).__name__}({self.config}, control_dt={self.control_dt})"

    def _require_reset(self, what: str) -> None:
        if not hasattr(self, "reference"):
            raise InputError(f"{what} before the first reset: call reset() first")

    def _samples(self) -> int:
        return round(self.duration / self.control_dt) + 1

    def _new_reference(self, rng: np.random.Generator) -> Reference:
        samples = self._samples()
        motion = np.zeros((3, samples, len(JOINTS)))
        for joint, span in self.span.items():
            motion[:, :, JOINTS.index(joint)] = random_moves(
                rng, span, samples, self.control_dt, self.move_time, self.dwell_time
            )
        for joint, span in self.hold.items():
            motion[0, :, JOINTS.index(joint)] = rng.uniform(*span)
        return follow(self._bare_arm, self.wiring.joints, (motion[0], motion[1], motion[2]))

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
        return angle - self.reference.angle[self.reference.at(self._step), self.wiring.assisted]

    def _human_torque(self) -> Array:
        return self.data.actuator_force[self.wiring.human[self.wiring.assisted]]

    def _count_energy(self) -> None:
        rate = np.abs(self.data.qvel[self.wiring.joints])
        force = np.abs(self.data.actuator_force)
        human_power = force[self.wiring.human] @ rate
        assist_power = force[self.wiring.assist] @ rate[self.wiring.assisted]
        self._energy["human_energy"] += float(human_power) * self.control_dt
        self._energy["assist_energy"] += float(assist_power) * self.control_dt

    def _lost(self, error: Array) -> bool:
        faults = self.data.plugin_state[self.wiring.faults]
        return bool(np.abs(error).max() > LOST or faults.any())

    def _diverged(self) -> bool:
        sensed = self.data.sensordata
        total = sensed[self.wiring.suit_torque].sum() + sensed[self.wiring.dissipated].sum()
        return bool(self.data.warning.number[DIVERGENCE].any()) or not math.isfinite(total)

    def _present(self, terms: dict[str, float]) -> tuple[NDArray[np.float32], dict[str, Any]]:
        observation, info = self._observation(), self._info(terms)
        self._valid = (observation.copy(), {key: copy(value) for key, value in info.items()})
        return observation, info

    def _last_valid(self, change: Array) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Returns the last valid observation and info, with the time and price of this step."""
        observation, info = deepcopy(self._valid)
        human_torque = info["human_torque"][self.wiring.assisted]
        return observation, {
            **info,
            "time": float(self.data.time),
            "clipped_actions": self._clipped,
            "diverged": True,
            "reward_terms": reward_terms(human_torque, np.full(len(ASSISTED), LOST), change),
        }

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
            "target_angle": self.reference.angle[self.reference.at(self._step)].copy(),
            "human_torque": data.actuator_force[self.wiring.human].copy(),
            "suit_torque": self.wiring.suit_torque_of(data),
            "assist_torque": data.actuator_force[self.wiring.assist].copy(),
            **self._energy,
            "dissipated_energy": dissipated,
            "clipped_actions": self._clipped,
            "diverged": False,
            "reward_terms": terms,
        }
