// The drawn world as the player draws it, so that it is visible before the server has answered.

/**
 * Returns start, target and radius of the robots after the first, in cells.
 * @param {EditedWorld} world
 * @returns {OtherEnds[]}
 */
export function othersOf({ others, cell_size: side }) {
  return others.map(({ start: [x, y, heading], target, radius }) => ({
    start: [x / side, y / side, heading],
    target: /** @type {Triple} */ (target.map((value) => value / side)),
    radius: radius / side,
    witness: null,
  }));
}

/**
 * Returns the first robot's footprint, in cells, and its goal's heading, from the text of its file,
 * which the server writes; the page cannot change either.
 * @param {{source: string | null, cell_size: number}} world
 * @returns {{footprint?: [number, number][], aim?: number}}
 */
export function kindOf({ source, cell_size: side }) {
  if (!source?.startsWith("%worldgen-grid 2")) return {};
  const table = source.slice(0, source.indexOf("%cells")).split("[[robot]]")[1] ?? "";
  const corners = /^footprint = (\[\[[-+.,\deE[\] ]*\]\])$/m.exec(table);
  const heading = /^target_heading = ([-+.\deE]+)$/m.exec(table);
  return {
    ...(corners && { footprint: JSON.parse(corners[1]).map(([x, y]) => [x / side, y / side]) }),
    ...(heading && { aim: Number(heading[1]) }),
  };
}

/**
 * Returns a world for the player, without copying its cells.
 * @param {EditedWorld} world
 * @returns {DrawnWorld}
 */
export function drawnOf(world) {
  const { width, height, cells, cell_size: side, events } = world;
  const [startX, startY, heading] = world.start;
  return {
    width,
    height,
    cell: side,
    radius: world.robot_radius / side,
    cells: "",
    start: [startX / side, startY / side, heading],
    target: /** @type {Triple} */ (world.target.map((value) => value / side)),
    events: null,
    ...kindOf(world),
    others: othersOf(world),
    open: {
      cells,
      events: events && {
        ms: Float64Array.from(events.times, (time) => time * 1000),
        ix: Float64Array.from(events.ix),
        iy: Float64Array.from(events.iy),
        state: Float64Array.from(events.state),
      },
      witness: null,
      now: null,
      done: 0,
    },
  };
}
