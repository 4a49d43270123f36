// The first screen: does it work, how bad is it, why, and what to do.

import { causeWords, el, grouped, plural, unfinished, verdictDot } from "#player/dom.js";
import { legendOfCells } from "#player/legend.js";
import { drawSmall, pictureLabel } from "#player/picture/map.js";
import { copyButton } from "#report/copy.js";
import { insidePart, reactionsPart } from "#report/inside.js";

// A severity has the colour of its typical verdict.
/** @type {Record<string, string>} */
export const COLOURS = {
  "through-walls": "tunnel",
  "through-robots": "tunnel",
  "controller-error": "crash",
  harmed: "burned",
  "never-arrives": "loop",
  "too-slow": "timeout",
  questionable: "oracle",
  unsensed: "burned",
};

// Causes that can depend on a wall or a number, unlike an error in the controller or a rule set by
// the user.
const EXPLAINED = new Set(["through-walls", "harmed", "never-arrives", "too-slow"]);

// Causes that are described; the names of the others follow. One of them at a time has its example,
// so that everything fits on one screen.
const MOST_SHOWN = 3;

/**
 * Fills the section with the answer for each controller.
 * @param {HTMLElement} section
 * @param {ReportData} data
 * @returns {{ redraw(): void }}
 */
export function makeAnswer(section, data) {
  const all = [...data.failures, ...data.extras];
  const find = (path) => all.find((failure) => failure.path === path);
  const several = data.answers.length > 1;
  const redraw = () => {
    for (const canvas of section.querySelectorAll("canvas")) {
      const failure = all.find((one) => one.id === canvas.dataset.id);
      const drawn = failure && failure[canvas.dataset.which === "before" ? "before" : "now"];
      if (drawn) drawSmall(canvas, drawn, { touched: true, cells: true });
    }
  };
  const parts = data.answers.map((answer) => answerPart(answer, find, several, data.campaigns[answer.campaign], redraw));
  section.replaceChildren(several ? controllersTable(data.answers, parts) : "", ...parts);
  return { redraw };
}

// The first screen of a report of several controllers: how often each arrives, and its worst cause,
// in the order of the parts below.
function controllersTable(answers, parts) {
  const row = ({ controller, motion, natural, causes }, k) => {
    const [worst] = causes.filter(isCounted).concat(causes.filter(isMet));
    const show = () => parts[k].scrollIntoView();
    return el(
      "tr",
      {},
      el("th", { scope: "row" }, el("button", { type: "button", class: "small", onclick: show }, `${controller} under ${motion}`)),
      el("td", {}, natural?.worlds ? `${natural.percent} % of ${grouped(natural.worlds)}` : "not measured"),
      el("td", {}, worst ? [verdictDot(COLOURS[worst.severity]), ` ${causeWords(worst.cause)}`] : "none"),
      el("td", {}, grouped(causes.length)),
    );
  };
  const heads = ["Controller", "Arrives in natural worlds", "Worst cause", "Causes"];
  return el(
    "div",
    { class: "scroll", tabindex: "0", role: "group", "aria-label": "Controllers" },
    el("table", { class: "rows controllers" }, el("thead", {}, el("tr", {}, heads.map((words) => el("th", { scope: "col" }, words)))), el("tbody", {}, answers.map(row))),
  );
}

function answerPart(answer, find, several, campaign, redraw) {
  const own = answer.causes.filter(isCounted);
  const causes = own.length ? own : answer.causes.filter(isMet);
  const others = answer.causes.filter((cause) => !causes.includes(cause));
  const shown = causes.slice(0, MOST_SHOWN).map((cause) => makeCause(cause, answer, find(cause.file)));
  const choose = (chosen) => {
    for (const one of shown) one.open(one === chosen);
    redraw();
  };
  for (const one of shown) one.button.addEventListener("click", () => choose(one));
  const examples = shown.filter(({ button }) => !button.hidden);
  choose(examples[0]);
  if (examples.length === 1) examples[0].button.hidden = true; // there is nothing to choose
  return el(
    "div",
    { class: "answer" },
    several ? el("h2", {}, `${answer.controller} under ${answer.motion}`) : null,
    el(
      "div",
      { class: "answer-two" },
      el(
        "div",
        {},
        verdictPart(answer),
        el("ol", { class: "causes" }, shown.map(({ item }) => item)),
        causes.length > MOST_SHOWN ? morePart(causes.slice(MOST_SHOWN), find) : null,
        others.length ? othersPart(others, find) : null,
        survivorsPart(campaign),
        unrunPart(campaign),
        campaign?.changed ? el("p", { class: "notice" }, `${campaign.changed}.`) : null,
        answer.comparison ? el("p", { class: "quiet" }, capital(`${answer.comparison.sentence}.`)) : null,
        answer.natural && answer.natural.worlds ? coverage(answer.natural) : null,
      ),
      ...shown.map(({ example }) => example),
    ),
    el("div", { class: "evidence" }, reactionsPart(answer.reactions, "What it does by what is around it, in all runs of this report (steps at nearly the same pose count once in each)")),
  );
}

// The controller's own causes count, if a world that nobody shrunk shows them.
function isCounted(cause) {
  return cause.severity !== "unsensed" && isMet(cause);
}

// A world of the search or a natural one shows it, and not only a shrunk one.
function isMet(cause) {
  return cause.met > 0 || cause.natural > 0;
}

function morePart(causes, find) {
  return namesPart(`And ${plural(causes.length, "more cause")}`, causes, find, verdictsOf);
}

function othersPart(causes, find) {
  return namesPart("Not counted", causes, find, (cause) =>
    isMet(cause) ? verdictsOf(cause) : "only in worlds that shrinking made",
  );
}

function namesPart(words, causes, find, noteOn) {
  const part = (cause) => {
    const failure = find(cause.file);
    const name = causeWords(cause.cause);
    const remark = noteOn(cause);
    return [failure ? el("a", { href: `#${failure.id}` }, name) : name, remark ? ` (${remark})` : ""];
  };
  return el("p", { class: "quiet" }, `${words}: `, ...causes.flatMap((cause, index) => [index ? "; " : "", ...part(cause)]), ".");
}

function verdictsOf(cause) {
  const met = Object.entries(cause.verdicts).filter(([, count]) => count);
  return met.map(([verdict, count]) => `${grouped(count)} ${verdict}`).join(", ");
}

// The first line of the answer that terminal and studio give, too.
function verdictPart({ headline, natural }) {
  const { words, rest, tone, more } = headline;
  const isAnswer = Boolean(COLOURS[tone]);
  const colour = isAnswer ? COLOURS[tone] : tone === "clean" ? "reached" : "timeout";
  const whole = isAnswer ? (words.startsWith("its ") ? words : `it ${words}`) : `${words}${rest}`;
  return el(
    "div",
    {},
    el("p", { class: "headline", "data-verdict": colour }, `${tone === "clean" ? "✓ " : ""}${capital(whole)}.`),
    natural && natural.worlds ? ratePart(natural) : null,
    more ? [el("p", {}, "Give it more time:"), el("div", { class: "command" }, el("code", {}, more), copyButton("Copy", () => more))] : null,
  );
}

// How often it arrives in natural worlds, as a sentence and as a bar with the interval.
function ratePart(natural) {
  const [low, high] = [natural.low, natural.high].map((share) => Math.round(100 * share));
  const bar = el("span", { class: "rate", role: "img", "aria-label": `95 % interval: ${low} % to ${high} %` });
  const range = el("i", { class: "range" }),
    point = el("i", { class: "point" });
  range.style.left = `${100 * natural.low}%`;
  range.style.width = `${Math.max(1, 100 * (natural.high - natural.low))}%`;
  point.style.left = `${100 * natural.share}%`;
  bar.append(range, point);
  const unsensed = natural.unsensed ? ` ${natural.unsensed} more ${natural.unsensed === 1 ? "has" : "have"} hazards that it cannot sense.` : "";
  return el(
    "p",
    { class: "rate-line" },
    el("b", {}, `Arrives in ${natural.percent} %`),
    ` of ${plural(natural.worlds, "natural world")} (95 %: ${low} to ${high} %) `,
    bar,
    el("span", { class: "quiet" }, unsensed),
  );
}

function coverage(natural) {
  const tried = Object.keys(natural.families).filter((name) => natural.families[name].worlds > 0);
  return el(
    "p",
    { class: "quiet" },
    `Natural worlds are those of families at default settings: ${tried.join(", ")}.`,
    natural.never.length ? ` Never tried: ${natural.never.join("; ")}.` : "",
  );
}

/* Makes a cause: its item in the list, the button that opens its example, and the example's pictures
   and evidence, which have places of their own. */
function makeCause(cause, answer, failure) {
  const often = [];
  if (answer.natural && answer.natural.worlds && cause.natural !== null && cause.severity !== "unsensed")
    often.push(`${cause.natural || "none"} of ${plural(answer.natural.worlds, "natural world")}`);
  often.push(cause.met > 0 ? `examined: ${verdictsOf(cause)}` : "not met by the search");
  const name = causeWords(cause.cause);
  const button = el("button", { type: "button", class: "small", hidden: !failure, "aria-label": `Example of ${name}` }, "Example");
  const more = el("div", { class: "folded" }, whyPart(cause, failure), failure ? commandPart(failure) : null);
  const example = el(
    "div",
    { class: "example folded" },
    failure ? [el("h3", { class: "on-paper" }, name), picturePart(failure), el("div", { class: "evidence" }, insidePart(failure.inside))] : null,
  );
  const item = el(
    "li",
    { class: "cause" },
    el(
      "div",
      { class: "line" },
      verdictDot(COLOURS[cause.severity]),
      failure ? el("a", { href: `#${failure.id}`, class: "name" }, name) : el("span", { class: "name" }, name),
      cause.state === "new" ? el("span", { class: "new" }, "new") : null,
      el("span", { class: "quiet" }, often.join("; ")),
      button,
    ),
    el("p", {}, `${cause.sentence} ${cause.advice}`),
    cause.fault ? el("p", { class: "why" }, el("code", {}, cause.fault)) : null,
    failure?.onMap ? el("p", { class: "why" }, `${failure.onMap}.`) : null,
    more,
  );
  const open = (is) => {
    more.hidden = example.hidden = !is && failure !== undefined;
    button.setAttribute("aria-pressed", String(is));
  };
  return { item, button, example, open };
}

// State that a class keeps from one run to the next is a fault of its own, whatever else it does.
function survivorsPart(campaign) {
  const names = campaign?.survives_reset ?? [];
  if (!names.length) return null;
  return el("p", { class: "notice" }, `State of the controller survives reset(): ${names.join(", ")}. Clear it there, or a run depends on the runs before it.`);
}

// Code that no world has run is code that nobody has tried.
function unrunPart(campaign) {
  const lines = campaign?.unrun_lines ?? [];
  if (!lines.length) return null;
  return el("p", { class: "notice" }, `Lines of the controller that never ran in any world: ${lines.join(", ")}.`);
}

// A failure that no change explains gets no sentence; if the campaign had no time to try, show the
// command that does.
function whyPart(cause, failure) {
  const known = [cause.repeats || (failure ? failure.repeats : ""), cause.why].filter(Boolean);
  const who = failure && failure.now.others?.length ? "the fleet" : "it";
  if (known.length) return el("p", { class: "why" }, `In its example ${who} ${known.join(". It ")}.`);
  if (!failure || !EXPLAINED.has(cause.severity)) return null;
  return el("p", { class: "why" }, "What it depends on: ", el("code", {}, failure.explain));
}

function commandPart(failure) {
  return el(
    "div",
    { class: "command" },
    el("code", {}, `${failure.replay} --show`),
    copyButton("Copy", () => `${failure.replay} --show`),
    copyButton("Copy test", () => failure.test),
  );
}

function picturePart(failure) {
  const figure = (drawn, which, words) =>
    el(
      "figure",
      {},
      el(
        "a",
        { href: `#${failure.id}`, "aria-label": `${words}: play it` },
        el("canvas", { "data-id": failure.id, "data-which": which, role: "img", "aria-label": pictureLabel(drawn) }),
      ),
      el("figcaption", {}, words, legendOfCells(drawn)),
    );
  const state = unfinished(failure.shrinking) || "shrunk";
  const now = `${state.charAt(0).toUpperCase()}${state.slice(1)}: ${failure.now.size} cells, ${grouped(failure.now.solid)} solid`;
  return el(
    "div",
    { class: "pictures" },
    failure.now.world ? figure(failure.now, "now", now) : null,
    failure.before && failure.before.world
      ? figure(failure.before, "before", `As found: ${failure.before.size} cells`)
      : null,
  );
}

function capital(text) {
  return text.charAt(0).toUpperCase() + text.slice(1);
}
