// The archive of behaviours, with its table.

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
    archivePlot(archive, PLOT),
    tableBehind("Table of the archive", [across, up, "quality", "verdict"], cells),
  );
}
