// The world that is drawn, and its history: every change can be undone, without limit.

import { KEEP } from "./shapes.js";

const DRAFT = "worldgen-studio-draft";
const OPENED = "worldgen-studio-opened";
const LARGEST_DRAFT = 4e6; // characters: what browsers keep at least

/** An empty world of the thesis's kind: a border of walls, start and target in opposite corners. */
export function emptyWorld(width, height, usual = {}) {
  const cell = usual.cell_size || 0.1;
  const cells = new Uint8Array(width * height);
  for (let ix = 0; ix < width; ix += 1) cells[ix] = cells[(height - 1) * width + ix] = 1;
  for (let iy = 0; iy < height; iy += 1) cells[iy * width] = cells[iy * width + width - 1] = 1;
  return {
    width,
    height,
    cells,
    cell_size: cell,
    robot_radius: usual.robot_radius || 0.07,
    robot_speed: usual.robot_speed || 2,
    start: [round(2.5 * cell), round(2.5 * cell), 0],
    target: [round((width - 2.5) * cell), round((height - 2.5) * cell), round(0.5 * cell)],
    events: null,
    source: null,
    name: "", // of its file in the folder; empty: it has none
  };
}

/** A length without the dirt of binary arithmetic. */
export function round(value) {
  return Number(value.toFixed(9));
}

/** A world as the server sends it, made ready to edit; with the name of its file, if it has one. */
export function worldOf(message, name = "") {
  const bytes = Uint8Array.from(atob(message.cells), (letter) => letter.charCodeAt(0));
  const cells = Uint8Array.from({ length: message.width * message.height }, (_, k) => (bytes[k >> 3] >> (k & 7)) & 1);
  return { ...message, cells, name };
}

/** A world as the server wants it. */
export function messageOf(world) {
  const bytes = new Uint8Array(Math.ceil(world.cells.length / 8));
  for (let k = 0; k < world.cells.length; k += 1) if (world.cells[k]) bytes[k >> 3] |= 1 << (k & 7);
  let text = "";
  for (let k = 0; k < bytes.length; k += 8192) text += String.fromCharCode(...bytes.subarray(k, k + 8192));
  return { ...world, name: undefined, cells: btoa(text) }; // what is undefined is not sent
}

/** A world and its history. `changed` is called after each change. */
export class Model {
  constructor(world, changed) {
    this.world = world;
    this.changed = changed;
    this.past = [];
    this.future = [];
    this.version = 0; // of what is seen; goes up with each change
    this.counted = { version: -1, solid: 0 };
    this.saved = null; // the last entry of the past when it was saved
    this.stroke = null;
  }

  get unsaved() {
    return this.saved !== (this.past.at(-1) || null);
  }

  /** How many cells are solid; counted once for each version. */
  get solid() {
    if (this.counted.version !== this.version) {
      let solid = 0;
      for (const cell of this.world.cells) solid += cell;
      this.counted = { version: this.version, solid };
    }
    return this.counted.solid;
  }

  /** Sets cells in the stroke that is being drawn; cells outside are passed over. */
  paint(cells, value) {
    const { width, height, cells: all } = this.world;
    this.stroke ||= new Set();
    for (const [ix, iy] of cells) {
      if (ix < 0 || iy < 0 || ix >= width || iy >= height) continue;
      const k = iy * width + ix;
      if (all[k] === value) continue;
      all[k] = value;
      if (!this.stroke.delete(k)) this.stroke.add(k);
    }
    this.touch();
  }

  /** Puts a pattern down, its lower left corner at (x, y). */
  put(pattern, [x, y]) {
    for (const value of [0, 1]) {
      const cells = [];
      pattern.cells.forEach((cell, k) => {
        if (cell === value && cell !== KEEP) cells.push([x + (k % pattern.width), y + Math.floor(k / pattern.width)]);
      });
      this.paint(cells, value);
    }
  }

  /** Ends the stroke: one step of the history. */
  lift(label) {
    const stroke = this.stroke;
    this.stroke = null;
    if (stroke && stroke.size > 0) this.note({ label, cells: Int32Array.from(stroke) });
  }

  /** Changes anything but single cells; changes of one kind that follow each other, as of a slider, are one step. */
  change(label, parts, together = false) {
    const last = this.past.at(-1);
    const before = this.world;
    this.world = { ...before, ...parts };
    if (together && last && last.together === label && last !== this.saved) {
      last.after = this.world;
      this.future = [];
      this.touch();
    } else this.note({ label, before, after: this.world, together: together ? label : null });
  }

  note(entry) {
    this.past.push(entry);
    this.future = [];
    this.touch();
  }

  undo() {
    this.lift("stroke");
    const entry = this.past.pop();
    if (!entry) return null;
    this.future.push(entry);
    this.turn(entry, entry.before);
    return entry.label;
  }

  redo() {
    const entry = this.future.pop();
    if (!entry) return null;
    this.past.push(entry);
    this.turn(entry, entry.after);
    return entry.label;
  }

  turn(entry, world) {
    if (entry.cells) for (const k of entry.cells) this.world.cells[k] ^= 1;
    else this.world = world;
    this.touch();
  }

  touch() {
    this.version += 1;
    this.changed();
  }

  markSaved(name, source) {
    this.world.name = name;
    this.world.source = source;
    this.saved = this.past.at(-1) || null;
    this.changed();
  }

  /** Keeps what is drawn in the browser, in case the page or the server ends. */
  keepDraft() {
    try {
      const text = JSON.stringify({ name: this.world.name, world: messageOf(this.world) });
      if (text.length < LARGEST_DRAFT && this.unsaved) localStorage.setItem(DRAFT, text);
      else localStorage.removeItem(DRAFT);
      sessionStorage.setItem(OPENED, this.unsaved ? "" : this.world.name);
    } catch {
      // a browser that keeps nothing: what is saved is in the folder
    }
  }
}

/** What was drawn and not saved when the page was last here. */
export function draft() {
  try {
    const { name, world } = JSON.parse(localStorage.getItem(DRAFT));
    return worldOf(world, name);
  } catch {
    return null;
  }
}

/** The file that was open when this tab was loaded anew; empty where there was none. */
export function openedBefore() {
  try {
    return sessionStorage.getItem(OPENED) || "";
  } catch {
    return "";
  }
}

/** The same world in another size: what lies beyond is cut, what is new is free; start and target are kept inside. */
export function resized(world, width, height) {
  const cells = new Uint8Array(width * height);
  for (let iy = 0; iy < Math.min(height, world.height); iy += 1)
    cells.set(world.cells.subarray(iy * world.width, iy * world.width + Math.min(width, world.width)), iy * width);
  const inside = ([x, y, ...rest]) => [
    Math.min(x, round((width - 0.5) * world.cell_size)),
    Math.min(y, round((height - 0.5) * world.cell_size)),
    ...rest,
  ];
  return {
    width,
    height,
    cells,
    start: inside(world.start),
    target: inside(world.target),
    events: eventsIn(world, width, height),
  };
}

function eventsIn({ events }, width, height) {
  if (!events) return null;
  const kept = events.ix.map((ix, k) => k).filter((k) => events.ix[k] < width && events.iy[k] < height);
  const pick = (column) => kept.map((k) => column[k]);
  if (kept.length === 0) return null;
  return { times: pick(events.times), ix: pick(events.ix), iy: pick(events.iy), state: pick(events.state) };
}
