// Everything under the view that shares one time axis: scrubber, ruler, overview, curves, a row per channel.

const ROW = 14;

function createTimeline(root, app) {
  const find = (name) => root.querySelector(`[data-part=${name}]`);
  const scrubber = find("scrubber"), cursor = find("cursor"), more = find("all-rows");
  const canvases = Object.fromEntries(["ruler", "overview", "plot", "rows"].map((n) => [n, find(n)]));
  let gutter = 110, inner = 100, listed = [];
  const right = 14;

  app.timeX = (time) => gutter + ((time - app.window[0]) / (app.window[1] - app.window[0])) * inner;
  const xTime = (x) => app.window[0] + ((x - gutter) / inner) * (app.window[1] - app.window[0]);

  // A context in CSS pixels, cleared, sharp on dense screens; the height may follow the content.
  function sheet(canvas, height) {
    const ratio = window.devicePixelRatio || 1, width = root.clientWidth;
    canvas.style.height = `${height}px`;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    return context;
  }

  function layout() {
    gutter = root.clientWidth < 560 ? 62 : 112;
    inner = Math.max(40, root.clientWidth - gutter - right);
    scrubber.style.marginLeft = `${gutter - 8}px`;
    scrubber.style.width = `${inner + 16}px`;
    const rate = app.recordings[app.reference].fps;
    scrubber.min = Math.round(app.window[0] * rate);
    scrubber.max = Math.round(Math.min(app.window[1], app.duration) * rate);
    drawRuler();
    drawOverview();
    const tall = app.recordings.some((r) => r.markers && r.channelOf.has(app.channel)) ? 240 : 170;
    drawPlot(sheet(canvases.plot, tall), { left: gutter, width: inner, height: tall }, app);
    drawRows();
    moveCursor();
  }

  function drawRuler() {
    const context = sheet(canvases.ruler, 18);
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "center";
    const span = app.window[1] - app.window[0], step = roundStep(span / Math.max(2, inner / 80));
    const digits = digitsFor(step);
    for (let t = Math.ceil(app.window[0] / step - 1e-9) * step; t <= app.window[1] + 1e-9; t += step) {
      const x = app.timeX(t);
      context.fillStyle = app.theme.line;
      context.fillRect(Math.round(x), 0, 1, 4);
      context.fillStyle = app.theme.faint;
      if (x < root.clientWidth - 16) context.fillText(`${t.toFixed(digits)} s`, x, 15);
    }
  }

  // Worst state of channels among the frames of each pixel: one entry a pixel, -1 past the end.
  function columnsOf(recording, visit) {
    for (let px = 0; px < inner; px++) {
      const from = Math.floor(xTime(gutter + px) * recording.rate + 0.5);
      const to = Math.max(from, Math.floor(xTime(gutter + px + 1) * recording.rate + 0.5) - 1);
      if (from >= recording.drawn) break;
      visit(px, Math.max(0, from), Math.min(recording.drawn - 1, to));
    }
  }

  function worst(recording, channel, from, to) {
    let state = 0;
    for (let t = from; t <= to && state < LEFT_OPEN; t++) state = Math.max(state, stateAt(recording, channel, t));
    return state;
  }

  function drawOverview() {
    const height = 26, context = sheet(canvases.overview, height), recording = app.provenance;
    const channels = recording.channels.length;
    label(context, gutter < 80 ? "all" : recording.markers ? `all ${recording.points_are}` : "all channels", height / 2, false);
    columnsOf(recording, (px, from, to) => {
      const counts = [0, 0, 0, 0];
      for (let c = 0; c < channels; c++) counts[worst(recording, c, from, to)]++;
      context.fillStyle = app.theme.states[MEASURED];
      context.fillRect(gutter + px, 0, 1, height);
      let bottom = height;
      for (const state of [LEFT_OPEN, FILLED, REPAIRED]) {
        if (!counts[state]) continue;
        const tall = Math.max(3, (counts[state] / channels) * height);
        context.fillStyle = app.theme.states[state];
        context.fillRect(gutter + px, bottom - tall, 1, tall);
        bottom -= tall;
      }
    });
  }

  function drawRows() {
    const recording = app.provenance, touched = [];
    for (let c = 0; c < recording.channels.length; c++) {
      const from = c * recording.drawn;
      if (recording.state.subarray(from, from + recording.drawn).some((s) => s !== MEASURED)) touched.push(c);
    }
    listed = more.checked ? recording.channels.map((_, c) => c) : touched;
    find("rows-note").textContent = listed.length ? "" : recording.repaired ? "Every sample was measured." : "No sample is missing.";
    canvases.rows.parentElement.hidden = !listed.length;
    const context = sheet(canvases.rows, Math.max(1, listed.length * ROW)), brief = briefly(recording.channels);
    listed.forEach((c, i) => {
      const top = i * ROW + 1, tall = ROW - 2, strip = { state: -1, from: 0 };
      const chosen = recording.channels[c] === app.channel;
      label(context, brief[c], top + tall / 2, chosen);
      const paint = (end) => {
        if (strip.state < 0) return;
        context.fillStyle = strip.state === LEFT_OPEN ? app.theme.hatch(context) : app.theme.states[strip.state];
        context.fillRect(gutter + strip.from, top, end - strip.from, tall);
      };
      let end = 0;
      columnsOf(recording, (px, from, to) => {
        const state = worst(recording, c, from, to);
        if (state !== strip.state) { paint(px); strip.state = state; strip.from = px; }
        end = px + 1;
      });
      paint(end);
      if (chosen) {
        context.strokeStyle = app.theme.ink;
        context.strokeRect(gutter - 0.5, top - 0.5, end + 1, tall + 1);
      }
    });
  }

  // Names tell rows apart without the namespace that all of them have, and by an axis and three letters.
  function briefly(names) {
    const first = names[0] ?? "", space = first.slice(0, first.lastIndexOf(":") + 1);
    const shared = names.every((name) => name.startsWith(space)) ? space.length : 0;
    return names.map((name) => name.slice(shared).replace(/\.([XYZ])(rot|pos)(ation|ition)$/i, ".$1$2"));
  }

  function label(context, text, middle, chosen) {
    context.font = `${chosen ? "700 " : ""}11px system-ui, sans-serif`;
    context.textAlign = "right";
    context.fillStyle = chosen ? app.theme.ink : app.theme.faint;
    let shown = text;
    for (let keep = text.length - 2; keep > 2 && context.measureText(shown).width > gutter - 12; keep--) {
      const ending = Math.ceil(keep / 2);  // names often differ in their ends
      shown = `${text.slice(0, keep - ending)}…${text.slice(-ending)}`;
    }
    context.fillText(shown, gutter - 8, middle + 4);
    context.textAlign = "start";
  }

  function moveCursor() {
    const x = app.timeX(app.time), inside = x >= gutter - 0.5 && x <= gutter + inner + 0.5;
    cursor.style.transform = `translateX(${Math.round(x)}px)`;
    cursor.hidden = !inside;
    scrubber.value = app.frame();
    scrubber.setAttribute("aria-valuetext", `frame ${app.frame()}, ${app.time.toFixed(2)} seconds`);
  }

  // Narrow or widen the window about the cursor; whole frames of the reference, ten at least.
  function zoom(factor) {
    const rate = app.recordings[app.reference].fps, span = app.window[1] - app.window[0];
    const wanted = Math.min(app.span, Math.max(10 / rate, span * factor));
    const share = (app.time - app.window[0]) / span;
    setWindow(app.time - Math.min(1, Math.max(0, share)) * wanted, wanted);
  }

  function setWindow(start, span) {
    const rate = app.recordings[app.reference].fps;
    const first = Math.max(0, Math.min(app.span - span, start));
    app.window = [Math.round(first * rate) / rate, Math.min(app.span, Math.round((first + span) * rate) / rate)];
    layout();
  }

  // Keep the cursor in sight while it plays or steps through a narrowed window.
  function follow() {
    const span = app.window[1] - app.window[0];
    if (app.time < app.window[0] - 1e-6) setWindow(app.time - span * 0.9, span);
    else if (app.time > app.window[1] + 1e-6) setWindow(app.time - span * 0.1, span);
  }

  const seekTo = (x) => app.seek(Math.min(app.window[1], Math.max(app.window[0], xTime(x))));
  scrubber.addEventListener("input", () => app.seek(Number(scrubber.value) / app.recordings[app.reference].fps));
  more.addEventListener("change", layout);
  for (const name of ["ruler", "overview", "plot", "rows"]) {
    canvases[name].addEventListener("pointerdown", (event) => {
      const row = name === "rows" ? listed[Math.floor(event.offsetY / ROW)] : undefined;
      if (row !== undefined) app.choose(app.provenance.channels[row]);
      if (event.offsetX < gutter) return;
      if (event.pointerType === "mouse") canvases[name].setPointerCapture(event.pointerId);
      seekTo(event.offsetX);
    });
    canvases[name].addEventListener("pointermove", (event) => {
      if (event.buttons === 1 && canvases[name].hasPointerCapture(event.pointerId)) seekTo(event.offsetX);
    });
  }
  return { layout, moveCursor, zoom, follow, fit: () => setWindow(0, app.span) };
}
