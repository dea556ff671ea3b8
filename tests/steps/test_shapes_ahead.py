"""Collision shapes that other processes search are those that are searched here."""

import os
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from openrooms_usd.physics.components import Part
from openrooms_usd.physics.decomposition import collision_shapes
from openrooms_usd.steps.physics import ahead
from openrooms_usd.steps.physics.ahead import Search, search_ahead
from openrooms_usd.steps.physics.cache import cached_shapes, is_missing


def searches() -> list[Search]:
    meshes = [trimesh.creation.torus(0.3, 0.1, 24, 12), trimesh.creation.annulus(0.2, 0.4, 0.1)]
    return [
        Search([Part("ring", np.asarray(m.vertices), np.asarray(m.faces), "wood")], "auto", 0.01)
        for m in meshes
    ]


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("ORUSD_CACHE", str(tmp_path))
    monkeypatch.setattr(ahead, "_WORTH", 1)


@pytest.mark.slow
def test_what_one_process_takes_no_other_searches(monkeypatch):
    taken = []
    monkeypatch.setattr(ahead, "_search", lambda _, queue: taken.append(os.read(queue, 3)))
    search_ahead(searches(), 2)
    assert taken == [b"000"]
    away = [search for search in searches() if not is_missing(*search)]
    assert [search.triangles for search in away] == [min(s.triangles for s in searches())]
    found, here = cached_shapes(*away[0]), collision_shapes(*away[0])
    assert found.error == here.error
    for a, b in zip(found.shapes, here.shapes, strict=True):
        assert a.mesh.points.tobytes() == b.mesh.points.tobytes()
        assert (a.contact, a.parts, a.box) == (b.contact, b.parts, b.box)


def test_without_other_processes_all_is_searched_here(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    search_ahead(searches(), 2)
    assert not any(is_missing(*search) for search in searches())


def test_a_process_that_fails_takes_nothing(monkeypatch):
    monkeypatch.setattr(ahead, "_bytes", lambda _: b"nothing that could be read")
    search_ahead(searches(), 2)
    assert not any(is_missing(*search) for search in searches())


def test_windows_hands_no_pipe_down(monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(ahead, "_started", lambda *_: pytest.fail("it was started"))
    search_ahead(searches(), 2)
    assert all(is_missing(*search) for search in searches())


@pytest.mark.slow
def test_nothing_is_started_for_one_worker_or_for_what_is_there(monkeypatch):
    monkeypatch.setattr(ahead, "_started", lambda *_: pytest.fail("it was started"))
    search_ahead(searches(), 1)
    assert all(is_missing(*search) for search in searches())
    for search in searches():
        cached_shapes(*search)
    search_ahead(searches(), 2)


def test_the_longest_searches_come_first(monkeypatch):
    order = []
    monkeypatch.setattr(ahead, "_started", lambda *_: None)
    monkeypatch.setattr(ahead, "cached_shapes", lambda *search: order.append(Search(*search)))
    search_ahead(searches()[::-1] + searches()[:1], 2)
    assert [search.triangles for search in order] == sorted(
        (search.triangles for search in searches()[::-1] + searches()[:1]), reverse=True
    )


@pytest.mark.slow
def test_a_search_that_nothing_can_come_of_stops_no_other(monkeypatch):
    monkeypatch.setattr(ahead, "_started", lambda *_: None)
    empty = Part("nothing", np.zeros((500, 3)), np.zeros((1000, 3), np.int32))
    search_ahead([Search([empty], "auto", 0.01), *searches()], 2)
    assert not any(is_missing(*search) for search in searches())


def test_a_process_for_searches_starts_without_usd():
    told = "import openrooms_usd.steps.physics.ahead, sys; sys.exit('pxr' in sys.modules)"
    subprocess.run([sys.executable, "-c", told], check=True)


def test_a_process_ends_with_the_one_that_has_started_it():
    """It takes its work from a pipe that stays open, so nothing else would end it."""
    read, write = os.pipe()
    nobody = subprocess.Popen([sys.executable, "-c", ""])
    nobody.wait()
    told = ahead._bytes(searches())
    command = [sys.executable, "-P", "-m", ahead.__name__, str(read), str(nobody.pid)]
    done = subprocess.run(command, input=told, pass_fds=[read], timeout=60, check=False)
    assert done.returncode == 1
    os.close(read)
    os.close(write)
