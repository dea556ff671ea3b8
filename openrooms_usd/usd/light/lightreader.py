"""Reading the lights of any stage, with everything that scales them resolved.

UsdLux defines the radiance of a light, in nits, as
``intensity * 2^exposure * color * blackbody(temperature) / size``. The size is 1 unless
``normalize`` is on; then it is the emitting area, or what stands for it with a distant light.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any, Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd.arrays import Array
from openrooms_usd.usd.arrays import number_of, vector_of
from openrooms_usd.usd.files.strayed import locate
from openrooms_usd.usd.light import emitters
from openrooms_usd.usd.light.inputs import OLD, has_filters, light_input, old_names
from openrooms_usd.usd.light.shaping import read_shaping
from openrooms_usd.usd.places.frames import Z_UP_FROM_Y_UP, up_axis
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import Texture, bound_material

Matrix = Array

# Animated lights are read where they begin; all others have one value anyway.
_WHEN: Final = Usd.TimeCode.EarliestTime()


def read_light(prim: Usd.Prim, world: Matrix | None = None) -> emitters.Light:
    """One light, whether it can be seen or not.

    Args:
        prim: A prim with ``UsdLux.LightAPI``.
        world: (4, 4) from its frame to the world, Z up and metres; None: where it stands itself.
    """
    reader = _Reader(prim, world)
    if reason := _misplaced(prim, reader.world):
        return emitters.UnknownLight(str(prim.GetPath()), np.zeros(3), reader.world, (reason,))
    # LightAPI makes a light of any shape; MeshLightAPI is for meshes.
    read = (
        _Reader.mesh if prim.IsA(UsdGeom.Gprim) else _KINDS.get(prim.GetTypeName(), _Reader.unknown)
    )
    light = read(reader)
    found, lost = read_shaping(prim, light)
    response, told = _response(prim)
    losses = (*light.losses, *lost, *told)
    return replace(light, shaping=found, response=response, losses=losses, unseen=reader.thin)


def _misplaced(prim: Usd.Prim, world: Matrix) -> str:
    """Why a light is nowhere, or light from afar comes from nowhere; empty where it is not so."""
    if not np.isfinite(world).all():
        return "its transform holds NaN or infinity"
    turned = np.linalg.norm(world[:3, :3], axis=0)
    return "" if turned.all() or prim.GetTypeName() not in _FROM_AFAR else _SINGULAR


def _response(prim: Usd.Prim) -> tuple[tuple[float, float], tuple[str, ...]]:
    """The multipliers of diffuse and specular reflection, and what is lost of them."""
    values = [
        number_of(light_input(prim, name).Get(_WHEN))
        for name in ("inputs:diffuse", "inputs:specular")
    ]
    diffuse, specular = (
        max(0.0, value) if value is not None and math.isfinite(value) else 1.0 for value in values
    )
    if diffuse == specular == 1.0:
        return (1.0, 1.0), ()
    if prim.GetTypeName() in _FROM_AFAR:
        return (1.0, 1.0), ("inputs:diffuse, inputs:specular: distant lights have no multipliers",)
    why = (
        "inputs:diffuse, inputs:specular: the first applies to all but metals, the second to metals"
    )
    return (diffuse, specular), (why,)


class _Reader:
    """One light prim: its attributes, and the losses so far."""

    def __init__(self, prim: Usd.Prim, world: Matrix | None) -> None:
        self.prim = prim
        self.losses: list[str] = []
        self.thin = False
        self.normalize = bool(self.value("inputs:normalize", False))
        self.world = emitters.world_from_prim(prim) if world is None else world

    # Kinds: each reads what is its own, and what all have in common at the end.

    def dome(self) -> emitters.Light:
        # The pole of a plain DomeLight is +Y, whatever else is written there.
        known = self.prim.IsA(UsdLux.DomeLight_1)
        pole = self.value("poleAxis", UsdGeom.Tokens.y) if known else UsdGeom.Tokens.y
        if pole == UsdLux.Tokens.scene:
            pole = up_axis(self.prim.GetStage())
        frame = self.world @ Z_UP_FROM_Y_UP if pole == UsdGeom.Tokens.z else self.world
        texture = self.texture()
        path, radiance, _, losses = self.common(1.0)
        return emitters.DomeLight(path, radiance, _rotation(frame), losses, texture)

    def mesh(self) -> emitters.Light:
        glow, tinted = self.glow()
        area = emitters.world_area(self.prim)
        if area == 0.0 and self.normalize:
            self.losses.append("inputs:normalize: the area of such a shape is not known; 1 is used")
        path, radiance, world, losses = self.common(area)
        return emitters.MeshLight(path, radiance * glow, world, losses, tinted)

    def rect(self) -> emitters.Light:
        width, height = (self.thick(f"inputs:{name}", 1.0) for name in ("width", "height"))
        texture = self.texture()
        return emitters.RectLight(
            *self.common(width * height * self.xy_scale()), width, height, texture
        )

    def disk(self) -> emitters.Light:
        radius = self.thick("inputs:radius", 0.5)
        return emitters.DiskLight(*self.common(math.pi * radius**2 * self.xy_scale()), radius)

    def sphere(self) -> emitters.Light:
        radius = self.thick("inputs:radius", 0.5, "treatAsPoint")
        return emitters.SphereLight(*self.common(ellipsoid_area(*(radius * self.scales()))), radius)

    def cylinder(self) -> emitters.Light:
        radius = self.thick("inputs:radius", 0.5, "treatAsLine")
        length = self.size("inputs:length", 1.0)
        sx, sy, sz = self.scales()
        area = length * sx * ellipse_perimeter(radius * sy, radius * sz)
        return emitters.CylinderLight(*self.common(area), radius, length)

    def distant(self) -> emitters.Light:
        angle = self.number("inputs:angle", 0.53)
        half = math.radians(min(max(angle, 0.0), 360.0)) / 2
        lit = math.sin(half) ** 2 * math.pi
        size = 1.0 if half == 0 else lit if half <= math.pi / 2 else 2 * math.pi - lit
        common = self.common(size)
        return emitters.DistantLight(*common, angle, common[1] * size)

    def unknown(self) -> emitters.Light:
        self.losses.append(
            f"lights of the type {self.prim.GetTypeName() or 'a prim'} are not supported"
        )
        return emitters.UnknownLight(*self.common(1.0))

    # What the kinds are made of.

    def common(self, size: float) -> tuple[str, Array, Matrix, tuple[str, ...]]:
        """Path, radiance, frame and losses: what every light has."""
        radiance = self.radiance(size)
        self.check_extras()
        return str(self.prim.GetPath()), radiance, self.world, tuple(self.losses)

    def value(self, name: str, default: Any) -> Any:
        attribute = light_input(self.prim, name)
        if attribute and attribute.HasAuthoredConnections():
            self.losses.append(f"{name}: what is connected to it is left out")
        value = attribute.Get(_WHEN) if attribute else None
        return default if value is None else value

    def number(self, name: str, default: float) -> float:
        found = self.value(name, default)
        value = number_of(found)
        if value is not None and math.isfinite(value):
            return value
        what = "no number" if value is None else "not finite"
        self.losses.append(f"{name}: {found} is {what}; {default} is used")
        return default

    def color(self) -> Array:
        """(3,) the factor of each primary."""
        found = vector_of(self.value("inputs:color", (1.0, 1.0, 1.0)), 3)
        if found is None:
            self.losses.append("inputs:color: it is not a colour; white is used")
        return np.ones(3) if found is None else found

    def size(self, name: str, default: float) -> float:
        """A length, in the light's own units."""
        value = self.number(name, default)
        if value < 0.0:
            self.losses.append(f"{name}: {value:g} is not a length; 0 is used")
        return max(value, 0.0)

    def thick(self, name: str, default: float, hint: str = "") -> float:
        """A length. What has none is taken as thin and unseen, of the flux that it has.

        Without a surface there is no radiance: the intensity of points and lines counts as if it
        was normalized. Other lights without a surface send something only where they are so.
        """
        length = self.size(name, default)
        if length > 0.0 or not (self.normalize or (hint and self.value(hint, False))):
            return length
        self.normalize = self.thin = True
        self.losses.append(
            f"{name}: it is treated as {1e3 * _THIN_METRES:g} mm thick, and is not visible"
        )
        scale = float(self.scales().mean())
        return _THIN_METRES / scale if scale > 0.0 else 0.0

    def radiance(self, size: float) -> Array:
        """(3,) nits of each primary."""
        stops = min(self.number("inputs:exposure", 0.0), _MOST_STOPS)
        scale = self.number("inputs:intensity", 1.0) * 2.0**stops
        if self.normalize and size > 0:
            scale /= size
        color = self.color()
        if self.value("inputs:enableColorTemperature", False):
            kelvin = self.number("inputs:colorTemperature", 6500.0)
            color = color * np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin))
        radiance = np.asarray(scale * color, dtype=np.float64)
        if not ((radiance >= 0) & (radiance <= _MOST_NITS)).all():
            self.losses.append(f"its radiance {radiance.tolist()} is not physical; cut off at 0")
            kept = (radiance >= 0) & (radiance <= _MOST_NITS)
            radiance = np.where(kept, radiance, 0.0)
        return radiance

    def texture(self) -> str | None:
        asset = self.value("inputs:texture:file", None)
        resolved, lost = locate(light_input(self.prim, "inputs:texture:file"), asset)
        if lost:
            self.losses.append(f"its texture {lost}")
        layout = self.value("inputs:texture:format", UsdLux.Tokens.automatic)
        if resolved and layout not in (UsdLux.Tokens.automatic, UsdLux.Tokens.latlong):
            self.losses.append(f"textures in {layout} layout are not supported")
            return None
        return resolved or None

    def glow(self) -> tuple[Array, bool]:
        """(3,) what the bound material makes of a mesh light's color, and whether by a picture."""
        mode = self.value("light:materialSyncMode", UsdLux.Tokens.materialGlowTintsLight)
        material = bound_material(self.prim)
        if mode == UsdLux.Tokens.noMaterialResponse or material is None:
            return np.ones(3), False
        emissive = read_preview_surface(material)[0].emissive
        if mode == UsdLux.Tokens.independent:
            self.losses.append(
                "light:materialSyncMode: it looks as bright as the light that it emits"
            )
            return np.ones(3), False
        if isinstance(emissive, Texture):
            return np.ones(3), True
        if not any(emissive):
            self.losses.append("its material's emission is black; it does not tint the light")
            return np.ones(3), False
        return np.array(emissive), False

    def check_extras(self) -> None:
        """Note the features that no light here has."""
        for name, (neutral, what) in _EXTRAS.items():
            attribute = light_input(self.prim, name)
            if attribute and attribute.HasAuthoredValue() and attribute.Get(_WHEN) != neutral:
                self.losses.append(f"{name}: {what}")
        if old := old_names(self.prim):
            self.losses.append(f"{OLD} are read: {', '.join(old)}")
        if has_filters(self.prim):
            self.losses.append("light:filters: light filters are left out")
        light = UsdLux.LightAPI(self.prim)
        if not includes_all(light.GetShadowLinkCollectionAPI().ComputeMembershipQuery()):
            self.losses.append("shadowLink: everything casts shadows")
        from_afar = self.prim.GetTypeName() in _FROM_AFAR
        if from_afar and not includes_all(
            light.GetLightLinkCollectionAPI().ComputeMembershipQuery()
        ):
            self.losses.append("lightLink: distant lights light everything")

    def scales(self) -> Array:
        """(3,) how much longer the local axes are in the world."""
        return np.asarray(np.linalg.norm(self.world[:3, :3], axis=0))

    def xy_scale(self) -> float:
        """How much larger an area in the local XY plane is in the world."""
        return float(np.linalg.norm(np.cross(self.world[:3, 0], self.world[:3, 1])))


_KINDS: Final[dict[str, Callable[[_Reader], emitters.Light]]] = {
    "DomeLight": _Reader.dome,
    "DomeLight_1": _Reader.dome,
    "RectLight": _Reader.rect,
    "DiskLight": _Reader.disk,
    "SphereLight": _Reader.sphere,
    "CylinderLight": _Reader.cylinder,
    "DistantLight": _Reader.distant,
}
# Attribute -> the value that changes nothing, and what any other value would do.
_EXTRAS: Final[dict[str, tuple[Any, str]]] = {
    "inputs:shadow:enable": (True, "the light casts shadows anyway"),
    "inputs:shadow:color": (Gf.Vec3f(0.0), "shadows are black"),
    "inputs:shadow:distance": (-1.0, "the length of shadows is not limited"),
    "inputs:shadow:falloff": (-1.0, "the length of shadows is not limited"),
    "inputs:shadow:falloffGamma": (1.0, "the length of shadows is not limited"),
}

# What renderers, who count in single precision, can still add up.
_MOST_NITS: Final = 1e30
_MOST_STOPS: Final = 1000.0

# The radius that points and lines have, metres.
_THIN_METRES: Final = 1e-3

# What is smaller in a rotation is rounding.
_ROUNDING_TOLERANCE: Final = 1e-15
_SINGULAR: Final = "its transform is singular"
_FROM_AFAR: Final = ("DomeLight", "DomeLight_1", "DistantLight")


def _rotation(frame: Matrix) -> Matrix:
    """A frame without its scales and offset."""
    lengths = np.linalg.norm(frame[:3, :3], axis=0)
    rotation = np.eye(4)
    rotation[:3, :3] = frame[:3, :3] / np.where(lengths > 0, lengths, 1.0)
    # The cosine of a quarter turn that is given in degrees is not quite 0.
    rotation[np.abs(rotation) < _ROUNDING_TOLERANCE] = 0.0
    return rotation


def ellipse_perimeter(a: float, b: float) -> float:
    """Perimeter of an ellipse: Ramanujan's second approximation, exact for circles."""
    h = ((a - b) / (a + b)) ** 2 if a + b > 0 else 0.0
    return math.pi * (a + b) * (1 + 3 * h / (10 + math.sqrt(4 - 3 * h)))


def ellipsoid_area(a: float, b: float, c: float) -> float:
    """Area of an ellipsoid: Thomsen's approximation, exact for spheres, else within 1.1 %."""
    p = 1.6075
    mean = ((a * b) ** p + (a * c) ** p + (b * c) ** p) / 3
    return float(4 * math.pi * mean ** (1 / p))


class LightLinks:
    """What the collections ``lightLink`` of the lights of a stage leave out.

    Args:
        stage: The stage.
        lights: Its lights; those from afar light everything.
    """

    def __init__(self, stage: Usd.Stage, lights: Iterable[emitters.Light]) -> None:
        self._queries = {
            light.path: UsdLux.LightAPI(stage.GetPrimAtPath(light.prim))
            .GetLightLinkCollectionAPI()
            .ComputeMembershipQuery()
            for light in lights
            if not isinstance(light, emitters.DomeLight | emitters.DistantLight)
        }
        for path, query in tuple(self._queries.items()):
            if includes_all(query):
                del self._queries[path]

    def unlit_by(self, path: str) -> tuple[str, ...]:
        """The lights that do not light a prim; of what an instancer scatters, its own path counts.

        Args:
            path: The prim's path, perhaps with the numbers of instances.
        """
        if not self._queries:
            return ()
        prim = Sdf.Path(path.partition("[")[0])
        return tuple(
            light for light, query in self._queries.items() if not query.IsPathIncluded(prim)
        )


def includes_all(query: Any) -> bool:
    """Whether a collection is the whole stage, which is USD's default."""
    return bool(query.GetAsPathExpansionRuleMap() == _EVERYTHING)


_EVERYTHING: Final = {Sdf.Path.absoluteRootPath: Usd.Tokens.expandPrims}
