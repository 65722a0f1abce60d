"""Send two robots at a time for as long as the swarm says *infeasible*, as an operator would.

An event that is added for a later step changes no step before it. So whoever sends robots adds an event, and
plays the run again up to this step. ``robots.most`` is set, since it would otherwise grow with each event.
"""

import feasibee

PATIENCE, DELAY, SENT = 60, 50, 2
"""Steps of *infeasible* in a row, longer than news takes; steps until robots come, and how many do."""
SCENARIO = feasibee.Scenario(
    robots={"count": 20, "most": 40},
    tasks={"count": 16},
    decision={"strategy": "roster"},
    events=[{"step": 300, "tasks": 10}],
    run={"steps": 1000},
)


def serve(scenario, seed=0):
    """Return the swarm at the end of a run, and the steps at which robots were sent."""
    swarm, events, sent, held_for = feasibee.Swarm(scenario, seed), scenario.to_dict()["events"], [], 0
    while swarm.step < scenario.run.steps:
        swarm.advance()
        held_for = held_for + 1 if swarm.decision == 0 else 0
        if held_for == PATIENCE and swarm.step + DELAY <= scenario.run.steps:
            sent.append(swarm.step)
            events.append({"step": swarm.step + DELAY, "robots": SENT})
            swarm = feasibee.Swarm(scenario.replace({"events": events}), seed)
            swarm.advance(sent[-1])
            held_for = -DELAY  # whether more are needed shows once these are there
    return swarm, sent


if __name__ == "__main__":
    swarm, sent = serve(SCENARIO)
    robots, tasks = swarm.robot_counts[-1], swarm.task_counts[-1]
    print(f"Two robots were sent at each of the steps {', '.join(map(str, sent))}.")
    print(f"At the end {robots} robots have {tasks} tasks, and the decision is {swarm.decision}.")
