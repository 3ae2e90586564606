"use strict";
// Draws the test in space on every canvas, and turns it with the pointer and the arrow keys.
for (const figure of document.querySelectorAll("figure.scene")) {
  const scene = JSON.parse(figure.querySelector(".scene-data").textContent);
  const canvas = figure.querySelector("canvas");
  const pen = canvas.getContext("2d");
  let azimuth = 0.6, elevation = 0.45;
  const points = [...scene.sensors.map((s) => s[1]), ...scene.hits.map((h) => h[1])];
  if (scene.center) points.push(scene.center);
  const middle = [0, 1, 2].map((k) => {
    const all = points.map((p) => p[k]);
    return (Math.min(...all) + Math.max(...all)) / 2;
  });
  const reach = Math.max(1e-3, ...points.map((p) => Math.hypot(...p.map((x, k) => x - middle[k]))));
  const arrow = 0.35 * reach;
  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const add = (a, b, factor) => a.map((x, k) => x + factor * b[k]);

  function at(point) {
    const [x, y, z] = point.map((v, k) => v - middle[k]);
    const [sa, ca, se, ce] = [Math.sin(azimuth), Math.cos(azimuth), Math.sin(elevation), Math.cos(elevation)];
    const scale = 0.36 * Math.min(canvas.width, canvas.height * 1.3) / reach;
    return [
      canvas.width / 2 + scale * (-sa * x + ca * y),
      canvas.height / 2 - scale * (-se * ca * x - se * sa * y + ce * z),
    ];
  }
  function line(from, to, width) {
    pen.lineWidth = width;
    pen.beginPath();
    pen.moveTo(...at(from));
    pen.lineTo(...at(to));
    pen.stroke();
  }
  function head(tip, from) {
    const [x, y] = at(tip), [u, v] = at(from);
    const turn = Math.atan2(y - v, x - u);
    pen.beginPath();
    pen.moveTo(x, y);
    for (const side of [2.6, -2.6]) pen.lineTo(x + 16 * Math.cos(turn + side), y + 16 * Math.sin(turn + side));
    pen.closePath();
    pen.fill();
  }
  function use(name) {
    pen.strokeStyle = pen.fillStyle = color(name);
  }
  function label(text, point, dx, dy) {
    const [x, y] = at(point);
    pen.fillText(text, x + dx, y + dy);
  }
  function ring(a, b) {
    pen.lineWidth = 1.5;
    pen.beginPath();
    for (let k = 0; k <= 60; k++) {
      const t = k * Math.PI / 30;
      pen.lineTo(...at(add(add(scene.center, a, Math.cos(t)), b, Math.sin(t))));
    }
    pen.stroke();
  }
  function draw() {
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.font = "20px system-ui, sans-serif";
    use("--faint");
    for (const [name, axis] of [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]]) {
      const end = add([0, 0, 0], axis, arrow);
      line([0, 0, 0], end, 1.5);
      label(name, end, 4, -4);
    }
    if (scene.center) {
      use("--body");
      if (scene.axes) {
        const [a, b, c] = scene.axes;
        for (const pair of [[a, b], [b, c], [c, a]]) ring(...pair);
        for (const axis of scene.axes) line(add(scene.center, axis, -1), add(scene.center, axis, 1), 1);
      }
      pen.beginPath();
      pen.arc(...at(scene.center), 8, 0, 7);
      pen.fill();
    }
    use("--sensor");
    for (const [name, place] of scene.sensors) {
      const [x, y] = at(place);
      pen.fillRect(x - 8, y - 8, 16, 16);
      label(name, place, -8, 30);
    }
    use("--hit");
    for (const [name, place, direction] of scene.hits) {
      const from = add(place, direction, -arrow);
      line(from, place, 3);
      head(place, from);
      label(name, from, 8, -8);
    }
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
  function turn(right, down) {
    azimuth -= right;
    elevation = Math.max(-1.5, Math.min(1.5, elevation + down));
    draw();
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  draw();
}
