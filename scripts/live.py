"""The panel of the live viewer: loops and torques of the moving arm, and what may be changed."""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ..assets import JOINTS
from ..envs.model import ASSISTED
from ..envs.rendering import Capsule

TAIL, NEW = 600, 100  # control periods that the panel shows, and those of the thick end
EVERY = 2  # control periods from one drawn point to the next


class Sample(NamedTuple):
    """One control period [s] of the assisted joints: angles [rad] and torques [N·m], (m,) each."""

    time: float
    angle: Sequence[float]
    suit: Sequence[float]
    human: Sequence[float]
    motor: Sequence[float]


@dataclass
class Live:
    """What the simulation and the panel share, which run in two threads.

    Attributes:
        choices: Names that may be chosen, by what they are: policy, task, suit, place.
        chosen: Name that is chosen of each; the panel writes it, and the simulation takes back what
            cannot be.
        paused: Whether the motion waits; the panel writes it.
        restarted: Number of times that a new motion was asked for; the panel writes it.
        status: One line about the motion; the simulation writes it.
        note: Why a choice was taken back, as a sentence; the simulation writes it.
        samples: The last control periods; the simulation writes them.
        beside: What is drawn beside the arm; the simulation writes a new list each time.
    """

    choices: Mapping[str, list[str]]
    chosen: dict[str, str]
    paused: bool = False
    restarted: int = 0
    status: str = ""
    note: str = ""
    samples: deque[Sample] = field(default_factory=lambda: deque(maxlen=TAIL))
    beside: Sequence[Capsule] = ()

    def measure(self, info: Mapping[str, Any]) -> None:
        """Keeps what a control period has measured."""
        at = [JOINTS.index(joint) for joint in ASSISTED]
        self.samples.append(
            Sample(
                float(info["time"]),
                info["angle"][at].tolist(),
                (-info["suit_torque"][at]).tolist(),
                info["human_torque"][at].tolist(),
                info["assist_torque"].tolist(),
            )
        )


def panel(live: Live) -> Any:
    """Returns a plugin of MuJoCo Studio that draws the panel, and what is beside the arm."""
    import mujoco
    from mujoco.studio import messages, plugin
    from mujoco.studio.dear_imgui import dear_imgui as imgui
    from mujoco.studio.implot import implot

    first = int(imgui.Cond.FirstUseEver)
    fit = int(implot.AxisFlags.AutoFit)

    class Panel(plugin.ViewerPlugin):
        @messages.handler
        def on_update(self, _: messages.UpdateEvent) -> None:
            self.viewer.extra_geoms[:] = [one.into(mujoco.MjvGeom()) for one in live.beside]

        @messages.handler
        def on_build_gui(self, _: messages.BuildGuiEvent) -> None:
            imgui.SetNextWindowPos(imgui.Vec2(8, 30), first)
            imgui.SetNextWindowSize(imgui.Vec2(430, 690), first)
            if imgui.Begin("ActiveSuit"):
                self._controls()
                self._plots([*live.samples])
            imgui.End()

        def _controls(self) -> None:
            imgui.TextWrapped(f"{live.status}\n{live.note}" if live.note else live.status)
            for kind, names in live.choices.items():
                chosen = live.chosen[kind]
                now = names.index(chosen) if chosen in names else 0  # the arm is being replaced
                changed, at = imgui.Combo(kind, now, names)
                if changed:
                    live.chosen[kind] = names[at]
            if imgui.Button("go on" if live.paused else "pause"):
                live.paused = not live.paused
            imgui.SameLine()
            if imgui.Button("next motion"):
                live.restarted += 1

        def _plots(self, samples: list[Sample]) -> None:
            if len(samples) < 2:
                return
            time = [one.time for one in samples][::EVERY]
            for i, joint in enumerate(ASSISTED):
                name = joint.removesuffix("_flexion")
                if self._begins(f"{name}: suit torque over angle", "angle [rad]", 170):
                    angle = [one.angle[i] for one in samples]
                    torque = [one.suit[i] for one in samples]
                    implot.PlotLine("loop", angle[::EVERY], torque[::EVERY])
                    implot.PlotLine("last second", angle[-NEW:], torque[-NEW:])
                    implot.PlotScatter("now", angle[-1:], torque[-1:])
                    implot.EndPlot()
                if self._begins(f"{name}: torques", "time [s]", 140):
                    for kind in ("suit", "human", "motor"):
                        values = [getattr(one, kind)[i] for one in samples]
                        implot.PlotLine(kind, time, values[::EVERY])
                    implot.EndPlot()

        def _begins(self, title: str, across: str, height: float) -> bool:
            """Begins a plot, unless it is out of sight; its legend stands to the right."""
            if not implot.BeginPlot(title, imgui.Vec2(-1, height), int(implot.Flags.NoTitle)):
                return False
            implot.SetupAxes(f"{title.partition(':')[0]} {across}", "[N·m]", fit, fit)
            outside = int(implot.LegendFlags.Outside)
            implot.SetupLegend(int(implot.Location.East), outside)
            return True

    return Panel()
