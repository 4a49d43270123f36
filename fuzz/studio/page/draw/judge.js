// Judges the drawing in the page, while the pointer moves: by the server's own cores, in a worker.

import { proofOf } from "#player/edit/answer.js";
import { rowsOf } from "#player/edit/grid_text.js";
import { hasMoreInFile, robotsIn } from "#player/edit/model.js";
import { openLive } from "#player/live/live.js";
import { Ended } from "#studio/shared/connection.js";
import { Refused } from "#studio/shared/refusals.js";
import { messageOf } from "#studio/shared/world_message.js";

const LARGEST = 250_000; // cells: copying a larger world for each move would delay the pointer
const NOT_HERE = { run: null, world: {}, why: "" }; // what is known before the server has answered

/**
 * Makes a judge of the drawing; it begins to work when it is opened.
 * @param {Studio} studio
 * @param {(proof: Proof | null, run: LiveRun | null, robot: string, why: string) => void} judged -
 *   Called with the answer about the current drawing: its proof, null if only the server decides
 *   that, and the run of a robot, or why there is none
 * @param {() => void} failed - Called if the page can no longer judge
 * @returns {{open: () => Promise<void>, judge: () => boolean}} `judge` returns whether `judged` will
 *   be called with a proof
 */
export function makeJudge(studio, judged, failed) {
  /** @type {{live: Live | null, isOpened: boolean, key: string, events: any, recipe: any}} */
  const state = { live: null, isOpened: false, key: "", events: null, recipe: null };

  async function open() {
    if (state.isOpened) return;
    state.isOpened = true;
    const core = await asked(studio.connection.ask("core"));
    state.live = await openLive(/** @type {any} */ (core));
    if (state.live) judge();
  }

  // Asks how to run the robot, whenever that may have changed; edits of walls, start, target and
  // radius do not change it.
  async function askRecipe() {
    const { world } = studio.model,
      { controllers, ...setup } = studio.play.setup(),
      { width, height, cell_size, robot_speed, source, events } = world;
    const key = JSON.stringify([controllers[0], setup, width, height, cell_size, robot_speed, hasMoreInFile({ source }) ? source : ""]);
    if (state.key === key && state.events === events) return;
    Object.assign(state, { key, events, recipe: null });
    const sent = messageOf(world);
    const recipe = await asked(studio.connection.ask("recipe", { ...setup, controller: controllers[0], world: hasMoreInFile(sent) ? sent : { ...sent, source: null } }));
    if (state.key !== key || state.events !== events) return;
    state.recipe = recipe && { ...recipe, robot: controllers[0], isGiven: setup.steps !== null };
    judge();
  }

  function judge() {
    const { model } = studio,
      { world, version } = model,
      { live } = state;
    if (!live || robotsIn(world) > 1 || world.cells.length > LARGEST) return false;
    askRecipe();
    const recipe = state.recipe ?? NOT_HERE,
      // The recipe knows what only the file has: a body, waypoints, a drive.
      isPlain = !world.events && (state.recipe !== null || !hasMoreInFile(world));
    if (!state.recipe && !isPlain) return false;
    const { cell_size, start, target, robot_radius: radius, robot_speed: speed } = world;
    const now = { ...recipe.world, cells: rowsOf(world), cell_size, start, target, radius, speed };
    live.judge({ world: now, run: recipe.run, edited: !recipe.isGiven }).then(
      (answer) => {
        if (!answer || version !== model.version) return;
        const proof = isPlain ? proofOf(answer.proof, answer.live.proof, world) : null;
        judged(proof, answer.run, recipe.robot ?? "", answer.live.run || recipe.why);
      },
      () => {
        state.live = null;
        failed();
      },
    );
    return isPlain;
  }

  return { open, judge };
}

// Returns the answer; null if the server refuses it, or ends.
async function asked(request) {
  try {
    return await request;
  } catch (error) {
    if (!(error instanceof Refused || error instanceof Ended)) throw error;
    return null;
  }
}
