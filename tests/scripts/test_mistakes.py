"""Mistakes in options, a table a command: each is one sentence, and nothing changes on disk."""

import shlex
import shutil

import pytest
from activesuit.assets import FOLDER, curves_path
from helpers import content, fails
from trained_runs import make_run, write_card

FULL = "is not empty, it holds 'notes.txt': choose a new folder as --out, or add --force"
TRAINED = "trained with 'moon': leave --gravity out"
WAY = "time_s,angle_rad\n0,0.52\n5,{}\n"
WHOLE = (FOLDER / "suits" / "mock-suit.json").read_text(encoding="utf-8")
FILES = {  # of the folder in which the commands run, beside elbow.csv
    "text.csv": "curve,angle_rad,torque_nm\nA,0,0\nA,1,x\n",
    "cut.json": WHOLE[: len(WHOLE) // 2],
    "broken.json": "{",
    "empty": "",
    "still.csv": "angle_rad\n1\n1\n",
    "untimed.csv": "angle_rad\n0.52\n1\n",
    "way.csv": WAY.format(1.0),
    "quick.csv": WAY.format(1.0).replace("5,", "0.1,"),
    "wide.csv": WAY.format(3.0),
}

IDENTIFY = {
    "none.csv": "No such file",
    "text.csv": "line 3: torque_nm is 'x'",
    "other.csv --out out": "give --joint",
    "other.csv --for MinorLoops": "cannot tell which joint",
    "elbow.csv --trials 1000000000": "trials is 1000000000: use at most 10,000,000",
    "elbow.csv --out other": FULL,
    "elbow.csv --trials 0 --out new/out": "trials is 0",
    "elbow.csv --trials 0 --out bare": "trials is 0",
    "elbow.csv --trials x": "--trials",
    "elbow.csv --samples 1.5": "--samples",
    "elbow.csv --joint knee --out out": "unknown joint 'knee'",
    "elbow.csv --seed -1": "seed is -1",
    "elbow.csv --model preisach --method pso": "has the method 'certified'",
    "elbow.csv --objective sse": "objective is 'sse': method 'certified' always",
    "elbow.csv --base nope --out out": "unknown suit 'nope'",
    "elbow.csv --base mock-suit": "--base mock-suit needs --out",
    "elbow.csv --for Minorloops": "did you mean 'MinorLoops'",
    "elbow.csv --for MinorLoops --joint knee": "unknown joint 'knee'",
    "elbow.csv --for still.csv": "stays at the angle 1 rad",
    "elbow.csv --columns angle": "--columns has 'angle': give NAME=VALUE",
    "elbow.csv --columns angel=2": "unknown kind of column 'angel'",
    "elbow.csv --units angle=deg angle=rad": "--units has 'angle' twice",
    "elbow.csv --units torque=stone": "'stone' is no unit of torque",
    "elbow.csv --decimal ';'": "decimal is ';': give '.' or ','",
    "elbow.csv --rate viscous": "has no times",
    "elbow.csv --rate fast": "fast",
    "elbow.csv --average-cycles": "curve '0.87' has 2 branches",
}
EVALUATE = {
    "--policies run --gravity earth": TRAINED,
    "--policies none --motions 8 --out other": FULL,
    "--motions 1.5": "--motions",
    "--motions 1000000000": "motions is 1000000000: use at most",
    "--motions 7": "motions is 7: use at least 8",
    "--policies magic --out out": "unknown policy 'magic'",
    "--env ActiveSuit/Elbow-v0": "did you mean 'ActiveSuit/ElbowFlexion-v0'",
    "--env CartPole-v1": "'CartPole-v1' is no arm of ActiveSuit",
    "--env Nothing-v0": "unknown environment 'Nothing-v0'",
    "--gravity venus": "unknown gravity 'venus'",
    "--suit published-2022": "certificate margin is -0.245",
    "--seed -1": "seed is -1",
}
SIMULATE = {
    "--out out --policy run --gravity earth": TRAINED,
    "--out other": FULL,
    "--out out --policy magic": "unknown policy",
    "--out out --suit cut.json": "not complete JSON",
    "--out out --seed -1": "seed is -1",
    "--task Hamer": "unknown task 'Hamer'",
    "--task none.csv": "cannot read the motion 'none.csv'",
    "--level hard": "unknown level 'hard'",
    "--wearer.stature 3": "stature is 3.0: use a number from 1.4 to 2.1 m",
    "--sensing.rate-cutoff -1": "sensing.rate_cutoff is -1",
    "--max-episode-steps 0": "max_episode_steps is 0",
    "--gravity weightless": "write 'microgravity' instead",
    "--fatigue much": "fatigue is 'much'",
    "--tilt 1": "--tilt",
    "--motions 8": "unknown option --motions",
    "--set fatigue=true": "write --NAME VALUE for each",
    "--sex=female": "write --wearer.sex",
    "--task Hammer --env ActiveSuit/Hammer-v0": "--task is 'Hammer', and --env is",
}
VALIDATE = {
    "": "no suit is given",
    "cut.json": "not complete JSON",
    "mock-suit --plant mock-suit --out other": FULL,
    "emu-like --plant mock-suit --motions 7": "motions is 7: use at least 8",
    "emu-like --plant emu-like --policy compensation:suit=mock-suit": "the option suit: leave the",
    "mock-suit --plant nope": "unknown suit 'nope'",
    "mock-suit --samples --held-out elbow.csv": "leave one out",
    "mock-suit --samples": "'mock-suit' has no samples: identify",
    "mock-suit --plant mock-suit --policy magic": "unknown policy 'magic'",
    "emu-like --plant mock-suit --joint elbow_flexion": "add --held",
    "mock-suit --held-out other.csv": "give --joint",
}
RIG = {
    "--out other": FULL,
    "--noise x": "--noise",
    "--turns 3.0": "turn is 3 rad: give an angle in the range of elbow_flexion",
    "--rate 0": "rate is 0.0: use a number from 0.01 to 0.5 rad/s",
    "--joint knee": "unknown joint of suit 'mock-suit' 'knee'",
    "--suit nope": "unknown suit 'nope'",
    "--predict 1.1": "predict has 1.1 rad: give some of the turns, 0.87, 1.05",
    "--turns 1.0 --predict 1.0": "predict has all turns",
    "--out empty/out": "choose another --out",
    "--motion empty": "is empty: give a header 'time_s,angle_rad'",
    "--motion none.csv": "cannot read the motion 'none.csv'",
    "--motion untimed.csv": "has no column time_s: add it",
    "--motion way.csv --predict 1.0": "--predict belongs to first-order curves",
    "--motion way.csv --turns 1.0": "turns is (1.0,) beside a motion",
    "--motion quick.csv": "at 4.8 rad/s: give 0.01 to 0.5 rad/s",
    "--motion wide.csv": "3 rad: give an angle in the range of elbow_flexion",
}
DESIGN = {
    "": "give a file of curves, or --range LOW HIGH in rad, and not both",
    "none.csv": "cannot read the curves 'none.csv'",
    "elbow.csv --range 0 1": "and not both",
    "--range 0 x": "--range",
    "--range 1 0": "--range is 1 to 0 rad: give the smaller angle first",
    "--range 0 1 --max-rate 0.01": "min_rate is 0.02 and max_rate 0.01 rad/s",
    "--range 0 1 --out empty": "--force",
}
SUITS = {"nope": "unknown suit 'nope'", "emulike": "did you mean 'emu-like'"}
VIEW = {
    "--policy run --gravity earth": TRAINED,
    "": "no window can be opened here: use --snapshot FILE.png for a picture, or --film FILE.gif",
    "--snapshot arm.jpg": "snapshot is 'arm.jpg': use a name that ends with .png",
    "--snapshot arm.png --film arm.gif": "--film and --snapshot are given: use one of them",
    "--snapshot arm.png --draw muscles": "draw and snapshot are given",
    "--snapshot arm.png --size 0 960": "size has 0: use even numbers of pixels from 120 to 4096",
    "--snapshot no/arm.png": "cannot write 'no/arm.png'",
    "--film arm.avi": "film is 'arm.avi': use a name that ends with .gif or .mp4",
    "--film no/arm.gif": "cannot write 'no/arm.gif'",
    "--film arm.gif --size 960 541": "size has 541: use even numbers of pixels from 120 to 1920",
    "--film arm.gif --env Ant-v5": "no arm of ActiveSuit",
    "--gravity sun": "unknown gravity 'sun'",
    "--snapshot arm.png --quality best": "unknown render_quality 'best'",
    "--coupling glue": "unknown coupling 'glue'",
    "--policy magic": "unknown policy 'magic'",
    "--seed -1": "seed is -1: use at least 0",
}
BENCHMARK = {
    "run x.jsonl": "run takes no results",
    "run --suite huge": "unknown suite 'huge'",
    "run --policies compensation:leed=1": "did you mean 'lead'",
    "run --suit none --out out": "the suite sets the option suit",
    "run --reward mine:reward --out out": "the suite sets the option reward",
    "table": "there are no results",
    "table nowhere": "cannot read the results",
}
C_CODE = {
    "nosuch": "unknown suit 'nosuch'",
    "mock-suit --joint knee": "unknown joint of this suit 'knee': use one of elbow_flexion",
    "mock-suit --payload 3": "--payload is {'mass': 3.0}, and a suit has none",
    "mock-suit --out 3.h": "begin the name with a letter",
    "published-2022": "--allow-uncertified",
    "adaptive": "cannot be exported as C code: use one of transparent, gravity",
    "none": "cannot be exported as C code",
    "run": "cannot be exported as C code",
    "compensation:guard=true": "cannot be exported as C code",
    "compensation --joint elbow_flexion": "--joint is 'elbow_flexion', and a policy has none",
    "compensation:suit=nosuch": "unknown suit",
    "compensation:leed=1": "unknown option",
    "compensation --coupling none": "needs motors, and coupling is 'none'",
    "broken.json": "broken.json",
}
ONNX = {
    "": "required",
    "run --c": "two formats are given: add either --onnx",
    "run --payload 2": "--payload is {'mass': 2.0}, and an ONNX model has none: leave it out",
    "run --joint elbow_flexion": "--joint is 'elbow_flexion', and an ONNX model has none",
    "nosuch": "has no readable policy.json",
    "compensation": "the policy 'compensation' is no network: give the folder of a training run",
    "run --out empty": "exists: give another name, or add --force",
    "run --out other": "is a folder: give the name",
}
TRAIN = {
    "--residual compensator": "unknown policy 'compensator'",
    "--residual activesuit.envs.policies:NoAssist": "unknown policy that a network",
    "--residual compensation --residual-scale 5": "residual scale is 5",
    "--residual-scale 0.1": "given without --residual",
    "--reward nothing": "the reward 'nothing' cannot be imported",
    "--reward own_rewards:nothing": "cannot be imported (AttributeError",
    "--belief.suit nothing": "unknown suit 'nothing'",
    "--randomize.suit samples": "make a suit file with `activesuit identify --samples`",
    "--motions 3": "motions is 3",
    "--patience 0": "patience is 0",
    "--seeds 4-2": "the lowest of each part first",
    f"--seeds {'9' * 5000}": "give whole numbers, as 0-9 or 0,3,5",
    "--seeds 1 --seed 1": "--seed and --seeds are given: give one of them",
    "--teacher compensation --residual none": "leave --residual out",
    "--teacher compensation --patience 2": "leave --patience out",
    "--teacher compensation --hyperparameters x.yml": "leave --hyperparameters out",
    "--teacher compensation --resume": "no model.zip to resume",
    "--teacher compensation --normalize": "leave --normalize out",
    "--resume": "no model.zip to resume",
    "--algo dqn": "unknown algo 'dqn'",
    "--trust": "--trust is given without --resume",
    "--torch-threads 0": "torch-threads is 0",
    "--steps 0": "steps is 0",
    "--seed -1": "seed is -1",
    "--seed 4294967296": "seed is 4294967296: use at most 4,294,967,295",
    "--rows 0": "rows is 0",
    "--hyperparameters x.yml": "cannot read the hyperparameters 'x.yml'",
    "--task Knitting": "unknown task 'Knitting'",
    "--sensors eyes": "unknown",
    "--out run": "holds a trained run: add --resume",
    "--steps 1 --out other": FULL,
}
BEGUN = {  # what shows when the arms act, after the folder of the training is made
    "--residual adaptive --sensors encoders": "needs the sensors encoders, inter",
    "--residual compensation --normalize": "normalize=True: use normalize=False",
    "--reward own_rewards:nan": "is nan in row 0 of",
    "--reward own_rewards:scalar": "has the shape ()",
    "--reward own_rewards:failing": "fails (KeyError",
}
RESUME = {  # of the run in run/, whose network has learned nothing
    "--seed 5": "has --seed 5, and the run",
    "--algo sac": "has --algo 'sac', and the run",
    "--rows 9": "has --rows 9, and the run",
    "--level shift": "has --level 'shift', and the run",
    "--sensors emg": "has --sensors ['emg'], and the run",
    "--teacher adaptive": "has --teacher 'adaptive', and the run",
    "--residual compensation": "was trained without: leave --residual out",
    "--hyperparameters x.yml": "cannot read the hyperparameters 'x.yml'",
    "--gravity earth": "was trained with 'moon': leave --gravity out",
    "--steps 0": "steps is 0",
}
MISTAKES = {
    "identify": IDENTIFY,
    "evaluate": EVALUATE,
    "simulate": SIMULATE,
    "validate": VALIDATE,
    "rig --out out": RIG,
    "design": DESIGN,
    "list suits": SUITS,
    "view": VIEW,
    "benchmark": BENCHMARK,
    "export --c": C_CODE,
    "export --onnx": ONNX,
    "train --task ArmTracking --gravity microgravity --out new": TRAIN,
    "train --resume --trust --out run": RESUME,
    "export run": {"": "no format is given: add either --onnx"},
    "demo --out out": {
        "--motions 7": "motions is 7: use at least 8",
        "--out other": FULL,
        "--trials 0": "trials is 0",
        "--seed -5": "seed is -5",
    },
    "list tasks": {"Hamer": "did you mean 'Hammer'"},
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The working folder of the commands, with the files that they read."""
    monkeypatch.chdir(tmp_path)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    for name in ("bare", "other"):
        (tmp_path / name).mkdir()
    (tmp_path / "other" / "notes.txt").write_text("mine")
    for name in ("elbow.csv", "other.csv"):
        shutil.copy(curves_path("elbow"), tmp_path / name)
    return tmp_path


@pytest.mark.parametrize("command", MISTAKES)
def test_a_mistake_is_one_sentence_and_changes_nothing(capsys, folder, command):
    if command.startswith(("train", "export")):
        pytest.importorskip("stable_baselines3")
        make_run(folder / "run")
    else:
        (folder / "run").mkdir()
        write_card(folder / "run")
    before = content(folder)
    for given, message in MISTAKES[command].items():
        said = fails(capsys, *shlex.split(f"{command} {given}"))
        assert message in said, given
        assert content(folder) == before, given


def test_a_mistake_that_the_arms_show_is_one_sentence(capsys, folder):
    pytest.importorskip("stable_baselines3")
    for given, message in BEGUN.items():
        command = f"train --task ArmTracking --gravity microgravity --out new {given}"
        assert message in fails(capsys, *shlex.split(command)), given
