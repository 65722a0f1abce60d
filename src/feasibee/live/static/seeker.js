// Jumps to other steps of a run. One is on its way at a time; of those wanted meanwhile, the last one counts.

/** @typedef {{to: number | "decision", lane: number}} Goal */

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

  get busy() {
    return this.goal !== null;
  }

  /**
   * Return the step that is wanted, or the one that is shown.
   * @param {number} shown
   */
  from(shown) {
    const { to } = this.next ?? this.goal ?? { to: shown };
    return to === "decision" ? shown : to;
  }

  /**
   * @param {number | "decision"} to
   * @param {number} lane Swarm whose decision is meant.
   */
  seek(to, lane = 0) {
    if (this.goal) {
      this.next = { to, lane };
      return;
    }
    this.goal = { to, lane };
    this.jump = (this.jump + 1) % 256;
    this.send({ type: "seek", to, lane, jump: this.jump });
  }

  /**
   * Go once more to where the page goes, or is: the frame brings what is asked for now.
   * @param {number} shown
   */
  again(shown) {
    const { to, lane } = this.next ?? this.goal ?? { to: shown, lane: 0 };
    this.seek(to, lane);
  }

  // The frame of a jump has come: go on to the next one, if any; return whether there is none.
  arrive() {
    const { next } = this;
    this.goal = this.next = null;
    if (next) this.seek(next.to, next.lane);
    return !next;
  }
}
