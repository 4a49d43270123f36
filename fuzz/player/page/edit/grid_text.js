// Reads and writes worlds as `.grid` files, byte for byte as worldgen/files/grid/writer.py does.

import { hasMoreInFile } from "#player/edit/model.js";

const USUAL_SPEED = 2.0; // m/s: worldgen.robot.DEFAULT_ROBOT_SPEED, which version 1 leaves out
const STATES = ["free", "solid", "burning"];

/**
 * Returns a world for editing.
 * @param {LiveWorld} world - Its numbers
 * @param {string} source - The canonical text of its file, which has everything else
 * @param {string} name - Of the file
 * @returns {EditedWorld}
 */
export function editedOf(world, source, name) {
  const width = world.cells[0].length,
    height = world.cells.length,
    cells = new Uint8Array(width * height);
  world.cells.forEach((row, k) => {
    for (let ix = 0; ix < width; ix += 1) cells[(height - 1 - k) * width + ix] = row[ix] === "#" ? 1 : 0;
  });
  return {
    width,
    height,
    cells,
    cell_size: world.cell_size,
    robot_radius: world.radius,
    robot_speed: world.speed,
    start: world.start,
    target: world.target,
    events: eventsIn(source),
    others: [],
    source,
    name,
    file: null,
    sheet: Symbol("sheet"),
  };
}

// Returns the changes of cells in the text of a file.
function eventsIn(source) {
  const rows = sectionOf(source, "timeline").map((line) => line.split(" "));
  if (rows.length === 0) return null;
  const column = (k) => rows.map((row) => Number(row[k]));
  return { times: column(0), ix: column(1), iy: column(2), state: rows.map((row) => STATES.indexOf(row[3])) };
}

function sectionOf(source, name) {
  const begin = source.indexOf(`\n%${name}\n`);
  if (begin < 0) return [];
  const from = begin + name.length + 3;
  return source.slice(from, source.indexOf("\n%", from)).split("\n");
}

/**
 * Returns the cells of a world as its file has them, the top row first.
 * @param {{width: number, height: number, cells: Uint8Array}} world
 * @returns {string[]}
 */
export function rowsOf({ width, height, cells }) {
  const row = (iy) => Array.from(cells.slice(iy * width, (iy + 1) * width), (cell) => (cell ? "#" : ".")).join("");
  return Array.from({ length: height }, (_, k) => row(height - 1 - k));
}

/**
 * Returns the text of a world's file. What pages do not edit comes from the file as it was opened,
 * except for the provenance: a family did not make what was edited.
 * @param {EditedWorld} world
 * @param {Pick<LiveProof, "witness" | "cut"> | null} proof
 * @param {LiveRun | null} run - The run of the controller that the opened file names, if the file
 *   should record it
 * @returns {string}
 */
export function gridText(world, proof, run) {
  const tables = tablesOf(world.source ?? ""),
    several = hasMoreInFile(world);
  const lines = [`%worldgen-grid ${several ? 2 : 1}`, `cell_size = ${numberText(world.cell_size)}`];
  if (several) lines.push(...tables.robots.flatMap((table, k) => ["", "[[robot]]", ...(k === 0 ? robotLines(table, world) : table)]));
  else {
    lines.push(`robot_radius = ${numberText(world.robot_radius)}`);
    if (world.robot_speed !== USUAL_SPEED) lines.push(`robot_speed = ${numberText(world.robot_speed)}`);
    lines.push(`start = ${listText(world.start)}`, `target = ${listText(world.target)}`);
  }
  const { witness, cut } = proof ?? { witness: null, cut: null };
  const shown = witness ?? cut;
  const separates = cut?.waypoint ? [`waypoint = ${cut.waypoint}`] : [];
  if (shown) lines.push("", "[certificate]", `kind = "${witness ? "witness" : "cut"}"`, ...separates, `clearance = ${numberText(shown.clearance)}`);
  // Without the record of a failure, nothing says which controller ran.
  if (run && tables.failure.length > 0) lines.push("", "[failure]", ...failureLines(tables.failure, run));
  lines.push("%cells", ...rowsOf(world));
  if (world.events) lines.push("%timeline", ...eventLines(world.events));
  if (witness) lines.push("%witness", ...pointLines(witness, several ? "1 " : ""));
  else if (cut) lines.push("%cut", ...(cut.boxes ?? cut.cells).map((row) => row.join(" ")));
  return [...lines, "%end", ""].join("\n");
}

// Returns the lines of each robot's table, and those of the failure's.
function tablesOf(source) {
  const found = { robots: /** @type {string[][]} */ ([]), failure: /** @type {string[]} */ ([]) };
  let table = /** @type {string[]} */ ([]);
  for (const line of source.slice(0, source.indexOf("\n%cells\n")).split("\n")) {
    if (line.startsWith("[")) table = [];
    if (line === "[[robot]]") found.robots.push(table);
    else if (line === "[failure]") found.failure = table;
    else if (line) table.push(line);
  }
  return found;
}

function robotLines(table, { start, target, robot_radius }) {
  const edited = { start: listText(start), target: listText(target), radius: numberText(robot_radius) };
  return table.map((line) => {
    const [key] = line.split(" = ");
    return key in edited ? `${key} = ${edited[key]}` : line;
  });
}

function failureLines(table, { verdict, digest, budget, evidence }) {
  const keeps = (name) => table.filter((line) => line.startsWith(`${name} = `));
  const parameters = keeps("parameters").map((line) => line.replace(/([{ ]steps = )\d+/, `$1${budget}`));
  return [
    ...["controller", "motion", "seed"].flatMap(keeps),
    `verdict = ${valueText(verdict)}`,
    `trace_digest = ${valueText(digest)}`,
    ...parameters,
    `evidence = ${valueText(evidence)}`,
  ];
}

function eventLines({ times, ix, iy, state }) {
  return times.map((time, k) => `${numberText(time)} ${ix[k]} ${iy[k]} ${STATES[state[k]]}`);
}

/** @param {NonNullable<LiveProof["witness"]>} path @param {string} prefix */
function pointLines({ t, x, y, heading }, prefix) {
  const columns = [t, x, y, ...(heading ? [heading] : [])];
  return t.map((_, k) => prefix + columns.map((column) => numberText(column[k])).join(" "));
}

const listText = (values) => `[${values.map(numberText).join(", ")}]`;

/**
 * Returns the shortest decimal that reads back as the same number, spelled as Python does.
 * @param {number} value
 * @returns {string}
 */
function numberText(value) {
  const number = value + 0; // minus zero becomes zero
  const [digits, exponent] = number.toExponential().split("e");
  const power = Number(exponent);
  if (power < -4 || power > 15) return `${digits}e${power < 0 ? "-" : "+"}${String(Math.abs(power)).padStart(2, "0")}`;
  return Number.isInteger(number) ? `${number}.0` : String(number);
}

/**
 * Returns a value of evidence on one line. A whole number is an integer there: a number that is not
 * is never whole by chance.
 * @param {any} value
 * @returns {string}
 */
function valueText(value) {
  if (typeof value === "number") return Number.isInteger(value) ? String(value) : numberText(value);
  if (typeof value === "string") return JSON.stringify(value);
  if (Array.isArray(value)) return `[${value.map(valueText).join(", ")}]`;
  if (typeof value !== "object") return String(value);
  const parts = Object.keys(value)
    .sort()
    .map((key) => `${key} = ${valueText(value[key])}`);
  return `{ ${parts.join(", ")} }`;
}
