"""What every part of a description has in common."""

from collections.abc import Iterator
from typing import Annotated, Any, NamedTuple, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

Number = Annotated[float, Field(strict=True)]
"""A number that is written as a number: neither text nor true or false."""

Whole = Annotated[int, Field(strict=True)]
"""A whole number that is written as one."""

Switch = Annotated[bool, Field(strict=True)]
"""true or false."""

PrimName = Annotated[
    str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=128, examples=["chair_2"])
]
"""A name that USD accepts for a prim."""


class FoundMistake(NamedTuple):
    """A mistake that concerns several fields.

    Attributes:
        path: Keys and list positions from the checked model to what is to blame.
        text: What is wrong, in one sentence.
    """

    path: tuple[str | int, ...]
    text: str


MISTAKE = "mistake"


class Model(BaseModel):
    """A frozen part of a description that refuses unknown keys and non-finite numbers."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


class CheckedModel(Model):
    """A part whose fields must also agree with each other.

    `disagreements` reads the data as it was given, so that it speaks beside the mistakes in single
    fields and not only after they were mended.
    """

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """What is wrong between the fields of ``given``: a mapping or a model, perhaps faulty."""
        raise NotImplementedError

    @model_validator(mode="wrap")
    @classmethod
    def _agreed(cls, given: Any, validate: ModelWrapValidatorHandler[Self]) -> Self:
        found = list(cls.disagreements(given))
        try:
            valid = validate(given)
        except ValidationError as error:
            raise ValidationError.from_exception_data(
                cls.__name__, [*_again(error), *_details(found)]
            ) from None
        if found:
            refuse(cls.__name__, found)
        return valid


def refuse(title: str, found: list[FoundMistake]) -> None:
    """Raise a `ValidationError` with all of these mistakes."""
    raise ValidationError.from_exception_data(title, _details(found))


def peek(given: Any, key: str) -> Any:
    """Look a field up in a mapping or a model that is not known to be valid; None where absent."""
    return given.get(key) if isinstance(given, dict) else getattr(given, key, None)


def peek_list(given: Any, key: str) -> list[Any]:
    """Like `peek`, but always a list: empty where there is none."""
    value = peek(given, key)
    return list(value) if isinstance(value, (list, tuple)) else []


def peek_text(given: Any, key: str) -> str | None:
    """Like `peek`, but None for everything that is not text."""
    value = peek(given, key)
    return value if isinstance(value, str) else None


def by_source(default: str, **implied: str) -> Discriminator:
    """Choose between sources by the key ``from``.

    Args:
        default: The source where nothing else says it.
        **implied: A key that implies a source where ``from`` is absent.
    """

    def choose(given: Any) -> str | None:
        if isinstance(given, Model):
            return str(peek(given, "source"))
        if not isinstance(given, dict):
            return None
        if "from" in given:
            return str(given["from"])
        return next((source for key, source in implied.items() if key in given), default)

    return Discriminator(choose)


def _details(found: list[FoundMistake]) -> list[InitErrorDetails]:
    return [
        InitErrorDetails(type=PydanticCustomError(MISTAKE, text), loc=path, input=None)
        for path, text in found
    ]


def _again(error: ValidationError) -> Iterator[InitErrorDetails]:
    """The mistakes of an error in the form that makes a new one."""
    for row in error.errors(include_url=False):
        ours = row["type"] == MISTAKE
        kind = PydanticCustomError(MISTAKE, row["msg"]) if ours else row["type"]
        yield InitErrorDetails(
            type=kind, loc=row["loc"], input=row["input"], ctx={} if ours else row.get("ctx", {})
        )
