// SPDX-License-Identifier: GPL-3.0-or-later
// STOP: cuts all motors at once. Pressed is pressed: what does not reach the ground station now goes
// out as soon as it can, by WebSocket or as a plain request.

import { $, say } from "./dom.js";

const AGAIN_MS = 250;
// A field for numbers takes no space: it is no text field.
const TEXT_FIELDS = "input:not([type=range], [type=number], [type=checkbox], [type=radio]), textarea";

export class Stop {
  #connection;
  #pressed = false; // here, and not known to the ground station yet
  #latched = false;
  #confirmed = false;
  #replay = false;
  #several = false;
  #timer = 0;

  constructor(connection) {
    this.#connection = connection;
    $("stop").onclick = () => this.press();
    $("release").onclick = () => this.release();
    connection.addEventListener("open", () => this.#pressed && this.#send());
    connection.addEventListener("close", () => this.show());
    addEventListener("keydown", (event) => this.#onKey(event), { capture: true });
    addEventListener("keyup", (event) => this.#isStop(event) && event.preventDefault(), { capture: true });
  }

  press() {
    if (this.#replay) return;
    this.#pressed = true;
    this.#send();
    this.show();
  }

  release() {
    this.#pressed = false;
    this.#connection.send({ do: "release" });
    this.show();
  }

  /** A state message of the server. */
  take({ stop, replay, fleet, alone }) {
    this.#latched = stop.latched;
    this.#confirmed = stop.confirmed;
    this.#replay = Boolean(replay);
    this.#several = fleet.length > 1;
    if (stop.latched) this.#pressed = false;
    say($("alone"), alone && `The drone itself: ${alone}.`);
    this.show();
  }

  get on() {
    return this.#pressed || this.#latched || this.#confirmed;
  }

  /** What the page says of the drone while a stop is on. */
  get headline() {
    return this.on && (this.#confirmed ? "stopped" : "stopping");
  }

  show() {
    const { isOpen } = this.#connection;
    const all = this.#several;
    $("stop").hidden = this.#latched || this.#pressed;
    say($("stop-whom"), all ? "cuts all motors, all drones fall" : "cuts the motors, the drone falls");
    $("latched").hidden = !this.on;
    $("release").hidden = !this.#latched && !this.#pressed;
    say($("latched-text"), this.#words(isOpen, all ? "Each drone" : "The drone"));
    $("unreachable").hidden = isOpen;
  }

  #words(isOpen, who) {
    if (this.#pressed && !isOpen) {
      return "STOP has NOT gone out: this page cannot reach the ground station. It is tried again and again.";
    }
    if (!this.#confirmed) return `STOP is being sent, again and again, until ${who.toLowerCase()} confirms it.`;
    const stays = `The motors are cut. ${who} stays locked until it is restarted: switch it off and on.`;
    return this.#latched ? `${stays} Release lets pages command again.` : stays;
  }

  #send() {
    clearTimeout(this.#timer);
    if (!this.#pressed) return;
    if (!this.#connection.send({ do: "stop" })) fetch("/stop", { method: "POST" }).catch(() => {});
    this.#timer = setTimeout(() => this.#send(), AGAIN_MS);
  }

  /** Space is STOP everywhere but in a text field, also on a focused button. */
  #onKey(event) {
    if (!this.#isStop(event)) return;
    event.preventDefault();
    event.stopPropagation();
    if (!event.repeat) this.press();
  }

  #isStop({ code, target }) {
    return code === "Space" && !this.#replay && !target.closest?.(TEXT_FIELDS);
  }
}
