"""Many rooms by one dataset.yaml."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from openrooms_usd.api.given import AnyPath, path_of
from openrooms_usd.progress import Progress, silent

if TYPE_CHECKING:
    from openrooms_usd.dataset.plan import Job
    from openrooms_usd.dataset.run import RunSummary


def run_dataset(
    file: AnyPath,
    out: AnyPath,
    *,
    workers: int = 1,
    executor: str = "local",
    options: Mapping[str, str] | None = None,
    progress: Progress = silent,
) -> "RunSummary":
    """Make a dataset, or what is left of it; what is finished stays.

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
    """
    from openrooms_usd.dataset import run
    from openrooms_usd.dataset.scratch import root_of

    return run.run_dataset(
        path_of(file, "a dataset.yaml"),
        root_of(out),
        workers=workers,
        executor=executor,
        options=options,
        progress=progress,
    )


def plan_dataset(file: AnyPath) -> Iterator["Job"]:
    """What there is to do for a dataset, one by one: the views of one variant of one room.

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
