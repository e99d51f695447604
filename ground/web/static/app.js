// SPDX-License-Identifier: GPL-3.0-or-later
// The page shows the last state that the server sent and sends wishes back; it decides nothing.
// Here the parts of the page are put together.

import { Connection } from "./connection.js";
import { $ } from "./dom.js";
import { forgetEvents, showEvents } from "./events.js";
import { showFleet } from "./fleet.js";
import { Hand } from "./hand.js";
import { MapPanel } from "./map.js";
import { sentence, showNoGround, showNow } from "./now.js";
import { answeredParameter, showParameters } from "./parameters.js";
import { showStatus } from "./status.js";
import { Stop } from "./stop.js";
import { listenToTimeline, showTimeline } from "./timeline.js";

const WATCH_MS = 500;
const TOAST_MS = 6000;

const connection = new Connection();
const stop = new Stop(connection);
const hand = new Hand((what) => connection.send(what));
const map = new MapPanel({ wish });
let toastTimer = 0;

function wish(what) {
  if (!connection.send(what)) toast("no connection to the ground station");
}

const TAKE = {
  state: takeState,
  answer: takeAnswer,
  events: (message) => showEvents(message, alarm),
  parameters: takeParameters,
};

function takeState(state) {
  const { can, fleet, replay } = state;
  map.take(state);
  stop.take(state);
  hand.take(state);
  showFleet(fleet, choose);
  showNow(state, stop.headline);
  showTimeline(replay);
  for (const button of document.querySelectorAll("[data-do]")) button.disabled = !can[button.dataset.do];
  showStatus(state);
}

function takeAnswer(answer) {
  if (answer.do === "set") answeredParameter(answer);
  else if (!answer.ok) toast(`${label(answer.do)} refused: ${sentence(answer.words, answer.step)}`);
  map.answered(answer.do, answer);
}

function takeParameters({ rows }) {
  showParameters(rows, (name, value) => wish({ do: "set", name, value }));
  hand.takeParameters(rows);
}

/** What is shown is old from now on, and nothing but STOP can be wished for. */
function takeClose() {
  showNoGround("the ground station has gone");
  hand.toggle(false);
  for (const button of document.querySelectorAll("[data-do], #hand")) button.disabled = true;
}

function choose(number) {
  wish({ do: "choose", drone: number });
  forgetEvents();
  hand.toggle(false);
  map.forget();
}

/** After STOP everybody knows. */
function alarm(words) {
  if (!stop.on) toast(words);
}

function toast(text) {
  $("toast").textContent = text;
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => ($("toast").textContent = ""), TOAST_MS);
}

const LABELS = { goto: "Goal", manual: "Flying by hand", area: "Area", fly: "Waypoints", patrol: "Patrol" };

function label(what) {
  if (what in LABELS) return LABELS[what];
  const button = document.querySelector(`[data-do="${what}"]`);
  return button?.ariaLabel ?? button?.textContent ?? what;
}

for (const button of document.querySelectorAll("[data-do]")) {
  button.onclick = () => wish({ do: button.dataset.do });
}
connection.addEventListener("cells", ({ detail }) => map.takeCells(detail));
connection.addEventListener("message", ({ detail }) => (TAKE[detail.kind] ?? map.takeOther.bind(map))(detail));
connection.addEventListener("open", () => {
  stop.show();
  map.opened();
});
connection.addEventListener("close", takeClose);
setInterval(() => {
  if (connection.isSilent) showNoGround("the ground station is silent");
}, WATCH_MS);
listenToTimeline(wish);
connection.open();
