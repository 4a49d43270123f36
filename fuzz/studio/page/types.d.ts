// Types of the studio's messages, as fuzz/studio/protocol.md has them, and of what its scripts share.
// Only `npm run check` reads this file.

/** What the server refuses: fuzz/studio/refusals.py. */
interface Refusal {
  code: string;
  problem: string;
  remedy: string;
  terminal: boolean;
  /** The part of the page that has the way out, such as "import". */
  opens: string;
  facts: Record<string, any>;
  line: number | null;
  source: string | null;
}

/** The first message of a connection: fuzz/studio/app.py. */
interface Begins {
  protocol: number;
  /** That the server has open. */
  folder: string;
  /** The world to open first. */
  file: string | null;
  limits: Limits;
}

/** How much the server takes: fuzz/studio/limits.py. Pairs are the least and the largest value. */
interface Limits {
  /** Bytes of a message. */
  message: number;
  /** Bytes of files that are dropped together. */
  dropped: number;
  /** Cells a side. */
  side: number;
  cells: number;
  /** m. */
  lengths: [number, number];
  robots: number;
  steps: number;
  /** s. */
  time_steps: [number, number];
  seconds: number;
  units: number;
  workers: number;
  examples: number;
  epoch: number;
}

/** What there is to choose from, the answer to `hello`: fuzz/studio/catalogue.py. */
interface Offered {
  families: { name: string; about: string; changes: boolean; parameters: Parameter[] }[];
  controllers: OfferedController[];
  motions: Motion[];
  formats: Format[];
  time_step: number;
  lanes: string[];
  oracles: string[];
  cores: number;
  /** Name of the folder of known failures. */
  known: string;
  /** What the command line says of each option of `worldgen fuzz`. */
  options: Record<string, { help: string; default: string }>;
}

interface OfferedController {
  name: string;
  thesis: boolean;
  lattice: boolean;
  motion: string;
  /** Another registered name of the same controller. */
  also: string;
  named: boolean;
  fault: Refusal | null;
}

interface Motion {
  name: string;
  about: string;
  thesis: boolean;
  options: Parameter[];
}

interface Format {
  name: string;
  about: string;
  suffixes: string[];
  reads: boolean;
  writes: boolean;
  changes: boolean;
  options: Parameter[];
  read_options: Parameter[];
}

/** A parameter of a family or format, or an option of a motion model, as the server declares it. */
interface Parameter {
  name: string;
  default: any;
  /** Name of its Python type: "bool", "int", "float" or "str". */
  kind: string;
  choices: string[];
  low: number | null;
  high: number | null;
  help: string;
  /** Whether `low` itself is too little. */
  above?: boolean;
  /** A number that is allowed in addition, or null. */
  chosen?: number | null;
  /** The bounds in words. */
  bounds?: string;
  unit?: string;
  group?: string;
}

/** Changes of cells, in columns. */
interface Events {
  times: number[];
  ix: number[];
  iy: number[];
  state: number[];
}

/** A world without its proof: fuzz/studio/messages.py. */
interface WorldMessage {
  width: number;
  height: number;
  cells: Bits;
  /** m, as all lengths here. */
  cell_size: number;
  robot_radius: number;
  robot_speed: number;
  start: Triple;
  target: Triple;
  events: Events | null;
  /** Text of the file that it was opened from. */
  source: string | null;
}

/** A world that is being drawn. */
interface EditedWorld extends Omit<WorldMessage, "cells"> {
  cells: Uint8Array;
  /** Of its file in the folder; empty without one. */
  name: string;
  /** The digest of that file as it was opened or saved. */
  file: string | null;
  /** The same for all that one drawing has been. */
  sheet: symbol;
}

/** A rectangle of cells: 0 free, 1 solid, 2 as it was. */
interface Pattern {
  width: number;
  height: number;
  cells: Uint8Array;
  /** Its picture, and the colours that this has. */
  picture?: OffscreenCanvas;
  pictured?: string;
}

/** One step of the history: runs of cells that are inverted, or the worlds before and after. */
interface HistoryEntry {
  label: string;
  runs?: Int32Array;
  before?: EditedWorld;
  after?: EditedWorld;
  together?: string | null;
}

/** A failure that a file holds. */
interface FailureMessage {
  controller: string;
  motion: string;
  seed: number;
  verdict: string;
  digest: string;
  parameters: Record<string, any>;
}

/** The answer to `open`, `generate`, `bring` and the like. */
interface OpenedMessage {
  world: WorldMessage;
  made?: string | null;
  failure?: FailureMessage | null;
  file?: string | null;
}

/** The answer to `decide`, or what stands for it. */
interface Proof {
  result?: "reachable" | "blocked" | "undecided";
  /** Of the path, m; this and the next two only if the target is reachable. */
  length: number;
  duration: number;
  clearance: number;
  /** How many cells the cut has. */
  ring?: number | null;
  reason?: string;
  witness?: DrawnWorld["witness"];
  cut?: CellPlace[];
  error?: string;
  /** The witness, unpacked. */
  opened?: OpenWorld["witness"];
}

/** A campaign in numbers: fuzz/studio/campaign_state.py. */
interface CampaignState {
  folder: string;
  running: boolean;
  controller: string;
  motion: string;
  seed: string;
  budget: { units: number | null; seconds: number | null };
  status: string;
  units: number;
  worlds: number;
  steps: number;
  seconds: number;
  /** For how long its process runs, s. */
  elapsed: number | null;
  /** Another text whenever a failure is new or smaller. */
  failures: string;
  verdicts: Record<string, number>;
  met: Record<string, number>;
  known: Record<string, number>;
  lanes: { lane: string; units: number; worlds: number; steps: number; failures: number; classes: number }[];
  archive: Archive | null;
  error: Refusal | null;
}

/** A failure of a folder, as the wall lists it. */
interface WallFailure {
  name: string;
  class: string;
  verdict: string;
  controller: string;
  motion: string;
  width: number;
  height: number;
  solid: number;
  events: number;
  seen: number;
  digest: string;
  known: boolean;
}

/** A question on its way, which can be taken back. */
interface Asked extends Promise<any> {
  stop(): void;
}

interface Connection {
  /** Asks the server; `part` is called with each part of the answer. */
  ask(kind: string, message?: object, part?: (part: any) => void): Asked;
}

/** What all pages of the studio share. */
interface Studio {
  model: import("./model.js").Model;
  connection: Connection;
  folder: string;
  /** Null until the server has told them. */
  limits: Limits | null;
  offered: Offered | null;
  /** The largest radius that passes, m. */
  widest: number | symbol | null;
  askWidest(): void;
  say(words: string): void;
  page(): string;
  go(page: string): void;
  show(answer: OpenedMessage, name: string, label: string): void;
  showName(): void;
  undo(): void;
  redo(): void;
  save(): Promise<void>;
  run(): void;
  /** The pages, once they are made. */
  draw: any;
  play: any;
  campaign: any;
}

/** What is drawn on the board besides the world. */
interface Board {
  canvas: HTMLCanvasElement;
  model: import("./model.js").Model;
  show: Record<string, boolean>;
  view: View | null;
  proof: Proof | null;
  signal: { values: Float64Array; most: number; picture?: OffscreenCanvas | null } | null;
  /** What would be put down. */
  ghost: { pattern: Pattern; at: CellPlace } | null;
  /** Boxes of cells that would be changed. */
  marks: Box[];
  selection: Box | null;
  measure: [CellPlace, CellPlace] | null;
  /** The cell that keys draw at. */
  cursor: CellPlace | null;
  draw(): void;
  now(): View;
  pointAt(event: { clientX: number; clientY: number }): CellPlace;
  zoom(factor: number, event?: { clientX: number; clientY: number } | null): void;
  pan(dx: number, dy: number): void;
  reveal(cell: CellPlace): void;
  fit(): void;
}

/** How a tool is used: whether it takes away, and whether exactly where the pointer is. */
interface ToolUse {
  erase: boolean;
  exact: boolean;
}

interface Tool {
  begin(point: CellPlace, use: ToolUse): void;
  drag(point: CellPlace, use: ToolUse): void;
  end(use: ToolUse): void;
  hover?(point: CellPlace): void;
}
