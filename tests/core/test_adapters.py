"""Adapters are found by name, and the ones that are not found are explained."""

from importlib.metadata import EntryPoint

import pytest

from openrooms_usd import adapters
from openrooms_usd.errors import InputError, MissingPackageError


def test_our_adapters_are_registered() -> None:
    assert "roomplan" in adapters.available(adapters.IMPORTERS)
    assert "mitsuba" in adapters.available(adapters.RENDERERS)
    assert "mitsuba" in adapters.available(adapters.EXPORTERS)


def test_a_typo_gets_the_nearest_name() -> None:
    with pytest.raises(InputError, match="did you mean 'mitsuba'"):
        adapters.load(adapters.RENDERERS, "mitsubba")


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = EntryPoint("broken", "no_such_package_at_all:Thing", adapters.RENDERERS)
    monkeypatch.setattr(adapters, "available", lambda group: {"broken": broken})
    with pytest.raises(MissingPackageError, match="no_such_package_at_all"):
        adapters.load(adapters.RENDERERS, "broken")
