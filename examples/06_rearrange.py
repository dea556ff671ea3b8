"""A robot pushes a cabinet to where it shall stand: behind it, push, round it, push again.

Run: python examples/06_rearrange.py OUT
"""

import sys
from pathlib import Path

from openrooms_usd import adapters, compose_room
from openrooms_usd.geometry.pinhole import look_at
from openrooms_usd.simulation import strips
from openrooms_usd.simulation.driving import Action, act, towards
from openrooms_usd.simulation.eyes import RGB, Eyes, robot_camera
from openrooms_usd.simulation.pushing import cabinet
from openrooms_usd.simulation.robots import rover, with_robot
from openrooms_usd.usd.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world

ROOM = """\
room: living_room
layout:
  {polygon: [[0, 0], [3.6, 0], [3.6, 3], [0, 3]], openings: [{kind: window, wall: 1}]}
alignment:
  objects: [{category: table, at: [0.6, 2.4]}, {category: ceiling_lamp, at: [1.8, 1.5]}]
physics: {}
"""
GOAL = (2.2, 1.6)
ALONG, ACROSS = 0.3 + 0.18, 0.25 + 0.18  # From its middle to the robot's, when they touch.


def main(out: Path) -> None:
    out.mkdir(parents=True, exist_ok=True)
    (out / "room.yaml").write_text(ROOM)
    scene = compose_room(out / "room.yaml", out).scene
    world = with_robot(read_world(open_stage(scene)), cabinet((1.5, 1.0)))
    world = with_robot(world, rover((0.5, 1.0)))
    simulation = adapters.load(adapters.ENGINES, "pybullet").open(world)
    eyes = Eyes(scene, world)

    x, y = GOAL
    # Along x, back off and round the corner, along y; twice, since wheels slip when they push.
    plan = [[(x - ALONG, 1.0)] * 2, [(0.8, 0.4), (x, 0.4)], [(x, y - ACROSS)] * 2]
    rows = []
    for number, points in enumerate([[], *plan]):
        if number == 2:
            act(simulation, "rover", Action(backward=0.25))
        for point in points:
            act(simulation, "rover", towards(simulation, "rover", point))
        pose = simulation.poses()["cabinet"].world_from_body
        miss = ((pose[0, 3] - x) ** 2 + (pose[1, 3] - y) ** 2) ** 0.5
        print(f"step {number}: ({pose[0, 3]:.2f}, {pose[1, 3]:.2f}), {100 * miss:.0f} cm to go")
        eye, onlooker = robot_camera(simulation, "rover"), look_at((0.3, 0.2, 1.9), (1.9, 1.4, 0))
        views = eyes.see(simulation, {"onlooker": onlooker, "robot": eye}, (RGB,))
        rows.append(strips.row(f"step {number}", views, {"onlooker": [RGB], "robot": [RGB]}))
    strips.write_strip(out / "strip.png", rows)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_06"))
