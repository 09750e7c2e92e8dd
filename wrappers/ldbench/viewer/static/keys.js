// Keys, and dragging and zooming with mouse, pen and fingers.

// What keys do, and the buttons that name them.
const KEYS = {
  " ": page => page.player.toggle(),
  "ArrowLeft": (page, event) => page.stepRow(event.shiftKey ? -10 : -1),
  "ArrowRight": (page, event) => page.stepRow(event.shiftKey ? 10 : 1),
  "e": page => page.stepEvent(1),
  "E": page => page.stepEvent(-1),
  "Home": page => { page.pause(); page.go(page.start); },
  "End": page => { page.pause(); page.go(page.end); },
  "[": page => page.player.change(-1),
  "]": page => page.player.change(1),
  "+": page => page.zoomTime(0.5),
  "-": page => page.zoomTime(2),
  "0": page => page.wholeRun(),
  "1": page => page.look("whole"),
  "2": page => page.look("left"),
  "3": page => page.look("right"),
  "4": page => page.fitScene(),
  "f": () => get("follow").click(),
  "l": () => get("arrows").click(),
  "m": page => page.setMark(),
  "o": page => {
    page.player.loop(!page.player.looping);
    page.write();
  },
  "a": page => { if (page.runs.length > 1) get("align").click(); },
  "?": () => {
    get("keys").hidden = !get("keys").hidden;
    get("help").setAttribute("aria-expanded", !get("keys").hidden);
  },
};
const SCENE_KEYS = {
  "ArrowLeft": page => page.panScene(40, 0),
  "ArrowRight": page => page.panScene(-40, 0),
  "ArrowUp": page => page.panScene(0, 40),
  "ArrowDown": page => page.panScene(0, -40),
  "+": page => page.zoomScene(1.25),
  "-": page => page.zoomScene(0.8),
  "0": page => page.fitScene(),
};
const CHART_KEYS = {
  "b": chart => chart.setBoxing(!chart.boxing),
  "y": chart => chart.zoomValues(0.5),
  "Y": chart => chart.zoomValues(2),
  "g": chart => chart.setLog(!chart.log),
  "0": chart => chart.fit(),
  "Escape": chart => chart.fit(),
};

function pressKey(page, event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const {target, key} = event;
  if (target.matches("select, input:not([type=checkbox], [type=range])")) return;
  if (key === " " && target.matches("button, summary, a, input[type=checkbox]")) return;
  const chart = page.charts.find(one => one.canvas === target);
  const act = target === page.scene.canvas && SCENE_KEYS[key] || KEYS[key];
  if (chart && CHART_KEYS[key]) CHART_KEYS[key](chart);
  else if (act) act(page, event);
  else return;
  event.preventDefault();
}

// Mouse, pen and fingers on an element: one pointer drags, two zoom about the middle between them.
function pointers(element, {press = () => {}, drag, zoom, release = () => {}}) {
  const down = new Map();
  const place = event => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const spread = () => {
    const [a, b] = [...down.values()];
    return [Math.hypot(a[0] - b[0], a[1] - b[1]), (a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
  };
  element.addEventListener("pointerdown", event => {
    element.setPointerCapture(event.pointerId);
    const [x, y] = place(event);
    down.set(event.pointerId, [x, y]);
    if (down.size === 1) press(x, event, y);
  });
  element.addEventListener("pointermove", event => {
    if (!down.has(event.pointerId)) return;
    const [x0, y0] = down.get(event.pointerId), [x, y] = place(event);
    const before = down.size === 2 ? spread() : null;
    down.set(event.pointerId, [x, y]);
    if (before) {
      const [length, middleX, middleY] = spread();
      if (before[0] > 0) zoom(length / before[0], middleX, middleY, event);
    } else if (down.size === 1) drag(x - x0, y - y0, x, event, y);
  });
  for (const end of ["pointerup", "pointercancel"])
    element.addEventListener(end, event => {
      if (!down.delete(event.pointerId) || down.size) return;
      release(end === "pointercancel");
    });
  element.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(Math.exp(-Math.min(Math.max(event.deltaY, -120), 120) / 400), ...place(event), event);
  }, {passive: false});
}
