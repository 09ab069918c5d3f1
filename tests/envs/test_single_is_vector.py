"""Row i of a vector environment is the single environment with that seed, to the last bit."""

import gymnasium
import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.simulation.episode_plan import Plan
from activesuit.envs.tasks import RandomMoves
from activesuit.envs.vector_env import ArmVectorEnv
from gymnasium.vector import AutoresetMode

TERMS = {
    "suits": ["mock-suit", "emu-like"],
    "pressure": 0.2,
    "payload": [0.0, 2.0],
    "gravity": ["earth", "mars"],
    "wearers": [{"sex": "female", "stature": 1.6, "mass": 60.0}, {}],
    "sensor_noise": [0.5, 2.0],
    "encoder_offset": 0.02,
}
VARIED = {
    "fatigue": True,
    "faults": {"late": 0.2, "lost": 0.2, "torque_bias": 1},
    "exo": {"encoder_delay": 0.02},
    "control": {"noise": 1.0, "tremor": 0.01, "adaptation": 0.8},
    "randomize": TERMS,
}
SUITES = ["encoders", "interaction", "emg", "preview", "belief", "privileged"]
MODES = ["NextStep", "SameStep", "Disabled"]
SHORT = 13  # control periods of an episode


class Juggle(RandomMoves):
    """Loads are taken up and put down within each episode."""

    carries = True

    def plan(self, rng, samples, dt, arm):
        mass = np.repeat(rng.uniform(0, 3, samples // 5 + 1), 5)[:samples]
        mass[::4] = 0.0
        return Plan(self.motion(rng, samples, dt), mass)


TASK = Juggle(name="Juggle", span={"elbow_flexion": (0.5, 1.5)})


def make(n, threads=1, mode="NextStep", coupling="rigid", **options):
    options = {**VARIED, "coupling": coupling, "sensors": SUITES, **options}
    if coupling == "cuffs":
        options["randomize"] = {**TERMS, "misalignment": 0.01}
        options["sensors"] = [*SUITES, "cuffs"]
    singles = [ArmEnv(TASK, **options) for _ in range(n)]
    limit = {"max_episode_steps": SHORT, "threads": threads, "autoreset_mode": mode}
    arms = ArmVectorEnv(n, TASK, info="full", **limit, **options)
    return arms, [gymnasium.wrappers.TimeLimit(single, SHORT) for single in singles]


def assert_same(info, reported, row):
    for name, value in info.items():
        if name in ("reward_terms", "cost_terms"):
            assert value == {term: reported[name][term][row] for term in value}
        else:
            np.testing.assert_array_equal(np.ravel(value), np.ravel(reported[name][row]), name)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(
    ("n", "threads", "coupling"), [(1, 1, "rigid"), (3, 2, "cuffs"), (8, 2, "rigid")]
)
def test_through_resets(n, threads, mode, coupling):
    arms, singles = make(n, threads, mode, coupling)
    rng, over = np.random.default_rng(0), np.zeros(n, bool)
    shown, reported = arms.reset(seed=5)
    for row, single in enumerate(singles):
        observation, info = single.reset(seed=5 + row)
        np.testing.assert_array_equal(observation, shown[row])
        assert_same(info, reported, row)
    lost = 0
    for period in range(3 * SHORT):
        if mode == "Disabled" and over.any():
            shown, reported = arms.reset(options={"reset_mask": over})
            for row in np.flatnonzero(over):
                observation, info = singles[row].reset()
                np.testing.assert_array_equal(observation, shown[row])
                assert_same(info, reported, row)
            over[:] = False
        # Rows end at different times: some are thrown about.
        actions = rng.uniform(-1, 1, (n, 2)) * (3.0 if period > SHORT else 0.3)
        if period == 5:
            arms.episodes.simulation.batch.bind("qvel")[0] = 500.0
            singles[0].unwrapped.episodes.simulation.batch.bind("qvel")[0] = 500.0
        shown, rewards, terminated, truncated, reported = arms.step(actions)
        for row, single in enumerate(singles):
            if mode == "NextStep" and over[row]:
                observation, info = single.reset()
                reward, ended, late = 0.0, False, False
            else:
                observation, reward, ended, late, info = single.step(actions[row])
            assert (reward, ended, late) == (rewards[row], terminated[row], truncated[row])
            lost += ended
            if mode == "SameStep" and (ended or late):
                np.testing.assert_array_equal(observation, reported["final_obs"][row])
                assert_same(info, reported["final_info"], row)
                observation, info = single.reset()
            np.testing.assert_array_equal(observation, shown[row])
            assert_same(info, reported, row)
        over = terminated | truncated
    assert lost > 0


@pytest.mark.parametrize("coupling", ["rigid", "cuffs"])
def test_any_row_continues_from_any_state(coupling):
    arms, (single, *_) = make(3, coupling=coupling)
    rng = np.random.default_rng(1)
    single.reset(seed=9)
    for _ in range(4):
        single.step(rng.uniform(-0.5, 0.5, 2))
    state = single.unwrapped.get_state()
    arms.reset(seed=0)
    arms.step(np.zeros((3, 2)))
    shown, _ = arms.set_state(state, rows=[2])
    for _ in range(SHORT - 5):
        action = rng.uniform(-1, 1, 2)
        observation, reward, *_ = single.step(action)
        shown, rewards, *_ = arms.step(np.array([[0.1, 0.1], [0.0, 0.2], action]))
        np.testing.assert_array_equal(observation, shown[2])
        assert reward == rewards[2]
    # And a state of two rows goes into two others.
    both = arms.get_state(rows=[1, 2])
    first = [arms.step(np.full((3, 2), 0.1))[0] for _ in range(2)]
    arms.reset(seed=4)
    arms.set_state(both, rows=[0, 1])
    again = [arms.step(np.full((3, 2), 0.1))[0] for _ in range(2)]
    for one, other in zip(first, again, strict=True):
        np.testing.assert_array_equal(one[1:], other[:2])


def test_made_by_gymnasium():
    arms = gymnasium.make_vec("ActiveSuit/ElbowFlexion-v0", num_envs=3, gravity="moon")
    assert isinstance(arms, ArmVectorEnv)
    assert arms.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    single = gymnasium.make("ActiveSuit/ElbowFlexion-v0", gravity="moon")
    shown, info = arms.reset(seed=[3, 1, None])
    assert info == {}
    np.testing.assert_array_equal(shown[0], single.reset(seed=3)[0])
    np.testing.assert_array_equal(shown[1], single.reset(seed=1)[0])
    assert shown in arms.observation_space


@pytest.mark.parametrize("mode", MODES)
def test_wrappers_of_gymnasium(mode):
    arms, _ = make(2, mode=mode)
    wrapped = gymnasium.wrappers.vector.RecordEpisodeStatistics(arms)
    if mode == "NextStep":  # Gymnasium's own limit
        wrapped = gymnasium.wrappers.vector.NormalizeObservation(wrapped)
    wrapped.reset(seed=0)
    lengths = []
    for _ in range(2 * SHORT):
        *_, terminated, truncated, info = wrapped.step(np.zeros((2, 2)))
        if "episode" in info:
            lengths += info["episode"]["l"][info["_episode"]].tolist()
        if mode == "Disabled" and (terminated | truncated).any():
            wrapped.reset(options={"reset_mask": terminated | truncated})
    assert set(lengths) == {SHORT}


def test_a_staggered_start_spreads_the_resets():
    arms = ArmVectorEnv(32, stagger=True, max_episode_steps=20)
    arms.reset(seed=0)
    ends = [arms.step(np.zeros((32, 2)))[3].sum() for _ in range(20)]
    assert max(ends) < 10 and sum(ends) >= 32
    again = ArmVectorEnv(8, stagger=True, max_episode_steps=20)
    again.reset(seed=0)
    limit = again.episodes.simulation.state.episode.limit
    arms.reset(seed=0)
    np.testing.assert_array_equal(limit, arms.episodes.simulation.state.episode.limit[:8])


def test_metrics_are_some_of_the_info():
    arms = ArmVectorEnv(2, info="metrics")
    _, info = arms.reset(seed=0)
    energies = ("human_energy", "assist_energy", "dissipated_energy")
    names = (*energies, "motor_load", "reward_terms", "is_success")
    assert set(info) == {*names, *(f"_{name}" for name in names)}


def test_the_default_observation_knows_nothing_of_what_comes():
    envs = [ArmEnv() for _ in range(2)]
    states = []
    for env in envs:
        env.reset(seed=1)
        states.append(env.get_state())
    for name in ("angle", "rate", "acceleration"):
        states[1][name][:, 51:] = states[1][name][:, 50:51]
    envs[1].set_state(states[1])
    seen = []
    for _ in range(80):
        pair = [env.step(np.array([0.2, 0.1])) for env in envs]
        moved = not np.array_equal(*(step[-1]["angle"] for step in pair))
        seen.append((moved, not np.array_equal(*(step[0] for step in pair))))
    assert [differs for moved, differs in seen if not moved] == [False] * 50
    assert seen[-1] == (True, True)
    shown = [ArmEnv(sensors=["preview"]) for _ in range(2)]
    for env, state in zip(shown, states, strict=True):
        env.set_state(state)
    pairs = [[env.step(np.zeros(2))[0] for env in shown] for _ in range(40)]
    assert not np.array_equal(*pairs[-1])
