"""Collision shapes that other processes search are those that are searched here."""

import sys

import numpy as np
import pytest
import trimesh

from openrooms_usd.physics.components import Part
from openrooms_usd.physics.decomposition import collision_shapes
from openrooms_usd.stages.physics import ahead
from openrooms_usd.stages.physics.ahead import Search, search_ahead
from openrooms_usd.stages.physics.cache import cached_shapes, is_missing


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


def test_each_process_leaves_its_share_in_the_cache(monkeypatch):
    mine = []
    monkeypatch.setattr(ahead, "_search", mine.extend)
    search_ahead(searches(), 2)
    assert len(mine) == 1
    away = [search for search in searches() if not is_missing(*search)]
    assert [search.triangles for search in away] == [min(s.triangles for s in searches())]
    found, here = cached_shapes(*away[0]), collision_shapes(*away[0])
    assert found.error == here.error
    for a, b in zip(found.shapes, here.shapes, strict=True):
        assert a.mesh.points.tobytes() == b.mesh.points.tobytes()
        assert (a.contact, a.parts, a.box) == (b.contact, b.parts, b.box)


def test_without_other_processes_the_rest_is_searched_where_it_is_needed(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    search_ahead(searches(), 2)
    assert sorted(is_missing(*search) for search in searches()) == [False, True]


def test_a_process_that_fails_leaves_the_rest_to_be_searched(monkeypatch):
    monkeypatch.setattr(ahead, "_bytes", lambda share: b"nothing that could be read")
    search_ahead(searches(), 2)
    assert sorted(is_missing(*search) for search in searches()) == [False, True]


def test_nothing_is_started_for_one_worker_or_for_what_is_there(monkeypatch):
    monkeypatch.setattr(ahead, "_started", lambda share: pytest.fail("it was started"))
    search_ahead(searches(), 1)
    assert all(is_missing(*search) for search in searches())
    for search in searches():
        cached_shapes(*search)
    search_ahead(searches(), 2)


def test_the_longest_search_stands_alone():
    part = Part("ring", np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    sizes = [5, 1, 4, 10]
    rows = [Search([part, part], "auto", 0.01) for _ in sizes]
    for row, size in zip(rows, sizes, strict=True):
        row.parts[0] = Part("ring", np.zeros((0, 3)), np.zeros((size, 3), np.int32))
    shares = ahead._shared(rows, 2)
    assert [[search.triangles for search in share] for share in shares] == [[10], [5, 4, 1]]
