// A live body as the report's scene draws it: a recording of one frame whose positions change.

const DOUBTFUL = 0.5;  // a reliability below this is marked

function createBody(index, name, colour, who) {
  const joints = who.names.length;
  return {
    index, name, colour, markers: false, repaired: name === "corrected", visible: true,
    points: who.names, channels: who.names, channelPoint: who.names.map((_, j) => j),
    channelOf: new Map(who.names.map((n, j) => [n, j])),
    lines: who.lines, view: who.view,
    positions: new Float32Array(3 * joints).fill(NaN), state: new Uint8Array(joints),
    frames: 1, drawn: 1, fps: 1, rate: 1, stride: 1, duration: 0,
    path: { every: 1, centres: [[0, 0, 0]], reach: 1, seen: false },
  };
}

// New positions, and where the body is: its centre glides after it over about half a second.
function moveBody(body, numbers, reliability, follow) {
  numbers.forEach((value, k) => { body.positions[k] = value === null ? NaN : value; });
  body.state.fill(MEASURED);
  if (!body.repaired) reliability.forEach((r, j) => { if (r !== null && r < DOUBTFUL) body.state[j] = REPAIRED; });
  const here = bodyPath(body), path = body.path;
  if (!Number.isFinite(here.centres[0][0]) || !body.positions.some((x) => x === x)) return;
  const pull = path.seen ? 0.06 : 1;
  if (follow || !path.seen) path.centres[0] = path.centres[0].map((c, k) => c + pull * (here.centres[0][k] - c));
  path.reach += pull * (Math.max(0.5, here.reach) - path.reach);
  path.seen = true;
}

// The height of the lowest joint, m; Infinity where there is none.
function lowest(body) {
  const at = [0, 0, 0];
  let low = Infinity;
  for (let j = 0; j < body.points.length; j++) if (pointAt(body, 0, j, at)) low = Math.min(low, at[2]);
  return low;
}
