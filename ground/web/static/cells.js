// SPDX-License-Identifier: GPL-3.0-or-later
// The map as the drone sent it: cells, obstacle points and how old they are. It is drawn into a
// canvas of its own, anew only when it or what is seen of it has changed.

const STATES = ["unknown", "free", "occupied", "occupied"];
const HAS_POINT = 3;
const HEADER_BYTES = 20;
const TILE_CELLS = 8;
const AGE_FULL_S = 20; // of the veil that is half as dark as can be
const SHORTEST = 1e-3;
const POINT_PX = 1.2; // radius, at least
const POINT_CELLS = 0.22;

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

export class Cells {
  constructor(camera) {
    this.camera = camera;
    this.image = document.createElement("canvas"); // a pixel a cell
    this.sheet = document.createElement("canvas"); // as large as the screen
    this.drawn = "";
    this.version = 0;
    this.forget();
  }

  forget() {
    this.map = this.box = null;
    this.points = new Path2D(); // the shortest of lines, in cells: round ends make dots of them
    this.version++;
  }

  take(map, colours) {
    this.forget();
    this.map = map;
    const { side, codes } = map;
    const image = new ImageData(side, side);
    const rgb = STATES.map((name) => parseColour(colours[name]));
    for (let cell = 0; cell < codes.length; cell++) {
      const state = codes[cell] & 3;
      if (!state) continue;
      const column = cell % side;
      const row = (cell - column) / side;
      this.include(column, row);
      if (state === HAS_POINT) {
        const eighths = codes[cell] >> 2;
        const [x, y] = [column + ((eighths & 7) + 0.5) / 8, row + ((eighths >> 3) + 0.5) / 8];
        this.points.moveTo(x, y);
        this.points.lineTo(x + SHORTEST, y);
      }
      image.data.set([...rgb[state], 255], 4 * ((side - 1 - row) * side + column));
    }
    this.image.width = this.image.height = side;
    this.image.getContext("2d").putImageData(image, 0, 0);
  }

  include(column, row) {
    const box = (this.box ??= [column, row, column, row]);
    box[0] = Math.min(box[0], column);
    box[1] = Math.min(box[1], row);
    box[2] = Math.max(box[2], column + 1);
    box[3] = Math.max(box[3], row + 1);
  }

  /** What is known of the world lies in there, in metres; null before anything is. */
  get knownBox() {
    const { map, box } = this;
    return map && box && box.map((v, i) => v * map.cell + (i % 2 ? map.y : map.x));
  }

  /** @param ages  seconds, or -1, of each tile; null: not shown */
  draw(context, ratio, colours, { points, ages }) {
    const { camera, sheet } = this;
    const [w, h] = camera.size.map((px) => Math.round(px * ratio));
    const { centre, scale, angle } = camera;
    const seen = [w, h, ratio, ...centre, scale, angle, this.version, points, ages, colours.free].join();
    if (seen !== this.drawn) {
      this.drawn = seen;
      if (sheet.width !== w || sheet.height !== h) [sheet.width, sheet.height] = [w, h];
      const c = sheet.getContext("2d", { alpha: false });
      c.setTransform(ratio, 0, 0, ratio, 0, 0);
      c.fillStyle = colours.unknown;
      c.fillRect(0, 0, w, h);
      this.drawMetres(c, colours);
      if (this.map) this.drawCells(c);
      if (this.map && points) this.drawPoints(c, colours);
      if (this.map && ages) this.drawAges(c, colours, ages);
    }
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(sheet, 0, 0);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  drawMetres(c, colours) {
    const [x0, y0, x1, y1] = this.camera.box;
    c.strokeStyle = colours.grid;
    c.lineWidth = 1;
    c.beginPath();
    for (let x = Math.ceil(x0); x <= x1; x++) this.line(c, [x, y0], [x, y1]);
    for (let y = Math.ceil(y0); y <= y1; y++) this.line(c, [x0, y], [x1, y]);
    c.stroke();
  }

  line(c, from, to) {
    c.moveTo(...this.camera.toScreen(...from));
    c.lineTo(...this.camera.toScreen(...to));
  }

  drawCells(c) {
    const { side, cell, x, y } = this.map;
    c.save();
    this.camera.enter(c, x, y + side * cell);
    c.scale(cell, -cell);
    c.imageSmoothingEnabled = false;
    c.drawImage(this.image, 0, 0);
    c.restore();
  }

  drawPoints(c, colours) {
    const { map, points, camera } = this;
    const cellPx = map.cell * camera.scale;
    c.save();
    camera.enter(c, map.x, map.y);
    c.scale(map.cell, map.cell);
    c.lineWidth = 2 * Math.max(POINT_PX / cellPx, POINT_CELLS);
    c.lineCap = "round";
    c.strokeStyle = colours.point;
    c.stroke(points);
    c.restore();
  }

  /** The older a tile, the more of a veil; what never came is framed. */
  drawAges(c, colours, ages) {
    const { side, cell, x, y } = this.map;
    const [tiles, size] = [side / TILE_CELLS, TILE_CELLS * cell];
    c.save();
    this.camera.enter(c, x, y);
    c.fillStyle = c.strokeStyle = colours.route;
    c.lineWidth = 1 / this.camera.scale;
    for (const [tile, age] of ages.entries()) {
      const [left, bottom] = [(tile % tiles) * size, Math.floor(tile / tiles) * size];
      c.globalAlpha = Math.min(0.5, Math.max(0, age) / AGE_FULL_S);
      c.fillRect(left, bottom, size, size);
      c.globalAlpha = 0.5;
      if (age < 0) c.strokeRect(left + 0.05 * size, bottom + 0.05 * size, 0.9 * size, 0.9 * size);
    }
    c.restore();
  }
}

function parseColour(hex) {
  const n = parseInt(hex.slice(1), 16);
  return [n >> 16, (n >> 8) & 255, n & 255];
}
