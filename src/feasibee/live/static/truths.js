// The truth over the steps of a run as a band, full where it is feasible and striped where it isn't.

/** @typedef {[number, number, number, number]} Change Step, robots, tasks, truth from there on. */

/**
 * Return the changes of the truth among those of the world, with the truth at the start.
 * @param {Change[]} world
 * @returns {[number, number][]} Step and truth.
 */
export function truthsOf(world) {
  return world
    .filter(([, , , truth], k) => !k || truth !== world[k - 1][3])
    .map(([step, , , truth]) => [step, truth]);
}

/**
 * Draw one stretch of the band.
 * @param {CanvasRenderingContext2D} pen
 * @param {{x: number, y: number, width: number, height: number}} box
 * @param {boolean} truth
 * @param {Record<"feasible" | "infeasible", string>} colours
 * @param {number} grain Width of a line, in the pen's units.
 */
export function drawTruth(pen, { x, y, width, height }, truth, colours, grain) {
  if (truth) {
    pen.fillStyle = colours.feasible;
    pen.fillRect(x, y, width, height);
    return;
  }
  pen.save();
  pen.beginPath();
  pen.rect(x, y, width, height);
  pen.clip();
  pen.strokeStyle = colours.infeasible;
  pen.lineWidth = 1.6 * grain;
  pen.beginPath();
  const gap = 4 * grain;
  for (let at = gap * Math.floor((x - height) / gap); at < x + width; at += gap) {
    pen.moveTo(at, y + height);
    pen.lineTo(at + height, y);
  }
  pen.stroke();
  pen.restore();
}
