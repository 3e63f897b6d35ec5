"""The few errors a user can cause. The command line prints each as one line and exits with 2."""

_LONGEST = 1000


class SynthdepthError(Exception):
    """The user gave something unusable; the message says what was given and what is allowed.

    As text it is one line without control characters, and not endless, whatever names and values
    are quoted in it.
    """

    def __str__(self) -> str:
        text = super().__str__()
        # Torch passes a worker's error on with the worker's whole traceback as its message.
        return text if "Traceback (most recent call last)" in text else _one_line(text)


def _one_line(text: str) -> str:
    line = " ".join(part.strip() for part in text.splitlines() if part.strip())
    if len(line) > _LONGEST:
        line = f"{line[: _LONGEST * 3 // 4]} ... {line[-_LONGEST // 5 :]}"
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)


class RecipeError(SynthdepthError):
    """A map recipe is malformed: names the file, the key, the value and what is allowed."""


class DatasetError(SynthdepthError):
    """A dataset folder is missing, broken, or holds something else than was asked for."""


class FlightError(SynthdepthError):
    """No flight could be found in a scene after the allowed number of draws."""


class BackendError(SynthdepthError):
    """The rendering backend asked for does not work on this machine."""
