// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the map and what moves on it. World: metres, x to the right, y up. No state of the drone
// is kept here: draw() shows what it is given.

const STATES = ["unknown", "free", "occupied", "occupied"];
const HAS_POINT = 3;
const HEADER_BYTES = 20;
const BEAM_BEARINGS = [0, Math.PI / 2, Math.PI, -Math.PI / 2]; // front, left, back, right
const BEAM_HALF_WIDTH = (13.5 * Math.PI) / 180;
const NO_ECHO_M = 1.0;

/** A map frame as the server packs it (web/frames.py). */
export function parseMap(buffer) {
  const head = new DataView(buffer);
  return {
    revision: head.getUint32(0, true),
    side: head.getUint16(4, true),
    cell: head.getFloat32(8, true),
    x: head.getFloat32(12, true),
    y: head.getFloat32(16, true),
    codes: new Uint8Array(buffer, HEADER_BYTES),
  };
}

export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.tiles = document.createElement("canvas");
    this.map = null;
    this.ages = null; // seconds, or -1, of each tile
    this.points = [];
    this.centre = [0, 0];
    this.scale = 60; // CSS pixels a metre
    this.auto = true; // follow the known part of the map
    this.readColours();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.readColours();
      if (this.map) this.setMap(this.map);
    });
  }

  readColours() {
    const style = getComputedStyle(document.documentElement);
    const names = ["unknown", "grid", "free", "occupied", "point", "trail", "route", "goal", "drone", "beam", "panel"];
    this.colours = Object.fromEntries(names.map((n) => [n, style.getPropertyValue(`--${n}`).trim()]));
  }

  setMap(map) {
    this.map = map;
    this.points = [];
    this.box = null;
    const { side, codes } = map;
    const image = new ImageData(side, side);
    const rgb = STATES.map((name) => parseColour(this.colours[name]));
    for (let cell = 0; cell < codes.length; cell++) {
      const state = codes[cell] & 3;
      const column = cell % side;
      const row = (cell - column) / side;
      if (state) this.include(column, row);
      if (state === HAS_POINT) {
        const eighths = codes[cell] >> 2;
        this.points.push(column + ((eighths & 7) + 0.5) / 8, row + ((eighths >> 3) + 0.5) / 8);
      }
      const at = 4 * ((side - 1 - row) * side + column);
      image.data.set(rgb[state], at);
      image.data[at + 3] = state ? 255 : 0;
    }
    this.tiles.width = this.tiles.height = side;
    this.tiles.getContext("2d").putImageData(image, 0, 0);
  }

  forget() {
    this.map = this.box = null;
    this.points = [];
  }

  include(column, row) {
    const box = (this.box ??= [column, row, column, row]);
    box[0] = Math.min(box[0], column);
    box[1] = Math.min(box[1], row);
    box[2] = Math.max(box[2], column + 1);
    box[3] = Math.max(box[3], row + 1);
  }

  toWorld(px, py) {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    return [this.centre[0] + (px - w / 2) / this.scale, this.centre[1] - (py - h / 2) / this.scale];
  }

  toScreen(x, y) {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    return [w / 2 + (x - this.centre[0]) * this.scale, h / 2 - (y - this.centre[1]) * this.scale];
  }

  zoom(factor, px = this.canvas.clientWidth / 2, py = this.canvas.clientHeight / 2) {
    const before = this.toWorld(px, py);
    this.auto = false;
    this.scale = Math.min(600, Math.max(12, this.scale * factor));
    const after = this.toWorld(px, py);
    this.centre = [this.centre[0] + before[0] - after[0], this.centre[1] + before[1] - after[1]];
  }

  pan(dx, dy) {
    this.auto = false;
    this.centre = [this.centre[0] - dx / this.scale, this.centre[1] + dy / this.scale];
  }

  /** Glide towards showing everything that is known. */
  follow() {
    if (!this.auto) return;
    let [x0, y0, x1, y1] = [-2, -2, 2, 2];
    if (this.map && this.box) {
      const { cell, x, y } = this.map;
      [x0, y0, x1, y1] = this.box.map((v, i) => v * cell + (i % 2 ? y : x));
    }
    const { clientWidth: w, clientHeight: h } = this.canvas;
    const margin = 0.6;
    const scale = Math.min(w / (x1 - x0 + 2 * margin), h / (y1 - y0 + 2 * margin), 160);
    const step = 0.15;
    this.scale += (scale - this.scale) * step;
    this.centre[0] += ((x0 + x1) / 2 - this.centre[0]) * step;
    this.centre[1] += ((y0 + y1) / 2 - this.centre[1]) * step;
  }

  draw(drone, route, trail, goal, fleet) {
    const { canvas, context: c } = this;
    const ratio = devicePixelRatio || 1;
    const [w, h] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    this.follow();
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = this.colours.unknown;
    c.fillRect(0, 0, w, h);
    this.drawMetres();
    this.drawCells();
    this.drawAges();
    this.drawHome();
    this.drawLine(trail, this.colours.trail, 2, []);
    this.drawLine(route, this.colours.route, 3, [8, 5]);
    if (goal) this.drawGoal(goal);
    const several = fleet.length > 1;
    for (const [n, other] of fleet.entries()) {
      if (several && other.pose && !other.chosen) this.drawDrone(other, other.colour, n + 1);
    }
    if (drone?.pose) {
      const own = fleet.findIndex((one) => one.chosen);
      this.drawDrone(drone, several ? fleet[own].colour : this.colours.drone, several ? own + 1 : "");
    }
  }

  /** The older a tile, the more of a veil; what never came is framed. */
  drawAges() {
    if (!this.map || !this.ages) return;
    const { context: c, map } = this;
    const [tiles, size] = [map.side / 8, 8 * map.cell * this.scale];
    c.fillStyle = c.strokeStyle = this.colours.route;
    c.lineWidth = 1;
    for (const [tile, age] of this.ages.entries()) {
      const [column, row] = [tile % tiles, Math.floor(tile / tiles)];
      const [px, py] = this.toScreen(map.x + 8 * map.cell * column, map.y + 8 * map.cell * (row + 1));
      c.globalAlpha = Math.min(0.5, Math.max(0, age) / 20);
      c.fillRect(px, py, size, size);
      c.globalAlpha = 0.5;
      if (age < 0) c.strokeRect(px + 2, py + 2, size - 4, size - 4);
    }
    c.globalAlpha = 1;
  }

  drawMetres() {
    const { context: c, canvas } = this;
    const [x0, y1] = this.toWorld(0, 0);
    const [x1, y0] = this.toWorld(canvas.clientWidth, canvas.clientHeight);
    c.strokeStyle = this.colours.grid;
    c.lineWidth = 1;
    c.beginPath();
    for (let x = Math.ceil(x0); x <= x1; x++) {
      const [px] = this.toScreen(x, 0);
      c.moveTo(px, 0);
      c.lineTo(px, canvas.clientHeight);
    }
    for (let y = Math.ceil(y0); y <= y1; y++) {
      const [, py] = this.toScreen(0, y);
      c.moveTo(0, py);
      c.lineTo(canvas.clientWidth, py);
    }
    c.stroke();
  }

  drawCells() {
    if (!this.map) return;
    const { context: c, map } = this;
    const size = map.side * map.cell;
    const [px, py] = this.toScreen(map.x, map.y + size);
    c.imageSmoothingEnabled = false;
    c.drawImage(this.tiles, px, py, size * this.scale, size * this.scale);
    c.fillStyle = this.colours.point;
    const radius = Math.max(1.2, 0.22 * map.cell * this.scale);
    c.beginPath();
    for (let i = 0; i < this.points.length; i += 2) {
      const [x, y] = this.toScreen(map.x + this.points[i] * map.cell, map.y + this.points[i + 1] * map.cell);
      c.moveTo(x + radius, y);
      c.arc(x, y, radius, 0, 2 * Math.PI);
    }
    c.fill();
  }

  drawLine(points, colour, width, dash) {
    if (points.length < 2) return;
    const { context: c } = this;
    c.beginPath();
    for (const [x, y] of points) c.lineTo(...this.toScreen(x, y));
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.lineJoin = c.lineCap = "round";
    c.setLineDash(dash);
    c.stroke();
    c.setLineDash([]);
  }

  /** The origin: where it took off first. */
  drawHome() {
    const { context: c } = this;
    const [px, py] = this.toScreen(0, 0);
    c.strokeStyle = this.colours.trail;
    c.lineWidth = 2;
    c.strokeRect(px - 6, py - 6, 12, 12);
  }

  drawGoal([x, y]) {
    const { context: c } = this;
    const [px, py] = this.toScreen(x, y);
    c.strokeStyle = c.fillStyle = this.colours.goal;
    c.lineWidth = 3;
    c.beginPath();
    c.arc(px, py, 11, 0, 2 * Math.PI);
    c.stroke();
    c.beginPath();
    c.arc(px, py, 4, 0, 2 * Math.PI);
    c.fill();
  }

  drawDrone({ pose: [x, y, , yaw], ranges }, colour, label) {
    const { context: c } = this;
    const [px, py] = this.toScreen(x, y);
    c.save();
    c.translate(px, py);
    c.rotate(-yaw);
    if (ranges) this.drawBeams(ranges);
    const size = Math.max(9, 0.12 * this.scale);
    c.beginPath();
    c.moveTo(size * 1.25, 0);
    c.lineTo(-size, size * 0.85);
    c.lineTo(-size * 0.45, 0);
    c.lineTo(-size, -size * 0.85);
    c.closePath();
    c.fillStyle = colour;
    c.strokeStyle = this.colours.panel;
    c.lineWidth = 2.5;
    c.stroke();
    c.fill();
    c.restore();
    c.font = "bold 13px system-ui, sans-serif";
    c.fillText(label, px + size, py - size);
  }

  drawBeams(ranges) {
    const { context: c } = this;
    c.fillStyle = c.strokeStyle = this.colours.beam;
    ranges.forEach((range, i) => {
      const bearing = -BEAM_BEARINGS[i];
      const length = (range ?? NO_ECHO_M) * this.scale;
      c.globalAlpha = range === null ? 0.06 : 0.16;
      c.beginPath();
      c.moveTo(0, 0);
      c.arc(0, 0, length, bearing - BEAM_HALF_WIDTH, bearing + BEAM_HALF_WIDTH);
      c.fill();
      if (range === null) return;
      c.globalAlpha = 0.9;
      c.lineWidth = 2;
      c.beginPath();
      c.arc(0, 0, length, bearing - BEAM_HALF_WIDTH, bearing + BEAM_HALF_WIDTH);
      c.stroke();
    });
    c.globalAlpha = 1;
  }
}

function parseColour(hex) {
  const n = parseInt(hex.slice(1), 16);
  return [n >> 16, (n >> 8) & 255, n & 255];
}
