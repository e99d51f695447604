// SPDX-License-Identifier: GPL-3.0-or-later
// The page shows the last state that the server sent and sends wishes back; it decides nothing.

import { MapPanel } from "./map.js";
import { listenToTimeline, showTimeline } from "./timeline.js";

const RECONNECT_MS = 1000;
const STALE_MS = 2000;
const TOAST_MS = 6000;

const $ = (id) => document.getElementById(id);
const map = new MapPanel({ wish, toast });
let state = null;
let heardAt = 0;
let socket = null;
let toastTimer = 0;
let lastEvent = null;

// --- connection ----------------------------------------------------------------------------------

function connect() {
  socket = new WebSocket(`ws://${location.host}/socket`);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => {
    heardAt = performance.now();
    if (data instanceof ArrayBuffer) {
      map.takeCells(data);
      return;
    }
    const message = JSON.parse(data);
    if (message.kind === "state") take(message);
    else if (message.kind === "answer") answered(message);
    else map.takeOther(message);
  };
  socket.onclose = () => {
    showLink({ state: "closed", detail: "the ground station has gone" });
    setTimeout(connect, RECONNECT_MS);
  };
}

function wish(what) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
  else toast("no connection to the ground station");
}

function take(message) {
  state = message;
  map.take(message);
  show();
}

function answered({ do: what, ok, words }) {
  if (!ok) toast(`${label(what)} refused: ${words}`);
  map.answered(what);
}

// --- showing -------------------------------------------------------------------------------------

function show() {
  const { mission, drone, link, can, map: cells, fleet } = state;
  showFleet(fleet);
  const { latched, confirmed } = state.stop;
  $("state").textContent = latched || confirmed ? "stopped" : mission.words;
  $("detail").textContent = mission.fault;
  showLink(link);
  showTimeline(state.replay);
  $("stop").hidden = latched;
  const several = fleet.length > 1;
  $("stop-whom").textContent = several ? "cuts all motors, all drones fall" : "cuts the motors, the drone falls";
  $("latched").hidden = !latched && !confirmed;
  $("release").hidden = !latched;
  $("latched-text").textContent = confirmed
    ? "The motors are cut. The drone stays locked until it is restarted."
    : "STOP is being sent, again and again, until the drone confirms it.";
  for (const button of document.querySelectorAll("[data-do]")) button.disabled = !can[button.dataset.do];
  const [x, y, z] = drone.pose ?? [];
  $("position").textContent = drone.pose ? `${x.toFixed(2)}, ${y.toFixed(2)}` : "–";
  $("height").textContent = drone.pose ? `${z.toFixed(2)} m` : "–";
  $("path").textContent = drone.path_m === undefined ? "–" : `${drone.path_m.toFixed(1)} m`;
  $("battery").textContent = drone.battery_v === undefined ? "–" : `${drone.battery_v.toFixed(2)} V`;
  $("map-complete").textContent = `${Math.round(100 * cells.complete)} %`;
  const oldest = Math.max(...cells.ages_s);
  $("pieces").textContent = cells.rate_hz ? `${cells.rate_hz.toFixed(0)}/s, oldest ${oldest} s` : "–";
  $("pulse").textContent = pulseWords(link);
  const sent = (link.packets ?? 0) + (link.lost ?? 0);
  $("lost").textContent = sent ? `${((100 * link.lost) / sent).toFixed(1)} %` : "–";
  $("source").textContent = drone.source ?? "–";
  $("self-test").textContent = drone.self_test?.words ?? "–";
  $("self-test").dataset.state = drone.self_test?.state ?? "";
  showEvents(state.events);
}

/** A heartbeat goes out twice a second. */
function pulseWords({ round_trip_ms: ms, unanswered }) {
  if (unanswered > 2) return `not for ${(unanswered / 2).toFixed(0)} s`;
  return ms == null ? "–" : `in ${ms.toFixed(0)} ms`;
}

function showLink({ state: name, detail }) {
  $("link").dataset.state = name;
  $("link").lastElementChild.textContent = name === "connected" ? "connected" : detail;
}

/** All drones, where there are several: which one the rest of the page is about. */
function showFleet(fleet) {
  $("fleet").hidden = fleet.length < 2;
  while ($("fleet").children.length < fleet.length) {
    const [item, number] = [document.createElement("button"), $("fleet").children.length];
    item.type = "button";
    item.append(document.createElement("i"), document.createElement("b"), document.createElement("span"));
    item.onclick = () => choose(number);
    $("fleet").append(item);
  }
  fleet.forEach(({ name, colour, chosen, link, words }, n) => {
    const item = $("fleet").children[n];
    const [dot, label, text] = item.children;
    item.ariaPressed = String(chosen);
    item.title = name;
    dot.style.background = colour;
    label.textContent = `${n + 1}`;
    text.textContent = link === "connected" ? words : link;
  });
}

function choose(number) {
  wish({ do: "choose", drone: number });
  lastEvent = null;
  map.forget();
}

function showEvents(events) {
  const newest = events[0];
  const key = newest ? `${newest.n}/${newest.t}` : "";
  if (key === lastEvent) return;
  if (lastEvent !== null && newest?.level === "warning") toast(newest.words);
  lastEvent = key;
  $("events").replaceChildren(...events.map(eventItem));
}

function eventItem({ t, words, level }) {
  const item = document.createElement("li");
  const time = document.createElement("time");
  const text = document.createElement("span");
  item.dataset.level = level;
  time.textContent = `${t.toFixed(1)} s`;
  text.textContent = words;
  item.append(time, text);
  return item;
}

function toast(text) {
  $("toast").textContent = text;
  clearTimeout(toastTimer);
  toastTimer = setTimeout(() => ($("toast").textContent = ""), TOAST_MS);
}

function label(what) {
  if (what === "goto") return "Goal";
  const button = document.querySelector(`[data-do="${what}"]`);
  return button?.ariaLabel ?? button?.textContent ?? what;
}

function watchSilence() {
  if (state && performance.now() - heardAt > STALE_MS) {
    showLink({ state: "silent", detail: "the ground station is silent" });
  }
}

// --- wishes --------------------------------------------------------------------------------------

$("stop").onclick = () => wish({ do: "stop" });
$("release").onclick = () => wish({ do: "release" });
for (const button of document.querySelectorAll("[data-do]")) {
  button.onclick = () => wish({ do: button.dataset.do });
}
addEventListener("keydown", (event) => {
  if (event.code !== "Space" || event.repeat || state?.replay) return;
  event.preventDefault(); // also for a focused button: Space is STOP, everywhere
  wish({ do: "stop" });
});
addEventListener("keyup", (event) => {
  if (event.code === "Space" && !state?.replay) event.preventDefault();
});

listenToTimeline(wish);
connect();
setInterval(watchSilence, STALE_MS / 4);
