"""Depth, position, normals: against an independent ray cast and against their own definitions."""

from itertools import product

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.channels import CHANNELS, DEFAULT
from tests import small
from tests.small import square

GEOMETRY = ("depth", "distance", "position", "normal", "normal_geometric", "normal_camera", "valid")
WIDTH, HEIGHT = 32, 24


def furnished(up="Z", metres=1.0):
    """A tilted box, a stretched one and a floor, seen by a camera with a shifted window."""
    made = small.Stage(up=up, metres=metres)
    # Row vectors, as USD's: from our world to the stage's frame.
    turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), -90 if up == "Y" else 0))
    to_stage = turn * Gf.Matrix4d().SetScale(1 / metres)

    def place(mesh, *steps):
        points = [Gf.Vec3f(to_stage.Transform(Gf.Vec3d(p))) for p in mesh.GetPointsAttr().Get()]
        mesh.GetPointsAttr().Set(points)
        placed = Gf.Matrix4d(1)
        for step in steps:
            placed = placed * step
        mesh.AddTransformOp().Set(to_stage.GetInverse() * placed * to_stage)

    place(made.quad("/Floor", square((0, 0, 0), 2)))
    tilt = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 2, 0.5), 50))
    move = Gf.Matrix4d().SetTranslate(Gf.Vec3d(0.3, 0.2, 0.9))
    place(made.box("/Boxes/first", 0.8), tilt, move)
    stretch = Gf.Matrix4d().SetScale(Gf.Vec3d(1.0, 1.4, 0.7))
    shift = Gf.Matrix4d().SetTranslate(Gf.Vec3d(-0.9, 0.4, 0.35))
    place(made.box("/Boxes/second", 0.5), stretch, shift)

    def at(*v):
        return to_stage.Transform(Gf.Vec3d(*v))

    made.camera(at(0.5, -3.1, 1.7), at(0.1, 0.3, 0.4), up=at(0, 0, 1))
    camera = UsdGeom.Camera(made.stage.GetPrimAtPath("/Camera"))
    camera.CreateHorizontalApertureOffsetAttr(0.03)
    camera.CreateVerticalApertureOffsetAttr(-0.02)
    return made.stage


def brute_force(stage: Usd.Stage) -> tuple[Array, Array]:
    """First hits and normals through pixel centres, by USD's frustum and Moller and Trumbore."""
    cache = UsdGeom.XformCache()
    triangles = []
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            matrix = cache.GetLocalToWorldTransform(prim)
            points = [np.array(matrix.Transform(Gf.Vec3d(p))) for p in mesh.GetPointsAttr().Get()]
            rows = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
            triangles += [
                [points[r[i]] for i in pick] for r in rows for pick in ((0, 1, 2), (0, 2, 3))
            ]
    a, b, c = np.moveaxis(np.array(triangles), 1, 0)
    frustum = UsdGeom.Camera(stage.GetPrimAtPath("/Camera")).GetCamera(0).frustum
    hits = np.zeros((HEIGHT, WIDTH, 3))
    normals = np.zeros((HEIGHT, WIDTH, 3))
    for y, x in product(range(HEIGHT), range(WIDTH)):
        ray = frustum.ComputePickRay(
            Gf.Vec2d((x + 0.5) / WIDTH * 2 - 1, 1 - (y + 0.5) / HEIGHT * 2)
        )
        eye, d = np.array(frustum.position), np.array(ray.direction)
        p = np.cross(d, c - a)
        with np.errstate(all="ignore"):
            inverse = 1 / np.einsum("ij,ij->i", b - a, p)
            u = np.einsum("ij,ij->i", eye - a, p) * inverse
            q = np.cross(eye - a, b - a)
            v, t = q @ d * inverse, np.einsum("ij,ij->i", c - a, q) * inverse
        t[~((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0))] = np.inf
        nearest = int(t.argmin())
        if np.isfinite(t[nearest]):
            hits[y, x] = eye + t[nearest] * d
            n = np.cross(b[nearest] - a[nearest], c[nearest] - a[nearest])
            normals[y, x] = -np.sign(n @ d) * n / np.linalg.norm(n)
    return hits, normals


def test_positions_and_normals_are_those_of_an_independent_ray_cast(shoot):
    stage = furnished()
    images = shoot(stage, *GEOMETRY).images
    hits, normals = brute_force(stage)
    seen = np.abs(hits).sum(axis=2) > 0
    assert 0.5 < seen.mean() < 1.0
    assert np.array_equal(images["valid"].pixels[..., 0] == 1, seen)
    assert np.abs(images["position"].pixels - hits).max() < 2e-6
    assert np.abs(images["normal_geometric"].pixels - normals).max() < 1e-6
    assert np.abs(images["normal"].pixels - normals).max() < 1e-6


def test_depth_is_planar_and_distance_is_euclidean(shoot):
    view = shoot(furnished(), *GEOMETRY)
    image = {name: item.pixels for name, item in view.images.items()}
    x, y = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    rays = np.stack(
        [(x - view.K[0, 2]) / view.K[0, 0], (y - view.K[1, 2]) / view.K[1, 1], np.ones_like(x)],
        axis=2,
    )
    lengths = np.linalg.norm(rays, axis=2, keepdims=True)
    assert np.allclose(image["distance"], image["depth"] * lengths, rtol=1e-6)
    points = image["depth"] * rays @ view.world_from_camera[:3, :3].T
    points += view.world_from_camera[:3, 3]
    valid = image["valid"] == 1
    assert np.abs(np.where(valid, points - image["position"], 0)).max() < 2e-6


def test_normals_are_unit_face_the_camera_and_turn_into_its_axes(shoot):
    stage = furnished()
    view = shoot(stage, *GEOMETRY)
    image = {name: item.pixels for name, item in view.images.items()}
    valid = image["valid"][..., 0] == 1
    to_camera = view.world_from_camera[:3, 3] - image["position"]
    for name in ("normal", "normal_geometric"):
        normals = image[name][valid]
        assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6)
        assert (np.einsum("ij,ij->i", normals, to_camera[valid]) > 0).all()
    # The rows of USD's camera matrix are its axes: right, up, backward.
    axes = np.array(UsdGeom.Camera(stage.GetPrimAtPath("/Camera")).GetCamera(0).transform)[:3, :3]
    assert np.allclose(image["normal_camera"], image["normal"] @ axes.T, atol=1e-6)


def test_everything_is_zero_where_there_is_no_surface(shoot):
    names = [name for name in DEFAULT if CHANNELS[name].kind != "light"]
    images = shoot(furnished(), *names).images
    nothing = images["valid"].pixels[..., 0] == 0
    assert nothing.any()
    assert all((image.pixels[nothing] == 0).all() for image in images.values())


def test_a_stage_in_centimetres_with_y_up_gives_the_same_pixels(shoot):
    names = (*GEOMETRY, "instance", "part")
    ours = shoot(furnished(), *names).images
    theirs = shoot(furnished(up="Y", metres=0.01), *names).images
    for name in ("valid", "instance", "part"):
        assert np.array_equal(ours[name].pixels, theirs[name].pixels), name
    for name in ("depth", "distance", "position"):
        assert np.abs(ours[name].pixels - theirs[name].pixels).max() < 2e-6, name
    for name in ("normal", "normal_geometric", "normal_camera"):
        assert np.abs(ours[name].pixels - theirs[name].pixels).max() < 1e-5, name


@pytest.mark.parametrize("offset", [1e4, 1e6])
def test_far_from_the_origin_depth_stays_exact(shoot, offset):
    near = furnished()
    far = furnished()
    for path in ("/Floor", "/Boxes", "/Camera"):
        shifted = UsdGeom.Xformable(far.GetPrimAtPath(path))
        if not shifted:
            shifted = UsdGeom.Xform.Define(far, path)
        before = shifted.GetOrderedXformOps()
        move = shifted.AddTranslateOp(opSuffix="far")
        move.Set(Gf.Vec3d(offset, -offset, 0))
        shifted.SetXformOpOrder([move, *before])
    a, b = (shoot(stage, "depth", "valid").images for stage in (near, far))
    assert np.array_equal(a["valid"].pixels, b["valid"].pixels)
    assert np.abs(a["depth"].pixels - b["depth"].pixels).max() < 1e-5


def test_instances_and_their_flattened_copy_give_the_same_bits(shoot):
    made = small.Stage()
    made.box("/Class/Chair/Seat", 0.5)
    for number in range(3):
        prim = UsdGeom.Xform.Define(made.stage, f"/World/chair_{number}")
        prim.GetPrim().GetReferences().AddInternalReference("/Class/Chair")
        prim.GetPrim().SetInstanceable(True)
        prim.AddTranslateOp().Set(Gf.Vec3d(number - 1, 0, 0))
        prim.AddRotateZOp().Set(30.0 * number)
    made.stage.GetPrimAtPath("/Class").SetActive(True)
    made.dome()
    made.camera((0.3, -3, 1.5), (0, 0, 0))
    UsdGeom.Imageable(UsdGeom.Xform.Define(made.stage, "/Class")).MakeInvisible()
    flat = Usd.Stage.Open(made.stage.Flatten(addSourceFileComment=False))
    for prim in flat.Traverse():
        if prim.IsInstance():
            prim.SetInstanceable(False)
    assert not flat.GetPrototypes()
    assert len(made.stage.GetPrototypes()) == 1
    a, b = (shoot(stage, *GEOMETRY, "instance", "radiance").images for stage in (made.stage, flat))
    assert (a["instance"].pixels.max(), a["instance"].pixels.min()) == (3, 0)
    assert all(np.array_equal(a[name].pixels, b[name].pixels) for name in a)


@pytest.mark.parametrize("scale", [(1, 1, 1), (2, 1, 0.5), (-1, 1.5, 1)])
def test_smooth_normals_are_those_of_the_ellipsoid(shoot, scale):
    made = small.Stage()
    sphere = UsdGeom.Sphere.Define(made.stage, "/Ball")
    sphere.CreateRadiusAttr(1.0)
    sphere.AddScaleOp().Set(Gf.Vec3f(*scale))
    made.camera((0, -4, 0), (0, 0, 0), fov=12)
    images = shoot(made.stage, "normal", "position").images
    # The gradient of (x / a)^2 + (y / b)^2 + (z / c)^2.
    outward = images["position"].pixels / np.square(scale)
    assert (
        np.abs(images["normal"].pixels - outward / np.linalg.norm(outward, axis=2)[..., None]).max()
        < 0.01
    )
