// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the map and what moves on it, when something has changed. No state of the drone is kept
// here: draw() shows what it is given.

import { Camera } from "./camera.js";
import { Cells, parseMap } from "./cells.js";
import * as marks from "./marks.js";

const COLOURS = [
  "unknown", "grid", "free", "occupied", "point", "trail", "route", "goal", "drone", "beam", "panel", "ink",
  "accent", "accent-ink", "ghost", "area", "tree", "frontier", "person", "preview", "refused",
];
const GLIDE_MS = 70;
const JUMP_M = 0.5; // farther the drone does not glide
export const PERSON_MS = 2000; // somebody who was seen fades within this

export class View {
  constructor(canvas, changed) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.camera = new Camera(canvas);
    this.cells = new Cells(this.camera);
    this.shown = null; // the drone's pose as drawn: it glides to the newest
    this.frames = 0;
    this.readColours();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.readColours();
      if (this.cells.map) this.cells.take(this.cells.map, this.colours);
      changed();
    });
    new ResizeObserver(changed).observe(canvas);
  }

  readColours() {
    const style = getComputedStyle(document.documentElement);
    this.colours = Object.fromEntries(COLOURS.map((n) => [n, style.getPropertyValue(`--${n}`).trim()]));
  }

  takeCells(buffer) {
    this.cells.take(parseMap(buffer), this.colours);
  }

  forget() {
    this.cells.forget();
    this.shown = null;
  }

  /** @return true if it goes on moving by itself */
  draw(scene, elapsedMs) {
    const { canvas, context: c, camera, colours } = this;
    const ratio = devicePixelRatio || 1;
    camera.measure();
    const [w, h] = camera.size.map((px) => Math.round(px * ratio));
    if (!w || !h) return false;
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const gliding = this.glide(scene.drone?.pose, elapsedMs);
    const box = around(this.cells.knownBox, scene.drone?.goal);
    const moving = camera.step(elapsedMs, box, this.shown?.slice(0, 2));
    const { layers } = scene;
    this.cells.draw(c, ratio, colours, { points: layers.points, ages: layers.age ? scene.ages : null });
    const on = { c, camera, colours };
    this.drawPlans(on, scene);
    const fading = layers.people && this.drawPeople(on, scene.people);
    this.drawDrones(on, scene);
    scene.tools.draw(on);
    if (scene.cross) marks.crosshair(on, scene.cross);
    this.frames++;
    return gliding || moving || fading;
  }

  drawPlans(on, { layers, area, tree, frontiers, trail, ghostTrail, route, goal, preview }) {
    const { colours } = this;
    if (layers.area && area) marks.area(on, area);
    marks.home(on);
    if (layers.tree) marks.tree(on, preview?.tree ?? tree);
    if (layers.odometry) marks.line(on, ghostTrail, colours.ghost, 1.5, [1, 5], 0.8);
    if (layers.trail) marks.line(on, trail, colours.trail, 2);
    if (layers.route) marks.line(on, route, colours.route, 3, [8, 5]);
    if (layers.frontiers) marks.frontiers(on, frontiers);
    if (preview) marks.previewed(on, preview, [preview.x, preview.y]);
    if (goal) marks.goal(on, goal);
  }

  drawPeople(on, people) {
    const now = performance.now();
    for (const { place, at } of people) {
      const left = 1 - (now - at) / PERSON_MS;
      if (left > 0) marks.person(on, place, Math.min(1, 2 * left));
    }
    return people.some(({ at }) => now - at < PERSON_MS);
  }

  drawDrones(on, { layers, drone, fleet, odometry }) {
    const { colours } = this;
    const several = fleet.length > 1;
    for (const [n, { pose, chosen, colour }] of fleet.entries()) {
      if (several && pose && !chosen) marks.drone(on, [pose[0], pose[1], pose[3]], colour, n + 1);
    }
    if (layers.odometry && odometry) marks.ghost(on, odometry);
    if (!this.shown) return;
    const label = several ? fleet.findIndex(({ chosen }) => chosen) + 1 : "";
    marks.drone(on, this.shown, this.ownColour(fleet), label, layers.beams && drone.ranges);
  }

  /** Of the drone that the page is about. */
  ownColour(fleet) {
    return (fleet.length > 1 && fleet.find(({ chosen }) => chosen)?.colour) || this.colours.drone;
  }

  /** The drone as it is drawn follows the newest pose. @return true until it is there */
  glide(pose, elapsedMs) {
    if (!pose) {
      this.shown = null;
      return false;
    }
    const [x, y, , yaw] = pose;
    const [x0, y0, yaw0] = this.shown ?? [x, y, yaw];
    const off = [x - x0, y - y0, Math.atan2(Math.sin(yaw - yaw0), Math.cos(yaw - yaw0))];
    const near = Math.hypot(off[0], off[1]) < JUMP_M;
    const far = Math.hypot(off[0], off[1]) > 0.002 || Math.abs(off[2]) > 0.005;
    const part = this.camera.calm.matches || !near || !far ? 1 : 1 - Math.exp(-elapsedMs / GLIDE_MS);
    this.shown = part === 1 ? [x, y, yaw] : [x0 + part * off[0], y0 + part * off[1], yaw0 + part * off[2]];
    return part < 1;
  }
}

/** The box of all that is known, and where the drone flies to. */
function around(box, goal) {
  if (!box || !goal) return box;
  const [[x0, y0, x1, y1], [x, y]] = [box, goal];
  return [Math.min(x0, x), Math.min(y0, y), Math.max(x1, x), Math.max(y1, y)];
}
