"""Random numbers by name: what is drawn for one thing never depends on another."""

import hashlib
import json

import numpy as np


def generator(seed: int, *key: str | int) -> np.random.Generator:
    """A generator that depends on a seed and a key alone, on every machine.

    Args:
        seed: The room's.
        key: What is drawn, such as the stage and the object's name.
    """
    text = json.dumps([seed, *key]).encode()
    words = np.frombuffer(hashlib.sha256(text).digest(), dtype=np.uint32)
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(words.tolist())))
