"""What a dataset of a million views takes: hours, machines, bytes, requests and money, as a model.

Its inputs are measured here and now: planning, records, what reads all records (`status`, `stats`,
the end of a run, and a run with nothing left to do) at two sizes of a dataset whose records are
real and whose pictures are none; handing tasks to workers that do nothing; and a room, rendered.
All seconds are of processors, so that other work on the machine counts little. What is not measured
is an assumption: an option, and a row of the second table.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import click

from benchmarks.report import publish, table
from benchmarks.scenes import orusd
from openrooms_usd import adapters
from openrooms_usd.dataset.executor import Executor, Task, Told, Wanted
from openrooms_usd.dataset.plan import plan_jobs, view_name
from openrooms_usd.dataset.records import SCENE
from openrooms_usd.dataset.store import Store, write_json
from openrooms_usd.description import load_dataset

VIEWS_OF_A_JOB: Final = 10
_MOST_RECORDED: Final = 10_000

# Each in a process of its own: memory is that of nothing else.
_STEPS: Final = {
    "plan": "from openrooms_usd.dataset.plan import plan_jobs\n"
    "Store(root).write_plan(plan_jobs(load_dataset(file)))",
    "record": "from benchmarks.scale import record\nrecord(root, file, Path(sys.argv[3]))",
    "status": "from openrooms_usd.dataset.status import status_of\n"
    "assert status_of(root).left == 0",
    "stats": "from openrooms_usd.dataset.stats import stats_of\nstats_of(root)",
    "finish": "from openrooms_usd.dataset.run import finish\n"
    "finish(Store(root), load_dataset(file))",
    "run again": "from openrooms_usd.dataset.run import run_dataset\n"
    "assert run_dataset(file, root).made == 0",
}
_STEP: Final = """
import json, resource, sys, time
from pathlib import Path
from openrooms_usd.dataset.store import Store
from openrooms_usd.description import load_dataset
file, root = Path(sys.argv[1]), Path(sys.argv[2])
began = time.process_time()
{step}
took = time.process_time() - began
print(json.dumps([took, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024]))
"""


def nothing(task: Task) -> Iterator[Told]:
    """Work that is done at once, and tells what a view tells."""
    yield {"event": "begun", "view": task["number"]}
    yield {"event": "finished", "view": task["number"]}


def fill(root: Path, file: Path, example: Path) -> None:
    """Have a record of every view of a plan, by those of a real one; as quickly as can be."""
    for path, record in _records(Store(root), file, example):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(record))


def record(root: Path, file: Path, example: Path) -> None:
    """The same as a run does it."""
    for path, said in _records(Store(root), file, example):
        write_json(path, said)


def _records(store: Store, file: Path, example: Path) -> Iterator[tuple[Path, dict[str, Any]]]:
    records = {path.stem: json.loads(path.read_text()) for path in example.glob("records/*/*/*")}
    timing = json.loads(next(example.glob("timing/*/*/*")).read_text())
    view = next(record for name, record in records.items() if name != SCENE)
    for job in plan_jobs(load_dataset(file)):
        yield store.record_path(job, SCENE), {**records[SCENE], "key": job.key}
        for number in job.views:
            said = {"unit": f"{job.name}/view_{number}", "room": job.room.name, "key": job.key}
            yield store.timing_path(job, number), {**timing, "key": job.key}
            yield store.record_path(job, view_name(number)), {**view, **said}


def measure_steps(folder: Path, example: Path, views: int) -> Iterator[dict[str, Any]]:
    """What is done with a plan and its records, for a dataset of so many views.

    Records are made as a run makes them in the smaller datasets alone: that takes longest.
    """
    file, root = folder / f"{views}.yaml", folder / str(views)
    file.write_text(
        f"rooms: [{{types: [bathroom], count: {views // VIEWS_OF_A_JOB}}}]\n"
        f"views: {{count: {VIEWS_OF_A_JOB}}}\n"
    )
    for name, step in _STEPS.items():
        if name == "record" and views > _MOST_RECORDED:
            fill(root, file, example)
            continue
        words = [sys.executable, "-c", _STEP.format(step=step), file, root, example]
        env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
        done = subprocess.run(words, capture_output=True, text=True, check=False, env=env)
        if done.returncode:
            raise SystemExit(done.stderr)
        seconds, memory = json.loads(done.stdout)
        click.echo(f"{name}, {views} views: {seconds:.1f} s, {memory:.0f} MiB", err=True)
        yield {"step": name, "views": views, "ms_a_view": 1e3 * seconds / views, "MiB": memory}


def measure_handing(executor: str, tasks: int) -> dict[str, Any]:
    """Hand out tasks that are done at once; seconds of the clock, for nobody else would wait."""
    hirer: Executor = adapters.load(adapters.EXECUTORS, executor)
    rows = ({"number": number} for number in range(tasks))
    with hirer.hired(Wanted(1)) as crew:
        told = crew.run(rows, nothing)
        next(told)
        began = time.perf_counter()
        count = sum(1 for _ in told)
        took = time.perf_counter() - began
    assert count == 2 * tasks - 1
    return {"step": f"hand out, {executor}", "views": tasks, "ms_a_view": 1e3 * took / tasks}


def measure_room(folder: Path, size: tuple[int, int], samples: int) -> tuple[Path, float]:
    """Make a room with four views; where it lies, and core seconds a view."""
    file, out = folder / "room.yaml", folder / "room"
    file.write_text(json.dumps({
        "rooms": [{"types": ["bathroom"], "count": 1}],
        "views": {"count": 4, "resolution": list(size)},
        "budget": {"samples": samples},
    }))  # fmt: skip
    before = _of_children()
    orusd("dataset", "run", file, "-o", out)
    return out, (_of_children() - before) / 4


def _of_children() -> float:
    found = os.times()
    return found.children_user + found.children_system


def model(views: int, ms: Mapping[str, float], assumed: Mapping[str, float]) -> dict[str, float]:
    """What so many views take.

    Args:
        views: How many.
        ms: Milliseconds a view of each step.
        assumed: What is not measured, by name.
    """
    core_hours = views * assumed["core_s_a_view"] / 3600.0
    machines = math.ceil(core_hours / (assumed["hours"] * assumed["cores_a_machine"]))
    terabytes = views * assumed["MB_a_view"] / 1e6
    files = views * (assumed["files_a_view"] + 2)
    one_machine = ("plan", "status", "finish", "run again")
    return {
        "core_hours": core_hours,
        "machines": machines,
        "tasks_a_second": views / VIEWS_OF_A_JOB / (assumed["hours"] * 3600.0),
        "driver_busy_percent": 100.0 * views * ms["hand out, ray"] / 3.6e6 / assumed["hours"],
        "driver_minutes_besides": views * sum(ms[name] for name in one_machine) / 6e4,
        "TB": terabytes,
        "GB_of_records": views * assumed["KiB_of_records_a_view"] * 1024 / 1e9,
        "million_objects": files / 1e6,
        "$_computing": core_hours * assumed["$_a_core_hour"],
        "$_putting": files / 1e3 * assumed["$_a_thousand_puts"],
        "$_keeping_a_month": terabytes * 1e3 * assumed["$_a_GB_month"],
    }


@click.command(help=__doc__)
@click.option("--views", type=int, default=1_000_000, show_default=True)
@click.option("--sizes", default="10000,100000", show_default=True, help="Of synthetic datasets.")
@click.option("--tasks", type=int, default=2000, show_default=True, help="That do nothing.")
@click.option("--size", type=(int, int), default=(160, 120), show_default=True)
@click.option("--samples", type=int, default=16, show_default=True)
@click.option("--core-s-a-view", type=float, help="By default as long as the room here takes.")
@click.option("--mb-a-view", type=float, help="By default as the room here has.")
@click.option("--files-a-view", type=int, help="By default as the room here has.")
@click.option("--hours", type=float, default=24.0, show_default=True, help="Until all is there.")
@click.option("--cores-a-machine", type=int, default=32, show_default=True)
@click.option("--core-hour", type=float, default=0.04, show_default=True, help="Dollars.")
@click.option("--gb-month", type=float, default=0.023, show_default=True, help="Dollars.")
@click.option("--thousand-puts", type=float, default=0.005, show_default=True, help="Dollars.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(**given: Any) -> None:
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        example, seconds = measure_room(folder, given["size"], given["samples"])
        for views in map(int, given["sizes"].split(",")):
            rows += measure_steps(folder, example, views)
        rows += [measure_handing(executor, given["tasks"]) for executor in ("local", "ray")]
        record = next(path for path in example.glob("records/*/*/view_0.json"))
        files = json.loads(record.read_text())["files"]
        kib = (record.stat().st_size + 300) / 1024
    assumed = {
        "core_s_a_view": given["core_s_a_view"] or seconds,
        "MB_a_view": given["mb_a_view"] or sum(file["bytes"] for file in files.values()) / 1e6,
        "files_a_view": given["files_a_view"] or len(files),
        "KiB_of_records_a_view": kib,
        "hours": given["hours"],
        "cores_a_machine": given["cores_a_machine"],
        "$_a_core_hour": given["core_hour"],
        "$_a_GB_month": given["gb_month"],
        "$_a_thousand_puts": given["thousand_puts"],
    }
    found = model(given["views"], {row["step"]: row["ms_a_view"] for row in rows}, assumed)
    steps = table(
        ("step", "views", "ms a view", "MiB"),
        [(row["step"], row["views"], row["ms_a_view"], row.get("MiB")) for row in rows],
    )
    sides = [table(("what", "how much"), list(side.items())) for side in (assumed, found)]
    data = {"steps": rows, "assumed": assumed, "model": {"views": given["views"], **found}}
    publish("scale", data, "\n\n".join((steps, *sides)), given["target"])


if __name__ == "__main__":
    main()
