"""Lets a room rest in PhysX, the engine of Isaac Sim; the Python that runs this has ovphysx.

Run: python physx_episode.py SCENE SECONDS
"""

import json
import sys

import numpy as np
import ovphysx
import ovstage
from ovphysx import PhysX
from ovphysx.samples.python_samples.schema_support import physx_schema_paths
from ovphysx.types import ObjectScope, SimObjectType

# Half of what Isaac Sim takes by default.
STEP = 1.0 / 120.0
POSE = ("position", "orientation")
SURFACES = ("staticFriction", "dynamicFriction")
OF_BODIES = (*POSE, *SURFACES, "shapeCount", "mass", "inertia", "centerOfMassPosition")


def main(scene: str, seconds: float) -> None:
    """Print as JSON what PhysX has of each body and joint, and how far each body went."""
    PhysX.set_cpu_mode(True)
    physx = PhysX()
    schemas = [*map(str, physx_schema_paths()), str(ovphysx.newton_schema_root())]
    ovstage.population.register_usd_schemas(schemas)
    stage = ovstage.Stage("room")
    domains = ovstage.PopulationDomain.ALL
    ovstage.population.open_usd(stage, scene, ordinal=1, domains=domains)
    stage.advance_write_floor(ordinal=1).wait()
    physx.wait_task(physx.attach_ovstage(stage, read_ordinal=1))

    before = bodies_of(physx, stage, OF_BODIES)
    for _ in range(round(seconds / STEP)):
        physx.step_sync(STEP)
    after = bodies_of(physx, stage, POSE)
    inner = rows_of(physx, stage, SimObjectType.ARTICULATION_JOINT, ("jointLimit",))
    # Of joints that hold on to the world it says no more than that they are there.
    joints = {path: {} for path in rows_of(physx, stage, SimObjectType.JOINT, ("physxPointer",))}
    joints |= {path: {"limits": row["jointLimit"].ravel().tolist()} for path, row in inner.items()}
    bodies = {path: body(before[path], after[path]) for path in before}
    print(json.dumps({"bodies": bodies, "joints": joints}))


def bodies_of(physx, stage, names):
    """What moves, by itself or as a part of an articulation."""
    kinds = (SimObjectType.RIGID_BODY, SimObjectType.ARTICULATION_LINK)
    first, second = (rows_of(physx, stage, kind, names) for kind in kinds)
    return first | second


def rows_of(physx, stage, kind, names):
    """Path to name to value, for all objects of a kind."""
    rows = {}
    with ovstage.PathDictionary(stage) as paths:
        for name in names:
            with physx.read_sync(kind, [name], scope=ObjectScope.ALL) as result:
                for group in result.groups:
                    tensors = [np.array(tensor.numpy()) for tensor in group.tensors]
                    if group.is_delete or not tensors:
                        continue
                    values = tensors if group.is_array else tensors[0]
                    for path, value in zip(
                        paths.get_path_strings(group.prim_list), values, strict=True
                    ):
                        rows.setdefault(path, {})[name] = value
    return rows


def body(before, after):
    """One body: SI units, its own frame; quaternions are x, y, z, w."""
    same = abs(float(before["orientation"] @ after["orientation"]))
    shapes = int(before["shapeCount"])
    return {
        "moved": float(np.linalg.norm(after["position"] - before["position"])),
        "turned": float(np.degrees(2.0 * np.arccos(min(1.0, same)))),
        "mass": float(before["mass"]),
        "centre": before["centerOfMassPosition"].tolist(),
        "inertia": before["inertia"].reshape(3, 3).tolist(),
        **{name: np.atleast_1d(before[name])[:shapes].tolist() for name in SURFACES},
    }


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
