// SPDX-License-Identifier: GPL-3.0-or-later
// What happened on board: all that the ground has kept of it, the newest on top.

import { $ } from "./dom.js";

let newest = null; // what was on top before

/** @param {(words: string) => void} alarm for what somebody should see at once */
export function showEvents({ rows, missing }, alarm) {
  const top = rows[0];
  const key = top ? `${top.n}/${top.t}` : "";
  if (newest !== null && key !== newest && (top?.level === "warning" || top?.level === "error")) alarm(top.words);
  newest = key;
  $("events").replaceChildren(...rows.map(item));
  $("events-none").hidden = rows.length > 0;
  $("events-missing").hidden = !missing;
  $("events-missing").textContent = `${missing} earlier ${missing === 1 ? "event is" : "events are"} not here`;
}

/** Another drone: what it brings first is no news. */
export function forgetEvents() {
  newest = null;
}

function item({ t, words, level }) {
  const [row, time, text] = ["li", "time", "span"].map((tag) => document.createElement(tag));
  row.dataset.level = level;
  time.textContent = `${t.toFixed(1)} s`;
  text.textContent = words;
  row.append(time, text);
  return row;
}
