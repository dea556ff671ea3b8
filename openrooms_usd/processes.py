"""Whether a process of this machine is there; asking does nothing to it, on any system."""

import ctypes
import os
import sys
from typing import Any, Final

# Of Windows: what is asked for, and what it answers.
_SYNCHRONIZE: Final = 0x0010_0000
_NO_SUCH_PROCESS: Final = 87
_STILL_RUNS: Final = 0x102


def is_running(pid: int) -> bool:
    """Whether a process runs; true if unknown."""
    if sys.platform == "win32":  # signal 0 is Ctrl-C there
        return _is_running_on_windows(pid)
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True


def _is_running_on_windows(pid: int) -> bool:
    api: Any = ctypes
    kernel = api.WinDLL("kernel32", use_last_error=True)
    kernel.OpenProcess.restype = ctypes.c_void_p
    handle = kernel.OpenProcess(_SYNCHRONIZE, False, ctypes.c_uint32(pid))
    if not handle:
        return bool(api.get_last_error() != _NO_SUCH_PROCESS)
    process = ctypes.c_void_p(handle)
    try:
        return bool(kernel.WaitForSingleObject(process, 0) == _STILL_RUNS)
    finally:
        kernel.CloseHandle(process)
