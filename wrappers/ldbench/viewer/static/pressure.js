// The pressed patches of the first run at the moments of which the file has them: outline, pressure along the profile,
// largest pressure and area.

const PATCH = {width: 150, height: 132};        // room for a patch [px]

// Show the patches at the row of a time, or hide their place.
function drawPatches(page) {
  const {runs: [run], t, colour} = page;
  const row = run.rowTime(t) - run.shift, moment = run.pressure.find(one => Math.abs(one.t - row) < 2e-7), holder = get("patches");
  holder.hidden = !moment;
  page.shownPatches = moment?.patches ?? [];
  if (!moment) return;
  const most = Math.max(Math.floor(holder.clientWidth / PATCH.width), 1), [w, h] = patchesSize(moment.patches, most);
  const canvas = get("pressure"), {g} = prepare(canvas, w, h);
  [canvas.style.width, canvas.style.height] = [`${w}px`, `${h}px`];
  canvas.setAttribute("aria-label", `contact patches: ${moment.patches.map(patchWords).join("; ")}`);
  paintPatches(g, moment.patches, w / PATCH.width, colour);
}

// A patch in words; one that tread and flange share has both names.
function patchWords({c, also, pmax, area}) {
  return `${[c, also].filter(Boolean).join(" and ")} ${pressureText(pmax)}, ${numberText(1e6 * area, {decimals: 0})} mm²`;
}

// The size of a picture of patches beside each other, as many in a row as there is room for.
function patchesSize({length}, most) {
  const across = Math.min(most, length);
  return [PATCH.width * across, PATCH.height * Math.ceil(length / across)];
}

// The patches that are shown as a picture.
function patchesAs(kind, {shownPatches: patches, colour}) {
  const [w, h] = patchesSize(patches, patches.length);
  return onPaper(() => pictureOf(kind, w, h, g => {
    naming(g, {what: "paper"});
    g.fillStyle = colour.of("paper");
    g.fillRect(0, 0, w, h);
    paintPatches(g, patches, patches.length, colour);
  }));
}

function paintPatches(g, patches, across, colour) {
  const {width, height} = PATCH;
  g.font = "11px system-ui, sans-serif";
  g.textAlign = "center";
  g.setLineDash([]);
  const largest = Math.max(...patches.flatMap(patch => [2 * patch.x, patch.s])), scale = 60 / largest;
  patches.forEach((patch, k) => {
    const named = (what, unit, factor) => naming(g, {what, contact: patch.c, also: patch.also, side: patch.c[0], unit, factor});
    const middle = width / 2, n = patch.p.length, step = patch.s / n;
    g.save();
    g.translate(width * (k % across), height * Math.floor(k / across));
    g.fillStyle = colour.of("ink");
    named("patch in words", "MPa", 1e-6);
    g.fillText(patchWords(patch), middle, 12);
    named("patch", "mm", 1e3);
    g.lineWidth = 1;
    // The patch from above: rolling direction up, the profile across.
    const at = i => middle + scale * ((i + 0.5) * step - patch.s / 2), reach = i => scale * patch.x * patch.w[i] / 99;
    g.beginPath();
    const pressed = patch.w.map((_, i) => i).filter(i => patch.w[i] > 0);
    for (const i of pressed) g.lineTo(at(i), 50 - reach(i));
    for (const i of [...pressed].reverse()) g.lineTo(at(i), 50 + reach(i));
    g.closePath();
    g.fillStyle = g.strokeStyle = colour.of(patch.c);
    g.globalAlpha = 0.35;
    g.fill();
    g.globalAlpha = 1;
    g.stroke();
    // The pressure along the profile, in the middle of the patch.
    named("pressure", "MPa", 1e-6);
    g.beginPath();
    g.moveTo(at(-0.5), 108);
    patch.p.forEach((p, i) => g.lineTo(at(i), 108 - 24 * p / 99));
    g.lineTo(at(n - 0.5), 108);
    g.stroke();
    g.fillStyle = colour.of("muted");
    named("scale", "mm", 1e3);
    const size = roundBelow(largest / 2);
    g.fillRect(middle - scale * size / 2, 113, scale * size, 1.5);
    g.fillText(`${shortNumber(1e3 * size, 1)} mm along the profile`, middle, 125);
    g.restore();
  });
  naming(g);
}
