// The edited world as the player draws it.

import { frontOf } from "#player/picture/pen.js";

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
 * Returns the first robot's footprint and waypoints, in cells, and its goal's heading, from the text
 * of its file, which the server writes; the page cannot change them.
 * @param {{source: string | null, cell_size: number}} world
 * @returns {{footprint?: [number, number][], aim?: number, waypoints?: Triple[]}}
 */
export function kindOf({ source, cell_size: side }) {
  if (!source?.startsWith("%worldgen-grid 2")) return {};
  const table = source.slice(0, source.indexOf("%cells")).split("[[robot]]")[1] ?? "";
  const corners = /^footprint = (\[\[[-+.,\deE[\] ]*\]\])$/m.exec(table);
  const heading = /^target_heading = ([-+.\deE]+)$/m.exec(table);
  const waypoints = /^waypoints = \[.*\]$/m.exec(table)?.[0].matchAll(/\btarget = (\[[-+.,\de ]*\])/g);
  return {
    ...(corners && { footprint: JSON.parse(corners[1]).map(([x, y]) => [x / side, y / side]) }),
    ...(heading && { aim: Number(heading[1]) }),
    ...(waypoints && { waypoints: Array.from(waypoints, ([, goal]) => /** @type {Triple} */ (JSON.parse(goal).map((value) => value / side))) }),
  };
}

/**
 * Returns the end of the line that shows the start's heading, in cells.
 * @param {EditedWorld} world
 * @returns {CellPlace}
 */
export function headingTip(world) {
  const [x, y, heading] = world.start,
    side = world.cell_size,
    far = frontOf(kindOf(world).footprint, world.robot_radius / side) + 0.6;
  return [x / side + Math.cos(heading) * far, y / side + Math.sin(heading) * far];
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
