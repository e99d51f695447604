// SPDX-License-Identifier: GPL-3.0-or-later
// The numbers: what the drone and the link to it are doing.

import { $ } from "./dom.js";

const NONE = "\u2013";

export function showStatus({ drone, link, map, status }) {
  const [x, y, z, yaw] = drone.pose ?? [];
  put("position", drone.pose && `${x.toFixed(2)}, ${y.toFixed(2)} m`);
  put("height", drone.pose && `${z.toFixed(2)} m`);
  put("heading", drone.pose && `${Math.round((180 * yaw) / Math.PI)}\u00b0`);
  put("path", drone.path_m != null && `${drone.path_m.toFixed(1)} m`);
  put("battery", drone.battery_v !== undefined && `${drone.battery_v.toFixed(2)} V`);
  put("source", drone.source);
  put("confidence", status.confidence !== undefined && `${status.confidence} %`);
  put("correction", correctionWords(status.correction));
  put("map-complete", `${Math.round(100 * map.complete)} %`);
  put("pieces", status.map_age_s != null && `${status.map_age_s.toFixed(0)} s, ${map.rate_hz.toFixed(0)}/s`);
  put("rate", status.rate_hz !== undefined && `${status.rate_hz.toFixed(0)}/s`);
  put("lost", status.loss !== undefined && `${(100 * status.loss).toFixed(1)} %`);
  put("pulse", pulseWords(status));
  put("tick", status.tick_us && `${(status.tick_us / 1000).toFixed(2)} ms`);
  put("plan", status.plan_us && `${(status.plan_us / 1000).toFixed(0)} ms`);
  put("self-test", drone.self_test?.words);
  $("self-test").dataset.state = drone.self_test?.state ?? "";
}

function put(id, words) {
  $(id).textContent = words || NONE;
}

function correctionWords(correction) {
  if (!correction) return "";
  const { ago_s: ago, moved_m: moved, turned_deg: turned } = correction;
  const when = ago < 1 ? "just now" : `${ago.toFixed(0)} s ago`;
  return `${(100 * moved).toFixed(1)} cm, ${Math.abs(turned).toFixed(1)}\u00b0, ${when}`;
}

/** A heartbeat goes out twice a second. */
function pulseWords({ round_trip_ms: ms, unanswered }) {
  if (unanswered > 2) return `not for ${(unanswered / 2).toFixed(0)} s`;
  return ms == null ? "" : `in ${ms.toFixed(0)} ms`;
}
