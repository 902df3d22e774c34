"""Doggo: a quadruped of twelve joints on the plane (paper, appendix H.1.2; Safety Gym)."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import as_file, files
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from tiloilc.tasks.experts import Expert, Waypoint
from tiloilc.tasks.known import Known, played
from tiloilc.tasks.robots.base import Doubles, Field, RobotEnv
from tiloilc.tasks.robots.camera import View
from tiloilc.tasks.robots.trot import Trot, TrotExpert, shipped_trot
from tiloilc.tasks.scene import Circle, Rectangle, Scene

SUBSTEPS = 10
"""Of 0.01 s each in one step, as in Safety Gym."""

LEGS = (1, 2, 3, 4)
"""Front left, rear left, rear right, front right."""

JOINTS = tuple(f"{kind}_{leg}{axis}" for kind, axis in (("hip", "_z"), ("hip", "_y"), ("ankle", ""))
               for leg in LEGS)  # fmt: skip
"""The joints that have motors, in the order of the motors. The waist, which has none, is unseen."""

FAR = 8.0
"""Metres from the origin beyond which the observed position does not grow: a task's zones are
nearer, and whoever is so far away has nothing more to find."""

FIELDS = (
    Field("accelerometer", 3, -50.0, 50.0),
    Field("velocimeter", 3, -2.0, 2.0),
    Field("gyro", 3, -20.0, 20.0),
    Field("magnetometer", 3, -0.5, 0.5),
    Field("touch", 8, 0.0, 2.0),
    Field("joint_velocity", 12, -40.0, 40.0),
    Field("joint_sine", 12, -1.0, 1.0),
    Field("joint_cosine", 12, -1.0, 1.0),
    Field("position", 2, -FAR, FAR),
    Field("height", 1, -0.5, 0.5),
    Field("orientation", 4, -1.0, 1.0),
    Field("center_of_mass", 3, (-FAR, -FAR, -0.5), (FAR, FAR, 0.5)),
)

LENGTH = 4.0
HALF_WIDTH = 0.8
BACK = 0.5
"""The corridor of Doggo Avoid: |y| ≤ HALF_WIDTH and x ≥ -BACK, in metres; it is done at LENGTH."""

FIRST = Circle("a", "#d9534f", (1.6, 0.6), 0.5)
SECOND = Circle("b", "#4caf6d", (2.8, -1.0), 0.5)
"""The discs of Doggo Navigate: 1.7 m from the start, and 2 m from there to the right."""

YAW = 0.1
BEND = 0.05
"""How far heading and joints at the start are from straight ahead and from rest, at most, rad."""


END = Waypoint((LENGTH + 1.0, 0.0), 0.9)
ROUTE = tuple(Waypoint(disc.center, 0.35) for disc in (FIRST, SECOND))
"""What experts head for: well inside the zones."""

STARTS = 8
"""Episodes that tell the best that is known."""

FLOOR = (0.8, 0.8, 0.78, 1.0)
LIGHT = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
TRUNK = ("accelerometer", "velocimeter", "gyro", "magnetometer")

CORRIDOR = Scene(
    (-1.5, -2.0, FAR, 2.0),
    (
        Rectangle("z", "#5b8fd6", (-1.5, HALF_WIDTH), (FAR, 2.0)),
        Rectangle("z", "#5b8fd6", (-1.5, -2.0), (FAR, -HALF_WIDTH)),
        Rectangle("z", "#5b8fd6", (-1.5, -HALF_WIDTH), (-BACK, HALF_WIDTH)),
        Rectangle("a", "#4caf6d", (LENGTH, -HALF_WIDTH), (FAR, HALF_WIDTH)),
    ),
    position=(56, 57),
)

DISCS = Scene((-1.0, -2.0, 4.0, 2.0), (FIRST, SECOND), position=(56, 57))


class DoggoEnv(RobotEnv):
    """Doggo on a plane, facing along x from the origin; what is around it, a task says.

    Twelve motors in [-1, 1], 0.1 s a step. The observation, float32 [66]:

    accelerometer 3 (m/s²), velocimeter 3 (m/s), gyro 3 (rad/s), magnetometer 3
                       of the trunk, in its own axes
    touch 8            force at the knees and feet of the four legs, N
    joint_velocity 12  rad/s, of JOINTS
    joint_sine 12, joint_cosine 12
    position 2, height 1 (m), orientation 4 (quaternion w, x, y, z)
                       the trunk's free joint
    center_of_mass 3   m

    Each is kept within its bounds in FIELDS; places up to FAR. At the start the heading is up to
    YAW and each joint up to BEND off, drawn evenly. The joint of the waist, which no motor moves,
    is not observed, as in Safety Gym.
    """

    def __init__(self, scene: Scene, render_mode: str | None) -> None:
        super().__init__(
            _model(scene),
            substeps=SUBSTEPS,
            fields=FIELDS,
            actions=len(JOINTS),
            view=View((0.0, 0.0, 0.1), 4.0, 90.0, -45.0),
            render_mode=render_mode,
        )
        self.metadata = {**self.metadata, "render_fps": round(1 / self.step_seconds)}
        self._scene = scene
        sensors = [f"touch_ankle_{leg}{end}" for leg in LEGS for end in "ab"]
        sensors += [f"jointvel_{joint}" for joint in JOINTS]
        self._sensed = _places(self.model, [*TRUNK, *sensors])
        self._mass = _places(self.model, ["subtreecom"])
        self._angles = [int(self.model.joint(joint).qposadr[0]) for joint in JOINTS]

    def scene(self) -> Scene:
        """The zones from above."""
        return self._scene

    def walker(self, name: str, trot: Trot, *route: Waypoint) -> TrotExpert:
        """What trots along `route` here."""
        position, orientation = (self.observation_fields[f] for f in ("position", "orientation"))
        assert isinstance(position, slice)
        assert isinstance(orientation, slice)
        return TrotExpert(name, trot, route, position, orientation, self.step_seconds)

    def _known(self, expert: TrotExpert, horizon: int) -> tuple[Known, ...]:
        expert = replace(expert, noise=0.0, dwell=None)
        how = (
            f"a trot, then standing still, the mean of {STARTS} starts: a lower bound, by "
            "real actions; from above no bound is known but the number of steps"
        )
        return (played(type(self)(), expert, horizon, STARTS, how),)  # type: ignore[call-arg]

    def _start(self) -> None:
        self.data.qpos[7:] += self.np_random.uniform(-BEND, BEND, self.model.nq - 7)
        half = self.np_random.uniform(-YAW, YAW) / 2
        self.data.qpos[3:7] = np.cos(half), 0.0, 0.0, np.sin(half)

    def _act(self, action: Doubles) -> None:
        self.data.ctrl[:] = action

    def _settle(self) -> None:
        mujoco.mj_forward(self.model, self.data)  # else sensors are of the last substep but one

    def _observe(self) -> Doubles:
        position, sensed = self.data.qpos, self.data.sensordata
        angles = position[self._angles]
        seen = (sensed[self._sensed], np.sin(angles), np.cos(angles), position[:7])
        return np.concatenate((*seen, sensed[self._mass]))

    def _look_at(self) -> tuple[float, float, float]:
        x, y = self.data.qpos[:2]
        return float(x), float(y), 0.1


class DoggoAvoidEnv(DoggoEnv):
    """A corridor along x to be walked through: |y| ≤ 0.8 m, from x = -0.5 m; it ends at x = 4 m.

    The paper does not give its size. There are no walls: to be outside is the violation.
    """

    def __init__(self, render_mode: str | None = None) -> None:
        super().__init__(CORRIDOR, render_mode)

    def experts(self) -> tuple[Expert, ...]:
        """One that trots along the middle and stands still at the end."""
        return (self.walker("avoid", shipped_trot(), END),)

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """What the fastest gait there is comes to without noise."""
        return self._known(self.walker("avoid", shipped_trot(), END), horizon)


class DoggoNavigateEnv(DoggoEnv):
    """Two discs of radius 0.5 m to be visited one after the other; the paper does not say where."""

    def __init__(self, render_mode: str | None = None) -> None:
        super().__init__(DISCS, render_mode)

    def experts(self) -> tuple[Expert, ...]:
        """One that trots from disc to disc and stands still in the second."""
        return (self.walker("navigate", shipped_trot(), *ROUTE),)

    def known_best(self, horizon: int) -> tuple[Known, ...]:
        """What the expert comes to without noise."""
        return self._known(self.walker("navigate", shipped_trot(), *ROUTE), horizon)


def _places(model: Any, sensors: list[str]) -> npt.NDArray[np.int64]:
    """Where the numbers of sensors stand in MuJoCo's `sensordata`."""
    adr, dim = model.sensor_adr, model.sensor_dim
    numbers = [model.sensor(name).id for name in sensors]
    return np.concatenate([np.arange(adr[i], adr[i] + dim[i]) for i in numbers]).astype(np.int64)


def _model(scene: Scene) -> Any:
    """Safety Gym's robot, and the scene's zones painted on the floor, which nothing touches."""
    with as_file(files("tiloilc.tasks.robots") / "assets" / "doggo.xml") as path:
        spec = mujoco.MjSpec.from_file(str(path))
    floor = spec.geom("floor")
    floor.rgba, floor.size = FLOOR, (0.0, 0.0, 1.0)  # drawn as far as one can see
    spec.worldbody.add_light(pos=(0, 0, 5), dir=(0, 0, -1), type=LIGHT, diffuse=(0.6, 0.6, 0.6))
    for layer, shape in enumerate(scene.shapes):
        thickness = 0.001 * (layer + 1)
        if isinstance(shape, Circle):
            kind, (x, y) = mujoco.mjtGeom.mjGEOM_CYLINDER, shape.center
            size = (shape.radius, thickness, 0.0)
        else:
            assert isinstance(shape, Rectangle), "Doggo's zones are discs and rectangles"
            kind, (x, y) = mujoco.mjtGeom.mjGEOM_BOX, np.add(shape.low, shape.high) / 2
            size = (*(np.subtract(shape.high, shape.low) / 2), thickness)
        spec.worldbody.add_geom(
            type=kind, pos=[x, y, 0.0], size=size, contype=0, conaffinity=0,
            rgba=[int(shape.color[i : i + 2], 16) / 255 for i in (1, 3, 5)] + [1.0],
        )  # fmt: skip
    return spec.compile()
