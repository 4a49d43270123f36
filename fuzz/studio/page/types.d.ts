// Types of the studio's messages (fuzz/studio/protocol.md) and of objects that its scripts share.
// Only `npm run check` reads this file.

/** A refusal of the server: fuzz/studio/requests/refusals.py. */
interface Refusal {
  code: string;
  /** Where the user's code has failed, the innermost last;
   * empty if the error is about something else. */
  frames: Frame[];
  problem: string;
  remedy: string;
  terminal: boolean;
  /** The part of the page with the remedy, such as "import". */
  opens: string;
  facts: Record<string, any>;
  line: number | null;
  source: string | null;
}

/** What the server writes into the page: fuzz/studio/app.py. */
interface Given {
  /** The version of this page. */
  protocol: number;
  subprotocol: string;
  /** WebSocket code for too many connections; the reason is a sentence. */
  full: number;
  world: UsualWorld;
}

/** Cells and robot of a new world: m, m, m/s. */
interface UsualWorld {
  cell_size: number;
  robot_radius: number;
  robot_speed: number;
}

/** The first message of a connection: fuzz/studio/app.py. */
interface Begins {
  protocol: number;
  /** The server's opened folder. */
  folder: string;
  /** The world to open first. */
  file: string | null;
  limits: Limits;
}

/** The server's limits: fuzz/studio/requests/limits.py. Pairs are the smallest and the largest value. */
interface Limits {
  /** Bytes of a message. */
  message: number;
  /** Bytes of files that are dropped together. */
  dropped: number;
  /** Cells per side. */
  side: number;
  cells: number;
  /** m. */
  lengths: [number, number];
  robots: number;
  /** Robots in each world of a campaign. */
  fleet: number;
  /** Controllers, worlds, and runs with chance of a comparison. */
  compared: number;
  compared_worlds: number;
  compared_seeds: number;
  steps: number;
  /** s. */
  time_steps: [number, number];
  seconds: number;
  units: number;
  workers: number;
  examples: number;
  epoch: number;
  /** Digits, because JavaScript's numbers cannot hold it. */
  seed: string;
}

/** The choices that the server offers, the answer to `hello`: fuzz/studio/catalogue.py. */
interface Offered {
  families: { name: string; about: string; changes: boolean; parameters: Parameter[] }[];
  controllers: OfferedController[];
  motions: Motion[];
  formats: Format[];
  /** The defaults. */
  motion: string;
  time_step: number;
  strategies: string[];
  oracles: string[];
  cores: number;
  /** By name, what the robot does wrong, and where to look in the controller. */
  /** Name of the folder of known failures. */
  known: string;
  /** Help text and default of each option of `worldgen fuzz`. */
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

/** A file whose code the studio runs, and the named controllers
 * that may run it: fuzz/studio/requests/edits.py. */
interface CodeFile {
  file: string;
  name: string;
  digest: string;
  controllers: string[];
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
  /** Whether `low` itself is too small. */
  above?: boolean;
  /** A number that is allowed in addition, or null. */
  chosen?: number | null;
  /** The bounds in words. */
  bounds?: string;
  unit?: string;
  group?: string;
  /** The parameter `by` and its values with which this one has no effect;
   * null if it always has one. */
  idle?: { by: string; values: string[] } | null;
}

/** Changes of cells, in columns. */
interface Events {
  times: number[];
  ix: number[];
  iy: number[];
  state: number[];
}

/** A world without its proof: fuzz/studio/requests/messages.py. */
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
  /** The robots after the first: shown, but not edited. */
  others: { start: Triple; target: Triple; radius: number }[];
  /** Text of the file from which it was opened. */
  source: string | null;
}

/** A world that is being edited. */
interface EditedWorld extends Omit<WorldMessage, "cells"> {
  cells: Uint8Array;
  /** Name of its file in the folder; empty if it has none. */
  name: string;
  /** Digest of that file when it was opened or saved. */
  file: string | null;
  /** The same for all versions of one drawing. */
  sheet: symbol;
}

/** A rectangle of cells: 0 free, 1 solid, 2 unchanged. */
interface Pattern {
  width: number;
  height: number;
  cells: Uint8Array;
  /** Its picture, and the colours of the picture. */
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

/** The failure in a file. */
interface FailureMessage {
  controller: string;
  motion: string;
  seed: number;
  verdict: string;
  digest: string;
  parameters: Record<string, any>;
}

/** The answer to `open`, `generate`, `bring` and others. */
interface OpenedMessage {
  world: WorldMessage;
  made?: string | null;
  failure?: FailureMessage | null;
  file?: string | null;
}

/** The answer to `decide`, or a placeholder. */
interface Proof {
  result?: "reachable" | "blocked" | "undecided";
  /** Length of the path, m; like the next two, only if the target is reachable. */
  length: number;
  duration: number;
  clearance: number;
  /** Number of cells in the cut. */
  ring?: number | null;
  reason?: string;
  witness?: DrawnWorld["witness"];
  cut?: CellPlace[];
  /** With several robots: the others with their witnesses. */
  others?: OtherEnds[];
  error?: string;
  /** The witness, unpacked, and those of the other robots. */
  opened?: OpenWorld["witness"];
  openedOthers?: OpenWorld["others"];
}

/** A campaign in numbers: fuzz/studio/campaigns/state.py. */
interface CampaignState {
  folder: string;
  running: boolean;
  controller: string;
  /** Whether the controller's file is not the one that the campaign runs. */
  edited: boolean;
  motion: string;
  seed: string;
  budget: { units: number | null; seconds: number | null };
  /** What it is doing, or how it ended. */
  activity: "preparing" | "searching" | "shrinking" | "explaining" | "stopped" | "done" | "gave-up";
  /** What it answers; empty while it runs, and if an earlier version wrote it. */
  answer: "" | "failures" | "clean" | "none";
  answer_reason: string;
  /** Failures that are being shrunk, or wait for it. */
  shrinking: number;
  units: number;
  worlds: number;
  /** Runs that did not arrive in screening. */
  failed: number;
  steps: number;
  seconds: number;
  /** Seconds of the budget that are used; preparing does not count. */
  elapsed: number | null;
  /** A text that changes whenever a failure is new or smaller. */
  failures: string;
  verdicts: Record<string, number>;
  met: Record<string, number>;
  known: Record<string, number>;
  strategies: { strategy: string; units: number; worlds: number; steps: number; failures: number; variants: number }[];
  archive: Archive | null;
  error: Refusal | null;
}

/** A failure of a folder, as listed in the gallery. */
interface WallFailure {
  name: string;
  /** The name under which it is filed: its cause or, for an error of the controller, the reason. */
  group: string;
  verdict: string;
  controller: string;
  motion: string;
  width: number;
  height: number;
  solid: number;
  /** False for a world as it was found. */
  shrinking: "done" | "cut short" | "none";
  events: number;
  /** Its place among the folder's failures, the simplest first. */
  place: number;
  /** The place of its cause, the worst first. */
  rank: number;
  seen: number;
  digest: string;
  known: boolean;
}

/** A pending request, which can be stopped. */
interface Asked extends Promise<any> {
  stop(): void;
}

interface Connection {
  /** Sends a request to the server; `part` is called with each part of the answer. */
  ask(kind: string, message?: object, part?: (part: any) => void): Asked;
}

/** The state that all pages of the studio share. */
interface Studio {
  model: import("#studio/draw/model.js").Model;
  connection: Connection;
  folder: string;
  usual: UsualWorld;
  /** Null until the server has sent them. */
  limits: Limits | null;
  offered: Offered | null;
  /** The files whose code the server runs, as it last reported them. */
  code: CodeFile[];
  /** The largest radius that passes, m. */
  widest: number | symbol | null;
  askWidest(): void;
  say(words: string): void;
  page(): string;
  go(page: string): void;
  show(answer: OpenedMessage, name: string, label: string): void;
  generate(
    message: { family: string; seed: string; parameters: object; difficulty?: number; where?: string },
    label: string,
    progress?: (part: any) => void,
  ): Promise<OpenedMessage>;
  showName(): void;
  /** Keeps the address a link to what the page shows. */
  showLink(): void;
  undo(): void;
  redo(): void;
  save(): Promise<void>;
  run(): void;
  /** The pages, after they have been made. */
  draw: any;
  play: any;
  campaign: any;
  compare: any;
}

/** A world of a comparison: sent along, a file of the folder, or made by a family. */
interface ComparedWorld {
  name: string;
  world?: WorldMessage;
  file?: string;
  family?: string;
  seed?: string;
}

/** Everything on the board except the world. */
interface Board {
  canvas: HTMLCanvasElement;
  model: import("#studio/draw/model.js").Model;
  show: Record<string, boolean>;
  view: View | null;
  proof: Proof | null;
  signal: { values: Float64Array; most: number; picture?: OffscreenCanvas | null } | null;
  /** The moment that is shown of a world that changes, s. */
  time: number;
  /** A preview of what would be put down. */
  ghost: { pattern: Pattern; at: CellPlace } | null;
  /** Boxes of cells that would change. */
  marks: Box[];
  selection: Box | null;
  measure: [CellPlace, CellPlace] | null;
  /** The cell at which keys draw. */
  cursor: CellPlace | null;
  draw(): void;
  now(): View;
  pointAt(event: { clientX: number; clientY: number }): CellPlace;
  zoom(factor: number, event?: { clientX: number; clientY: number } | null): void;
  pan(dx: number, dy: number): void;
  reveal(cell: CellPlace): void;
  fit(): void;
}

/** How a tool is used: whether it erases, acts exactly at the pointer, and draws straight lines. */
interface ToolUse {
  erase: boolean;
  exact: boolean;
  /** Whether Shift is held: lines run straight. */
  straight?: boolean;
}

interface Tool {
  begin(point: CellPlace, use: ToolUse): void;
  drag(point: CellPlace, use: ToolUse): void;
  end(use: ToolUse): void;
  hover?(point: CellPlace): void;
}
