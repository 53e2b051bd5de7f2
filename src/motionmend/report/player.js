// The player: what is shown (app), the controls that change it, the clock, and window.report for scripts.

const WORDS = ["measured", "repaired", "filled", "left open"];

async function start() {
  const given = JSON.parse(document.getElementById("data").textContent);
  const recordings = await Promise.all(given.recordings.map(unpackRecording));
  const reference = recordings[given.reference];
  const element = (id) => document.getElementById(id);
  const app = {
    recordings, reference: given.reference, ground: given.ground,
    duration: Math.max(...recordings.map((r) => r.duration)),
    time: 0, window: [0, 1], playing: false, speed: 1,
    layout: "overlay", follow: true, grid: true, edges: true, marks: true,
    channel: firstChannel(reference), provenance: reference, theme: readTheme(),
  };
  app.span = Math.max(app.duration, 1 / reference.fps);  // of the time axis: one frame has a width too
  app.window = [0, app.span];

  let pending = false;
  const scene = createScene(element("view"), app);
  const timeline = createTimeline(element("timeline"), app);

  app.frame = () => Math.floor(app.time * reference.fps + 1e-6);
  // What the legend covers of the view where it floats on it, pixels.
  app.headroom = () => (getComputedStyle(element("legend")).position === "absolute" ? element("legend").offsetHeight + 12 : 0);
  app.redraw = () => {
    if (!pending) { pending = true; requestAnimationFrame(drawNow); }
  };
  app.seek = (time) => {
    const frame = Math.round(Math.min(app.duration, Math.max(0, time)) * reference.fps);
    app.time = Math.min(frame, Math.floor(app.duration * reference.fps + 1e-6)) / reference.fps;
    timeline.follow();
    app.redraw();
  };
  app.choose = (channel) => {
    if (!recordings.some((r) => r.channelOf.has(channel))) return;
    app.channel = channel;
    element("channel").value = channel;
    timeline.layout();
    app.redraw();
  };
  app.choosePoint = (recording, j) => {
    if (recording.markers) return app.choose(recording.channels[j]);
    const parent = new Map(recording.lines.map(([a, b]) => [b, a]));
    for (let at = j; at !== undefined; at = parent.get(at)) {
      const channel = recording.channelPoint.indexOf(at);
      if (channel >= 0) return app.choose(recording.channels[channel]);
    }
  };
  app.hover = (hit, x, y) => {
    const tip = element("tip");
    tip.hidden = !hit;
    element("view").style.cursor = hit ? "pointer" : "";
    if (!hit) return;
    tip.textContent = `${hit.recording.points[hit.j]} · ${hit.recording.name}`;
    tip.style.transform = `translate(${x + 12}px, ${y - 26}px)`;
  };

  function drawNow() {
    pending = false;
    scene.draw();
    timeline.moveCursor();
    readout(app, element);
  }

  function setPlaying(playing) {
    app.playing = playing;
    element("play").setAttribute("aria-label", playing ? "pause" : "play");
    element("play").classList.toggle("playing", playing);
    if (!playing) return;
    let last = performance.now();
    const turn = (now) => {
      if (!app.playing) return;
      app.time += (Math.max(0, now - last) / 1000) * app.speed;
      last = now;
      if (app.time > app.duration + 0.5 / reference.fps) app.time = 0;  // round again
      else app.time = Math.min(app.time, app.duration);
      timeline.follow();
      drawNow();
      requestAnimationFrame(turn);
    };
    requestAnimationFrame(turn);
  }

  function step(frames) {
    setPlaying(false);
    app.seek((app.frame() + frames * reference.stride) / reference.fps);
  }

  function layout() {
    scene.resize();
    timeline.layout();
    drawNow();
  }

  addLegend(app, element, layout);
  addChoices(app, element, { layout, timeline, scene });
  addTransport(app, element, { setPlaying, step, timeline });
  for (const button of document.querySelectorAll(".jump")) {
    button.addEventListener("click", () => {
      const recording = recordings[button.dataset.recording];
      app.choose(recording.channels[button.dataset.channel]);
      if (button.dataset.frame) app.seek(Number(button.dataset.frame) / recording.fps);
    });
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { app.theme = readTheme(); layout(); });
  new ResizeObserver(layout).observe(element("stage"));
  document.body.classList.remove("loading");
  layout();

  window.report = {
    setFrame(frame) {
      setPlaying(false);
      app.seek(frame / reference.fps);
      drawNow();
    },
    state: () => ({
      frame: app.frame(), time: app.time, frames: reference.frames, duration: app.duration,
      playing: app.playing, speed: app.speed, layout: app.layout, follow: app.follow, grid: app.grid,
      edges: app.edges, marks: app.marks, channel: app.channel, provenance: app.provenance.name,
      window: [...app.window], camera: { ...scene.camera },
      recordings: recordings.map((r) => ({ name: r.name, visible: r.visible, frame: frameAt(r, app.time) })),
    }),
  };
}

// Start with the channel that needs explaining most: the one with the most samples not measured.
function firstChannel(recording) {
  let best = 0, most = 0;
  for (let c = 0; c < recording.channels.length; c++) {
    let count = 0;
    for (let t = 0; t < recording.drawn; t++) count += stateAt(recording, c, t) !== MEASURED;
    if (count > most) { most = count; best = c; }
  }
  return recording.channels[best];
}

function readTheme() {
  const style = getComputedStyle(document.documentElement), read = (name) => style.getPropertyValue(name).trim();
  const names = ["ink", "faint", "line", "paper", "floor", "shadow"];
  const theme = Object.fromEntries(names.map((n) => [n, read(`--${n}`)]));
  theme.colours = [0, 1, 2, 3, 4, 5].map((i) => read(`--c${i}`));
  theme.states = ["measured", "repaired", "filled", "open"].map((n) => read(`--${n}`));
  let pattern = null;
  theme.hatch = (context) => (pattern ||= hatching(context, theme));
  return theme;
}

// Left open is hatched: told apart without colour.
function hatching(context, theme) {
  const tile = document.createElement("canvas");
  tile.width = tile.height = 6;
  const pen = tile.getContext("2d");
  pen.fillStyle = theme.paper;
  pen.fillRect(0, 0, 6, 6);
  pen.strokeStyle = theme.states[LEFT_OPEN];
  pen.lineWidth = 2;
  pen.beginPath();
  for (const d of [-6, 0, 6]) { pen.moveTo(d - 1, 7); pen.lineTo(d + 7, -1); }
  pen.stroke();
  return context.createPattern(tile, "repeat");
}

function readout(app, element) {
  const reference = app.recordings[app.reference];
  element("frame").textContent = `${app.frame()} / ${reference.frames - 1}`;
  element("time").textContent = `${app.time.toFixed(3)} s`;
  element("now").textContent = happening(app);
  const values = app.recordings.filter((r) => r.visible && r.channelOf.has(app.channel)).map((r) => {
    const frame = frameAt(r, app.time);
    return frame < 0 ? `${r.name} ended` : `${r.name} ${valueText(r, r.channelOf.get(app.channel), frame)}`;
  });
  element("values").textContent = values.join("  ·  ");
}

function valueText(recording, channel, frame) {
  const curves = curvesOf(recording, channel), unit = curves[0].unit === "°" ? "°" : " m";
  const digits = unit === "°" ? 2 : 3, values = curves.map((c) => curveValue(recording, c, frame));
  if (values.some((v) => v !== v)) return "missing";
  const std = stdValue(recording, channel, curves[0], frame);
  const band = std === std ? (unit === "°" ? ` ± ${std.toFixed(2)}` : ` ± ${(std * 1000).toFixed(1)} mm`) : "";
  const text = values.map((v) => v.toFixed(digits)).join(", ");
  return unit === "°" ? `${text}${band}°` : `${text} m${band}`;
}

// One line about this frame: how many samples are not measured, and the names of a few.
function happening(app) {
  const recording = app.provenance, frame = frameAt(recording, app.time);
  if (frame < 0) return `${recording.name} has ended`;
  const names = [[], [], [], []];
  recording.channels.forEach((name, c) => names[stateAt(recording, c, frame)].push(name));
  const parts = [REPAIRED, FILLED, LEFT_OPEN].filter((s) => names[s].length).map((s) => {
    const word = s === LEFT_OPEN && !recording.repaired ? "missing" : WORDS[s];
    const list = names[s].slice(0, 4).join(", ") + (names[s].length > 4 ? ", …" : "");
    return `${names[s].length} ${word} (${list})`;
  });
  if (parts.length) return parts.join(" · ");
  return recording.repaired ? "every sample of this frame was measured" : "no sample of this frame is missing";
}

function addLegend(app, element, layout) {
  const legend = element("legend");
  app.recordings.forEach((recording) => {
    const label = document.createElement("label"), box = document.createElement("input");
    const swatch = document.createElement("i"), name = document.createElement("span");
    box.type = "checkbox";
    box.checked = true;
    box.dataset.recording = recording.index;
    swatch.className = `swatch c${recording.colour}`;
    name.textContent = recording.name;
    label.append(box, swatch, name);
    legend.append(label);
    box.addEventListener("change", () => { recording.visible = box.checked; layout(); });
  });
  const key = element("key"), reference = app.recordings[app.reference];
  const shown = reference.repaired ? [MEASURED, REPAIRED, FILLED, LEFT_OPEN] : [MEASURED, LEFT_OPEN];
  for (const state of shown) {
    const item = document.createElement("span"), chip = document.createElement("i");
    chip.className = `chip ${["measured", "repaired", "filled", "left_open"][state]}`;
    item.append(chip, state === LEFT_OPEN && !reference.repaired ? "missing" : WORDS[state]);
    key.append(item);
  }
}

function addChoices(app, element, { layout, timeline, scene }) {
  const channel = element("channel"), provenance = element("provenance");
  const names = [...new Set([app.recordings[app.reference], ...app.recordings].flatMap((r) => r.channels))];
  channel.append(...names.map((name) => new Option(name, name)));
  channel.value = app.channel;
  channel.addEventListener("change", () => app.choose(channel.value));
  provenance.append(...app.recordings.map((r) => new Option(r.name, r.index)));
  provenance.value = app.reference;
  provenance.closest("label").hidden = app.recordings.length < 2;
  provenance.addEventListener("change", () => { app.provenance = app.recordings[provenance.value]; layout(); });
  for (const name of ["follow", "grid", "edges", "marks"]) {
    const box = element(name);
    box.addEventListener("change", () => { app[name] = box.checked; app.redraw(); });
  }
  element("edges").closest("label").hidden = !app.recordings.some((r) => r.markers && r.lines.length);
  element("marks").closest("label").hidden = !app.recordings.some((r) => r.state.some((s) => s !== MEASURED));
  const side = element("side");
  side.closest("label").hidden = app.recordings.length < 2;
  side.addEventListener("change", () => { 
    app.layout = side.checked ? "side" : "overlay";
    element("stage").classList.toggle("tall", side.checked && app.recordings.length > 3);
    layout();
  });
  const first = { ...scene.camera };
  const angles = { start: first, front: { yaw: -Math.PI / 2, pitch: 0.05 }, side: { yaw: 0, pitch: 0.05 }, top: { yaw: -Math.PI / 2, pitch: 1.55 } };
  for (const button of document.querySelectorAll("[data-angle]")) {
    button.addEventListener("click", () => { Object.assign(scene.camera, { zoom: 1 }, angles[button.dataset.angle]); app.redraw(); });
  }
  element("widen").addEventListener("click", () => timeline.zoom(2));
  element("narrow").addEventListener("click", () => timeline.zoom(0.5));
  element("fit").addEventListener("click", () => timeline.fit());
}

function addTransport(app, element, { setPlaying, step, timeline }) {
  element("play").addEventListener("click", () => setPlaying(!app.playing));
  element("back").addEventListener("click", () => step(-1));
  element("forward").addEventListener("click", () => step(1));
  const speed = element("speed");
  speed.addEventListener("change", () => { app.speed = Number(speed.value); });
  const toggle = (name) => element(name).click();
  const keys = {
    ArrowLeft: (event) => step(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => step(event.shiftKey ? 10 : 1),
    Home: () => app.seek(0),
    End: () => app.seek(app.duration),
    " ": () => setPlaying(!app.playing),
    "+": () => timeline.zoom(0.5), "=": () => timeline.zoom(0.5), "-": () => timeline.zoom(2), 0: () => timeline.fit(),
    f: () => toggle("follow"), g: () => toggle("grid"), s: () => app.recordings.length > 1 && toggle("side"),
  };
  document.addEventListener("keydown", (event) => {
    const at = event.target.closest("select, button, summary, input:not([type=range])");
    // A focused control keeps its own keys: letters and arrows in a list, space on a button or box.
    if (event.ctrlKey || event.metaKey || event.altKey || (at && (at.matches("select") || event.key === " "))) return;
    if (!Object.hasOwn(keys, event.key)) return;
    event.preventDefault();
    keys[event.key](event);
  });
}

start().catch((error) => {
  document.body.classList.remove("loading");
  const note = document.getElementById("failed");
  note.hidden = false;
  note.textContent = `The player could not start (${error.message}). It needs a browser from 2023 or later; the tables below need none.`;
  throw error;
});
