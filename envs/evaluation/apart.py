"""Policies of strangers in processes of their own, which end with the rollout.

One process, the home, makes the policy and lets it practice, and never sees a motion that is
scored. For each motion of each rollout the home forks: the copy of the home acts in this motion
alone, and ends. So a copy knows neither another motion nor an earlier rollout of its own motion, by
whatever object, class or module. Nor may a copy leave a message: the kernel refuses what it writes
into files, and Python refuses to begin files, processes and connections.
"""

import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import cloudpickle
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ..plant import Plant
from ..policies import Policy
from ..policies.guard import Guard
from .rollout import NO_GUARD

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # a fork keeps one thread
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_TRUNC
REFUSED = ("os.", "socket.", "subprocess.", "shutil.", "tempfile.", "mmap.", "sqlite3.", "fcntl.")
ALLOWED = ("os.listdir", "os.scandir", "os.walk", "os.fwalk", "os.putenv", "os.unsetenv")


class Apart:
    """A policy whose every rollout runs in new processes, one for each motion.

    Attributes:
        practice: Number of rollouts, on other motions, in which the policy learns first.
        acted: Number of control periods in which a guard reduced a torque, shape (rows,).
    """

    def __init__(self, name: str, make: Callable[[Plant], Policy], plant: Plant) -> None:
        if not hasattr(os, "fork"):
            raise InputError(
                f"policy {name!r} is your own and needs processes that fork, which this system "
                "lacks: use Linux or macOS (on Windows: WSL)"
            )
        self._name, self.acted, self.practice = name, NO_GUARD, 0
        try:
            sent = cloudpickle.dumps((make, plant))
        except Exception as error:  # any object of the user
            raise InputError(
                f"policy {name!r} cannot be sent to a process of its own "
                f"({type(error).__name__}: {error}): give its class, or a function that makes it "
                "from plain values and files"
            ) from error
        ours, theirs = socket.socketpair()
        code = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import serve; serve()"
        self._process = subprocess.Popen(
            [sys.executable, "-c", code, str(theirs.fileno())],
            pass_fds=[theirs.fileno()],
            env={**os.environ, **dict.fromkeys(THREADS, "1")},
        )
        theirs.close()
        self._home, self._copies = Connection(ours.detach()), list[Connection]()
        self._home.send_bytes(sent)
        self._left = self.practice = self._received(self._home)

    def reset(self) -> None:
        """Ends the processes of the rollout before."""
        for copy in self._copies:
            copy.close()
        self._copies, self._begins = [], True

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the actions of all rows, shape (rows, motors), each from its own process.

        In practice the home acts in the first row, and the other rows rest.
        """
        if self._begins:
            self._begin(len(observation))
        practicing = not self._copies
        for copy, row in zip(self._copies or [self._home], observation[:, None], strict=False):
            copy.send(row)
        found = [self._received(copy) for copy in self._copies or [self._home]]
        action = np.concatenate([one for one, _ in found])
        self.acted = np.concatenate([acted for _, acted in found])
        if practicing:
            rest = np.zeros((len(observation) - 1, action.shape[1]))
            action, self.acted = np.concatenate([action, rest]), NO_GUARD
        return action

    def _begin(self, rows: int) -> None:
        """Begins a rollout: in the home while it practices, else in new processes."""
        from multiprocessing.reduction import recv_handle  # not on Windows

        self._begins = False
        if self._left:
            self._left -= 1
            self._home.send(None)
            self._received(self._home)
            return
        self._home.send(rows)
        for _ in range(rows):
            self._received(self._home)
            self._copies.append(Connection(recv_handle(self._home)))
        for copy in self._copies:
            copy.send(None)
        for copy in self._copies:
            self._received(copy)

    def _received(self, sender: Connection) -> Any:
        """Returns the answer of a process; raises the error that the process reports."""
        try:
            fine, answer = sender.recv()
        except (EOFError, OSError) as error:
            raise InputError(
                f"the process of policy {self._name!r} ended before its rollout: repair the policy"
            ) from error
        if not fine:
            raise InputError(answer)
        return answer

    def close(self) -> None:
        """Ends all processes of the policy."""
        self.reset()
        self._home.close()
        self._process.wait()


def serve() -> None:
    """Makes a policy, and forks for each motion; this is the program of the home."""
    from multiprocessing.reduction import send_handle

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the evaluation ends its processes
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for a copy
    evaluation = Connection(int(sys.argv[1]))
    sys.argv[1:] = []
    sys.addaudithook(_refuse_shared_memory)
    try:
        make, plant = cloudpickle.loads(evaluation.recv_bytes())
        policy = make(plant)
    except InputError as error:
        evaluation.send((False, str(error)))
        return
    except BaseException as error:  # the user's module may do anything
        said = f"a policy cannot be made in a process of its own ({type(error).__name__}: {error})"
        evaluation.send((False, f"{said}: repair it, or put its module into the working folder"))
        return
    _warm(make, plant)
    evaluation.send((True, int(getattr(policy, "practice", 0))))
    with contextlib.suppress(EOFError, OSError):
        while True:
            given = evaluation.recv()
            if not isinstance(given, int):
                evaluation.send(_answer(policy, given))
                continue
            for _ in range(given):
                ours, theirs = socket.socketpair()
                if os.fork() == 0:
                    _act(policy, ours.detach())
                ours.close()
                evaluation.send((True, None))
                send_handle(evaluation, theirs.fileno(), os.getppid())
                theirs.close()


def _warm(make: Callable[[Plant], Policy], plant: Plant) -> None:
    """Lets another policy act once on zeros, so that its kernels compile before the forks."""
    with contextlib.suppress(BaseException):  # what fails here fails in the rollout, too
        policy = make(plant)
        policy.reset()
        policy.act(np.zeros((1, *plant.observation_space.shape), np.float32))


def _act(policy: Policy, channel: int) -> None:
    """Acts in one motion until the evaluation ends it, and leaves no message."""
    import resource  # not on Windows

    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nothing, stream)
    for one in map(int, os.listdir("/dev/fd")):
        if one > 2 and one != channel:
            with contextlib.suppress(OSError):  # the folder's own
                os.close(one)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    sys.addaudithook(_refuse_messages)
    evaluation = Connection(channel)
    with contextlib.suppress(BaseException):
        while True:
            evaluation.send(_answer(policy, evaluation.recv()))
    os._exit(0)


def _answer(policy: Policy, observation: NDArray[np.float32] | None) -> tuple[bool, Any]:
    """Returns whether the policy could act, and its action, or the sentence of an error."""
    try:
        if observation is None:
            return True, policy.reset()
        action = policy.act(observation)
        return True, (action, policy.acted if isinstance(policy, Guard) else NO_GUARD)
    except InputError as error:
        return False, str(error)


def _refuse_shared_memory(event: str, given: tuple[Any, ...]) -> None:
    """Refuses memory that forks would share, before the policy is made."""
    if event == "mmap.__new__" and given[2] != 1:  # mmap.ACCESS_READ
        raise PermissionError("a policy that is scored may map files for reading alone")


def _refuse_messages(event: str, given: tuple[Any, ...]) -> None:
    """Refuses what could reach a later rollout: files, processes and connections."""
    opened = event == "open" and isinstance(given[2], int) and given[2] & WRITING
    if opened or (event.startswith(REFUSED) and event not in ALLOWED):
        raise PermissionError(
            f"a policy that is scored may write no file and start no process or connection in a "
            f"rollout, and it asks for {event}"
        )
