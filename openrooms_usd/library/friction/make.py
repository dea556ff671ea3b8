"""Makes the shipped table again: ``python -m openrooms_usd.library.friction.make``."""

import io

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.library.friction.table import FILE, built


def table_bytes() -> bytes:
    """The file's bytes: numpy's own format, which holds no time and no machine."""
    buffer = io.BytesIO()
    np.save(buffer, built(), allow_pickle=False)
    return buffer.getvalue()


if __name__ == "__main__":
    atomic.write_bytes(FILE, table_bytes())
