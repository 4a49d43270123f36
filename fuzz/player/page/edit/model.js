// The drawn world and its history: every change can be undone, without limit.

import { KEEP } from "#player/edit/shapes.js";

const MOST_BOXES = 64; // number of recent boxes of painted cells to remember

/**
 * Returns an empty world: a border of walls if there is space for one, and start and target
 * in opposite corners.
 * @param {number} width
 * @param {number} height
 * @param {UsualWorld} usual - Cells and robot
 * @returns {EditedWorld}
 */
export function emptyWorld(width, height, { cell_size: cell, robot_radius, robot_speed }) {
  const cells = bordered(width, height);
  const near = (side) => round((side < 3 ? 0.5 : side < 6 ? 1.5 : 2.5) * cell),
    far = (side) => round(side * cell - near(side));
  return {
    width,
    height,
    cells,
    cell_size: cell,
    robot_radius,
    robot_speed,
    start: [near(width), near(height), 0],
    target: [far(width), far(height), round(0.5 * cell)],
    events: null,
    others: [],
    source: null,
    name: "", // name of its file in the folder; empty if it has none
    file: null, // the digest of that file when it was opened or saved
    sheet: Symbol("sheet"), // the same for all versions of one drawing
  };
}

/**
 * Returns how many robots the world has; the page edits the first.
 * @param {EditedWorld} world
 * @returns {number}
 */
export function robotsIn(world) {
  return 1 + world.others.length;
}

/**
 * Returns free cells with a border of walls; a side of one or two cells has no space for a border.
 * @param {number} width
 * @param {number} height
 * @returns {Uint8Array}
 */
export function bordered(width, height) {
  const cells = new Uint8Array(width * height);
  for (let ix = 0; height > 2 && ix < width; ix += 1) cells[ix] = cells[(height - 1) * width + ix] = 1;
  for (let iy = 0; width > 2 && iy < height; iy += 1) cells[iy * width] = cells[iy * width + width - 1] = 1;
  return cells;
}

/**
 * Rounds a length to hide the errors of binary arithmetic.
 * @param {number} value
 * @returns {number}
 */
export function round(value) {
  return Number(value.toFixed(9));
}

/** A world and its history. `changed` is called after each change. */
export class Model {
  /**
   * @param {EditedWorld} world
   * @param {() => void} changed
   */
  constructor(world, changed) {
    /** @type {EditedWorld} */
    this.world = world;
    this.changed = changed;
    /** @type {HistoryEntry[]} */
    this.past = [];
    /** @type {HistoryEntry[]} */
    this.future = [];
    this.version = 0; // version of the visible world; increases with each change
    this.counted = { version: -1, solid: 0 };
    this.hashed = { version: -1, digest: "" };
    /** @type {{entry: HistoryEntry | null, shows: Record<string, string>} | null} */
    this.made = null; // the last generated world: its place in the history, and what a link to it contains
    /** @type {HistoryEntry | null} */
    this.saved = null; // the last entry of the past at the time of saving
    /** @type {Uint8Array | null} */
    this.stroke = null; // the cells before the current stroke
    /** @type {{since: number, boxes: (Box & {version: number})[]}} */
    // the cells changed after that version, each box with its version
    this.painted = { since: 0, boxes: [] };
  }

  get unsaved() {
    return this.saved !== (this.past.at(-1) || null);
  }

  /** The number of solid cells, counted only once for each version. */
  get solid() {
    if (this.counted.version !== this.version) {
      let solid = 0;
      for (const cell of this.world.cells) solid += cell;
      this.counted = { version: this.version, solid };
    }
    return this.counted.solid;
  }

  /** A digest of the visible world, without its file; computed only once for each version. */
  get digest() {
    if (this.hashed.version !== this.version) this.hashed = { version: this.version, digest: digestOf(this.world) };
    return this.hashed.digest;
  }

  /** Records that the visible world has just been generated. */
  markMade(shows) {
    this.made = { entry: this.mark(), shows };
  }

  /** What a link to the visible world contains, if it is as it was generated; else null. */
  get link() {
    return this.made && this.made.entry === (this.past.at(-1) || null) && !this.stroke ? this.made.shows : null;
  }

  /** Sets boxes of cells in the current stroke, ignoring anything outside. */
  paint(boxes, value) {
    const { width, height } = this.world,
      all = this.begun();
    for (const box of boxes) {
      const from = Math.max(0, box.x),
        to = Math.min(width, box.x + box.width);
      if (from >= to) continue;
      const low = Math.max(0, box.y),
        high = Math.min(height, box.y + box.height);
      for (let iy = low; iy < high; iy += 1) all.fill(value, iy * width + from, iy * width + to);
    }
    this.touch(boxAround(boxes));
  }

  /** Sets cells by their numbers, which count row by row from the lowest. */
  paintCells(numbers, value) {
    const all = this.begun();
    // much faster than for ... of for millions of cells
    for (let k = 0; k < numbers.length; k += 1) all[numbers[k]] = value;
    this.touch(rowsOf(numbers, this.world.width));
  }

  /** Puts a pattern down with its lower left corner at (x, y). */
  put(pattern, [x, y]) {
    const { width, height } = this.world,
      all = this.begun();
    pattern.cells.forEach((cell, k) => {
      const ix = x + (k % pattern.width),
        iy = y + Math.floor(k / pattern.width);
      if (cell !== KEEP && ix >= 0 && iy >= 0 && ix < width && iy < height) all[iy * width + ix] = cell;
    });
    this.touch({ x, y, width: pattern.width, height: pattern.height });
  }

  // Returns the cells for changing, and keeps a copy until the stroke ends.
  begun() {
    this.stroke ||= this.world.cells.slice();
    return this.world.cells;
  }

  /** Ends the stroke, which becomes one step of the history. */
  lift(label) {
    const before = this.stroke,
      { cells } = this.world;
    this.stroke = null;
    if (!before) return;
    const runs = runsOf(cells, before);
    if (runs.length > 0) this.note({ label, runs });
  }

  /** Changes anything but single cells; consecutive changes of one kind, as from a slider,
   * become one step. */
  change(label, parts, together = false) {
    this.lift("stroke");
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
    this.lift("stroke");
    const entry = this.future.pop();
    if (!entry) return null;
    this.past.push(entry);
    this.turn(entry, entry.after);
    return entry.label;
  }

  turn(entry, world) {
    const { cells, width } = this.world;
    for (let k = 0; entry.runs && k < entry.runs.length; k += 2)
      for (let at = entry.runs[k]; at < entry.runs[k + 1]; at += 1) cells[at] ^= 1;
    if (!entry.runs) this.world = world;
    this.touch(entry.runs ? rowsOf(entry.runs, width) : null);
  }

  /**
   * Notes a change, and the box of cells that it may have affected.
   * @param {Box | null} [box]
   */
  touch(box = null) {
    this.version += 1;
    const { painted } = this;
    if (box) painted.boxes.push({ ...box, version: this.version });
    const oldest = painted.boxes.length > MOST_BOXES ? painted.boxes.shift() : undefined;
    if (oldest) painted.since = oldest.version;
    this.changed();
  }

  /** Returns a box of all cells that may have changed after a version;
   * null if that is no longer known. */
  boxSince(version) {
    const { since, boxes } = this.painted,
      { width, height } = this.world;
    if (version < since) return null;
    const all = boxAround(boxes.filter((box) => box.version > version));
    const x = Math.max(0, all.x),
      y = Math.max(0, all.y);
    return { x, y, width: Math.min(width, all.x + all.width) - x, height: Math.min(height, all.y + all.height) - y };
  }

  /** Returns the step of the history that is being saved; later changes become a new step. */
  mark() {
    this.lift("stroke");
    const last = this.past.at(-1) || null;
    if (last) last.together = null;
    return last;
  }

  /** Records that the state at a mark is saved in a file; earlier versions of the drawing get the
   * file's name too. */
  markSaved(name, source, file, mark) {
    const { sheet } = this.world,
      entries = [...this.past, ...this.future];
    for (const world of [this.world, ...entries.flatMap(({ before, after }) => [before, after])])
      if (world && world.sheet === sheet) Object.assign(world, { name, source, file });
    this.saved = mark;
    this.changed();
  }
}

/**
 * Returns true if only the file's text has everything about the robots: version 2 has several, or
 * one with a goal, a body or a drive that the page does not edit.
 * @param {{source: string | null}} world
 * @returns {boolean}
 */
export function hasMoreInFile({ source }) {
  return source !== null && source.startsWith("%worldgen-grid 2");
}

/**
 * Returns a digest of 53 bits of everything about a world that a run depends on.
 * @param {EditedWorld} world
 * @returns {string}
 */
function digestOf({ cells, name, file, sheet, source, ...rest }) {
  const text = JSON.stringify([rest, hasMoreInFile({ source }) ? source : null]);
  let low = 0x9e3779b9,
    high = 0x41c6ce57;
  const take = (value) => {
    low = Math.imul(low ^ value, 2654435761);
    high = Math.imul(high ^ value, 1597334677);
    low ^= low >>> 15;
    high ^= high >>> 13;
  };
  for (let k = 0; k < text.length; k += 1) take(text.charCodeAt(k));
  for (let k = 0; k < cells.length; k += 1) take(cells[k]);
  return (4294967296 * (2097151 & high) + (low >>> 0)).toString(36);
}

/**
 * Returns where two maps differ: start and end of each run of cells, in order. This is compact
 * enough to keep the entire history.
 * @param {Uint8Array} cells
 * @param {Uint8Array} before
 * @returns {Int32Array}
 */
function runsOf(cells, before) {
  const runs = [];
  let k = 0;
  while (k < cells.length) {
    while (k < cells.length && cells[k] === before[k]) k += 1;
    if (k === cells.length) break;
    runs.push(k);
    while (k < cells.length && cells[k] !== before[k]) k += 1;
    runs.push(k);
  }
  return Int32Array.from(runs);
}

/**
 * @param {Box[]} boxes
 * @returns {Box}
 */
function boxAround(boxes) {
  if (boxes.length === 0) return { x: 0, y: 0, width: 0, height: 0 };
  const x = boxes.reduce((least, box) => Math.min(least, box.x), Infinity),
    y = boxes.reduce((least, box) => Math.min(least, box.y), Infinity);
  const right = boxes.reduce((most, box) => Math.max(most, box.x + box.width), -Infinity),
    top = boxes.reduce((most, box) => Math.max(most, box.y + box.height), -Infinity);
  return { x, y, width: right - x, height: top - y };
}

/**
 * Returns a box of the rows that contain the cells with these numbers.
 * @param {ArrayLike<number>} numbers
 * @param {number} width
 * @returns {Box | null}
 */
function rowsOf(numbers, width) {
  if (numbers.length === 0) return null;
  let least = numbers[0],
    most = least;
  for (let k = 1; k < numbers.length; k += 1) {
    if (numbers[k] < least) least = numbers[k];
    if (numbers[k] > most) most = numbers[k];
  }
  const low = Math.floor(least / width),
    high = Math.floor(most / width);
  return { x: 0, y: low, width, height: high - low + 1 };
}

/**
 * Returns the same world at another size. Cells outside are cut off, new ones are free, and start
 * and target stay inside.
 * @param {EditedWorld} world
 * @param {number} width
 * @param {number} height
 * @param {number[]} [kept] - The part that stays in place, across and up:
 *     0 the left or lower part, 0.5 the middle, 1 the right or upper part
 * @returns {Partial<EditedWorld>}
 */
export function resized(world, width, height, kept = [0, 0]) {
  const right = Math.floor((width - world.width) * kept[0]),
    up = Math.floor((height - world.height) * kept[1]);
  const cells = new Uint8Array(width * height);
  const from = Math.max(0, -right),
    to = Math.min(world.width, width - right);
  for (let iy = Math.max(0, -up); from < to && iy < Math.min(world.height, height - up); iy += 1)
    cells.set(world.cells.subarray(iy * world.width + from, iy * world.width + to), (iy + up) * width + from + right);
  const side = world.cell_size;
  const inside = (value, by, most) => {
    const moved = round(value + by * side);
    return moved >= 0 && moved <= round(most * side) ? moved : round((moved < 0 ? 0.5 : most - 0.5) * side);
  };
  /** @type {(place: Triple) => Triple} */
  const place = ([x, y, rest]) => [inside(x, right, width), inside(y, up, height), rest];
  return {
    width,
    height,
    cells,
    start: place(world.start),
    target: place(world.target),
    events: eventsIn(world, [right, up], width, height),
  };
}

/**
 * @param {EditedWorld} world
 * @param {number[]} by
 * @param {number} width
 * @param {number} height
 * @returns {Events | null}
 */
function eventsIn({ events }, [right, up], width, height) {
  if (!events) return null;
  const is = (at, most) => at >= 0 && at < most;
  const kept = events.ix.map((_, k) => k).filter((k) => is(events.ix[k] + right, width) && is(events.iy[k] + up, height));
  const pick = (column, by = 0) => kept.map((k) => column[k] + by);
  if (kept.length === 0) return null;
  return { times: pick(events.times), ix: pick(events.ix, right), iy: pick(events.iy, up), state: pick(events.state) };
}

/**
 * Returns which of start and target is at a point, in cells; empty if neither is.
 * @param {EditedWorld} world
 * @param {CellPlace | null} point
 * @returns {string}
 */
export function markAt(world, point) {
  if (!point) return "";
  /** @type {(place: Triple, reach: number) => boolean} */
  const near = ([x, y], reach) => Math.hypot(point[0] - x / world.cell_size, point[1] - y / world.cell_size) <= Math.max(0.5, reach / world.cell_size);
  if (near(world.start, world.robot_radius)) return "Start";
  return near(world.target, world.target[2]) ? "Target" : "";
}
