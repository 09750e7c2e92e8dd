// Keys, and dragging and zooming with mouse, pen and fingers.

const KEYS = {
  " ": page => page.playing ? page.pause() : page.play(),
  "ArrowLeft": (page, event) => page.stepRow(event.shiftKey ? -10 : -1),
  "ArrowRight": (page, event) => page.stepRow(event.shiftKey ? 10 : 1),
  "e": page => page.stepEvent(1),
  "E": page => page.stepEvent(-1),
  "Home": page => { page.pause(); page.go(page.start); },
  "End": page => { page.pause(); page.go(page.end); },
  "[": page => page.changeSpeed(-1),
  "]": page => page.changeSpeed(1),
  "+": page => page.zoomTime(0.5),
  "-": page => page.zoomTime(2),
  "0": page => page.wholeRun(),
  "1": page => page.look("whole"),
  "2": page => page.look("left"),
  "3": page => page.look("right"),
  "l": () => get("logarithmic").click(),
  "?": () => get("help").click(),
};
const SCENE_KEYS = {
  "ArrowLeft": page => { page.scene.pan(40, 0); page.redrawScene(); },
  "ArrowRight": page => { page.scene.pan(-40, 0); page.redrawScene(); },
  "ArrowUp": page => { page.scene.pan(0, 40); page.redrawScene(); },
  "ArrowDown": page => { page.scene.pan(0, -40); page.redrawScene(); },
  "+": page => page.zoomScene(1.25),
  "-": page => page.zoomScene(0.8),
  "0": page => page.look(page.scene.view),
};

// Mouse, pen and fingers on an element: one pointer drags, two zoom about the middle between them.
function pointers(element, {press = () => {}, drag, zoom}) {
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
    down.set(event.pointerId, place(event));
    if (down.size === 1) press(place(event)[0], event);
  });
  element.addEventListener("pointermove", event => {
    if (!down.has(event.pointerId)) return;
    const [x0, y0] = down.get(event.pointerId), [x, y] = place(event);
    const before = down.size === 2 ? spread() : null;
    down.set(event.pointerId, [x, y]);
    if (before) {
      const [length, middleX, middleY] = spread();
      if (before[0] > 0) zoom(length / before[0], middleX, middleY);
    } else if (down.size === 1) drag(x - x0, y - y0, x, event);
  });
  for (const end of ["pointerup", "pointercancel"])
    element.addEventListener(end, event => down.delete(event.pointerId));
  element.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(Math.exp(-Math.min(Math.max(event.deltaY, -120), 120) / 400), ...place(event));
  }, {passive: false});
}
