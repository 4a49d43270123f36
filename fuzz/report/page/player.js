// The replay: a clock in steps, and a canvas that shows the run at that time.

const SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10, 25, 100, 500];
const SECONDS = 12; // that a replay takes at most, unless asked otherwise

function usualSpeed(steps, dt) {
  const seconds = steps * dt;
  return SPEEDS.find((speed) => seconds / speed <= SECONDS) || SPEEDS[SPEEDS.length - 1];
}

/* A player of one drawn world.
     canvas    where
     drawn     world, run and sensors
     changed   called whenever the time, or whether it plays, has changed */
function makePlayer(canvas, drawn, changed) {
  const { run, world } = drawn;
  const player = {
    drawn,
    step: run ? run.steps : 0,
    playing: false,
    period: false, // plays the loop's period only
    speed: run ? usualSpeed(run.steps, run.dt) : 1,
    show: { trail: true, witness: false, sensors: true, signal: true, touched: true },
    view: null, // null: the whole world
    follow: false,
    frame: 0,
    before: 0,
  };
  const draw = () => {
    if (player.follow && run) Object.assign(player.view, pick(poseAt(run, player.step), "x", "y"));
    drawScene(canvas, { world, run, sensors: drawn.sensors, step: player.step, show: player.show }, player.view);
  };
  const update = () => {
    draw();
    changed(player);
  };
  const tick = (now) => {
    if (!player.playing) return;
    const passed = Math.min(0.25, (now - player.before) / 1000);
    player.before = now;
    player.step = advanced(player, run, (passed * player.speed) / run.dt);
    if (player.step >= run.steps && !run.loop) player.playing = false;
    else player.frame = requestAnimationFrame(tick);
    update();
  };
  return Object.assign(player, {
    draw,
    update,
    go(step) {
      player.step = Math.min(run ? run.steps : 0, Math.max(0, step));
      update();
    },
    play(on) {
      if (!run || on === player.playing) return;
      player.playing = on;
      cancelAnimationFrame(player.frame);
      if (on) {
        if (player.step >= run.steps) player.step = player.period ? run.loop[0] : 0;
        player.before = performance.now();
        player.frame = requestAnimationFrame(tick);
      }
      update();
    },
    zoom(factor) {
      const now = player.view || fitView(world, canvas.clientWidth, canvas.clientHeight);
      const least = fitView(world, canvas.clientWidth, canvas.clientHeight).scale;
      const scale = Math.min(400, now.scale * factor);
      player.view = scale <= least && factor < 1 ? null : { ...now, scale };
      player.follow = player.follow && player.view !== null;
      update();
    },
    fit() {
      player.view = null;
      player.follow = false;
      update();
    },
    robot() {
      if (!run) return;
      const around = Math.max(7 * world.radius, 6); // cells that are seen around it
      const fitted = fitView(world, canvas.clientWidth, canvas.clientHeight).scale;
      player.view = { x: 0, y: 0, scale: Math.max(fitted * 1.5, Math.min(canvas.clientWidth, canvas.clientHeight) / around) };
      player.follow = true;
      update();
    },
    move(dx, dy) {
      if (!player.view) return;
      player.follow = false;
      player.view = { ...player.view, x: player.view.x - dx / player.view.scale, y: player.view.y + dy / player.view.scale };
      update();
    },
  });
}

// The time after some more steps: a loop goes on where it was entered, one period later.
function advanced(player, run, more) {
  const step = player.step + more;
  if (!run.loop) return Math.min(run.steps, step);
  const [entry, period] = run.loop;
  const from = player.period && step < entry ? entry : step;
  return from < entry + period ? from : entry + ((from - entry) % period);
}

function pick(thing, ...names) {
  return Object.fromEntries(names.map((name) => [name, thing[name]]));
}
