// The 3D view: a camera that orbits, a floor, and bodies as lines and points on a plain canvas.

function createScene(canvas, app) {
  const context = canvas.getContext("2d");
  const camera = { yaw: -1.05, pitch: 0.2, zoom: 1 };
  const HALF_ANGLE = Math.tan((17 * Math.PI) / 180);
  let width = 0, height = 0, hits = [];

  const everyPath = pathBox(app.recordings);
  if (everyPath.length > 0.6) {  // see a walk from its side
    camera.yaw = Math.atan2(everyPath.along[1], everyPath.along[0]) - Math.PI / 2 + 0.35;
  }

  function resize() {
    const ratio = window.devicePixelRatio || 1;
    width = canvas.clientWidth;
    height = canvas.clientHeight;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  // Fits a body of that reach into the cell's height and all its ways (wide) into the width.
  function projector(cell, target, reach, wide) {
    const { yaw, pitch, zoom } = camera;
    const focal = cell.height / 2 / HALF_ANGLE;
    const fit = Math.max(reach * 1.2, (wide * 1.05 * cell.height) / cell.width);
    const distance = (fit / HALF_ANGLE + (wide - reach) * 0.4) / zoom;
    const toEye = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
    const right = [-Math.sin(yaw), Math.cos(yaw), 0];
    const up = [-Math.sin(pitch) * Math.cos(yaw), -Math.sin(pitch) * Math.sin(yaw), Math.cos(pitch)];
    const cx = cell.left + cell.width / 2, cy = cell.top + cell.height / 2 + (app.layout === "side" ? 8 : 0);
    return (p, out) => {
      const x = p[0] - target[0], y = p[1] - target[1], z = p[2] - target[2];
      const depth = distance - (x * toEye[0] + y * toEye[1] + z * toEye[2]);
      if (depth < 0.05) return false;
      const scale = focal / depth;
      out[0] = cx + scale * (x * right[0] + y * right[1]);
      out[1] = cy - scale * (x * up[0] + y * up[1] + z * up[2]);
      out[2] = scale;  // pixels a metre
      return true;
    };
  }

  // Floor lines a metre apart, fading with the distance from what is looked at.
  function drawFloor(project, target, reach) {
    const rings = Math.min(24, Math.max(4, Math.ceil(reach * 2.5)));
    const x0 = Math.round(target[0]), y0 = Math.round(target[1]);
    const batches = Array.from({ length: 5 }, () => new Path2D());
    const a = [0, 0, 0], b = [0, 0, 0];
    const segment = (p, q) => {
      const away = Math.hypot((p[0] + q[0]) / 2 - target[0], (p[1] + q[1]) / 2 - target[1]) / rings;
      if (away >= 1 || !project(p, a) || !project(q, b)) return;
      const batch = batches[Math.min(4, Math.floor(away * 5))];
      batch.moveTo(a[0], a[1]);
      batch.lineTo(b[0], b[1]);
    };
    for (let i = -rings; i <= rings; i++) {
      for (let j = -rings; j < rings; j++) {
        segment([x0 + i, y0 + j, app.ground], [x0 + i, y0 + j + 1, app.ground]);
        segment([x0 + j, y0 + i, app.ground], [x0 + j + 1, y0 + i, app.ground]);
      }
    }
    context.strokeStyle = app.theme.floor;
    context.lineWidth = 1;
    batches.forEach((batch, i) => {
      context.globalAlpha = 1 - i * 0.19;
      context.stroke(batch);
    });
    context.globalAlpha = 1;
  }

  function drawBody(recording, frame, project) {
    const points = recording.points.length, world = [0, 0, 0], flat = [0, 0, 0];
    const placed = new Array(points), shadow = new Array(points);
    for (let j = 0; j < points; j++) {
      if (!pointAt(recording, frame, j, world)) continue;
      const at = [0, 0, 0];
      if (project(world, at)) placed[j] = at;
      if (project([world[0], world[1], app.ground], flat)) shadow[j] = [flat[0], flat[1]];
    }
    const lines = recording.markers && !app.edges ? [] : recording.lines;
    context.lineCap = "round";
    if (app.grid) {
      const cast = new Path2D();
      for (const [a, b] of lines) {
        if (shadow[a] && shadow[b]) { cast.moveTo(...shadow[a]); cast.lineTo(...shadow[b]); }
      }
      context.strokeStyle = app.theme.shadow;
      context.lineWidth = 3;
      context.stroke(cast);
    }
    const leading = recording.repaired || app.recordings.length === 1;
    const thick = (recording.markers ? 0.007 : 0.011) * (leading ? 1.4 : 1);
    context.strokeStyle = context.fillStyle = app.theme.colours[recording.colour];
    context.globalAlpha = leading || app.layout === "side" ? 1 : 0.8;
    for (const [a, b] of lines) {
      if (!placed[a] || !placed[b]) continue;
      context.lineWidth = Math.min(5, Math.max(1, thick * (placed[a][2] + placed[b][2]) / 2));
      context.beginPath();
      context.moveTo(placed[a][0], placed[a][1]);
      context.lineTo(placed[b][0], placed[b][1]);
      context.stroke();
    }
    const dot = recording.markers ? 0.016 : 0.013;
    for (let j = 0; j < points; j++) {
      if (!placed[j]) continue;
      context.beginPath();
      context.arc(placed[j][0], placed[j][1], Math.min(6, Math.max(1.6, dot * placed[j][2])), 0, 2 * Math.PI);
      context.fill();
      hits.push({ x: placed[j][0], y: placed[j][1], recording, j });
    }
    context.globalAlpha = 1;
    if (app.marks) drawMarks(recording, frame, placed);
    const chosen = recording.channelOf.get(app.channel);
    if (chosen !== undefined) {
      const at = placed[recording.markers ? chosen : recording.channelPoint[chosen]];
      if (at) drawChosen(at);
    }
  }

  // A diamond round what was repaired, a circle round what was filled, a cross where a joint has an open channel.
  function drawMarks(recording, frame, placed) {
    const worst = new Uint8Array(recording.points.length);
    for (let c = 0; c < recording.channels.length; c++) {
      const j = recording.markers ? c : recording.channelPoint[c];
      worst[j] = Math.max(worst[j], stateAt(recording, c, frame));
    }
    context.lineWidth = 2;
    for (let j = 0; j < worst.length; j++) {
      if (!worst[j] || !placed[j]) continue;
      const [x, y, scale] = placed[j], r = Math.min(11, Math.max(5, 0.035 * scale));
      context.strokeStyle = app.theme.states[worst[j]];
      context.beginPath();
      if (worst[j] === REPAIRED) {
        context.moveTo(x, y - r * 1.2); context.lineTo(x + r * 1.2, y); context.lineTo(x, y + r * 1.2);
        context.lineTo(x - r * 1.2, y); context.closePath();
      } else if (worst[j] === FILLED) {
        context.arc(x, y, r, 0, 2 * Math.PI);
      } else {
        context.moveTo(x - r, y - r); context.lineTo(x + r, y + r);
        context.moveTo(x + r, y - r); context.lineTo(x - r, y + r);
      }
      context.stroke();
    }
  }

  function drawChosen([x, y]) {
    context.beginPath();
    context.arc(x, y, 3.2, 0, 2 * Math.PI);
    context.fillStyle = app.theme.paper;
    context.fill();
    context.lineWidth = 1.5;
    context.strokeStyle = app.theme.ink;
    context.stroke();
  }

  function draw() {
    context.clearRect(0, 0, width, height);
    hits = [];
    const shown = app.recordings.filter((r) => r.visible);
    const groups = app.layout === "side" ? shown.map((r) => [r]) : [shown];
    cells(groups.length).forEach((cell, i) => {
      const lead = groups[i].find((r) => r.index === app.reference) || groups[i][0];
      if (!lead) return;
      const frame = frameAt(lead, app.time);
      const box = app.layout === "side" ? pathBox([lead]) : everyPath;
      const target = app.follow ? centreAt(lead, frame < 0 ? lead.drawn - 1 : frame) : box.centre;
      const reach = lead.path.reach, wide = app.follow ? reach : box.reach;
      context.save();
      context.beginPath();
      context.rect(cell.left, cell.top, cell.width, cell.height);
      context.clip();
      const project = projector(cell, target, reach, wide);
      if (app.grid) drawFloor(project, target, wide);
      for (const recording of [...groups[i]].sort((a, b) => a.repaired - b.repaired)) {
        const own = frameAt(recording, app.time);
        if (own >= 0) drawBody(recording, own, project);
      }
      context.restore();
      if (app.layout === "side") drawCaption(cell, lead, frame < 0);
    });
  }

  function drawCaption(cell, recording, ended) {
    context.font = "600 13px system-ui, sans-serif";
    context.textAlign = "center";
    context.fillStyle = app.theme.colours[recording.colour];
    const text = recording.name + (ended ? " (ended)" : "");
    context.fillText(text, cell.left + cell.width / 2, cell.top + 16, cell.width - 8);
    if (cell.left > 0) {
      context.fillStyle = app.theme.line;
      context.fillRect(cell.left, cell.top, 1, cell.height);
    }
    context.textAlign = "start";
  }

  // Equal cells, in one row or, where that leaves slivers, in two.
  function cells(count) {
    if (!count) return [];
    const rows = count > 1 && width / count < height * 0.45 ? 2 : 1, columns = Math.ceil(count / rows);
    const top = app.layout === "side" ? app.headroom() : 0;
    const tall = (height - top) / rows;
    return Array.from({ length: count }, (_, i) => ({
      left: ((i % columns) * width) / columns, top: top + Math.floor(i / columns) * tall,
      width: width / columns, height: tall,
    }));
  }

  function nearest(x, y) {
    let best = null, least = 12;
    for (const hit of hits) {
      const away = Math.hypot(hit.x - x, hit.y - y);
      if (away < least) { least = away; best = hit; }
    }
    return best;
  }

  const scene = { camera, draw, resize, nearest };
  addOrbit(canvas, scene, app);
  return scene;
}

// Where the bodies go: centre and reach of all paths, and the way from first to last.
function pathBox(recordings) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const { path } of recordings) {
    for (const c of path.centres) {
      for (let k = 0; k < 3; k++) { low[k] = Math.min(low[k], c[k]); high[k] = Math.max(high[k], c[k]); }
    }
  }
  const first = recordings[0].path.centres[0], last = recordings[0].path.centres.at(-1);
  const along = [last[0] - first[0], last[1] - first[1]];
  return {
    centre: low.map((l, k) => (l + high[k]) / 2), along, length: Math.hypot(...along),
    reach: Math.max(...recordings.map((r) => r.path.reach)) + Math.hypot(high[0] - low[0], high[1] - low[1]) / 2,
  };
}

// Drag to turn, wheel or two fingers to zoom, a plain click or tap chooses the nearest joint or marker.
function addOrbit(canvas, scene, app) {
  const down = new Map();
  let dragged = 0, pinch = 0;
  const spread = () => { const [a, b] = [...down.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
  canvas.addEventListener("pointerdown", (event) => {
    down.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
    canvas.setPointerCapture(event.pointerId);
    if (down.size === 1) dragged = 0;
    if (down.size === 2) pinch = Math.max(1, spread());
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = down.get(event.pointerId);
    if (!last) return app.hover(scene.nearest(event.offsetX, event.offsetY), event.offsetX, event.offsetY);
    const dx = event.offsetX - last.x, dy = event.offsetY - last.y;
    last.x = event.offsetX;
    last.y = event.offsetY;
    dragged += Math.abs(dx) + Math.abs(dy);
    if (down.size === 2) {
      const now = Math.max(1, spread());
      zoom(now / pinch);
      pinch = now;
    } else {
      scene.camera.yaw -= dx * 0.008;
      scene.camera.pitch = Math.min(1.55, Math.max(-0.3, scene.camera.pitch + dy * 0.006));
    }
    app.redraw();
  });
  const up = (event) => {
    const single = down.size === 1;
    if (!down.delete(event.pointerId) || event.type !== "pointerup") return;
    const hit = single && dragged < 5 && scene.nearest(event.offsetX, event.offsetY);
    if (hit) app.choosePoint(hit.recording, hit.j);
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => app.hover(null));
  const zoom = (factor) => {
    scene.camera.zoom = Math.min(12, Math.max(0.15, scene.camera.zoom * factor));
  };
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * 0.0012));
    app.redraw();
  }, { passive: false });
}
