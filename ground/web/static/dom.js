// SPDX-License-Identifier: GPL-3.0-or-later
// What every part of the page does with its elements.

export const $ = (id) => document.getElementById(id);

/** Only what changed is written: a screen reader reads it out. */
export function say(element, words) {
  if (element.textContent !== words) element.textContent = words;
}
