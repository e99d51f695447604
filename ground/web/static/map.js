// SPDX-License-Identifier: GPL-3.0-or-later
// Everything in the map's part of the page: what is drawn there, and what is done there.

import { View, parseMap } from "./view.js";

const DRAG_PX = 6;
const $ = (id) => document.getElementById(id);

export class MapPanel {
  /** wish() sends to the server, toast() tells the user. */
  constructor({ wish, toast }) {
    this.wish = wish;
    this.toast = toast;
    this.view = new View($("map"));
    this.state = null;
    this.trail = [];
    this.wanted = null; // the goal just clicked, until the drone takes or refuses it
    this.listen($("map"));
    $("zoom-in").onclick = () => this.view.zoom(1.3);
    $("zoom-out").onclick = () => this.view.zoom(1 / 1.3);
    $("fit").onclick = () => (this.view.auto = true);
    $("ages").onclick = () => ($("ages").ariaPressed = String($("ages").ariaPressed !== "true"));
    requestAnimationFrame(() => this.frame());
  }

  /** A state message of the server. */
  take(message) {
    const { can, map } = (this.state = message);
    this.trail = [...this.trail.slice(0, message.trail_from), ...message.trail];
    $("map").style.cursor = can.goto ? "crosshair" : "default";
    $("hint").hidden = !can.goto || this.trail.length > 0;
    this.view.ages = $("ages").ariaPressed === "true" ? map.ages_s : null;
  }

  /** A map message. */
  takeCells(buffer) {
    this.view.setMap(parseMap(buffer));
  }

  /** Any other message; those that are not about the map are left alone. */
  takeOther() {}

  /** A wish of that name was answered. */
  answered(what) {
    if (what === "goto") this.wanted = null;
  }

  /** Another drone is looked at. */
  forget() {
    this.wanted = null;
    this.view.forget();
  }

  frame() {
    const { state, view } = this;
    view.draw(state?.drone, state?.route ?? [], this.trail, this.wanted ?? state?.drone.goal, state?.fleet ?? []);
    this.showScale();
    requestAnimationFrame(() => this.frame());
  }

  showScale() {
    const metres = [0.5, 1, 2, 5, 10].find((m) => m * this.view.scale >= 60) ?? 10;
    $("scale-bar").style.width = `${metres * this.view.scale}px`;
    $("scale-text").textContent = `${metres} m`;
  }

  setGoal(px, py) {
    if (!this.state?.can.goto) return;
    const [x, y] = this.view.toWorld(px, py);
    this.wanted = [x, y];
    this.wish({ do: "goto", x, y });
  }

  listen(canvas) {
    const touches = new Map();
    let moved = 0;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      if (!touches.size) moved = 0;
      touches.set(event.pointerId, [event.offsetX, event.offsetY]);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = touches.get(event.pointerId);
      if (!before) return;
      const now = [event.offsetX, event.offsetY];
      const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
      moved += Math.hypot(dx, dy);
      const other = [...touches].find(([id]) => id !== event.pointerId)?.[1];
      if (other) {
        const [was, is] = [before, now].map((p) => Math.hypot(p[0] - other[0], p[1] - other[1]));
        if (was > 1) this.view.zoom(is / was, ...other);
      } else if (moved > DRAG_PX) {
        this.view.pan(dx, dy);
      }
      touches.set(event.pointerId, now);
    });
    canvas.addEventListener("pointerup", (event) => {
      const alone = touches.size === 1;
      touches.delete(event.pointerId);
      if (alone && moved <= DRAG_PX && event.button === 0) this.setGoal(event.offsetX, event.offsetY);
    });
    canvas.addEventListener("pointercancel", (event) => touches.delete(event.pointerId));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.view.zoom(Math.exp(-event.deltaY / 400), event.offsetX, event.offsetY);
    }, { passive: false });
  }
}
