"""A robot on two wheels drives through a room and sees: the OpenRooms paper's navigation.

State: its 3-D position. Action: ways forward and backward, turns left and right. Observations: RGB,
normals, depth, semantics, and the state of its joints. The same actions again on a waxed floor.

Run: python examples/05_navigate.py OUT
"""

import sys
from pathlib import Path

from openrooms_usd import adapters, compose_room
from openrooms_usd.demo import copy_example
from openrooms_usd.geometry.pinhole import look_at
from openrooms_usd.simulation import strips
from openrooms_usd.simulation.driving import Action, act
from openrooms_usd.simulation.eyes import RGB, SEEN, Eyes, robot_camera
from openrooms_usd.simulation.floors import mean_friction, with_friction
from openrooms_usd.simulation.robots import rover, with_robot
from openrooms_usd.usd.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world

ACTIONS = (Action(forward=1.3), Action(left=1.9, forward=0.7), Action(right=0.8, backward=0.3))


def main(out: Path) -> None:
    scene = compose_room(copy_example(out / "source"), out).scene
    engine = adapters.load(adapters.ENGINES, "pybullet")
    world = with_robot(read_world(open_stage(scene)), rover((1.2, 1.2)))
    eyes = Eyes(scene, world)
    simulation = engine.open(world)
    first = {"robot": robot_camera(simulation, "rover")}
    look = eyes.see(simulation, first, ("semantic", "friction"))["robot"]
    floor = mean_friction(look, eyes.legend)
    print(f"friction of the floor, mean of its pixels: {floor:.3f}")
    rows = []
    for coefficient, watched in ((floor, True), (0.31, False)):
        simulation = engine.open(with_friction(world, "floor", coefficient))
        for number, action in enumerate(ACTIONS):
            act(simulation, "rover", action)
            pose = simulation.poses()["rover"]
            x, y, z = pose.world_from_body[:3, 3]
            wheels = ", ".join(f"{name} {angle:.2f} rad" for name, angle in pose.joints.items())
            print(f"floor {coefficient:.2f} step {number}: ({x:.3f}, {y:.3f}, {z:.3f})  {wheels}")
            if watched:
                cameras = {"robot": robot_camera(simulation, "rover"),
                           "onlooker": look_at((5.2, 0.4, 1.9), (1.9, 2.1, 0.2))}  # fmt: skip
                views = eyes.see(simulation, cameras)
                shown = {"onlooker": [RGB], "robot": SEEN}
                rows.append(strips.row(f"step {number}", views, shown))
        simulation.close()
    strips.write_strip(out / "strip.png", rows)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_05"))
