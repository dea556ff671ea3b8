"""Lets a room rest in Newton; the Python that runs this has Newton, which brings its own pxr.

Run: python newton_episode.py SCENE SECONDS
"""

import json
import sys

import newton
import numpy as np
import warp as wp

STEP = 2e-3
# With 8, a towel that lies on another hops by 9 mm now and then.
ROUNDS = 16


def main(scene: str, seconds: float) -> None:
    """Print as JSON what Newton has of each body and joint, and how far each body went."""
    builder = newton.ModelBuilder()
    builder.add_usd(scene)
    model = builder.finalize(device="cpu")
    before, after = model.state(), model.state()
    newton.eval_fk(model, model.joint_q, model.joint_qd, before)
    start = before.body_q.numpy().copy()
    solver = newton.solvers.SolverXPBD(model, iterations=ROUNDS)
    control = model.control()
    for _ in range(round(seconds / STEP)):
        before.clear_forces()
        solver.step(before, after, control, model.collide(before), STEP)
        before, after = after, before
    end = before.body_q.numpy()
    print(
        json.dumps({"bodies": dict(bodies(model, start, end)), "joints": dict(joints(model, end))})
    )


def bodies(model, start, end):
    """Of each body: its path; SI units, its own frame; quaternions are x, y, z, w."""
    surfaces = [[] for _ in model.body_label]
    shapes = (values.numpy() for values in (model.shape_body, model.shape_flags))
    for body, flags, friction in zip(*shapes, model.shape_material_mu.numpy(), strict=True):
        if body >= 0 and flags & newton.ShapeFlags.COLLIDE_SHAPES:
            surfaces[body].append(float(friction))
    for number, path in enumerate(model.body_label):
        same = abs(float(start[number, 3:] @ end[number, 3:]))
        yield (
            path,
            {
                "moved": float(np.linalg.norm(end[number, :3] - start[number, :3])),
                "turned": float(np.degrees(2.0 * np.arccos(min(1.0, same)))),
                "mass": float(model.body_mass.numpy()[number]),
                "centre": model.body_com.numpy()[number].tolist(),
                "inertia": model.body_inertia.numpy()[number].tolist(),
                "dynamicFriction": surfaces[number],
            },
        )


def joints(model, bodies):
    """Of each joint but free ones: its path, its limits, and how far its anchors are apart."""
    kinds, parents, children = (
        values.numpy() for values in (model.joint_type, model.joint_parent, model.joint_child)
    )
    frames = (model.joint_X_p.numpy(), model.joint_X_c.numpy())
    axes, starts = model.joint_axis.numpy(), model.joint_qd_start.numpy()
    lower, upper = model.joint_limit_lower.numpy(), model.joint_limit_upper.numpy()
    for number, kind in enumerate(kinds):
        if kind == newton.JointType.FREE:
            continue
        ends = []
        for body, frame in zip((parents[number], children[number]), frames, strict=True):
            local = wp.transform(*frame[number])
            ends.append(wp.transform(*bodies[body]) * local if body >= 0 else local)
        gap = np.array(ends[1].p) - np.array(ends[0].p)
        first = starts[number]
        axis = np.array(wp.quat_rotate(ends[0].q, wp.vec3(*axes[first])))
        limits = [float(lower[first]), float(upper[first])]
        if kind == newton.JointType.PRISMATIC:
            gap -= axis * (gap @ axis)
        else:
            limits = np.degrees(limits).tolist()
        # Across the axis.
        yield model.joint_label[number], {"limits": limits, "apart": float(np.linalg.norm(gap))}


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
