// Jumps to other steps of a run. One is on its way at a time; of those wanted meanwhile, the last one counts.

/** @typedef {{to: number | "decision", lane: number}} Goal Where to go, or to the decision of which swarm. */

export class Seeker {
  /** @param {(message: object) => void} send */
  constructor(send) {
    this.send = send;
    this.jump = 0; // number of the last jump, which the frames after it have
    /** @type {Goal | null} */
    this.goal = null; // on its way
    /** @type {Goal | null} */
    this.next = null;
  }

  // Forget all: another run has begun, or the connection is lost.
  reset() {
    this.jump = 0;
    this.goal = this.next = null;
  }

  /**
   * Return the step that is wanted, or the one that is shown.
   * @param {number} shown
   */
  from(shown) {
    const { to } = this.next ?? this.goal ?? { to: shown };
    return to === "decision" ? shown : to;
  }

  /** @param {Goal} goal */
  seek(goal) {
    if (this.goal) {
      this.next = goal;
      return;
    }
    this.goal = goal;
    this.jump = (this.jump + 1) % 256;
    this.send({ type: "seek", ...goal, jump: this.jump });
  }

  /**
   * Go once more to where the page goes, or is: the frame brings what is asked for now.
   * @param {number} shown
   */
  again(shown) {
    this.seek(this.next ?? this.goal ?? { to: shown, lane: 0 });
  }

  // The frame of a jump has come: go on to the next one, if any; return whether there is none.
  arrive() {
    const { next } = this;
    this.goal = this.next = null;
    if (next) this.seek(next);
    return !next;
  }
}
