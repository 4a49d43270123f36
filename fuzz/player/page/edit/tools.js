// The tools: how the pointer acts on the board. Each begins, drags and ends at points in cells.

import {
  STAMPS,
  brushBox,
  floodCells,
  lineCells,
  patternIn,
  patternOf,
  rectangleBoxes,
  rectangleOf,
} from "#player/edit/shapes.js";
import { round } from "#player/edit/model.js";

/** Every tool: its name, its key, its icon in a square of 16. */
export const TOOLS = {
  brush: ["Brush", "b", "M10.5 1.5l4 4-7 7-4.5.5.5-4.5zM1 15.5h14v-1.5H1z"],
  erase: ["Eraser", "e", "M6 13l-4-4 7-7 5 5-6 6zm-4 1.5h12v1H2z"],
  line: ["Line", "l", "M2 12.6L12.6 2 14 3.4 3.4 14z"],
  rectangle: ["Rectangle", "r", "M2 3h12v10H2zm1.6 1.6v6.8h8.8V4.6z"],
  fill: [
    "Fill",
    "f",
    "M7 1l7 7-6 6-6-6 5-5-1.5-1.5zm-3.2 7h8L7.5 4zM14 10c1 1.7 1.5 2.5 1.5 3.2a1.5 1.5 0 0 1-3 0c0-.7.5-1.5 1.5-3.2z",
  ],
  select: [
    "Select",
    "s",
    "M1 1h4v1.5H2.5V5H1zm10 0h4v4h-1.5V2.5H11zM1 11h1.5v2.5H5V15H1zm12.5 0H15v4h-4v-1.5h2.5zM6.5 1h3v1.5h-3zm0 12.5h3V15h-3zM1 6.5h1.5v3H1zm12.5 0H15v3h-1.5z",
  ],
  stamp: ["Stamp", "t", "M6 1h4v5l1 2h3v3H2V8h3l1-2zM2 12.5h12V15H2z"],
  start: [
    "Start",
    "a",
    "M8 1.5a6.5 6.5 0 1 0 0 13 6.5 6.5 0 0 0 0-13zm0 1.6a4.9 4.9 0 1 1 0 9.8 4.9 4.9 0 0 1 0-9.8zM7.2 7.2H16v1.6H7.2z",
  ],
  target: [
    "Target",
    "g",
    "M8 1a7 7 0 1 0 0 14A7 7 0 0 0 8 1zm0 1.6a5.4 5.4 0 1 1 0 10.8A5.4 5.4 0 0 1 8 2.6zM8 5a3 3 0 1 0 0 6 3 3 0 0 0 0-6z",
  ],
  measure: ["Measure", "m", "M1 11L11 1l4 4L5 15zm2.3 0L5 12.7 12.7 5l-.8-.8-1.4 1.4-.9-.9L11 3.3z"],
  pan: ["Move view", "h", "M8 0l3 3H9v4h4V5l3 3-3 3V9H9v4h2l-3 3-3-3h2V9H3v2L0 8l3-3v2h4V3H5z"],
};

/**
 * @param {CellPlace} point
 * @returns {CellPlace}
 */
const cellOf = ([x, y]) => [Math.floor(x), Math.floor(y)];
const holds = (box, [x, y]) => box && x >= box.x && y >= box.y && x < box.x + box.width && y < box.y + box.height;

/**
 * Makes the tools of a board.
 * @param {Board} board
 * @param {{size: number, hollow: boolean, stamp: string, stampSize: number}} setting
 * @param {(words: string) => void} said - Called with a description of each action
 * @returns {any}
 */
export function makeTools(board, setting, said) {
  const kit = { board, model: board.model, setting, said, clipboard: null, turns: [] };
  return {
    kit,
    brush: painter(kit, 1),
    erase: painter(kit, 0),
    line: spanned(kit, "line", () => setting.size, (from, to) => thick(lineCells(from, to), setting.size)),
    rectangle: spanned(kit, "rectangle", () => 1, (from, to) => rectangleBoxes(rectangleOf(from, to), setting.hollow)),
    fill: filler(kit),
    select: selector(kit),
    stamp: stamper(kit),
    start: starter(kit),
    target: targeter(kit),
    measure: measurer(kit),
    pan: { begin() {}, drag() {}, end() {} }, // the board itself pans
  };
}

/**
 * Returns the cell nearest to another one that is horizontal, vertical or diagonal from the first.
 * @param {CellPlace} from
 * @param {CellPlace} to
 * @returns {CellPlace}
 */
function straightFrom([x, y], [toX, toY]) {
  const dx = toX - x,
    dy = toY - y,
    far = Math.max(Math.abs(dx), Math.abs(dy));
  if (2 * Math.abs(dy) < Math.abs(dx)) return [toX, y];
  if (2 * Math.abs(dx) < Math.abs(dy)) return [x, toY];
  return [x + Math.sign(dx) * far, y + Math.sign(dy) * far];
}

// Returns each cell of a line as a box of the brush's width.
function thick(cells, size) {
  return cells.map((cell) => brushBox(cell, size));
}

/**
 * @param {any} kit
 * @param {number} value
 * @returns {Tool}
 */
function painter(kit, value) {
  /** @type {CellPlace | null} */
  let last = null;
  /** @type {CellPlace} */
  let first = [0, 0];
  /** @type {(point: CellPlace, use: ToolUse) => void} */
  const paint = (point, { erase, straight }) => {
    if (!last) first = cellOf(point);
    const here = straight ? straightFrom(first, cellOf(point)) : cellOf(point);
    kit.model.paint(thick(lineCells(last || here, here), kit.setting.size), erase ? 1 - value : value);
    last = here;
  };
  return {
    begin: paint,
    drag: paint,
    end() {
      last = null;
      kit.model.lift(value ? "brush" : "eraser");
    },
    hover: (point) => {
      kit.board.marks = [brushBox(cellOf(point), kit.setting.size)];
    },
  };
}

/**
 * @param {any} kit
 * @param {string} label
 * @param {() => number} width Of what is drawn, cells.
 * @param {(from: CellPlace, to: CellPlace) => Box[]} cellsOf
 * @returns {Tool}
 */
function spanned(kit, label, width, cellsOf) {
  /** @type {CellPlace} */
  let from = [0, 0];
  /** @type {CellPlace} */
  let to = from;
  const show = () => {
    kit.board.marks = cellsOf(from, to);
    kit.board.draw();
  };
  return {
    begin(point) {
      from = to = cellOf(point);
      show();
    },
    drag(point, { straight }) {
      to = straight ? straightFrom(from, cellOf(point)) : cellOf(point);
      show();
    },
    end({ erase }) {
      kit.board.marks = [];
      kit.model.paint(cellsOf(from, to), erase ? 0 : 1);
      kit.model.lift(label);
    },
    hover: (point) => {
      kit.board.marks = [brushBox(cellOf(point), width())];
    },
  };
}

/**
 * @param {any} kit
 * @returns {Tool}
 */
function filler(kit) {
  return {
    begin(point, { erase }) {
      const { world } = kit.model,
        [x, y] = cellOf(point);
      if (x < 0 || y < 0 || x >= world.width || y >= world.height) return;
      const solid = world.cells[y * world.width + x];
      if (erase && !solid) return;
      kit.model.paintCells(floodCells(world, [x, y]), erase ? 0 : 1);
      kit.model.lift("fill");
    },
    drag() {},
    end() {},
    hover: (point) => {
      kit.board.marks = [brushBox(cellOf(point), 1)];
    },
  };
}

/**
 * @param {any} kit
 * @returns {Tool}
 */
function selector(kit) {
  const { board, model } = kit;
  /** @type {CellPlace} */
  let from = [0, 0];
  /** @type {{box: Box, pattern: Pattern} | null} */
  let moving = null;
  return {
    begin(point) {
      from = cellOf(point);
      moving = holds(board.selection, from)
        ? { box: board.selection, pattern: patternIn(model.world, board.selection) }
        : null;
      if (!moving) board.selection = rectangleOf(from, from);
      board.draw();
    },
    drag(point) {
      const to = cellOf(point);
      if (!moving) board.selection = rectangleOf(from, to);
      else {
        const at = [moving.box.x + to[0] - from[0], moving.box.y + to[1] - from[1]];
        board.ghost = { pattern: moving.pattern, at };
      }
      board.draw();
    },
    end() {
      if (!moving || !board.ghost) return;
      const { at } = board.ghost;
      board.ghost = null;
      model.paint([moving.box], 0);
      model.put(moving.pattern, at);
      model.lift("move");
      board.selection = { ...moving.box, x: at[0], y: at[1] };
      board.draw();
    },
  };
}

/** Returns the pattern that the stamp puts down, made again only if it has changed. */
function stampOf(kit) {
  const { stamp, stampSize } = kit.setting,
    made = kit.stamped;
  const wanted = [stamp, stampSize, kit.clipboard, kit.turns, kit.turns.length];
  if (!made || wanted.some((value, k) => value !== made.wanted[k]))
    kit.stamped = { wanted, pattern: freshStamp(kit, stamp, stampSize) };
  return kit.stamped.pattern;
}

function freshStamp(kit, stamp, stampSize) {
  const made =
    stamp === "clipboard" && kit.clipboard ? kit.clipboard : STAMPS[stamp in STAMPS ? stamp : "U trap"](stampSize);
  return kit.turns.reduce((pattern, change) => change(pattern), made);
}

/**
 * @param {any} kit
 * @returns {Tool}
 */
function stamper(kit) {
  const place = (point) => {
    const pattern = stampOf(kit);
    const at = [Math.round(point[0] - pattern.width / 2), Math.round(point[1] - pattern.height / 2)];
    kit.board.ghost = { pattern, at };
    kit.board.draw();
    return { pattern, at };
  };
  return {
    begin(point, { erase }) {
      const { pattern, at } = place(point);
      if (erase)
        kit.model.put(
          patternOf(pattern.width, pattern.height, (ix, iy) => (pattern.cells[iy * pattern.width + ix] === 1 ? 0 : 2)),
          at,
        );
      else kit.model.put(pattern, at);
      kit.model.lift("stamp");
    },
    drag: place,
    end() {},
    hover: place,
  };
}

/**
 * Moves the start to the middle of a cell, or with Alt to the exact place; dragging away from it
 * turns it.
 * @param {any} kit
 * @returns {Tool}
 */
function starter(kit) {
  /** @type {CellPlace} */
  let at = [0, 0];
  return {
    begin(point, { exact }) {
      at = placed(kit, point, exact);
      kit.model.change("start", { start: [...at, kit.model.world.start[2]] });
    },
    drag(point) {
      const side = kit.model.world.cell_size;
      const dx = point[0] * side - at[0],
        dy = point[1] * side - at[1];
      if (Math.hypot(dx, dy) < 0.6 * side) return;
      const heading = Math.atan2(dy, dx),
        // steps of five degrees are easy to hit
        steps = Math.round((heading * 180) / Math.PI / 5) * 5;
      kit.model.change("start heading", { start: [...at, round((steps * Math.PI) / 180)] }, true);
    },
    end() {},
  };
}

/**
 * Moves the target; one drag is one step of the history.
 * @param {any} kit
 * @returns {Tool}
 */
function targeter(kit) {
  const move = (together) => (point, { exact }) =>
    kit.model.change("target", { target: [...placed(kit, point, exact), kit.model.world.target[2]] }, together);
  const begin = move(false),
    drag = move(true);
  return {
    begin(point, how) {
      begin(point, how);
      kit.model.past.at(-1).together = "target";
    },
    drag,
    end() {},
  };
}

/**
 * @param {any} kit
 * @param {CellPlace} point
 * @param {boolean} exact
 * @returns {CellPlace}
 */
function placed(kit, [x, y], exact) {
  const { width, height, cell_size: side } = kit.model.world;
  const inside = (value, most) => Math.min(most, Math.max(0, value));
  if (exact) return [round(inside(x, width) * side), round(inside(y, height) * side)];
  return [
    round((inside(Math.floor(x), width - 1) + 0.5) * side),
    round((inside(Math.floor(y), height - 1) + 0.5) * side),
  ];
}

/**
 * @param {any} kit
 * @returns {Tool}
 */
function measurer(kit) {
  return {
    begin(point) {
      kit.board.measure = [point, point];
      kit.board.draw();
    },
    drag(point) {
      kit.board.measure = [kit.board.measure[0], point];
      kit.board.draw();
    },
    end() {
      const [from, to] = kit.board.measure;
      kit.said(`${(Math.hypot(to[0] - from[0], to[1] - from[1]) * kit.model.world.cell_size).toFixed(3)} m`);
    },
  };
}
