// SPDX-License-Identifier: GPL-3.0-or-later
// What is drawn on the map: each function draws one kind of thing. Shapes and dashes differ as well
// as colours, so that no meaning hangs on a colour alone.

const BEAM_BEARINGS = [0, Math.PI / 2, Math.PI, -Math.PI / 2]; // front, left, back, right
const BEAM_HALF_WIDTH = (13.5 * Math.PI) / 180;
const NO_ECHO_M = 1.0;
const FULL = 2 * Math.PI;
const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";

/** Where to draw, and how things look: {c, camera, colours}. */
export function line({ c, camera }, points, colour, width, dash = [], alpha = 1) {
  if (points.length < 2) return;
  c.beginPath();
  for (const [x, y] of points) c.lineTo(...camera.toScreen(x, y));
  stroke(c, colour, width, dash, alpha);
}

export function home({ c, camera, colours }) {
  const [px, py] = camera.toScreen(0, 0);
  c.beginPath();
  c.rect(px - 6, py - 6, 12, 12);
  stroke(c, colours.trail, 2);
}

export function goal({ c, camera, colours }, [x, y]) {
  const [px, py] = camera.toScreen(x, y);
  disc(c, px, py, 11);
  stroke(c, colours.panel, 5);
  stroke(c, colours.goal, 3);
  disc(c, px, py, 4);
  c.fillStyle = colours.goal;
  c.fill();
}

/** pose: [x, y, yaw] */
export function drone({ c, camera, colours }, [x, y, yaw], colour, label, ranges) {
  const [px, py] = camera.toScreen(x, y);
  c.save();
  c.translate(px, py);
  c.rotate(-yaw - camera.angle);
  if (ranges) beams(c, ranges, camera.scale, colours.beam);
  const size = outline(c, camera.scale);
  c.fillStyle = colour;
  stroke(c, colours.panel, 2.5);
  c.fill();
  c.restore();
  if (label) text({ c, colours }, px + size + 9, py - size - 3, label);
}

/** Where the firmware's own estimate has it: a hollow drone. */
export function ghost({ c, camera, colours }, [x, y, yaw]) {
  const [px, py] = camera.toScreen(x, y);
  c.save();
  c.translate(px, py);
  c.rotate(-yaw - camera.angle);
  outline(c, camera.scale);
  stroke(c, colours.panel, 4, [], 0.7);
  stroke(c, colours.ghost, 1.8, [3, 2]);
  c.restore();
}

/** x0, y0, x1, y1 in metres: what lies outside is shaded. */
export function area({ c, camera, colours }, [x0, y0, x1, y1], colour = colours.area) {
  const corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(([x, y]) => camera.toScreen(x, y));
  c.beginPath();
  c.rect(0, 0, ...camera.size);
  ring(c, corners);
  c.fillStyle = colour;
  c.globalAlpha = 0.07;
  c.fill("evenodd");
  c.globalAlpha = 1;
  c.beginPath();
  ring(c, corners);
  stroke(c, colour, 2, [12, 5, 2, 5]);
}

export function tree({ c, camera, colours }, edges) {
  c.beginPath();
  for (const [x0, y0, x1, y1] of edges) {
    c.moveTo(...camera.toScreen(x0, y0));
    c.lineTo(...camera.toScreen(x1, y1));
  }
  stroke(c, colours.tree, 1.2, [], 0.75);
  c.fillStyle = colours.tree;
  for (const [x, y] of edges) {
    const [px, py] = camera.toScreen(x, y);
    c.fillRect(px - 1.5, py - 1.5, 3, 3);
  }
}

/** Diamonds, the larger the more would be seen; filled where exploring would go first. */
export function frontiers({ c, camera, colours }, rows) {
  for (const [x, y, gain, first] of rows) {
    const [px, py] = camera.toScreen(x, y);
    const size = 5 + Math.sqrt(gain) / 6;
    c.beginPath();
    c.moveTo(px, py - size);
    c.lineTo(px + size, py);
    c.lineTo(px, py + size);
    c.lineTo(px - size, py);
    c.closePath();
    c.fillStyle = first ? colours.frontier : colours.panel;
    c.globalAlpha = first ? 1 : 0.75;
    c.fill();
    c.globalAlpha = 1;
    stroke(c, colours.frontier, 2);
  }
}

/** Somebody, as sure as alpha says. */
export function person({ c, camera, colours }, [x, y], alpha) {
  const [px, py] = camera.toScreen(x, y);
  c.save();
  c.globalAlpha = alpha;
  disc(c, px, py, 12);
  c.fillStyle = colours.person;
  c.fill();
  c.strokeStyle = colours.panel;
  c.lineWidth = 2;
  c.stroke();
  c.fillStyle = colours.panel;
  disc(c, px, py - 4, 3.2);
  c.fill();
  c.beginPath();
  c.arc(px, py + 7, 5.5, Math.PI, FULL);
  c.fill();
  c.restore();
}

/** The way that it would fly; what nobody has seen of it is dotted. */
export function previewed({ c, camera, colours }, { path, ok, seen_m: seen }, [x, y]) {
  const [known, unknown] = split(path, seen);
  line({ c, camera }, known, colours.panel, 6, [], 0.8);
  line({ c, camera }, known, colours.preview, 2.5);
  line({ c, camera }, unknown, colours.preview, 2.5, [1, 6]);
  const [px, py] = camera.toScreen(x, y);
  c.beginPath();
  if (ok) {
    c.arc(px, py, 6, 0, FULL);
  } else {
    for (const [dx, dy] of [[1, 1], [1, -1]]) {
      c.moveTo(px - 6 * dx, py - 6 * dy);
      c.lineTo(px + 6 * dx, py + 6 * dy);
    }
  }
  stroke(c, colours.panel, 5);
  stroke(c, ok ? colours.preview : colours.refused, 2.5);
}

/** Numbered places, and the way from one to the next. */
export function wayPoints({ c, camera, colours }, points, { held = -1, ghostly = false } = {}) {
  c.save();
  c.globalAlpha = ghostly ? 0.55 : 1;
  line({ c, camera }, points, colours.accent, 2, [2, 5], c.globalAlpha);
  c.font = `600 13px ${FONT}`;
  [c.textAlign, c.textBaseline] = ["center", "middle"];
  for (const [n, [x, y]] of points.entries()) {
    const [px, py] = camera.toScreen(x, y);
    disc(c, px, py, n === held ? 15 : 12);
    c.fillStyle = colours.accent;
    c.fill();
    c.strokeStyle = colours.panel;
    c.lineWidth = 2;
    c.stroke();
    c.fillStyle = colours["accent-ink"];
    c.fillText(n + 1, px, py + 1);
  }
  c.restore();
}

/** The place that the keyboard moves about. */
export function crosshair({ c, camera, colours }, [x, y]) {
  const [px, py] = camera.toScreen(x, y);
  c.beginPath();
  for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
    c.moveTo(px + 5 * dx, py + 5 * dy);
    c.lineTo(px + 18 * dx, py + 18 * dy);
  }
  stroke(c, colours.panel, 5);
  stroke(c, colours.ink, 2);
}

/** Words in a small box, with its middle there. */
export function text({ c, colours }, px, py, words) {
  c.save();
  c.font = `600 13px ${FONT}`;
  [c.textAlign, c.textBaseline] = ["center", "middle"];
  const width = c.measureText(words).width + 12;
  c.beginPath();
  c.roundRect(px - width / 2, py - 11, width, 22, 6);
  c.fillStyle = colours.panel;
  c.globalAlpha = 0.92;
  c.fill();
  c.globalAlpha = 1;
  c.fillStyle = colours.ink;
  c.fillText(words, px, py + 1);
  c.restore();
}

function beams(c, ranges, scale, colour) {
  c.fillStyle = c.strokeStyle = colour;
  c.lineWidth = 2;
  ranges.forEach((range, i) => {
    const bearing = -BEAM_BEARINGS[i];
    const length = (range ?? NO_ECHO_M) * scale;
    c.globalAlpha = range === null ? 0.06 : 0.16;
    c.beginPath();
    c.moveTo(0, 0);
    c.arc(0, 0, length, bearing - BEAM_HALF_WIDTH, bearing + BEAM_HALF_WIDTH);
    c.fill();
    if (range === null) return;
    c.globalAlpha = 0.9;
    c.beginPath();
    c.arc(0, 0, length, bearing - BEAM_HALF_WIDTH, bearing + BEAM_HALF_WIDTH);
    c.stroke();
  });
  c.globalAlpha = 1;
}

/** A path as a drone looks. @return its size in pixels */
function outline(c, scale) {
  const size = Math.max(9, 0.12 * scale);
  c.beginPath();
  c.moveTo(size * 1.25, 0);
  c.lineTo(-size, size * 0.85);
  c.lineTo(-size * 0.45, 0);
  c.lineTo(-size, -size * 0.85);
  c.closePath();
  return size;
}

function disc(c, px, py, radius) {
  c.beginPath();
  c.arc(px, py, radius, 0, FULL);
}

function ring(c, corners) {
  corners.forEach((corner, i) => (i ? c.lineTo(...corner) : c.moveTo(...corner)));
  c.closePath();
}

function stroke(c, colour, width, dash = [], alpha = 1) {
  c.save();
  c.globalAlpha = alpha;
  c.strokeStyle = colour;
  c.lineWidth = width;
  c.lineJoin = c.lineCap = "round";
  c.setLineDash(dash);
  c.stroke();
  c.restore();
}

/** A way in two, after so many metres. */
function split(path, at) {
  let gone = 0;
  for (let i = 1; i < path.length; i++) {
    const [[x0, y0], [x1, y1]] = [path[i - 1], path[i]];
    const length = Math.hypot(x1 - x0, y1 - y0);
    if (gone + length > at + 1e-3) {
      const share = Math.max(0, (at - gone) / length);
      const middle = [x0 + share * (x1 - x0), y0 + share * (y1 - y0)];
      return [[...path.slice(0, i), middle], [middle, ...path.slice(i)]];
    }
    gone += length;
  }
  return [path, []];
}
