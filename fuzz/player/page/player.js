// The replay: a clock that counts steps, and a canvas that shows the run at that time.

import { poseAt, stepWithin } from "#player/decode.js";
import { SHOWN, drawScene, runScene } from "#player/picture/map.js";
import { fitView } from "#player/picture/pen.js";
import { eventView } from "#player/picture/view.js";

const VISIBLE = 40; // pixels: diameter of a robot in a view of what happens

export const SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10, 25, 100, 500];
const SECONDS = 12; // longest duration of a replay at the default speed

/**
 * @param {number} steps
 * @param {number} dt
 * @returns {number}
 */
export function usualSpeed(steps, dt) {
  const seconds = steps * dt;
  return SPEEDS.find((speed) => seconds / speed <= SECONDS) || SPEEDS[SPEEDS.length - 1];
}

/**
 * Makes a player of one drawn world.
 * @param {HTMLCanvasElement} canvas
 * @param {Drawn} drawn
 * @param {(player: Player) => void} changed - Called when the time changes, or when playing starts
 *   or stops
 * @returns {Player}
 */
export function makePlayer(canvas, drawn, changed) {
  const { run, world } = drawn;
  const last = lastStep(drawn);
  /** @type {Omit<Player, keyof Clock | keyof Camera>} */
  const own = {
    drawn,
    canvas,
    step: last,
    last,
    isOverview: !drawn.beside, // show the whole run until the reader chooses a time
    playing: false,
    period: false, // plays only the loop's period
    speed: run ? usualSpeed(last, run.dt) : 1,
    show: { ...SHOWN },
    drawnMore: null, // called after each frame, while both runs are saved to a file
    view: null, // null: the whole world
    follow: false,
    draw() {
      const { run } = player.drawn;
      if (player.follow && player.view && run) {
        const { x, y } = poseAt(run, stepWithin(run, player.step));
        player.view = { ...player.view, x, y };
      }
      if (drawn.paint) drawn.paint(player);
      else drawScene(canvas, { ...player.drawn, world, run, step: player.step, show: player.show, whole: player.isOverview }, player.view);
      const { beside } = drawn;
      if (beside) drawBeside(player, beside);
      if (player.drawnMore) player.drawnMore();
    },
    update() {
      player.draw();
      changed(player);
    },
    reveal(name, on) {
      // What the robot senses belongs to a time.
      if (name === "sensors") player.isOverview = false;
      player.show[name] = on;
      player.update();
    },
  };
  const player = /** @type {Player} */ (own);
  return Object.assign(player, clockOf(player), cameraOf(player));
}

/**
 * Draws the other run at the same time, with its world zoomed and shifted like the one in front.
 * @param {Player} player
 * @param {Beside} beside
 */
function drawBeside(player, beside) {
  const { canvas, view, show, follow, drawn } = player;
  const step = sameTime(player.step, drawn.run, beside.run);
  /** @type {View | null} */
  let own = null;
  if (view) {
    const whole = fitView(beside.world, beside.canvas.clientWidth, beside.canvas.clientHeight);
    const nearer = view.scale / fitView(drawn.world, canvas.clientWidth, canvas.clientHeight).scale;
    own = { x: (view.x * beside.world.width) / drawn.world.width, y: (view.y * beside.world.height) / drawn.world.height, scale: whole.scale * nearer };
    if (follow && beside.run) {
      const { x, y } = poseAt(beside.run, stepWithin(beside.run, step));
      own = { x, y, scale: view.scale };
    }
  }
  drawScene(beside.canvas, { ...beside, step, show }, own);
}

/**
 * Return the end of the longest run, in steps of the one in front.
 * @param {Drawn} drawn
 * @returns {number}
 */
function lastStep({ run, others, beside }) {
  if (!run) return 0;
  const all = [...(others || []), beside].flatMap((other) => (other?.run ? [other.run] : []));
  return Math.max(run.steps, ...all.map((other) => Math.round(sameTime(other.steps, other, run))));
}

/**
 * Return the step of another run at the time of this run's step.
 * @param {number} step
 * @param {DrawnRun | null} run
 * @param {DrawnRun | null} other
 * @returns {number}
 */
function sameTime(step, run, other) {
  return run && other ? (step * run.dt) / other.dt : 0;
}

/**
 * @param {Player} player
 * @returns {Clock}
 */
function clockOf(player) {
  let frame = 0,
    before = 0;
  const tick = (now) => {
    const { run } = player.drawn;
    if (!run) return;
    // a frame's time may be earlier than the call of play()
    const passed = Math.max(0, Math.min(0.25, (now - before) / 1000));
    before = now;
    player.step = advanced(player, run, (passed * player.speed) / run.dt);
    player.playing = goesRound(player, run) || player.step < player.last;
    if (player.playing) frame = requestAnimationFrame(tick);
    player.update();
  };
  return {
    go(step) {
      player.isOverview = false;
      player.step = Math.min(player.last, Math.max(0, step));
      player.update();
    },
    play(on) {
      const { run } = player.drawn;
      if (!run || on === player.playing) return;
      player.isOverview = false;
      player.playing = on;
      cancelAnimationFrame(frame);
      if (on) {
        if (player.step >= player.last) player.step = player.period && run.loop ? run.loop[0] : 0;
        before = performance.now();
        frame = requestAnimationFrame(tick);
      }
      player.update();
    },
  };
}

/**
 * @param {Player} player
 * @returns {Camera}
 */
function cameraOf(player) {
  const { canvas } = player;
  const { world } = player.drawn;
  const whole = () => fitView(world, canvas.clientWidth, canvas.clientHeight);
  return {
    zoom(factor) {
      const now = player.view || whole(),
        scale = Math.min(400, now.scale * factor);
      player.view = scale > whole().scale ? { ...now, scale } : null;
      player.follow = player.follow && player.view !== null;
      player.update();
    },
    fit() {
      player.view = null;
      player.follow = false;
      player.update();
    },
    robot() {
      const around = Math.max(7 * world.radius, 6); // visible cells around it
      const scale = Math.min(canvas.clientWidth, canvas.clientHeight) / around;
      player.view = { x: 0, y: 0, scale: Math.max(1.5 * whole().scale, scale) };
      player.follow = true;
      player.update();
    },
    event() {
      const { run } = player.drawn;
      if (!run) return;
      const scene = runScene({ ...player.drawn, run, show: player.show, step: player.last, whole: true }, run);
      player.view = eventView(scene, canvas.clientWidth, canvas.clientHeight, VISIBLE);
      player.follow = false;
      player.update();
    },
    move(dx, dy) {
      if (!player.view) return;
      player.follow = false;
      const { x, y, scale } = player.view;
      player.view = { x: x - dx / scale, y: y + dy / scale, scale };
      player.update();
    },
  };
}

/**
 * Return whether the clock repeats a loop; if other runs are longer, it does so only while the
 * period alone is played.
 * @param {Player} player
 * @param {DrawnRun} run
 */
function goesRound(player, run) {
  return run.loop !== null && (player.period || player.last === run.steps);
}

/**
 * Return the time after some more steps; a loop continues from its entry, one period later.
 * @param {Player} player
 * @param {DrawnRun} run
 * @param {number} more
 * @returns {number}
 */
function advanced(player, run, more) {
  const step = player.step + more;
  if (!run.loop || !goesRound(player, run)) return Math.min(player.last, step);
  const [entry, period] = run.loop;
  const from = player.period && step < entry ? entry : step;
  return from < entry + period ? from : entry + ((from - entry) % period);
}
