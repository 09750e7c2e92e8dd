// Wheels on rails in cross-section, seen in the direction of travel: left is left, so y grows to the left.
// Lengths in m; the first run is filled, further ones are outlines in their own colours.

const FOOT = 0.09;              // height of the rail that is drawn below its profile
const ARROW = 105;              // length of the largest force [px]
const NARROWEST = 4e-5, WIDEST = 6;     // part of the track
const DEEPEST = 2e-3;           // a wheel deeper in its rail lies beside it
const LOG_FROM = 1e3;           // smaller forces are drawn as points on the logarithmic scale [N]

class Scene {
  constructor(canvas, colour) {
    this.canvas = canvas;
    this.colour = colour;
    this.readSettings();
    this.show("whole", viewOf("whole", null));
  }

  // What the controls beside the scene say.
  readSettings() {
    const factor = what => Number(get("exaggerate-" + what).value) || 1, on = id => get(id).checked;
    this.settings = {displacement: factor("displacement"), roll: factor("roll"), gap: factor("gap"), logarithmic: on("arrows"),
                     normals: on("normals"), follow: on("follow")};
  }

  // Show a part of the track, {y, z, width, height}, in a view of this name.
  show(view, part) {
    this.view = view;
    this.camera = {...part};
    this.aside = [0, 0];        // of the camera from the contact that it follows
    this.moved = false;         // whether it is no longer the view of this name
  }

  resize() {
    Object.assign(this, prepare(this.canvas));
    this.onScreen = this.g;
  }

  // [px/m]
  get scale() { return Math.min(this.w / this.camera.width, this.h / this.camera.height); }

  px(y, z) {
    return [this.w / 2 - (y - this.camera.y) * this.scale, this.h / 2 - (z - this.camera.z) * this.scale];
  }

  zoom(factor, x = this.w / 2, y = this.h / 2) {
    const {camera} = this, before = this.scale, width = Math.min(Math.max(camera.width / factor, NARROWEST), WIDEST);
    this.moved = true;
    Object.assign(camera, {width, height: camera.height * width / camera.width});
    const change = 1 / before - 1 / this.scale;
    if (this.settings.follow) this.aside = this.aside.map(d => d * before / this.scale);
    else this.move((this.w / 2 - x) * change, (this.h / 2 - y) * change);
  }

  pan(dx, dy) { this.move(dx / this.scale, dy / this.scale); }

  move(dy, dz) {
    this.moved = true;
    this.camera.y += dy;
    this.camera.z += dz;
    if (this.settings.follow) this.aside = [this.aside[0] + dy, this.aside[1] + dz];
  }

  // The pose in which a run is drawn: the side that is nearer to its rail is moved away by what the gap is exaggerated.
  poseOf(run, shape, at) {
    const pose = run.pose(at), factor = this.settings.gap;
    if (factor === 1 || !shape) return {...pose, aside: 0};
    const known = sidesOf(shape).map(([outline, side]) => ({
      side, found: this.lateralGap(outline, run, pose, side), whole: run.clearance[side > 0 ? 0 : 1]}));
    const near = known.filter(({found}) => found).sort((a, b) => a.found.gap - b.found.gap)[0];
    return {...pose, aside: near ? near.side * (near.found.gap - exaggerated(near.found.gap, near.whole, factor)) : 0};
  }

  // Where a side's contact is drawn: that of the largest force, or of the last or next row with one; null if it has none.
  anchor(run, shape, at, side = null) {
    const found = run.contactNear(side, at);
    return found && this.placed(run, this.poseOf(run, shape, at), [found.u, found.v]);
  }

  // Move the camera to the contact; while the page plays it goes there smoothly.
  followContact(run, shape, at, smoothly) {
    const side = {left: "L", right: "R"}[this.view] ?? null, point = this.anchor(run, shape, at, side);
    if (!point) return;
    const share = smoothly ? 0.25 : 1, [dy, dz] = this.aside;
    this.camera.y += share * (point[0] + dy - this.camera.y);
    this.camera.z += share * (point[1] + dz - this.camera.z);
  }

  // A point of the wheelset, from its centre, in the track frame, as it is drawn.
  placed(run, pose, [u, v]) {
    const {displacement, roll} = this.settings;
    const angle = run.axleRoll + roll * pose.roll, c = Math.cos(angle), s = Math.sin(angle);
    return [displacement * pose.y + (pose.aside ?? 0) + c * u - s * v, run.axle + displacement * pose.z + s * u + c * v];
  }

  draw(runs, shapes, at, smoothly = false) {
    const {g} = this;
    this.readSettings();
    if (g === this.onScreen) g.clearRect(0, 0, this.w, this.h);
    g.lineJoin = "round";
    g.font = "12px system-ui, sans-serif";
    const first = runs[0];
    if (!first) return;
    this.labels = new Labels(g, this.colour, this.w, this.h);
    const poses = runs.map(run => this.poseOf(run, shapes[run.shape], at));
    if (this.settings.follow) this.followContact(first, shapes[first.shape], at, smoothly);
    this.drawGrid();
    if (first.shape === null) this.labels.words("no outlines of wheel and rail: " + first.notes.join("; "), 12, 24);
    else this.drawRails(shapes[first.shape]);
    runs.slice(1).forEach(run => {
      if (run.shape !== null && run.shape !== first.shape) this.drawRails(shapes[run.shape], this.colour.run(run));
    });
    runs.forEach((run, k) => {
      if (run.shape !== null) this.drawWheelset(shapes[run.shape], run, poses[k], !k);
    });
    const largest = Math.max(...runs.map(run => run.largest), 1);
    let words = [];
    for (let k = runs.length - 1; k >= 0; k--) words = this.drawContacts(runs[k], poses[k], at, largest, !k);
    this.drawScales(largest);
    this.drawBadge();
    for (const [name, text, x, y, up] of words) {
      naming(g, name);
      this.labels.write(text, x, y, this.colour.of("ink"), up);
    }
    if (first.shape !== null) this.drawGaps(shapes[first.shape], first, poses[0], at);
    naming(g);
  }

  path(points) {
    const {g} = this;
    g.beginPath();
    for (const [y, z] of points) g.lineTo(...this.px(y, z));
    g.closePath();
  }

  // Draw the top of the rails and the centreline.
  drawGrid() {
    naming(this.g, {what: "top of rails and centreline"});
    const {g} = this, [centre, zero] = this.px(0, 0);
    g.strokeStyle = this.colour.of("faint");
    g.lineWidth = 1;
    g.setLineDash([2, 4]);
    strokes(g, [0, zero, this.w, zero], [centre, 0, centre, this.h]);
    g.setLineDash([]);
  }

  drawRails(shape, outline = "") {
    const {g} = this;
    naming(g, {what: "rails"});
    for (const [{rail}, side] of sidesOf(shape)) {
      const head = rail.map(([y, z]) => [side * y, z]);
      const a = head[0], b = head.at(-1), low = Math.min(a[1], b[1]) - FOOT;
      this.path([...head, [b[0], low], [a[0], low]]);
      g.strokeStyle = outline || this.colour.of("ink");
      g.lineWidth = 1.2;
      if (!outline) {
        g.fillStyle = this.colour.of("rail");
        g.fill();
      }
      g.stroke();
    }
  }

  drawWheelset(shape, run, pose, filled) {
    naming(this.g, {what: "wheelset", run: run.name, column: "Y Z roll"});
    const {g} = this, a = -shape.right.half, b = shape.left.half;
    const bodies = sidesOf(shape).map(([{wheel}, side]) =>
      [...wheel, ...[...wheel].reverse().map(([u, v]) => [u, -v])].map(([u, v]) => [side * u, v]));
    bodies.unshift([[a, -0.08], [b, -0.08], [b, 0.08], [a, 0.08]]);
    g.lineWidth = filled ? 1.2 : 1.6;
    g.strokeStyle = filled ? this.colour.of("ink") : this.colour.run(run);
    g.fillStyle = this.colour.of("wheel");
    if (!filled) g.setLineDash(this.colour.dash(run));
    for (const body of bodies) {
      this.path(body.map(point => this.placed(run, pose, point)));
      if (filled) g.fill();
      g.stroke();
    }
    g.setLineDash([]);
    const [x, y] = this.px(...this.placed(run, pose, [0, 0]));
    strokes(g, [x - 6, y, x + 6, y], [x, y - 6, x, y + 6]);
  }

  // The least horizontal distance of a flange from its rail, which the exaggeration of gaps enlarges.
  lateralGap({flank, gauge}, run, pose, side) {
    const roll = side * (run.axleRoll + pose.roll), c = Math.cos(roll), s = Math.sin(roll);
    let found = null;
    for (const [u, v] of flank) {
      const y = side * pose.y + c * u - s * v, z = run.axle + pose.z + s * u + c * v;
      const rail = atHeight(gauge, z);
      if (rail !== null && (!found || rail - y < found.gap)) found = {gap: rail - y, point: [side * u, v], rail};
    }
    return found;
  }

  // The gap between a flange and its rail along the rail's normal [m], below zero the approach, with the point of the wheel and the
  // foot of its normal on the rail. Null where no point of the flange is beside the rail.
  normalGap({flank, gauge}, run, pose, side) {
    const roll = side * (run.axleRoll + pose.roll), c = Math.cos(roll), s = Math.sin(roll);
    const placed = ([u, v]) => [side * pose.y + c * u - s * v, run.axle + pose.z + s * u + c * v];
    const wheel = flank.map(placed), found = leastGap(wheel, gauge);
    if (!found) return null;
    // The outlines are curves, of which the nearest points are two: those between them tell tenths of micrometres.
    const near = finer(flank, found.k), close = leastGap(near.map(placed), finer(gauge, found.i));
    const [{gap, k, foot}, points] = close ? [close, near] : [found, flank];
    return {gap, point: [side * points[k][0], points[k][1]], foot};
  }

  // Draw the gaps of both flanges; the numbers are those of the true position.
  drawGaps(shape, run, pose, at) {
    const {g} = this;
    for (const [outline, side] of sidesOf(shape)) {
      const found = this.normalGap(outline, run, pose, side);
      if (!found || found.gap < -DEEPEST) continue;
      const [x1, y1] = this.px(...this.placed(run, pose, found.point)), [x2, y2] = this.px(side * found.foot[0], found.foot[1]);
      if (x1 < -50 || x1 > this.w + 50) continue;
      naming(g, {what: found.gap < 0 ? "approach" : "gap", run: run.name, side: side > 0 ? "L" : "R", unit: "mm", factor: 1e3});
      g.strokeStyle = g.fillStyle = this.colour.of("muted");
      g.lineWidth = 1;
      const far = Math.hypot(x2 - x1, y2 - y1) || 1, [a, b] = [4 * (y2 - y1) / far, 4 * (x2 - x1) / far];
      strokes(g, [x1, y1, x2, y2], [x1 - a, y1 + b, x1 + a, y1 - b], [x2 - a, y2 + b, x2 + a, y2 - b]);
      this.labels.write(gapWords(found, run, at), (x1 + x2) / 2, (y1 + y2) / 2 + 18, this.colour.of("muted"));
    }
  }

  arrowLength(N, largest) {
    if (!this.settings.logarithmic) return ARROW * N / largest;
    return ARROW * Math.max(Math.log10(N / LOG_FROM), 0) / Math.log10(Math.max(largest / LOG_FROM, 10));
  }

  // Draw the closed contacts of a run; returns what is to be written beside them.
  drawContacts(run, pose, at, largest, first) {
    const {g} = this, found = [];
    for (const c of CONTACTS) {
      const contact = run.contact(c, at);
      if (!contact || !Number.isFinite(contact.u + contact.v + contact.angle)) continue;
      const [x, y] = this.px(...this.placed(run, pose, [contact.u, contact.v]));
      const colour = first ? this.colour.of(c) : this.colour.run(run);
      const side = c[0] === "L" ? 1 : -1;
      const named = what => naming(g, {what, run: run.name, contact: c, side: c[0], unit: "kN", factor: 1e-3});
      const angle = contact.angle * side + (this.settings.roll - 1) * pose.roll;
      const nx = Math.sin(angle), ny = -Math.cos(angle);      // on the screen, from the rail into the wheel
      g.strokeStyle = g.fillStyle = colour;
      if (this.settings.normals) {
        named("normal");
        g.lineWidth = 1;
        g.setLineDash([5, 4]);
        strokes(g, [x - 40 * nx, y - 40 * ny, x + 130 * nx, y + 130 * ny]);
        g.setLineDash([]);
      }
      // A rail that pulls has its arrow turned round.
      const length = this.arrowLength(Math.abs(contact.N), largest), way = Math.sign(contact.N), [ax, ay] = [way * nx, way * ny];
      named("force");
      this.arrow(x, y, ax, ay, length, first ? 3 : 2);
      named("contact");
      g.beginPath();
      g.arc(x, y, 3.5, 0, 2 * Math.PI);
      g.fill();
      g.strokeStyle = this.colour.of("paper");
      g.lineWidth = 1;
      g.stroke();
      this.labels.keepArrow(x, y, ax, ay, length);
      const inside = x > 0 && x < this.w && y > 0 && y < this.h, beyond = length + 14;
      if (inside && first)
        found.push([{what: "force in words", run: run.name, contact: c}, `${c} ${forceWords(run, c, at)}`,
                    x + beyond * ax, y + beyond * ay, ay < 0 ? -1 : 1]);
    }
    return found;
  }

  arrow(x, y, nx, ny, length, width) {
    const {g} = this, head = Math.min(9, length);
    if (length < 1) return;
    const tip = [x + length * nx, y + length * ny], [bx, by] = [tip[0] - head * nx, tip[1] - head * ny], half = 0.45 * head;
    g.lineWidth = width;
    strokes(g, [x, y, bx, by]);
    g.beginPath();
    g.moveTo(...tip);
    g.lineTo(bx - half * ny, by + half * nx);
    g.lineTo(bx + half * ny, by - half * nx);
    g.fill();
  }

  // Say in the picture what is drawn larger than it is.
  drawBadge() {
    const {displacement, roll, gap} = this.settings, {g} = this;
    const found = [displacement !== 1 && `displacement × ${displacement}`, roll !== 1 && `roll × ${roll}`,
                   gap !== 1 && `small gaps × ${gap}`].filter(Boolean);
    naming(g, {what: "badge"});
    this.badge = found.length ? `not to scale: ${found.join(", ")}` : "";
    if (!this.badge) return;
    const half = g.measureText(this.badge).width / 2 + 8, x = this.w / 2;
    g.fillStyle = this.colour.of("accent");
    g.fillRect(x - half, 26, 2 * half, 20);
    g.fillStyle = this.colour.of("accent-ink");
    g.textAlign = "center";
    g.fillText(this.badge, x, 40);
    this.labels.keep(x - half, 26, x + half, 46);
  }

  // Draw the names of the sides and the scales of length and force.
  drawScales(largest) {
    const {g} = this, y = this.h - 12;
    naming(g, {what: "scales"});
    const {labels} = this;
    labels.words("← left, Y", 12, 18);
    labels.words("right →", this.w - 12, 18, "right");
    g.strokeStyle = this.colour.of("muted");
    g.lineWidth = 2;
    const length = roundBelow(90 / this.scale), bar = length * this.scale;
    strokes(g, [12, y, 12 + bar, y]);
    const size = length >= 1e-3 ? `${shortNumber(1e3 * length, 1)} mm` : `${shortNumber(1e6 * length, 1)} µm`;
    labels.words(size, 12, y - 6);
    const {logarithmic} = this.settings, right = this.w - 12 - ARROW;
    const decades = [1e3, 1e4, 1e5, 1e6, 1e7].filter(N => N >= LOG_FROM && N <= largest);
    const forces = logarithmic ? decades : [roundBelow(0.8 * largest)], several = forces.length > 1;
    g.fillStyle = g.strokeStyle = this.colour.of("muted");
    this.arrow(right, y, 1, 0, this.arrowLength(forces.at(-1), largest), 2);
    g.font = "11px system-ui, sans-serif";
    for (const N of forces) {
      const x = right + this.arrowLength(N, largest);
      labels.words(several ? `${N / 1e3}` : forceText(N), x, y - 8, several ? "center" : "right");
    }
    labels.words(several ? "kN, logarithmic" : "force", right - 6, y + 4, "right");
    g.font = "12px system-ui, sans-serif";
  }
}

// A gap or an approach along the normal, in the digits that the displacements at this time give it.
function gapWords({gap, point}, run, at) {
  const [y, z, roll] = ["Y", "Z", "roll"].map(name => run.has(name) ? run.reading(name, at) : new Reading(0));
  const off = (y.high - y.low + z.high - z.low + Math.hypot(...point) * (roll.high - roll.low)) / 2;
  return `${gap < 0 ? "approach" : "gap"} ${decimalWords(new Reading(Math.abs(gap) - off, Math.abs(gap) + off), 1e3)} mm`;
}

// A gap as it is drawn: `factor` times as large if it is small, as it is if it is whole, and in between without a step.
function exaggerated(gap, whole, factor) {
  if (gap <= 0 || !(whole > 0)) return factor * gap;
  return gap < whole ? whole * (1 - (1 - gap / whole) ** factor) : gap;
}

// The largest of 1, 2 and 5 times powers of ten that is at most x.
function roundBelow(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return [5, 2, 1].find(k => k * power <= x * (1 + 1e-9)) * power;
}
