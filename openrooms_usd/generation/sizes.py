"""How large things are: about as the library says, a little more or less."""

import numpy as np

from openrooms_usd.furniture import MIN_SIDE, Size, category


def drawn_size(
    rng: np.random.Generator,
    name: str,
    usual: Size,
    given: tuple[float | None, float | None, float | None],
    modesty: float = 0.0,
) -> Size:
    """A size in a category's usual range, to the centimetre (below 10 cm to the millimetre).

    Args:
        rng: Draws it.
        name: The category.
        usual: Its usual size, metres.
        given: Sides that are decided already, metres.
        modesty: 1 draws no side larger than usual.
    """
    known, sides = category(name), []
    for side, share, wanted in zip(usual, known.size_variation, given, strict=True):
        drawn = side * (1.0 + float(rng.uniform(-share, share * (1.0 - modesty))))
        sides.append(
            max(MIN_SIDE, round(drawn if wanted is None else wanted, 3 if side < 0.1 else 2))
        )
    if known.round and usual[0] == usual[1]:
        sides[1] = sides[0]
    return sides[0], sides[1], sides[2]
