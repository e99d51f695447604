// SPDX-License-Identifier: GPL-3.0-or-later
// Put into the page by the bench: notes when states came, when it drew, and which map that was.
// Times in milliseconds since 1970, so that they compare with the recording's.

const now = () => performance.timeOrigin + performance.now();

globalThis.meter = { states: [], draws: [], draw_ms: [], maps: [] };

/** Called once the page runs. */
globalThis.meterPage = async () => {
  const { View } = await import("/view.js");
  const { draw, takeCells } = View.prototype;
  let shown = null; // revision of a map that was not drawn yet
  View.prototype.takeCells = function (buffer) {
    takeCells.call(this, buffer);
    shown = this.cells.map.revision;
  };
  const always = () => { // it draws when something has changed: let that be in every frame
    wayflie.map.changed();
    requestAnimationFrame(always);
  };
  always();
  View.prototype.draw = function (...given) {
    const begin = performance.now();
    const result = draw.apply(this, given);
    meter.draw_ms.push(performance.now() - begin);
    meter.draws.push(now());
    if (shown !== null) {
      const revision = shown;
      requestAnimationFrame(() => meter.maps.push([revision, now()])); // the one drawn is on screen
      shown = null;
    }
    return result;
  };
};

globalThis.WebSocket = class extends WebSocket {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({ data }) => {
      if (typeof data === "string" && JSON.parse(data).kind === "state") meter.states.push(now());
    });
  }
};
