"""The Gymnasium environment: the wearer moves a suited arm, and the agent drives the motors.

    >>> env = ArmEnv("ElbowFlexion", sensors=["encoders", "cuffs"], coupling="cuffs")
    >>> observation, info = env.reset(seed=0)
    >>> observation[env.layout["cuff_force"]].shape
    (9,)
    >>> observation, reward, terminated, truncated, info = env.step([0.1, -0.2])
    >>> info["time"], 0 < reward < 1
    (0.01, True)

An environment is row 0 of `Episodes` with one row: the same seed and actions give the same numbers
to the last bit as in any row of `ArmVectorEnv`. Observations are new arrays; `env.data` is the
physics of this instant, which the next access overwrites.
"""

from typing import Any

import gymnasium
import mujoco
import numpy as np
from numpy.typing import NDArray

from ..checks import check_seed
from ..errors import InputError, shown
from .episodes import Episodes
from .interface.info import Info
from .rendering import ArmRenderer, RenderQuality
from .setup import Setup
from .tasks import ARM_TRACKING, Task, task_of
from .vector_env import ArmVectorEnv

ROW = np.zeros(1, np.int64)


class ArmEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.floating[Any]]]):
    """One arm: a wearer who follows an intention, a suit that resists, motors that help.

    The wearer follows a minimum-jerk intention by stiffness inside the physics, a reflex, a slow
    correction, the torque of the bare arm and learned torque, all within human strength (see
    `envs.person.control`). The suit resists every joint inside the physics. The agent sets the
    assist torque of shoulder and elbow.

    Action, `Box(-1, 1, (2,), float32)`:

    | index | motor | low | high | torque at 1 [N·m] |
    |---|---|---|---|---|
    | 0 | shoulder_flexion | -1 | 1 | 40 |
    | 1 | elbow_flexion | -1 | 1 | 25 |

    Observation, `Box` of float32, the parts of the chosen suites one after the other:

    | suite | part | numbers | limit | 1 if normalized | unit |
    |---|---|---|---|---|---|
    | encoders | angle | 4 | 3.142 | 3.142 | rad |
    | encoders | rate | 4 | 20 | 4 | rad/s |
    | encoders | motor_torque | 2 | 1 | 1 | 1 |
    | encoders | previous_action | 2 | 1 | 1 | 1 |
    | cuffs | cuff_force | 9 | 1000 | 100 | N |
    | interaction | interaction_torque | 4 | 200 | 20 | N·m |
    | emg | emg | 4 | 200 | 20 | N·m |
    | preview | target | 6 | 3.142 | 3.142 | rad |
    | belief | belief | 4 | 200 | 20 | N·m |
    | privileged | suit_torque | 4 | 100 | 20 | N·m |

    - angle: angles of the exoskeleton's four encoders.
    - rate: their rates.
    - motor_torque: torque of both motors over the peak.
    - previous_action: the last action.
    - cuff_force: forces at the cuffs on upper arm, forearm and hand, noise of 1 N.
    - interaction_torque: torque between person and suit at the four joints, as pads would measure
      it: 10 % noise, 0.05 s old.
    - emg: the wearer's voluntary torque at the four joints, 0.05 s ahead of its effect, 20 % noise,
      low-pass of 6 Hz.
    - target: angles that the wearer intends at shoulder and elbow in 0.02, 0.1 and 0.24 s.
    - belief: torques of a believed model at shoulder and elbow: the resistance of the suit, then
      the torque that supports arm, suit, exoskeleton and load.
    - suit_torque: true torque of the suit on the four joints, which no device can measure.

    Reward, 1 / (1 + the sum of three terms), in [0, 1]; 0 where the arm is lost:

    | term | square of | over |
    |---|---|---|
    | effort | torque over strength, root mean square of four joints | effort of the suited arm |
    | tracking | tracking error, root mean square of four joints | 0.1 rad |
    | smoothness | change of the action, root mean square of the motors | 0.25 of the peak |

    Costs of an episode, `info["cost_terms"]`:

    - cuff_force: greatest force of a cuff over what a person should bear [1].
    - heat: greatest load of a motor over its continuous torque [1].
    - wrong_way_work: work of the motors against the motion [J].
    - chatter: sum of the squared changes of the action [1].
    - range_stops: time in which a joint is at the end of its range [s].
    - effort: root mean square of effort [1].
    - hand_error: greatest distance of the hand from its place, where it is watched [m].
    - tilt: greatest error of the hand's pitch there [rad].
    - slowness: greatest share of its intended speed that the hand lacks there [1].
    - tracking: root mean square of the tracking error over time and joints [rad].
    - worst_joint: root mean square of the tracking error of the worst joint [rad].

    Version history: v0, since version 0.1 of the package; since 0.3 `reset` returns the state from
    which the first step starts.

    Values of an action outside its range are clipped and counted in `info["clipped_actions"]`. A
    motor that has reached its highest temperature gives no more than its continuous torque. Without
    an exoskeleton (`coupling="none"`) there are no motors, and the shape is (0,).

    Parts of the observation are at `layout`. Rates are differences of the encoders' counts through
    a low-pass of 20 Hz. A belief is a torque at the encoder's angle plus 0.02 s of its rate, where
    the joint will be when the motors have answered. Angles, cuff forces and suit torques are those
    of this instant; the torques of motors and wearer are those of the last physics step.

    `info` contains quantities that no sensor measures: angle, rate and target_angle of the arm,
    human_torque, suit_torque and assist_torque, energies, effort (torque over the strength of a
    still joint); with an exoskeleton motor_load, the running root mean square of the motors' torque
    over their continuous torque; with cuffs cuff_force [N]; with `fatigue` the fatigued part of
    every muscle group, (2, 4): extensors and flexors. "is_success" says whether the episode is a
    success so far. The content is computed when it is read.

    An episode is truncated at the end of its intention (10 s), and terminated when the arm is lost:
    more than 1 rad from the intention, or at a pole of the suit's torque, or diverged. Where MuJoCo
    reports that the physics diverged, `info["diverged"]` is true, and that step shows the last
    valid observation and measurements. All numbers stay finite.

    Args:
        task: Task, or the name of a shipped one.
        render_mode: Render mode of Gymnasium: None, "rgb_array" or "human".
        camera: Name of the camera to render from.
        width: Width of the picture [pixels].
        height: Height of the picture [pixels].
        render_quality: Quality of pictures: "fast", which needs no graphics card, or "fine", with
            shadows, smooth edges and reflections.
        picture_dt: Simulated time between new pictures [s], in which `render` returns the last
            picture again; 0 draws each picture anew. A recorder calls `render` after every step:
            with 0.04 the recorder gets 25 new pictures a second, and the film still plays in real
            time.
        **options: Options of the environment: sensors, control_dt, control, level, randomize and
            others, as in `Setup`; and suit, gravity, coupling, wearer and others, as in
            `ArmConfig`. Give nested options as dicts if you need `EnvSpec.to_json`.

    Attributes:
        episodes: Episodes of the task, with the simulated arm and its sensors.
        config: Configuration of the arm.
        control_dt: Time between actions [s].
        duration: Duration of an episode [s].
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 100}  # noqa: RUF012

    def __init__(
        self,
        task: str | Task = ARM_TRACKING,
        *,
        render_mode: str | None = None,
        camera: str = "overview",
        width: int = 640,
        height: int = 480,
        render_quality: RenderQuality = "fast",
        picture_dt: float = 0.0,
        **options: Any,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError(f"render_mode is {render_mode!r}: use None, 'rgb_array' or 'human'")
        task, self._options = task_of(task), options
        self.episodes = Episodes(task, 1, Setup.of(task, options))
        simulation, self.duration = self.episodes.simulation, task.duration
        self.config, self.control_dt = simulation.config, simulation.control_dt
        # Gymnasium's recorders render after each step, and play the pictures at this rate.
        self.metadata = {**self.metadata, "render_fps": round(1 / self.control_dt)}
        self.render_mode = render_mode
        look = camera, width, height, render_quality, picture_dt
        self.renderer = ArmRenderer(self.config, task.edits, *look)
        self._data: mujoco.MjData | None = None
        self.layout = self.episodes.observer.layout
        self.observation_space = self.episodes.observer.space
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (self.episodes.motors,), np.float32)

    # --- Gymnasium ----------------------------------------------------------------------------

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode with a new intention; the suit's memory begins at its start angle.

        There are no options: any content of `options` raises an InputError.
        """
        if options is not None and options != {}:
            raise InputError(
                f"reset got the options {shown(options)}: there are no such options; leave them out"
            )
        if seed is not None:
            seed = check_seed(seed)
        super().reset(seed=seed)
        self.episodes.reset(ROW, [seed])
        self.renderer.forget()
        if self.render_mode == "human":
            self.render()
        return self._answer()

    def step(
        self, action: NDArray[np.floating[Any]]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Applies `action` for one control period."""
        self.episodes.require_reset("step")
        episodes = self.episodes
        episodes.step_one(action)
        if self.render_mode == "human":
            self.render()
        observation, info = self._answer()
        reward, ended = episodes.reward.item(), episodes.terminated.item()
        return observation, reward, ended, episodes.truncated.item(), info

    def render(self) -> NDArray[np.uint8] | None:
        """Returns a picture (height, width, 3) for "rgb_array"; updates the window for "human"."""
        if self.render_mode is None:
            raise InputError(
                "render_mode is None: make the environment with render_mode='rgb_array'"
            )
        posture = self.episodes.simulation.posture_of(0)
        if self.render_mode == "human":
            return self.renderer.show(posture, self.control_dt)
        return self.renderer.picture(posture)

    def close(self) -> None:
        """Frees the renderer; later calls do nothing."""
        self.renderer.close()

    def rows(self, count: int, **options: Any) -> ArmVectorEnv:
        """Returns a vector environment of the same task and options, with `count` rows.

        Further options are those of `ArmVectorEnv`, such as `threads`.
        """
        return ArmVectorEnv(count, self.episodes.task, **{**self._options, **options})

    # --- State --------------------------------------------------------------------------------

    def get_state(self) -> dict[str, Any]:
        """Returns the whole state of the episode, from which episodes can continue.

        The state contains the physics with the suit's memory, the intention, the counters and the
        place in the random streams, as arrays with one row and plain values (picklable).
        """
        self.episodes.require_reset("get_state")
        return self.episodes.state(ROW)

    def set_state(self, state: dict[str, Any]) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Restores a state of `get_state`; returns the observation and info of that moment.

        The episode then continues bit for bit.
        """
        self.episodes.restore(ROW, state)
        self.renderer.forget()
        return self._answer()

    # --- Parts --------------------------------------------------------------------------------

    @property
    def model(self) -> mujoco.MjModel:
        """The simulated model, which has no drawings; for reading."""
        return self.episodes.simulation.model

    @property
    def data(self) -> mujoco.MjData:
        """The physics of this instant, for reading: a change of this copy changes nothing."""
        self._data = self.episodes.simulation.data(0, self._data)
        return self._data

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_data": None}

    def _answer(self) -> tuple[NDArray[np.float32], Info]:
        episodes = self.episodes
        return episodes.observe()[0], episodes.info(0)
