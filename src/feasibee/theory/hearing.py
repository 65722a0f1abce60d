"""Who is heard: contacts of one sender and one hearer, as a Markov chain.

A sender is in range or not, and broadcasts or not. Both change at the rates of real space and of the rounds.
"""

from __future__ import annotations

import numpy as np

from feasibee.theory.classes import EXPLORING, SENDING, Array
from feasibee.theory.geometry import Space


def audible(
    space: Space,
    reach: float,
    delivered: float,
    explored: float,
    ends: Array,
    weights: Array,
    explorers_hear: bool,
) -> Array:
    """Return the probability per step that a sender is heard, for the last time before the hearer decides.

    Parameters
    ----------
    space : Space
        The arena and the walk.
    reach : float
        Range of the radio, in units.
    delivered : float
        Probability that a message arrives.
    explored : float
        Probability per step that an exploration ends.
    ends, weights : float64 array, shape (opinions, durations)
        Durations of dissemination: probability per step of their end, and of each duration.
    explorers_hear : bool
        Whether robots hear while they explore.

    Returns
    -------
    float64 array, shape (opinions, 1 + durations, 2)
        By opinion and phase of the hearer, and by opinion of the sender, given that the sender broadcasts.
    """
    opinions, durations = ends.shape
    found = np.zeros((opinions, SENDING + durations, 2))
    for sender in (0, 1):
        moves = _moves(space, reach, explored, ends[sender], weights[sender])
        states = len(moves)
        heard = np.arange(states) > states // 2  # in range and broadcasting
        unheard = moves * np.where(heard, 1 - delivered, 1.0)
        sending = weights[sender] / ends[sender]
        share = delivered * space.in_range(reach) * sending / sending.sum()
        for hearer in range(opinions):
            last = _last(unheard, explored, ends[hearer], weights[hearer])
            found[hearer, :, sender] = last[:, heard] @ share
    if not explorers_hear:
        found[:, EXPLORING] = 0
    return found


def _last(unheard: Array, explored: float, ends: Array, weights: Array) -> Array:
    """Return the chance that nothing more is heard, by the hearer's phase and the sender's state."""
    states = len(unheard)
    last = np.zeros((SENDING + len(ends), states))
    for k, end in enumerate(ends, SENDING):
        last[k] = np.linalg.solve(np.eye(states) - (1 - end) * unheard, np.full(states, end))
    then = explored * unheard @ (weights @ last[SENDING:])
    last[EXPLORING] = np.linalg.solve(np.eye(states) - (1 - explored) * unheard, then)
    return last


def _moves(space: Space, reach: float, explored: float, ends: Array, weights: Array) -> Array:
    """Return the chances of a sender to move: out of range and in range, each by phase."""
    inside, coming = space.in_range(reach), space.coming(reach)
    enter, leave = coming / (1 - inside), coming / inside
    phases = np.diag(1 - np.concatenate([[explored], ends]))
    phases[0, 1:], phases[1:, 0] = explored * weights, ends
    return np.kron(np.array([[1 - enter, enter], [leave, 1 - leave]]), phases)
