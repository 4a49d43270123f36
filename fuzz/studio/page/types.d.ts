// Types of objects that the studio's scripts share; those of its messages are in messages.d.ts.
// Only `npm run check` reads this file.

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
  model: import("#player/edit/model.js").Model;
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

