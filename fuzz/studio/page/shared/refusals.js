// Refusals of the server as data, { code, problem, remedy, terminal, opens, facts, line,
// source }, and as sentences.

/**
 * Returns a refusal as a sentence: the place, the problem, the remedy.
 * @param {Refusal} refusal
 * @returns {string}
 */
export function refusalWords(refusal) {
  const { problem, remedy, terminal, line, source } = refusal;
  const failed = codeWords(refusal);
  if (failed) return failed;
  const place = source ? (line === null ? source : `${source}:${line}`) : line === null ? "" : `line ${line}`;
  const whole = remedy ? `${problem}; ${remedy}${terminal ? " (at a terminal)" : ""}` : problem;
  return place ? `${place}: ${whole}` : whole;
}

// Returns where and how the user's code failed; empty if the refusal is about something else.
function codeWords({ code, facts, frames }) {
  const place = frames?.at(-1);
  return code === "code-failed" && place ? `${place.file}:${place.line}: ${facts.kind}: ${facts.reason}` : "";
}

/** A refusal of the server; `code` and `facts` are for the page, `message` is for the user. */
export class Refused extends Error {
  /* refusal    the server's, or a sentence from the page itself */
  constructor(refusal) {
    const own = typeof refusal === "string";
    super(own ? refusal : refusalWords(refusal));
    this.code = own ? "" : refusal.code;
    this.facts = own ? {} : refusal.facts;
    this.opens = own ? "" : refusal.opens;
  }
}
