"""The choice of a backend, in processes of their own: it is made once in each."""

import os
import subprocess
import sys

import pytest

from openrooms_usd.errors import RenderError
from orusd_mitsuba import MitsubaRenderer, llvm, variants


def python(code, **environment):
    return subprocess.run(
        [sys.executable, "-c", code],
        env=dict(os.environ) | environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()


@pytest.mark.slow
def test_importing_the_adapter_imports_no_renderer():
    loaded = python("import orusd_mitsuba, sys; print(*sys.modules)")
    assert "orusd_mitsuba" in loaded
    assert not {"mitsuba", "drjit", "pxr", "numpy.testing", "scipy"} & set(loaded)


@pytest.mark.slow
def test_without_a_usable_llvm_the_scalar_backend_is_chosen_with_advice():
    code = "from orusd_mitsuba import variants as v; b = v.choose(); print(b.variant, b.advice)"
    chosen, *advice = python(code, **{llvm.VARIABLE: "/nowhere/libLLVM.so"})
    assert chosen in ("scalar_rgb", "cuda_ad_rgb")
    said = " ".join(advice)
    if chosen == "scalar_rgb":
        assert "/nowhere/libLLVM.so" in said and "irradiance" in said
        assert f"unset the environment variable {llvm.VARIABLE}" in said


@pytest.mark.slow
def test_asking_for_llvm_where_there_is_none_names_the_remedy():
    code = (
        "from orusd_mitsuba import variants as v\n"
        "try: v.choose('llvm')\n"
        "except Exception as e: print(type(e).__name__, e.remedy)"
    )
    kind, *remedy = python(code, **{llvm.VARIABLE: "/nowhere/libLLVM.so"})
    assert kind == "RenderError"
    assert f"unset the environment variable {llvm.VARIABLE}" in " ".join(remedy)


def test_an_unknown_backend_is_refused_with_the_known_ones():
    with pytest.raises(RenderError, match="vulkan") as caught:
        variants.choose("vulkan")
    assert "scalar" in str(caught.value)


def test_the_diagnosis_names_every_backend():
    diagnosis = MitsubaRenderer().diagnose()
    assert set(diagnosis) == {"cuda", "llvm", "scalar", "auto"}
    assert all(diagnosis.values())
