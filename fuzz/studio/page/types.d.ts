// Types of objects that the studio's scripts share; those of its messages are in messages.d.ts.
// Only `npm run check` reads this file.

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

/** The answer to `decide`, or a placeholder. */
interface Proof extends Partial<ProofMessage> {
  length: number;
  duration: number;
  clearance: number;
  error?: string;
  /** The witness, unpacked, and those of the other robots. */
  opened?: OpenWorld["witness"];
  openedOthers?: OpenWorld["others"];
}

/** A pending request, which can be stopped. */
interface Asked<T> extends Promise<T> {
  stop(): void;
}

interface Connection {
  /** Sends a request to the server; `part` is called with each part of the answer, and with the
   * digests of the user's files whose code has run. */
  ask<K extends keyof Messages>(
    kind: K,
    message?: Messages[K]["request"],
    part?: (part: Messages[K]["part"], code: Record<string, string>) => void,
  ): Asked<Messages[K]["answer"]>;
}

/** A world that can be chosen for a comparison. */
interface ChosenWorld extends ComparedWorld {
  name: string;
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
