// Add tasks and robots at points, move them and take them away, with the pointer: each is an event of the scenario.

import { announce } from "./elements.js";

/** @typedef {"robot" | "task"} Kind */

/**
 * Return the tools that change what is there.
 * @param {Page} page
 * @returns {Record<string, Tool>}
 */
export function handTools(page) {
  /** @type {(kind: Kind) => Tool} */
  const adding = (kind) => ({
    label: `Add ${kind}s`,
    help: `Click where a ${kind} is to ${kind === "task" ? "appear" : "join"}.`,
    end: (place) => page.happen({ [`${kind}s`]: 1, at: pointAt(place, kind) }, `one more ${kind}`),
  });
  return {
    task: adding("task"),
    robot: adding("robot"),
    move: {
      label: "Move",
      help: "Drag a robot or a task to another place.",
      begin: (place) => {
        const thing = thingAt(place);
        return thing && { ...thing, from: place.arena.unitsAt(place) };
      },
      move: (place, held) => held && page.tools.sketch([held.from, pointAt(place, held.kind)]),
      end: (place, held) => {
        if (!held) return;
        const { kind, number } = held;
        page.happen({ [kind]: number, at: pointAt(place, kind) }, `${kind} ${number} is elsewhere`);
      },
    },
    remove: {
      label: "Remove",
      help: "Click a robot or a task to take it away.",
      end: (place) => {
        const { kind, number } = thingAt(place) ?? {};
        if (kind) page.happen({ [kind]: number }, `${kind} ${number} is gone`);
      },
    },
  };
}

/** @param {Place} place Of the robot or task that is returned, if any is near. */
function thingAt(place) {
  const found = place.arena.thingAt(place);
  if (!found) announce("There is no robot or task.");
  return found;
}

/**
 * Return the point of a place, within what the scenario allows.
 * @param {Place} place
 * @param {Kind} kind
 * @returns {[number, number]}
 */
function pointAt(place, kind) {
  const { arena } = place,
    { size, walls, diameter } = arena.world,
    margin = walls && kind === "robot" ? diameter / 2 : 0,
    edge = walls ? margin : arena.longer / 1e4, // on a torus, the far edge is the near one
    [x, y] = arena
      .unitsAt(place)
      .map((each, k) => Math.max(margin, Math.min(size[k] - edge, Number(each.toPrecision(4)))));
  return [x, y];
}
