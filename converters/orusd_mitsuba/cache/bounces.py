"""Light that goes from surfel to surfel: a sparse product for every scattering."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from orusd_mitsuba.cache.links import LINKED_VERTICES, Found

Floats = NDArray[np.float32]


class Transport:
    """What surfels receive of what surfels receive, as sparse matrices.

    Args:
        links: All of them.
        count: Surfels.
        elsewhere: The light that has come in through no opening: where a link crosses one, it
            belongs to that.
    """

    def __init__(self, links: Found, count: int, elsewhere: int) -> None:
        self._elsewhere = elsewhere
        self._all, self._crossing = [], []
        for vertex in range(LINKED_VERTICES):
            here = links.vertex == vertex
            self._all.append(_matrices(links, here, count))
            openings = np.unique(links.crossed[here])
            self._crossing.append(
                {int(n): _matrices(links, here & (links.crossed == n), count) for n in openings}
            )

    def __call__(self, vertex: int, irradiance: Floats, into: Floats) -> None:
        """Add what arrives by links of a vertex.

        Args:
            vertex: Of paths, from 0.
            irradiance: (N, L, 3) of the surfels that are met.
            into: (N, L, 3) receives it.
        """
        for color in range(3):
            into[:, : self._elsewhere, color] += (
                self._all[vertex][color] @ irradiance[:, : self._elsewhere, color]
            )
            for opening, matrices in self._crossing[vertex].items():
                into[:, opening, color] += matrices[color] @ irradiance[:, self._elsewhere, color]


def _matrices(links: Found, which: NDArray[np.bool_], count: int) -> list[Any]:
    """By colour."""
    from scipy.sparse import csr_matrix

    places = links.row[which], links.column[which]
    return [
        csr_matrix((links.weight[which, color], places), shape=(count, count)) for color in range(3)
    ]


def bounced(straight: Floats, transport: Transport, scatterings: int) -> Floats:
    """What surfels receive of each light, with all scatterings up to some number.

    Args:
        straight: (orders, N, L, 3) what lights send by paths of so many scatterings.
        transport: What surfels send to each other.
        scatterings: S, at most.

    Returns:
        (N, S + 1, L, 3) with at most S scatterings, with one less, and so on to none.
    """
    found: list[Floats] = []
    for number in range(scatterings + 1):
        here = straight[number].copy()
        for vertex in range(min(number, LINKED_VERTICES)):
            transport(vertex, found[number - vertex - 1], here)
        found.append(here)
    return np.ascontiguousarray(np.cumsum(found, axis=0)[::-1].swapaxes(0, 1))
