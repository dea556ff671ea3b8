"""Batches of torch: what is in them, and the same for any number of workers."""

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.loading.opening import open_source
from openrooms_usd.loading.sample import Sample
from openrooms_usd.loading.transforms import Compose, Exposure, HorizontalFlip, RandomCrop

PAGE = Path(__file__).parents[2] / "docs/howto/loading.md"
CHANNELS = ("radiance", "depth", "position", "instance")
CHANGE = Compose([HorizontalFlip(), RandomCrop(16, 12)])


@dataclass(frozen=True)
class Several:
    """Views of different sources, one after the other."""

    samples: tuple[Sample, ...]

    def __len__(self) -> int:
        return len(self.samples)

    def read(self, index: int, channels: object) -> Sample:
        return self.samples[index]


@pytest.fixture(autouse=True)
def needs(torch: ModuleType) -> None:
    """All of them do."""


def batches(loader: Any, epochs: int = 2) -> Iterator[dict[str, Any]]:
    for epoch in range(epochs):
        loader.dataset.set_epoch(epoch)
        yield from loader


def equal(one: Any, other: Any) -> bool:
    if isinstance(one, list):
        return bool(one == other)
    return bool((one == other).all()) and one.dtype == other.dtype


def test_a_batch_has_tensors_of_the_channels(sample: Sample, torch: ModuleType) -> None:
    from openrooms_usd.loading.training import loader

    (batch,) = loader(Several((sample, sample)), (), batch=2, shuffle=False)
    lamps = len(sample.light_numbers)
    shapes = {
        "radiance": (2, 3, 36, 48),
        "depth": (2, 1, 36, 48),
        "semantic": (2, 36, 48),
        "radiance_i": (2, lamps, 3, 36, 48),
        "mask_i": (2, lamps, 1, 36, 48),
        "environment": (2, 9, 12, 16, 32, 3),
        "K": (2, 3, 3),
        "world_from_camera": (2, 4, 4),
        "world_from_box": (2, lamps, 4, 4),
        "light_mask": (2, lamps),
    }
    assert {name: tuple(batch[name].shape) for name in shapes} == shapes
    assert batch["semantic"].dtype == batch["instance"].dtype == torch.int64
    floats = ("radiance", "radiance_i", "K", "world_from_camera", "light_scale")
    assert {batch[name].dtype for name in floats} == {torch.float32}
    assert batch["light_mask"].all() and batch["name"] == ["view_0", "view_0"]
    for name, row, column in (("radiance", 3, 7), ("position", 30, 40)):
        pixel = sample.images[name][row, column]
        np.testing.assert_array_equal(batch[name][1, :, row, column].numpy(), pixel)
    light = sample.lights["radiance_i"][lamps - 1, 5, 6]
    np.testing.assert_array_equal(batch["radiance_i"][0, lamps - 1, :, 5, 6].numpy(), light)


def test_lights_are_filled_up_and_told(sample: Sample, torch: ModuleType) -> None:
    from dataclasses import replace

    from openrooms_usd.loading.tensors import collate, tensors_of

    two = replace(
        sample,
        lights={name: lights[:2] for name, lights in sample.lights.items()},
        light_numbers=sample.light_numbers[:2],
        world_from_box=sample.world_from_box[:2],
        box_size=sample.box_size[:2],
    )
    lamps = len(sample.light_numbers)
    assert lamps > 2
    batch = collate([tensors_of(sample), tensors_of(two)])
    assert batch["light_mask"].sum(dim=1).tolist() == [lamps, 2]
    assert not batch["radiance_i"][1, 2:].any() and not batch["box_size"][1, 2:].any()
    # Lights that are none change no sum.
    whole = batch["radiance_i"].sum(dim=1)
    torch.testing.assert_close(whole[0], batch["radiance"][0], rtol=1e-4, atol=1.0)


def test_rooms_with_and_without_lights_go_together(sample: Sample) -> None:
    from dataclasses import replace

    from openrooms_usd.loading.tensors import collate, tensors_of

    dark = replace(
        sample,
        lights={name: lights[:0] for name, lights in sample.lights.items()},
        light_numbers=(),
        world_from_box=sample.world_from_box[:0],
        box_size=sample.box_size[:0],
    )
    lamps = len(sample.light_numbers)
    batch = collate([tensors_of(dark), tensors_of(sample)])
    assert batch["light_mask"].sum(dim=1).tolist() == [0, lamps]
    assert batch["radiance_i"].shape[:2] == (2, lamps)
    alone = collate([tensors_of(dark)])
    assert alone["light_mask"].shape == (1, 0)


def test_what_does_not_go_together_is_told(sample: Sample) -> None:
    from openrooms_usd.loading.tensors import collate, tensors_of
    from openrooms_usd.loading.transforms import Crop

    part = Crop(0, 0, 24, 24)(sample, np.random.default_rng(0))
    with pytest.raises(InputError, match="in sizes"):
        collate([tensors_of(sample), tensors_of(part)])
    fewer = {name: value for name, value in tensors_of(sample).items() if name != "depth"}
    with pytest.raises(InputError, match="different channels"):
        collate([tensors_of(sample), fewer])


def test_epochs_and_seeds_draw_anew_and_the_same_again(dataset: Path) -> None:
    from openrooms_usd.loading.training import loader

    source = open_source(dataset)

    def seen(seed: int) -> list[dict[str, Any]]:
        return list(batches(loader(source, CHANNELS, CHANGE, batch=3, seed=seed)))

    one, again, other = seen(4), seen(4), seen(5)
    assert [len(batch["name"]) for batch in one] == [3, 3, 2] * 2
    for a, b in zip(one, again, strict=True):
        assert set(a) == set(b) and all(equal(a[name], b[name]) for name in a)
    names = [[name for batch in run for name in batch["name"]] for run in (one, other)]
    epochs = names[0][:8], names[0][8:]
    assert sorted(epochs[0]) == sorted(epochs[1]) == sorted(names[1][:8])
    assert epochs[0] != epochs[1] and names[0] != names[1]
    drawn = []
    for part in (one[:3], one[3:]):
        rows = [zip(b["name"], b["K"][:, 0, 2].tolist(), strict=True) for b in part]
        drawn.append({name: cx for row in rows for name, cx in row})
    assert drawn[0] != drawn[1]


@pytest.mark.slow
@pytest.mark.parametrize("start", ["spawn", "fork", "forkserver"])
def test_any_number_of_workers_gives_the_same(start: str, dataset: Path) -> None:
    """Also workers that are forks of a process which has read pictures itself."""
    from openrooms_usd.loading.training import loader

    source = open_source(dataset)
    alone = list(batches(loader(source, CHANNELS, CHANGE, batch=2, seed=1)))
    with warnings.catch_warnings():
        # Of forks beside threads, which is what is looked at here.
        warnings.simplefilter("ignore", DeprecationWarning)
        for workers in (1, 2):
            more = loader(
                source, CHANNELS, CHANGE, batch=2, seed=1, workers=workers, start=start, timeout=60
            )
            found = list(batches(more))
            for a, b in zip(alone, found, strict=True):
                assert all(equal(a[name], b[name]) for name in a)


def test_replicas_share_the_views(dataset: Path, torch: ModuleType) -> None:
    from openrooms_usd.loading.training import ViewDataset, loader

    source = open_source(dataset)
    shares = [
        [n for b in loader(source, ("valid",), rank=rank, replicas=3, seed=2) for n in b["name"]]
        for rank in range(3)
    ]
    assert [len(share) for share in shares] == [3, 3, 3]
    together = [name for share in shares for name in share]
    assert len(set(together)) == 8
    # The one that is there twice is the first of the order.
    assert max(set(together), key=together.count) == shares[0][0] == shares[2][-1]
    with pytest.raises(InputError, match="no replica 3 of 3"):
        loader(source, ("valid",), rank=3, replicas=3)
    views = ViewDataset(source, ("valid",))
    sampler = torch.utils.data.distributed.DistributedSampler(views, num_replicas=2, rank=1)
    assert len(list(torch.utils.data.DataLoader(views, sampler=sampler, batch_size=None))) == 4


def test_what_goes_wrong_in_a_view_is_told(dataset: Path) -> None:
    from openrooms_usd.loading.training import ViewDataset

    views = ViewDataset(open_source(dataset), ("depth",), Exposure())
    with pytest.raises(InputError, match="no radiance to expose by"):
        views[0]
    with pytest.raises(IndexError):
        views[8]


@pytest.mark.slow
def test_the_python_of_the_page_runs_in_order(
    dataset: Path,
    torch: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "homes").symlink_to(dataset)
    monkeypatch.chdir(tmp_path)
    shown = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    names: dict[str, object] = {}
    for block in shown:
        exec(block, names)
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("(192, 256, 3)")
    assert (
        said[-1] == "torch.Size([2, 3, 192, 256]) torch.Size([2, 192, 256]) torch.Size([2, 3, 3])"
    )
