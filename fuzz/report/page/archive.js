// The archive of behaviours as a map: one square for each kind, stronger where its best run has a higher quality.

function archiveChart(archive) {
  if (!archive) return null;
  const [across, up] = archive.names,
    [columns, rows] = archive.edges.map((edges) => edges.length + 1);
  const note = `${plural(archive.cells.length, "kind")} of behaviour of ${grouped(columns * rows)}; the stronger, the higher its quality; letters begin the verdicts of runs that did not arrive.`;
  const cells = archive.cells.map(([i, j, quality, verdict]) => [
    rangeOf(archive.edges[0], i),
    rangeOf(archive.edges[1], j),
    rounded(quality),
    verdict,
  ]);
  return chart(
    `Archive: ${across} and ${up}`,
    note,
    archivePlot(archive, columns, rows),
    tableBehind("Table of the archive", [across, up, "quality", "verdict"], cells),
  );
}

// What lies between two edges; the first and the last cell are open.
function rangeOf(edges, k) {
  if (edges.length === 0) return "any";
  if (k === 0) return `below ${short(edges[0])}`;
  return k === edges.length ? `${short(edges[k - 1])} and above` : `${short(edges[k - 1])} to ${short(edges[k])}`;
}

function rounded(number) {
  return String(Number(number.toPrecision(4)));
}

function archivePlot(archive, columns, rows) {
  const wide = (PLOT.width - PLOT.left - PLOT.right) / columns,
    high = Math.min(wide, 340 / rows);
  const top = PLOT.top + 16,
    bottom = top + rows * high;
  const frame = { wide, high, top, bottom, x: (i) => PLOT.left + i * wide, y: (j) => bottom - (j + 1) * high };
  const height = bottom + PLOT.bottom + 4;
  const empty = svg("rect", { class: "empty", x: frame.x(0), y: top, width: wide * columns, height: high * rows });
  const label = `Heat map of ${archive.cells.length} kinds of behaviour by ${archive.names.join(" and ")}; the table below has each`;
  return svg(
    "svg",
    { class: "plot", viewBox: `0 0 ${PLOT.width} ${height}`, role: "img", "aria-label": label },
    empty,
    archiveCells(archive, frame),
    archiveAxes(archive, frame),
  );
}

function archiveCells(archive, { wide, high, x, y }) {
  const qualities = archive.cells.map((cell) => cell[2]);
  const least = Math.min(...qualities),
    span = Math.max(...qualities) - least || 1;
  return archive.cells.map(([i, j, quality, verdict]) => {
    const where = archive.names.map((name, axis) => `${name} ${rangeOf(archive.edges[axis], [i, j][axis])}`).join(", ");
    const strength = (0.12 + (0.88 * (quality - least)) / span).toFixed(2);
    const cell = svg(
      "rect",
      { class: "heat", x: x(i), y: y(j), width: wide, height: high, "fill-opacity": strength },
      svg("title", {}, `${where}: quality ${rounded(quality)}, ${verdict}`),
    );
    const said = verdict !== "reached" && high > 11 && wide > 11;
    return [
      cell,
      said
        ? svg("text", { class: "onheat", x: x(i) + wide / 2, y: y(j) + high / 2 + 4 }, verdict[0].toUpperCase())
        : null,
    ];
  });
}

function archiveAxes(archive, { wide, high, bottom, x, y }) {
  const [across, up] = archive.edges,
    apart = Math.ceil(34 / wide),
    above = Math.ceil(16 / high);
  const middle = { "text-anchor": "middle" },
    end = { "text-anchor": "end" };
  return [
    across.map((edge, k) =>
      k % apart === 0 ? svg("text", { x: x(k + 1), y: bottom + 16, ...middle }, short(edge)) : null,
    ),
    up.map((edge, k) => (k % above === 0 ? svg("text", { x: PLOT.left - 6, y: y(k) + 4, ...end }, short(edge)) : null)),
    svg("text", { x: (PLOT.left + PLOT.width) / 2, y: bottom + PLOT.bottom, ...middle }, archive.names[0]),
    svg("text", { x: 4, y: PLOT.top }, archive.names[1]),
  ];
}
