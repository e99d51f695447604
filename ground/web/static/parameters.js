// SPDX-License-Identifier: GPL-3.0-or-later
// What can be tuned: one row a parameter, as the drone's own source describes it. A change goes out
// when it is complete, and the row shows what the drone made of it.

import { $ } from "./dom.js";

const SAID_MS = 4000;
let rows = new Map();

/** @param {(name: string, value: number) => void} set */
export function showParameters(table, set) {
  $("parameters").hidden = table.length === 0;
  if (table.some(({ name }) => !rows.has(name)) || table.length !== rows.size) build(table, set);
  for (const row of table) rows.get(row.name).take(row);
}

/** The answer to set(). */
export function answeredParameter({ name, ok, words }) {
  rows.get(name)?.answered(ok, words);
}

function build(table, set) {
  rows = new Map(table.map((row) => [row.name, new Row(row, set)]));
  $("parameter-groups").replaceChildren(...[...grouped(table)].map(([name, of]) => fieldset(name, of)));
}

function grouped(table) {
  const groups = new Map();
  for (const row of table) groups.set(row.group, [...(groups.get(row.group) ?? []), row]);
  return groups;
}

function fieldset(name, table) {
  const group = make("fieldset", "");
  group.append(make("legend", name), ...table.map((row) => rows.get(row.name).element));
  return group;
}

class Row {
  constructor({ name, choices, min, max, unit, type, help, default: usual }, set) {
    this.value = null;
    this.usual = usual;
    this.set = set;
    this.name = name;
    const id = name.replace(".", "-");
    this.element = make("div", "");
    this.element.className = "parameter";
    const label = make("label", name.replace("way.", ""));
    label.htmlFor = id;
    this.input = choices.length ? select(choices) : number(min, max, type);
    this.input.id = id;
    this.input.setAttribute("aria-describedby", `${id}-help`);
    this.input.onchange = () => this.#change(this.input.value);
    this.reset = make("button", "Reset");
    this.reset.type = "button";
    this.reset.title = `Back to ${choices[usual] ?? usual} ${unit}`.trim();
    this.reset.ariaLabel = `Reset ${label.textContent}`;
    this.reset.onclick = () => this.#change(usual);
    const entry = make("span", "");
    entry.className = "entry";
    entry.append(this.input, make("small", unit), this.reset);
    const about = make("p", choices.length ? help.split(":")[0] : help);
    about.id = `${id}-help`;
    this.said = make("output", "");
    this.element.append(label, entry, about, this.said);
  }

  take({ value }) {
    this.value = value;
    const editing = document.activeElement === this.input && this.input.type === "number";
    if (!editing || Number(this.input.value) === value) this.input.value = value;
    this.reset.hidden = value === this.usual;
  }

  answered(ok, words) {
    this.said.dataset.level = ok ? "good" : "warning";
    this.said.value = ok ? "set" : words;
    if (!ok) this.input.value = this.value;
    clearTimeout(this.timer);
    if (ok) this.timer = setTimeout(() => (this.said.value = ""), SAID_MS);
  }

  #change(value) {
    if (String(value).trim() === "" || Number.isNaN(Number(value))) {
      this.answered(false, "not a number");
      return;
    }
    this.said.value = "…";
    this.set(this.name, Number(value));
  }
}

function select(choices) {
  const box = make("select", "");
  choices.forEach((words, value) => {
    const option = make("option", words);
    option.value = value;
    box.append(option);
  });
  return box;
}

function number(min, max, type) {
  const box = make("input", "");
  box.type = "number";
  box.step = type === "float" ? "any" : "1";
  if (min !== null) [box.min, box.max] = [min, max];
  return box;
}

function make(tag, text) {
  const element = document.createElement(tag);
  element.textContent = text;
  return element;
}
