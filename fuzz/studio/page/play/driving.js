// Driving a robot by hand: keys become commands, and the server runs the robot from the start
// with all of them.

import { el } from "#player/dom.js";
import { Ended } from "#studio/shared/connection.js";
import { addSteps, commandOf, directionOf } from "#studio/play/commands.js";
import { Refused } from "#studio/shared/refusals.js";

const EVERY = 100; // ms between two requests
const PACE = 0.25; // share of real time: a robot crosses a small world in two seconds
const HELP = "Drive with the arrow keys, W A S D, or the buttons in the picture, at a quarter of real speed. Escape stops.";
const PAD = [["ArrowUp", "↑", "Forward"], ["ArrowLeft", "←", "Turn left"], ["ArrowDown", "↓", "Back"], ["ArrowRight", "→", "Turn right"]];

/**
 * Makes the button Drive and the pad of arrows for touch, and handles the user's driving.
 * @param {object} uses
 * @param {() => Promise<object | null>} uses.begin - Runs the chosen robots; returns the settings
 *   of the run, or null
 * @param {(message: Messages["drive"]["request"]) => Promise<any>} uses.ask - Asks the server for the run so far
 * @param {(robot: any) => void} uses.show - Shows the run so far, at its last step
 * @param {(words: string, isBad?: boolean) => void} uses.tell
 */
export function makeDriving(uses) {
  const button = el("button", { type: "button", id: "drive", title: "Drive a robot by hand", onclick: () => (state.drive ? stop() : begin()) }, "Drive");
  /** @type {{drive: any}} */
  const state = { drive: null };
  const pad = el("div", { class: "drive-pad", role: "group", "aria-label": "Drive", hidden: true }, PAD.map(([key, sign, words]) => arrow(key, sign, words)));

  // An arrow acts like its key, for as long as it is held down; several fingers may hold several.
  function arrow(key, sign, words) {
    const part = el("button", { type: "button", "aria-label": words, "data-key": key }, sign);
    const loose = () => state.drive?.held.delete(key);
    part.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      event.stopPropagation();
      part.setPointerCapture(event.pointerId);
      state.drive?.held.add(key);
    });
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) part.addEventListener(name, loose);
    part.addEventListener("contextmenu", (event) => event.preventDefault());
    return part;
  }

  async function begin() {
    const message = await uses.begin();
    if (!message || state.drive) return;
    const drive = { message, commands: [], held: new Set(), due: 0, isAsking: false, timer: 0, robot: null };
    state.drive = drive;
    button.textContent = "Stop";
    pad.hidden = false;
    uses.tell(HELP);
    addEventListener("keydown", press, { capture: true });
    addEventListener("keyup", release, { capture: true });
    addEventListener("blur", letGo);
    drive.timer = setInterval(tick, EVERY);
  }

  function end(words = "") {
    const { drive } = state;
    if (!drive) return;
    state.drive = null;
    clearInterval(drive.timer);
    removeEventListener("keydown", press, { capture: true });
    removeEventListener("keyup", release, { capture: true });
    removeEventListener("blur", letGo);
    button.textContent = "Drive";
    pad.hidden = true;
    uses.tell(words);
  }

  // Ends the drive at the user's wish; the run so far stays.
  function stop() {
    const robot = state.drive?.robot;
    end();
    if (robot) uses.show({ ...robot, verdict: "stopped by you" });
  }

  // While the user drives, the page's shortcuts and its fields ignore the keys.
  function press(event) {
    const direction = directionOf(event.key);
    if (event.ctrlKey || event.metaKey || event.altKey || !(direction || event.key === "Escape")) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (direction) state.drive.held.add(event.key);
    else stop();
  }

  function release(event) {
    state.drive?.held.delete(event.key);
  }

  function letGo() {
    state.drive?.held.clear();
  }

  async function tick() {
    const { drive } = state;
    // With a long time step, each tick is a step.
    drive.due += Math.max((EVERY * PACE) / 1000 / drive.message.time_step, drive.message.time_step > 1 ? 1 : 0);
    const steps = Math.floor(drive.due);
    // The clock starts with the first key and does not wait for answers.
    if (drive.commands.length === 0 && drive.held.size === 0) drive.due = 0;
    else if (steps > 0) {
      drive.due -= steps;
      addSteps(drive.commands, steps, commandOf(drive.held));
      if (!drive.isAsking) await ask(drive);
    }
  }

  async function ask(drive) {
    drive.isAsking = true;
    try {
      const robot = await uses.ask({ ...drive.message, commands: drive.commands.map((one) => [...one]) });
      if (state.drive !== drive) return;
      drive.robot = robot;
      uses.show(robot);
      if (robot.ended) end(`You drove ${robot.time.toFixed(2)} s under ${robot.motion}: ${[robot.verdict, robot.why].filter(Boolean).join(" ")}.`);
    } catch (error) {
      if (!(error instanceof Refused || error instanceof Ended)) throw error;
      if (state.drive !== drive) return;
      end();
      uses.tell(error.message, error instanceof Refused);
    } finally {
      drive.isAsking = false;
    }
  }

  return { button, pad, end, begin };
}
