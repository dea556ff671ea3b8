"""Train on views: a small network learns the depth of a room from its light, in fifty steps.

Run: python examples/07_train.py OUT
"""

import sys
from pathlib import Path

import torch
from torch import nn

import openrooms_usd as ou
from openrooms_usd import loading


def main(out: Path) -> None:
    scene = ou.compose(ou.copy_example(out / "source"), out)
    render = ou.render(scene, channels=["radiance", "depth"], resolution=(96, 72), samples=8)
    # The camera, the depth and the light of a view are cropped and mirrored together.
    change = loading.Compose(
        [loading.HorizontalFlip(), loading.RandomCrop(64, 48), loading.Exposure()]
    )
    source = loading.open_source(render)
    views = loading.loader(source, ["radiance", "depth"], change, batch=4, seed=1)

    torch.manual_seed(0)
    network = nn.Sequential(
        nn.Conv2d(3, 16, 5, padding=2),
        nn.ReLU(),
        nn.Conv2d(16, 16, 3, padding=4, dilation=4),
        nn.ReLU(),
        nn.Conv2d(16, 16, 3, padding=8, dilation=8),
        nn.ReLU(),
        nn.Conv2d(16, 1, 1),
    )
    optimizer = torch.optim.Adam(network.parameters(), lr=3e-3)
    losses: list[float] = []
    while len(losses) < 50:
        views.dataset.set_epoch(len(losses))
        for batch in views:
            there = batch["depth"] > 0
            log_depth = network(torch.log1p(batch["radiance"]))
            loss = (log_depth[there] - torch.log(batch["depth"][there])).abs().mean()
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            losses.append(loss.item())

    first, last = sum(losses[:5]) / 5, sum(losses[-5:]) / 5
    told = f"{len(source)} views, {len(losses)} steps: log depth off by"
    print(f"{told} {first:.2f}, then {last:.2f}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/example_07"))
