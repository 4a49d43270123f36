// Pointers, wheel and keys on the board: draw with one finger; pan and zoom with two,
// or with wheel and middle button.

/**
 * Starts listening to the board, and gives `draw` two functions: `cancel` takes back the current
 * stroke, if there is one, and `cancelKeys` does so if keys have begun it.
 * @param {any} draw - The page: its `canvas`, `board`, `tools`, the name of the current `tool`;
 *   `say` announces what a key has done, and `where` shows the point under the pointer, in cells
 */
export function listenToBoard(draw) {
  const { canvas, board } = draw;
  /** @type {any} */
  const state = { pointers: new Map(), stroke: null, panning: null, pinch: null, before: null };
  canvas.addEventListener("pointerdown", (event) => down(draw, state, event));
  canvas.addEventListener("pointermove", (event) => move(draw, state, event));
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => up(draw, state, event));
  canvas.addEventListener("pointerleave", () => leave(draw, state));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      board.zoom(Math.exp(-Math.max(-200, Math.min(200, event.deltaY)) / 500), event);
    },
    { passive: false },
  );
  canvas.addEventListener("keydown", (event) => keyDown(draw, state, event));
  canvas.addEventListener("blur", () => {
    board.cursor = null;
    draw.cancelKeys();
    leave(draw, state);
  });
  draw.cancel = () => takeBack(draw, state);
  draw.cancelKeys = () => state.stroke?.byKeys && takeBack(draw, state);
}

const how = (event) => ({ erase: (event.buttons & 2) === 2, exact: event.altKey, straight: event.shiftKey });

function down(draw, state, event) {
  const { canvas, board } = draw;
  canvas.focus({ preventScroll: true });
  board.cursor = null;
  canvas.setPointerCapture(event.pointerId);
  state.pointers.set(event.pointerId, event);
  if (state.pointers.size === 2) {
    takeBack(draw, state);
    state.pinch = pinchOf(state);
    return;
  }
  if (draw.tool === "pan" || event.button === 1) {
    state.panning = event;
    return;
  }
  draw.cancelKeys();
  // otherwise another button was pressed while drawing
  if (!state.stroke) begin(draw, state, board.pointAt(event), how(event));
}

function begin(draw, state, point, how) {
  const { board } = draw,
    { past, future } = board.model;
  state.before = { steps: past.length, future, selection: board.selection, measure: board.measure };
  state.stroke = { ...how, tool: draw.tools[draw.tool] };
  state.stroke.tool.begin(point, state.stroke);
}

function stopStroke(state) {
  if (!state.stroke) return;
  state.stroke.tool.end(state.stroke);
  state.stroke = null;
}

// Cancels the current stroke, because a second finger came down or Escape was pressed;
// returns whether there was one.
function takeBack(draw, state) {
  const { model } = draw.board,
    { steps, future, selection, measure } = state.before || {};
  if (!state.stroke) return false;
  stopStroke(state);
  while (model.past.length > steps) model.undo();
  model.future = future; // restores what had been undone before, without the cancelled stroke
  Object.assign(draw.board, { selection, measure, marks: [], ghost: null });
  model.touch();
  return true;
}

// Returns the distance between two fingers, and the point between them.
function pinchOf({ pointers }) {
  const [a, b] = [...pointers.values()];
  return {
    wide: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY),
    clientX: (a.clientX + b.clientX) / 2,
    clientY: (a.clientY + b.clientY) / 2,
  };
}

function move(draw, state, event) {
  const { board } = draw,
    before = state.pointers.get(event.pointerId);
  if (before) state.pointers.set(event.pointerId, event);
  if (state.pointers.size === 2 && before) {
    const now = pinchOf(state),
      last = state.pinch;
    board.pan(now.clientX - last.clientX, now.clientY - last.clientY);
    // the point between the fingers stays in place
    board.zoom(now.wide / Math.max(1, last.wide), now);
    state.pinch = now;
    return;
  }
  if (state.panning) {
    board.pan(event.clientX - state.panning.clientX, event.clientY - state.panning.clientY);
    state.panning = event;
    return;
  }
  if (state.stroke) state.stroke.straight = event.shiftKey;
  const tool = state.stroke ? state.stroke.tool : draw.tools[draw.tool];
  for (const one of state.stroke && event.getCoalescedEvents ? event.getCoalescedEvents() : []) drag(draw, state, one);
  const point = board.pointAt(event);
  if (state.stroke) tool.drag(point, state.stroke);
  else if (tool.hover) {
    tool.hover(point);
    board.draw();
  }
  draw.where(point);
}

function drag(draw, state, event) {
  const { brush, erase } = draw.tools,
    { tool } = state.stroke;
  if (tool === brush || tool === erase) tool.drag(draw.board.pointAt(event), state.stroke);
}

function up(draw, state, event) {
  const known = state.pointers.delete(event.pointerId);
  if (known && state.stroke && state.pointers.size === 0) stopStroke(state);
  state.panning = null;
}

function leave(draw, state) {
  if (state.stroke) return;
  draw.board.marks = [];
  draw.board.ghost = null;
  draw.board.draw();
  draw.where(null);
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };

// Moves the cursor with the arrow keys and uses the tool with Space. Tools that span two cells need
// Space at each.
function keyDown(draw, state, event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const { board } = draw,
    arrow = ARROWS[event.key];
  if (!arrow && event.key !== " ") return;
  event.preventDefault();
  event.stopPropagation();
  moveCursor(draw, arrow, event.shiftKey ? 5 : 1);
  const point = [board.cursor[0] + 0.5, board.cursor[1] + 0.5];
  if (!arrow) useTool(draw, state, point, event.shiftKey);
  else if (state.stroke) state.stroke.tool.drag(point, state.stroke);
  else draw.tools[draw.tool].hover?.(point); // preview of the tool's effect here
  draw.where(point);
  draw.say(cellWords(board.model.world, board.cursor));
  board.draw();
}

// Moves the cursor, which starts in the middle of the visible part, and keeps it visible.
function moveCursor({ board }, arrow, far) {
  const { world } = board.model,
    inside = (value, most) => Math.min(most - 1, Math.max(0, Math.floor(value)));
  const { x, y } = board.now();
  const [ix, iy] = board.cursor || [x, y],
    [dx, dy] = (board.cursor && arrow) || [0, 0];
  board.cursor = [inside(ix + far * dx, world.width), inside(iy + far * dy, world.height)];
  board.reveal(board.cursor);
}

// Describes the cell under the cursor for screen readers.
function cellWords(world, [ix, iy]) {
  const here = ([x, y]) => Math.floor(x / world.cell_size) === ix && Math.floor(y / world.cell_size) === iy;
  const there = [world.cells[iy * world.width + ix] ? "wall" : "free", here(world.start) && "start", here(world.target) && "target"];
  return `${ix}, ${iy}: ${there.filter(Boolean).join(", ")}`;
}

function useTool(draw, state, point, erase) {
  if (!state.stroke) {
    begin(draw, state, point, { erase, exact: false, byKeys: true });
    if (["line", "rectangle", "select", "measure", "start"].includes(draw.tool)) return;
  }
  stopStroke(state);
}
