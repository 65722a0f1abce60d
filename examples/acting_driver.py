"""Drive one robot that does tasks: python acting_driver.py 0 mine.toml. Body and tasks are simulated here."""

import json
import math
import subprocess
import sys

TASKS, SIGHT, SPEED, REACH = [(2.0, 3.0), (6.0, 5.0)], 20.0, 1.0, 1.0
number, scenario = sys.argv[1:3]
command = ["feasibee", "robot", "join", scenario, "--id", number, "--senses", "/dev/stdin"]
mind = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
place, going, others = (8.0, 9.0), None, {1: 1}  # another robot of rank 1 has task 1

while True:
    acts = []
    if going:
        far = math.dist(place, going) or 1.0
        place = tuple(p + min(SPEED, far) * (g - p) / far for p, g in zip(place, going, strict=True))
        if math.dist(place, going) <= REACH:  # the status that your sensors see there: 0 is free
            nearest = min(range(len(TASKS)), key=lambda k: math.dist(TASKS[k], going))
            acts = [["reached", others.get(nearest, 0)]]
    seen = [k for k, task in enumerate(TASKS) if math.dist(place, task) <= SIGHT]
    see = [[0, k, 0, 0, *TASKS[k], k] for k in seen]
    taken = [[k, others[k]] for k in seen if k in others]
    sensed = {"place": place, "see": see, "taken": taken, "acts": acts}
    print(json.dumps(sensed), file=mind.stdin, flush=True)
    answer = json.loads(mind.stdout.readline())
    going = answer["go"]
    print(answer["step"], "stands" if answer["stand"] else f"goes to {going}" if going else "walks about")
    if answer["stand"]:
        break
mind.stdin.close()
