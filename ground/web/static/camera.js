// SPDX-License-Identifier: GPL-3.0-or-later
// Which part of the world the map shows. World: metres, x to the right, y up; the map may be turned.

export const ZOOM = 1.3; // of one press on a key or button
export const TURN_RAD = Math.PI / 12;
const SCALE = [12, 600]; // CSS pixels a metre
const FIT_SCALE_MAX = 160;
const MARGIN_M = 0.6;
const TOOLS_PX = { top: 62, right: 58 }; // what lies over the map's edges
const GLIDE_MS = 110;
const STILL = 1e-3;
const AFTER_TOUCH_MS = 1000;

export class Camera {
  constructor(canvas) {
    this.canvas = canvas;
    this.measure();
    this.centre = [0, 0];
    this.scale = 60;
    this.angle = 0; // the map is turned so far, counter-clockwise
    this.mode = "fit"; // all that is known, and the goal; "follow": the drone; "free"
    this.coveredPx = 0; // at the lower edge
    this.heldUntilMs = 0;
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
  }

  /** The map's size on the screen, in CSS pixels; asking the browser for it is slow. */
  measure() {
    this.size = [this.canvas.clientWidth, this.canvas.clientHeight];
  }

  toWorld(px, py) {
    const [w, h] = this.size;
    const [x, y] = turned([(px - w / 2) / this.scale, (h / 2 - py) / this.scale], -this.angle);
    return [this.centre[0] + x, this.centre[1] + y];
  }

  toScreen(x, y) {
    const [w, h] = this.size;
    const [rx, ry] = turned([x - this.centre[0], y - this.centre[1]], this.angle);
    return [w / 2 + rx * this.scale, h / 2 - ry * this.scale];
  }

  /** All of the world that can be seen lies in this box: [x0, y0, x1, y1]. */
  get box() {
    const [w, h] = this.size;
    const corners = [[0, 0], [w, 0], [0, h], [w, h]].map(([px, py]) => this.toWorld(px, py));
    const [xs, ys] = [corners.map(([x]) => x), corners.map(([, y]) => y)];
    return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  }

  /** Let drawing be in metres, from the world's point (x, y) on, y up. */
  enter(context, x, y) {
    const [px, py] = this.toScreen(x, y);
    context.translate(px, py);
    context.rotate(-this.angle);
    context.scale(this.scale, -this.scale);
  }

  zoom(factor, px = this.size[0] / 2, py = this.size[1] / 2) {
    const before = this.toWorld(px, py);
    if (this.mode === "fit") this.mode = "free";
    this.scale = Math.min(SCALE[1], Math.max(SCALE[0], this.scale * factor));
    if (this.mode === "free") this.putAt(before, px, py);
  }

  turn(by, px = this.size[0] / 2, py = this.size[1] / 2) {
    const before = this.toWorld(px, py);
    this.angle = Math.atan2(Math.sin(this.angle + by), Math.cos(this.angle + by));
    if (Math.abs(this.angle) < STILL) this.angle = 0;
    if (this.mode === "free") this.putAt(before, px, py);
  }

  pan(dx, dy) {
    this.mode = "free";
    const [x, y] = turned([-dx / this.scale, dy / this.scale], -this.angle);
    this.centre = [this.centre[0] + x, this.centre[1] + y];
  }

  /** Let that point of the world lie there on the screen. */
  putAt([x, y], px, py) {
    const now = this.toWorld(px, py);
    this.centre = [this.centre[0] + x - now[0], this.centre[1] + y - now[1]];
  }

  /** Do not fit the map anew under a pointer: not while it is `down`, nor soon after it moved. */
  touched(down) {
    this.heldUntilMs = down ? Infinity : performance.now() + AFTER_TOUCH_MS;
  }

  /** The pointer has left the map. */
  untouched() {
    this.heldUntilMs = 0;
  }

  /** Move on towards what the mode asks for. @return true until it is there */
  step(elapsedMs, box, drone) {
    const goal = this.aim(box, drone);
    if (!goal) return false;
    const part = this.calm.matches ? 1 : 1 - Math.exp(-elapsedMs / GLIDE_MS);
    const off = [goal.centre[0] - this.centre[0], goal.centre[1] - this.centre[1]];
    const zoom = goal.scale / this.scale;
    const far = Math.hypot(...off) * this.scale > 0.25 || Math.abs(zoom - 1) > STILL;
    if (far && this.mode === "fit" && performance.now() < this.heldUntilMs) return true;
    const step = far ? part : 1;
    this.centre = [this.centre[0] + off[0] * step, this.centre[1] + off[1] * step];
    this.scale *= 1 + (zoom - 1) * step;
    return far;
  }

  aim(box, drone) {
    if (this.mode === "follow") return drone && { centre: drone, scale: this.scale };
    if (this.mode !== "fit") return null;
    const [x0, y0, x1, y1] = box ?? [-2, -2, 2, 2];
    const [top, right, bottom] = box ? [TOOLS_PX.top, TOOLS_PX.right, this.coveredPx] : [0, 0, 0];
    const [w, h] = [this.size[0] - right, this.size[1] - top - bottom];
    const [sine, cosine] = [Math.abs(Math.sin(this.angle)), Math.abs(Math.cos(this.angle))];
    const [wide, high] = [x1 - x0 + 2 * MARGIN_M, y1 - y0 + 2 * MARGIN_M];
    const across = w / (wide * cosine + high * sine);
    const down = h / (wide * sine + high * cosine);
    const scale = Math.max(SCALE[0], Math.min(across, down, FIT_SCALE_MAX));
    const [dx, dy] = turned([right / 2 / scale, (top - bottom) / 2 / scale], -this.angle);
    return { centre: [(x0 + x1) / 2 + dx, (y0 + y1) / 2 + dy], scale };
  }
}

function turned([x, y], angle) {
  const [sine, cosine] = [Math.sin(angle), Math.cos(angle)];
  return [x * cosine - y * sine, x * sine + y * cosine];
}
