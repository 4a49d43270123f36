// The state of a campaign: its progress, its speed, its failures,
// and the strategies that find them.

import { rangeOf } from "#player/archive.js";
import { causeWords, el, grouped, plural, verdictDot } from "#player/dom.js";
import { refusalWords } from "#studio/shared/refusals.js";

const SPAN = 10_000; // ms over which the current speed is measured
const ACTIVITIES = { preparing: "Preparing", searching: "Searching", shrinking: "Shrinking", explaining: "Explaining", stopped: "Stopped", done: "Done", "gave-up": "Gave up" };
// What became of a cause; only kept ones have a picture.
const FATES = { kept: "", known: "known", waiting: "to be shrunk", lost: "not kept", unread: "…" };

/**
 * @param {any} campaign
 * @returns {any}
 */
export function makeStatus(campaign) {
  const parts = {
    actions: el("div", { class: "actions" }),
    line: el("p", { class: "progress-line", id: "progress-line" }),
    bar: el("progress", { max: 1, value: 0, "aria-labelledby": "progress-line" }),
    causes: el("tbody", {}),
    strategies: el("tbody", {}),
    fault: el("p", { class: "notice", role: "alert", hidden: true }),
    best: el("p", { class: "best-line", id: "best-so-far" }),
    conclusion: el("section", { class: "conclusion", id: "conclusion", tabindex: "0", "aria-label": "What it found out", hidden: true }),
  };
  const table = (title, names, body) =>
    el(
      "div",
      { class: "scrolls", tabindex: "0", role: "region", "aria-label": title },
      el("table", { class: "counts" }, el("thead", {}, el("tr", {}, names.map((name) => el("th", { scope: "col" }, name)))), body),
    );
  parts.tables = el(
    "div",
    { class: "tables" },
    table("Failures by cause", ["Cause", "Met", "Smallest"], parts.causes),
    table("Strategies", ["Strategy", "Worlds", "Failed", "New variants"], parts.strategies),
  );
  const element = el("div", { class: "status-part" }, parts.line, parts.bar, parts.conclusion, parts.best, parts.fault, parts.tables);
  const status = { campaign, parts, past: [], strategies: new Map(), state: null, smallest: null, offered: "null" };
  // until a campaign is shown
  for (const part of [parts.line, parts.bar, parts.best, parts.tables]) part.hidden = true;
  return {
    element,
    actions: parts.actions,
    show: (state) => show(status, state),
    sizes: (smallest) => {
      // the simplest of each cause, the worst first; null while the folder is being read
      status.smallest = smallest;
      if (status.state) showFailures(status);
    },
  };
}

// Shows everything about failures, by the same causes: the line, the table, and the best one.
function showFailures(status) {
  const causes = causesOf(status);
  status.parts.line.replaceChildren(...line(status, causes));
  showCauses(status, causes);
  showBest(status);
}

function show(status, state) {
  const { parts } = status;
  if (!state || status.state?.folder !== state.folder) Object.assign(status, { past: [], strategies: new Map() });
  status.state = state;
  for (const part of [parts.line, parts.bar, parts.best, parts.tables]) part.hidden = !state;
  const told = state ? faultWords(state) : "";
  parts.fault.hidden = told === "";
  showActions(status);
  showConclusion(status);
  if (!state) return;
  parts.fault.textContent = told;
  parts.bar.value = share(state);
  parts.bar.hidden = !state.running;
  showFailures(status);
  const now = strategiesNow(status);
  const mark = (name) => (now.has(name) ? [name, el("b", { class: "now" }, " now")] : name);
  /** @type {(strategy: CampaignState["strategies"][0]) => [Content, ...Content[]]} */
  const row = (strategy) => [mark(strategy.strategy), strategy.worlds, strategy.failures, strategy.variants];
  parts.strategies.replaceChildren(...[...state.strategies].sort((a, b) => b.variants - a.variants || b.worlds - a.worlds).map((strategy) => rowOf(row(strategy))));
  parts.tables.hidden = state.strategies.length === 0;
}

// Shows what a campaign that has ended found out, as the terminal does: does it work, why, what to
// check. A cause's name shows its failures only.
function showConclusion({ state, parts, campaign }) {
  const told = state?.conclusion ?? null;
  parts.conclusion.hidden = !told;
  if (!told) return;
  const { headline, rate, causes, others, comparison } = told;
  const name = ({ cause, file }) => {
    const words = causeWords(cause);
    return file ? el("button", { type: "button", class: "link", onclick: () => campaign.openFile(file) }, words) : el("b", {}, words);
  };
  const item = (one) =>
    el(
      "li",
      {},
      el("p", {}, name(one), one.is_new ? el("b", { class: "now" }, " new") : "", el("span", { class: "quiet" }, ` ${one.often}`)),
      el("p", {}, one.sentence),
      one.why ? el("p", { class: "quiet" }, `In its example it ${one.why}.`) : null,
    );
  parts.conclusion.replaceChildren(
    el("p", { class: "headline", "data-tone": headline.tone }, headline.who ? `${headline.who}: ` : "", el("b", {}, headline.words), headline.rest),
    rate ? el("p", {}, rate) : "",
    el("ol", {}, causes.map(item)),
    others ? el("p", { class: "quiet" }, others) : "",
    comparison ? el("p", { class: "quiet" }, comparison) : "",
  );
}

// Shows why a campaign gave up, or that its code has been edited since it started.
function faultWords({ error, edited, running }) {
  if (error) return refusalWords(error);
  if (!edited) return "";
  const rest = running ? "this campaign continues with the code from when it started" : "these results come from the old code";
  return `The controller's file has changed since this campaign began: ${rest}. Start another one to test the new code.`;
}

// Returns the strategies whose counts have grown in the last seconds; if none has, those that grew
// last, because a unit may take a while.
function strategiesNow({ state, strategies }) {
  if (!state.running) return new Set();
  const now = performance.now(),
    first = strategies.size === 0;
  for (const { strategy, worlds, units } of state.strategies) {
    const before = strategies.get(strategy),
      counted = worlds + units;
    if (!before || before.counted !== counted) strategies.set(strategy, { counted, grew: first ? 0 : now });
  }
  const last = Math.max(0, ...[...strategies.values()].map(({ grew }) => grew));
  return new Set([...strategies].filter(([, { grew }]) => grew > 0 && grew >= Math.min(last, now - SPAN)).map(([name]) => name));
}

// Shows the worst failure or, before there is one, the longest path
// that a robot took to its target.
function showBest({ state, smallest, parts, campaign }) {
  const [best] = (smallest || new Map()).values();
  parts.best.hidden = false;
  if (best) {
    const open = el("button", { type: "button", class: "link", onclick: () => campaign.wall.choose(best) }, causeWords(best.group));
    parts.best.replaceChildren(el("span", {}, "Best so far:"), open, el("span", {}, `${best.width} x ${best.height} cells, ${best.solid} solid`));
    return;
  }
  const longest = longestWay(state.archive);
  const met = Object.keys(state.met).length > 0; // some are still to be shrunk, or known
  parts.best.replaceChildren(longest && !met ? `No failure yet. Longest path so far: ${longest} times the straight line` : "");
  parts.best.hidden = !longest || met;
}

// Returns the range of the longest detour among runs that arrived; empty if unknown.
function longestWay(archive) {
  if (!archive || archive.names[0] !== "detour") return "";
  const [edges] = archive.edges;
  const last = Math.max(-1, ...archive.cells.filter(([, , , verdict]) => verdict === "reached").map(([i]) => i));
  return last < 0 ? "" : rangeOf(edges, last);
}

function rowOf([name, ...cells]) {
  const cell = (value) => el("td", {}, typeof value === "number" ? grouped(value) : value);
  return el("tr", {}, el("th", { scope: "row" }, name), cells.map(cell));
}

// Returns the share of the budget that is done, from 0 to 1.
function share({ budget, units, elapsed }) {
  if (budget.units) return Math.min(1, units / budget.units);
  return budget.seconds && elapsed !== null ? Math.min(1, elapsed / budget.seconds) : 0;
}

function line(status, causes) {
  const { state, campaign, smallest } = status;
  const met = Object.values(state.met).reduce((sum, times) => sum + times, 0);
  const facts = [
    [grouped(state.worlds), "worlds"],
    [short(state.steps), "steps"],
    state.running ? [grouped(state.failed), "not arrived"] : [grouped(met), met === 1 ? "failure met" : "failures met"],
    ...(smallest ? [[grouped(causes.length), countWords(causes)]] : []),
    [grouped(speed(status)), state.running ? "worlds/s now" : "worlds/s"],
  ];
  const doing = campaign.stopping === state.folder && state.running ? "Stopping" : activityWords(state);
  return [
    el("b", { class: state.running ? "good" : "", id: "campaign-state" }, doing),
    el("span", {}, `${state.controller} under ${state.motion}, seed ${state.seed}`),
    el("span", {}, budgetWords(state)),
    ...facts.map(([value, words]) => el("span", {}, el("b", {}, value), ` ${words}`)),
  ];
}

// Shows what a campaign is doing, or how it ended. Shrinking also runs during the search.
function activityWords({ activity, shrinking, running, answer }) {
  if (!running && activity === "done" && answer === "none") return "Done without an answer";
  return activity === "shrinking" && shrinking > 0 ? `Shrinking ${plural(shrinking, "failure")}` : ACTIVITIES[activity];
}

function budgetWords({ budget, units, running, elapsed, activity }) {
  if (activity === "preparing") return `loading simulator and controller; ${budget.units ? `${plural(budget.units, "unit")} follow` : `the ${budget.seconds} s begin after that`}`;
  if (activity === "explaining") return "running natural worlds, and trying what the failures depend on";
  if (budget.units) return `unit ${units} of ${budget.units}`;
  if (!running || elapsed === null) return `${budget.seconds} s`;
  return elapsed > budget.seconds ? `the ${budget.seconds} s are over; finishing current work` : `${Math.round(elapsed)} of ${budget.seconds} s`;
}

function short(count) {
  if (count < 1e6) return grouped(count);
  return count < 1e9 ? `${(count / 1e6).toFixed(1)} million` : `${(count / 1e9).toFixed(2)} billion`;
}

// Returns worlds per second: over the last seconds while it runs, else over its whole time.
function speed({ state, past }) {
  if (!state.running) return state.seconds > 0 ? state.worlds / state.seconds : 0;
  const now = performance.now();
  if (past.at(-1)?.worlds !== state.worlds || past.length === 0) past.push({ now, worlds: state.worlds });
  while (past.length > 2 && now - past[0].now > SPAN) past.shift();
  const [first, last] = [past[0], past.at(-1)];
  if (last.now - first.now > 800) return (last.worlds - first.worlds) / ((last.now - first.now) / 1000);
  return state.seconds > 0 ? state.worlds / state.seconds : 0;
}

/* Returns the causes, those met most often first. Some are only in natural worlds, which the search
   never tried. Of each { name, times, best, fate }: fate is one of FATES. */
function causesOf({ state, smallest, campaign }) {
  const kept = smallest || new Map();
  const natural = [...kept.keys()].filter((name) => !Object.hasOwn(state.met, name)).map((name) => [name, 0]);
  const fateOf = (name) => {
    if (kept.has(name)) return "kept";
    if (state.known[name]) return "known";
    if (state.running) return "waiting";
    return campaign.read === state.failures ? "lost" : "unread"; // the folder is still being read
  };
  const rows = [...Object.entries(state.met), ...natural].sort(([, a], [, b]) => b - a);
  return rows.map(([name, times]) => ({ name, times, best: kept.get(name), fate: fateOf(name) }));
}

// Describes the causes without a picture, such as "causes: 1 known, 2 to be shrunk".
function countWords(causes) {
  const counts = ["known", "waiting", "lost"].map((wanted) => [FATES[wanted], causes.filter(({ fate }) => fate === wanted).length]);
  const words = counts.filter(([, count]) => count > 0).map(([fate, count]) => `${count} ${fate}`);
  return `${causes.length === 1 ? "cause" : "causes"}${words.length > 0 ? `: ${words.join(", ")}` : ""}`;
}

function showCauses({ parts, campaign }, causes) {
  parts.causes.replaceChildren(
    ...causes.map(({ name, times, best, fate }) => {
      const show = el("button", { type: "button", class: "link", title: "Show only these", onclick: () => campaign.wall.only(name) }, causeWords(name));
      const size = best ? `${best.width} x ${best.height}, ${best.solid} solid` : FATES[fate];
      const kind = el("span", { class: "kind" }, verdictDot(best ? best.verdict : ""), best ? show : causeWords(name));
      return rowOf([kind, times || "not by the search", size]);
    }),
  );
}

// Shows Stop while the campaign runs or begins, and Resume or Continue with an amount otherwise.
function showActions(status) {
  const { state, parts, campaign } = status;
  const stopping = Boolean(state?.running) && campaign.stopping === state.folder,
    beginning = Boolean(state) && !state.running && campaign.beginning.has(state.folder);
  // Rebuilds the buttons only if the choices change, so that a typed amount stays.
  const offered = JSON.stringify(state && [state.running, stopping, beginning, state.running ? "" : state.folder, state.running || beginning ? 0 : state.units]);
  if (status.offered === offered) return;
  status.offered = offered;
  if (!state) parts.actions.replaceChildren();
  else if (beginning) parts.actions.replaceChildren(haltButton(campaign, state.folder));
  else if (state.running) parts.actions.replaceChildren(stopButton(campaign.stop, stopping));
  else parts.actions.replaceChildren(...goOnPart(state, campaign));
}

function haltButton(campaign, folder) {
  const halt = () => {
    button.disabled = true;
    campaign.halt(folder);
  };
  const button = stopButton(halt);
  return button;
}

function stopButton(onclick, disabled = false) {
  return el("button", { type: "button", id: "stop", disabled, onclick, title: "Everything found so far is kept" }, "Stop");
}

function goOnPart(state, campaign) {
  const byUnits = state.budget.units !== null;
  const left = byUnits && state.units < state.budget.units;
  const usual = byUnits ? (left ? state.budget.units : 2 * state.budget.units) : state.conclusion?.more_seconds || state.budget.seconds;
  const amount = el("input", { type: "number", id: "go-on-amount", value: usual, min: byUnits ? Math.max(1, state.units) : 1, step: 1 });
  const go = () => {
    const value = amount.valueAsNumber;
    if (value > 0) campaign.goOn({ [byUnits ? "units" : "seconds"]: Math.round(value), known: true, workers: campaign.form.workers() });
  };
  const button = el("button", { type: "button", id: "go-on", onclick: go }, left ? "Resume" : "Continue");
  return [button, el("label", { class: "field" }, byUnits ? "to unit" : "for, s", amount)];
}
