// The table of a comparison: a row for each world, a column for each controller,
// a verdict in each cell.

import { breakable, el, grouped, shortName, verdictSign } from "#player/dom.js";
import { refusalWords } from "#studio/shared/refusals.js";

/**
 * Makes an empty table.
 * @param {(row: number, column: number) => void} open - Called when the user chooses a result
 * @returns {any}
 */
export function makeTable(open) {
  /** @type {any} */
  const table = { open, robots: [], rows: [], element: el("div", { class: "comparison-scroll", tabindex: 0, role: "region", "aria-label": "Comparison" }) };
  return {
    element: table.element,
    begin: (robots, worlds) => begin(table, robots, worlds),
    take: (part) => take(table, part),
    totals: (totals, rows) => showTotals(table, totals, rows),
    seedOf: (row, column) => table.rows[row]?.cells[column]?.seed,
  };
}

// Shows the worlds and the robots, with every cell still empty.
function begin(table, robots, worlds) {
  const head = el("tr", {}, el("th", { scope: "col" }, "World"), robots.map((name) => el("th", { scope: "col", title: name }, breakable(shortName(name)))));
  table.robots = robots;
  table.rows = worlds.map(({ name }) => rowOf(table, name));
  table.foot = el("tfoot", {});
  table.element.replaceChildren(
    el("table", { class: "comparison" }, el("thead", {}, head), el("tbody", {}, table.rows.map(({ element }) => element)), table.foot),
  );
}

function rowOf({ robots }, name) {
  const size = el("span", { class: "quiet" });
  const places = robots.map(() => el("td", { class: "due" }, "…"));
  const element = el("tr", {}, el("th", { scope: "row" }, el("span", {}, name), " ", size), places);
  return { name, size, places, element, cells: [] };
}

function take(table, part) {
  const row = table.rows[part.row];
  if (part.column !== undefined) showCell(table, part);
  else if (part.error) row.element.replaceChildren(row.element.querySelector("th"), el("td", { class: "bad", colspan: table.robots.length }, refusalWords(part.error)));
  else if (part.best) for (const column of part.best) markBest(row.places[column]);
  else row.size.textContent = `${part.width} x ${part.height}`;
}

// Shows a result, in the colour of its verdict and in words.
function showCell({ rows, robots, open }, part) {
  const { row, column } = part;
  const { places, cells, name } = rows[row];
  const place = places[column];
  cells[column] = part;
  place.className = "";
  if (part.error) {
    place.replaceChildren(el("span", { class: "bad" }, "did not run"), el("p", { class: "bad" }, refusalWords(part.error)));
    return;
  }
  place.dataset.verdict = part.verdict;
  const many = part.runs > 1;
  const ending = part.time === null ? part.detail : `${part.time.toFixed(2)} s`;
  const facts = [many ? `${part.reached} of ${part.runs}` : "", ending, `${grouped(part.steps)} steps`];
  const button = el(
    "button",
    { type: "button", class: "cell", "aria-label": `${robots[column]} in ${name}: ${part.verdict}, ${facts.filter(Boolean).join(", ")}. Play it`, onclick: () => open(row, column) },
    el("span", { class: "who" }, verdictSign(part.verdict), " ", el("b", {}, part.verdict)),
    el("span", { class: "quiet" }, facts.filter(Boolean).join(", ")),
  );
  place.replaceChildren(button);
}

function markBest(place) {
  place.classList.add("best");
  place.querySelector(".who")?.append(el("span", { class: "fastest" }, "fastest"));
}

// Shows how often each robot arrived, and how often it was fastest.
function showTotals(table, totals, rows) {
  if (totals.length === 0) return;
  const cell = ({ reached, runs, wins, shared }) => {
    const first = wins + shared > 0 ? `fastest in ${wins + shared}` : "";
    return el("td", {}, el("b", {}, `${reached} of ${runs}`), el("span", { class: "quiet" }, [" arrive", first].filter(Boolean).join(", ")));
  };
  const of = rows < table.rows.length ? ` (${rows} of ${table.rows.length} worlds)` : "";
  table.foot.replaceChildren(el("tr", {}, el("th", { scope: "row" }, `All${of}`), totals.map(cell)));
}
