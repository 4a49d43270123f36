// Types of what the server sends and of what the pages' scripts share. Only `npm run check` reads this file.

/** Whole numbers as `fuzz/player/streams.py` packs them. */
type Packed = string;

/** One bit a cell or row, in base64. */
type Bits = string;

/** A column and a row of cells. */
type CellPlace = [number, number];

/** A place and one more number: a heading in rad, or a radius. */
type Triple = [number, number, number];

/** A box of cells; (x, y) is its lower left cell. */
interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** Where a canvas looks: the cell in its middle, and pixels a cell. */
interface View {
  x: number;
  y: number;
  scale: number;
}

// What the server packs to be drawn: fuzz/player/worlds.py, runs.py, memory.py, sensors.py.

interface DrawnWorld {
  width: number;
  height: number;
  /** Side of a cell, m. */
  cell: number;
  /** Of the robot, in cells. */
  radius: number;
  cells: Bits;
  /** x and y in cells, heading in rad. */
  start: Triple;
  /** x, y and radius in cells. */
  target: Triple;
  events: { ms: Packed; ix: Packed; iy: Packed; state: Packed } | null;
  witness?: { ms: Packed; x: Packed; y: Packed } | null;
  cut?: CellPlace[] | null;
  /** What the page has unpacked; the server sends none. */
  open?: OpenWorld;
}

interface OpenWorld {
  cells: Uint8Array;
  events: { ms: Float64Array; ix: Float64Array; iy: Float64Array; state: Float64Array } | null | undefined;
  witness?: { ms: Float64Array; x: Float64Array; y: Float64Array } | null;
  /** Cells at some time, and how many events are in them. */
  now?: Uint8Array | null;
  done: number;
  /** Of a world that is being drawn: a box with all cells changed after a version, null for all of them. */
  boxSince?: (version: number) => Box | null;
}

/** A world of which only what is needed to draw it is there. */
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
  at: Packed;
  x: Packed;
  y: Packed;
  heading: Packed;
  bump: Bits;
  active?: Packed | null;
  behaviours?: string[];
  memory: DrawnMemory | null;
  breached: boolean;
  /** One in how many steps is there, at the coarsest. */
  thinned: number;
  /** Entry and period. */
  loop: [number, number] | null;
  marks: Mark[];
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
  pierced?: Map<string, { ix: number; iy: number; step: number; named: boolean }>;
  touched?: Map<string, { ix: number; iy: number; step: number }>;
  numbered?: number[];
}

interface DrawnMemory {
  fields: { name: string; words: string[]; least: number; values: Packed }[];
  map: (Record<"kind" | "x0" | "y0" | "x1" | "y1" | "since" | "until", Packed> & { names: string[] }) | null;
  fault: string;
  open?: {
    fields: Float64Array[];
    map: Record<string, Float64Array> | null;
  };
}

interface Sensors {
  beams: number;
  /** Longest beam, in cells. */
  range?: number;
  /** Angle between the first and the last beam, rad; 0 for all around. */
  field?: number;
  signal: boolean;
}

/** A robot's result, with its run if it has one. */
interface Robot {
  name: string;
  verdict: string;
  /** What the verdict rests on; empty if the robot arrived. */
  why: string;
  steps: number;
  time: number;
  path: number;
  collisions: number;
  digest: string;
  run: DrawnRun | null;
  sensors: Sensors | null;
  /** Why it did not drive. */
  error?: string;
}

interface ReplayData {
  title: string;
  world: DrawnWorld | null;
  robots: Robot[];
}

// What the report's page holds: fuzz/report/page.py, gather.py, summary.py.

/** A world with its run and its file. */
interface DrawnFailure {
  name: string;
  file: string;
  size: string;
  solid: number;
  events: number;
  kind: string;
  world: DrawnWorld | null;
  run: DrawnRun | null;
  sensors: Sensors | null;
}

interface ReportFailure {
  id: string;
  kind: string;
  verdict: string;
  controller: string;
  motion: string;
  solid: number;
  size: string;
  cells: number;
  met: number | null;
  lane: string;
  /** Which of the page's campaigns; -1 for none. */
  campaign: number;
  confirmed: boolean;
  words: string;
  reason: string;
  path: string;
  replay: string;
  groups: [string, [string, string][]][];
  now: DrawnFailure;
  before: DrawnFailure | null;
}

interface ReportCampaign {
  folder: string;
  controller: string;
  motion: string;
  seed: string;
  units: number;
  worlds: number;
  steps: number;
  seconds: number;
  found: { kind: string; lane: string; unit: number; solid_cells: number; worlds: number; steps: number; seconds: number }[];
  lanes: { lane: string; units: number; worlds: number; steps: number; failures: number; classes: number }[];
  met: Record<string, number>;
  verdicts: Record<string, number>;
  archive: Archive | null;
}

interface ReportData {
  title: string;
  failures: ReportFailure[];
  campaigns: ReportCampaign[];
  others: number;
}

/** The report's list of failures. */
interface Overview {
  redraw(): void;
  /** Ids of the failures that are shown, in order. */
  shown(): string[];
}

/** Ids of the failures before and after one, if there are any. */
type Neighbours = [string | undefined, string | undefined];

/** The report's view of one failure. */
interface Detail {
  player(): Player | null;
  /** Shows the world before shrinking, or after. */
  swap(): void;
  redraw(): void;
}

/** The behaviours that a campaign has met. */
interface Archive {
  /** Of its two axes. */
  names: [string, string];
  edges: [number[], number[]];
  /** Column, row, quality and verdict of each kind that was met. */
  cells: [number, number, number, string][];
}

// What the player shares.

/** A canvas that is spoken to in cells. */
interface Pen {
  context: CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D;
  width: number;
  height: number;
  scale: number;
  snap(value: number): number;
  px(value: number): number;
  py(value: number): number;
  colours: Record<string, string>;
}

interface Pose {
  x: number;
  y: number;
  heading: number;
  bump: boolean;
  row: number;
}

type Layer = "trail" | "witness" | "sensors" | "signal" | "touched" | "memory";

/** What a scene shows; `grid` is shown unless it is false. */
type Shown = Partial<Record<Layer | "grid", boolean>>;

interface OtherRobot {
  run: DrawnRun;
  colour: string;
  number: number;
}

interface Scene {
  world: SceneWorld;
  run?: DrawnRun | null;
  /** Time, in steps. */
  step?: number;
  show: Shown;
  sensors?: Sensors | null;
  /** Of this robot, if there are several: the name of a colour in the palette. */
  colour?: string | null;
  /** Of this robot, if there are several: it is written next to the robot. */
  number?: number | null;
  others?: OtherRobot[];
  /** The whole path is drawn as driven, as in small pictures. */
  whole?: boolean;
}

/** A scene of a robot's run. */
type RunScene = Scene & { run: DrawnRun; step: number };

/** What a player plays. */
interface Drawn {
  world: DrawnWorld;
  run: DrawnRun | null;
  sensors?: Sensors | null;
  colour?: string | null;
  number?: number | null;
  others?: OtherRobot[];
  name?: string;
  /** Why there is no run. */
  why?: string;
  /** What this page can save: pairs of words and what to do. */
  saves?: [string, () => Promise<string | void>][];
  stopSaving?: () => void;
  /** Another run that is played in step. */
  beside?: Beside | null;
}

interface Beside {
  canvas: HTMLCanvasElement;
  world: DrawnWorld;
  run: DrawnRun | null;
  sensors?: Sensors | null;
  /** What is written on the two: of the other one, and of the one in front. */
  words: string[];
}

interface Player extends Clock, Camera {
  drawn: Drawn;
  canvas: HTMLCanvasElement;
  step: number;
  last: number;
  playing: boolean;
  /** Plays only the period of a loop. */
  period: boolean;
  speed: number;
  show: Record<Layer, boolean>;
  /** Called after each frame while a file of both runs is made. */
  drawnMore: (() => void) | null;
  /** Null for the whole world. */
  view: View | null;
  follow: boolean;
  draw(): void;
  update(): void;
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
  move(dx: number, dy: number): void;
}

/** What each key does, by its name. */
type Keys = Record<string, () => void>;

/** A row of the table of keys: the keys, as one text or one by one, and what they do. */
type KeyRow = [string | string[], string];

/** What an element may hold; null and undefined are left out. */
type Content = Node | string | number | null | undefined | false | Content[];

/** Which rows of a line are drawn, and how. */
interface LineLook {
  from: number;
  to: number;
  colour: string;
  width: number;
  alpha: number;
  /** No picture of it is kept. */
  once?: boolean;
}
