"""Bits in a row: written and read from the most significant on, and malformed ones reported."""

from __future__ import annotations

from collections.abc import Callable

WORD = 2**32 - 1
"""The bits of a word, without its sign."""


class WireError(ValueError):
    """A message that can't be sent, or bytes that aren't a message of this strategy."""


class BitWriter:
    """Bits that are appended one number after the other.

    Examples
    --------
    >>> from feasibee.robot.bits import BitWriter
    >>> writer = BitWriter()
    >>> writer.number(5, 3)
    >>> writer.unary(2)
    >>> writer.length, writer.bytes().hex()
    (6, 'a4')
    """

    def __init__(self) -> None:
        self.length = 0
        """Number of bits written."""
        self._whole = bytearray()
        self._rest, self._rest_bits = 0, 0

    def number(self, number: int, bits: int) -> None:
        """Write a number of 0 to ``2**bits - 1``.

        Raises
        ------
        WireError
            If the number doesn't fit.
        """
        if number < 0 or number >> bits:
            raise WireError(f"{number} doesn't fit {bits} bits; it must be from 0 to {2**bits - 1}")
        self.length += bits
        self._rest = self._rest << bits | number
        self._rest_bits += bits
        whole, left = divmod(self._rest_bits, 8)
        if whole:
            self._whole += (self._rest >> left).to_bytes(whole, "big")
            self._rest &= (1 << left) - 1
            self._rest_bits = left

    def flag(self, flag: bool) -> None:
        """Write 1 bit: 1 for true."""
        self.number(int(flag), 1)

    def unary(self, number: int) -> None:
        """Write a number of at least 0 as so many bits 0 and a bit 1."""
        if number < 0:
            raise WireError(f"{number} has no unary code; it must be at least 0")
        self.number(1, number + 1)

    def rice(self, number: int, low: int) -> None:
        """Write a number of at least 0 in Rice's code: in unary down to ``low`` bits, then these."""
        self.unary(number >> low)
        self.number(number & ((1 << low) - 1), low)

    def word(self, word: int) -> None:
        """Write a word, from -2**31 to 2**32 - 1, as its 32 bits."""
        if not -(2**31) <= word <= WORD:
            raise WireError(f"{word} isn't a word; it must be from -2**31 to 2**32 - 1")
        self.number(word & WORD, 32)

    def bytes(self) -> bytes:
        """Return the bits as bytes, the last one filled up with bits 0."""
        if not self._rest_bits:
            return bytes(self._whole)
        return bytes(self._whole) + (self._rest << (8 - self._rest_bits)).to_bytes(1, "big")


class BitReader:
    """Bits that are read one number after the other.

    Parameters
    ----------
    data : bytes
        The bits; the last byte may be filled up with bits 0.
    task_of : callable, optional
        Given the name of a task, returns its id; by default the name is the id.
    """

    def __init__(self, data: bytes, task_of: Callable[[int], int] | None = None) -> None:
        self.place = 0
        """Number of bits read."""
        self._data = data
        self._task_of = task_of

    def number(self, bits: int) -> int:
        """Read a number of so many bits.

        Raises
        ------
        WireError
            If fewer bits are left.
        """
        end = self.place + bits
        if end > 8 * len(self._data):
            raise WireError(f"ends after {len(self._data)} bytes, within a number; send the message again")
        last = (end + 7) // 8
        number = int.from_bytes(self._data[self.place // 8 : last], "big") >> (8 * last - end)
        self.place = end
        return number & ((1 << bits) - 1)

    def below(self, limit: int, bits: int) -> int:
        """Read a number of so many bits that must be below a limit."""
        number = self.number(bits)
        self.check(number < limit, "has a number out of range")
        return number

    def flag(self) -> bool:
        """Read 1 bit: whether it is 1."""
        return self.number(1) == 1

    def unary(self, limit: int) -> int:
        """Read a number in unary that must be below a limit."""
        number = 0
        while not self.flag():
            number += 1
            self.check(number < limit, "has a number out of range")
        return number

    def rice(self, limit: int, low: int) -> int:
        """Read a number in Rice's code that must be below a limit."""
        number = self.unary((limit >> low) + 1) << low | self.number(low)
        self.check(number < limit, "has a number out of range")
        return number

    def word(self) -> int:
        """Read a word of 32 bits, from -2**31 to 2**31 - 1."""
        number = self.number(32)
        return number - 2**32 if number >> 31 else number

    def task(self, name: int, limit: int) -> int:
        """Return the id of a task by its name; the id must be below a limit."""
        task = name if self._task_of is None else self._task_of(name)
        self.check(0 <= task < limit, "names a task that has no id here")
        return task

    def check(self, holds: bool, problem: str) -> None:
        """Raise a WireError if the message doesn't keep a rule."""
        if not holds:
            raise WireError(f"{problem} (bit {self.place}); send the message again")

    def end(self) -> None:
        """Raise a WireError unless all bytes have been read, and the bits that fill the last one are 0."""
        left = 8 * len(self._data) - self.place
        self.check(left < 8, "goes on after its end")
        self.check(self.number(left) == 0, "has bits other than 0 after its end")
