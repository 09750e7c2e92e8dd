// What the scene shows: the wheelset, close-ups of both contacts, and boxes round what is drawn. Lengths in m.

const VIEWS = ["whole", "left", "right"];
const CLOSE = {width: 0.19, height: 0.115};
const GAUGE_DEPTH = 0.014;      // of the gauge point below the top of rail
const STANDARD = 0.71755;       // half of the gauge where no rail is drawn

// The part of the track that a view shows: centre, width and height.
function viewOf(view, shape) {
  if (view !== "whole") {
    const side = view === "left" ? 1 : -1, outline = shape?.[view];
    const top = outline ? Math.max(...outline.rail.map(([, z]) => z)) : 0;
    const gauge = (outline && (atHeight(outline.gauge, top - GAUGE_DEPTH) ?? outline.gauge.at(-1)?.[0])) ?? STANDARD;
    return {y: side * (gauge + 0.0345), z: top + 0.006, ...CLOSE};
  }
  if (!shape) return {y: 0, z: 0.42, width: 1.85, height: 1.4};
  const wheels = [...shape.left.wheel, ...shape.right.wheel], rails = [...shape.left.rail, ...shape.right.rail];
  const half = Math.max(...[...wheels, ...rails].map(([u]) => Math.abs(u)));
  const radius = Math.max(...wheels.map(([, v]) => Math.abs(v)));
  return boxView([[-half, Math.min(...rails.map(([, z]) => z)) - FOOT], [half, shape.axle + radius]]);
}

// A view of the box round some points, with room for words and scales.
function boxView(points) {
  const [[y1, y2], [z1, z2]] = [0, 1].map(k => points.map(point => point[k])).map(v => [Math.min(...v), Math.max(...v)]);
  return {y: (y1 + y2) / 2, z: (z1 + z2) / 2, width: 1.13 * (y2 - y1), height: 1.27 * (z2 - z1)};
}

// A view of everything that is drawn: rails and wheelsets where they are now, on their sides too.
function fitAll(scene, runs, shapes, at) {
  const points = runs.filter(run => run.shape !== null).flatMap(run => {
    const shape = shapes[run.shape], pose = scene.poseOf(run, shape, at);
    return sidesOf(shape).flatMap(([{rail, wheel}, side]) => [...rail.map(([y, z]) => [side * y, z - (z > -0.02 ? 0 : FOOT)]),
      ...wheel.flatMap(([u, v]) => [[side * u, v], [side * u, -v]]).map(point => scene.placed(run, pose, point))]);
  });
  return points.length ? boxView(points) : viewOf("whole", null);
}

// A close-up of a side that holds the contact, and the flange beside the rail if the wheel is near it.
function fitContact(scene, run, shape, at, view) {
  const point = scene.anchor(run, shape, at, view === "left" ? "L" : "R"), usual = viewOf(view, shape);
  if (!point) return usual;
  const apart = Math.hypot(point[0] - usual.y, point[1] - usual.z);
  return apart < 0.05 ? usual : {...CLOSE, y: point[0], z: point[1] + 0.006};
}

// Both sides with the sign of y: the right side is stored as its mirror image.
function sidesOf(shape) {
  return [[shape.left, 1], [shape.right, -1]];
}

// The least y of a curve at a height; null beyond the ends of the curve.
function atHeight(curve, z) {
  if (!curve.length || z < curve[0][1] || z > curve.at(-1)[1]) return null;
  let low = 0, high = curve.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (curve[middle][1] <= z) low = middle;
    else high = middle;
  }
  const [[y1, z1], [y2, z2]] = [curve[low], curve[high]];
  return z2 > z1 ? y1 + (y2 - y1) * (z - z1) / (z2 - z1) : y1;
}

// The least distance of some points from a curve with its body to the right, below zero inside the body: {gap, k, i, foot}, with
// the numbers of the point and of the curve's point behind the foot. Null without a point whose foot is inside the curve's ends.
function leastGap(points, curve) {
  let found = null;
  points.forEach(([y, z], k) => {
    let own = null, least = Infinity;
    for (let i = 1; i < curve.length; i++) {
      const [ay, az] = curve[i - 1], dy = curve[i][0] - ay, dz = curve[i][1] - az;
      const along = Math.min(Math.max(((y - ay) * dy + (z - az) * dz) / (dy * dy + dz * dz), 0), 1);
      const foot = [ay + along * dy, az + along * dz], away = (y - foot[0]) ** 2 + (z - foot[1]) ** 2;
      if (away >= least) continue;
      const beyond = (i === 1 && along === 0) || (i === curve.length - 1 && along === 1);
      [least, own] = [away, beyond ? null : {gap: Math.sqrt(away) * Math.sign((z - az) * dy - (y - ay) * dz), k, i, foot}];
    }
    if (own && (!found || own.gap < found.gap)) found = own;
  });
  return found;
}

// The stretch of a curve round its point k with eight points for each, on the cubics through four of its points (E. Catmull,
// R. Rom, 1974).
function finer(curve, k) {
  const found = [], at = i => curve[Math.min(Math.max(i, 0), curve.length - 1)];
  for (let i = k - 2; i < k + 2; i++)
    for (let j = 0; j < 8 && i >= 0 && i + 1 < curve.length; j++) {
      const x = j / 8, weights = [[0, -1, 2, -1], [2, 0, -5, 3], [0, 1, 4, -3], [0, 0, -1, 1]].map(([a, b, c, d]) =>
        (a + x * (b + x * (c + x * d))) / 2);
      found.push([0, 1].map(axis => weights.reduce((sum, weight, n) => sum + weight * at(i - 1 + n)[axis], 0)));
    }
  return found;
}

// The outlines of the facts: pairs of numbers, both sides.
function unflattened(shape) {
  const pairs = a => Array.from({length: a.length / 2}, (_, k) => [a[2 * k], a[2 * k + 1]]);
  const sides = shape.sides.map(side => Object.fromEntries(Object.entries(side).map(([name, a]) => [name, pairs(a)])));
  sides.forEach(side => side.half = Math.min(...side.wheel.map(([u]) => u)));
  return {left: sides[0], right: sides.at(-1), axle: shape.axle, roll: shape.roll};
}
