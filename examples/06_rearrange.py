"""A robot pushes a cabinet to where it shall stand: behind it, push, round it, push again.

Run: python examples/06_rearrange.py OUT
"""

import sys
from pathlib import Path

import openrooms_usd as ou
from openrooms_usd import robots

GOAL = (2.2, 1.6)
ALONG, ACROSS = 0.3 + 0.18, 0.25 + 0.18  # From its middle to the robot's, when they touch.


def main(out: Path) -> None:
    room = ou.new_room("living_room", width=3.6, depth=3, physics=True)
    room.add_window(wall=1)
    room.add("table", at=(0.6, 2.4))
    room.add("ceiling_lamp", at=(1.8, 1.5))
    scene = room.compose(out)
    world = robots.with_robot(robots.load_world(scene), robots.cabinet((1.5, 1.0)))
    world = robots.with_robot(world, robots.rover((0.5, 1.0)))
    simulation = robots.load_engine("mujoco").open(world)
    cameras = robots.RobotCameras(scene, world)

    x, y = GOAL
    # Along x, back off and round the corner, along y; twice, since wheels slip when they push.
    plan = [[(x - ALONG, 1.0)] * 2, [(0.8, 0.4), (x, 0.4)], [(x, y - ACROSS)] * 2]
    rows = []
    for number, points in enumerate([[], *plan]):
        if number == 2:
            robots.act(simulation, "rover", robots.Action(backward=0.25))
        for point in points:
            robots.act(simulation, "rover", robots.towards(simulation, "rover", point))
        pose = simulation.poses()["cabinet"].world_from_body
        miss = ((pose[0, 3] - x) ** 2 + (pose[1, 3] - y) ** 2) ** 0.5
        print(f"step {number}: ({pose[0, 3]:.2f}, {pose[1, 3]:.2f}), {100 * miss:.0f} cm to go")
        seen = {
            "onlooker": robots.look_at((0.3, 0.2, 1.9), (1.9, 1.4, 0)),
            "robot": robots.robot_camera(simulation, "rover"),
        }
        views = cameras.see(simulation, seen, ("radiance",))
        rows.append(robots.row(f"step {number}", views, {name: ["radiance"] for name in seen}))
    robots.write_strip(out / "strip.png", rows)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_06"))
