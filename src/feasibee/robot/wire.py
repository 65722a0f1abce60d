"""Messages as bytes: what robots broadcast, exactly as many bits as the simulation counts (model.md 6.13).

A frame is a header of 3 bytes, the payload, and a checksum of 4 bytes. docs/wire.md has the layout.
"""

from __future__ import annotations

from binascii import crc32
from collections.abc import Callable
from typing import Any, Final, NamedTuple

from feasibee.robot.acting import GONE, Rules
from feasibee.robot.controller import NONE, Message
from feasibee.strategies.contract import Setting, Strategy
from feasibee.strategies.words import Words

VERSION: Final = 1
"""Version of the frame, its first byte."""
SCHEME_BYTES: Final = 2
CHECKSUM_BYTES: Final = 4
HEADER_BYTES: Final = 1 + SCHEME_BYTES
OVERHEAD: Final = HEADER_BYTES + CHECKSUM_BYTES
"""Number of bytes of a frame in addition to its payload."""
UNIT: Final = 2**16
"""Parameters are compared in units of 1 / UNIT."""
FREES_BITS: Final = 8
"""Bits for how often a task came free."""
VANISHED: Final = 2**FREES_BITS - 1
"""That number of a task that has vanished."""
WORD = 2**32 - 1
"""The bits of a word, without its sign."""


class WireError(ValueError):
    """A message that can't be sent, or bytes that aren't a message of this strategy."""


class BitWriter:
    """Bits that are appended one number after the other.

    Examples
    --------
    >>> from feasibee.robot.wire import BitWriter
    >>> writer = BitWriter()
    >>> writer.number(5, 3)
    >>> writer.unary(2)
    >>> writer.length, writer.bytes().hex()
    (6, 'a4')
    """

    def __init__(self) -> None:
        self.length = 0
        """Number of bits written."""
        self._digits: list[str] = []

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
        self._digits.append(f"{number:0{bits}b}" if bits else "")

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
        size = -(-self.length // 8)
        return int("0" + "".join(self._digits).ljust(8 * size, "0"), 2).to_bytes(size, "big")


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
        self._digits = "".join(f"{byte:08b}" for byte in data)
        self._task_of = task_of

    def number(self, bits: int) -> int:
        """Read a number of so many bits.

        Raises
        ------
        WireError
            If fewer bits are left.
        """
        end = self.place + bits
        if end > len(self._digits):
            size = len(self._digits) // 8
            raise WireError(f"ends after {size} bytes, within a number; send the message again")
        digits, self.place = self._digits[self.place : end], end
        return int("0" + digits, 2)

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
        left = len(self._digits) - self.place
        self.check(left < 8, "goes on after its end")
        self.check(self.number(left) == 0, "has bits other than 0 after its end")


def name_of(strategy: Strategy) -> str:
    """Return the name by which frames know a strategy: of a user's file, the CRC-32 of its text."""
    return f"{crc32(strategy.source.encode()):08x}" if strategy.source else strategy.name


class Heard(NamedTuple):
    """A decoded frame: the arguments of `Controller.hear`."""

    sender: int
    """Id of the sender; -1 if the strategy's messages don't have it."""
    message: Message
    """The message; its opinion is -1 if the strategy's messages don't have it."""


class Wire:
    """Encodes and decodes the messages of one strategy.

    All robots of a swarm need the same strategy, parameters, length of ids and rule to declare. A frame of
    others is reported as such.

    Parameters
    ----------
    strategy : Strategy
        The strategy, such as ``STRATEGIES["dmmd"]``.
    id_bits : int
        Length of a robot's id, in bits; takes the place of ``setting.id_bits``.
    declares : bool
        Whether messages say whether the sender has declared (model.md 6.14).
    setting : Setting, optional
        The numbers that the strategy's knowledge depends on; needed if it passes on knowledge.
    task_of : callable, optional
        Given the name of a task in a message, returns its id, or -1 if it has none. By default the name is
        the id.
    rules : Rules, optional
        How robots act, if they do (model.md 6.25.7). Names of tasks have 32 bits here
        with each strategy.

    Examples
    --------
    >>> from feasibee.robot import Message
    >>> from feasibee.robot.wire import Wire
    >>> from feasibee.strategies import STRATEGIES
    >>> wire = Wire(STRATEGIES["dmmd"], id_bits=5)
    >>> frame = wire.encode(7, Message(opinion=1))
    >>> len(frame), wire.bits(7, Message(opinion=1))
    (8, 6)
    >>> sender, message = wire.decode(frame)
    >>> sender, message.opinion
    (7, 1)
    """

    def __init__(
        self,
        strategy: Strategy,
        id_bits: int,
        *,
        declares: bool = False,
        setting: Setting | None = None,
        task_of: Callable[[int], int] | None = None,
        rules: Rules | None = None,
    ) -> None:
        if strategy.knowledge and setting is None:
            raise TypeError(f"{strategy.name} passes on knowledge: give the wire a setting")
        if not 1 <= id_bits <= 32:
            raise ValueError(f"id_bits = {id_bits}: must be from 1 to 32")
        self._hooks: Any = strategy
        self._knowledge = strategy.knowledge
        self._value_bits = strategy.value_bits
        self._id_bits, self._declares, self._task_of = id_bits, declares, task_of
        self._rules = rules
        self._setting = setting._replace(id_bits=id_bits) if setting is not None else None
        self._words = 0
        if strategy.knowledge and self._setting is not None:
            self._words = strategy.row_lengths(self._setting)[1]
        self.is_exact = not strategy.knowledge or strategy.pack is not None
        """Whether messages take as many bits as the simulation counts: not for knowledge without ``pack``."""
        self._header = bytes([VERSION]) + crc32(self._scheme(strategy)).to_bytes(4, "big")[-SCHEME_BYTES:]

    def encode(self, sender: int, message: Message) -> bytes:
        """Return the frame of a message.

        Parameters
        ----------
        sender : int
            The robot's id.
        message : Message
            What the robot broadcasts: `Controller.message`.

        Raises
        ------
        WireError
            If a part of the message doesn't fit its bits, such as an id.
        """
        frame = self._header + self._written(sender, message).bytes()
        return frame + crc32(frame).to_bytes(CHECKSUM_BYTES, "big")

    def bits(self, sender: int, message: Message) -> int:
        """Return the length of a message's payload, in bits."""
        return self._written(sender, message).length

    def decode(self, frame: bytes) -> Heard:
        """Return sender and message of a frame.

        Raises
        ------
        WireError
            If the bytes are no frame of this version, strategy and setting.
        """
        frame = bytes(frame)
        if len(frame) < OVERHEAD:
            raise WireError(f"has {len(frame)} bytes; a frame has at least {OVERHEAD}")
        body, checksum = frame[:-CHECKSUM_BYTES], frame[-CHECKSUM_BYTES:]
        if crc32(body) != int.from_bytes(checksum, "big"):
            raise WireError("has a wrong checksum; send the message again")
        if body[0] != VERSION:
            raise WireError(f"is of version {body[0]}; use robots of version {VERSION}")
        if body[:HEADER_BYTES] != self._header:
            raise WireError("is of another strategy or setting; use the same for all robots")
        reader = BitReader(body[HEADER_BYTES:], self._task_of)
        heard = self._read(reader)
        if self._rules:
            news = self._read_news(reader, self._rules)
            heard = heard._replace(message=heard.message._replace(news=news))
        reader.end()
        return heard

    def _scheme(self, strategy: Strategy) -> bytes:
        """Return bytes that differ between strategies and settings, for the header."""
        numbers = [self._id_bits, self._value_bits, int(self._declares)]
        numbers += [self._rules.ranks, int(self._rules.comes_free)] if self._rules else []
        if self._setting is not None and strategy.knowledge:
            setting = self._setting
            numbers += [self._words, setting.robot_classes, setting.task_classes, int(setting.knows_count)]
            numbers += [int(each * UNIT) % 2**32 for each in setting.parameters]
        return name_of(strategy).encode() + b"\0" + b"".join(number.to_bytes(4, "big") for number in numbers)

    def _written(self, sender: int, message: Message) -> BitWriter:
        writer = BitWriter()
        if message.declared and not self._declares:
            raise WireError("has a declaration; give the wire declares=True")
        if self._declares or not (self._knowledge and self.is_exact):
            writer.number(sender, self._id_bits)
            writer.number(message.opinion, 1)
            writer.number(message.value, self._value_bits)
            if self._declares:
                writer.flag(message.declared)
        if self._knowledge:
            if len(message.knowledge) != self._words:
                raise WireError(f"has {len(message.knowledge)} words of knowledge; must have {self._words}")
            if self.is_exact:
                self._hooks.pack(writer, message.knowledge, sender, self._setting)
            else:
                for word in message.knowledge:
                    writer.word(word)
        if self._rules:
            self._write_news(writer, message, self._rules)
        return writer

    def _write_news(self, writer: BitWriter, message: Message, rules: Rules) -> None:
        """Write name and status of each task, with how often it came free; the most stands for vanished."""
        for name, version in message.news:
            frees, status = divmod(version, rules.ranks + 1) if version != GONE else (VANISHED, 0)
            if frees >= VANISHED and version != GONE:
                raise WireError(f"has a task that came free {frees} times; at most {VANISHED - 1} are sent")
            writer.flag(True)
            writer.number(name, 32)
            writer.number(status, rules.ranks.bit_length())
            writer.number(frees, FREES_BITS if rules.comes_free else 0)
        writer.flag(False)

    def _read_news(self, reader: BitReader, rules: Rules) -> tuple[tuple[int, int], ...]:
        """Read what `_write_news` writes."""
        news = []
        while reader.flag():
            name = reader.number(32)
            status = reader.below(rules.ranks + 1, rules.ranks.bit_length())
            frees = reader.number(FREES_BITS if rules.comes_free else 0)
            news.append((name, GONE if frees == VANISHED else frees * (rules.ranks + 1) + status))
        return tuple(news)

    def _read(self, reader: BitReader) -> Heard:
        sender, opinion, value, declared = NONE, NONE, 0, False
        if self._declares or not (self._knowledge and self.is_exact):
            robots = self._setting.robots if self._setting and self._knowledge else 2**self._id_bits
            sender, opinion = reader.below(robots, self._id_bits), reader.number(1)
            value = reader.number(self._value_bits)
            declared = self._declares and reader.flag()
        if not self._knowledge:
            return Heard(sender, Message(opinion, value, declared))
        words = Words([0] * self._words)
        if self.is_exact:
            named = self._hooks.unpack(words, reader, self._setting)
            reader.check(NONE in (sender, named) or sender == named, "has two different ids")
            sender = max(sender, named)
        else:
            words[:] = [reader.word() for _ in words]
        return Heard(sender, Message(opinion, value, declared, tuple(words)))
