// The live page: hears who is there and what the client looked at does, and draws it.

function startLive() {
  const element = (id) => document.getElementById(id);
  const app = {
    recordings: [], reference: 1, ground: 0, time: 0, layout: "overlay",
    follow: true, grid: true, edges: true, marks: true, channel: null, theme: readColours(),
    headroom: () => element("legend").offsetHeight + 12,
  };
  const live = { who: { clients: [], client: 0 }, frame: null, received: 0, open: false, times: [], follow: true };
  let scene = null, socket = null, pending = false, wait = 500;

  app.redraw = () => {
    if (!pending) { pending = true; requestAnimationFrame(() => { pending = false; draw(); }); }
  };
  app.hover = (hit, x, y) => {
    const tip = element("tip");
    tip.hidden = !hit;
    if (!hit) return;
    tip.textContent = `${hit.recording.points[hit.j]} · ${hit.recording.name}`;
    tip.style.transform = `translate(${x + 12}px, ${y - 26}px)`;
  };
  app.choosePoint = (recording, j) => choose(recording.points[j]);

  function choose(name) {
    app.channel = app.channel === name ? null : name;
    app.redraw();
  }

  function draw() {
    if (!scene) return;
    scene.draw();
    if (live.frame) tell(app, live, element);
  }

  function fit() {
    if (!scene) return;
    scene.resize();
    draw();
  }

  // Another client, or other joints: bodies, table and scene begin anew.
  function meet(who) {
    const before = live.who;
    live.who = who;
    listClients(who, element("client"));
    const same = before.client === who.client && JSON.stringify(before.names) === JSON.stringify(who.names);
    element("hint").hidden = who.clients.length > 0;
    if (same && app.recordings.length) return;
    live.frame = null;
    app.channel = null;
    app.ground = Infinity;
    app.recordings = who.names
      ? [createBody(0, "raw", 1, who), createBody(1, "corrected", 0, who)] : [];
    for (const body of app.recordings) body.visible = element(`show-${body.name}`).checked;
    fillTable(who.names || [], element("joints").tBodies[0], choose);
    const view = element("view");
    if (!app.recordings.length) {
      view.getContext("2d").clearRect(0, 0, view.width, view.height);
      return;
    }
    const camera = scene ? { ...scene.camera } : { yaw: -Math.PI / 2 + 0.35, pitch: 0.12, zoom: 1 };
    scene = createScene(scene ? freshCanvas() : view, app);
    Object.assign(scene.camera, camera);
    fit();
  }

  // A canvas without the listeners of the scene before.
  function freshCanvas() {
    const old = element("view"), canvas = old.cloneNode(false);
    old.replaceWith(canvas);
    return canvas;
  }

  function show(frame) {
    const [raw, corrected] = app.recordings;
    if (!raw || frame.raw.length !== raw.positions.length) return;
    live.frame = frame;
    live.received += 1;
    live.times.push(performance.now());
    if (live.times.length > 60) live.times.shift();
    moveBody(raw, frame.raw, frame.reliability, live.follow);
    moveBody(corrected, frame.corrected, frame.reliability, live.follow);
    raw.path.centres[0] = [...corrected.path.centres[0]];
    const low = Math.min(lowest(raw), lowest(corrected));
    if (Number.isFinite(low)) app.ground = Number.isFinite(app.ground) ? Math.min(app.ground + 1e-4, low) : low;
    app.redraw();
  }

  function connect() {
    socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/watch`);
    socket.onopen = () => { live.open = true; wait = 500; status("connected", "open"); };
    socket.onmessage = (event) => {
      const message = JSON.parse(event.data);
      if (message.clients) meet(message);
      else show(message);
    };
    socket.onclose = () => {
      live.open = false;
      status("no server: trying again", "shut");
      setTimeout(connect, wait);
      wait = Math.min(8000, 2 * wait);
    };
  }

  function status(text, kind) {
    element("link").textContent = text;
    element("link").className = kind;
  }

  element("follow").addEventListener("change", () => { live.follow = element("follow").checked; });
  for (const name of ["grid", "marks"]) {
    element(name).addEventListener("change", () => { app[name] = element(name).checked; app.redraw(); });
  }
  element("side").addEventListener("change", () => { app.layout = element("side").checked ? "side" : "overlay"; fit(); });
  for (const name of ["raw", "corrected"]) {
    element(`show-${name}`).addEventListener("change", (event) => {
      for (const body of app.recordings) if (body.name === name) body.visible = event.target.checked;
      app.redraw();
    });
  }
  const angles = { front: { yaw: -Math.PI / 2, pitch: 0.05 }, side: { yaw: 0, pitch: 0.05 }, top: { yaw: -Math.PI / 2, pitch: 1.55 } };
  for (const button of document.querySelectorAll("[data-angle]")) {
    button.addEventListener("click", () => {
      if (scene) { Object.assign(scene.camera, { zoom: 1 }, angles[button.dataset.angle]); app.redraw(); }
    });
  }
  element("client").addEventListener("change", () => socket.send(JSON.stringify({ watch: Number(element("client").value) })));
  element("try").textContent = `motionmend stream FILE --to ws://${location.host}`;
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { app.theme = readColours(); fit(); });
  new ResizeObserver(fit).observe(element("stage"));
  window.live = {
    state: () => ({
      open: live.open, received: live.received, client: live.who.client, clients: live.who.clients.map((c) => c.id),
      seq: live.frame ? live.frame.seq : null, joints: app.recordings.length ? app.recordings[0].points.length : 0,
      chosen: app.channel, flags: live.frame ? live.frame.flags : [],
    }),
  };
  connect();
}

function readColours() {
  const style = getComputedStyle(document.documentElement), read = (name) => style.getPropertyValue(name).trim();
  const theme = Object.fromEntries(["ink", "faint", "line", "paper", "floor", "shadow"].map((n) => [n, read(`--${n}`)]));
  theme.colours = [0, 1, 2, 3, 4, 5].map((i) => read(`--c${i}`));
  theme.states = ["measured", "repaired", "filled", "open"].map((n) => read(`--${n}`));
  return theme;
}

function listClients(who, select) {
  const options = who.clients.map((c) => new Option(`${c.id} · ${c.skeleton}, ${Number(c.fps.toFixed(1))} Hz`, c.id));
  select.replaceChildren(...(options.length ? options : [new Option("none yet", 0)]));
  select.disabled = options.length < 2;
  select.value = who.client;
}

function fillTable(names, body, choose) {
  body.replaceChildren(...names.map((name) => {
    const row = document.createElement("tr"), head = document.createElement("th"), meter = document.createElement("meter");
    meter.setAttribute("aria-label", `reliability of ${name}`);
    head.textContent = name;
    const moved = document.createElement("td"), reliable = document.createElement("td");
    reliable.append(meter);
    row.append(head, moved, reliable);
    row.addEventListener("click", () => choose(name));
    return row;
  }));
}

// The figures beside the view, as of the last frame.
function tell(app, live, element) {
  const { frame, times } = live, span = times.at(-1) - times[0];
  element("seq").textContent = `${frame.seq}, at ${frame.t.toFixed(2)} s`;
  element("rate").textContent = span > 0 ? `${((1000 * (times.length - 1)) / span).toFixed(1)} Hz` : "–";
  element("ms").textContent = `${frame.ms.toFixed(2)} ms`;
  element("flags").textContent = frame.flags.join(", ") || "none";
  const rows = element("joints").tBodies[0].rows;
  for (let j = 0; j < rows.length; j++) {
    const at = [0, 1, 2].map((k) => 3 * j + k), r = frame.reliability[j];
    const known = at.every((i) => frame.raw[i] !== null && frame.corrected[i] !== null);
    const moved = Math.hypot(...at.map((i) => frame.corrected[i] - frame.raw[i]));
    rows[j].cells[1].textContent = known ? `${(100 * moved).toFixed(1)} cm` : "not seen";
    rows[j].cells[2].firstChild.value = r === null ? 0 : r;
    rows[j].classList.toggle("doubtful", r === null || r < DOUBTFUL);
    rows[j].classList.toggle("chosen", live.who.names[j] === app.channel);
  }
  const chosen = live.who.names.indexOf(app.channel), std = chosen >= 0 ? frame.std[chosen] : null;
  element("now").textContent = chosen < 0 ? "" : `${app.channel}: ${rows[chosen].cells[1].textContent} moved`
    + (std === null ? "" : `, ± ${(100 * std).toFixed(1)} cm`);
}

startLive();
