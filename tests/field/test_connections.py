"""Connections: who has no key, or isn't at the address that it names, gets nothing and changes nothing."""

from __future__ import annotations

import pytest
from nets import ASKED, KEY, Pair, Wire, joined, settle

from feasibee.field import connections
from feasibee.field.checks import HEARD, HELLO, SAID
from feasibee.field.connections import ACCEPT, DOWN, HEADER, TOKEN, UP, WINDOW, Client, Server, packed

SAYING = {"t": 0, "said": None, "was": [0, -1, False, 1, 1, None], "ends": False}


@pytest.fixture(params=[b"", KEY], ids=["no key", "a key"])
def key(request):
    return request.param


def connected(key):
    pair = Pair(key)
    joined(pair)
    return pair


def packets_of(pair, number=1):
    """Return the packets in which the client says so many things; none of them arrives."""
    for step in range(number):
        pair.client.send(SAID, {**SAYING, "t": step})
    packets = [packet for packet, _ in pair.net.up]
    pair.net.up.clear()
    return packets


def arrives(pair, packet, peer="peer"):
    """Let a packet arrive at the world; return the step of what it says."""
    pair.net.up.append((packet, peer))
    frame = pair.server.receive(0.0)
    return None if frame is None else frame.body["t"]


def comes(pair, packet):
    """Let a packet arrive at the client; return the frame, if it accepts it."""
    pair.net.down["peer"].append((packet, "peer"))
    return pair.client.receive(0.0)


def asked(key):
    """Return a pair, and the packet in which its client asks for a connection with its token."""
    pair = Pair(key)
    pair.client.send(*ASKED)
    pair.server.receive(0.0)
    pair.client.receive(0.0)
    ((asking, _),) = pair.net.up
    pair.net.up.clear()
    return pair, asking


def flipped(packet):
    """Yield a packet with each one of its bits changed."""
    for bit in range(8 * len(packet)):
        changed = bytearray(packet)
        changed[bit // 8] ^= 1 << bit % 8
        yield bytes(changed)


def test_both_sides_read_what_the_other_one_wrote(key):
    pair = Pair(key)
    (greeting,) = joined(pair)
    assert (greeting.kind, greeting.body) == ASKED
    assert pair.client.session == 7
    pair.client.send(SAID, SAYING)
    pair.server.send(pair.channel, HEARD, {"heard": [1, "00"]})
    (up,), (down,) = settle(pair)
    assert (up.kind, up.body) == (SAID, SAYING)
    assert (down.kind, down.body) == (HEARD, {"heard": [1, "00"]})
    said = [packet for packet, way in pair.net.seen if way.up][-1]
    assert (b'"said"' in said) == (not key)
    assert not pair.client.dropped + pair.server.dropped


def test_packets_may_overtake_each_other_and_count_once(key):
    pair = connected(key)
    packets = packets_of(pair, WINDOW + 6)
    order = [2, 1, 5, 3, WINDOW + 2, 4, WINDOW + 5]
    assert [arrives(pair, packets[k]) for k in order] == order
    assert [arrives(pair, packets[k]) for k in order] == [None] * len(order)
    assert arrives(pair, packets[0]) is None  # overtaken by too many
    assert pair.server.dropped == {"old": len(order) + 1}


def test_a_packet_sent_back_to_its_sender_is_dropped(key):
    pair = connected(key)
    (packet,) = packets_of(pair)
    pair.server.send(pair.channel, HEARD, {"heard": [1, "00"]})
    down, _ = pair.net.down["peer"].pop()
    assert comes(pair, packet) is arrives(pair, down) is None
    if key:  # without one, anybody can write these
        assert comes(pair, packet[:3] + bytes([DOWN]) + packet[4:]) is None
        assert arrives(pair, down[:3] + bytes([UP]) + down[4:]) is None
        assert pair.client.dropped["not sealed with the key"] == 1
    pair.net.down["peer"].append((down, "peer"))
    assert [frame.kind for frame in settle(pair)[1]] == [HEARD]
    assert arrives(pair, packet) == 0


def test_a_packet_is_of_one_connection_and_one_address(key):
    pair, other = connected(key), Pair(key, "other")
    other.join(pair)
    (packet,) = packets_of(pair)
    assert arrives(pair, packet, "other") is None
    assert arrives(pair, packet, "elsewhere") is None
    if key:
        (mine,) = packets_of(other)
        assert arrives(pair, mine[: HEADER.size] + packet[HEADER.size :], "other") is None
        assert arrives(pair, mine, "other") == 0
    assert arrives(pair, packet) == 0
    before = packet
    again = connected(key)
    assert arrives(again, before) is None


def test_no_changed_bit_and_no_cut_packet_passes():
    pair = connected(KEY)
    (packet,) = packets_of(pair)
    for changed in (*flipped(packet), *(packet[:length] for length in range(len(packet)))):
        assert arrives(pair, changed) is None
    assert len(pair.server._known) == 1
    assert arrives(pair, packet) == 0


def test_no_changed_or_cut_handshake_leads_to_a_connection():
    pair, asking = asked(KEY)
    number = range(8 * (HEADER.size - 8), 8 * HEADER.size)  # which isn't used before there is a connection
    wrong = [each for bit, each in enumerate(flipped(asking)) if bit not in number]
    for changed in (*wrong, *(asking[:length] for length in range(len(asking)))):
        arrives(pair, changed)
        assert not pair.server._known
    arrives(pair, asking)
    (accepting,) = (each for each, _ in pair.net.down["peer"] if each[3] == ACCEPT)
    right = [each for bit, each in enumerate(flipped(accepting)) if bit in number]
    wrong = [each for each in flipped(accepting) if each not in right]
    for changed in (*wrong, *(accepting[:length] for length in range(len(accepting)))):
        pair.net.down["peer"].clear()
        comes(pair, changed)
        assert pair.client.session == 0
    pair.net.down["peer"].append((accepting, "peer"))
    assert settle(pair)[0]
    assert pair.client.session == 7


@pytest.mark.parametrize("keys", [(KEY, b""), (b"", KEY), (KEY, b"another key of some length")])
def test_both_sides_have_the_same_key_or_none(keys):
    pair = Pair(keys[0])
    pair.client = Client(Wire(pair.net, "peer"), keys[1], lambda: ASKED)
    for _ in range(3):
        assert joined(pair) == []
    assert not pair.server._known
    assert pair.server.dropped == {"not sealed with the key": 3}


def test_a_packet_that_is_too_large_is_an_error(key):
    with pytest.raises(ValueError, match="at most 60,000 fit"):
        connected(key).client.send(SAID, {"said": "0" * 60_000})


def test_an_address_that_did_not_answer_gets_no_more_bytes_than_came_from_it(key):
    """All packets of another one's connection come from it, those of the world too."""
    pair = connected(key)
    pair.client.send(*ASKED)
    settle(pair)
    packets = [packet for packet, _ in pair.net.seen]
    packets += [packet[:length] for packet in packets for length in range(len(packet))]
    got = 0
    for packet in packets:
        pair.net.up.append((packet, "victim"))
        assert pair.server.receive(0.0) is None
        answers = [answer for answer, _ in pair.net.down["victim"]]
        pair.net.down["victim"].clear()
        assert sum(map(len, answers)) <= len(packet)
        got += len(answers)
    assert got > 3  # tokens


def test_a_token_is_good_for_one_address_and_a_short_time(key, monkeypatch):
    pair, asking = asked(key)
    arrives(pair, asking, "victim")
    assert not pair.server._known
    now = connections.time.monotonic()
    monkeypatch.setattr(connections.time, "monotonic", lambda: now + 2 * connections.TOKEN_KEPT)
    arrives(pair, asking)
    assert not pair.server._known
    monkeypatch.setattr(connections.time, "monotonic", lambda: now)
    arrives(pair, asking)
    assert len(pair.server._known) == 1


def test_there_is_a_new_connection_when_the_world_has_started_again(key, monkeypatch):
    monkeypatch.setattr(connections, "AGAIN", -1.0)
    pair = connected(key)
    for session, answers in ((8, 0), (7, 1)):
        pair.server = Server(pair.net, session, key)
        pair.client.send(SAID, SAYING)
        assert len(settle(pair)[0]) == answers  # not of the packet that was lost, but the first of a new one
        assert pair.client.session == 7
    pair.client.send(SAID, SAYING)
    assert [frame.kind for frame in settle(pair)[0]] == [SAID]


def test_tokens_sent_by_anybody_end_no_connection(key, monkeypatch):
    monkeypatch.setattr(connections, "AGAIN", -1.0)
    pair = connected(key)
    before = pair.channel
    for k in range(3):
        comes(pair, packed(TOKEN, before.name, bytes([k] * 8)))
        pair.server.send(before, HEARD, {"heard": [1, "00"]})
        assert pair.client.receive(0.0).kind == HEARD
    assert len(settle(pair)[0]) == 1  # of a new connection
    pair.server.send(before, HEARD, {"heard": [1, "00"]})  # the world may not have read that yet
    assert [frame.kind for frame in settle(pair)[1]] == [HEARD]
    pair.client.send(SAID, SAYING)
    assert [frame.kind for frame in settle(pair)[0]] == [SAID]
    monkeypatch.setattr(connections, "AGAIN", 1e9)
    pair.net.down["peer"].append((packed(TOKEN, pair.client._channels[0].name, bytes([9] * 8)), "peer"))
    assert settle(pair) == ([], [])
    assert not pair.client._is_asking


def test_the_connection_that_was_silent_for_longest_makes_room_and_comes_back(monkeypatch):
    monkeypatch.setattr(connections, "CONNECTIONS_LIMIT", 2)
    monkeypatch.setattr(connections, "AGAIN", -1.0)
    pair = connected(KEY)
    second, third = Pair(KEY, "second"), Pair(KEY, "third")
    second.join(pair)
    pair.client.send(SAID, SAYING)
    settle(pair)
    third.join(pair)
    assert [peer for peer, _ in pair.server._known] == ["peer", "third"]
    second.client.send(SAID, SAYING)
    assert [frame.kind for frame in settle(second)[0]] == [HELLO]
    assert [peer for peer, _ in pair.server._known] == ["third", "second"]
