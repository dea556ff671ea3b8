"""Words in files beside a scan, by the numbers of its instances or of its classes."""

from pathlib import Path

import numpy as np

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.segmentation.labelled import with_labels
from orusd_scans.records.fields import text
from orusd_scans.records.jsonfile import read_json


def classified(cloud: Cloud, path: Path) -> Cloud:
    """A cloud whose labels are the numbers of another list of classes than NYU40's.

    Raises:
        InputError: The cloud has no labels, or the file is no table of words.
    """
    if cloud.label is None:
        raise InputError("the scan has no labels that could have classes", place=path)
    table = {number: words[0] for number, words in read_words(path).items()}
    numbers, of_point = np.unique(cloud.label, return_inverse=True)
    names = np.array([table.get(number, "") for number in numbers.tolist()])
    return with_labels(cloud, names[of_point].tolist())


def read_words(path: Path) -> dict[int, tuple[str, ...]]:
    """Words by numbers, of instances or of classes.

    Raises:
        InputError: It is no such file.
    """
    node = read_json(path)
    words = node.value if isinstance(node.value, dict) else {}
    if not words or not all(key.isdecimal() and len(key) < 9 for key in words):
        raise node.error("this is no table of words by numbers", 'write {"13": "trash can"}')
    return {int(key): (text(node.need(key)),) for key in words}
