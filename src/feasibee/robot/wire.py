"""Messages as bytes: what robots broadcast, exactly as many bits as the simulation counts (model.md 6.13).

A frame is a header of 3 bytes, the payload, and a checksum of 4 bytes. docs/wire.md has the layout.
"""

from __future__ import annotations

from binascii import crc32
from collections.abc import Callable
from typing import Any, Final, NamedTuple

from feasibee.robot.bits import BitReader, BitWriter, WireError
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


class Heard(NamedTuple):
    """A decoded frame: the arguments of `Controller.hear`."""

    sender: int
    """Id of the sender; -1 if the strategy's messages don't have it."""
    message: Message
    """The message; its opinion is -1 if the strategy's messages don't have it."""


class Wire:
    """Encodes and decodes the messages of one strategy.

    All robots of a swarm need the same strategy, parameters, length of ids and rule to commit. A frame of
    others is reported as such.

    Parameters
    ----------
    strategy : Strategy
        The strategy, such as ``STRATEGIES["dmmd"]``.
    id_bits : int
        Length of a robot's id, in bits; takes the place of ``setting.id_bits``.
    commits : bool
        Whether messages say whether the sender has committed (model.md 6.14).
    setting : Setting, optional
        The numbers that the strategy's knowledge depends on; needed if it passes on knowledge.
    task_of : callable, optional
        Given the name of a task in a message, returns its id, or -1 if it has none. By default the name is
        the id.

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
        commits: bool = False,
        setting: Setting | None = None,
        task_of: Callable[[int], int] | None = None,
    ) -> None:
        if strategy.knowledge and setting is None:
            raise TypeError(f"{strategy.name} passes on knowledge: give the wire a setting")
        if not 1 <= id_bits <= 32:
            raise ValueError(f"id_bits = {id_bits}: must be from 1 to 32")
        self._hooks: Any = strategy
        self._knowledge = strategy.knowledge
        self._value_bits = strategy.value_bits
        self._id_bits, self._commits, self._task_of = id_bits, commits, task_of
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
        reader.end()
        return heard

    def _scheme(self, strategy: Strategy) -> bytes:
        """Return bytes that differ between strategies and settings, for the header."""
        numbers = [self._id_bits, self._value_bits, int(self._commits)]
        if self._setting is not None and strategy.knowledge:
            setting = self._setting
            numbers += [self._words, setting.robot_classes, setting.task_classes, int(setting.knows_count)]
            numbers += [int(each * UNIT) % 2**32 for each in setting.parameters]
        name = (strategy.source or strategy.name).encode()
        return name + b"\0" + b"".join(number.to_bytes(4, "big") for number in numbers)

    def _written(self, sender: int, message: Message) -> BitWriter:
        writer = BitWriter()
        if message.committed and not self._commits:
            raise WireError("has a commitment; give the wire commits=True")
        if self._commits or not (self._knowledge and self.is_exact):
            writer.number(sender, self._id_bits)
            writer.number(message.opinion, 1)
            writer.number(message.value, self._value_bits)
            if self._commits:
                writer.flag(message.committed)
        if self._knowledge:
            if len(message.knowledge) != self._words:
                raise WireError(f"has {len(message.knowledge)} words of knowledge; must have {self._words}")
            if self.is_exact:
                self._hooks.pack(writer, message.knowledge, sender, self._setting)
            else:
                for word in message.knowledge:
                    writer.word(word)
        return writer

    def _read(self, reader: BitReader) -> Heard:
        sender, opinion, value, committed = NONE, NONE, 0, False
        if self._commits or not (self._knowledge and self.is_exact):
            robots = self._setting.robots if self._setting and self._knowledge else 2**self._id_bits
            sender, opinion = reader.below(robots, self._id_bits), reader.number(1)
            value = reader.number(self._value_bits)
            committed = self._commits and reader.flag()
        if not self._knowledge:
            return Heard(sender, Message(opinion, value, committed))
        words = Words([0] * self._words)
        if self.is_exact:
            named = self._hooks.unpack(words, reader, self._setting)
            reader.check(NONE in (sender, named) or sender == named, "has two different ids")
            sender = max(sender, named)
        else:
            words[:] = [reader.word() for _ in words]
        return Heard(sender, Message(opinion, value, committed, tuple(words)))
