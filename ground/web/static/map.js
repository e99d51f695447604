// SPDX-License-Identifier: GPL-3.0-or-later
// Everything in the map's part of the page: puts together what is drawn there and what is done there.

import { TURN_RAD, ZOOM } from "./camera.js";
import { $, say } from "./dom.js";
import { Gestures } from "./gestures.js";
import { Keys } from "./keys.js";
import { Layers } from "./layers.js";
import { Preview } from "./preview.js";
import { Tools } from "./tools.js";
import { PERSON_MS, View } from "./view.js";

const TAKEN_MS = 300; // within this a goal that was taken is told of as the drone's
const FRAME_MS_MAX = 100; // a page that slept does not leap
const [LEGEND_PX, TIMELINE_PX] = [34, 96]; // what they cover of the map
const SCALE_M = [0.1, 0.2, 0.5, 1, 2, 5, 10];
const SCALE_PX = 48;
const TAP = matchMedia("(pointer: coarse)").matches ? "Tap" : "Click";
const POINTER_HINT = `${TAP} the map: it takes off and flies there`;
const KEY_HINTS = {
  go: "Shift and arrows move a cross, Enter flies there",
  points: "Shift and arrows move a cross, P: a point there, Enter: fly",
  area: "Shift and arrows move a cross, P: a corner there, Enter: use",
};

export class MapPanel {
  /** wish() sends to the server. */
  constructor({ wish }) {
    this.wish = wish;
    this.state = null;
    this.wanted = null; // the goal just clicked, until the drone takes or refuses it
    this.pointer = null; // where the mouse rests
    this.due = false;
    this.then = performance.now();
    this.trail = [];
    const changed = () => this.changed();
    this.view = new View($("map"), changed);
    const camera = (this.camera = this.view.camera);
    this.preview = new Preview({ wish, bubble: $("preview"), camera, changed });
    this.tools = new Tools({ wish, camera, changed });
    this.layers = new Layers($("layers-open"), $("layers"), () => this.choseLayers());
    this.keys = new Keys($("map"), this);
    this.forget();
    new Gestures($("map"), camera, {
      tap: (px, py) => this.tap(px, py),
      hold: (px, py) => this.look(camera.toWorld(px, py)),
      hover: (px, py) => this.hover(px, py),
      leave: () => this.leave(),
      grab: (px, py) => this.tools.grab(px, py),
      changed,
    });
    for (const kind of ["focus", "blur"]) $("map").addEventListener(kind, changed);
    this.listen();
    globalThis.wayflie = { map: this }; // for tests and the console
  }

  listen() {
    const { camera } = this;
    const on = (id, act) => ($(id).onclick = () => (act(), this.changed()));
    on("zoom-in", () => camera.zoom(ZOOM));
    on("zoom-out", () => camera.zoom(1 / ZOOM));
    on("turn-left", () => camera.turn(TURN_RAD));
    on("turn-right", () => camera.turn(-TURN_RAD));
    on("compass", () => camera.turn(-camera.angle));
    on("fit", () => (camera.mode = camera.mode === "fit" ? "free" : "fit"));
    on("follow", () => (camera.mode = camera.mode === "follow" ? "free" : "follow"));
  }

  /** The socket to the server is open. */
  opened() {
    this.wish({ do: "layers", want: this.layers.asked });
  }

  /** A state message of the server. */
  take(message) {
    this.state = message;
    const { trail, odometry_trail: ghostTrail, can, drone, odometry, area, route, fleet, replay } = message;
    this.trail = grown(this.trail, trail);
    this.ghostTrail = grown(this.ghostTrail, ghostTrail);
    $("map").style.cursor = can.goto ? "crosshair" : "default";
    this.camera.coveredPx = replay ? TIMELINE_PX : LEGEND_PX;
    for (const id of ["tool-points", "tool-area"]) $(id).disabled = !can.goto;
    this.preview.refresh();
    const { pose, ranges, goal } = drone;
    const key = JSON.stringify([can.goto, pose, ranges, goal, odometry, area, route, fleet, trail, ghostTrail]);
    if (key !== this.drawnOf || this.layers.shown.age) this.changed();
    this.drawnOf = key;
  }

  /** A map message. */
  takeCells(buffer) {
    this.view.takeCells(buffer);
    this.changed();
  }

  /** Any other message; those that are not about the map are left alone. */
  takeOther(message) {
    if (message.kind === "preview") this.preview.take(message);
    if (message.kind !== "layers") return;
    this.tree = message.tree ?? this.tree;
    this.frontiers = message.frontiers ?? this.frontiers;
    const at = performance.now();
    const seen = (message.people ?? []).map((place) => ({ place, at }));
    this.people = [...this.people.filter((one) => at - one.at < PERSON_MS), ...seen];
    this.changed();
  }

  /** A wish of that name was answered. */
  answered(what, { ok }) {
    if (what === "goto") setTimeout(() => this.want(null), ok ? TAKEN_MS : 0);
    if (!ok) this.tools.refused(what);
    this.changed();
  }

  /** Another drone is looked at. */
  forget() {
    this.wanted = null;
    this.trail = [];
    this.ghostTrail = [];
    [this.tree, this.frontiers, this.people] = [[], [], []];
    this.preview.clear();
    this.tools.forget();
    this.view.forget();
    this.changed();
  }

  tap(px, py) {
    this.pointer = null; // nothing is previewed until it moves on
    this.preview.clear();
    if (!this.tools.tap(px, py)) this.go(this.camera.toWorld(px, py));
  }

  go([x, y]) {
    if (!this.state?.can.goto) return;
    this.tools.forget();
    this.preview.clear();
    this.keys.cross = null;
    this.wish({ do: "goto", x, y });
    this.want([x, y]);
  }

  want(goal) {
    this.wanted = goal;
    this.changed();
  }

  hover(px, py) {
    this.keys.cross = null;
    this.pointer = [px, py];
    if (this.tools.mode === "area") this.preview.clear();
    else this.look(this.camera.toWorld(px, py));
  }

  leave() {
    this.pointer = null;
    if (!this.keys.cross) this.preview.clear();
  }

  /** Show what would come of a goal there. */
  look(place) {
    const from = this.tools.points.at(-1);
    if (this.layers.shown.preview && this.state?.can.goto) this.preview.ask(place, from);
  }

  choseLayers() {
    if (!this.layers.shown.preview) this.preview.clear();
    this.wish({ do: "layers", want: this.layers.asked });
    this.changed();
  }

  /** Draw soon. */
  changed() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    this.due = false;
    const elapsedMs = Math.min(FRAME_MS_MAX, Math.max(1, now - this.then));
    this.then = now;
    const moving = this.view.draw(this.scene(), elapsedMs);
    this.preview.show();
    this.showTools();
    if (!moving) return;
    this.changed();
    const resting = this.pointer && this.preview.place && !this.keys.cross;
    if (resting) this.look(this.camera.toWorld(...this.pointer)); // the map moves below it
  }

  scene() {
    const { state, layers, trail, ghostTrail, tree, frontiers, people, tools } = this;
    return {
      layers: layers.shown,
      drone: state?.drone,
      fleet: state?.fleet ?? [],
      odometry: state?.odometry,
      area: state?.area,
      ages: state?.map.ages_s,
      route: state?.route ?? [],
      goal: this.wanted ?? state?.drone.goal,
      preview: this.preview.fits,
      cross: this.keys.cross,
      trail, ghostTrail, tree, frontiers, people, tools,
    };
  }

  /** What to do here: until it has flown, and for who came with the Tab key. */
  showHint() {
    const { mode } = this.tools;
    const keyed = $("map").matches(":focus-visible");
    const pointed = !mode && !this.trail.length && POINTER_HINT;
    const words = this.state?.can.goto && (keyed ? KEY_HINTS[mode ?? "go"] : pointed);
    $("hint").hidden = !words;
    say($("hint"), words || "");
  }

  showTools() {
    const { camera, state, layers } = this;
    $("fit").ariaPressed = String(camera.mode === "fit");
    $("follow").ariaPressed = String(camera.mode === "follow");
    this.showHint();
    $("compass").hidden = camera.angle === 0;
    $("compass").firstElementChild.style.transform = `rotate(${-camera.angle}rad)`;
    const metres = SCALE_M.find((m) => m * camera.scale >= SCALE_PX) ?? SCALE_M.at(-1);
    $("scale-bar").style.width = `${metres * camera.scale}px`;
    $("scale-text").textContent = `${metres} m`;
    const pose = state?.drone.pose;
    const ghost = layers.shown.odometry && pose && state.odometry;
    $("legend").hidden = !ghost;
    if (!ghost) return;
    $("legend-drone").style.background = this.view.ownColour(state.fleet);
    $("legend-off").textContent = `${Math.hypot(ghost[0] - pose[0], ghost[1] - pose[1]).toFixed(2)} m off`;
  }
}

/** Points with the news of them. */
function grown(points, { from, points: news }) {
  return news.length || from < points.length ? [...points.slice(0, from), ...news] : points;
}
