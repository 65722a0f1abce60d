// The WebSocket to the server. It reconnects after 0.5 s, and doubles the wait up to 8 s.

import { decode } from "./frames.js";

const FIRST_WAIT = 500,
  LONGEST_WAIT = 8000;

export class Connection {
  /**
   * @param {(message: any) => void} receive A message of the server; see answers in main.js.
   * @param {(wait: number) => void} lost With the milliseconds until the next attempt.
   */
  constructor(receive, lost) {
    this.receive = receive;
    this.lost = lost;
    this.wait = FIRST_WAIT;
    this.open();
  }

  open() {
    clearTimeout(this.timer);
    const address = new URL("swarm", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    address.hash = "";
    const socket = (this.socket = new WebSocket(address));
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event) => {
      if (socket !== this.socket) return;
      const message = typeof event.data === "string" ? JSON.parse(event.data) : decode(event.data);
      if (message.type === "welcome") this.wait = FIRST_WAIT;
      this.receive(message);
    };
    socket.onclose = () => {
      if (socket !== this.socket) return;
      this.lost(this.wait);
      this.timer = setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, LONGEST_WAIT);
    };
  }

  /** @param {object} message */
  send(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}
