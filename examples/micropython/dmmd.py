"""DMMD for MicroPython: the decisions of ``feasibee.robot.Controller``, in one file that imports nothing.

``feasibee.robot`` needs ``typing``, ``dataclasses`` and ``fractions``, which MicroPython lacks. The tests run
this file in MicroPython and compare each step with the controller.
"""


class Robot:
    """The controller of one robot: explore, disseminate, decide by the majority.

    Parameters
    ----------
    opinion : int
        The first opinion: 1 feasible, 0 infeasible; a fair coin.
    draw_duration : callable
        Given a mean in steps, draws how many whole steps a phase lasts: at least 1.
    exploration : float
        Mean duration of exploration, in steps.
    gain : float
        Mean steps of dissemination for an opinion of quality 1.
    inbox_size : int
        Number of different robots whose latest messages it keeps, the newest.
    quorum : tuple of int, optional
        Numerator and denominator of the least share of an inbox that must agree with the opinion before the
        robot declares its opinion; by default it never does.
    rounds : int
        Number of successive decisions with such an inbox.
    heard : int
        Least number of messages in such an inbox.
    """

    def __init__(
        self,
        opinion,
        draw_duration,
        exploration=10.0,
        gain=10.0,
        inbox_size=32,
        quorum=None,
        rounds=3,
        heard=3,
    ):
        self.opinion = opinion
        self.declared = -1
        self._draw_duration = draw_duration
        self._exploration = exploration
        self._gain = gain
        self._inbox_size = inbox_size
        self._rule = (quorum, rounds, heard)
        self._agreed = 0
        self._explore()

    def observe(self, robots, tasks):
        """Count robots and tasks in sight while exploring."""
        if not self.disseminating:
            self.robots_seen += robots
            self.tasks_seen += tasks

    def hear(self, sender, opinion):
        """Keep the latest opinion of each sender."""
        self._inbox = [pair for pair in self._inbox if pair[0] != sender]
        self._inbox.append((sender, opinion))
        if len(self._inbox) > self._inbox_size:
            self._inbox.pop(0)

    def message(self):
        """Return the opinion to broadcast in this step with ``declared``, None while exploring."""
        return self._said if self.disseminating else None

    def end_step(self):
        """End a step; if its phase ends, the robot changes phase."""
        self.phase_left -= 1
        if self.phase_left == 0:
            if self.disseminating:
                self._decide()
                self._explore()
            else:
                self._disseminate()

    def _explore(self):
        self.disseminating = False
        self.robots_seen = self.tasks_seen = 0
        self._inbox = []
        self.phase_left = self._draw_duration(self._exploration)

    def _disseminate(self):
        seen = self.robots_seen + self.tasks_seen
        quality = self.robots_seen / seen if seen else 0.5
        if self.opinion == 0:
            quality = 1.0 - quality
        self.disseminating = True
        self._said = self.opinion
        self.phase_left = self._draw_duration(self._gain * quality)

    def _decide(self):
        heard = len(self._inbox)
        feasible = sum(opinion for _, opinion in self._inbox)
        balance = 2 * feasible - heard + (1 if self.opinion == 1 else -1)  # its own vote included
        if balance and self.declared == -1:
            self.opinion = 1 if balance > 0 else 0
        self._declare_by_votes(feasible if self.opinion == 1 else heard - feasible, heard)

    def _declare_by_votes(self, agreeing, heard):
        quorum, rounds, least = self._rule
        agrees = quorum and heard >= least and agreeing * quorum[1] >= quorum[0] * heard
        self._agreed = self._agreed + 1 if agrees else 0
        if self.declared == -1 and quorum is not None and self._agreed >= rounds:
            self.declared = self.opinion
