// The archive of behaviours as a map: one square for each kind,
// with a stronger colour for a higher quality.

import { svg } from "#player/dom.js";

/**
 * Describes the range between two edges; the first and the last cell are open.
 * @param {number[]} edges
 * @param {number} k
 * @returns {string}
 */
export function rangeOf(edges, k) {
  if (edges.length === 0) return "any";
  if (k === 0) return `below ${short(edges[0])}`;
  return k === edges.length ? `${short(edges[k - 1])} and above` : `${short(edges[k - 1])} to ${short(edges[k])}`;
}

/**
 * @param {number} number
 * @returns {string}
 */
export function rounded(number) {
  return String(Number(number.toPrecision(4)));
}

/**
 * Draws the map.
 * @param {Archive} archive
 * @param {{width: number, left: number, right: number, top: number, bottom: number}} space - Width
 *   of the picture,
 *     and the margins around the map
 * @param {((i: number, j: number) => void) | null} [open] - Called when a kind is clicked; without
 *   it nothing can
 *     be opened
 * @returns {SVGElement}
 */
export function archivePlot(archive, space, open = null) {
  const [columns, rows] = archive.edges.map((edges) => edges.length + 1);
  const wide = (space.width - space.left - space.right) / columns,
    high = Math.min(wide, 340 / rows);
  const top = space.top + 16,
    bottom = top + rows * high;
  const frame = { wide, high, top, bottom, x: (i) => space.left + i * wide, y: (j) => bottom - (j + 1) * high };
  const height = bottom + space.bottom + 4;
  const empty = svg("rect", { class: "empty", x: frame.x(0), y: top, width: wide * columns, height: high * rows });
  const label = `Heat map of ${archive.cells.length} kinds of behaviour by ${archive.names.join(" and ")}; the table below lists them`;
  return svg(
    "svg",
    { class: "plot", viewBox: `0 0 ${space.width} ${height}`, role: "img", "aria-label": label },
    empty,
    archiveCells(archive, frame, open),
    archiveAxes(archive, frame, space),
  );
}

function archiveCells(archive, { wide, high, x, y }, open) {
  const qualities = archive.cells.map((cell) => cell[2]);
  const least = Math.min(...qualities),
    span = Math.max(...qualities) - least || 1;
  return archive.cells.map(([i, j, quality, verdict]) => {
    const where = archive.names.map((name, axis) => `${name} ${rangeOf(archive.edges[axis], [i, j][axis])}`).join(", ");
    // Even the lowest quality stays visible against an empty square.
    const strength = (0.12 + (0.88 * (quality - least)) / span).toFixed(2);
    const cell = svg(
      "rect",
      {
        class: open ? "heat opens" : "heat",
        x: x(i), y: y(j), width: wide, height: high, "fill-opacity": strength,
        onclick: open && (() => open(i, j)),
      },
      svg("title", {}, `${where}: quality ${rounded(quality)}, ${verdict}${open ? "; click to open its simplest world" : ""}`),
    );
    const labelled = verdict !== "reached" && high > 11 && wide > 11;
    return [
      cell,
      labelled
        ? svg("text", { class: "onheat", x: x(i) + wide / 2, y: y(j) + high / 2 + 4 }, verdict[0].toUpperCase())
        : null,
    ];
  });
}

function archiveAxes(archive, { wide, high, bottom, x, y }, space) {
  const [across, up] = archive.edges,
    apart = Math.ceil(34 / wide),
    above = Math.ceil(16 / high);
  const middle = { "text-anchor": "middle" },
    end = { "text-anchor": "end" };
  return [
    across.map((edge, k) =>
      k % apart === 0 ? svg("text", { x: x(k + 1), y: bottom + 16, ...middle }, short(edge)) : null,
    ),
    up.map((edge, k) => (k % above === 0 ? svg("text", { x: space.left - 6, y: y(k) + 4, ...end }, short(edge)) : null)),
    svg("text", { x: (space.left + space.width) / 2, y: bottom + space.bottom, ...middle }, archive.names[0]),
    svg("text", { x: 4, y: space.top }, archive.names[1]),
  ];
}

/**
 * @param {number} value
 * @returns {string}
 */
export function short(value) {
  if (value >= 1e6) return `${Number((value / 1e6).toPrecision(3))} M`;
  return value >= 1e4 ? `${Number((value / 1e3).toPrecision(3))} k` : String(Number(value.toPrecision(3)));
}
