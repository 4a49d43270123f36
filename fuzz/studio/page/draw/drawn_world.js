// The drawn world as the player draws it, so that it is visible before the server has answered.

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
