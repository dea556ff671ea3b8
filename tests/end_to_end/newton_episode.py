"""Lets a room rest in Newton; the Python that runs this has Newton, which brings its own pxr.

Run: python newton_episode.py SCENE SECONDS
"""

import json
import sys

import newton
import numpy as np
import warp as wp

STEP = 2e-3


def main(scene: str, seconds: float) -> None:
    """Print as JSON how far each body moved, metres, and how far each joint came apart."""
    builder = newton.ModelBuilder()
    builder.add_usd(scene)
    model = builder.finalize(device="cpu")
    before, after = model.state(), model.state()
    newton.eval_fk(model, model.joint_q, model.joint_qd, before)
    start = before.body_q.numpy().copy()
    solver = newton.solvers.SolverXPBD(model, iterations=8)
    control = model.control()
    for _ in range(round(seconds / STEP)):
        before.clear_forces()
        solver.step(before, after, control, model.collide(before), STEP)
        before, after = after, before
    end = before.body_q.numpy()
    moved = np.linalg.norm(end[:, :3] - start[:, :3], axis=1)
    labels = [label.removeprefix("/World/") for label in builder.body_label]
    print(
        json.dumps(
            {
                "moved": dict(zip(labels, moved.tolist(), strict=True)),
                "joints": dict(apartness(model, end)),
                "shapes": len(builder.shape_type),
            }
        )
    )


def apartness(model, bodies):
    """Of each joint but free ones: its name, how far its anchors are apart across its axis."""
    kinds, parents, children = (
        values.numpy() for values in (model.joint_type, model.joint_parent, model.joint_child)
    )
    frames = (model.joint_X_p.numpy(), model.joint_X_c.numpy())
    axes, starts = model.joint_axis.numpy(), model.joint_qd_start.numpy()
    for number, kind in enumerate(kinds):
        if kind == newton.JointType.FREE:
            continue
        ends = []
        for body, frame in zip((parents[number], children[number]), frames, strict=True):
            local = wp.transform(*frame[number])
            ends.append(wp.transform(*bodies[body]) * local if body >= 0 else local)
        gap = np.array(ends[1].p) - np.array(ends[0].p)
        axis = np.array(wp.quat_rotate(ends[0].q, wp.vec3(*axes[starts[number]])))
        if kind == newton.JointType.PRISMATIC:
            gap -= axis * (gap @ axis)
        yield model.joint_label[number].removeprefix("/World/"), float(np.linalg.norm(gap))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
