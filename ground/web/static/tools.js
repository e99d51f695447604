// SPDX-License-Identifier: GPL-3.0-or-later
// Drawing on the map: waypoints to fly along, and the area that the drone may not leave.

import { $ } from "./dom.js";
import * as marks from "./marks.js";

const HIT_PX = 18;
const SMALL_PX = 10; // a rectangle as small as this was a slip

export class Tools {
  constructor({ wish, camera, changed }) {
    Object.assign(this, { wish, camera, changed });
    this.mode = null; // "points", "area"
    this.points = [];
    this.sent = []; // what was flown or patrolled last
    this.held = -1; // the point that is being dragged
    this.area = null; // [x0, y0, x1, y1], as drawn
    this.corner = null; // where the keyboard began it
    for (const mode of ["points", "area"]) {
      $(`tool-${mode}`).onclick = () => this.enter(this.mode === mode ? null : mode);
    }
    $("draft-fly").onclick = () => this.send("fly");
    $("draft-patrol").onclick = () => this.send("patrol");
    $("draft-use").onclick = () => this.send("area");
    $("draft-undo").onclick = () => this.undo();
    $("draft-clear").onclick = () => this.clear();
    $("draft-leave").onclick = () => this.enter(null);
  }

  enter(mode) {
    this.mode = mode;
    this.area = this.corner = null;
    if (mode) this.sent = [];
    else this.points = [];
    this.show();
    if (mode) $("map").focus({ preventScroll: true });
  }

  /** A finger or button goes down: what it may drag. */
  grab(px, py) {
    if (this.mode === "points") return this.grabPoint(this.hit(px, py));
    return this.mode === "area" ? this.grabArea([px, py]) : null;
  }

  grabPoint(n) {
    if (n < 0) return null;
    const before = this.points[n];
    this.held = n;
    const put = (point) => {
      this.points[n] = point;
      this.show();
    };
    const drop = () => {
      this.held = -1;
      this.changed();
    };
    return {
      move: (px, py) => put(this.camera.toWorld(px, py)),
      drop,
      cancel: () => (put(before), drop()),
    };
  }

  grabArea(from) {
    const before = this.area;
    const start = this.camera.toWorld(...from);
    const put = (area) => {
      this.area = area;
      this.show();
    };
    return {
      move: (px, py) => put(box(start, this.camera.toWorld(px, py))),
      drop: (px, py) => Math.hypot(px - from[0], py - from[1]) < SMALL_PX && put(before),
      cancel: () => put(before),
    };
  }

  /** @return true if the tap was for drawing */
  tap(px, py) {
    if (this.mode === "points" && this.hit(px, py) < 0) this.mark(this.camera.toWorld(px, py));
    return this.mode !== null;
  }

  /** A point, or one corner of the area and then the other. */
  mark(place) {
    if (this.mode === "points") this.points.push(place);
    else this.corner = this.corner ? null : place;
    this.show();
  }

  /** The keyboard's cross moves: the area's second corner does. */
  stretch(place) {
    if (this.corner) this.area = box(this.corner, place);
    this.show();
  }

  hit(px, py) {
    return this.points.findLastIndex(([x, y]) => {
      const [qx, qy] = this.camera.toScreen(x, y);
      return Math.hypot(px - qx, py - qy) < HIT_PX;
    });
  }

  undo() {
    if (this.mode === "points") this.points.pop();
    else this.area = this.corner = null;
    this.show();
  }

  clear() {
    this.points = [];
    this.area = this.corner = null;
    this.show();
  }

  send(what) {
    if (what === "area") {
      if (!this.area) return;
      const [x0, y0, x1, y1] = this.area.map((v) => Math.round(100 * v) / 100);
      this.wish({ do: "area", x0, y0, x1, y1 });
      this.enter(null);
    } else if (this.points.length) {
      const sent = this.points;
      this.wish({ do: what, points: sent });
      this.enter(null);
      this.sent = sent;
      this.changed();
    }
  }

  /** What was sent came to nothing: it can be mended. */
  refused(what) {
    if ((what !== "fly" && what !== "patrol") || this.mode || !this.sent.length) return;
    const points = this.sent;
    this.enter("points");
    this.points = points;
    this.show();
  }

  /** Nothing of it concerns the drone any more. */
  forget() {
    this.sent = [];
    this.enter(null);
  }

  /** @return true if the key was for drawing */
  key(event) {
    if (!this.mode) return false;
    if (event.key === "Escape") this.enter(null);
    else if (event.key === "Backspace") this.undo();
    else if (event.key === "Enter") this.send(this.mode === "points" ? "fly" : "area");
    else return false;
    return true;
  }

  show() {
    const { mode, points, area } = this;
    for (const name of ["points", "area"]) $(`tool-${name}`).ariaPressed = String(mode === name);
    $("draft").hidden = !mode;
    $("draft").dataset.mode = mode ?? "";
    for (const id of ["draft-fly", "draft-patrol", "draft-undo"]) $(id).hidden = mode !== "points";
    $("draft-use").hidden = mode !== "area";
    for (const id of ["draft-fly", "draft-patrol", "draft-undo"]) $(id).disabled = !points.length;
    $("draft-use").disabled = !area;
    $("draft-clear").disabled = !points.length && !area;
    $("draft-text").value = mode === "area" ? areaWords(area) : pointWords(points.length);
    this.changed();
  }

  draw(on) {
    if (this.area) {
      marks.area(on, this.area, on.colours.accent);
      const [x0, y0, x1, y1] = this.area;
      const [px, py] = this.camera.toScreen((x0 + x1) / 2, (y0 + y1) / 2);
      marks.text(on, px, py, size(this.area));
    }
    if (this.points.length) marks.wayPoints(on, this.points, { held: this.held });
    else if (this.sent.length) marks.wayPoints(on, this.sent, { ghostly: true });
  }
}

function box([x0, y0], [x1, y1]) {
  return [Math.min(x0, x1), Math.min(y0, y1), Math.max(x0, x1), Math.max(y0, y1)];
}

function size([x0, y0, x1, y1]) {
  return `${(x1 - x0).toFixed(1)} × ${(y1 - y0).toFixed(1)} m`;
}

function areaWords(area) {
  return area ? size(area) : "Drag a box";
}

function pointWords(count) {
  if (!count) return "Mark places";
  return count === 1 ? "1 point" : `${count} points`;
}
