"use strict";
// Draws the test in space on every canvas, and turns it with the pointer and the arrow keys.
for (const figure of document.querySelectorAll("figure.scene")) {
  const scene = JSON.parse(figure.nextElementSibling.textContent);
  const canvas = figure.querySelector("canvas");
  const pen = canvas.getContext("2d");
  if (!pen) continue;
  figure.classList.add("turns");
  let azimuth = 0.6, elevation = 0.45;
  // The size of the canvas in units of the page.
  let width = 1, height = 1;
  const add = (a, b, factor) => a.map((x, k) => x + factor * b[k]);
  const nodes = [...scene.sensors, ...scene.nodes].map((node) => node[1]);
  const points = [...nodes, ...scene.hits.map((h) => h[1])];
  if (scene.center) {
    points.push(scene.center);
    for (const axis of scene.axes ?? []) points.push(add(scene.center, axis, 1), add(scene.center, axis, -1));
  }
  const middle = [0, 1, 2].map((k) => {
    const all = points.map((p) => p[k]);
    return (Math.min(...all) + Math.max(...all)) / 2;
  });
  const far = (all) => Math.max(1e-3, ...all.map((p) => Math.hypot(...add(p, middle, -1))));
  const arrow = 0.3 * far(points);
  // All of it fits, however it is turned: the ellipsoid reaches as far as its longest axis.
  const longest = Math.max(0, ...(scene.axes ?? []).map((axis) => Math.hypot(...axis)));
  const ofBody = scene.center ? far([scene.center]) + longest : 0;
  const reach = Math.max(ofBody, far([...points, [0, 0, 0], ...scene.hits.map((h) => add(h[1], h[2], -arrow))]));
  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  function at(point) {
    const [x, y, z] = add(point, middle, -1);
    const [sa, ca, se, ce] = [Math.sin(azimuth), Math.cos(azimuth), Math.sin(elevation), Math.cos(elevation)];
    const scale = (Math.min(width, height) / 2 - 24) / reach;
    return [
      width / 2 + scale * (-sa * x + ca * y),
      height / 2 - scale * (-se * ca * x - se * sa * y + ce * z),
    ];
  }
  function line(from, to, thickness) {
    pen.lineWidth = thickness;
    pen.beginPath();
    pen.moveTo(...at(from));
    pen.lineTo(...at(to));
    pen.stroke();
  }
  // The corners of the convex hull of the nodes as they are seen (Andrew, 1979).
  function outline() {
    const left = ([x, y], [u, v], [p, q]) => (u - x) * (q - y) > (v - y) * (p - x);
    const half = (places) => {
      const corners = [];
      for (const place of places) {
        while (corners.length > 1 && !left(...corners.slice(-2), place)) corners.pop();
        corners.push(place);
      }
      return corners.slice(0, -1);
    };
    const places = nodes.map(at).sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    return [...half(places), ...half(places.reverse())];
  }
  function head(tip, from) {
    const [x, y] = at(tip), [u, v] = at(from);
    const turn = Math.atan2(y - v, x - u);
    pen.beginPath();
    pen.moveTo(x, y);
    for (const side of [2.7, -2.7]) pen.lineTo(x + 12 * Math.cos(turn + side), y + 12 * Math.sin(turn + side));
    pen.closePath();
    pen.fill();
  }
  function use(name) {
    pen.strokeStyle = pen.fillStyle = color(name);
  }
  // The boxes of the labels that are drawn already, of the nodes, and of what lies along arrows and axes.
  let taken = [];
  function label(text, point, dx, dy) {
    const [x, y] = at(point), wide = pen.measureText(text).width, tall = 12;
    const places = [[dx, dy], [5, 17], [-wide - 5, -5], [-wide - 5, 17], [-wide / 2, -12], [-wide / 2, 26], [9, 5], [-wide - 9, 5], [5, 32], [5, -21]];
    const boxes = places.map(([u, v]) => [x + u, y + v - tall, x + u + wide, y + v]);
    const free = (a) => taken.every((b) => a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1]);
    const box = boxes.find(free) ?? boxes[0];
    taken.push(box);
    pen.fillText(text, box[0], box[3]);
  }
  function ring(a, b) {
    pen.lineWidth = 1.2;
    pen.beginPath();
    for (let k = 0; k <= 60; k++) {
      const t = k * Math.PI / 30;
      pen.lineTo(...at(add(add(scene.center, a, Math.cos(t)), b, Math.sin(t))));
    }
    pen.stroke();
  }
  function draw() {
    pen.clearRect(0, 0, width, height);
    pen.font = "14px system-ui, sans-serif";
    taken = nodes.map(at).map(([x, y]) => [x - 7, y - 7, x + 7, y + 7]);
    const axes = [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]];
    const lines = [...scene.hits.map(([, tip, along]) => [tip, along, -arrow]), ...axes.map(([, axis]) => [[0, 0, 0], axis, 0.8 * arrow])];
    for (const [from, along, far] of lines) for (let k = 0; k <= 8; k++) {
      const [x, y] = at(add(from, along, far * k / 8));
      taken.push([x - 3, y - 3, x + 3, y + 3]);
    }
    pen.beginPath();
    for (const corner of outline()) pen.lineTo(...corner);
    pen.closePath();
    pen.fillStyle = color("--panel");
    pen.fill();
    use("--faint");
    pen.lineWidth = 1;
    pen.stroke();
    use("--faint");
    for (const [name, axis] of axes) {
      const end = add([0, 0, 0], axis, 0.8 * arrow);
      line([0, 0, 0], end, 1.2);
      label(name, end, 3, -3);
    }
    if (scene.center) {
      use("--body");
      if (scene.axes) {
        const [a, b, c] = scene.axes;
        for (const pair of [[a, b], [b, c], [c, a]]) ring(...pair);
        for (const axis of scene.axes) line(add(scene.center, axis, -1), add(scene.center, axis, 1), 0.8);
      }
      pen.beginPath();
      pen.arc(...at(scene.center), 6, 0, 7);
      pen.fill();
    }
    pen.lineWidth = 1.5;
    for (const [name, place] of scene.nodes) {
      pen.beginPath();
      pen.arc(...at(place), 4.5, 0, 7);
      pen.fillStyle = color("--paper");
      pen.fill();
      use("--ink");
      pen.stroke();
      if (name) label(name, place, -14, 20);
    }
    use("--sensor");
    for (const [name, place] of scene.sensors) {
      const [x, y] = at(place);
      pen.fillRect(x - 6, y - 6, 12, 12);
      label(name, place, -14, 20);
    }
    use("--hit");
    for (const [name, place, direction] of scene.hits) {
      const from = add(place, direction, -arrow);
      line(from, place, 2.2);
      head(place, from);
      label(name, from, 5, -5);
    }
  }
  function turn(right, down) {
    azimuth -= right;
    elevation = Math.max(-1.5, Math.min(1.5, elevation + down));
    draw();
  }
  let held = null;
  canvas.addEventListener("pointerdown", (event) => {
    held = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held) return;
    turn((event.clientX - held[0]) / 120, (event.clientY - held[1]) / 120);
    held = [event.clientX, event.clientY];
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { held = null; });
  canvas.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
    if (!steps[event.key]) return;
    event.preventDefault();
    turn(...steps[event.key]);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  new ResizeObserver(() => {
    if (!canvas.clientWidth) return;
    [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const pixels = devicePixelRatio || 1;
    [canvas.width, canvas.height] = [width * pixels, height * pixels];
    pen.setTransform(pixels, 0, 0, pixels, 0, 0);
    draw();
  }).observe(canvas);
}
// On paper everything is open.
let closed = [];
addEventListener("beforeprint", () => {
  closed = [...document.querySelectorAll("details:not([open])")];
  for (const of of closed) of.open = true;
});
addEventListener("afterprint", () => {
  for (const of of closed) of.open = false;
});
