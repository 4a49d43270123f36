// Written by `python -m build_tools.page_types` from fuzz/studio/requests/protocol.py; not edited.

/** What a campaign found out, ready to be shown. */
interface CampaignAnswer {
  /** Whether the controller works. */
  headline: Headline;
  /** How often it arrives in natural worlds, or why that is not known; empty if it was not to be measured. */
  rate: string;
  /** The causes, the worst first. */
  causes: RankedCause[];
  /** The names of the causes that do not count; may be empty. */
  others: string;
  /** What changed since an earlier campaign; may be empty. */
  comparison: string;
  /** Time that is likely to bring an answer; 0 if there is one. */
  more_seconds: number;
}

/** Changes of cells, in columns; state 0 is free, 1 solid, 2 burning. */
interface Events {
  times: number[];
  ix: number[];
  iy: number[];
  state: number[];
}

/** Start, target and radius of a robot after the first; shown, but not edited. */
interface RobotEnds {
  start: [number, number, number];
  target: [number, number, number];
  radius: number;
}

/** A world as the page edits it, without its proof. */
interface WorldMessage {
  width: number;
  height: number;
  /** Bits, the first in the lowest bit, row by row from the lowest y. */
  cells: string;
  cell_size: number;
  robot_radius: number;
  robot_speed: number;
  /** x, y, heading. */
  start: [number, number, number];
  /** x, y, radius. */
  target: [number, number, number];
  events: Events | null;
  /** The robots after the first. */
  others: RobotEnds[];
  /** Text of the file from which it was opened. A world that still equals that one is saved, run and exported with its proof, provenance and failure. */
  source: string | null;
}

/** A file of the browser: dropped on the page, or to be kept. */
interface NamedFile {
  name: string;
  data: string;
}

/** A world of a comparison: sent along, a file of the folder, or made by a family. */
interface ComparedWorld {
  world?: WorldMessage | null;
  file?: string | null;
  family?: string | null;
  seed?: string | null;
}

/** An error as data; it does not depend on the wording. */
interface Refusal {
  /** Names the rule. */
  code: string;
  problem: string;
  /** By fields and buttons of the page, if possible. */
  remedy: string;
  /** Whether the remedy needs a terminal. */
  terminal: boolean;
  /** The part of the page with the remedy: `import` for the options of the import. */
  opens: string;
  /** The values by name; paths in the opened folder are relative to it. */
  facts: Record<string, any>;
  /** Where the user's code has failed, the innermost last. */
  frames: Frame[];
  /** Line of the file, if the error is in one. */
  line: number | null;
  source: string | null;
}

/** The parameter `by` and its values with which another one has no effect. */
interface Idle {
  by: string;
  values: string[];
}

/** A parameter of a family or format, or an option of a motion model. */
interface ParameterMessage {
  name: string;
  default: any;
  /** Name of its Python type: bool, int, float or str. */
  kind: string;
  choices: string[];
  low: number | null;
  high: number | null;
  /** Whether `low` itself is too small. */
  above: boolean;
  /** A number that is allowed in addition. */
  chosen: number | null;
  /** The bounds in words. */
  bounds: string;
  unit: string;
  group: string;
  help: string;
  idle: Idle | null;
}

/** A registered family. */
interface FamilyMessage {
  name: string;
  about: string;
  changes: boolean;
  parameters: ParameterMessage[];
}

/** A controller, with the motion model that it usually runs under. */
interface OfferedController {
  name: string;
  /** Whether it was named at the start. */
  named: boolean;
  thesis: boolean;
  lattice: boolean;
  motion: string;
  /** Another registered name of the same controller. */
  also: string;
  /** Why it cannot be loaded. */
  fault: Refusal | null;
}

/** A motion model. */
interface MotionMessage {
  name: string;
  about: string;
  thesis: boolean;
  options: ParameterMessage[];
}

/** A format that can be read or written. */
interface FormatMessage {
  name: string;
  about: string;
  suffixes: string[];
  reads: boolean;
  writes: boolean;
  changes: boolean;
  options: ParameterMessage[];
  read_options: ParameterMessage[];
}

/** Help text and default of an option of `worldgen fuzz`. */
interface OptionHelp {
  help: string;
  default: string | number | null;
}

/** Everything that the page offers as a choice. */
interface Offered {
  families: FamilyMessage[];
  /** Those named at the start first. */
  controllers: OfferedController[];
  motions: MotionMessage[];
  formats: FormatMessage[];
  /** The default. */
  motion: string;
  time_step: number;
  strategies: string[];
  oracles: string[];
  cores: number;
  /** Name of the folder of known failures. */
  known: string;
  options: Record<string, OptionHelp>;
}

/** A file that can be opened. */
interface ListedFile {
  name: string;
  bytes: number;
  world: boolean;
  /** Whether a campaign has found it. */
  found: boolean;
}

/** A recorded run: a failure's, or that of an archive's cell. */
interface RecordedRun {
  controller: string;
  motion: string;
  seed: number;
  parameters: Record<string, any>;
  verdict: string;
  digest: string;
}

/** A world with the facts in its file. */
interface OpenedMessage {
  world: WorldMessage;
  /** A sentence on its origin. */
  made: string | null;
  /** The record of a failure's file. */
  failure: RecordedRun | null;
  /** Digest of the file's bytes, or null if the world was not read from the folder. */
  file: string | null;
  /** The file's name, once it is saved. */
  name: string;
  /** Name of an imported map among its files. */
  main: string;
  /** Format of an imported map. */
  format: string | null;
  /** Problems in a map's scenario; `row` is the one used. */
  rows: number;
  row: number | null;
  /** Remarks of the import. */
  notes: string[];
  /** What a campaign ran in the world, unless it varies that. */
  runs: RecordedRun | null;
}

/** A failure as it was found. */
interface FoundRun {
  words: string;
  world: DrawnWorld;
  sensors: Sensors | null;
  run: DrawnRun | null;
  number: number | null;
  others: OtherRobot[];
}

/** An export. */
interface Exported {
  lost: string[];
  notes: string[];
  /** Names in the folder, if it is kept there. */
  written: string[];
  /** Else one file, which is a .zip of those `inside` if the format has several. */
  files: NamedFile[];
  inside: string[];
}

/** A decision with its proof. */
interface ProofMessage {
  result: "reachable" | "blocked" | "undecided";
  reason: string;
  /** Length of the path; of several robots, the sum. */
  length?: number;
  duration?: number;
  /** Of the witness, or how much too wide the robot is for the cut. */
  clearance?: number;
  witness?: PackedWitness | null;
  cut?: CellPlace[] | null;
  /** Number of cells of the cut, if they form a ring. */
  ring?: number | null;
  /** Ends and witness of each robot after the first. */
  others?: OtherEnds[];
}

/** A world's value of a metric. */
interface Metric {
  name: string;
  value: number;
  unit: string;
  meaning: string;
}

/** The worlds tried or files read so far; of an archive, their number is unknown. */
interface Progress {
  done: number;
  of: number | null;
}

/** The world of a run. */
interface RunBegins {
  world: DrawnWorld;
  /** A sentence if it is impossible or undecided that all robots arrive. */
  impossible: string;
}

/** A robot's run, as the player takes it. */
interface RobotMessage {
  name: string;
  verdict: string;
  /** Evidence for the verdict, in words. */
  why: string;
  /** Where the controller crashed. */
  frames: Frame[];
  steps: number;
  time: number;
  path: number;
  collisions: number;
  digest: string;
  run: DrawnRun | null;
  others: OtherRobot[];
  sensors: Sensors | null;
}

/** A robot's run by its number, with the flow chart of its behaviours. */
interface RanRobot {
  name: string;
  verdict: string;
  why: string;
  frames: Frame[];
  steps: number;
  time: number;
  path: number;
  collisions: number;
  digest: string;
  run: DrawnRun | null;
  others: OtherRobot[];
  sensors: Sensors | null;
  number: number;
  arbitration: FlowChart | null;
}

/** Why a robot did not run. */
interface RobotFault {
  number: number;
  name: string;
  error: Refusal;
}

/** The run of the robot that the user drives. */
interface DrivenRobot {
  name: string;
  verdict: string;
  why: string;
  frames: Frame[];
  steps: number;
  time: number;
  path: number;
  collisions: number;
  digest: string;
  run: DrawnRun | null;
  others: OtherRobot[];
  sensors: Sensors | null;
  /** The motion model, which is swept instead of the thesis's. */
  motion: string;
  /** Whether the world ended the run before the commands did. */
  ended: boolean;
}

/** A row's size, then what its cells cannot show: a fault, or the best columns. */
interface RowPart {
  row: number;
  width?: number;
  height?: number;
  column?: number | null;
  error?: Refusal | null;
  best?: number[] | null;
}

/** A cell of a comparison. */
interface CellPart {
  row: number;
  column: number;
  verdict: string;
  /** What is known beyond the verdict, such as a loop's period. */
  detail: string;
  steps: number;
  /** Null if it never arrives. */
  time: number | null;
  runs: number;
  reached: number;
  /** Seed of the run to play. */
  seed: number;
}

/** Totals of a controller over the full rows. */
interface ColumnTotal {
  runs: number;
  reached: number;
  wins: number;
  shared: number;
  mean_time: number | null;
}

/** The totals by column, and the number of full rows. */
interface ComparisonMessage {
  totals: ColumnTotal[];
  rows: number;
}

/** A file whose code the studio runs, and the named controllers that may run it. */
interface CodeFile {
  file: string;
  name: string;
  digest: string;
  controllers: string[];
}

/** The archive of behaviours: its two numbers, and index, quality and verdict of each cell. */
interface ArchiveMessage {
  names: string[];
  edges: number[][];
  cells: [number, number, number, string][];
}

/** A campaign in numbers. */
interface CampaignState {
  folder: string;
  running: boolean;
  controller: string;
  /** Whether the controller's file is not the one that the campaign runs. */
  edited: boolean;
  motion: string;
  seed: string;
  budget: Budget;
  /** A text that changes whenever a failure is new or smaller. */
  failures: string;
  /** What it is doing, or how it ended. */
  activity: "preparing" | "searching" | "shrinking" | "explaining" | "stopped" | "done" | "gave-up";
  /** Empty while it runs. */
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
  verdicts: Record<string, number>;
  met: Record<string, number>;
  known: Record<string, number>;
  strategies: StrategyYield[];
  archive: ArchiveMessage | null;
  /** Why it gave up. */
  error: Refusal | null;
  /** What it found out, once it has ended. */
  conclusion: CampaignAnswer | null;
}

/** A folder that holds worlds, with their number. */
interface ListedFolder {
  name: string;
  worlds: number;
}

/** The folder's campaigns, running ones first, with those that cannot be read. */
interface CampaignList {
  campaigns: CampaignState[];
  faults: Refusal[];
  folders: ListedFolder[];
  archives: string[];
}

/** A failure of a folder. */
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
  events: number;
  shrinking: "done" | "cut short" | "none";
  digest: string;
  /** Its place among the folder's failures, the simplest first. */
  place: number;
  /** The place of its cause, the worst first. */
  rank: number;
  /** Seconds since 1970. */
  seen: number;
  known: boolean;
}

/** The failures of a folder, and why some of its files cannot be read. */
interface FailureList {
  failures: WallFailure[];
  faults: Refusal[];
}

/** A failure to be drawn, and what happened in words. */
interface LookMessage {
  world: DrawnWorld;
  /** A command. */
  replay: string;
  notes: string[];
  /** For a cause's example, the changes after which it arrives; `named` are their cells. */
  why: string;
  named: CellPlace[];
  /** Of its cause, like `advice`; empty if unknown. */
  sentence: string;
  advice: string;
  words: string;
  repeats: string;
  /** Whether the run has the digest that was found. */
  same: boolean | null;
  run: DrawnRun | null;
  sensors: Sensors | null;
  number: number | null;
  others: OtherRobot[];
  /** Why it is not run. */
  error: Refusal | null;
}

/** The server's limits, so that the page's fields can show what it would refuse. */
interface Limits {
  /** Bytes of a message. */
  message: number;
  /** Bytes of files that are dropped together. */
  dropped: number;
  /** Cells per side. */
  side: number;
  cells: number;
  lengths: [number, number];
  robots: number;
  /** Controllers of a comparison. */
  compared: number;
  compared_worlds: number;
  compared_seeds: number;
  steps: number;
  time_steps: [number, number];
  seconds: number;
  units: number;
  workers: number;
  examples: number;
  epoch: number;
  /** Robots in each world of a campaign. */
  fleet: number;
  /** Digits. */
  seed: string;
}

/** Cells and robot of a new world. */
interface UsualWorld {
  cell_size: number;
  robot_radius: number;
  robot_speed: number;
}

/** What the page needs to know before it has a connection. */
interface Given {
  /** The version of this page. */
  protocol: number;
  subprotocol: string;
  /** WebSocket code for too many connections; the reason is a sentence. */
  full: number;
  world: UsualWorld;
}

/** The first message of a connection. */
interface Begins {
  /** The opened folder. */
  folder: string;
  /** The world to open first. */
  file: string | null;
  protocol: number;
  limits: Limits;
}

/** The first line of an answer. */
interface Headline {
  /** The controller under its motion model; empty if the words name it. */
  who: string;
  /** Whether it works. */
  words: string;
  /** What follows them. */
  rest: string;
  /** `none`, `clean`, or the severity of the worst cause. */
  tone: string;
}

/** A cause as an answer gives it. */
interface RankedCause {
  /** Its name. */
  cause: string;
  /** Its severity, in a word. */
  severity: string;
  /** True if the campaign is the first to meet it. */
  is_new: boolean;
  /** How often it was met. */
  often: string;
  /** What the robot does wrong, and what to check. */
  sentence: string;
  /** What its example depends on; may be empty. */
  why: string;
  /** Name of the example's file; empty if there is none. */
  file: string;
  /** The groups of its failures. */
  groups: string[];
}

/** The yield of a strategy so far. */
interface StrategyYield {
  /** Its name. */
  strategy: string;
  /** Units it was given. */
  units: number;
  /** Scenarios simulated. */
  worlds: number;
  /** Steps simulated. */
  steps: number;
  /** Failures proved and classified. */
  failures: number;
  /** Keys of failures that it was the first to find. */
  variants: number;
}

/** The budget of a campaign. */
interface Budget {
  /** Amount of work, or `None`. */
  units: number | null;
  /** Time for this run, or `None`. */
  seconds: number | null;
}

/** Each kind of request: its fields, the parts of its answer, and the answer. */
interface Messages {
  /** Return everything that the page offers as a choice. */
  hello: { request: { }; part: string; answer: Offered };
  /** Return the files in the folder that can be opened. */
  files: { request: { }; part: never; answer: ListedFile[] };
  /** Return a world of the folder. */
  open: { request: { name: string; }; part: never; answer: OpenedMessage };
  /** Return the original of a failure in the folder, before shrinking. */
  before: { request: { name: string; }; part: never; answer: FoundRun | null };
  /** Write a world to the folder, with its file's proof or else a new one. */
  save: { request: { name: string; world: WorldMessage; overwrite: boolean; replaces?: string | null; }; part: never; answer: OpenedMessage };
  /** Import a map of another program: from the folder, or dropped with its companions. */
  bring: { request: { name?: string | null; files?: NamedFile[] | null; format?: string | null; options?: Record<string, any>; radius?: number | null; row?: number | null; seed?: string | null; }; part: never; answer: OpenedMessage };
  /** Return a world in another program's format. */
  export: { request: { name: string; world: WorldMessage; format: string; keep: boolean; overwrite?: boolean; options?: Record<string, any>; at?: number | null; origin?: [number, number] | null; sidecar?: boolean; }; part: never; answer: Exported };
  /** Decide if the target can be reached; for several robots, all together. */
  decide: { request: { world: WorldMessage; }; part: never; answer: ProofMessage };
  /** Return the largest radius that fits through. */
  widest: { request: { world: WorldMessage; }; part: never; answer: number | null };
  /** Return the signal that the thesis's robot reads, cell by cell. */
  signal: { request: { world: WorldMessage; noise: boolean; }; part: never; answer: string };
  /** Return the world with another body and other goals of its robot. */
  goal: { request: { world: WorldMessage; footprint: string; heading: string; arrival: string; waypoints: string; }; part: never; answer: WorldMessage };
  /** Return the difficulty of a world by every applicable metric. */
  measure: { request: { world: WorldMessage; }; part: never; answer: Metric[] };
  /** Return a world of a family; with a difficulty or a condition, search for one. */
  generate: { request: { family: string; seed: string; parameters: Record<string, any>; difficulty?: number | null; where?: string | null; }; part: Progress; answer: OpenedMessage };
  /** Return a small world of a family, as an example. */
  preview: { request: { family: string; }; part: never; answer: DrawnWorld };
  /** Return the world with walls that move, as in the thesis's world shifter. */
  shift: { request: { world: WorldMessage; seed: string; }; part: never; answer: WorldMessage };
  /** Run controllers in a world, one after another; each result is a part. */
  run: { request: { motion: string; time_step: number; seed: number; options: Record<string, any>; steps?: number | null; still?: boolean; world: WorldMessage; controllers: string[]; }; part: RunBegins | RanRobot | RobotFault; answer: null };
  /** Return the same runs as a file. */
  picture: { request: { motion: string; time_step: number; seed: number; options: Record<string, any>; steps?: number | null; still?: boolean; world: WorldMessage; controllers: string[]; kind: "gif" | "svg" | "html"; title: string; looked: number; }; part: never; answer: string };
  /** Run a robot by the user's commands from the start. */
  drive: { request: { motion: string; time_step: number; seed: number; options: Record<string, any>; steps?: number | null; still?: boolean; world: WorldMessage; commands: [number, number, number][]; }; part: never; answer: DrivenRobot };
  /** Check that a controller may run under this name with its options. */
  check: { request: { motion: string; time_step: number; seed: number; options: Record<string, any>; steps?: number | null; still?: boolean; controller: string; }; part: never; answer: null };
  /** Return the core with which the page judges worlds itself; null if there is none here. */
  core: { request: { }; part: never; answer: Record<string, string> | null };
  /** Return what the page needs to run a controller itself, in any world of this size and robot. */
  recipe: { request: { motion: string; time_step: number; seed: number; options: Record<string, any>; steps?: number | null; still?: boolean; world: WorldMessage; controller: string; }; part: never; answer: Record<string, any> };
  /** Run each controller in each world; each cell is a part. */
  compare: { request: { motion: string; time_step: number; seed: number; options: Record<string, any>; steps?: number | null; still?: boolean; controllers: string[]; worlds: ComparedWorld[]; seeds: number; }; part: RowPart | CellPart; answer: ComparisonMessage };
  /** Report the files whose code the studio runs, at first and after each edit. */
  edits: { request: { }; part: CodeFile[]; answer: null };
  /** Return the folder's campaigns, and the folders and archives that hold worlds. */
  campaigns: { request: { }; part: never; answer: CampaignList };
  /** Begin a campaign, or resume the one in its folder. */
  begin: { request: { folder: string; units?: number | null; seconds?: number | null; workers?: number | null; known?: boolean; baseline?: string[]; controller: string; motion: string; strategies?: string[]; world?: WorldMessage | null; world_name?: string | null; seed?: string | null; robots?: number | null; time_step?: number | null; examples?: number | null; epoch?: number | null; oracles?: string[]; vary?: string[]; shrink?: boolean | null; }; part: string; answer: CampaignState };
  /** Return the command that begins the same campaign at a terminal. */
  command: { request: { folder: string; units?: number | null; seconds?: number | null; workers?: number | null; known?: boolean; baseline?: string[]; controller: string; motion: string; strategies?: string[]; world?: WorldMessage | null; world_name?: string | null; seed?: string | null; robots?: number | null; time_step?: number | null; examples?: number | null; epoch?: number | null; oracles?: string[]; vary?: string[]; shrink?: boolean | null; }; part: never; answer: string };
  /** Resume the campaign in a folder. */
  resume: { request: { folder: string; units?: number | null; seconds?: number | null; workers?: number | null; known?: boolean; baseline?: string[]; }; part: string; answer: CampaignState };
  /** Report a campaign's state whenever it has changed, until it ends. */
  watch: { request: { folder: string; }; part: CampaignState; answer: CampaignState | null };
  /** Stop a campaign, also one that has not begun yet. */
  stop: { request: { folder: string; }; part: never; answer: CampaignState | null };
  /** Return the simplest world in a cell of a campaign's archive. */
  elite: { request: { folder: string; i: number; j: number; }; part: never; answer: OpenedMessage };
  /** Return the failures in and below a folder, "" for the opened one, or in an archive. */
  failures: { request: { folder: string; }; part: Progress; answer: FailureList };
  /** Return a failure's world and run, to be drawn, and a description of what happened. */
  look: { request: { name: string; }; part: never; answer: LookMessage };
  /** Return a failure as the source of a test. */
  snippet: { request: { name: string; }; part: never; answer: string };
  /** Mark a failure's cause as known, or unmark it. */
  know: { request: { name: string; known: boolean; }; part: never; answer: null };
  /** End another request, which is then answered by `ended`. */
  cancel: { request: { of: number; }; part: never; answer: null };
}
