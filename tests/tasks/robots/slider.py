"""The smallest robot: a ball on a rail, beside a ball that falls."""

import numpy as np

from tiloilc.tasks import Circle, Expert, Scene
from tiloilc.tasks.robots.base import Doubles, Field, RobotEnv
from tiloilc.tasks.robots.camera import View

MODEL = """
<mujoco>
  <worldbody>
    <light pos="0 0 3"/>
    <geom type="plane" size="2 2 0.1" rgba="0.9 0.9 0.9 1"/>
    <body pos="0 0 0.2"><joint name="x" type="slide" axis="1 0 0" damping="0.1"/>
      <geom size="0.1" rgba="0.1 0.2 0.9 1"/></body>
    <body pos="0.5 0.5 0.5"><freejoint/><geom size="0.1" rgba="0.9 0.1 0.1 1"/></body>
  </worldbody>
  <actuator><motor joint="x"/></actuator>
</mujoco>
"""


class SliderEnv(RobotEnv):
    def __init__(self, render_mode: str | None = None) -> None:
        import mujoco  # after the package, which says how it is to draw

        super().__init__(
            mujoco.MjModel.from_xml_string(MODEL),
            substeps=5,
            fields=(Field("pos", 3, (-1, -1, 0), (1, 1, 2)), Field("vx", 1, -2, 2)),
            actions=1,
            view=View((0, 0, 0.2), 3.0, 90, -30),
            render_mode=render_mode,
        )

    def scene(self) -> Scene:
        return Scene((-1, -1, 1, 1), (Circle("a", "#ff0000", (0.5, 0.0), 0.2),))

    def experts(self) -> tuple[Expert, ...]:
        return ()

    def _start(self) -> None:
        self.data.qpos[0] = self.np_random.uniform(-0.5, 0.5)

    def _act(self, action: Doubles) -> None:
        self.data.ctrl[:] = action

    def _observe(self) -> Doubles:
        return np.concatenate([self.data.xpos[1], self.data.qvel[:1]])
