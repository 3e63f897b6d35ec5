"""The few errors a user can cause. The command line prints each as one line and exits with 2."""


class SynthdepthError(Exception):
    """The user gave something unusable; the message says what was given and what is allowed."""


class RecipeError(SynthdepthError):
    """A map recipe is malformed: names the file, the key, the value and what is allowed."""


class DatasetError(SynthdepthError):
    """A dataset folder is missing, broken, or holds something else than was asked for."""


class FlightError(SynthdepthError):
    """No flight could be found in a scene after the allowed number of draws."""


class BackendError(SynthdepthError):
    """The rendering backend asked for does not work on this machine."""
