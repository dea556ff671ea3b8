"""A robot on two wheels drives through a room and sees: the OpenRooms paper's navigation.

State: its 3-D position. Action: ways forward and backward, turns left and right. Observations: RGB,
normals, depth, semantics, and the state of its joints. The same actions again on a waxed floor.

Run: python examples/05_navigate.py OUT
"""

import sys
from pathlib import Path

import openrooms_usd as ou
from openrooms_usd import robots

ACTIONS = (
    robots.Action(forward=1.3),
    robots.Action(left=1.9, forward=0.7),
    robots.Action(right=0.8, backward=0.3),
)
SEEN = ("radiance", "depth", "normal", "semantic")


def main(out: Path) -> None:
    scene = ou.compose(ou.copy_example(out / "source"), out)
    engine = robots.load_engine("mujoco")
    world = robots.with_robot(robots.load_world(scene), robots.rover((1.2, 1.2)))
    seen = robots.RobotCameras(scene, world)
    simulation = engine.open(world)
    first = {"robot": robots.robot_camera(simulation, "rover")}
    look = seen.see(simulation, first, ("semantic", "friction"))["robot"]
    floor = robots.mean_friction(look, seen.legend)
    print(f"friction of the floor, mean of its pixels: {floor:.3f}")
    rows = []
    for coefficient, watched in ((floor, True), (0.31, False)):
        simulation = engine.open(robots.with_friction(world, "floor", coefficient))
        for number, action in enumerate(ACTIONS):
            robots.act(simulation, "rover", action)
            pose = simulation.poses()["rover"]
            x, y, z = pose.world_from_body[:3, 3]
            wheels = ", ".join(f"{name} {angle:.2f} rad" for name, angle in pose.joints.items())
            print(f"floor {coefficient:.2f} step {number}: ({x:.3f}, {y:.3f}, {z:.3f})  {wheels}")
            if watched:
                cameras = {
                    "robot": robots.robot_camera(simulation, "rover"),
                    "onlooker": robots.look_at((5.2, 0.4, 1.9), (1.9, 2.1, 0.2)),
                }
                views = seen.see(simulation, cameras, SEEN)
                shown = {"onlooker": ["radiance"], "robot": SEEN}
                rows.append(robots.row(f"step {number}", views, shown))
        simulation.close()
    robots.write_strip(out / "strip.png", rows)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_05"))
