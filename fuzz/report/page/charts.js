// The course of a campaign: what each search strategy found, and when, and the archive of
// behaviours. Each picture has its table.

import { archivePlot, rangeOf, rounded, short } from "#player/archive.js";
import { causeWords, choice, el, grouped, plural, svg, ticks, verdictDot } from "#player/dom.js";
import { compareText } from "#report/overview.js";

// As wide as the window allows, so that its text is as large as elsewhere.
const PLOT = {
  width: Math.max(300, Math.min(640, innerWidth - 60)),
  height: 260,
  left: 44,
  right: 14,
  top: 12,
  bottom: 40,
};
const UNLINKED = "Causes without a link have no failure here.";
const AXES = { worlds: "worlds tried", steps: "steps simulated", seconds: "seconds" };

/**
 * @param {HTMLElement} section
 * @param {ReportCampaign[]} campaigns
 * @param {ReportFailure[]} failures
 */
export function makeCampaign(section, campaigns, failures) {
  section.append(
    ...campaigns.map((campaign, index) => campaignPart(campaign, linksOf(failures, index), campaigns.length > 1)),
  );
}

// Returns, for each cause of a campaign, its first failure on this page.
function linksOf(failures, index) {
  const links = new Map();
  for (const failure of failures)
    if (failure.campaign === index && !links.has(failure.group)) links.set(failure.group, failure.id);
  return links;
}

function campaignPart(campaign, links, several) {
  return el(
    "div",
    { class: "part" },
    el("h2", several ? {} : { class: "away" }, `${campaign.controller} under ${campaign.motion}, ${campaign.folder}`),
    el(
      "div",
      { class: "charts" },
      foundChart(campaign, links),
      strategyChart(campaign),
      archiveChart(campaign.archive),
      barChart(
        "Causes, by how often they were met",
        "cause",
        campaign.met,
        (cause) => linked(cause, links),
        (count) =>
          `${plural(count, "failure")} proved. ${Object.keys(campaign.met).every((cause) => links.has(cause)) ? "" : UNLINKED}`,
      ),
      barChart(
        "Verdicts at screening",
        "verdict",
        campaign.verdicts,
        (verdict) => el("span", {}, verdictDot(verdict), ` ${verdict}`),
        (count) =>
          `${plural(count, "world")} of the search, which may be easy, so they give no rate of arrival.${campaign.verdicts.undecided ? " Undecided: the quick run's small budget was used up without a verdict." : ""}`,
        true,
      ),
    ),
  );
}

function linked(cause, links) {
  const words = causeWords(cause);
  return links.has(cause) ? el("a", { href: `#${links.get(cause)}` }, words) : words;
}

function chart(title, note, ...content) {
  return el(
    "section",
    { class: "chart", "aria-label": title },
    el("h3", {}, title),
    el("p", { class: "quiet" }, note),
    content,
  );
}

// Finds over time: a step up for each cause, where it was first met.
function foundChart(campaign, links) {
  if (campaign.found.length === 0) return chart("Found over time", "Nothing was found.");
  const firsts = firstFinds(campaign.found);
  const holder = el("div");
  const draw = (axis) => holder.replaceChildren(foundPlot(campaign, firsts, axis));
  draw("worlds");
  const note = `${plural(firsts.length, "cause")}; the last new one after ${grouped(firsts[firsts.length - 1].worlds)} of ${plural(campaign.worlds, "world")}.`;
  return chart(
    "Found over time",
    note,
    el(
      "label",
      { class: "field" },
      "Over",
      choice(Object.entries(AXES), "worlds", (event) => draw(event.target.value)),
    ),
    holder,
    tableBehind(
      "Table of finds",
      ["cause", "strategy", "unit", "cells", "worlds", "steps", "s"],
      firsts.map((find) => [
        linked(find.cause, links),
        find.strategy,
        grouped(find.unit),
        grouped(find.solid_cells),
        grouped(find.worlds),
        grouped(find.steps),
        find.seconds.toFixed(1),
      ]),
    ),
  );
}

// Returns the first find of each cause; the others are variants of it.
function firstFinds(found) {
  const firsts = new Map();
  for (const find of found) if (!firsts.has(find.cause)) firsts.set(find.cause, find);
  return [...firsts.values()];
}

function foundPlot(campaign, firsts, axis) {
  const most = firsts.length,
    end = Math.max(campaign[axis], firsts[most - 1][axis], 1e-9);
  const x = (value) => PLOT.left + (value / end) * (PLOT.width - PLOT.left - PLOT.right);
  const y = (value) => PLOT.height - PLOT.bottom - (value / most) * (PLOT.height - PLOT.top - PLOT.bottom);
  // The curve rises at each cause; its first find is a dot with its details as a tooltip.
  let path = `M${x(0)},${y(0)}`;
  firsts.forEach((find, index) => (path += `H${x(find[axis]).toFixed(1)}V${y(index + 1).toFixed(1)}`));
  path += `H${x(end)}`;
  const dots = firsts.map((find, index) =>
    svg(
      "circle",
      { cx: x(find[axis]).toFixed(1), cy: y(index + 1).toFixed(1), r: 4.5, class: "first" },
      svg(
        "title",
        {},
        `${causeWords(find.cause)}: ${find.solid_cells} cells, strategy ${find.strategy}, unit ${find.unit}, after ${grouped(find.worlds)} worlds`,
      ),
    ),
  );
  return svg(
    "svg",
    {
      class: "plot",
      viewBox: `0 0 ${PLOT.width} ${PLOT.height}`,
      role: "img",
      "aria-label": `Causes found over ${AXES[axis]}: ${most} in total; the table below lists them`,
    },
    axes(x, y, end, most, AXES[axis]),
    svg("path", { class: "under", d: `${path}V${y(0)}Z` }),
    svg("path", { class: "curve", d: path }),
    dots,
  );
}

function axes(x, y, end, most, name) {
  const parts = [];
  for (const value of ticks(most).filter(Number.isInteger)) {
    parts.push(svg("line", { class: "axis", x1: PLOT.left, x2: PLOT.width - PLOT.right, y1: y(value), y2: y(value) }));
    parts.push(svg("text", { x: PLOT.left - 8, y: y(value) + 4, "text-anchor": "end" }, String(value)));
  }
  for (const value of ticks(end)) {
    parts.push(svg("text", { x: x(value), y: PLOT.height - PLOT.bottom + 18, "text-anchor": "middle" }, short(value)));
  }
  parts.push(svg("text", { x: (PLOT.left + PLOT.width) / 2, y: PLOT.height - 4, "text-anchor": "middle" }, name));
  return parts;
}

function strategyChart(campaign) {
  if (campaign.strategies.length === 0) return null;
  const most = Math.max(...campaign.strategies.map((strategy) => strategy.variants), 1);
  const rows = campaign.strategies.map((strategy) => [
    strategy.strategy,
    grouped(strategy.units),
    grouped(strategy.worlds),
    grouped(strategy.steps),
    grouped(strategy.failures),
    grouped(strategy.variants),
    strategy.steps > 0 ? Number(((strategy.variants / strategy.steps) * 1e6).toPrecision(2)).toString() : "–",
    meter(strategy.variants / most),
  ]);
  const best = [...campaign.strategies].sort((a, b) => b.variants - a.variants)[0];
  return chart(
    "By search strategy",
    best.variants > 0
      ? `Strategy ${best.strategy} was the first to find ${plural(best.variants, "variant")} of these causes.`
      : "No strategy found a failure.",
    table(["strategy", "units", "worlds", "steps", "failures", "new variants", "per M steps", ""], rows),
  );
}

/**
 * @param {number} share
 * @param {string | null} [verdict]
 */
function meter(share, verdict = null) {
  const bar = el("i", { "data-verdict": verdict });
  bar.style.width = `${(100 * share).toFixed(1)}%`;
  return el("span", { class: "meter", "aria-hidden": "true" }, bar);
}

function barChart(title, what, counts, nameOf, noteOf, coloured = false) {
  const rows = Object.entries(counts).sort((a, b) => b[1] - a[1] || compareText(a[0], b[0]));
  if (rows.length === 0) return null;
  const most = rows[0][1] || 1;
  return chart(
    title,
    noteOf(rows.reduce((sum, row) => sum + row[1], 0)),
    table(
      [what, "count", ""],
      rows.map(([name, count]) => [nameOf(name), grouped(count), meter(count / most, coloured ? name : null)]),
    ),
  );
}

function table(heads, rows) {
  const head = el(
    "tr",
    {},
    heads.map((words) => (words ? el("th", { scope: "col" }, words) : el("td"))),
  );
  const cell = (content, k) => {
    if (k === 0) return el("th", { scope: "row" }, content);
    // text is a number, an element is a bar
    return el("td", { class: content.nodeType ? "meter" : null }, content);
  };
  const body = rows.map((row) => el("tr", {}, row.map(cell)));
  const whole = el("table", { class: "rows" }, el("thead", {}, head), el("tbody", {}, body));
  return el("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": "Table" }, whole);
}

function tableBehind(title, heads, rows) {
  return el("details", {}, el("summary", {}, title), table(heads, rows));
}

/**
 * The archive of behaviours, with its table.
 * @param {Archive | null} archive
 * @returns {HTMLElement | null}
 */
function archiveChart(archive) {
  if (!archive) return null;
  const [across, up] = archive.names,
    [columns, rows] = archive.edges.map((edges) => edges.length + 1);
  const note = `${plural(archive.cells.length, "kind")} of behaviour out of ${grouped(columns * rows)}. Stronger colours mean higher quality. Letters are the initials of the verdicts of runs that did not arrive.`;
  const cells = archive.cells.map(([i, j, quality, verdict]) => [
    rangeOf(archive.edges[0], i),
    rangeOf(archive.edges[1], j),
    rounded(quality),
    verdict,
  ]);
  return chart(
    `Archive: ${across} and ${up}`,
    note,
    archivePlot(archive, PLOT),
    tableBehind("Archive table", [across, up, "quality", "verdict"], cells),
  );
}
