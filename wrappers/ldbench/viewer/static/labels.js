// Words in the scene that keep clear of contact points, arrows and each other.

class Labels {
  constructor(g, colour, w, h) {
    Object.assign(this, {g, colour, w, h, taken: [], written: []});
  }

  // Keep a box free of words.
  keep(...box) { this.taken.push(box); }

  // Keep the surroundings of a point and of an arrow from it free.
  keepArrow(x, y, nx, ny, length) {
    for (let s = 0, r = 8; s <= length; s += 8, r = 5) this.keep(x + s * nx - r, y + s * ny - r, x + s * nx + r, y + s * ny + r);
  }

  // Write near (x, y), in the first free place of a ring round it; below it at first or above it.
  write(text, x, y, colour, first = 1) {
    const half = this.g.measureText(text).width / 2 + 4;
    const clamp = (v, low, high) => Math.min(Math.max(v, low), high);
    let best = null, least = Infinity;
    for (const r of [0, 14, 28, 42, 58, 76, 96])
      for (const [a, b] of [[0, first], [1, first], [-1, first], [1, 0], [-1, 0], [0, -first], [1, -first], [-1, -first]]) {
        if (!least) break;
        const cx = clamp(x + a * (r + (a ? half * 0.9 : 0)), half + 2, this.w - half - 2);
        const cy = clamp(y + b * r, 36, this.h - 38), box = [cx - half, cy - 11, cx + half, cy + 6];
        const hits = this.taken.filter(other => meets(other, box)).length;
        if (hits < least) [best, least] = [{cx, cy, box}, hits];
      }
    this.taken.push(best.box);
    this.written.push(best.box);
    this.words(text, best.cx, best.cy, "center", colour);
  }

  // Write with a margin in the colour of the paper.
  words(text, x, y, align = "left", colour = this.colour.of("muted")) {
    const {g} = this;
    g.textAlign = align;
    g.lineWidth = 4;
    g.strokeStyle = this.colour.of("paper");
    g.strokeText(text, x, y);
    g.fillStyle = colour;
    g.fillText(text, x, y);
  }
}

function meets([a1, b1, a2, b2], [c1, d1, c2, d2]) { return a1 < c2 && c1 < a2 && b1 < d2 && d1 < b2; }
