// Pointers, wheel and keys on the board: draw with one, pan and zoom with two fingers, the middle button or Space.

/* Listens to the board.
     draw      the page: its board, its tool in hand */
export function listenToBoard(draw) {
  const { canvas, board } = draw;
  const state = { pointers: new Map(), stroke: null, panning: null, pinch: 0, before: 0 };
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
    board.draw();
  });
  return state;
}

const how = (event) => ({ erase: (event.buttons & 2) === 2, exact: event.altKey });

function down(draw, state, event) {
  const { canvas, board } = draw;
  canvas.focus({ preventScroll: true });
  board.cursor = null;
  canvas.setPointerCapture(event.pointerId);
  state.pointers.set(event.pointerId, event);
  if (state.pointers.size === 2) {
    takeBack(draw, state, event);
    state.pinch = spread(state);
    return;
  }
  if (draw.tool === "pan" || event.button === 1) {
    state.panning = event;
    return;
  }
  state.before = draw.studio.model.past.length;
  state.stroke = how(event);
  draw.tools[draw.tool].begin(board.pointAt(event), state.stroke);
}

function stopStroke(draw, state, event) {
  if (!state.stroke) return;
  draw.tools[draw.tool].end(draw.board.pointAt(event), state.stroke);
  state.stroke = null;
}

// The first finger of two has not meant to draw.
function takeBack(draw, state, event) {
  const { model } = draw.studio;
  if (!state.stroke) return;
  stopStroke(draw, state, event);
  if (model.past.length > state.before) model.undo();
}

function spread({ pointers }) {
  const [a, b] = [...pointers.values()];
  return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
}

function move(draw, state, event) {
  const { board } = draw,
    before = state.pointers.get(event.pointerId);
  if (before) state.pointers.set(event.pointerId, event);
  if (state.pointers.size === 2 && before) {
    const now = spread(state);
    board.pan((event.clientX - before.clientX) / 2, (event.clientY - before.clientY) / 2);
    board.zoom(now / Math.max(1, state.pinch), event);
    state.pinch = now;
    return;
  }
  if (state.panning) {
    board.pan(event.clientX - state.panning.clientX, event.clientY - state.panning.clientY);
    state.panning = event;
    return;
  }
  const tool = draw.tools[draw.tool];
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
  const point = draw.board.pointAt(event);
  if (["brush", "erase"].includes(draw.tool)) draw.tools[draw.tool].drag(point, state.stroke);
}

function up(draw, state, event) {
  const known = state.pointers.delete(event.pointerId);
  if (known && state.stroke && state.pointers.size === 0) stopStroke(draw, state, event);
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

// The cursor goes by arrows; Space uses the tool there. Tools that span two cells begin at one Space and end at the next.
function keyDown(draw, state, event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const { board } = draw,
    { world } = draw.studio.model;
  const arrow = ARROWS[event.key];
  if (!arrow && event.key !== " ") return;
  event.preventDefault();
  event.stopPropagation();
  if (!board.cursor) board.cursor = [Math.floor(world.width / 2), Math.floor(world.height / 2)];
  else if (arrow) {
    const far = event.shiftKey ? 5 : 1;
    const inside = (value, most) => Math.min(most - 1, Math.max(0, value));
    board.cursor = [
      inside(board.cursor[0] + far * arrow[0], world.width),
      inside(board.cursor[1] + far * arrow[1], world.height),
    ];
  }
  const point = [board.cursor[0] + 0.5, board.cursor[1] + 0.5],
    tool = draw.tools[draw.tool];
  if (arrow && state.stroke) tool.drag(point, state.stroke);
  if (!arrow) useTool(draw, state, tool, point, event.shiftKey);
  draw.where(point);
  board.draw();
}

function useTool(draw, state, tool, point, erase) {
  if (state.stroke) {
    tool.end(point, state.stroke);
    state.stroke = null;
    return;
  }
  state.stroke = { erase, exact: false };
  tool.begin(point, state.stroke);
  if (["line", "rectangle", "select", "measure", "start"].includes(draw.tool)) return;
  tool.end(point, state.stroke);
  state.stroke = null;
}
