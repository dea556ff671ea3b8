"""Runs one step: gives it a layer between the others, then drafts what it wrote, whole."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path

from pxr import Sdf, Tf, Usd, UsdMedia, Vt

from openrooms_usd import names
from openrooms_usd.codedigest import counting
from openrooms_usd.description.room import Room
from openrooms_usd.errors import StageError, writing
from openrooms_usd.progress import Progress, silent
from openrooms_usd.steps.base import Step, StepContext, completed, record_of
from openrooms_usd.steps.draft import Draft
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.files import layers as usd_layers
from openrooms_usd.usd.files.diagnostics import composition_errors, reason
from openrooms_usd.usd.files.preflight import check_stage_file
from openrooms_usd.version import __version__


def steps() -> list[Step]:
    """One of each step, from the weakest to the strongest layer."""
    modules = [import_module(f"openrooms_usd.steps.{name}.step") for name in names.STEPS]
    return [
        getattr(module, f"{name.capitalize()}Step")()
        for name, module in zip(names.STEPS, modules, strict=True)
    ]


def create_edits(draft: Draft) -> None:
    """Make the layer for human edits when there is none yet; never touch it again.

    Raises:
        InputError: USD cannot read the one that is there; what it says would be lost in silence.
    """
    edits = draft.layer(names.EDITS)
    if edits.exists():
        check_stage_file(edits, is_whole=True)
    else:
        layer = Sdf.Layer.CreateAnonymous(".usda")
        usd_layers.apply_metadata(layer)
        draft.export(layer, names.EDITS)


def is_current(step: Step, wanted: str, draft: Draft) -> bool:
    """Whether a step's layer is as it would be written now, and all its files are there.

    If so, the draft keeps these files.

    Args:
        step: The step.
        wanted: Its `fingerprint`.
        draft: The composition.
    """
    path = draft.layer(step.name)
    if not path.is_file():
        return False
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path), metadataOnly=True)
    except Tf.ErrorException:
        return False
    record = record_of(layer, step.name)
    files: Iterable[str] = record.get("files", ())
    if record.get("fingerprint") != completed(wanted, record.get("counted", ())):
        return False
    if not all((draft.folder(step.name) / file).exists() for file in files):
        return False
    draft.keep(step.name, files)
    return True


def run(
    step: Step,
    room: Room,
    source: Path,
    draft: Draft,
    fingerprint: str,
    workers: int,
    progress: Progress = silent,
) -> Sequence[str]:
    """Author one step's layer into a draft; its record keeps the notes.

    Args:
        step: The step.
        room: The description.
        source: The description's folder.
        draft: The composition that it is for.
        fingerprint: What the layer is written from, besides the code that the step asks for.
        workers: Threads that the step may use.
        progress: Called with what is being done, and the finished fraction of the step.

    Returns:
        Notes for the user.

    Raises:
        OrusdError: The step refuses the description, a file cannot be written, or the layer was
            changed by hand.
    """
    draft.check_unchanged(step.name)
    folder = draft.folder(step.name)
    try:
        with draft.scratch(step.name) as layer, _edits(step.name, draft) as edits:
            usd_layers.apply_metadata(layer)
            position = names.STEPS.index(step.name)
            weaker = [draft.layer(name) for name in reversed(names.STEPS[:position])]
            with usd_layers.stacked(layer, [edits], weaker) as composed:
                context = StepContext(room, source, composed, folder, workers, progress)
                with counting() as counted:
                    step.author(context)
                whole = completed(fingerprint, counted)
                _write_authorship(composed, step.name, room, whole)
            kept = set(context.kept())
            arrays = usd_layers.arrays_file(layer, folder)
            kept |= {arrays.name} if arrays else set()
            record = {
                "fingerprint": whole,
                "seed": str(room.seed),
                "version": __version__,
                "files": Vt.StringArray(sorted(kept)),
                "counted": Vt.StringArray(sorted(counted)),
                "notes": Vt.StringArray(context.notes),
            }
            custom = {names.NAMESPACE: {"stages": {step.name: record}}}
            layer.customLayerData = {**layer.customLayerData, **custom}
            draft.export(layer, step.name, kept)
    except Tf.ErrorException as error:
        message = f"USD rejects what the step {step.name} writes: {reason(error)}"
        raise StageError(message) from error
    return context.notes


@contextmanager
def _edits(step: str, draft: Draft) -> Iterator[Path]:
    """The human edits, as a step sees them: what it defines itself is active.

    USD defines nothing below an inactive prim. What other steps define stays inactive.
    """
    path = draft.layer(names.EDITS)
    edits = _reactivated(path, step)
    if edits is None:
        yield path
        return
    with draft.scratch(names.EDITS) as copy:
        copy.TransferContent(edits)
        with writing(path):
            usd_layers.save(copy)
        yield Path(copy.realPath)


def _reactivated(path: Path, step: str) -> Sdf.Layer | None:
    """The edits without what deactivates a step's own prims; None when nothing does."""
    try:
        edits = Sdf.Layer.OpenAsAnonymous(str(path)) if path.is_file() else None
    except Tf.ErrorException:
        # Said when the step is composed, with the layer's place.
        return None
    if edits is None:
        return None
    off = layers.deactivations(edits, names.OWNED[step])
    world = edits.GetPrimAtPath(names.WORLD)
    off += [world] if world and not world.active else []
    layers.reactivate(off)
    return edits if off else None


def notes_of(path: Path, step: str = "") -> tuple[str, ...]:
    """What was noted when a layer was written.

    Args:
        path: The layer.
        step: Whose layer it is; empty for the root layer, whose notes are about the whole room.

    Returns:
        The notes; none where the layer is missing or holds none.
    """
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path), metadataOnly=True) if path.is_file() else None
    except Tf.ErrorException:
        return ()
    if layer is None:
        return ()
    record = record_of(layer, step) if step else layer.customLayerData.get(names.NAMESPACE)
    noted = record.get("notes", ()) if isinstance(record, dict) else ()
    return tuple(noted) if isinstance(noted, Vt.StringArray) else ()


def _write_authorship(stage: Usd.Stage, name: str, room: Room, fingerprint: str) -> None:
    # customLayerData of sublayers does not survive Stage.Flatten, these records do.
    record = UsdMedia.AuthorshipAPI.Apply(stage.OverridePrim(names.WORLD), name)
    record.CreateSoftwarePackageAttr(names.CREATOR)
    record.CreateSoftwareVersionAttr(__version__)
    record.CreateInputsAttr(["fingerprint", fingerprint, "seed", str(room.seed)])


def stack(draft: Draft, notes: Sequence[str] = ()) -> Sdf.Layer:
    """The root layer: metadata, the layers that are there as sublayers, notes about the room."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    usd_layers.apply_metadata(layer)
    layer.subLayerPaths = [
        f"./{names.LAYERS}/{name}.usda" for name in names.STACK if draft.layer(name).is_file()
    ]
    layer.pseudoRoot.SetInfo("renderSettingsPrimPath", names.RENDER_SETTINGS)
    if notes:
        kept = {names.NAMESPACE: {"notes": Vt.StringArray(notes)}}
        layer.customLayerData = {**layer.customLayerData, **kept}
    return layer


def write_scene(draft: Draft, notes: Sequence[str] | None = None) -> None:
    """Draft the root layer where it is missing or differs.

    Args:
        draft: The composition.
        notes: What is to be kept of the room as a whole; None for what is there.
    """
    layer = stack(draft, notes_of(draft.scene) if notes is None else notes)
    data = layer.ExportToString().encode()
    if not draft.scene.is_file() or draft.scene.read_bytes() != data:
        draft.export_scene(layer)


def check(draft: Draft) -> Usd.Stage:
    """Refuse a composition that USD finds errors in, before it takes the old one's place.

    Returns:
        The composed stage.

    Raises:
        StageError: Something refers to what is not there.
    """
    stack = [draft.layer(name) for name in names.STACK]
    stage = usd_layers.stacked_files(stack)
    errors = composition_errors(stage)
    if errors:
        prim, text = errors[0]
        raise StageError(
            f"the composed stage has {len(errors)} errors, the first at {prim}: {text}",
            place=draft.scene,
            remedy=f"look into {names.LAYERS}/{names.EDITS}.usda, the layer for edits",
        )
    return stage
