// The pressed patches of the first run at the moments of which the file has them: outline, pressure along the profile,
// largest pressure and area.

const PATCH = {width: 150, height: 132};        // room for a patch [px]

// Show the patches at the row of a time, or hide their place.
function drawPatches(run, t, colour) {
  const row = run.rowTime(t) - run.shift, moment = run.pressure.find(one => Math.abs(one.t - row) < 2e-7), holder = get("patches");
  holder.hidden = !moment;
  if (moment) paintPatches(moment.patches, Math.max(Math.floor(holder.clientWidth / PATCH.width), 1), colour);
}

// Draw patches beside each other, as many in a row as there is room for.
function paintPatches(patches, most, colour) {
  const {width, height} = PATCH, across = Math.min(most, patches.length), rows = Math.ceil(patches.length / across);
  const canvas = get("pressure"), {g} = prepare(canvas, width * across, height * rows);
  [canvas.style.width, canvas.style.height] = [`${width * across}px`, `${height * rows}px`];
  g.font = "11px system-ui, sans-serif";
  g.textAlign = "center";
  const words = patches.map(patch => `${patch.c} ${numberText(patch.pmax / 1e6, {decimals: 0})} MPa, ${numberText(1e6 * patch.area, {decimals: 0})} mm²`);
  canvas.setAttribute("aria-label", `contact patches: ${words.join("; ")}`);
  const largest = Math.max(...patches.flatMap(patch => [2 * patch.x, patch.s])), scale = 60 / largest;
  patches.forEach((patch, k) => {
    const middle = width / 2, n = patch.p.length, step = patch.s / n;
    g.save();
    g.translate(width * (k % across), height * Math.floor(k / across));
    g.fillStyle = colour.of("ink");
    g.fillText(words[k], middle, 12);
    // The patch from above: rolling direction up, the profile across.
    const at = i => middle + scale * ((i + 0.5) * step - patch.s / 2), reach = i => scale * patch.x * patch.w[i] / 99;
    g.beginPath();
    for (let i = 0; i < n; i++) g.lineTo(at(i), 50 - reach(i));
    for (let i = n - 1; i >= 0; i--) g.lineTo(at(i), 50 + reach(i));
    g.closePath();
    g.fillStyle = g.strokeStyle = colour.of(patch.c);
    g.globalAlpha = 0.35;
    g.fill();
    g.globalAlpha = 1;
    g.stroke();
    // The pressure along the profile, in the middle of the patch.
    g.beginPath();
    g.moveTo(at(-0.5), 108);
    patch.p.forEach((p, i) => g.lineTo(at(i), 108 - 24 * p / 99));
    g.lineTo(at(n - 0.5), 108);
    g.stroke();
    g.fillStyle = colour.of("muted");
    const size = roundBelow(largest / 2);
    g.fillRect(middle - scale * size / 2, 113, scale * size, 1.5);
    g.fillText(`${shortNumber(1e3 * size, 1)} mm along the profile`, middle, 125);
    g.restore();
  });
}
