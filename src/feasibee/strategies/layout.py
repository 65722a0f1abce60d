"""One description of a message's bits, by which it is written and read.

A strategy's ``layout(wire, message, sender, setting)`` goes through a message from its first bit to
its last. It gives each call what to write, and stores what the call returns: the same when writing, else
what was read. It returns the sender's id, -1 if it isn't sent. ``pack`` and ``unpack`` are made of it.
"""


class Bits:
    """The bits of one message, which go to a ``BitWriter`` or, if ``reads``, come from a ``BitReader``."""

    def __init__(self, stream, reads):
        self.stream, self.reads = stream, reads

    def number(self, number, bits, limit=None):
        """Write or read a number of so many bits; one that is read must be below the limit, if any."""
        if self.reads:
            return self.stream.number(bits) if limit is None else self.stream.below(limit, bits)
        self.stream.number(number, bits)
        return number

    def flag(self, flag):
        """Write or read 1 bit."""
        return self.number(int(flag), 1) == 1

    def rice(self, number, low, limit):
        """Write or read a number in Rice's code with so many low bits, 0 for unary; see `number`."""
        if self.reads:
            return self.stream.rice(limit, low)
        self.stream.rice(number, low)
        return number

    def task(self, name, task, limit):
        """Return the id of a task: the one given, or when reading that of its name, below the limit."""
        return self.stream.task(name, limit) if self.reads else task

    def check(self, holds, problem):
        """Raise an error if a message that is read doesn't keep a rule."""
        if self.reads:
            self.stream.check(holds, problem)


def both_ways(layout):
    """Return the functions ``pack`` and ``unpack`` of a layout."""

    def pack(writer, message, sender, setting):
        layout(Bits(writer, False), list(message), sender, setting)

    def unpack(message, reader, setting):
        return layout(Bits(reader, True), message, -1, setting)

    return {"pack": pack, "unpack": unpack}
