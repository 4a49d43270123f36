// The failures as cards that can be filtered, ordered and grouped.

import { causeWords, choice, el, grouped, plural, unfinished, verdictDot } from "#player/dom.js";
import { legendOfMany } from "#player/legend.js";
import { drawSmall, pictureLabel } from "#player/picture/map.js";

const ORDERS = {
  cause: ["Cause", (a, b) => compareText(a.group, b.group) || Number(b.example) - Number(a.example)],
  small: ["Smallest first", (a, b) => a.place - b.place],
  large: ["Largest first", (a, b) => b.place - a.place],
  steps: ["Longest run first", (a, b) => stepsOf(b) - stepsOf(a)],
  met: ["Met most often", (a, b) => (b.met || 0) - (a.met || 0)],
};
const GROUPS = {
  cause: ["Cause", (failure) => causeWords(failure.group)],
  verdict: ["Verdict", (failure) => failure.verdict],
  controller: ["Controller", (failure) => `${failure.controller} under ${failure.motion}`],
  none: ["Nothing", () => ""],
};

const FIRST = 50; // cards that are made at once; a group's others are made when they are wanted

/**
 * @param {string} a
 * @param {string} b
 * @returns {number}
 */
export function compareText(a, b) {
  return a < b ? -1 : a > b ? 1 : 0;
}

function stepsOf(failure) {
  return failure.now.run ? failure.now.run.steps : 0;
}

/**
 * @param {HTMLElement} section
 * @param {ReportFailure[]} failures
 * @param {Map<string, string>} causes The verdict that gives each cause its colour, in the order
 *   of the answer, the worst first; the list has the same order.
 * @returns {Overview}
 */
export function makeOverview(section, failures, causes = new Map()) {
  const wanted = { text: "", verdicts: new Set(), controller: "", order: "cause", group: "cause" };
  const list = el("div", { class: "groups" });
  const count = el("span", { class: "quiet", role: "status" });
  // Draw a card's picture only when it is about to be seen: a page may have a thousand cards.
  const visible = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) {
        if (!entry.isIntersecting) continue;
        visible.unobserve(entry.target);
        const canvas = /** @type {HTMLCanvasElement} */ (entry.target);
        const failure = failureOf(failures, canvas.dataset.id);
        if (failure) drawSmall(canvas, failure.now);
      }
    },
    { rootMargin: "300px" },
  );
  const redraw = () => list.querySelectorAll("canvas").forEach((canvas) => visible.observe(canvas));
  const several = new Set(failures.map((failure) => `${failure.controller}\n${failure.motion}`)).size > 1;
  const refresh = () => {
    const shown = failures.filter((failure) => fits(failure, wanted)).sort(ORDERS[wanted.order][1]);
    const colours = wanted.group === "cause" ? causes.entries() : [];
    const first = new Map([...colours].map(([cause, colour]) => [causeWords(cause), colour]));
    list.replaceChildren(...groupsOf(shown, GROUPS[wanted.group][1], (failure) => card(failure, several), first, redraw));
    count.textContent = shown.length === failures.length ? "" : `${shown.length} of ${failures.length} shown`;
    redraw();
  };
  section.append(toolbar(failures, wanted, refresh, count), legendOfMany(failures.map(({ now }) => now)), list);
  list.addEventListener("keydown", moveBetweenCards);
  refresh();
  const drawAll = () => {
    for (const button of /** @type {NodeListOf<HTMLElement>} */ (list.querySelectorAll("button.rest"))) button.click();
    for (const canvas of list.querySelectorAll("canvas")) {
      const failure = failureOf(failures, canvas.dataset.id);
      if (failure) drawSmall(canvas, failure.now);
    }
  };
  return { redraw, drawAll, shown: () => [...list.querySelectorAll("canvas")].map((canvas) => canvas.dataset.id ?? "") };
}

/**
 * @param {ReportFailure[]} failures
 * @param {string | undefined} id
 * @returns {ReportFailure | undefined}
 */
export function failureOf(failures, id) {
  return failures.find((failure) => failure.id === id);
}

function fits(failure, wanted) {
  const text = `${failure.group} ${failure.cause} ${failure.controller} ${failure.motion} ${failure.path} ${failure.strategy}`.toLowerCase();
  return (
    (wanted.verdicts.size === 0 || wanted.verdicts.has(failure.verdict)) &&
    (wanted.controller === "" || failure.controller === wanted.controller) &&
    wanted.text
      .toLowerCase()
      .split(/\s+/)
      .every((word) => text.includes(word))
  );
}

function toolbar(failures, wanted, refresh, count) {
  const set = (name) => (event) => {
    wanted[name] = event.target.value;
    refresh();
  };
  const controllers = [...new Set(failures.map((failure) => failure.controller))].sort(compareText);
  return el(
    "div",
    { class: "bar", role: "search" },
    el("input", {
      type: "search",
      id: "find",
      placeholder: "Find a cause, a file …",
      "aria-label": "Find failures",
      oninput: set("text"),
    }),
    controllers.length > 1
      ? el(
          "label",
          { class: "field" },
          "Controller",
          choice([["", "all"], ...controllers.map((name) => [name, name])], "", set("controller")),
        )
      : null,
    el("label", { class: "field" }, "Group by", choice(named(GROUPS), wanted.group, set("group"))),
    el("label", { class: "field" }, "Order", choice(named(ORDERS), wanted.order, set("order"))),
    verdictChips(failures, wanted, refresh),
    count,
  );
}

function named(table) {
  return Object.entries(table).map(([name, [words]]) => [name, words]);
}

function verdictChips(failures, wanted, refresh) {
  const counts = new Map();
  for (const { verdict } of failures) counts.set(verdict, (counts.get(verdict) || 0) + 1);
  if (counts.size < 2) return null;
  const chip = ([verdict, number]) =>
    el(
      "button",
      {
        type: "button",
        "aria-pressed": "false",
        onclick: (event) => {
          const on = !wanted.verdicts.delete(verdict);
          if (on) wanted.verdicts.add(verdict);
          event.currentTarget.setAttribute("aria-pressed", String(on));
          refresh();
        },
      },
      verdictDot(verdict),
      `${verdict} ${number}`,
    );
  return el("div", { class: "chips", role: "group", "aria-label": "Verdicts" }, [...counts].sort().map(chip));
}

// Groups whose names are in `first` come in that order and have its colours, the others follow.
// `added` is called when a group's other cards have been made.
function groupsOf(failures, nameOf, cardOf, first, added) {
  if (failures.length === 0)
    return [el("p", { class: "quiet" }, "No failure matches. Clear the search, or choose other verdicts.")];
  const groups = new Map();
  for (const failure of failures) {
    const name = nameOf(failure);
    groups.set(name, [...(groups.get(name) || []), failure]);
  }
  const names = [...first.keys()];
  const rank = (name) => (first.has(name) ? names.indexOf(name) : names.length);
  const ordered = [...groups].sort((a, b) => rank(a[0]) - rank(b[0]));
  let room = FIRST;
  const item = (failure) => el("li", {}, cardOf(failure));
  return ordered.map(([name, members]) => {
    const rest = members.slice(room);
    const cards = el("ul", { class: "cards" }, members.slice(0, room).map(item));
    room = Math.max(0, room - members.length);
    const more = () => {
      button?.remove();
      cards.append(...rest.map(item));
      added();
    };
    const button = rest.length > 0 ? el("button", { type: "button", class: "rest", onclick: more }, `Show ${rest.length} more`) : null;
    return el(
      "div",
      { class: "group" },
      name
        ? el("h2", {}, verdictDot(first.get(name) ?? members[0].verdict), name, el("span", { class: "quiet" }, ` ${members.length}`))
        : null,
      cards,
      button,
    );
  });
}

function card(failure, several) {
  const { run } = failure.now;
  const facts = [
    `${failure.size}, ${grouped(failure.solid)} solid`,
    run && (run.loop ? `period ${plural(run.loop[1], "step")}` : plural(run.steps, "step")),
    failure.met && `cause met ${grouped(failure.met)}×`,
  ].filter(Boolean);
  return el(
    "a",
    { class: "card", href: `#${failure.id}`, "data-verdict": failure.verdict, id: `card-${failure.id}` },
    el("canvas", { "data-id": failure.id, role: "img", "aria-label": pictureLabel(failure.now) }),
    el(
      "div",
      { class: "text" },
      el("div", { class: "kind" }, causeWords(failure.group)),
      el(
        "div",
        { class: "facts" },
        facts.map((fact) => el("span", {}, fact)),
      ),
      several ? el("div", { class: "facts" }, `${failure.controller}, ${failure.motion}`) : null,
      unfinished(failure.shrinking) ? el("div", { class: "facts" }, unfinished(failure.shrinking)) : null,
      failure.confirmed ? null : el("div", { class: "facts bad" }, "not confirmed here"),
      el("div", { class: "facts on-paper" }, el("code", {}, failure.replay)),
    ),
  );
}

function moveBetweenCards(event) {
  const cards = [...document.querySelectorAll(".card")];
  const here = cards.findIndex((card) => card === document.activeElement);
  if (here < 0 || event.altKey || event.ctrlKey || event.metaKey) return;
  const next = {
    ArrowLeft: () => cards[here - 1],
    ArrowRight: () => cards[here + 1],
    ArrowUp: () => nearestCard(cards[here], cards.slice(0, here)),
    ArrowDown: () => nearestCard(cards[here], cards.slice(here + 1)),
  }[event.key];
  if (!next) return;
  event.preventDefault();
  next()?.focus();
}

// Returns the nearest card in another row; the nearest row comes first.
function nearestCard(card, others) {
  const from = card.getBoundingClientRect();
  const away = others
    .map((other) => ({ other, box: other.getBoundingClientRect() }))
    .filter(({ box }) => Math.abs(box.top - from.top) > 4)
    .map(({ other, box }) => ({ other, far: 9 * Math.abs(box.top - from.top) + Math.abs(box.left - from.left) }));
  return away.sort((a, b) => a.far - b.far)[0]?.other;
}
