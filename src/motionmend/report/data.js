// What the page is given, unpacked: 16-bit steps back to numbers, frames by time, the body's path.

const MEASURED = 0, REPAIRED = 1, FILLED = 2, LEFT_OPEN = 3;
const MISSING = -32768;
const DEGREES = 180 / Math.PI;

async function inflate(text) {
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Numbers (T, N), frame by frame, NaN = missing: the mirror of packed.py.
async function unpack(block) {
  const [frames, columns] = block.shape;
  const bytes = await inflate(block.data);
  const values = new Float32Array(frames * columns);
  const half = frames * columns;
  for (let n = 0; n < columns; n++) {
    let code = 0;
    for (let t = 0; t < frames; t++) {
      const at = n * frames + t;
      code = (code + bytes[at] + 256 * bytes[half + at]) & 0xffff;
      const signed = code > 32767 ? code - 65536 : code;
      values[t * columns + n] = signed === MISSING ? NaN : block.offset[n] + block.step[n] * signed;
    }
  }
  return values;
}

async function unpackRecording(block, index) {
  const markers = block.kind === "markers";
  const positions = await unpack(block.positions);
  const drawn = block.positions.shape[0];
  const recording = {
    ...block, index, markers, drawn, positions,
    values: markers ? positions : await unpack(block.values),
    std: block.std ? await unpack(block.std) : null,
    state: await inflate(block.state.data),  // channel by channel
    rate: block.fps / block.stride,
    duration: (block.frames - 1) / block.fps,
    visible: true,
  };
  recording.channelOf = new Map(block.channels.map((name, c) => [name, c]));
  recording.path = bodyPath(recording);
  return recording;
}

// The drawn frame at a time in s, -1 once the recording has ended.
function frameAt(recording, time) {
  const frame = Math.floor(time * recording.fps + 1e-6);
  return frame < recording.frames ? Math.floor(frame / recording.stride) : -1;
}

function stateAt(recording, channel, frame) {
  return recording.state[channel * recording.drawn + frame];
}

// Point j at a drawn frame in the page's axes (right, forward, up), m; false where it is missing.
function pointAt(recording, frame, j, out) {
  const at = (frame * recording.points.length + j) * 3, p = recording.positions, v = recording.view;
  const x = p[at], y = p[at + 1], z = p[at + 2];
  if (!(x === x && y === y && z === z)) return false;
  out[0] = v[0][0] * x + v[0][1] * y + v[0][2] * z;
  out[1] = v[1][0] * x + v[1][1] * y + v[1][2] * z;
  out[2] = v[2][0] * x + v[2][1] * y + v[2][2] * z;
  return true;
}

// What one channel's curves hold: a motion has one curve in degrees or m, a marker has x, y and z in m.
function curvesOf(recording, channel) {
  if (recording.markers) {
    const columns = recording.points.length * 3;
    return ["x", "y", "z"].map((name, k) => ({ name, unit: "m", scale: 1, columns, column: 3 * channel + k }));
  }
  const angular = recording.angular[channel];
  return [{
    name: angular ? "angle" : "length", unit: angular ? "°" : "m", scale: angular ? DEGREES : 1,
    columns: recording.channels.length, column: channel,
  }];
}

function curveValue(recording, curve, frame) {
  return recording.values[frame * curve.columns + curve.column] * curve.scale;
}

function stdValue(recording, channel, curve, frame) {
  return recording.std ? recording.std[frame * recording.channels.length + channel] * curve.scale : NaN;
}

// The body's centre ten times a second (of most of its points, so that a stray marker does not pull it),
// smoothed over half a second, and its reach, m: of arms that are raised for a while too, not of a few wild frames.
function bodyPath(recording) {
  const every = Math.max(1, Math.round(recording.rate / 10));
  const centres = [], reaches = [], point = [0, 0, 0];
  for (let frame = 0; frame < recording.drawn; frame += every) {
    const axes = [[], [], []];
    for (let j = 0; j < recording.points.length; j++) {
      if (pointAt(recording, frame, j, point)) for (let k = 0; k < 3; k++) axes[k].push(point[k]);
    }
    const centre = axes[0].length ? [median(axes[0]), median(axes[1]), middle(axes[2])] : null;
    centres.push(centre);
    if (centre) {
      const away = axes[0].map((x, i) => Math.hypot(x - centre[0], axes[1][i] - centre[1], axes[2][i] - centre[2]));
      reaches.push(away.sort((a, b) => a - b)[Math.floor((recording.markers ? 0.95 : 1) * (away.length - 1))]);
    }
  }
  let last = centres.find((c) => c) || [0, 0, 0];
  const filled = centres.map((c) => (last = c || last));
  const smooth = filled.map((_, i) => [0, 1, 2].map((k) => {
    let sum = 0, n = 0;
    for (let d = Math.max(0, i - 2); d <= Math.min(filled.length - 1, i + 2); d++) { sum += filled[d][k]; n++; }
    return sum / n;
  }));
  return { every, centres: smooth, reach: reaches.length ? reaches.sort((a, b) => a - b)[Math.floor(0.95 * (reaches.length - 1))] : 1 };
}

function centreAt(recording, frame) {
  const { every, centres } = recording.path, at = frame / every;
  const i = Math.min(Math.floor(at), centres.length - 1), j = Math.min(i + 1, centres.length - 1), w = at - i;
  return [0, 1, 2].map((k) => centres[i][k] * (1 - w) + centres[j][k] * w);
}

function middle(values) {
  const sorted = [...values].sort((a, b) => a - b), beyond = Math.floor(0.04 * sorted.length);
  return (sorted[beyond] + sorted[sorted.length - 1 - beyond]) / 2;
}

function median(values) {
  const sorted = [...values].sort((a, b) => a - b), half = sorted.length >> 1;
  return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}
