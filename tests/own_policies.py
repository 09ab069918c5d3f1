"""Policies of a user: honest ones, and ones that carry a motion into its next rollout.

The guided rollouts show the whole motion. Who still knows the motion when it is scored is ahead of
lag and noise. These policies carry it in a class, a module, a file, and in what forks share.
"""

import contextlib
import mmap
import os
import tempfile
from pathlib import Path
from typing import ClassVar

import numpy as np
from activesuit.envs.policies import Compensation, NoAssist
from scipy.ndimage import gaussian_filter1d

AHEAD = 1  # control periods by which the motors are late
NOTES = {}
FOLDER = Path(tempfile.gettempdir(), "activesuit-rehearsals")


class Push(NoAssist):
    """Pushes with a tenth of the peak torque."""

    command = -0.1

    def torque(self, seen):
        return super().torque(seen) + self.command * self.peak


class Lose(Push):
    """Loses the arm."""

    command = -1.0


class Practices(NoAssist):
    """Pushes more with each of its rollouts."""

    practice = 3

    def __init__(self, plant):
        super().__init__(plant)
        self.rollouts = 0

    def reset(self):
        super().reset()
        self.rollouts += 1

    def torque(self, seen):
        assert len(seen["angle"]) == 1
        return super().torque(seen) + 0.01 * self.rollouts * self.peak


class Ends(NoAssist):
    """Ends its process."""

    def torque(self, seen):
        os._exit(3)


class Honest(Compensation):
    """Compensation, which forgets."""


class ByClass(Compensation):
    """Knows the motion from a class attribute."""

    notes: ClassVar[dict] = {}

    def begin(self, seen):
        super().begin(seen)
        self.motion = "-".join(f"{one:.6f}" for one in seen["angle"][:, 1])
        self.known, self.seen = self.recalled(), []

    def torque(self, seen):
        self.seen.append(seen["angle"])
        self.note()
        if self.known is None:
            return super().torque(seen)
        now = min(len(self.seen) - 1 + AHEAD, len(self.known[0]) - 1)
        angle, rate = (one[now] for one in self.known)
        late = {**seen, "angle": angle - self.lead * rate, "rate": rate}
        return super().torque(late) + self.friction(rate[:, self.assisted]) / 4

    def recalled(self):
        return self.motions(self.notes.get(self.motion))

    def motions(self, noted):
        """Angles and rates of a motion, without the encoders' noise."""
        if noted is None or len(noted) < 50:
            return None
        angle = gaussian_filter1d(np.array(noted), 1.5, axis=0)
        return angle, np.gradient(angle, self.dt, axis=0)

    def note(self):
        self.notes[self.motion] = self.seen


class ByModule(ByClass):
    """Knows the motion from a global of this module."""

    @property
    def notes(self):
        return NOTES


class ByFile(ByClass):
    """Knows the motion from a file, which earlier rollouts wrote."""

    @property
    def path(self):
        return FOLDER / f"{self.motion[:200]}.bin"

    def recalled(self):
        rows = self.motion.count("-") + 1
        return (
            self.motions(np.fromfile(self.path).reshape(-1, rows, 4))
            if self.path.exists()
            else None
        )

    def note(self):
        with contextlib.suppress(OSError):
            FOLDER.mkdir(exist_ok=True)
            with self.path.open("wb" if len(self.seen) == 1 else "ab") as file:
                file.write(np.array(self.seen[-1], np.float64).tobytes())


class Leak(Honest):
    """Pushes where a rollout before has left a message."""

    def torque(self, seen):
        told = self.told()
        if seen["angle"].any():  # not where the policy only warms up
            self.tell()
        return super().torque(seen) + (5.0 if told else 0.0)


class ByOpenFile(Leak):
    """Leaves a message in a file that it opened when it was made."""

    def __init__(self, plant, belief=None):
        super().__init__(plant, belief)
        self.file = tempfile.TemporaryFile()

    def told(self):
        with contextlib.suppress(OSError):
            return os.fstat(self.file.fileno()).st_size > 0
        return False

    def tell(self):
        with contextlib.suppress(OSError):
            os.write(self.file.fileno(), b"!")


class ByPipe(Leak):
    """Leaves a message in a pipe that it opened when it was made."""

    def __init__(self, plant, belief=None):
        super().__init__(plant, belief)
        self.ends = os.pipe()
        os.set_blocking(self.ends[0], False)

    def told(self):
        with contextlib.suppress(OSError):
            return bool(os.read(self.ends[0], 1))
        return False

    def tell(self):
        with contextlib.suppress(OSError):
            os.write(self.ends[1], b"!")


class ByName(Leak):
    """Leaves a message as the name of a folder."""

    path = FOLDER / "told"

    def told(self):
        return self.path.exists()

    def tell(self):
        with contextlib.suppress(OSError):
            self.path.mkdir(parents=True, exist_ok=True)


class ByMemory(Leak):
    """Would leave a message in memory that forks share."""

    def __init__(self, plant, belief=None):
        super().__init__(plant, belief)
        self.memory = mmap.mmap(-1, 1)

    def told(self):
        return self.memory[0] > 0

    def tell(self):
        self.memory[0] = 1
