// SPDX-License-Identifier: GPL-3.0-or-later
// What the map shows: a menu of layers that stays as the user left it.

const KEPT_AS = "wayflie.layers";

/** Name, words, shown at first; `asked`: the server computes it for who wants it. */
const LAYERS = [
  { name: "points", words: "Obstacle points", shown: true },
  { name: "beams", words: "Beams", shown: true },
  { name: "trail", words: "Trail", shown: true },
  { name: "odometry", words: "Odometry alone", shown: true },
  { name: "route", words: "Route", shown: true },
  { name: "area", words: "Area", shown: true },
  { name: "people", words: "People seen now", shown: true, asked: true },
  { name: "preview", words: "Way to the pointer", shown: true },
  { name: "frontiers", words: "Frontiers", shown: false, asked: true },
  { name: "tree", words: "RRT* tree", shown: false, asked: true },
  { name: "age", words: "Age of the map", shown: false },
];

export class Layers {
  /** changed() is called after each choice. */
  constructor(button, menu, changed) {
    [this.button, this.menu] = [button, menu];
    const kept = read();
    this.shown = Object.fromEntries(LAYERS.map(({ name, shown }) => [name, kept[name] ?? shown]));
    for (const { name, words } of LAYERS) menu.append(this.item(name, words, changed));
    const note = document.createElement("p");
    const computed = LAYERS.filter(({ asked }) => asked).map(({ words }) => words);
    note.textContent = `Computed here, by the drone's own code, from the map received: ${computed.join(", ")}.`;
    menu.append(note);
    button.onclick = () => this.open(menu.hidden);
    menu.addEventListener("keydown", (event) => this.key(event));
    addEventListener("pointerdown", ({ target }) => {
      if (!menu.contains(target) && !button.contains(target)) this.open(false);
    });
  }

  /** Names of the layers that the server shall compute. */
  get asked() {
    return LAYERS.filter(({ name, asked }) => asked && this.shown[name]).map(({ name }) => name);
  }

  item(name, words, changed) {
    const label = document.createElement("label");
    const box = document.createElement("input");
    const text = document.createElement("span");
    const sign = document.createElement("i");
    [box.type, box.id, box.checked] = ["checkbox", `layer-${name}`, this.shown[name]];
    sign.className = `sign ${name}`;
    text.textContent = words;
    box.onchange = () => {
      this.shown[name] = box.checked;
      keep(this.shown);
      changed();
    };
    label.append(box, sign, text);
    return label;
  }

  open(open) {
    if (this.menu.hidden === !open) return;
    this.menu.hidden = !open;
    this.button.ariaExpanded = String(open);
    if (open) this.menu.querySelector("input").focus();
  }

  key(event) {
    const boxes = [...this.menu.querySelectorAll("input")];
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step) {
      const next = (boxes.indexOf(document.activeElement) + step + boxes.length) % boxes.length;
      boxes[next].focus();
    } else if (event.key === "Enter") {
      document.activeElement.click();
    } else if (event.key === "Escape") {
      this.open(false);
      this.button.focus();
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }
}

function read() {
  try {
    return JSON.parse(localStorage.getItem(KEPT_AS)) ?? {};
  } catch {
    return {}; // nothing is kept where cookies are forbidden
  }
}

function keep(shown) {
  try {
    localStorage.setItem(KEPT_AS, JSON.stringify(shown));
  } catch {
    // as above
  }
}
