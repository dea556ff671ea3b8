"""A robot shoves a cabinet over carpet and wax, as in the OpenRooms paper; Coulomb says how far.

Robot 0.27 kg, cabinet 2 kg (friction 0.76), 2.4 m/s wanted for 0.08 s, then 1.67 s still; g 9.8.
The paper's table names neither gap nor motor. Ours: the robot touches, starts from rest, pushes the
height of the centre of mass with at most 30 or 60 N, runs on rails, its face is smooth and dead.
Run: python examples/04_push.py OUT
"""

import sys
from importlib.util import find_spec
from pathlib import Path

import openrooms_usd as ou
from openrooms_usd import robots

# PyBullet has no wheels for newer Pythons.
ENGINES = [name for name in ("pybullet", "mujoco") if find_spec(name)]


def main(out: Path) -> None:
    pushing = robots.pushing
    engines = {name: robots.load_engine(name) for name in ENGINES}
    print("floor  motor  Coulomb   step     " + "   ".join(f"{name:>16}" for name in engines))
    for name, floor in (("carpet", pushing.CARPET), ("wax", pushing.WAX)):
        for effort in (pushing.WEAK, pushing.STRONG):
            push = pushing.Push(floor, effort)
            way = pushing.predicted(push)
            for step in (0.004, 0.002, 0.001):
                ways = [pushing.simulated(push, engine, step) for engine in engines.values()]
                errors = "   ".join(f"{w:.4f} m {100 * (w / way - 1):+5.1f} %" for w in ways)
                print(f"{name:<6} {effort:3.0f} N  {way:.4f} m  {1000 * step:.0f} ms  {errors}")
        print(f"{name:<6} the paper, whose motor and gap are not known: {pushing.PAPER[floor]} m")

    # In a room of ours the floor's coefficient is the mean of its per-pixel map.
    corners = [(-1.2, -1.1), (1.8, -1.1), (1.8, 1.1), (-1.2, 1.1)]
    room = ou.new_room("storage", polygon=corners, height=2.4, physics=True)
    room.add("ceiling_lamp", at=(0.3, 0))
    room.set_material("floor", "loop_carpet")
    scene = room.compose(out)
    push = pushing.Push(pushing.CARPET)
    cameras = {"onlooker": robots.look_at((0.1, -1.0, 1.1), (0.05, 0.1, 0.15))}
    world = pushing.world_of(push)
    simulation, seen = engines["mujoco"].open(world), robots.RobotCameras(scene, world)
    rows = []
    for moment in pushing.moments(push, simulation):
        views = seen.see(simulation, cameras, ("radiance", "semantic", "friction"))
        rows += robots.row(moment, views, {"onlooker": ["radiance"]})
    ours = pushing.Push(robots.mean_friction(views["onlooker"], seen.legend))
    way = pushing.simulated(ours, engines["mujoco"], 0.002)
    print(f"our carpet {ours.floor:.3f}: {way:.3f} m, by Coulomb {pushing.predicted(ours):.3f} m")
    robots.write_strip(out / "strip.png", [rows])


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_04"))
