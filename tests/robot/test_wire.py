"""Messages as bytes: nothing is lost, every bit is accounted for, and damaged frames are rejected."""

from __future__ import annotations

import random
from dataclasses import replace
from zlib import crc32

import pytest

from feasibee import Scenario
from feasibee.reference.swarm import Swarm
from feasibee.robot import Message, Wire, WireError
from feasibee.robot.acting import GONE, Rules
from feasibee.robot.knowledge import Knowledge
from feasibee.robot.wire import OVERHEAD, BitReader, BitWriter
from feasibee.scenario.setting import setting_from
from feasibee.strategies import STRATEGIES, roster
from feasibee.strategies.contract import Me, Thing
from tests.robot.driving import mutated

RULE = {"quorum": 0.6, "rounds": 1}
CLASSES = {
    "robots": {
        "classes": [
            {"name": "small", "count": 5, "skills": ["a"]},
            {"name": "large", "count": 4, "skills": ["b"]},
        ]
    },
    "tasks": {
        "classes": [
            {"name": "light", "count": 3, "needs": {"a": 1}},
            {"name": "heavy", "count": 3, "needs": {"b": 1}},
        ]
    },
}
VARIANTS = [
    *((name, {}, {}) for name in STRATEGIES),
    *((name, {}, CLASSES) for name in ("dmmd", "tally", "estimate", "census")),
    ("quiet-census", {}, {"robots": {"know_count": True}}),
    ("quiet-census", {"tolerates": 1}, {}),
    ("map", {"rows": 2}, {}),
    ("map", {"tolerates": 1}, {}),
    ("map", {"tolerates": 1, "rows": 3}, {}),
    ("turns", {"names": 0}, {}),
    ("turns", {"names": 3, "name_bits": 7}, {}),
    ("turns", {"names": -1}, {}),
    ("turns", {"names": -1, "name_bits": 5}, {}),
    ("turns", {"names": -1, "name_bits": 11, "tolerates": 1, "looks": 2}, {}),
    ("roster", {}, {"robots": {"know_count": True}}),
    ("roster", {"tolerates": 1}, {}),
    ("dmmd", {}, {"radio": {"id_bits": 16}}),
    ("turns", {}, {"radio": {"id_bits": 4}}),
]
GENERATOR_SEED = 17


def scenario_of(name, parameters, fields, declares, says):
    """Return a small scenario of a strategy in which robots hear each other at once."""
    strategy = STRATEGIES[name]
    robots = {"know_count": strategy.needs_count} | fields.get("robots", {"count": 9})
    decision = {"strategy": name, "parameters": parameters} | ({"declare": RULE} if declares else {})
    sides = {"arena": {"side": 8.0}, "tasks": {"count": 6}, "radio": {}} | fields | {"robots": robots}
    faults = {"faults": {"byzantine": 0.3, "byzantine_says": says}} if says else {}
    return Scenario(decision=decision, **sides, **faults)


def wire_of(swarm):
    """Return the wire of a swarm's robots."""
    scenario = swarm.scenario
    setting = scenario.setting if scenario.strategy.knowledge else None
    declares = scenario.decision.declare is not None
    places = {(k + 1) * 2654435761 % 2**32: k for k in range(setting.task_ids)} if setting else {}
    for number, place in swarm.tasks.items():
        thing = Thing(False, number, 0, 0, *swarm.world.in_units(place))
        places[roster.place_of(thing, scenario.setting)] = number
    by_position = swarm.scenario.strategy.name == "roster"
    task_of = (lambda name: places.get(name, -1)) if by_position else None
    return Wire(scenario.strategy, swarm.names.id_bits, declares=declares, setting=setting, task_of=task_of)


class Eavesdropped(Swarm):
    """A swarm whose messages are kept, with the bits that are accounted for each."""

    def __init__(self, scenario):
        super().__init__(scenario, 3, 0)
        self.messages = []

    def _said_by(self, sender):
        message, bits = super()._said_by(sender)
        if message is not None:
            self.messages.append((self.names.id(sender.number), message, bits))
        return message, bits


def simulated(scenario, steps=40):
    """Return the wire of a swarm and the messages of a run, each with its accounted bits."""
    swarm = Eavesdropped(scenario)
    for _ in range(steps):
        swarm.step()
    assert len(swarm.messages) > 20
    return wire_of(swarm), swarm.messages


# --- Nothing is lost, and every bit is accounted for ---


def once(words):
    """Return the words of a message of turns with each name once, as receivers get it."""
    names = sorted(set(words[1:]) - {0})
    return (words[0], *names, *[0] * (len(words) - 1 - len(names)))


SAYS = [None, "colluding", "opposite"]


@pytest.mark.quick(8)
@pytest.mark.parametrize(
    ("name", "parameters", "fields", "says"),
    [
        (*variant, says)
        for number, variant in enumerate(VARIANTS)
        for says in (SAYS if STRATEGIES[variant[0]].knowledge else SAYS[number % 3 :][:1])
    ],
)
def test_the_messages_of_a_run_survive_and_take_the_bits_that_it_accounts(name, parameters, fields, says):
    declares = says != "colluding" and not STRATEGIES[name].declares
    wire, messages = simulated(scenario_of(name, parameters, fields, declares, says))
    for sender, said, bits in messages:
        frame = wire.encode(sender, said)
        message = said
        if name == "turns" and parameters.get("names") == -1:  # some lies hold a name twice
            message = said._replace(knowledge=once(said.knowledge))
        if message == said:
            assert wire.bits(sender, message) == bits
            assert len(frame) == OVERHEAD + (bits + 7) // 8
        heard = wire.decode(frame)
        assert heard.message.opinion == (-1 if message.knowledge and not declares else message.opinion)
        assert heard.sender in {sender, -1}
        assert (heard.sender == -1) <= (bool(message.knowledge) and not declares)
        assert heard.message._replace(opinion=message.opinion) == message


def test_which_messages_have_no_id():
    without = {"tally", "estimate", "census", "quiet-census", "roster"}
    for name in STRATEGIES:
        wire, messages = simulated(scenario_of(name, {}, {}, False, None), steps=20)
        assert (wire.decode(wire.encode(*messages[0][:2])).sender == -1) == (name in without)


def random_things(setting, rng):
    """Return some robots and tasks, at random places."""
    for _ in range(rng.randrange(12)):
        is_robot = rng.random() < 0.5
        kinds = setting.robot_classes if is_robot else setting.task_classes
        place = rng.uniform(0, setting.width), rng.uniform(0, setting.height)
        number = rng.randrange(setting.robots if is_robot else setting.tasks)
        yield Thing(is_robot, number, rng.randrange(kinds), rng.getrandbits(32), *place)


@pytest.mark.parametrize("name", [name for name in STRATEGIES if STRATEGIES[name].knowledge])
def test_random_knowledge_survives(name):
    rng = random.Random(GENERATOR_SEED)
    strategy = STRATEGIES[name]
    for _ in range(20):
        counts, classes = (rng.randint(2, 70), rng.randint(1, 90)), (0, 0)
        if not strategy.one_class:
            classes = rng.randint(0, 3), rng.randint(0, 3)
        knows = strategy.needs_count or rng.random() < 0.5
        setting = setting_from(counts, classes, False, None, strategy.parameters.values(), knows_count=knows)
        me = Me(
            rng.randrange(counts[0]),
            0,
            rng.getrandbits(32),
            rng.randrange(1000),
            [0.0] * strategy.memory,
            setting,
        )
        knowledge = Knowledge(strategy, me)
        places = {}
        for _ in range(10):
            things = list(random_things(setting, rng))
            places |= {roster.place_of(thing, setting): thing.id for thing in things if not thing.is_robot}
            knowledge.observe(things)
            task_of = places.get if name == "roster" else None
            wire = Wire(strategy, setting.id_bits, setting=setting, task_of=task_of)
            sent = Message(-1, knowledge=knowledge.message())
            assert wire.bits(me.id, sent) == knowledge.bits(sent.knowledge)
            assert wire.decode(wire.encode(me.id, sent)).message == sent
            knowledge.end_step(explores=True)


# --- What isn't a frame ---


def sealed(body):
    """Return a frame of these bytes with the right checksum."""
    return body + crc32(body).to_bytes(4, "big")


DMMD = Wire(STRATEGIES["dmmd"], 5)
FRAME = DMMD.encode(7, Message(1))


@pytest.mark.parametrize(
    ("frame", "problem"),
    [
        (b"", "has 0 bytes; a frame has at least 7"),
        (FRAME[:-1], "wrong checksum"),
        (FRAME[:3] + b"\x00" + FRAME[4:], "wrong checksum"),
        (sealed(b"\x02" + FRAME[1:-4]), "is of version 2; use robots of version 1"),
        (sealed(b"\x00" + FRAME[1:-4]), "is of version 0; use robots of version 1"),
        (sealed(FRAME[:1] + b"\x00" + FRAME[2:-4]), "is of another strategy or setting"),
        (sealed(FRAME[:3]), "ends after 0 bytes"),
        (sealed(FRAME[:-4] + b"\x00"), "goes on after its end"),
        (sealed(FRAME[:3] + bytes([FRAME[3] | 1])), "has bits other than 0 after its end"),
        (Wire(STRATEGIES["dmvd"], 5).encode(7, Message(1)), "another strategy or setting"),
        (Wire(STRATEGIES["dmmd"], 6).encode(7, Message(1)), "another strategy or setting"),
        (Wire(STRATEGIES["dmmd"], 5, declares=True).encode(7, Message(1)), "another strategy or setting"),
    ],
)
def test_bytes_that_are_no_frame_are_rejected(frame, problem):
    with pytest.raises(WireError, match=problem):
        DMMD.decode(frame)


@pytest.mark.parametrize(
    ("sender", "message", "problem"),
    [
        (32, Message(1), "32 doesn't fit 5 bits; it must be from 0 to 31"),
        (-1, Message(1), "-1 doesn't fit 5 bits"),
        (1, Message(-1), "-1 doesn't fit 1 bits"),
        (1, Message(1, 3), "3 doesn't fit 0 bits"),
        (1, Message(1, 0, True), "has a declaration; give the wire declares=True"),
    ],
)
def test_a_message_that_does_not_fit_is_rejected(sender, message, problem):
    with pytest.raises(WireError, match=problem):
        DMMD.encode(sender, message)


def test_a_wire_says_what_it_needs():
    with pytest.raises(TypeError, match="census passes on knowledge: give the wire a setting"):
        Wire(STRATEGIES["census"], 5)
    with pytest.raises(ValueError, match="id_bits = 0: must be from 1 to 32"):
        Wire(STRATEGIES["dmmd"], 0)
    with pytest.raises(WireError, match="4294967296 isn't a word"):
        BitWriter().word(2**32)


def header(name, id_bits=5, tasks=5, classes=(0, 0), knows_count=True, **parameters):
    strategy = STRATEGIES[name]
    values = (strategy.parameters | parameters).values()
    setting = setting_from((20, tasks), classes, False, 5, values, knows_count=knows_count)
    wire = Wire(strategy, id_bits, setting=setting)
    return wire.encode(1, Message(-1, knowledge=(0,) * strategy.row_lengths(setting)[1]))[:3]


def test_a_setting_and_parameters_tell_swarms_apart():
    turns = [{"name_bits": 19.0}, {"tolerates": 1.0}, {}, {"looks": 2.0}, {"quiet": 100.5}, {"quiet": 100.0}]
    census = [{}, {"id_bits": 6}, {"tasks": 50}, {"classes": (2, 0)}, {"classes": (0, 2)}]
    found = [header("turns", **each) for each in turns]
    found += [header("census", **each) for each in [*census, {"knows_count": False}]]
    assert len(set(found)) == len(found)
    assert header("turns") == header("turns", looks=1.0) == header("turns", looks=1 + 0.9 / 65536)  # as in C


def test_the_text_of_a_strategy_tells_swarms_apart_and_not_the_name_of_its_file():
    texts = [("own", "one"), ("own", "another"), ("mine", "one")]
    wires = [Wire(replace(STRATEGIES["dmmd"], name=name, source=source), 5) for name, source in texts]
    first, second, third = (wire.encode(1, Message(1))[:3] for wire in wires)
    assert first == third != second


def encoded(name, declares, sender):
    """Return a wire of 20 robots with ids of 5 bits, and a frame without knowledge."""
    setting = setting_from((20, 5), (0, 0), False, None, STRATEGIES[name].parameters.values())
    wire = Wire(STRATEGIES[name], 5, declares=declares, setting=setting)
    words = (0,) * STRATEGIES[name].row_lengths(setting)[1]
    return wire, wire.encode(sender, Message(1 if declares else -1, knowledge=words))


@pytest.mark.parametrize(("name", "declares"), [("turns", False), ("tally", True)])
def test_a_robot_whose_id_is_no_robots_is_rejected(name, declares):
    wire, frame = encoded(name, declares, 20)
    with pytest.raises(WireError, match="has a number out of range"):
        wire.decode(frame)


# --- Damaged frames ---


def test_a_frame_with_two_different_ids_is_rejected():
    wire, frame = encoded("turns", True, 1)
    assert wire.decode(frame).sender == 1
    with pytest.raises(WireError, match="has two different ids"):
        wire.decode(sealed(frame[:3] + bytes([frame[3] ^ 0x80]) + frame[4:-4]))  # the first id is now 17


def frames_of_all_strategies():
    """Return wires, each with frames of a run."""
    found = []
    for name, parameters, fields in VARIANTS:
        wire, messages = simulated(scenario_of(name, parameters, fields, False, None), steps=30)
        found.append((wire, [wire.encode(*each[:2]) for each in messages[:: max(1, len(messages) // 20)]]))
    return found


@pytest.mark.slow
def test_damaged_packets_are_rejected_and_no_message_has_two_frames():
    """Payloads with the right checksum are read strictly."""
    rng = random.Random(GENERATOR_SEED)
    wires = frames_of_all_strategies()
    for _ in range(50_000):
        wire, frames = rng.choice(wires)
        frame = rng.choice(frames)
        packet = mutated(frame, rng)
        if packet != frame:
            with pytest.raises(WireError):  # 2**-32 of such packets may be accepted
                wire.decode(packet)
        packet = sealed(frame[:3] + mutated(frame[3:-4], rng))
        try:
            heard = wire.decode(packet)
        except WireError:
            continue
        sent = heard.message._replace(opinion=max(heard.message.opinion, 0))
        assert wire.encode(max(heard.sender, 0), sent) == packet


# --- Bits ---


def test_bits_are_read_as_they_were_written():
    rng = random.Random(GENERATOR_SEED)
    writer, written = BitWriter(), []
    for _ in range(500):
        number, bits, low = rng.randrange(20), rng.randrange(33), rng.randrange(6)
        number_of_bits = number % 2**bits
        codes = [
            ("number", (number_of_bits, bits), (bits,)),
            ("unary", (number,), (20,)),
            ("rice", (number, low), (20, low)),
            ("word", (number - 10,), ()),
        ]
        written.append(rng.choice(codes))
        getattr(writer, written[-1][0])(*written[-1][1])
    reader = BitReader(writer.bytes())
    for code, (number, *_), limits in written:
        assert getattr(reader, code)(*limits) == number
    assert reader.place == writer.length
    reader.end()


def test_what_acting_robots_say_of_tasks_has_the_bits_of_the_model_and_comes_back():
    """1 bit, 32 for the place and a status for each task, 1 at the end (model.md 6.25.7)."""
    for rules, news, bits in (
        (Rules(), ((3, 0), (2**32 - 1, 1)), 2 * (33 + 1) + 1),
        (
            Rules(ranks=3, comes_free=True),
            ((1, 0), (2, 7), (5, 254 * 4 + 3), (8, GONE)),
            4 * (33 + 2 + 8) + 1,
        ),
        (Rules(ranks=2), (), 1),
    ):
        wire = Wire(STRATEGIES["dmmd"], 5, rules=rules)
        message = Message(1, news=news)
        assert wire.bits(4, message) == 6 + bits
        assert wire.decode(wire.encode(4, message)) == (4, message)
        plain = Wire(STRATEGIES["dmmd"], 5)
        with pytest.raises(WireError, match="another strategy or setting"):
            plain.decode(wire.encode(4, message))
    wire = Wire(STRATEGIES["dmmd"], 5, rules=Rules(comes_free=True))
    with pytest.raises(WireError, match="came free 255 times"):
        wire.encode(4, Message(1, news=((1, 2 * 255),)))
    writer, reader = (Wire(STRATEGIES["dmmd"], 5, rules=Rules(ranks=ranks)) for ranks in (3, 2))
    writer._header = reader._header
    frame = writer.encode(4, Message(1, news=((1, 3),)))
    with pytest.raises(WireError, match="out of range"):
        reader.decode(frame)
