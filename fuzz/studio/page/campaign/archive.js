// The behaviours that a campaign has found, as a map and as a table.

import { askToOpen } from "#studio/shared/asking.js";
import { archivePlot, rangeOf, rounded } from "#player/archive.js";
import { el, grouped, plural } from "#player/dom.js";

const SPACE = { width: 330, left: 40, right: 8, top: 12, bottom: 40 };

/**
 * @param {any} campaign
 * @returns {{element: HTMLElement, show: (archive: Archive | null | undefined) => void}}
 */
export function makeArchive(campaign) {
  const element = el("div", { id: "archive-panel" });
  let shown = "";
  return {
    element,
    show: (archive) => {
      const text = JSON.stringify(archive);
      if (!archive || text === shown) return;
      shown = text;
      const open = element.querySelector("details")?.open;
      const focused = /** @type {HTMLElement | null} */ (document.activeElement);
      const cell = element.contains(focused) && focused?.dataset.cell;
      element.replaceChildren(...partsOf(archive, (i, j) => openCell(campaign, i, j)));
      const table = element.querySelector("details");
      if (table) table.open = Boolean(open);
      /** @type {HTMLElement | null} */
      const again = cell ? element.querySelector(`[data-cell="${cell}"]`) : null;
      again?.focus({ preventScroll: true });
    },
  };
}

// Opens the simplest world of a kind on the board, and chooses the campaign's robot on the page
// Play.
function openCell(campaign, i, j) {
  const { studio, folder } = campaign;
  return campaign.trying(async () => {
    const answer = await askToOpen(studio.connection, "elite", { folder, i, j });
    studio.show({ ...answer, failure: answer.runs }, "", `kind ${i}, ${j} of ${folder}`);
    studio.go("draw");
  });
}

function partsOf(archive, open) {
  const [across, up] = archive.names,
    [columns, rows] = archive.edges.map((edges) => edges.length + 1);
  const words = `${plural(archive.cells.length, "kind")} out of ${grouped(columns * rows)}, by ${across} and ${up}. Colours are stronger where a simpler world shows the behaviour. Letters are the initials of the verdicts of runs that did not arrive. Click a kind to open its simplest world in the editor.`;
  const where = (i, j) => [i, j].map((index, axis) => rangeOf(archive.edges[axis], index));
  const edit = (i, j) => {
    const named = { "aria-label": `Open the simplest world of ${where(i, j).join(", ")}`, "data-cell": `${i} ${j}` };
    return el("button", { type: "button", class: "link", ...named, onclick: () => open(i, j) }, where(i, j)[0]);
  };
  const row = ([i, j, quality, verdict]) => [edit(i, j), rangeOf(archive.edges[1], j), rounded(quality), verdict];
  const head = el("tr", {}, [across, up, "quality", "verdict"].map((name) => el("th", { scope: "col" }, name)));
  const body = archive.cells.map((cell) => el("tr", {}, row(cell).map((value) => el("td", {}, value))));
  return [
    el("h2", {}, "Behaviours found"),
    el("p", { class: "quiet" }, words),
    archivePlot(archive, SPACE, open),
    el("details", {}, el("summary", {}, "Table"), el("table", { class: "counts" }, el("thead", {}, head), el("tbody", {}, body))),
  ];
}
