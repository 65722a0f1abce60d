"""The handshake is that of the Noise framework, to the byte."""

from __future__ import annotations

from hashlib import sha256

import pytest
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey

from feasibee.field.noise import Handshake

SHARED = sha256(b"shared").digest()
MESSAGES = [
    "c1dc6653ec4cfeff64f36a8866fdfb571489b19494be4fe9a2ae86de68351519368e976dee9b452f757199ea3fe88eda",
    "4fbe7a71591080637b0cf601eaa93cc9ccba089a60352afe93a2277caf24f54b3f0623fa12961b60e5755484fc7053b44ba2ba"
    "64239290",
]
SEALED = {
    b"up 0": "c4e23365d05a8656438152c579a5eeb2a28dae28",
    b"up 1": "1d15d01d05ec86b2282b111a3ab37aa9de4d90bb",
    b"down 0": "5fd48accbc41a1223bcc3bde223de2d0def300efa7d1",
    b"down 1": "7bd0c5bf57ebabcf2b23cba7584e57419dd33b740b61",
}
"""What noiseprotocol 0.3.1, another implementation, makes of the same keys."""


def side(name):
    return Handshake(SHARED, b"feasibee", X25519PrivateKey.from_private_bytes(sha256(name).digest()))


def test_the_bytes_are_those_of_another_implementation():
    asking, answering = side(b"asks"), side(b"answers")
    first = asking.write(b"")
    answering, nothing = answering.read(first)
    second = answering.write(b"a field")
    asking, said = asking.read(second)
    assert ([first.hex(), second.hex()], nothing, said) == (MESSAGES, b"", b"a field")
    for text, sealed in SEALED.items():
        way, number = text.startswith(b"down"), int(text[-1:])
        assert asking.ciphers()[way].seal(number, text).hex() == sealed
        assert answering.ciphers()[way].open(number, bytes.fromhex(sealed)) == text


def test_keys_are_new_in_each_handshake():
    assert Handshake(SHARED, b"").write(b"") != Handshake(SHARED, b"").write(b"")


class Unfit:
    """A private key whose public one is a point that gives everybody the same secret."""

    def public_key(self):
        return self

    def public_bytes_raw(self):
        return bytes(32)


def test_a_public_key_that_gives_no_secret_is_an_error():
    answering, _ = side(b"answers").read(Handshake(SHARED, b"feasibee", Unfit()).write(b""))
    with pytest.raises(ValueError, match="shared key"):
        answering.write(b"")
