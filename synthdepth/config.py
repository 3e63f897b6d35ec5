"""Checked configuration: frozen dataclasses whose fields say what they allow.

A config class inherits from `Config`; its fields are made by `number`, `span`, `choice` or
`choices`. Values are checked on construction, and TOML tables are read into them with errors that
name the key, the value and what is allowed.
"""

import dataclasses
import json
import math
import reprlib
import tomllib
from collections.abc import Mapping
from typing import Any

from synthdepth.errors import RecipeError

# Keys with many dots take tomllib time that grows with their square; no file of ours comes near.
_MOST_TOML, _MOST_TOML_LINE = 65_536, 4096

_short = reprlib.Repr()
_short.maxstring = _short.maxother = 100
_short.maxlist = _short.maxtuple = _short.maxdict = 8


def shown(value: Any) -> str:
    """A value as an error names it: as Python writes it, but short and on one line."""
    return _short.repr(value)


def shown_key(key: str) -> str:
    """A key as it stands in a file, or, where that is no word, as Python writes it."""
    return key if key.isidentifier() and len(key) <= 100 else shown(key)


def parse_json(text: str | bytes) -> Any:
    """The value of a JSON text; ValueError where it is none, or nested too deep."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None


def parse_toml(text: str) -> dict[str, Any]:
    """The table of a TOML text; ValueError where it is none, nested too deep or too long."""
    if len(text) > _MOST_TOML or max(map(len, text.splitlines()), default=0) > _MOST_TOML_LINE:
        raise ValueError(
            f"it is too long: allowed are {_MOST_TOML} characters, {_MOST_TOML_LINE} in a line"
        )
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deep") from None


def number(default, low, high):
    """A field that holds one number within [low, high]; an int default allows only ints.

    With `None` as default the number may be left out.
    """
    return dataclasses.field(default=default, metadata={"within": (low, high)})


def span(default, low, high):
    """A field that holds a range (from, to) to draw from, itself within [low, high]."""
    return dataclasses.field(default=tuple(default), metadata={"span": (low, high)})


def choice(default: str, allowed: tuple[str, ...]):
    """A field that holds one of a few words."""
    return dataclasses.field(default=default, metadata={"choice": allowed})


def choices(default: tuple[str, ...], allowed: tuple[str, ...], *, least: int = 0):
    """A field that holds a list of such words, at least `least` of them."""
    metadata = {"choices": allowed, "least": least}
    return dataclasses.field(default=tuple(default), metadata=metadata)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Config:
    """Base of the checked configurations."""

    def __post_init__(self):
        for field in dataclasses.fields(self):
            value = _checked(field.name, getattr(self, field.name), field)
            object.__setattr__(self, field.name, value)

    @classmethod
    def from_table(cls, table: Any, where: str) -> "Config":
        """The config of a TOML table.

        Args:
            table: what the file holds.
            where: file and section, for the error.

        Raises:
            RecipeError: an unknown key, a wrong type or a value out of range.
        """
        if not isinstance(table, Mapping):
            raise RecipeError(f"{where} is {shown(table)}: allowed is a table of keys")
        known = [field.name for field in dataclasses.fields(cls)]
        for key in table:
            if key not in known:
                raise RecipeError(
                    f"{where} {shown_key(key)} is unknown: allowed are {', '.join(known)}"
                )
        try:
            return cls(**table)
        except RecipeError as error:
            raise RecipeError(f"{where} {error}") from None


def _is_number(value) -> bool:
    # Not math.isfinite, which refuses whole numbers of more than 308 digits with an error.
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < math.inf


def _checked(name: str, value, field: dataclasses.Field):
    if "choice" in field.metadata:
        allowed = field.metadata["choice"]
        if value not in allowed:
            raise RecipeError(f"{name} = {shown(value)}: allowed are {', '.join(allowed)}")
        return value
    if "choices" in field.metadata:
        allowed, least = field.metadata["choices"], field.metadata["least"]
        words = list(value) if isinstance(value, list | tuple) else [value]
        if len(words) < least or any(word not in allowed for word in words):
            some = f"at least {least} of " if least else ""
            raise RecipeError(
                f"{name} = {_shown(value)}: allowed is a list of {some}{', '.join(allowed)}"
            )
        return tuple(words)
    if "span" in field.metadata:
        low, high = field.metadata["span"]
        pair = list(value) if isinstance(value, list | tuple) else []
        if (
            len(pair) != 2
            or not all(map(_is_number, pair))
            or not low <= pair[0] <= pair[1] <= high
        ):
            raise RecipeError(
                f"{name} = {_shown(value)}: allowed are two numbers [from, to] with "
                f"{low:g} <= from <= to <= {high:g}"
            )
        return (float(pair[0]), float(pair[1]))
    if "within" in field.metadata:
        if value is None and field.default is None:
            return None
        low, high = field.metadata["within"]
        whole = isinstance(field.default, int)
        right = _is_number(value) and (isinstance(value, int) or not whole)
        if not right or not low <= value <= high:
            kind = "a whole number" if whole else "a number"
            raise RecipeError(
                f"{name} = {_shown(value)}: allowed is {kind} from {low:g} to {high:g}"
            )
        return value if whole else float(value)
    return value


def _shown(value) -> str:
    return shown(list(value) if isinstance(value, tuple) else value)
