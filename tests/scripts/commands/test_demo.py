"""The demo: one command from loops to report."""

import json

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs.rendering import ArmRenderer, RenderingUnavailableError
from activesuit.scripts.commands import demo as demo_module
from activesuit.scripts.commands.demo import demo
from activesuit.scripts.main import main
from activesuit.scripts.output import Bar
from helpers import fails, python, shorten_tasks

PLACES = ("earth", "microgravity")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a demo in a process of its own, and the names of the modules it loaded."""
    path = tmp_path_factory.mktemp("demo")
    code = (
        "import sys\n"
        "from dataclasses import replace\n"
        "from activesuit.envs.tasks import TASKS\n"
        "from activesuit.scripts.main import main\n"
        "TASKS.update({name: replace(task, duration=1.0) for name, task in TASKS.items()})\n"
        "main(sys.argv[1:])\n"
        "print('loaded:', *sys.modules)"
    )
    arguments = ["demo", "--trials", "1", "--motions", "8", "--out", str(path)]
    done = python("-c", code, *arguments)
    assert done.returncode == 0, done.stderr
    return path, done.stdout.rpartition("loaded: ")[2].split()


@pytest.fixture
def sketched(undrawn, monkeypatch):
    """For demos whose pictures nobody looks at: short motions on Earth, no figures, no arm."""
    monkeypatch.setattr(demo_module, "GRAVITIES", ("earth",))
    monkeypatch.setattr(ArmRenderer, "picture", lambda *scene: np.zeros((2, 2, 3), np.uint8))
    shorten_tasks(monkeypatch, 0.5)


@pytest.mark.slow
def test_the_page_has_both_joints_and_all_motions(run):
    folder, modules = run
    assert "mujoco" in modules
    assert not {"torch", "stable_baselines3"} & set(modules)
    page = (folder / "report.html").read_text()
    names = [f"loops-{joint}" for joint in ("shoulder", "elbow")] + ["convergence"]
    names += [f"{x}-{y}" for x in ("trajectory", "torques", "motion-loops") for y in PLACES]
    for name in names:
        assert (folder / f"{name}.png").stat().st_size > 10_000
        assert (folder / f"{name}.svg").exists()
    assert page.count("<figure>") == len(names) + 1  # the arm
    assert "earth: The suit raises the wearer" in page
    assert len(page) < 3_000_000


@pytest.mark.slow
def test_numbers_are_there(run):
    folder, _ = run
    fits = json.loads((folder / "fits.json").read_text())
    for joint in ("shoulder", "elbow"):
        assert set(fits[joint]) == {"sa-pso", "mpso", "certified"}
        assert fits[joint]["certified"]["certificate"]["certified"]
        assert len(fits[joint]["mpso"]["prediction_max_error"]) == 2
    result = json.loads((folder / "result.json").read_text())
    scores = result["evaluation"]
    for gravity in PLACES:
        found = scores[gravity]["scores"]
        relief = {name: score["relief"]["value"] for name, score in found.items()}
        assert (relief["suited"], relief["unsuited"]) == pytest.approx((0, 1))
        assert relief["none"] < 0
        assert relief["none"] < relief["compensation"] < relief["best-known-plan"]
        if gravity == "microgravity":
            assert 0.1 < relief["feedforward"] < relief["compensation"]
        rows = (folder / f"motions-{gravity}.csv").read_text().splitlines()
        assert len(rows) == 1 + 7 * 8
    assert set(load_suit(str(folder / "suit.json")).joints) == set(load_suit("mock-suit").joints)
    rows = (folder / "traces-earth.csv").read_text().splitlines()
    assert len(rows) == 1 + 7 * 100
    assert result["seed"] == 0


@pytest.mark.slow
@pytest.mark.usefixtures("sketched")
def test_without_opengl_it_says_so_and_goes_on(tmp_path, monkeypatch, capsys):
    def unavailable(*scene):
        raise RenderingUnavailableError("no OpenGL context")

    monkeypatch.setattr(ArmRenderer, "picture", unavailable)
    demo(out=tmp_path, trials=1, motions=8)
    assert "no picture of the arm: no OpenGL context" in capsys.readouterr().out
    assert not (tmp_path / "arm.png").exists()


def interrupted(capsys, out, *more) -> str:
    """Runs a demo that must be interrupted; returns its last sentence."""
    given = ["demo", "--trials", 1, "--motions", 8, "--out", out, *more]
    message = fails(capsys, *given, shown=True)
    assert message.startswith("activesuit: interrupted: ")
    return message


def interrupting_call(monkeypatch, owner, name, number=1):
    """Makes the call with that number, from 1, raise KeyboardInterrupt."""
    real, calls = getattr(owner, name), []

    def interrupt(*arguments, **options):
        calls.append(name)
        if len(calls) == number:
            raise KeyboardInterrupt
        return real(*arguments, **options)

    monkeypatch.setattr(owner, name, interrupt)


@pytest.mark.parametrize(
    ("owner", "part", "call", "done"), [(demo_module, "fit_curves", 1, 0), (Bar, "advance", 2, 2)]
)
def test_interrupt_keeps_the_finished_fits(tmp_path, monkeypatch, capsys, owner, part, call, done):
    interrupting_call(monkeypatch, owner, part, call)
    message = interrupted(capsys, tmp_path)
    assert f"the finished fits ({done} of 6) are kept in {tmp_path}/fits.json" in message
    fits = json.loads((tmp_path / "fits.json").read_text())
    assert sum(map(len, fits.values())) == done
    if done:
        assert len((tmp_path / "trials.csv").read_text().splitlines()) == 1 + done


@pytest.mark.slow
@pytest.mark.parametrize("part", ["loops_plot", "evaluate", "motion_plots"])
@pytest.mark.usefixtures("sketched")
def test_interrupt_after_the_fits_says_how_to_go_on(tmp_path, monkeypatch, capsys, part):
    interrupting_call(monkeypatch, demo_module, part)
    message = interrupted(capsys, tmp_path, "--seed", "3")
    assert f"fits.json, trials.csv and suit.json are kept in {tmp_path}; go on with: " in message
    fits = json.loads((tmp_path / "fits.json").read_text())
    assert all(set(fits[joint]) == {"sa-pso", "mpso", "certified"} for joint in fits)
    assert not (tmp_path / "report.html").exists()
    command = message.split("go on with: activesuit ")[1]
    assert command == f"validate {tmp_path}/suit.json --plant mock-suit --motions 8 --seed 10003"
    main(command.split())  # what it says can be done
    assert "Torque, believed less true" in capsys.readouterr().out
