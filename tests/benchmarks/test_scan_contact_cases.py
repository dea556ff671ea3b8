"""The hard cases of furniture as bodies: what they are in truth, and one of them from a scan."""

from dataclasses import replace

import pytest

pytest.importorskip("fcl")
pytest.importorskip("embreex")

from benchmarks.scan import contact_cases as scan_contact_cases
from benchmarks.scan.built import built
from benchmarks.scan.contact_cases import CONTACT_CASES, OUTLINE, contact_cases
from benchmarks.scan.contacts import contacts


@pytest.mark.parametrize("name", CONTACT_CASES)
def test_nothing_is_wrong_in_truth_but_what_is_said_to_be(name: str) -> None:
    case = CONTACT_CASES[name]
    truth = built(OUTLINE, things=case.things).truth
    found = contacts(truth.objects, truth.cads, truth.rooms, truth.objects)
    assert all(depth <= 0.0005 for _, _, depth in found.penetrations)
    alone = contacts(truth.objects, truth.cads, truth.rooms)
    outside = {number for number, depth in alone.in_walls.items() if depth > 0.01}
    assert outside == case.impossible


@pytest.mark.slow
def test_a_case_is_scanned_aligned_and_placed(monkeypatch: pytest.MonkeyPatch) -> None:
    small = replace(scan_contact_cases.SCANNER, frames=12, reduce=6, voxel=0.02)
    monkeypatch.setattr(scan_contact_cases, "SCANNER", small)
    chosen = {"chairs": scan_contact_cases.CONTACT_CASES["chairs under a table"]}
    monkeypatch.setattr(scan_contact_cases, "CONTACT_CASES", chosen)
    (row,) = contact_cases(quick=False)
    assert row["case"] == "chairs" and row["objects"] == 4
    assert row["pairs_deep"] == row["in_walls"] == row["floating"] == 0
    assert row["placed_tight"] >= row["measured_tight"]
