// SPDX-License-Identifier: GPL-3.0-or-later
// The time line of a recording: play, pause, wind.

import { $ } from "./dom.js";

const PLAY = "\u25b6";
const PAUSE = "\u275a\u275a";
const WINDS_MS = 150;
let timer = 0; // runs while the wish for the slider's newest place waits
let held = false; // the user holds the slider: it stays where it is held

export function showTimeline(replay) {
  $("timeline").hidden = !replay;
  document.body.classList.toggle("replay", Boolean(replay));
  if (!replay) return;
  const slider = $("time");
  slider.max = replay.of_s;
  if (!held) slider.value = replay.at_s;
  slider.ariaValueText = words(slider.value, replay.of_s);
  $("time-text").value = slider.ariaValueText;
  $("play").textContent = replay.playing ? PAUSE : PLAY;
  $("play").ariaLabel = replay.playing ? "Pause" : "Play";
}

export function listenToTimeline(wish) {
  const slider = $("time");
  $("timeline").onsubmit = (event) => event.preventDefault();
  $("play").onclick = () => wish({ do: $("play").ariaLabel.toLowerCase() });
  slider.oninput = () => {
    held = true;
    timer ||= setTimeout(() => {
      timer = 0;
      wish({ do: "seek", s: Number(slider.value) });
    }, WINDS_MS);
  };
  slider.onchange = () => setTimeout(() => (held = false), 2 * WINDS_MS); // until it is there
}

function words(at, of) {
  return `${clock(at)} / ${clock(of)}`;
}

function clock(seconds) {
  const whole = Math.floor(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
