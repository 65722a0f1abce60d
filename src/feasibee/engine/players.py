"""Players: what plays runs of a scenario by the engine."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial

from feasibee.base.codes import UNDECIDED
from feasibee.base.record import Record
from feasibee.engine.given import NO_MEMORY, Given
from feasibee.engine.state import Room, State
from feasibee.engine.tables import Control, Lowered, Player


def player_of(lowered: Lowered, team: int) -> Player:
    """Return what plays runs of a scenario, each by so many threads."""
    given = Given(lowered)
    return (PaperWorld if lowered.fast else AnyWorld)(given, team).play


class PaperWorld:
    """Plays runs of the paper's world by the code for it, each by so many threads."""

    def __init__(self, given: Given, team: int) -> None:
        self.given, self.team = given, team

    def play(self, record: Record, control: Control) -> None:
        """Play runs, one after another."""
        if self.team > 1:
            self._play_together(record, control)
            return
        given, shared = self.given, self.given.control(control)
        complete = given.engine.feasibee_play(*given.job, record.first_run, given.outcome(record), shared)
        given.check(shared, complete, record, int(complete))

    def _play_together(self, record: Record, control: Control) -> None:
        given, shared, outcome = self.given, self.given.control(control), self.given.outcome(record)
        crowd = given.engine.feasibee_crowd_new(*given.job, self.team)
        if not crowd:
            raise MemoryError(NO_MEMORY)
        try:
            with ThreadPoolExecutor(self.team) as pool:
                for row in range(record.runs):
                    run = crowd, record.first_run + row, row, outcome, shared
                    part = partial(given.engine.feasibee_crowd_run, *run)
                    given.check(shared, min(pool.map(part, range(self.team))), record, row)
                    if control.cancelled[0]:
                        return
        finally:
            given.engine.feasibee_crowd_free(crowd)


class AnyWorld:
    """Plays runs by the general path, each by so many threads."""

    def __init__(self, given: Given, team: int) -> None:
        self.given, self.team = given, team
        self.room = Room.first(given.params)  # has sufficed so far, for all chunks; it changes no result

    def play(self, record: Record, control: Control) -> None:
        """Play runs, one after another; where an inbox has no room, play that run again with more."""
        complete = 0
        while complete < record.runs and not control.cancelled[0]:
            state = State(self.given, self.room, self.team)
            rest = record.part(complete, record.runs)
            complete += self._play_some(state, rest, control)
            if state.struct.clock.full:
                self.room = state.enlarged()

    def _play_some(self, state: State, record: Record, control: Control) -> int:
        """Play runs until one isn't complete; return how many are."""
        given, row = self.given, 0
        shared, outcome = given.control(control), given.outcome(record)
        if self.team == 1:
            row = given.engine.feasibee_play_any(state.struct, record.first_run, outcome, shared)
            given.check(shared, row, record, row)
            return int(row)
        steps = given.params.run.steps
        with ThreadPoolExecutor(self.team) as pool:
            for row in range(record.runs):
                state.start(record.first_run + row)
                record.decision[row], record.decision_step[row] = UNDECIDED, -1
                part = partial(given.engine.feasibee_advance, state.struct, row, steps, outcome, shared)
                list(pool.map(part, range(self.team)))
                given.check(shared, 0, record, row)
                if state.struct.clock.full or control.cancelled[0]:
                    return row
        return record.runs
