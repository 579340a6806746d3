"""Exceptions and warnings of slipgrid."""

from __future__ import annotations

import errno
from typing import Any


class InputError(ValueError):
    """Input that was refused. The message is the line that the command line prints.

    Attributes
    ----------
    file, line, key, value, expected
        File, line and key of the input, the refused value, and accepted values; ``None`` where there is none.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        line: int | None = None,
        key: str | None = None,
        value: str | None = None,
        expected: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.key = key
        self.value = value
        self.expected = expected


class MissingFileError(FileNotFoundError, InputError):
    """A file that does not exist: an :class:`InputError` with the path in ``file``, and a ``FileNotFoundError``."""

    def __init__(self, message: str, *, file: str | None = None, **named: Any) -> None:
        InputError.__init__(self, message, file=file, **named)
        self.errno = errno.ENOENT
        self.filename = file

    def __str__(self) -> str:
        return str(self.args[0])


class TooLargeError(MemoryError, InputError):
    """An array that exceeds a limit or the memory, and was not copied: an :class:`InputError`, and a ``MemoryError``."""

    def __init__(self, message: str, **named: Any) -> None:
        InputError.__init__(self, message, **named)


class SlipgridWarning(UserWarning):
    """Doubtful input or a doubtful result, which the command line marks with ``warning:`` or ``!``."""


class CostWarning(SlipgridWarning):
    """A computation that takes more than half a minute or a gigabyte; given before it begins."""


class ComputationError(RuntimeError):
    """A computation that has no answer, with the reason."""
