// Types of the server's data and of objects that the pages' scripts share.
// Only `npm run check` reads this file.

/** Whole numbers as `fuzz/player/streams.py` packs them. */
type Packed = string;

/** One bit per cell or row, in base64. */
type Bits = string;

/** A column and a row of cells. */
type CellPlace = [number, number];

/** A place and another number: a heading in rad, or a radius. */
type Triple = [number, number, number];

/** A box of cells; (x, y) is its lower left cell. */
interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** The view of a canvas: the cell in its middle, and pixels per cell. */
interface View {
  x: number;
  y: number;
  scale: number;
}

// Data that the server packs for drawing: fuzz/player/worlds.py, runs.py, memory.py, sensors.py.

/** Packed by the server, or not by the page. */
interface CutPoses {
  all: Bits | Uint8Array;
  some: Bits | Uint8Array;
  fineness: number;
}

interface DrawnWorld {
  width: number;
  height: number;
  /** Side of a cell, m. */
  cell: number;
  /** Radius of the robot, in cells. */
  radius: number;
  cells: Bits;
  /** x and y in cells, heading in rad. */
  start: Triple;
  /** x, y and radius in cells. */
  target: Triple;
  events: { ms: Packed; ix: Packed; iy: Packed; state: Packed } | null;
  witness?: PackedWitness | null;
  cut?: CellPlace[] | null;
  /** Places where a body fits in no heading, and in some only; `fineness` of them along a cell. */
  cut_poses?: CutPoses | null;
  /** Corners of the robot's body in cells, x ahead and y to the left; a disc has none. */
  footprint?: [number, number][];
  /** Heading that the robot must have at the target, rad. */
  aim?: number;
  /** Goals before the target, in order: x, y and radius in cells. */
  waypoints?: Triple[];
  /** The robots after the first. */
  others?: OtherEnds[];
  /** Unpacked by the page; never sent by the server. */
  open?: OpenWorld;
}

/** Times in ms; places in parts, `per_cell` to a cell. */
interface PackedWitness {
  ms: Packed;
  x: Packed;
  y: Packed;
  per_cell: number;
}

interface OtherEnds {
  start: Triple;
  target: Triple;
  /** In cells. */
  radius: number;
  witness: PackedWitness | null;
  footprint?: [number, number][];
  aim?: number;
}

interface OpenWorld {
  cells: Uint8Array;
  events: { ms: Float64Array; ix: Float64Array; iy: Float64Array; state: Float64Array } | null | undefined;
  witness?: { ms: Float64Array; x: Float64Array; y: Float64Array } | null;
  /** Witnesses of the robots after the first. */
  others?: ({ ms: Float64Array; x: Float64Array; y: Float64Array } | null)[];
  /** Cells at some time, and the number of events that they include. */
  now?: Uint8Array | null;
  done: number;
  /** What happens next to each cell, which cells open later, and which have burnt, at `done`. */
  coming?: { next: Uint8Array; opens: Uint8Array; burnt: Uint8Array; done: number };
  /** In a world that is being edited: a box of all cells changed after a version,
   * null for all cells. */
  boxSince?: (version: number) => Box | null;
}

/** A world with only the parts that are needed to draw it. */
type SceneWorld = Omit<DrawnWorld, "cell" | "cells" | "events"> & Partial<DrawnWorld>;

/** A step that the evidence names. */
interface Mark {
  step: number;
  kind: string;
  name: string;
  text: string;
  cell?: CellPlace;
}

interface DrawnRun {
  steps: number;
  /** Time step, s. */
  dt: number;
  /** Units of the columns: parts of a step in `at`, of a cell in `x` and `y`,
   * of a turn in `heading`. */
  per: { step: number; cell: number; turn: number };
  at: Packed;
  x: Packed;
  y: Packed;
  heading: Packed;
  bump: Bits;
  active?: Packed | null;
  behaviours?: string[];
  memory: DrawnMemory | null;
  /** If the robot has entered a wall: the depth in cells beyond
   * which its motion model reports that; else null. */
  tolerance: number | null;
  /** One in this many steps is included, at the coarsest. */
  thinned: number;
  /** Entry and period. */
  loop: [number, number] | null;
  /** Whether its task is to be everywhere instead of to arrive. */
  covers?: boolean;
  marks: Mark[];
  /** With several robots: the numbers of the robots that this one drives into forever. */
  blocked_by?: number[];
  open?: OpenRun;
}

interface OpenRun {
  /** Time of each row, in steps. */
  at: Float64Array;
  x: Float64Array;
  y: Float64Array;
  heading: Float64Array;
  bump: Uint8Array;
  active: Float64Array | null | undefined;
  pierced?: Map<string, { ix: number; iy: number; step: number; named: boolean; isEntered: boolean }>;
  touched?: Map<string, { ix: number; iy: number; dx: number; dy: number; step: number; last: number }>;
  numbered?: number[];
  series?: Series[];
}

/** One value for each row of a run. */
interface Series {
  name: string;
  unit: string;
  least: number;
  most: number;
  values: Float64Array;
  /** Whether the greatest value stands for all that are greater. */
  capped: boolean;
}

/** The series of one of the robots in the plots. */
interface Curves {
  run: DrawnRun;
  number: number;
  colour: string;
  front: boolean;
  /** Whether there are several robots. */
  named: boolean;
  series: Series[];
}

interface DrawnMemory {
  fields: { name: string; words: string[]; least: number; values: Packed }[];
  /** Value of a field that stands for 1. */
  one: number;
  /** Value of a field without a number. */
  missing: number;
  map: MemoryMap | null;
  fault: string;
  open?: {
    fields: Float64Array[];
    map: Record<string, Float64Array> | null;
  };
}

/** Shapes with the steps between which they exist: fuzz/player/memory.py. */
interface MemoryMap extends Record<"kind" | "x0" | "y0" | "x1" | "y1" | "since" | "until", Packed> {
  /** Names of the kinds by number; the numbers after them are rectangles by degree,
   * the worst first. */
  kinds: string[];
  degrees: number;
  /** Names of the places. */
  names: string[];
}

interface Sensors {
  beams: number;
  /** Longest beam, in cells. */
  range?: number;
  /** Angle between the first and the last beam, rad; 0 for all around. */
  field?: number;
  signal: boolean;
}

/** A line of a user's code at which it has failed. */
interface Frame {
  file: string;
  line: number;
  function?: string;
  code?: string;
}

/** A robot's result, with its run if it has one. */
interface Robot {
  name: string;
  verdict: string;
  /** Evidence for the verdict; empty if the robot arrived. */
  why: string;
  steps: number;
  time: number;
  path: number;
  collisions: number;
  digest: string;
  run: DrawnRun | null;
  sensors: Sensors | null;
  /** The world's robots after the first, if it has several. */
  others?: OtherRobot[];
  /** How it arbitrates among its behaviours, in the studio; null if it has none. */
  arbitration?: FlowChart | null;
  /** Why it did not run. */
  error?: string;
  /** Where its code has failed, the innermost last. */
  frames?: Frame[];
}

/** A flow chart: sim/controllers/behaviours/chart.py. */
interface FlowChart {
  arbiter: string;
  /** A sentence on each behaviour, the highest priority first. */
  words: string[];
  /** px. */
  width: number;
  height: number;
  /** Tag, attributes and text; `data-part` is the name of the behaviour of
   * which a shape is the box. */
  shapes: ["rect" | "polygon" | "polyline" | "text", Record<string, string>, string][];
}

interface ReplayData {
  title: string;
  world: DrawnWorld | null;
  robots: Robot[];
}

// Data of the report's page: fuzz/report/page.py, gather.py, summary.py.

/** A world with its run and its file. */
interface DrawnFailure {
  name: string;
  file: string;
  size: string;
  solid: number;
  events: number;
  world: DrawnWorld | null;
  run: DrawnRun | null;
  sensors: Sensors | null;
  /** For the first robot, and for the others if there are several. */
  number?: number | null;
  others?: OtherRobot[];
  /** Cells that the text next to the picture names. */
  named?: [number, number][];
}

/** What runs inside a controller in Python in the last part of its run. */
interface ReportInside {
  file: string;
  part: string;
  /** Number (0 for lines left out), how often it runs (null for one that does not run by itself), text. */
  lines: [number, number | null, string][];
  unused: string[];
  /** Fields of the observation. */
  reads: string[];
  state: [string, string][];
}

interface ReportFailure {
  id: string;
  /** The name under which it is filed: its cause or, for an error of the controller, the reason. */
  group: string;
  verdict: string;
  controller: string;
  motion: string;
  solid: number;
  size: string;
  cells: number;
  met: number | null;
  strategy: string;
  /** Index of its campaign on the page; -1 for none. */
  campaign: number;
  confirmed: boolean;
  words: string;
  reason: string;
  path: string;
  replay: string;
  /** The command that finds what it depends on. */
  explain: string;
  cause: string;
  sentence: string;
  advice: string;
  /** What the robot repeats; empty if it arrives, or if there are several robots. */
  repeats: string;
  inside: ReportInside | null;
  /** What is around it, steps, how it turns and how it drives there, in words. */
  reactions: [string, number, string, string][];
  /** Whether it is the clearest failure of its cause. */
  example: boolean;
  /** After which single changes the robot arrives; empty if that was not tried. */
  why: string;
  shrinking: "done" | "cut short" | "none";
  /** A sentence if its controller's file has changed since its campaign; else empty. */
  changed: string;
  /** A test that contains the world. */
  test: string;
  /** What a page needs to judge changes of the world, packed: fuzz/report/live.py. Null if it cannot. */
  live: string | null;
  /** Single changes after which the robot arrives: in words, and what to change. */
  tries: [string, { cell?: CellPlace; heading?: number; radius?: number }][];
  /** Heading, rows of name and value, and whether they are folded away at first. */
  groups: [string, [string, string][], boolean][];
  now: DrawnFailure;
  before: DrawnFailure | null;
}

interface ReportCampaign {
  folder: string;
  controller: string;
  motion: string;
  seed: string;
  /** Not set while it runs, and by earlier versions. */
  answer?: "failures" | "clean" | "none";
  answer_reason?: string;
  answer_numbers?: { searched_unjudged: number };
  units: number;
  units_cut: number;
  worlds: number;
  steps: number;
  seconds: number;
  found: { cause: string; strategy: string; unit: number; solid_cells: number; worlds: number; steps: number; seconds: number }[];
  strategies: { strategy: string; units: number; worlds: number; steps: number; failures: number; variants: number }[];
  met: Record<string, number>;
  verdicts: Record<string, number>;
  survives_reset?: string[];
  /** A sentence if its controller's file has changed since; else empty. */
  changed: string;
  archive: Archive | null;
}

/** Counts of natural worlds under one name. */
interface NaturalRow {
  worlds: number;
  arrived: number;
}

interface NaturalWorlds {
  worlds: number;
  arrived: number;
  unsensed: number;
  share: number;
  low: number;
  high: number;
  families: Record<string, NaturalRow>;
  clearances: Record<string, NaturalRow>;
  turns: Record<string, NaturalRow>;
  /** The kinds of paths that none of these worlds had. */
  never: string[];
  /** Share of worlds in which it arrives, as the terminal gives it. */
  percent: number;
}

interface ReportCause {
  cause: string;
  sentence: string;
  advice: string;
  severity: string;
  state: string;
  met: number;
  natural: number | null;
  /** The names under which its failures are filed. */
  groups: string[];
  verdicts: Record<string, number>;
  /** Path of the clearest failure; empty if there is none. */
  file: string;
  repeats: string;
  why: string;
}

interface ReportAnswer {
  controller: string;
  motion: string;
  causes: ReportCause[];
  natural: NaturalWorlds | null;
  comparison: { sentence: string } | null;
  /** Whether it works, as terminal and studio say it; `more` is the command that brings an answer. */
  headline: { who: string; words: string; rest: string; tone: string; more: string };
  campaign: number;
  /** Of all runs of this controller on the page. */
  reactions: [string, number, string, string][];
}

interface ReportData {
  title: string;
  answers: ReportAnswer[];
  failures: ReportFailure[];
  /** Failures that only the summary shows. */
  extras: ReportFailure[];
  campaigns: ReportCampaign[];
  others: number;
  /** The core, for pages that judge changes; null if there is none. */
  live?: LiveCore | null;
}

/** The report's list of failures. */
interface Overview {
  redraw(): void;
  /** Draws every picture at once. */
  drawAll(): void;
  /** Ids of the visible failures, in order. */
  shown(): string[];
}

/** Ids of the failures before and after one, if there are any. */
type Neighbours = [string | undefined, string | undefined];

/** The report's view of one failure. */
interface Detail {
  player(): Player | null;
  /** Switches between the world before and after shrinking. */
  swap(): void;
  /** Ends what the page leaves. */
  close(): void;
  redraw(): void;
}

/** The behaviours that a campaign has found. */
interface Archive {
  /** Names of the two axes. */
  names: [string, string];
  edges: [number[], number[]];
  /** Column, row, quality and verdict of each kind. */
  cells: [number, number, number, string][];
}

// Types of the player.

/** A canvas addressed in cells. */
interface Pen {
  context: CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;
  width: number;
  height: number;
  scale: number;
  /** Pixels of a mark's unit. */
  unit: number;
  snap(value: number): number;
  px(value: number): number;
  py(value: number): number;
  colours: Record<string, string>;
  /** Left, top, right and bottom of the words on the map so far. */
  words?: [number, number, number, number][];
  /** Middle and radius of the robots that stand on the map, pixels. */
  bodies?: Triple[];
}

/** Pixels of the page, and how many of the canvas each has. */
interface Size {
  width: number;
  height: number;
  ratio: number;
}

/** How a mark looks: worldgen/render/marks.py. */
interface MarkLook {
  colour: string;
  label?: string;
  width: number;
  dash: number[];
  opacity: number;
  casing: number;
  fill: number;
  size: number;
  fade: number[];
  on_cards: boolean;
}

/** Start, target and body of a robot; its number, if there are several. */
interface SceneEnds {
  start: Triple;
  target: Triple;
  waypoints?: Triple[];
  radius: number;
  footprint?: [number, number][];
  aim?: number;
  number: number | null;
}

/** What is drawn of a run at a time. */
interface SceneRobot {
  run: DrawnRun;
  number: number | null;
  isFront: boolean;
  open: OpenRun;
  /** Row from which the robot repeats itself; the number of rows if it doesn't. */
  entry: number;
  step: number;
  radius: number;
  footprint?: [number, number][];
  pose: Pose;
  /** Row after the last one that is drawn. */
  until: number;
  /** Whether the last place drawn is between two rows. */
  isDriving: boolean;
}

/** What the marks of a scene are drawn from. */
interface Stage {
  pen: Pen;
  world: SceneWorld;
  run?: DrawnRun | null;
  scene: RunScene | null;
  show: Shown;
  sensors?: Sensors | null;
  named: [number, number][];
  whole: boolean;
  isCard: boolean;
  ms: number;
  cells: Uint8Array;
  robots: SceneRobot[];
  front: (SceneRobot & { within: number }) | null;
}

interface Pose {
  x: number;
  y: number;
  heading: number;
  bump: boolean;
  row: number;
}

type Layer = "changes" | "trail" | "witness" | "sensors" | "signal" | "touched" | "memory";

/** The visible parts of a scene; `grid`, `numbers` and the bar `scale` are visible unless they are false. */
type Shown = Partial<Record<Layer | "grid" | "scale" | "cells" | "numbers", boolean>>;

interface OtherRobot {
  run: DrawnRun;
  number: number;
}

interface Scene {
  world: SceneWorld;
  run?: DrawnRun | null;
  /** Time, in steps. */
  step?: number;
  /** Time without a run, ms. */
  ms?: number;
  show: Shown;
  sensors?: Sensors | null;
  /** The number next to this robot, if there are several robots. */
  number?: number | null;
  others?: OtherRobot[];
  /** Draws the whole run, as in still pictures. */
  whole?: boolean;
  /** Leaves out what a small picture has no room for. */
  isCard?: boolean;
  /** Size of a canvas that is not on the page. */
  on?: Size | null;
  /** Cells that the text next to the picture names. */
  named?: [number, number][];
}

/** A scene of a robot's run. */
type RunScene = Scene & { run: DrawnRun; step: number };

/** What a player plays. */
interface Drawn {
  world: DrawnWorld;
  run: DrawnRun | null;
  sensors?: Sensors | null;
  number?: number | null;
  others?: OtherRobot[];
  named?: [number, number][];
  name?: string;
  /** What happened, in sentences, the most important first; a picture to keep has them. */
  says?: string[];
  /** Why there is no run. */
  why?: string;
  /** What this page can save: pairs of a label and a function. */
  saves?: [string, () => Promise<string | void>][];
  stopSaving?: () => void;
  /** Draws instead of the player: the editor's board. */
  paint?: (player: Player) => void;
  /** Another run that is played at the same time. */
  beside?: Beside | null;
}

interface Beside {
  canvas: HTMLCanvasElement;
  world: DrawnWorld;
  run: DrawnRun | null;
  sensors?: Sensors | null;
  /** Labels of the other run, and of the one in front. */
  words: string[];
}

interface Player extends Clock, Camera {
  /** Whether it shows the whole run: until a time is chosen. */
  isOverview: boolean;
  /** Shows or hides a layer. */
  reveal(name: Layer, on: boolean): void;
  drawn: Drawn;
  canvas: HTMLCanvasElement;
  step: number;
  last: number;
  playing: boolean;
  /** Plays only the period of a loop. */
  period: boolean;
  speed: number;
  show: Record<Layer | "cells", boolean>;
  /** Called after each frame while both runs are saved to a file. */
  drawnMore: (() => void) | null;
  /** Null for the whole world. */
  view: View | null;
  follow: boolean;
  /** Shows less of the run in the timeline, more with a factor below 1, the whole run with 0. */
  zoomTime?: (factor: number) => void;
  draw(): void;
  update(): void;
}

/** The scrub bar, and the part of the run that it and the plots show. */
interface Timeline {
  element: HTMLElement;
  buttons: HTMLElement;
  /** The first and the last step that are shown. */
  view: { from: number; to: number };
  /** As `Player.zoomTime`; the step `at` stays in its place. */
  zoom(factor: number, at?: number): void;
  /** Shows a step, in `words` for a screen reader. */
  draw(step: number, words: string): void;
}

interface Clock {
  go(step: number): void;
  play(on: boolean): void;
}

interface Camera {
  zoom(factor: number): void;
  /** Shows the whole world. */
  fit(): void;
  /** Follows the robot. */
  robot(): void;
  /** Shows what happens at the end: the period, or the robots that block each other. */
  event(): void;
  move(dx: number, dy: number): void;
}

/** The action of each key, by the key's name. */
type Keys = Record<string, () => void>;

/** A row of the table of keys: one key or several, and their action. */
type KeyRow = [string | string[], string];

/** Possible contents of an element; null and undefined are ignored. */
type Content = Node | string | number | null | undefined | false | Content[];

/** The rows of a line to draw, and their style. */
interface LineLook {
  from: number;
  to: number;
  colour: string;
  width: number;
  alpha: number;
  /** Do not keep a picture of it. */
  once?: boolean;
}

// Types of the editor: fuzz/player/page/edit.

/** A world that is being edited, in metres. */
interface EditedWorld {
  width: number;
  height: number;
  /** 1 for solid, row by row from the lowest y. */
  cells: Uint8Array;
  cell_size: number;
  robot_radius: number;
  robot_speed: number;
  /** x, y, heading. */
  start: Triple;
  /** x, y, radius. */
  target: Triple;
  /** Changes of cells, in columns, times in s. */
  events: { times: number[]; ix: number[]; iy: number[]; state: number[] } | null;
  /** The robots after the first, which pages show but do not edit. */
  others: { start: Triple; target: Triple; radius: number }[];
  /** Text of its file as it was opened, which has what pages do not edit. */
  source: string | null;
  /** Name of its file; empty if it has none. */
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

/** Whether the target can be reached, and the certificate; or a placeholder. */
interface Proof {
  result?: "reachable" | "blocked" | "undecided";
  reason?: string;
  length: number;
  duration: number;
  clearance: number;
  witness?: PackedWitness | null;
  cut?: CellPlace[] | null;
  /** Of a cut of poses: where it stops the body. */
  cut_poses?: CutPoses | null;
  /** Number of cells of the cut, if they form a ring. */
  ring?: number | null;
  /** Ends and witness of each robot after the first. */
  others?: OtherEnds[];
  error?: string;
  /** What the page waits for, in words. */
  waiting?: string;
  /** The witness, unpacked, and those of the other robots. */
  opened?: OpenWorld["witness"];
  openedOthers?: OpenWorld["others"];
}

/** Everything on the board except the world. */
interface Board {
  canvas: HTMLCanvasElement;
  model: import("#player/edit/model.js").Model;
  show: Record<string, boolean>;
  view: View | null;
  proof: Proof | null;
  /** Parts of the scene that show a run in the world. */
  run: Pick<Scene, "run" | "step" | "whole" | "sensors" | "show"> | null;
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
  toRun(): void;
}

/** How a tool is used: whether it erases, acts exactly at the pointer, and draws straight lines. */
interface ToolUse {
  erase: boolean;
  exact: boolean;
  /** Whether Shift is held: lines run straight. */
  straight?: boolean;
  /** Whether keys use it, at the cursor. */
  byKeys?: boolean;
}

interface Tool {
  /** Whether keys use it from one cell to another. */
  readonly spans?: boolean;
  begin(point: CellPlace, use: ToolUse): void;
  drag(point: CellPlace, use: ToolUse): void;
  end(use: ToolUse): void;
  hover?(point: CellPlace): void;
}


// Types of what judges a world in the page itself: live/, and fuzz/player/live.py.

/** The cores and the script of their worker, each as base64 of gzip. */
interface LiveCore {
  prover: string;
  simulator: string;
  script: string;
}

interface Live {
  /** The newest question wins: an earlier one without an answer yet gets null. */
  judge(question: LiveQuestion): Promise<LiveAnswer | null>;
  /** Ends the worker. */
  close(): void;
}

interface LiveQuestion {
  world: LiveWorld;
  /** Null if only the proof is wanted. */
  run: LiveRecipe | null;
  /** Whether the run gets the budget that Python gives this world, instead of the recorded one's. */
  edited: boolean;
}

/** A world as a reader edits it. Its numbers mean their shortest decimals, as in its file. */
interface LiveWorld {
  /** The top row first; "#" is solid. */
  cells: string[];
  /** m. */
  cell_size: number;
  /** x and y, m; heading, rad. */
  start: Triple;
  /** x, y and radius, m. */
  target: Triple;
  /** Of the robot's disc, m. */
  radius: number;
  /** m/s. */
  speed: number;
  /** A body instead of the disc. */
  body?: LiveBody;
  /** Headings of the lattice that a body or a car may have at the target: the first, and how many follow; null if there is none. */
  headings?: [number, number] | null;
  /** Set if the robot turns by steering. */
  car?: LiveCar;
  /** Goals before the target, in order, if there are any. */
  waypoints?: { target: Triple; headings?: [number, number] | null }[];
  /** Set if cells change over time: those that become solid or burn, and those that stop being solid. */
  changes?: { closes: CellPlace[]; opens: CellPlace[] };
  /** Their number, if there are several. */
  robots?: number;
}

interface LiveCar {
  /** m. */
  turning_radius: number;
  reverse: boolean;
  /** Full locks per second; 0 for at once. */
  steering_rate: number;
}

/** A convex polygon that turns about its axle. */
interface LiveBody {
  /** Lattice units, in its frame. */
  corners: [number, number][];
  /** Radius of a disc that it holds, m; 0 if it holds none. */
  inside: number;
  /** Radius of a disc that holds it, m. */
  around: number;
}

/** A number that JSON cannot hold or JavaScript would round is a string. */
type LiveNumber = number | string;

/** Everything about a run that an edit of its world leaves as it is. */
interface LiveRecipe {
  motion: string;
  /** s. */
  time_step: number;
  /** Overlap with a wall that is not reported, cells. */
  tolerance: number;
  /** Budget of the recorded run. */
  steps: number;
  /** What the budget of an edited world follows from: `step_budget` of sim/options/run.py. */
  budget: {
    factor: number;
    fewest: number;
    most: number;
    moved: boolean;
    drift: number;
    pushed: number;
    last_push: number;
  };
  /** Whether a recurrence of its state proves a loop. */
  finds_loops: boolean;
  /** Changes of cells: step, time within it (not under `stepped`), ix, iy, state. */
  events: number[][];

  // On the lattice.
  /** Name by which the core knows it. */
  controller: string;
  start_speed: LiveNumber;
  /** Those at reset that aren't zero. */
  memory: { size: number; numbers: [number, LiveNumber][] };
  /** Fields of WgSettings that aren't zero. */
  settings: Record<string, LiveNumber | LiveNumber[] | Record<string, LiveNumber>[]>;
  pushes: LiveNumber[][];
  decoys: LiveNumber[][];

  // Under `stepped`.
  /** Fields of WgThesisSettings. */
  setup: Record<string, LiveNumber>;
  /** Whether the noise filter changes the signal. */
  noise: boolean;
  seed: string;
  /** Random numbers before those of the seed. */
  draws: number[];
}

interface LiveAnswer {
  proof: LiveProof;
  /** Null without a recipe, and if the run cannot start. */
  run: LiveRun | null;
  /** Why there is no proof, or no run, in a sentence; empty if there is one. */
  live: { proof: string; run: string };
  /** Time that they took. */
  ms: { proof: number; run: number };
}

interface LiveProof {
  /** Null if it was not decided here. */
  reachable: boolean | null;
  reason: string;
  /** Corners of the path, in s and m; the radius of the largest disc that it lets through, m. */
  witness: { t: number[]; x: number[]; y: number[]; heading?: number[]; clearance: number } | null;
  /**
   * A chain of cells, row 0 the lowest, or boxes of poses as in worldgen.world.Cut; the radius above
   * which it stops every disc, m; and the waypoint that it stops, from 1, unless that is the target.
   */
  cut: { cells: CellPlace[]; clearance: number; boxes?: number[][]; waypoint?: number } | null;
}

interface LiveRun {
  verdict: string;
  /** Steps done; of a loop, until the end of its first period. */
  steps: number;
  /** s. */
  time: number;
  /** Steps that it was allowed. */
  budget: number;
  /** Step in which a loop begins; otherwise -1. */
  entry: number;
  /** Steps of a loop; otherwise 0. */
  period: number;
  /** 16 hex digits. */
  digest: string;
  /** m. */
  path_length: number;
  collisions: number;
  last_new_cell: number;
  /** The wall, fire or contact that decides the verdict. */
  hit: { step: number; cell: CellPlace } | null;
  /** What a controller that failed said. */
  error: string;
  /** As a failure's record holds it: sim/evidence.py. */
  evidence: Record<string, any>;
  /** Where it really begins. */
  start: Triple;
  /** For the player, already open. */
  drawn: DrawnRun;
}
