// What a campaign does now: how far it is, how fast, what fails, and which lane finds it.

import { el, grouped, plural, verdictDot } from "/player/dom.js";

const SPAN = 10_000; // ms over which the present speed is taken

export function makeStatus(campaign) {
  const parts = {
    actions: el("div", { class: "actions" }),
    line: el("p", { class: "progress-line", id: "progress-line" }),
    bar: el("progress", { max: 1, value: 0, "aria-labelledby": "progress-line" }),
    classes: el("tbody", {}),
    lanes: el("tbody", {}),
    fault: el("p", { class: "notice", role: "alert", hidden: true }),
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
    table("Failures by class", ["Class", "Met", "Smallest"], parts.classes),
    table("Lanes", ["Lane", "Units", "Worlds", "Failed", "New"], parts.lanes),
  );
  const element = el("div", { class: "status-part" }, parts.line, parts.bar, parts.fault, parts.tables);
  const status = { campaign, parts, past: [], state: null, smallest: new Map() };
  return {
    element,
    actions: parts.actions,
    show: (state) => show(status, state),
    sizes: (smallest) => {
      status.smallest = smallest;
      if (status.state) showClasses(status);
    },
  };
}

function show(status, state) {
  const { parts } = status;
  if (!state || status.state?.folder !== state.folder) status.past = [];
  status.state = state;
  for (const part of [parts.line, parts.bar, parts.tables]) part.hidden = !state;
  parts.fault.hidden = !(state && state.fault);
  showActions(status);
  if (!state) return;
  parts.fault.textContent = state.fault;
  parts.bar.value = share(state);
  parts.bar.hidden = !state.running;
  parts.line.replaceChildren(...line(status));
  showClasses(status);
  const row = (lane) => [lane.lane, lane.units, lane.worlds, lane.failures, lane.classes];
  parts.lanes.replaceChildren(...[...state.lanes].sort((a, b) => b.classes - a.classes || b.worlds - a.worlds).map((lane) => rowOf(row(lane))));
  parts.tables.hidden = state.lanes.length === 0;
}

function rowOf([name, ...cells]) {
  const cell = (value) => el("td", {}, typeof value === "number" ? grouped(value) : value);
  return el("tr", {}, el("th", { scope: "row" }, name), cells.map(cell));
}

// How much of the goal is done, from 0 to 1.
function share({ goal, units, sitting }) {
  if (goal.units) return Math.min(1, units / goal.units);
  return goal.seconds && sitting !== null ? Math.min(1, sitting / goal.seconds) : 0;
}

function line(status) {
  const { state, campaign } = status;
  const failed = Object.values(state.met).reduce((sum, times) => sum + times, 0);
  const facts = [
    [grouped(state.worlds), "worlds"],
    [short(state.steps), "steps"],
    [grouped(failed), `failures of ${plural(Object.keys(state.met).length, "class", "classes")}`],
    [grouped(speed(status)), state.running ? "worlds/s now" : "worlds/s"],
  ];
  const doing = !state.running ? stands(state) : campaign.stopping === state.folder ? "Stopping" : "Running";
  return [
    el("b", { class: state.running ? "good" : "", id: "campaign-state" }, doing),
    el("span", {}, `${state.controller} under ${state.motion}, seed ${state.seed}`),
    el("span", {}, goalWords(state)),
    ...facts.map(([value, words]) => el("span", {}, el("b", {}, value), ` ${words}`)),
  ];
}

function stands({ goal, units, fault }) {
  if (fault) return "Gave up";
  return goal.units && units < goal.units ? "Stopped" : "Done";
}

function goalWords({ goal, units, running, sitting }) {
  if (goal.units) return `unit ${units} of ${goal.units}`;
  if (running && sitting !== null) return `${Math.round(sitting)} of ${goal.seconds} s, ${plural(units, "unit")}`;
  return plural(units, "unit");
}

function short(count) {
  if (count < 1e6) return grouped(count);
  return count < 1e9 ? `${(count / 1e6).toFixed(1)} million` : `${(count / 1e9).toFixed(2)} billion`;
}

// Worlds a second: of the last seconds while it runs, else of all its time.
function speed({ state, past }) {
  if (!state.running) return state.seconds > 0 ? state.worlds / state.seconds : 0;
  const now = performance.now();
  if (past.at(-1)?.worlds !== state.worlds || past.length === 0) past.push({ now, worlds: state.worlds });
  while (past.length > 2 && now - past[0].now > SPAN) past.shift();
  const [first, last] = [past[0], past.at(-1)];
  if (last.now - first.now > 800) return (last.worlds - first.worlds) / ((last.now - first.now) / 1000);
  return state.seconds > 0 ? state.worlds / state.seconds : 0;
}

function showClasses({ state, parts, smallest, campaign }) {
  const slid = [...smallest.keys()].filter((name) => !(name in state.met)).map((name) => [name, 0]); // met while shrinking
  const rows = [...Object.entries(state.met), ...slid].sort(([, a], [, b]) => b - a);
  parts.classes.replaceChildren(
    ...rows.map(([name, times]) => {
      const best = smallest.get(name);
      const show = el("button", { type: "button", class: "link", title: "Show these alone", onclick: () => campaign.wall.only(name) }, name);
      const size = best ? `${best.width} x ${best.height}, ${best.solid} solid` : state.known[name] ? "known" : "to be shrunk";
      return rowOf([el("span", { class: "kind" }, verdictDot(best ? best.verdict : name.split("-")[0]), best ? show : name), times, size]);
    }),
  );
}

// Stop while it runs; go on when it stands still, as far as is asked for.
function showActions({ state, parts, campaign }) {
  const kind = !state ? "none" : state.running ? (campaign.stopping === state.folder ? "stopping" : "stop") : `on-${state.folder}-${state.units}`;
  if (parts.actions.dataset.kind === kind) return;
  parts.actions.dataset.kind = kind;
  if (!state) parts.actions.replaceChildren();
  else if (state.running) {
    const disabled = kind === "stopping";
    parts.actions.replaceChildren(
      el("button", { type: "button", id: "stop", disabled, onclick: campaign.stop, title: "All that was found is kept" }, "Stop"),
    );
  } else parts.actions.replaceChildren(...goOnPart(state, campaign));
}

function goOnPart(state, campaign) {
  const byUnits = state.goal.units !== null;
  const left = byUnits && state.units < state.goal.units;
  const usual = byUnits ? (left ? state.goal.units : 2 * state.goal.units) : state.goal.seconds;
  const amount = el("input", { type: "number", id: "go-on-amount", value: usual, min: byUnits ? Math.max(1, state.units) : 1, step: 1 });
  const go = () => {
    const value = amount.valueAsNumber;
    if (value > 0) campaign.goOn({ [byUnits ? "units" : "seconds"]: Math.round(value), known: true, workers: campaign.form.workers() });
  };
  const button = el("button", { type: "button", id: "go-on", onclick: go }, left ? "Resume" : "Go on");
  return [button, el("label", { class: "field" }, byUnits ? "to unit" : "for, s", amount)];
}
