"""A small alphabet of 3 x 5 dots, for the few words on pictures that people look at."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

# Five rows from the top, three dots each, as octal digits.
_GLYPHS: Final = {
    "A": "25755", "B": "65656", "C": "34443", "D": "65556", "E": "74647", "F": "74644",
    "G": "34553", "H": "55755", "I": "72227", "J": "11152", "K": "55655", "L": "44447",
    "M": "57755", "N": "65555", "O": "25552", "P": "65644", "Q": "25563", "R": "65655",
    "S": "34216", "T": "72222", "U": "55557", "V": "55552", "W": "55775", "X": "55255",
    "Y": "55222", "Z": "71247", "0": "75557", "1": "26227", "2": "71747", "3": "71717",
    "4": "55711", "5": "74717", "6": "74757", "7": "71122", "8": "75757", "9": "75717",
    ".": "00002", ",": "00024", ":": "02020", "-": "00700", "+": "02720", "%": "51245",
    "/": "11244", "_": "00007", "(": "24442", ")": "21112", "=": "07070",
}  # fmt: skip
_ROWS: Final = 5
_COLUMNS: Final = 3


def lettered(text: str, size: int) -> NDArray[np.bool_]:
    """A line of text as dots.

    Args:
        text: Capitals and small letters look the same; what the alphabet lacks is a gap.
        size: Pixels of a dot's side.

    Returns:
        (5 size, 4 size len(text)) where ink is.
    """
    dots = np.zeros((_ROWS, (_COLUMNS + 1) * len(text)), dtype=np.bool_)
    for place, letter in enumerate(text.upper()):
        for row, digit in enumerate(_GLYPHS.get(letter, "")):
            for column in range(_COLUMNS):
                ink = int(digit, 8) >> (_COLUMNS - 1 - column) & 1
                dots[row, place * (_COLUMNS + 1) + column] = bool(ink)
    return np.repeat(np.repeat(dots, size, axis=0), size, axis=1)
