// Looking ahead in the runs that the page shows, a little at a time, until all marks of the seek bar are found.

import { colours } from "./theme.js";

/** @import { Lane } from "./lane.js" */
/** @import { SeekBar } from "./seekbar.js" */

const AGAIN = 30; // milliseconds between two looks

export class Ahead {
  /**
   * @param {SeekBar} seekBar
   * @param {() => Lane[]} lanes Those that the page shows.
   * @param {(message: object) => void} send
   */
  constructor(seekBar, lanes, send) {
    this.seekBar = seekBar;
    this.lanes = lanes;
    this.send = send;
    this.timer = 0;
  }

  // Show what is found.
  mark() {
    this.seekBar.mark(
      this.lanes().map((each) => each.outlook),
      colours(),
    );
  }

  /**
   * Ask the server for more; later if it is busy.
   * @param {() => boolean} isBusy
   */
  look(isBusy) {
    clearTimeout(this.timer);
    const lane = this.lanes().find((each) => each.world && !each.outlook.done);
    if (!lane) return;
    if (isBusy()) return this.lookSoon(isBusy);
    const { robot, changes, world } = lane.outlook;
    this.send({ type: "look", robot, lane: lane.number, first: changes.length, seen: world.length });
  }

  /** @param {() => boolean} isBusy */
  lookSoon(isBusy) {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.look(isBusy), AGAIN);
  }
}
