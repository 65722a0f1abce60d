"""The handshake of two sides that share a key: Noise_NNpsk0_25519_ChaChaPoly_SHA256 (noiseprotocol.org).

Each side sends a fresh public key. These and the shared key give a new key for each direction. So no packet
fits another connection, and a shared key that leaks doesn't open the packets that were sent before.
"""

from __future__ import annotations

from copy import copy
from hashlib import sha256

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey
from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDF

NAME = b"Noise_NNpsk0_25519_ChaChaPoly_SHA256"
LENGTH = 32
"""Bytes of keys and hashes."""


class Cipher:
    """The packets of one direction, sealed with its key."""

    def __init__(self, key: bytes) -> None:
        self._cipher = ChaCha20Poly1305(key)

    def seal(self, number: int, plain: bytes, known: bytes = b"") -> bytes:
        """Encrypt a packet of a number that no other one has; ``known`` is authenticated in addition."""
        return self._cipher.encrypt(_nonce(number), plain, known)

    def open(self, number: int, sealed: bytes, known: bytes = b"") -> bytes:
        """Decrypt a packet; raise a ValueError if it isn't the one that was sealed."""
        try:
            return self._cipher.decrypt(_nonce(number), sealed, known)
        except InvalidTag:
            raise ValueError("a packet that was changed, or sealed with another key") from None


class Handshake:
    """One side of a handshake; who asks writes and then reads, who answers reads and then writes.

    The shared key has 32 bytes; both sides must agree on the prologue. By default, the private key is fresh.
    """

    def __init__(self, shared: bytes, prologue: bytes, private: X25519PrivateKey | None = None) -> None:
        self._private = private or X25519PrivateKey.generate()
        self._other: X25519PublicKey | None = None
        self._begun = False
        self._chain = self._hash = sha256(NAME).digest()
        self._mix_hash(prologue)
        mixed = self._mix_key(shared, 3)
        self._mix_hash(mixed)

    def write(self, payload: bytes) -> bytes:
        """Return this side's message; raise a ValueError if the other side's public key is unfit."""
        public = self._private.public_key().public_bytes_raw()
        self._mix_public(public)
        sealed = Cipher(self._key).seal(0, payload, self._hash)
        self._mix_hash(sealed)
        return public + sealed

    def read(self, message: bytes) -> tuple[Handshake, bytes]:
        """Return the handshake after a message of the other side, and what the message says.

        This one stays as it is, so that a forged message doesn't spoil it. Raise a ValueError if the message
        was changed, or the other side has another key.
        """
        after = copy(self)
        public, sealed = message[:LENGTH], message[LENGTH:]
        after._other = X25519PublicKey.from_public_bytes(public)
        after._mix_public(public)
        payload = Cipher(after._key).open(0, sealed, after._hash)
        after._mix_hash(sealed)
        return after, payload

    def ciphers(self) -> tuple[Cipher, Cipher]:
        """Return the ciphers of the packets of who asked, and of who answered."""
        first, second = self._derived(b"", 2)
        return Cipher(first), Cipher(second)

    def _mix_public(self, public: bytes) -> None:
        """Mix in a public key; the second one completes the secret that only the two sides know."""
        self._mix_hash(public)
        self._mix_key(public)
        if self._begun and self._other is not None:
            self._mix_key(self._private.exchange(self._other))
        self._begun = True

    def _mix_hash(self, data: bytes) -> None:
        self._hash = sha256(self._hash + data).digest()

    def _mix_key(self, secret: bytes, count: int = 2) -> bytes:
        self._chain, *rest, self._key = self._derived(secret, count)
        return b"".join(rest)

    def _derived(self, secret: bytes, count: int) -> list[bytes]:
        """Return so many keys."""
        found = HKDF(SHA256(), LENGTH * count, salt=self._chain, info=b"").derive(secret)
        return [found[start : start + LENGTH] for start in range(0, len(found), LENGTH)]


def _nonce(number: int) -> bytes:
    return bytes(4) + number.to_bytes(8, "little")
