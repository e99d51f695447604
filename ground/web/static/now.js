// SPDX-License-Identifier: GPL-3.0-or-later
// The headline: what the drone does; or what was heard last, why nothing comes, and what to do.

import { $, say } from "./dom.js";

const LINK = { connected: "connected", closed: "no drone", silent: "nothing heard" };
const LOST = "link lost";
let heard = ""; // what it did when it was heard last

/** A state message of the server. @param stopped what the headline says in place of it, if anything */
export function showNow({ mission, link, replay, alone }, stopped) {
  showLink(replay ? "recording" : (LINK[link.state] ?? LOST), link.state);
  if (link.state === "connected") {
    heard = mission.words;
    show(stopped || heard, stopped ? "" : sentence(mission.fault, mission.step));
  } else if (link.state === "closed") {
    show("waiting for a drone", sentence(link.detail, link.step));
  } else {
    show(`last heard: ${heard}`, [link.detail, alone].filter(Boolean).join("; "));
  }
}

/** Nothing comes from the ground station. */
export function showNoGround(words) {
  showLink(words, "closed");
  show(heard ? `last heard: ${heard}` : "no data yet", "");
}

/** What is wrong, and what to do about it. */
export function sentence(words, step) {
  return words && step ? `${words}. Next: ${step}.` : words;
}

function show(state, detail) {
  say($("state"), state);
  say($("detail"), detail);
}

function showLink(words, state) {
  $("link").dataset.state = state;
  say($("link").lastElementChild, words);
  document.body.classList.toggle("stale", state !== "connected");
}
