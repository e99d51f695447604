// SPDX-License-Identifier: GPL-3.0-or-later
// All drones, where there are several: which one the rest of the page is about.

import { $ } from "./dom.js";

export function showFleet(fleet, choose) {
  const list = $("fleet");
  list.hidden = fleet.length < 2;
  while (list.children.length < fleet.length) list.append(button(list.children.length, choose));
  fleet.forEach(({ name, colour, chosen, link, words }, n) => {
    const item = list.children[n];
    const [dot, label, text] = item.children;
    item.ariaPressed = String(chosen);
    item.title = name;
    dot.style.background = colour;
    label.textContent = `${n + 1}`;
    text.textContent = link === "connected" ? words : link;
  });
}

function button(number, choose) {
  const item = document.createElement("button");
  item.type = "button";
  item.append(...["i", "b", "span"].map((tag) => document.createElement(tag)));
  item.onclick = () => choose(number);
  return item;
}
