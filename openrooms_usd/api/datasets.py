"""Many rooms from one dataset.yaml, and renders in the form of a published dataset."""

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from openrooms_usd.api.given import AnyPath, choice_of, path_of
from openrooms_usd.errors import RenderError
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from openrooms_usd.dataset.plan import Job
    from openrooms_usd.dataset.run import RunSummary
    from openrooms_usd.rendering.datasets import Crowded, DatasetSummary, Layout, Order, Subset


def run_dataset(
    file: AnyPath,
    out: AnyPath,
    *,
    workers: int = 1,
    executor: str = "local",
    options: Mapping[str, str] | None = None,
    progress: Progress = silent,
) -> "RunSummary":
    """Make a dataset, or finish one: what exists is kept.

    Args:
        file: The dataset.yaml.
        out: The dataset's folder, or a URL such as ``s3://bucket/name`` (extra ``remote``).
        workers: How many rooms are worked on at once.
        executor: Who works them off: ``local``, ``ray`` (extra ``ray``), or another.
        options: What is asked of the executor, by name.
        progress: Called with each view and the finished fraction.

    Returns:
        ``.made`` and ``.kept`` count views, ``.failed`` has the reason of each that could not be
        made, ``.notes`` what is worth saying of other forms.

    Raises:
        InputError: A file is missing, or a name is unknown.
        DescriptionError: The dataset.yaml has mistakes.
        MissingPackageError: The executor or the URL needs a package that is not installed.
        OutputError: The folder cannot be written, or is that of another dataset.
        RenderError: No view at all could be made.
    """
    from openrooms_usd.dataset import run
    from openrooms_usd.dataset.scratch import root_of

    done = run.run_dataset(
        path_of(file, "a dataset.yaml"),
        root_of(out),
        workers=workers,
        executor=executor,
        options=options,
        progress=progress,
    )
    if done.failed and not done.made + done.kept:
        unit, reason = next(iter(done.failed.items()))
        raise RenderError(
            f"all {len(done.failed)} views failed; {unit}: {reason}",
            place=str(out),
            remedy="`orusd dataset status` lists the causes; fix them and run again",
        )
    return done


def plan_dataset(file: AnyPath) -> Iterator["Job"]:
    """The jobs of a dataset, one by one: the views of one variant of one room.

    Args:
        file: The dataset.yaml.

    Returns:
        Of each its ``.name``, ``.room``, ``.variant``, ``.seed`` and ``.views``.

    Raises:
        InputError: A file is missing, or there is no such renderer.
        DescriptionError: The dataset.yaml has mistakes.
    """
    from openrooms_usd.dataset.plan import plan_jobs
    from openrooms_usd.description import load_dataset

    return plan_jobs(load_dataset(path_of(file, "a dataset.yaml")))


def write_dataset(
    renders: AnyPath | Sequence[AnyPath],
    out: AnyPath,
    *,
    kind: str = "openrooms",
    scene: str = "scene0000_00",
    splits: str | Sequence[str] = ("main_xml",),
    subset: "Subset" = "train",
    layout: "Layout" = "split",
    order: "Order" = "legacy",
    first: int = 1,
    crowded: "Crowded" = "leave-out",
    stages: Sequence[AnyPath] = (),
    progress: Progress = silent,
) -> "DatasetSummary":
    """Write finished renders as the files of a published dataset.

    Args:
        renders: One render, or several: variants of one scene, or rooms, as the form takes them.
        out: The dataset's folder; other scenes in it stay.
        kind: Whose dataset.
        scene: The scene's name in it.
        splits: What each render is, in their order.
        subset: The list that the scene is added to.
        layout: A tree for each channel, or one folder.
        order: In which order the channels of environment maps are stored.
        first: The number of the first view.
        crowded: What becomes of views with more lights than loaders have room for.
        stages: The composed stage of each render: its scene is written, too.
        progress: Called with each finished view and the finished fraction.

    Returns:
        How many files of which views, and what is ``.missing`` and why.

    Raises:
        InputError: There is no such dataset, or the renders or options do not fit each other.
        OutputError: A file cannot be written.
    """
    from openrooms_usd.rendering import datasets as forms

    chosen = {"subset": subset, "layout": layout, "order": order, "crowded": crowded}
    for what, value in chosen.items():
        choice_of(value, getattr(forms, what.title()), what)
    several = [renders] if isinstance(renders, (str, os.PathLike)) else renders
    folders = [path_of(render, "a render's folder") for render in several]
    names = (splits,) if isinstance(splits, str) else tuple(splits)
    of = tuple(map(path_of, stages))
    options = forms.DatasetOptions(scene, names, subset, layout, order, first, crowded, of)
    return forms.write_dataset(folders, path_of(out), kind=kind, options=options, progress=progress)
