// What the server refuses, as data: { code, problem, remedy, terminal, opens, facts, line, source }; and how it reads.

/**
 * A refusal as a sentence: where, what came and the rule, the way out.
 * @param {Refusal} refusal
 * @returns {string}
 */
export function refusalWords({ problem, remedy, terminal, line, source }) {
  const place = source ? (line === null ? source : `${source}:${line}`) : line === null ? "" : `line ${line}`;
  const whole = remedy ? `${problem}; ${remedy}${terminal ? " (at a terminal)" : ""}` : problem;
  return place ? `${place}: ${whole}` : whole;
}

/** What the server objects to; `code` and `facts` say it to the page, `message` to its user. */
export class Refused extends Error {
  /* refusal    of the server's, or a sentence of the page's own */
  constructor(refusal) {
    const own = typeof refusal === "string";
    super(own ? refusal : refusalWords(refusal));
    this.code = own ? "" : refusal.code;
    this.facts = own ? {} : refusal.facts;
    this.opens = own ? "" : refusal.opens;
  }
}
