// SPDX-License-Identifier: GPL-3.0-or-later
// What would come of a goal, before it is given: the way, or why it would be refused. The ground
// station computes it with the drone's own code; here it is asked for and shown.

const ASK_MS = 120;
const AGAIN_MS = 1000;
const NEAR_M = 0.03; // an answer for a place as near as this is one for it
const EDGE_PX = 12;

export class Preview {
  constructor({ wish, bubble, camera, changed }) {
    Object.assign(this, { wish, bubble, camera, changed });
    this.place = null; // world
    this.answer = null;
    this.timer = 0;
  }

  /** What would it do if it were sent there, from where it is or from another place? The newest
   * question counts. */
  ask(place, from) {
    if (this.place && distance(place, this.place) < 1e-6) return;
    [this.place, this.from] = [place, from];
    this.timer ||= setTimeout(() => this.send(), this.answer ? ASK_MS : 0);
    this.changed();
  }

  send() {
    this.timer = 0;
    this.askedAt = performance.now();
    if (this.place) this.wish({ do: "ask", x: this.place[0], y: this.place[1], from: this.from });
  }

  /** The drone moves on: ask again from time to time. */
  refresh() {
    if (this.answer && performance.now() - this.askedAt > AGAIN_MS) this.timer ||= setTimeout(() => this.send(), 0);
  }

  take(answer) {
    if (!this.place) return;
    this.answer = answer;
    this.changed();
  }

  clear() {
    if (!this.place) return;
    this.place = this.answer = null;
    clearTimeout(this.timer);
    this.timer = 0;
    this.changed();
  }

  /** The answer, if it is about the present place. */
  get fits() {
    const { place, answer } = this;
    return place && answer && distance([answer.x, answer.y], place) < NEAR_M ? answer : null;
  }

  /** Words beside the place. */
  show() {
    const { bubble, camera, answer, place } = this;
    if (!place) bubble.textContent = "";
    else if (this.fits && bubble.textContent !== answer.words) bubble.textContent = answer.words;
    bubble.hidden = !bubble.textContent;
    if (bubble.hidden) return;
    bubble.dataset.ok = String(answer.ok);
    const [w] = camera.size;
    const [px, py] = camera.toScreen(...place);
    const left = Math.min(w - bubble.offsetWidth - EDGE_PX, Math.max(EDGE_PX, px - bubble.offsetWidth / 2));
    const above = py - bubble.offsetHeight - 18;
    const top = above < EDGE_PX ? py + 22 : above;
    bubble.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
  }
}

function distance([x0, y0], [x1, y1]) {
  return Math.hypot(x1 - x0, y1 - y0);
}
