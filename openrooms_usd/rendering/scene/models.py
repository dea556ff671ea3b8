"""One reflectance model for all surfaces, and what is lost by that."""

from dataclasses import replace
from typing import Final, Literal, get_args

import numpy as np

from openrooms_usd.rendering.scene.arrays import Patch, Scene
from openrooms_usd.rendering.scene.pictures import Picture
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.usd.shading.surfaces import f0_of

Model = Literal["auto", "openrooms", "preview"]
"""How surfaces reflect: as each material says, all by OpenRooms' microfacet model, or all as
UsdPreviewSurface."""

MODELS: Final[tuple[Model, ...]] = get_args(Model)


def with_model(scene: Scene, model: Model) -> Scene:
    """The scene with all its surfaces of one model; its report says what was changed for that.

    Args:
        scene: A translated stage.
        model: ``auto`` leaves the scene as it is.
    """
    if model == "auto":
        return scene
    shown = {id(patch.surface): _shown_as(model, patch.surface) for patch in scene.patches}
    scene.report.lose(
        {path: shown[id(surface)][1] for path, surface in scene.owners if id(surface) in shown}
    )
    patches = tuple(replace(patch, surface=shown[id(patch.surface)][0]) for patch in scene.patches)
    return replace(scene, patches=patches)


def without_shaping(scene: Scene) -> Scene:
    """The scene whose lamps shine evenly, with the same flux; its report says which did not."""
    if all(patch.shaping is None for patch in scene.patches):
        return scene
    lost, why = {}, "it shines evenly, without profile or cone"
    for patch in scene.patches:
        if patch.shaping is not None:
            for row in np.unique(patch.triangles.pieces):
                lost[scene.legend.part[scene.pieces[row].part]] = why
    scene.report.lose(lost)
    return replace(scene, patches=tuple(map(_even, scene.patches)))


def report_simplified(scene: Scene) -> None:
    """Say in the report what lights lose where all light everything and suns are points."""
    lamps = {lamp for patch in scene.patches for lamp in patch.unlit_by}
    lamps |= {patch.lamp for patch in scene.patches if patch.response != (1.0, 1.0)}
    scene.report.lose(dict.fromkeys(sorted(lamps), "it lights everything equally"))
    suns = [sun.path for sun in scene.suns if sun.angle > 0.0]
    scene.report.lose(dict.fromkeys(suns, "its angle is left out: shadows are sharp"))


def report_principled(scene: Scene) -> None:
    """Say in the report what surfaces lose that Mitsuba's own BSDFs and integrators show."""
    lost = {}
    for path, surface in scene.owners:
        why = []
        if surface.f0 is None and surface.pane is None and not surface.is_diffuse:
            why = ["Mitsuba's principled stands for UsdPreviewSurface: brighter at grazing angles"]
            why += ["its specularColor has no hue"] * (surface.specular is not None)
            why += ["its clearcoat is Disney's, at most as rough as 0.32"] * bool(surface.clearcoat)
        if surface.emission is not None and surface.opacity != 1.0:
            why.append("its emission is dimmed by its opacity where it is seen")
        if why:
            lost[path] = "; ".join(why)
    scene.report.lose(lost)


def report_plain(scene: Scene) -> None:
    """Say in the report what is lost where Mitsuba's own textures and emitters are all there is."""
    seen = "it is seen as a ball or tube of 1 mm"
    scene.report.lose({patch.lamp: seen for patch in scene.patches if patch.unseen})
    why = "its textures wrap along t as along s"
    scene.report.lose(
        {
            path: why
            for path, surface in scene.owners
            for value in vars(surface).values()
            if isinstance(value, Picture) and len(set(value.ways)) > 1
        }
    )


def _even(patch: Patch) -> Patch:
    if patch.shaping is None or patch.radiance is None:
        return patch
    share, radiance = patch.flux_share(), patch.radiance
    if isinstance(radiance, Picture):
        pixels = (radiance.pixels * share).astype(np.float32)
        radiance = Picture(pixels, radiance.wrap, radiance.uv)
    elif isinstance(radiance, tuple):
        red, green, blue = (share * value for value in radiance)
        radiance = (red, green, blue)
    else:
        radiance *= share
    return replace(patch, radiance=radiance, shaping=None)


def _shown_as(model: Model, surface: Surface) -> tuple[Surface, str]:
    """The surface in a model, and what was changed for that, in words."""
    if model == "preview" and surface.f0 is not None:
        lost = f"OpenRooms' model is shown by UsdPreviewSurface with ior {surface.ior:.4g}"
        return replace(surface, f0=None), lost
    # What has no specular lobe is Lambertian in both.
    if model == "openrooms" and surface.f0 is None and surface.dielectric != 1.0:
        f0 = f0_of(surface.dielectric)
        lost = f"UsdPreviewSurface is taken as OpenRooms' model with F0 {f0:.3g}"
        lost += "; its clearcoat is left out" if surface.clearcoat else ""
        lost += "; its specularColor has no hue" if surface.specular is not None else ""
        return replace(surface, f0=f0, specular=None), lost
    return surface, ""
