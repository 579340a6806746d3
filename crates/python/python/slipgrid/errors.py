"""What slipgrid raises, and what it warns of."""

from __future__ import annotations

import errno
from typing import Any


class InputError(ValueError):
    """Input that was refused: which file, line and key, what stood there, and what would be accepted.

    Its text is the line that the command line prints; the parts stand in the attributes, ``None`` where there is no such part.
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
    """A file that is not there: :class:`InputError` with its path in ``file``, and Python's own ``FileNotFoundError``."""

    def __init__(self, message: str, *, file: str | None = None, **named: Any) -> None:
        InputError.__init__(self, message, file=file, **named)
        self.errno = errno.ENOENT
        self.filename = file

    def __str__(self) -> str:
        return str(self.args[0])


class TooLargeError(MemoryError, InputError):
    """An array that is larger than what is accepted, or than memory: :class:`InputError`, and Python's own ``MemoryError``. It was
    not copied."""

    def __init__(self, message: str, **named: Any) -> None:
        InputError.__init__(self, message, **named)


class SlipgridWarning(UserWarning):
    """What is doubtful in the input or in a result: the command line says it as ``warning:`` or marks it with ``!``."""


class CostWarning(SlipgridWarning):
    """A computation that takes more than half a minute or a gigabyte, told before it begins."""


class ComputationError(RuntimeError):
    """A computation that has no answer, with the reason."""
