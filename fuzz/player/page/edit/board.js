// The drawing board: a canvas that shows the world, the current edit, the world's proof, and a run.

import { openRun, openWitness } from "#player/decode.js";
import { pixelOf } from "#player/picture/many_cells.js";
import { drawScene } from "#player/picture/map.js";
import { MARKS } from "#player/picture/marks.js";
import { bodyPath, disc, fitView, line, penFor, robotColour, stroke } from "#player/picture/pen.js";
import { drawnOf, headingTip, kindOf, othersOf } from "#player/edit/drawn_world.js";
import { pictureOf } from "#player/edit/pattern_picture.js";

const HANDLE = 4; // pixels: radius of the handle of the heading
const NEAREST = 200; // pixels per cell at the highest zoom
const MARGIN = { across: 54, up: 34 }; // pixels around the whole world, for the rulers

/**
 * Makes a board.
 * @param {HTMLCanvasElement} canvas
 * @param {import("#player/edit/model.js").Model} model
 * @param {Record<string, boolean>} show - Visibility of grid, ruler, proof and signal
 * @returns {Board}
 */
export function makeBoard(canvas, model, show) {
  /** @type {Omit<Board, "now" | "pointAt" | "zoom" | "pan" | "reveal" | "fit" | "toRun">} */
  const own = {
    canvas,
    model,
    show,
    view: null, // null: the whole world
    proof: null, // for this version of the world
    run: null, // parts of the scene that show a run in it
    signal: null, // the robot's reading in each cell
    time: 0, // s: the moment to show of a world that changes
    ghost: null, // { pattern, at }: a preview of what would be put down
    marks: [], // boxes of cells that would change
    selection: null, // a rectangle of cells
    measure: null, // two points, in cells
    cursor: null, // the cell at which keys draw
    draw: () => drawBoard(board),
  };
  const board = /** @type {Board} */ (own);
  return Object.assign(board, cameraOf(board));
}

function cameraOf(board) {
  const { canvas, model, show } = board;
  const whole = () => {
    const { width, height } = model.world;
    if (!("ruler" in show)) return fitView(model.world, canvas.clientWidth, canvas.clientHeight);
    const scale = Math.min((canvas.clientWidth - 2 * MARGIN.across) / width, (canvas.clientHeight - 2 * MARGIN.up) / height);
    return { x: width / 2, y: height / 2, scale: Math.max(scale, 0.05) };
  };
  const now = () => board.view || whole();
  return {
    now,
    /**
     * Returns the point of the world at a place in the window, in cells.
     * @returns {CellPlace}
     */
    pointAt({ clientX, clientY }) {
      const box = canvas.getBoundingClientRect(),
        { x, y, scale } = now();
      return [
        x + (clientX - box.left - canvas.clientWidth / 2) / scale,
        y - (clientY - box.top - canvas.clientHeight / 2) / scale,
      ];
    },
    /** Zooms; the point under the pointer stays in its place. */
    zoom(factor, event = null) {
      const before = now(),
        scale = Math.min(NEAREST, Math.max(whole().scale / 2, before.scale * factor));
      const [x, y] = event ? board.pointAt(event) : [before.x, before.y];
      const share = before.scale / scale;
      board.view = { x: x + (before.x - x) * share, y: y + (before.y - y) * share, scale };
      board.draw();
    },
    pan(dx, dy) {
      const { x, y, scale } = now();
      board.view = { x: x - dx / scale, y: y + dy / scale, scale };
      board.draw();
    },
    /** Moves the view by as little as possible to show a cell with some space around it. */
    reveal([ix, iy]) {
      if (!board.view) return;
      const { x, y, scale } = board.view;
      const moved = (middle, at, pixels) => {
        const half = Math.max(0.5, pixels / 2 / scale - 1);
        return Math.min(at + half, Math.max(at + 1 - half, middle));
      };
      const wide = canvas.clientWidth - 2 * MARGIN.across,
        high = canvas.clientHeight - 2 * MARGIN.up;
      board.view = { x: moved(x, ix, wide), y: moved(y, iy, high), scale };
    },
    fit() {
      board.view = null;
      board.draw();
    },
    /** Zooms to the run, with the space that the robot covers. */
    toRun() {
      if (!board.run) return;
      const { x, y } = openRun(board.run.run);
      const [[left, right], [low, high]] = [x, y].map((column) => column.reduce(([least, most], at) => [Math.min(least, at), Math.max(most, at)], [Infinity, -Infinity]));
      const around = (4 * model.world.robot_radius) / model.world.cell_size,
        wide = canvas.clientWidth - 2 * MARGIN.across,
        tall = canvas.clientHeight - 2 * MARGIN.up;
      const scale = Math.min(NEAREST, wide / (right - left + around), tall / (high - low + around));
      board.view = { x: (left + right) / 2, y: (low + high) / 2, scale: Math.max(whole().scale / 2, scale) };
      board.draw();
    },
  };
}

/** @type {{model: object | null, version: number, open: OpenWorld | null}} */
const changing = { model: null, version: -1, open: null }; // the last unpacked world that changes

// Returns the unpacked world of a drawing with changes; the same object until the drawing is
// edited.
function openChanging(model) {
  if (changing.model !== model || changing.version !== model.version)
    Object.assign(changing, { model, version: model.version, open: drawnOf(model.world).open });
  return /** @type {OpenWorld} */ (changing.open);
}

/**
 * Returns a world as the player draws it, without copying its cells.
 * @param {import("#player/edit/model.js").Model} model
 * @param {Proof | null} proof
 * @returns {SceneWorld}
 */
function sceneWorld(model, proof) {
  const { world, version } = model;
  if (proof) {
    proof.opened ??= openWitness(proof.witness);
    proof.openedOthers ??= (proof.others ?? []).map((one) => openWitness(one.witness) ?? null);
  }
  const witness = proof?.opened;
  const others = proof?.openedOthers ?? [];
  const side = world.cell_size;
  const [startX, startY, heading] = world.start;
  const [targetX, targetY, radius] = world.target;
  return {
    width: world.width,
    height: world.height,
    radius: world.robot_radius / side,
    start: [startX / side, startY / side, heading],
    target: [targetX / side, targetY / side, radius / side],
    ...kindOf(world),
    others: othersOf(world),
    witness: proof && proof.witness,
    cut: proof && proof.cut,
    cut_poses: proof && proof.cut_poses,
    open: world.events
      ? Object.assign(openChanging(model), { witness, others })
      : { cells: world.cells, events: null, done: version, boxSince: (then) => model.boxSince(then), witness, others },
  };
}

/** @param {Board} board */
function drawBoard(board) {
  const { canvas, model, show } = board;
  const world = sceneWorld(model, show.proof ? board.proof : null),
    view = board.now();
  const run = show.run === false ? null : board.run;
  const shown = { witness: show.proof, grid: show.grid, changes: true, ...run?.show };
  drawScene(canvas, { world, ms: board.time * 1000, ...run, show: shown }, view);
  // Everything else is drawn on top of the scene, from the lowest layer to the highest.
  const pen = penFor(canvas, view, world);
  if (pen.width === 0) return;
  if (show.signal && board.signal) drawSignal(pen, board);
  drawFootprint(pen, world, headingTip(model.world));
  // The floor that a body covers depends on its headings.
  if (show.proof && board.proof?.result === "reachable" && !world.footprint) drawTube(pen, board);
  drawMarks(pen, board);
  if (board.ghost) drawGhost(pen, board.ghost);
  if (board.selection) drawSelection(pen, board.selection);
  if (board.measure) drawMeasure(pen, board.measure, model);
  if (board.cursor) frame(pen, { x: board.cursor[0], y: board.cursor[1], width: 1, height: 1 }, pen.colours.focus, []);
  if (show.ruler) drawRulers(pen, board);
}

// Draws the robot's body at the start, and its heading as a line with a handle.
function drawFootprint(pen, world, [tipX, tipY]) {
  const [x, y, heading] = world.start;
  const colour = pen.colours[world.others.length > 0 ? robotColour(1) : "start"];
  bodyPath(pen, world.footprint, { x, y, heading }, world.radius);
  stroke(pen, colour, 1.5);
  const { context, px, py } = pen;
  context.beginPath();
  context.moveTo(px(x), py(y));
  context.lineTo(px(tipX), py(tipY));
  stroke(pen, colour, 2.5);
  disc(pen, tipX, tipY, HANDLE / pen.scale, colour);
}

// Draws the signal in colours, stronger where it is stronger,
// from a picture with one pixel per cell.
function drawSignal(pen, { signal, model }) {
  const { width, height } = model.world;
  if (signal.values.length !== width * height) return;
  if (!signal.picture) {
    signal.picture = new OffscreenCanvas(width, height);
    const context = signal.picture.getContext("2d"),
      image = context.createImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer),
      colour = pixelOf(pen.colours[MARKS.signal.colour], 0),
      most = Math.log1p(signal.most);
    for (let k = 0; k < signal.values.length; k += 1) {
      if (signal.values[k] < 0) continue;
      const strength = 1 - Math.log1p(signal.values[k]) / most;
      const row = height - 1 - Math.floor(k / width);
      pixels[row * width + (k % width)] = ((Math.round(20 + 180 * strength) << 24) | colour) >>> 0;
    }
    context.putImageData(image, 0, 0);
  }
  const { context, px, py, scale } = pen;
  context.imageSmoothingEnabled = false;
  context.drawImage(signal.picture, px(0), py(height), width * scale, height * scale);
}

// Draws the area that the robot's disc sweeps on the path of the proof.
function drawTube(pen, board) {
  const { x, y } = board.proof.opened || { x: [], y: [] };
  const { context } = pen;
  context.save();
  context.globalAlpha = 0.13;
  line(pen, x, y, 0, x.length);
  stroke(
    pen,
    pen.colours.start,
    Math.max(2, (2 * board.model.world.robot_radius * pen.scale) / board.model.world.cell_size),
  );
  context.restore();
}

function drawMarks(pen, { marks }) {
  const { context, px, py, colours } = pen;
  context.save();
  context.globalAlpha = 0.45;
  context.fillStyle = colours.focus;
  context.beginPath(); // a single path, so that overlapping boxes do not become darker
  for (const { x, y, width, height } of marks)
    context.rect(px(x), py(y + height), width * pen.scale, height * pen.scale);
  context.fill();
  context.restore();
}

function drawGhost(pen, { pattern, at }) {
  const { context, px, py, colours } = pen,
    { width, height } = pattern;
  context.save();
  context.globalAlpha = 0.6;
  context.imageSmoothingEnabled = false;
  context.drawImage(
    pictureOf(pattern, colours),
    px(at[0]),
    py(at[1] + height),
    width * pen.scale,
    height * pen.scale,
  );
  context.restore();
  frame(pen, { x: at[0], y: at[1], width: pattern.width, height: pattern.height }, colours.focus, [3, 3]);
}

function frame(pen, { x, y, width, height }, colour, dash) {
  const { context, px, py } = pen;
  context.save();
  context.strokeStyle = colour;
  context.lineWidth = 2;
  context.setLineDash(dash);
  context.strokeRect(px(x), py(y + height), width * pen.scale, height * pen.scale);
  context.restore();
}

function drawSelection(pen, selection) {
  frame(pen, selection, pen.colours.paper, []);
  frame(pen, selection, pen.colours.focus, [6, 4]);
}

function drawMeasure(pen, [from, to], model) {
  const { context, px, py, colours } = pen;
  context.beginPath();
  context.moveTo(px(from[0]), py(from[1]));
  context.lineTo(px(to[0]), py(to[1]));
  stroke(pen, colours.breach, 2);
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]) * model.world.cell_size;
  label(pen, `${length.toFixed(3)} m`, px(to[0]) + 10, py(to[1]) - 12);
}

function label(pen, text, x, y) {
  const { context, colours } = pen;
  context.font = "600 13px system-ui, sans-serif";
  const wide = context.measureText(text).width;
  context.fillStyle = colours.paper;
  context.fillRect(x - 4, y - 14, wide + 8, 20);
  context.fillStyle = colours.ink;
  context.fillText(text, x, y);
}

// Draws rulers in metres along the upper and left edge of the window.
function drawRulers(pen, { model }) {
  const { context, colours, width, height } = pen,
    { world } = model;
  const metres = niceMetres((70 / pen.scale) * world.cell_size);
  context.save();
  context.fillStyle = colours.paper;
  context.globalAlpha = 0.88;
  context.fillRect(0, 0, width, 20);
  context.fillRect(0, 20, 40, height - 20);
  context.globalAlpha = 1;
  context.font = "11px system-ui, sans-serif";
  context.fillStyle = context.strokeStyle = colours.quiet;
  context.lineWidth = 1;
  context.beginPath();
  for (const [k, [at, words]] of ticks(world.width * world.cell_size, metres).entries()) {
    const x = Math.round(pen.px(at / world.cell_size)) + 0.5;
    if (x < 40) continue;
    context.moveTo(x, 14);
    context.lineTo(x, 20);
    context.fillText(k === 0 ? `${words} m` : words, x + 3, 12);
  }
  for (const [at, words] of ticks(world.height * world.cell_size, metres)) {
    const y = Math.round(pen.py(at / world.cell_size)) + 0.5;
    if (y < 24) continue;
    context.moveTo(34, y);
    context.lineTo(40, y);
    context.fillText(words, 4, y + 4);
  }
  context.stroke();
  context.restore();
}

/**
 * @param {number} length
 * @param {number} metres
 * @returns {[number, string][]}
 */
function ticks(length, metres) {
  const digits = Math.max(0, -Math.floor(Math.log10(metres) + 1e-9));
  const count = Math.floor(length / metres + 1e-9) + 1;
  return Array.from({ length: count }, (_, k) => [k * metres, (k * metres).toFixed(digits)]);
}

/**
 * Returns the smallest value of 1, 2 or 5 times a power of ten that is not below a limit.
 * @param {number} least
 * @returns {number}
 */
function niceMetres(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((factor) => factor * power).find((value) => value >= least * 0.999) ?? 10 * power;
}
