// SPDX-License-Identifier: GPL-3.0-or-later
// Fingers, mouse and wheel on the map. One pointer taps, holds, drags a thing or pans; two pan, zoom
// and turn.

const DRAG_PX = 6;
const HOLD_MS = 500;
const TURN_AFTER_RAD = 0.17; // two fingers turn the map only if they mean it
const WHEEL = 1 / 400;
const PINCHED_WHEEL = 1 / 100; // what two fingers on a touchpad become
const LINE_PX = 16;

/** actions: tap(px, py), hold(px, py), hover(px, py), leave(), grab(px, py) -> {move, drop, cancel}
 * or null, changed(). */
export class Gestures {
  constructor(canvas, camera, actions) {
    this.camera = camera;
    this.actions = actions;
    this.fingers = new Map();
    this.thing = null; // what is being dragged
    this.timer = 0;
    for (const kind of ["down", "move", "up", "cancel", "leave"]) {
      canvas.addEventListener(`pointer${kind}`, (event) => this[kind](event));
    }
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  down(event) {
    event.target.setPointerCapture(event.pointerId);
    const at = [event.offsetX, event.offsetY];
    this.fingers.set(event.pointerId, at);
    this.camera.touched(true);
    clearTimeout(this.timer);
    if (this.fingers.size > 1) {
      this.spoil();
      this.turned = 0;
      return;
    }
    this.tapping = event.button === 0;
    this.moved = 0;
    this.thing = event.button === 0 ? this.actions.grab(...at) : null;
    if (event.pointerType !== "mouse" && !this.thing) this.timer = setTimeout(() => this.hold(at), HOLD_MS);
  }

  hold(at) {
    this.tapping = false;
    this.actions.hold(...at);
  }

  move(event) {
    const now = [event.offsetX, event.offsetY];
    const before = this.fingers.get(event.pointerId);
    this.camera.touched(this.fingers.size > 0);
    if (!before) {
      if (event.pointerType === "mouse") this.actions.hover(...now);
      return;
    }
    const other = [...this.fingers].find(([id]) => id !== event.pointerId)?.[1];
    this.fingers.set(event.pointerId, now);
    if (other) {
      this.pinch(before, now, other);
      return;
    }
    this.moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
    if (this.moved <= DRAG_PX) return;
    clearTimeout(this.timer);
    this.tapping = false;
    if (this.thing) this.thing.move(...now);
    else this.camera.pan(now[0] - before[0], now[1] - before[1]);
    this.actions.changed();
  }

  pinch(before, now, other) {
    const [was, is] = [before, now].map(([x, y]) => [x - other[0], y - other[1]]);
    if (Math.hypot(...was) < 1) return;
    const by = Math.atan2(was[0] * is[1] - was[1] * is[0], was[0] * is[0] + was[1] * is[1]);
    this.turned += by;
    this.camera.zoom(Math.hypot(...is) / Math.hypot(...was), ...other);
    if (Math.abs(this.turned) > TURN_AFTER_RAD) this.camera.turn(-by, ...other);
    this.actions.changed();
  }

  up(event) {
    const at = [event.offsetX, event.offsetY];
    clearTimeout(this.timer);
    this.lift(event);
    const thing = this.thing;
    this.thing = null;
    if (this.tapping) {
      thing?.cancel();
      this.actions.tap(...at);
    } else {
      thing?.drop(...at);
      if (event.pointerType === "mouse") this.actions.hover(...at);
    }
    this.tapping = false;
  }

  cancel(event) {
    this.lift(event);
    this.spoil();
  }

  lift(event) {
    this.fingers.delete(event.pointerId);
    this.camera.touched(this.fingers.size > 0);
  }

  /** Whatever was begun is none. */
  spoil() {
    clearTimeout(this.timer);
    this.tapping = false;
    this.thing?.cancel();
    this.thing = null;
  }

  leave(event) {
    if (event.pointerType !== "mouse") return;
    this.camera.untouched();
    this.actions.leave();
  }

  wheel(event) {
    event.preventDefault();
    const by = event.deltaY * (event.deltaMode ? LINE_PX : 1) * (event.ctrlKey ? PINCHED_WHEEL : WHEEL);
    this.camera.zoom(Math.exp(-by), event.offsetX, event.offsetY);
    this.actions.changed();
  }
}
