"""Ctrl-C while the main thread computes in a library that does not look at signals."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

# A command that claims a folder, begins a file and then computes without coming back to Python.
STUCK = """
import hashlib, signal, sys
from pathlib import Path
signal.signal(signal.SIGINT, signal.default_int_handler)  # also where tests run in the background
from openrooms_usd import atomic, claims
from openrooms_usd.cli.interruption import leave, prompt_interrupts

out = Path(sys.argv[1])
try:
    with prompt_interrupts(), claims.claimed(out), atomic.replacing(out / "picture.png") as beside:
        beside.write_bytes(b"half")
        print("ready", flush=True)
        {compute}
except KeyboardInterrupt:
    leave()
"""
# It releases Python's lock, as renderers do.
BLIND = "hashlib.pbkdf2_hmac('sha256', b'', b'', 2_000_000_000)"
AWAKE = "import time; time.sleep(60)"


def wait_until_busy(process: subprocess.Popen[str], *, computes: bool) -> None:
    """Return once it has computed for a tenth of a second since it was ready, or sleeps."""
    fields = Path(f"/proc/{process.pid}/stat")
    if not fields.exists():
        time.sleep(0.1)
        return
    begun = None
    while process.poll() is None:
        state, *rest = fields.read_text().rpartition(") ")[2].split()
        ticks = int(rest[10])
        begun = ticks if begun is None else begun
        if state == "S" if not computes else ticks >= begun + os.sysconf("SC_CLK_TCK") // 10:
            return
        time.sleep(0.005)


@pytest.mark.one_in(2)
@pytest.mark.skipif(sys.platform == "win32", reason="signals are others there")
@pytest.mark.parametrize("compute", [BLIND, AWAKE])
@pytest.mark.parametrize("is_there", [False, True])
def test_the_process_ends_soon_and_leaves_nothing(
    compute: str, is_there: bool, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    if is_there:
        out.mkdir()
        (out / "picture.png").write_bytes(b"earlier")
    command = [sys.executable, "-P", "-c", STUCK.format(compute=compute), str(out)]
    with subprocess.Popen(command, stdout=-1, stderr=-1, text=True) as process:
        assert process.stdout
        assert process.stdout.readline() == "ready\n"
        wait_until_busy(process, computes=compute == BLIND)
        process.send_signal(signal.SIGINT)
        # Far less than the computation takes, and far more than a busy machine may need.
        said = process.communicate(timeout=120)[1]
    assert process.returncode == 130
    assert said.strip() == "Interrupted. What was finished is kept."
    left = sorted(path.name for path in tmp_path.rglob("*"))
    assert left == (["out", "picture.png"] if is_there else [])
    if is_there:
        assert (out / "picture.png").read_bytes() == b"earlier"


def test_an_error_that_an_interruption_caused_is_none() -> None:
    code = """
import signal
from openrooms_usd.cli.interruption import prompt_interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)
with prompt_interrupts():
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise ImportError("while it was loaded")
"""
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True)
    assert done.returncode == 130
    assert done.stderr == "Interrupted. What was finished is kept.\n"


def test_what_ignores_ctrl_c_goes_on_ignoring_it() -> None:
    code = """
import signal
from openrooms_usd.cli.interruption import prompt_interrupts
signal.signal(signal.SIGINT, signal.SIG_IGN)
with prompt_interrupts():
    signal.raise_signal(signal.SIGINT)
print("still here")
"""
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True)
    assert done.stdout == "still here\n", done.stderr


def test_a_second_signal_hinders_nobody() -> None:
    code = """
import signal, time
from openrooms_usd.cli.interruption import leave, prompt_interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    with prompt_interrupts():
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            time.sleep(0.1)
            signal.raise_signal(signal.SIGINT)
            print("tidied up")
except KeyboardInterrupt:
    leave()
"""
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (130, "tidied up\n")
    assert done.stderr == "Interrupted. What was finished is kept.\n"


def test_modules_that_take_an_interruption_for_an_error_do_not_see_it(tmp_path: Path) -> None:
    signalled = "signal.raise_signal(signal.SIGINT)"
    swallowing = f"import signal\ntry:\n    {signalled}\nexcept BaseException:\n    print(1)"
    (tmp_path / "swallowing.py").write_text(swallowing)
    code = f"""
import signal, sys
from pathlib import Path
from openrooms_usd import atomic, claims
from openrooms_usd.cli.interruption import prompt_interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path.insert(0, {str(tmp_path)!r})
out = Path({str(tmp_path / "out")!r})
with prompt_interrupts(), claims.claimed(out), atomic.replacing(out / "picture.png") as beside:
    beside.write_bytes(b"half")
    import swallowing
"""
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "Interrupted. What was finished is kept.\n"
    assert not (tmp_path / "out").exists()
