"""Exceptions, by what was wrong. All are `overcoat.Error`, but for those of the system: a file that is not there is a
`FileNotFoundError`, as everywhere in Python."""

from __future__ import annotations

from typing import Any


class Error(Exception):
    """What overcoat refuses or cannot do. The message is one sentence that names what was wrong and what is allowed."""


class LoadError(Error):
    """A model, an environment, a material or a scene file that is damaged, of no known format, or refers to files that it must
    not read."""


class LimitError(Error):
    """More than a limit allows. Limits are bounds on hostile input; `limits={field: value}` raises one.

    Attributes:
        field: Name of the limit, as in `limits=`.
        limit: How much it allows; `None` where that is not one number.
        asked: How much there would have been, if that is known.
    """

    def __init__(
        self, message: str, field: str = "", limit: int | None = None, asked: int | None = None
    ) -> None:
        super().__init__(message)
        self.field = field
        self.limit = limit
        self.asked = asked

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (str(self), self.field, self.limit, self.asked))


class OptionError(Error, ValueError):
    """An option with a value that it cannot have, or that the model has no part for: an animation, a camera, a material."""


class UnknownOptionError(Error, TypeError):
    """An option that does not exist."""


class MeshError(Error, ValueError):
    """Arrays that are no mesh, no texture or no picture: another shape, another type, a number that is none, an index beyond
    the vertices."""


class RenderError(Error):
    """A picture that cannot be drawn for a reason that is none of the others."""


class HandleError(Error, LookupError):
    """A handle of something that has been removed from its scene, or that is of another scene; or something that cannot be removed,
    as something else needs it."""


class Cancelled(Error):
    """A picture that `Viewport.cancel` has stopped. The array may hold parts of it."""


class OutputError(Error):
    """A picture that a file format cannot hold."""


class GoldenError(Error):
    """Pictures that cannot be compared."""


class Mismatch(GoldenError, AssertionError):
    """A picture that differs from the expected one, that has none, or that was recorded as one just now."""


class OvercoatWarning(UserWarning):
    """What a file asks for and the picture does not show, in one sentence. Also in `Image.warnings`."""


class MissingFeatureWarning(OvercoatWarning):
    """What another library would have drawn and overcoat does not, in `overcoat.compat`."""
