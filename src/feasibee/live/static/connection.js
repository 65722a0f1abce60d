// The WebSocket to the server. It reconnects after 0.5 s, and doubles the wait up to 8 s.

const FIRST_WAIT = 500,
  LONGEST_WAIT = 8000;

/**
 * @typedef {object} Handlers
 * @property {(message: any) => void} message JSON message of the server; see answers in main.js.
 * @property {(buffer: ArrayBuffer) => void} binary
 * @property {(wait: number) => void} lost With the milliseconds until the next attempt.
 */

export class Connection {
  /** @param {Handlers} handlers */
  constructor(handlers) {
    this.handlers = handlers;
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
      if (typeof event.data !== "string") return this.handlers.binary(event.data);
      const message = JSON.parse(event.data);
      if (message.type === "welcome") this.wait = FIRST_WAIT;
      this.handlers.message(message);
    };
    socket.onclose = () => {
      if (socket !== this.socket) return;
      this.handlers.lost(this.wait);
      this.timer = setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(2 * this.wait, LONGEST_WAIT);
    };
  }

  /** @param {object} message */
  send(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }
}
