// SPDX-License-Identifier: GPL-3.0-or-later
// The map by keyboard: + and - everywhere; the rest while the map has the focus. Plain arrows are
// left to flying by hand.

import { TURN_RAD, ZOOM } from "./camera.js";

const STEP_M = 0.1;
const ARROWS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const EDGE_PX = 40;

export class Keys {
  /** panel: the MapPanel. */
  constructor(canvas, panel) {
    this.panel = panel;
    this.cross = null; // world; the place that the keyboard moves about
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !this.onMap(event)) return;
      event.preventDefault();
      event.stopPropagation();
      panel.changed();
    });
    addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target)) return;
      if (this.anywhere(event)) event.preventDefault();
    });
  }

  anywhere(event) {
    const factor = { "+": ZOOM, "=": ZOOM, "-": 1 / ZOOM }[event.key];
    if (factor) {
      this.panel.camera.zoom(factor);
      this.panel.changed();
      return true;
    }
    const onButton = event.target.closest?.("button, a, summary");
    return !(onButton && event.key === "Enter") && this.panel.tools.key(event);
  }

  onMap(event) {
    const { camera, tools } = this.panel;
    if (event.shiftKey && ARROWS[event.key]) this.move(...ARROWS[event.key]);
    else if (event.key === ",") camera.turn(TURN_RAD);
    else if (event.key === ".") camera.turn(-TURN_RAD);
    else if (event.key === "0") camera.mode = "fit";
    else if (event.key === "f") camera.mode = "follow";
    else if (event.key === "p" && tools.mode) this.mark();
    else if (event.key === "Enter" && this.cross && !tools.mode) this.panel.go(this.cross);
    else if (event.key === "Escape" && this.cross && !tools.mode) this.hide();
    else return false;
    return true;
  }

  move(dx, dy) {
    const { camera, tools } = this.panel;
    const [w, h] = camera.size;
    this.cross ??= camera.toWorld(w / 2, h / 2).map((v) => Math.round(v / STEP_M) * STEP_M);
    const [px, py] = camera.toScreen(...this.cross);
    const to = camera.toWorld(px + dx * STEP_M * camera.scale, py - dy * STEP_M * camera.scale);
    this.cross = to.map((v) => Math.round(v * 1000) / 1000);
    const [qx, qy] = camera.toScreen(...this.cross);
    const inside = qx > EDGE_PX && qy > EDGE_PX && qx < w - EDGE_PX && qy < h - EDGE_PX;
    if (!inside) camera.pan(-dx * STEP_M * camera.scale, dy * STEP_M * camera.scale);
    tools.stretch(this.cross);
    this.panel.look(this.cross);
  }

  mark() {
    if (!this.cross) this.move(0, 0);
    this.panel.tools.mark(this.cross);
  }

  hide() {
    this.cross = null;
    this.panel.preview.clear();
  }
}

function isTyping(target) {
  return target instanceof HTMLElement && target.matches("input:not([type=checkbox]), textarea, select");
}
