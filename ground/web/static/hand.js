// SPDX-License-Identifier: GPL-3.0-or-later
// Flying by hand: held keys, held buttons on the screen and a gamepad become one stick, sent twenty
// times a second while it is deflected. The drone brakes before obstacles, whatever the stick says.

import { $ } from "./dom.js";

const PERIOD_MS = 50;
const RESTS = 4; // so often "let go" is sent
const TURN_DPS = 60;
const CLIMB_MPS = 0.25;
const DEAD_ZONE = 0.15;
const KEYS = {
  ArrowUp: [1, 0, 0, 0],
  ArrowDown: [-1, 0, 0, 0],
  ArrowLeft: [0, 1, 0, 0],
  ArrowRight: [0, -1, 0, 0],
  KeyA: [0, 0, 1, 0],
  KeyD: [0, 0, -1, 0],
  KeyW: [0, 0, 0, 1],
  KeyS: [0, 0, 0, -1],
};
const REST = [0, 0, 0, 0];
const FIELDS = "input, textarea, select, [contenteditable]";

export class Hand {
  #send;
  #held = new Set();
  #on = false;
  #state = null;
  #rests = RESTS;
  #timer = 0;

  /** send() is the connection's. */
  constructor(send) {
    this.#send = send;
    $("hand").onclick = () => this.toggle();
    $("hand-speed").oninput = () => this.#showSpeed();
    addEventListener("keydown", (event) => this.#onKey(event, true), { capture: true });
    addEventListener("keyup", (event) => this.#onKey(event, false), { capture: true });
    addEventListener("blur", () => this.letGo());
    document.addEventListener("visibilitychange", () => document.hidden && this.letGo());
    for (const button of document.querySelectorAll("[data-key]")) this.#listenTo(button);
    this.#showSpeed();
  }

  toggle(on = !this.#on) {
    this.#on = on;
    this.letGo();
    $("hand").ariaPressed = String(on);
    $("hand-panel").hidden = !on;
    clearInterval(this.#timer);
    if (!on) return;
    this.#rests = RESTS;
    this.#timer = setInterval(() => this.#tick(), PERIOD_MS);
    const { can, mission } = this.#state ?? {};
    if (can?.hold && mission.state !== "HOVER") this.#send({ do: "hold" });
    this.show();
  }

  letGo() {
    this.#held.clear();
    this.#showKeys();
  }

  /** A state message of the server. */
  take(state) {
    this.#state = state;
    $("hand").disabled = !this.#on && !state.can.take_off && !state.can.manual;
    if (this.#on && (state.replay || state.stop.latched)) this.toggle(false);
    if (this.#on) this.show();
  }

  /** Rows of the parameter message: the drone is never faster than way.speed. */
  takeParameters(rows) {
    const most = rows.find(({ name }) => name === "way.speed")?.value;
    if (most) $("hand-speed").max = most;
    this.#showSpeed();
  }

  show() {
    const { can, mission } = this.#state ?? {};
    $("hand-hint").textContent = can?.manual
      ? "Hold a key to move, let go and it stands. It brakes before obstacles."
      : can?.take_off
        ? "Take off first: then these keys fly it."
        : `Wait until it holds its place (${mission?.words ?? "no data yet"}).`;
  }

  #tick() {
    const stick = this.#stick();
    const still = stick.every((part) => part === 0);
    this.#rests = still ? this.#rests + 1 : 0;
    if (this.#rests > RESTS || !this.#state?.can.manual) return;
    const speed = Number($("hand-speed").value);
    const [ahead, left, turn, up] = stick;
    this.#send({ do: "manual", vx: ahead * speed, vy: left * speed, yaw: turn * TURN_DPS, up: up * CLIMB_MPS });
  }

  /** Ahead, left, turn left, up: each from -1 to 1. */
  #stick() {
    const sum = [...this.#held].reduce((all, code) => all.map((part, i) => part + KEYS[code][i]), REST);
    const both = this.#gamepad().map((part, i) => Math.max(-1, Math.min(1, part + sum[i])));
    const length = Math.hypot(both[0], both[1]);
    return length > 1 ? [both[0] / length, both[1] / length, both[2], both[3]] : both;
  }

  /** As drones are flown: left stick climbs and turns, right stick moves. */
  #gamepad() {
    const pad = navigator.getGamepads?.().find((one) => one?.connected && one.axes.length >= 4);
    $("hand-pad").textContent = pad ? "Gamepad connected: right stick moves, left stick climbs and turns." : "";
    if (!pad) return REST;
    const [turn, climb, right, back] = pad.axes.map((axis) => (Math.abs(axis) < DEAD_ZONE ? 0 : axis));
    return [-back, -right, -turn, -climb];
  }

  #onKey(event, down) {
    const { code, target } = event;
    const elsewhere = target.closest?.(FIELDS) || (event.shiftKey && target.id === "map"); // its cross
    const used = this.#on && code in KEYS && !elsewhere && !event.ctrlKey && !event.metaKey;
    if (!used && (down || !this.#held.has(code))) return;
    event.preventDefault();
    event.stopPropagation();
    this.#hold(code, down);
  }

  #listenTo(button) {
    const { key } = button.dataset;
    button.onpointerdown = (event) => {
      button.setPointerCapture(event.pointerId);
      this.#hold(key, true);
    };
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      button.addEventListener(end, () => this.#hold(key, false));
    }
    button.oncontextmenu = (event) => event.preventDefault();
  }

  #hold(code, down) {
    if (down) this.#held.add(code);
    else this.#held.delete(code);
    this.#showKeys();
    if (this.#on) this.#tick();
  }

  #showKeys() {
    for (const button of document.querySelectorAll("[data-key]")) {
      button.classList.toggle("held", this.#held.has(button.dataset.key));
    }
  }

  #showSpeed() {
    $("hand-speed-text").value = `${Number($("hand-speed").value).toFixed(2)} m/s`;
  }
}
