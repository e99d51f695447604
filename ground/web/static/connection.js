// SPDX-License-Identifier: GPL-3.0-or-later
// The WebSocket to the ground station: opened again whenever it is gone.

const RECONNECT_MS = 1000;
const STALE_MS = 2000;

export class Connection extends EventTarget {
  #socket = null;
  #heardAt = -Infinity;

  /** Events: "open", "close", "cells" (a map, binary) and "message" (all else, read). */
  open() {
    const socket = (this.#socket = new WebSocket(`ws://${location.host}/socket`));
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.dispatchEvent(new Event("open"));
    socket.onmessage = ({ data }) => {
      this.#heardAt = performance.now();
      if (data instanceof ArrayBuffer) this.#tell("cells", data);
      else this.#take(JSON.parse(data));
    };
    socket.onclose = () => {
      this.dispatchEvent(new Event("close"));
      setTimeout(() => this.open(), RECONNECT_MS);
    };
  }

  /** The server waits for who says what it has taken: else a slow page would show the past. */
  #take(message) {
    this.#tell("message", message);
    if (message.kind === "state") this.send({ do: "taken" });
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /** Open, but nothing comes. */
  get isSilent() {
    return this.isOpen && performance.now() - this.#heardAt > STALE_MS;
  }

  /** @returns {boolean} whether it could be sent */
  send(what) {
    if (this.isOpen) this.#socket.send(JSON.stringify(what));
    return this.isOpen;
  }

  #tell(kind, detail) {
    this.dispatchEvent(new CustomEvent(kind, { detail }));
  }
}
