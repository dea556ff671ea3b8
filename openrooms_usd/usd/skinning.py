"""Skinned meshes in their pose: joints and blend shapes worked into points."""

from typing import Final

from pxr import Gf, Sdf, Tf, Usd, UsdSkel

# What makes a prim follow joints or blend shapes.
_INFLUENCES: Final = ("primvars:skel:jointIndices", "skel:blendShapes")
# What is written of a mesh, or of what is skinned as a whole.
_MOVED: Final = ("points", "xformOpOrder")


def has_skin(prim: Usd.Prim) -> bool:
    """Whether a prim moves with a skeleton, or holds what does."""
    return prim.IsA(UsdSkel.Root) or is_skinned(prim)


def is_skinned(prim: Usd.Prim) -> bool:
    """Whether a prim has influences of joints or blend shapes."""
    return any(prim.GetAttribute(name).HasAuthoredValue() for name in _INFLUENCES)


def skin(stage: Usd.Stage, layer: Sdf.Layer) -> dict[str, str]:
    """Write the posed points of all skinned meshes of a stage that holds still.

    USD's own: linear blend or dual quaternion skinning as each mesh says, blend shapes with
    in-betweens first. Meshes outside a ``SkelRoot`` are not skinned, which is USD's rule.

    Args:
        stage: A stage without instances that have something skinned inside.
        layer: One of its layers that receives the points; roots become ``Xform`` there.

    Returns:
        By prim path, why it stays in its rest pose.
    """
    lost: dict[str, str] = {}
    for root in [prim for prim in stage.TraverseAll() if prim.IsA(UsdSkel.Root)]:
        skinned = [prim for prim in Usd.PrimRange(root) if is_skinned(prim)]
        reason = "its joints or weights do not fit its skeleton"
        try:
            with Usd.EditContext(stage, layer):
                UsdSkel.BakeSkinning(UsdSkel.Root(root), Gf.Interval.GetFullInterval())
        except Tf.ErrorException as error:
            reason = str(error.args[0].commentary)
        for prim in skinned:
            if not _is_posed(prim, layer):
                lost[str(prim.GetPath())] = (
                    f"skinning is left out, drawn in its rest pose: {reason}"
                )
    return lost


def _is_posed(prim: Usd.Prim, layer: Sdf.Layer) -> bool:
    """Whether a layer moves a prim or its points."""
    specs = (layer.GetAttributeAtPath(prim.GetPath().AppendProperty(name)) for name in _MOVED)
    return any(spec is not None and spec.HasDefaultValue() for spec in specs)
