"""The state, the requests and the commands of a page in the browser."""

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Generic, TypeVar

from openrooms_usd.description.model import Model

Given = TypeVar("Given", bound=Model)

# Who reads or writes a stage holds it: layers are shared by all pages of a process, and USD allows
# no thread to read what another one changes.
STAGES: Final = threading.Lock()


class Nothing(Model):
    """What comes with a command that needs nothing to be said."""


@dataclass(frozen=True)
class Command(Generic[Given]):
    """Something that a person does in a page.

    Attributes:
        model: What comes with it; anything else is refused.
        run: Does it, and returns the answer for the page. An `OrusdError` is shown to the user.
    """

    model: type[Given]
    run: Callable[[Given], Mapping[str, Any]]


@dataclass(frozen=True)
class App:
    """A page and all that it can reach.

    Attributes:
        page: The module in ``page/`` whose ``start(root)`` fills the page, without its suffix.
        title: Of the page.
        state: The state when the page opens, as JSON.
        resources: Larger things by name; made when they are asked for.
        commands: What may be done, by name. They run one at a time.
        watched: Files; when one of them changes, the page receives ``changed`` with its name.
        live: As resources, but only while the page is served: a page in a file does not hold them.
    """

    page: str
    title: str
    state: Callable[[], Mapping[str, Any]]
    resources: Mapping[str, Callable[[], bytes]] = field(default_factory=dict)
    commands: Mapping[str, Command[Any]] = field(default_factory=dict)
    watched: tuple[Path, ...] = ()
    live: Mapping[str, Callable[[], bytes]] = field(default_factory=dict)
