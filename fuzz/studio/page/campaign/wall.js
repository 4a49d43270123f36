// Failures as a gallery of small pictures: filtered, sorted, each drawn when it becomes visible.

import { askAbout } from "#studio/shared/asking.js";
import { codeText } from "#studio/shared/edits.js";
import { causeWords, choice, el, grouped, plural, unfinished, verdictDot } from "#player/dom.js";
import { drawSmall } from "#player/picture/map.js";
import { Ended } from "#studio/shared/connection.js";
import { Recent } from "#studio/shared/recent.js";
import { Refused, refusalWords } from "#studio/shared/refusals.js";

const AT_ONCE = 3; // pictures requested at the same time
const LOOKS = 400; // pictures that are kept, about 50 kB each
const ROWS = 120; // cards that are shown before the user asks for more
const SORTS = { worst: "worst first", size: "smallest first", newest: "newest first", oldest: "oldest first", group: "by cause" };
const FILTERS = { group: "Cause", verdict: "Verdict", controller: "Controller" };

/**
 * @param {any} campaign
 * @returns {any}
 */
export function makeWall(campaign) {
  const parts = {
    tools: el("div", { class: "wall-tools" }),
    count: el("p", { class: "quiet", role: "status", id: "wall-count" }),
    list: el("ul", { class: "wall", "aria-label": "Failures" }),
    faults: el("p", { class: "notice", hidden: true }),
  };
  const wall = {
    campaign, parts, failures: [], shown: ROWS, sort: "worst", chosen: "", filter: {}, looks: new Recent(LOOKS), queue: [], busy: 0, isRead: false, cards: new Map(),
  };
  wall.seen = new IntersectionObserver((entries) => entries.forEach((entry) => entry.isIntersecting && want(wall, entry.target)), { rootMargin: "200px" });
  const element = el("div", { class: "wall-part" }, parts.tools, parts.faults, el("div", { class: "wall-scroll" }, parts.list));
  new ResizeObserver(() => redraw(wall)).observe(parts.list);
  campaign.look = (failure) => lookAt(wall, failure, true);
  return {
    element,
    show: (answer) => show(wall, answer),
    reading: (read, of) => {
      parts.tools.hidden = false;
      parts.count.textContent = `Reading ${grouped(read)}${of ? ` of ${grouped(of)}` : ""} files …`;
    },
    refuse: (words) => {
      parts.faults.hidden = false;
      parts.faults.textContent = words;
    },
    wait: (words) => wait(wall, words),
    /* Updates the reason why there is no picture. */
    refreshEmpty: () => {
      const empty = wall.failures.length === 0 && wall.isRead ? parts.list.querySelector(".empty") : null;
      if (empty) empty.textContent = emptyWords(campaign);
    },
    only: (group) => {
      wall.filter = { group };
      showAll(wall);
    },
    redraw: () => redraw(wall),
    /* Draws some failures again, because their controller has been edited. */
    forget: (which) => {
      for (const one of wall.failures.filter(which)) wall.looks.delete(keyOf(one));
      redraw(wall);
    },
    choose: (failure) => choose(wall, failure),
  };
}

// Shows a message in place of the pictures until another folder has been read.
function wait(wall, words) {
  const { parts } = wall;
  for (const { fail } of wall.queue) fail(new Ended("Another folder was chosen."));
  Object.assign(wall, { isRead: false, filter: {}, shown: ROWS, chosen: "", queue: [], failures: [], cards: new Map() });
  wall.seen.disconnect();
  parts.tools.replaceChildren(parts.count); // the filters belonged to the other folder
  parts.tools.hidden = parts.faults.hidden = true;
  parts.list.replaceChildren(el("li", { class: "empty quiet" }, words));
}

function show(wall, answer) {
  const { campaign, parts } = wall;
  wall.failures = answer ? answer.failures : [];
  wall.isRead = true;
  for (const name of Object.keys(FILTERS)) if (!wall.failures.some((one) => one[name] === wall.filter[name])) delete wall.filter[name];
  parts.faults.hidden = !answer || answer.faults.length === 0;
  parts.faults.textContent = answer ? faultWords(answer.faults) : "";
  const smallest = new Map();
  for (const one of sorted(wall.failures, "size")) if (!smallest.has(one.group)) smallest.set(one.group, one);
  const worst = sorted([...smallest.values()], "worst");
  campaign.status.sizes(answer && new Map(worst.map((one) => [one.group, one])));
  campaign.failure.follow(wall.failures);
  showAll(wall);
}

// Describes files that cannot be read: three of them in full, the others as a number.
function faultWords(faults) {
  const more = faults.length - 3;
  return [...faults.slice(0, 3).map(refusalWords), more > 0 ? `And ${plural(more, "more file")} cannot be read.` : ""].join(" ").trim();
}

function sorted(failures, by) {
  const size = (a, b) => a.place - b.place;
  const group = (a, b) => (a.group < b.group ? -1 : a.group > b.group ? 1 : 0);
  const orders = { worst: (a, b) => a.rank - b.rank, size, newest: (a, b) => b.seen - a.seen, oldest: (a, b) => a.seen - b.seen, group };
  return [...failures].sort((a, b) => orders[by](a, b) || size(a, b) || (a.name < b.name ? -1 : 1));
}

function showAll(wall) {
  showTools(wall);
  showCards(wall);
}

const focusedElement = () => /** @type {HTMLElement | null} */ (document.activeElement);

function fits(wall, failure) {
  const chosen = Object.keys(FILTERS).every((name) => !wall.filter[name] || failure[name] === wall.filter[name]);
  return chosen && (!wall.filter.known || (wall.filter.known === "known") === failure.known);
}

function showTools(wall) {
  const { parts, failures } = wall;
  const focused = focusedElement()?.dataset?.filter;
  const list = (name, words, pairs, value, change) => {
    const input = choice(pairs, value, (event) => {
      change(event.target.value);
      showCards(wall);
    });
    input.dataset.filter = name;
    return el("label", { class: "field" }, words, input);
  };
  const values = (name) => [...new Set(failures.map((one) => one[name]))].sort();
  /** @type {(pair: string[]) => HTMLElement} */
  const filter = ([name, words]) =>
    list(name, words, [["", "all"], ...values(name).map((one) => [one, name === "group" ? causeWords(one) : one])], wall.filter[name] || "", (value) => (wall.filter[name] = value));
  const known = ["", "new", "known"].map((value) => [value, value || "all"]);
  /** @type {(pair: string[]) => boolean} */
  const several = ([name]) => wall.filter[name] || values(name).length > 1;
  parts.tools.replaceChildren(
    ...Object.entries(FILTERS).filter(several).map(filter),
    list("known", "Known", known, wall.filter.known || "", (value) => (wall.filter.known = value)),
    list("sort", "Sort", Object.entries(SORTS), wall.sort, (value) => (wall.sort = value)),
    parts.count,
  );
  parts.tools.hidden = failures.length === 0;
  if (focused) parts.tools.querySelector(`[data-filter="${focused}"]`)?.focus();
}

function showCards(wall) {
  const { parts, failures, campaign } = wall;
  const fitting = sorted(failures, wall.sort).filter((one) => fits(wall, one));
  const focused = focusedElement()?.dataset?.failure;
  const all = fitting.length === failures.length;
  const causes = new Set(failures.map((one) => one.group)).size;
  const words = `${plural(failures.length, "failure")}${failures.length > 1 ? ` of ${plural(causes, "cause")}` : ""}`;
  parts.count.textContent = all ? words : `${fitting.length} of ${plural(failures.length, "failure")}`;
  wall.seen.disconnect();
  /** @type {[string, HTMLElement][]} */
  const cards = fitting.slice(0, wall.shown).map((failure) => cardOf(wall, failure));
  wall.cards = new Map(cards);
  parts.list.replaceChildren(...cards.map(([, card]) => el("li", {}, card)));
  if (fitting.length > wall.shown) parts.list.append(el("li", {}, moreButton(wall, fitting.length - wall.shown)));
  if (failures.length === 0) parts.list.append(el("li", { class: "empty quiet" }, emptyWords(campaign)));
  for (const card of wall.cards.values()) wall.seen.observe(card);
  if (focused) wall.cards.get(focused)?.focus({ preventScroll: true });
}

function emptyWords({ folder, states, folders }) {
  if (folder === null || folder === "" || (states.size === 0 && folders.length <= 1)) return "The opened folder has no failures yet. Start a campaign on the right; it searches for worlds in which the controller fails.";
  const state = states.get(folder);
  if (state?.activity === "preparing") return "Preparing: the simulator and the controller are being loaded. Nothing has been tried yet.";
  if (state?.running && state.worlds === 0) return "Nothing has been tried yet.";
  if (state?.running) return "Failures appear here as soon as they are proved and shrunk.";
  if (state?.conclusion) return "Continue the campaign for longer, or start another on the right.";
  if (state?.worlds === 0) return "Nothing was tried: the campaign ended before its first run. Continue it for longer.";
  if (state?.answer === "none") return `There is no answer yet: ${state.answer_reason}. Continue the campaign for longer.`;
  if (state) return `No failure was found in ${plural(state.worlds, "world")}. Continue the campaign for longer, or start another on the right.`;
  return "This folder has no failures. Choose another folder above, or start a campaign on the right.";
}

function moreButton(wall, left) {
  const act = () => {
    wall.shown += ROWS;
    showCards(wall);
  };
  return el("button", { type: "button", onclick: act }, `Show more (${left})`);
}

/**
 * Return a card; it is rebuilt only if its failure has changed, so that its picture stays.
 * @returns {[string, HTMLElement]}
 */
function cardOf(wall, failure) {
  const key = failure.name,
    before = wall.cards.get(key);
  const card =
    before && before.dataset.digest === failure.digest
      ? before
      : el("button", { type: "button", class: "card", "data-failure": key, "data-digest": failure.digest }, el("canvas", { "aria-hidden": "true" }), el("span", { class: "text" }));
  card.setAttribute("aria-pressed", String(wall.chosen === key));
  card.dataset.verdict = failure.verdict;
  card.onclick = () => choose(wall, failure);
  card.querySelector(".text").replaceChildren(
    el("span", { class: "kind" }, verdictDot(failure.verdict), causeWords(failure.group)),
    unfinished(failure.shrinking) ? el("span", { class: "quiet unshrunk" }, unfinished(failure.shrinking)) : "",
    el("span", { class: "quiet" }, `${failure.width} x ${failure.height}, ${failure.solid} solid`, failure.known ? el("b", { class: "known" }, "known") : ""),
  );
  return [key, card];
}

function choose(wall, failure) {
  wall.chosen = failure.name;
  for (const [name, card] of wall.cards) card.setAttribute("aria-pressed", String(name === failure.name));
  wall.campaign.select(failure);
}

// Requests the picture of a card that has become visible.
function want(wall, card) {
  wall.seen.unobserve(card);
  const failure = wall.failures.find((one) => one.name === card.dataset.failure);
  if (!failure) return;
  lookAt(wall, failure).then(
    (look) => draw(card, look),
    (error) => {
      if (!(error instanceof Refused || error instanceof Ended)) throw error;
    },
  );
}

const keyOf = ({ name, digest }) => `${name} ${digest}`;

// Requests a failure's picture from the server, only once.
function lookAt(wall, failure, first = false) {
  const key = keyOf(failure);
  let asked = wall.looks.get(key);
  if (!asked) {
    asked = new Promise((done, fail) => wall.queue.push({ key, failure, done, fail }));
    wall.looks.set(key, asked);
    asked.catch(() => wall.looks.delete(key));
  }
  // ahead of the others
  if (first) wall.queue.sort((a, b) => Number(b.key === key) - Number(a.key === key));
  pump(wall);
  return asked;
}

function pump(wall) {
  while (wall.busy < AT_ONCE && wall.queue.length > 0) {
    const { failure, done, fail } = wall.queue.shift();
    wall.busy += 1;
    const { studio } = wall.campaign;
    askAbout(studio.connection, () => codeText(studio, [failure.controller]), "look", { name: failure.name })
      .then(done, fail)
      .finally(() => {
        wall.busy -= 1;
        pump(wall);
      });
  }
}

function draw(card, look) {
  drawSmall(card.querySelector("canvas"), look);
}

// Draws every picture again when it becomes visible, visible ones immediately.
function redraw(wall) {
  wall.seen.disconnect();
  for (const card of wall.cards.values()) wall.seen.observe(card);
}
