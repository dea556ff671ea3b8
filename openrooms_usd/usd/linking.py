"""Light linking: which surfaces a light lights."""

from collections.abc import Iterable
from typing import Any, Final

from pxr import Sdf, Usd, UsdLux

from openrooms_usd.usd.emitters import DistantLight, DomeLight, Light


class LightLinks:
    """What the collections ``lightLink`` of the lights of a stage leave out.

    Args:
        stage: The stage.
        lights: Its lights; those from afar light everything.
    """

    def __init__(self, stage: Usd.Stage, lights: Iterable[Light]) -> None:
        self._queries = {
            light.path: UsdLux.LightAPI(stage.GetPrimAtPath(light.prim))
            .GetLightLinkCollectionAPI()
            .ComputeMembershipQuery()
            for light in lights
            if not isinstance(light, DomeLight | DistantLight)
        }
        for path, query in tuple(self._queries.items()):
            if includes_all(query):
                del self._queries[path]

    def unlit_by(self, path: str) -> tuple[str, ...]:
        """The lights that do not light a prim; of what an instancer scatters, its own path counts.

        Args:
            path: The prim's path, perhaps with the numbers of instances.
        """
        if not self._queries:
            return ()
        prim = Sdf.Path(path.partition("[")[0])
        return tuple(
            light for light, query in self._queries.items() if not query.IsPathIncluded(prim)
        )


def includes_all(query: Any) -> bool:
    """Whether a collection is the whole stage, as it is where nobody wrote one."""
    return bool(query.GetAsPathExpansionRuleMap() == _EVERYTHING)


_EVERYTHING: Final = {Sdf.Path.absoluteRootPath: Usd.Tokens.expandPrims}
