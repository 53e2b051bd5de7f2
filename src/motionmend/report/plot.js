// Curves of the chosen channel or marker: every visible recording, the band of one standard deviation, gaps.

function drawPlot(context, area, app) {
  const { left, width, height } = area;
  const shown = app.recordings.filter((r) => r.visible && r.channelOf.has(app.channel));
  const owner = app.provenance.channelOf.has(app.channel) ? app.provenance : shown[0];
  const model = owner || app.recordings.find((r) => r.channelOf.has(app.channel));
  const curves = curvesOf(model, model.channelOf.get(app.channel));
  const gap = 10, each = (height - gap * (curves.length - 1)) / curves.length;
  curves.forEach((curve, k) => {
    const box = { left, width, top: k * (each + gap), height: each };
    const range = rangeOf(shown, k, app);
    const y = (v) => box.top + box.height - ((v - range.low) / (range.high - range.low)) * box.height;
    context.save();
    context.beginPath();
    context.rect(box.left, box.top, box.width, box.height);
    context.clip();
    if (owner) shadeStates(context, box, owner, app);
    drawLevels(context, box, range, y, app.theme);
    for (const recording of [...shown].sort((a, b) => a.repaired - b.repaired)) {
      drawCurve(context, box, recording, k, y, range, app);
    }
    context.restore();
    drawScale(context, box, range, y, curve, curves.length > 1, app.theme);
  });
}

function channelCurve(recording, app, k) {
  const channel = recording.channelOf.get(app.channel);
  return { channel, curve: curvesOf(recording, channel)[k] };
}

// Drawn frames of a recording inside the window, one beyond on either side.
function framesInWindow(recording, app) {
  const first = Math.max(0, Math.floor(app.window[0] * recording.rate) - 1);
  return [first, Math.min(recording.drawn - 1, Math.ceil(app.window[1] * recording.rate) + 1)];
}

// All values, unless a few lie so far out that they would flatten the rest; those get a tick at the edge.
function rangeOf(shown, k, app) {
  const values = [];
  for (const recording of shown) {
    const { curve } = channelCurve(recording, app, k), [first, last] = framesInWindow(recording, app);
    const every = Math.max(1, Math.floor((last - first) / 4000));
    for (let t = first; t <= last; t += every) {
      const v = curveValue(recording, curve, t);
      if (v === v) values.push(v);
    }
  }
  if (!values.length) return { low: 0, high: 1, empty: true };
  values.sort((a, b) => a - b);
  const at = (share) => values[Math.round(share * (values.length - 1))];
  let low = values[0], high = values.at(-1);
  const reach = Math.max(at(0.99) - at(0.01), 1e-3);
  if (high > at(0.99) + reach) high = at(0.99) + reach * 0.5;
  if (low < at(0.01) - reach) low = at(0.01) - reach * 0.5;
  const room = Math.max((high - low) * 0.07, 1e-3);
  return { low: low - room, high: high + room };
}

// Stripes behind the curves where the samples were repaired, filled or left open.
function shadeStates(context, box, recording, app) {
  const channel = recording.channelOf.get(app.channel), [first, last] = framesInWindow(recording, app);
  let from = first;
  for (let t = first; t <= last; t++) {
    const state = stateAt(recording, channel, t);
    if (t < last && stateAt(recording, channel, t + 1) === state) continue;
    if (state !== MEASURED) {
      const a = app.timeX((from - 0.5) / recording.rate), b = app.timeX((t + 0.5) / recording.rate);
      context.fillStyle = state === LEFT_OPEN ? app.theme.hatch(context) : app.theme.states[state];
      context.globalAlpha = state === REPAIRED ? 0.45 : state === FILLED ? 0.2 : 0.5;
      context.fillRect(a, box.top, Math.max(1, b - a), box.height);
    }
    from = t + 1;
  }
  context.globalAlpha = 1;
}

function drawLevels(context, box, range, y, theme) {
  context.fillStyle = theme.line;
  for (const level of levels(range, box.height)) context.fillRect(box.left, Math.round(y(level)), box.width, 1);
}

function drawScale(context, box, range, y, curve, named, theme) {
  context.fillStyle = theme.faint;
  context.font = "11px system-ui, sans-serif";
  context.textAlign = "right";
  if (range.empty) {
    context.textAlign = "left";
    context.fillText("no sample of a visible recording here", box.left + 8, box.top + box.height / 2 + 4);
  } else {
    const marks = levels(range, box.height), digits = digitsFor(levelStep(range, box.height));
    marks.forEach((level) => {
      const at = Math.min(box.top + box.height - 1, Math.max(box.top + 8, y(level) + 4));
      context.fillText(`${level.toFixed(digits)}${curve.unit === "°" ? "°" : " m"}`, box.left - 6, at);
    });
  }
  if (named) {
    context.textAlign = "left";
    context.font = "600 12px system-ui, sans-serif";
    context.lineWidth = 4;
    context.strokeStyle = theme.paper;
    context.strokeText(curve.name, box.left + 5, box.top + 13);
    context.fillStyle = theme.ink;
    context.fillText(curve.name, box.left + 5, box.top + 13);
  }
  context.textAlign = "start";
}

// Round numbers inside a range, one every 24 to 60 pixels.
function levels({ low, high }, pixels) {
  const step = levelStep({ low, high }, pixels), found = [];
  for (let v = Math.ceil(low / step) * step; v <= high; v += step) found.push(Math.abs(v) < step / 1e6 ? 0 : v);
  return found;
}

function levelStep({ low, high }, pixels) {
  return roundStep((high - low) / Math.max(2, pixels / 24));
}

function roundStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((m) => m * power).find((s) => s >= least * 0.999);
}

function digitsFor(step) {
  return Math.max(0, Math.min(4, -Math.floor(Math.log10(step) + 1e-9)));
}

function drawCurve(context, box, recording, k, y, range, app) {
  const { channel, curve } = channelCurve(recording, app, k), [first, last] = framesInWindow(recording, app);
  const x = (t) => app.timeX(t / recording.rate);
  const colour = app.theme.colours[recording.colour];
  if (recording.std) drawBand(context, recording, channel, curve, first, last, x, y, colour);
  context.strokeStyle = context.fillStyle = colour;
  context.lineWidth = recording.repaired || app.recordings.length === 1 ? 1.8 : 1.2;
  context.globalAlpha = recording.repaired ? 1 : 0.85;
  context.lineJoin = "round";
  const path = new Path2D(), outside = new Path2D();
  const dense = last - first > 3 * box.width;
  let open = false, column = -1, low = 0, high = 0;
  for (let t = first; t <= last; t++) {
    const v = curveValue(recording, curve, t);
    if (v !== v) { open = false; column = -1; continue; }
    if (v > range.high || v < range.low) tick(outside, x(t), v > range.high ? box.top : box.top + box.height, v > range.high);
    if (dense) {  // one upright stroke a pixel, from least to most, so that no spike is lost
      const here = Math.round(x(t));
      if (here !== column) { low = high = v; column = here; } else { low = Math.min(low, v); high = Math.max(high, v); }
      if (t === last || Math.round(x(t + 1)) !== here) {
        if (open) path.lineTo(here, y(low)); else path.moveTo(here, y(low));
        path.lineTo(here, y(high) - 0.5);
        open = true;
      }
    } else if (open) {
      path.lineTo(x(t), y(v));
    } else {
      path.moveTo(x(t) - 0.5, y(v));  // a lone sample between gaps stays visible
      path.lineTo(x(t), y(v));
      open = true;
    }
  }
  context.stroke(path);
  context.globalAlpha = 1;
  context.fill(outside);
}

function tick(path, x, edge, top) {
  const way = top ? 1 : -1;
  path.moveTo(x - 3, edge + way * 5);
  path.lineTo(x + 3, edge + way * 5);
  path.lineTo(x, edge);
  path.closePath();
}

function drawBand(context, recording, channel, curve, first, last, x, y, colour) {
  context.fillStyle = colour;
  context.globalAlpha = 0.22;
  let run = [];
  const close = () => {
    if (run.length > 1) {
      context.beginPath();
      run.forEach(([t, v, s], i) => (i ? context.lineTo(x(t), y(v + s)) : context.moveTo(x(t), y(v + s))));
      run.reverse().forEach(([t, v, s]) => context.lineTo(x(t), y(v - s)));
      context.closePath();
      context.fill();
    }
    run = [];
  };
  const every = Math.max(1, Math.floor((last - first) / 2400));
  for (let t = first; t <= last; t += every) {
    const v = curveValue(recording, curve, t), s = stdValue(recording, channel, curve, t);
    if (v === v && s === s) run.push([t, v, s]); else close();
  }
  close();
  context.globalAlpha = 1;
}
