// Makes the pages that are looked at: make.js MASSLINE REPOSITORY FOLDER
"use strict";
const { execFileSync } = require("node:child_process");
const fs = require("node:fs");
const path = require("node:path");

const [massline, repository, folder] = process.argv.slice(2);
/** Largest page, bytes, and longest time to make one, s. */
const MOST_BYTES = 2 * 1024 * 1024;
const MOST_SECONDS = 2;

const run = (...words) =>
  execFileSync(massline, words, { cwd: folder, stdio: ["ignore", "pipe", "ignore"], maxBuffer: 1 << 28 });
const example = (name) => path.resolve(repository, "host/examples", name);
const archive = path.resolve(repository, "tests/data/archive/version-1.massline");

/** A layout with another title. */
function titled(file, title) {
  const text = fs.readFileSync(example("three-bar-test-1.toml"), "utf8");
  const changed = text.replace(/^title = .*$/m, `title = ${JSON.stringify(title)}`);
  fs.writeFileSync(path.join(folder, file), changed);
}

// What is not one command alone: the tests themselves take longer than their reports.
for (const number of [1, 2, 3, 4]) run("simulate", example(`three-bar-test-${number}.toml`), "--report", `test-${number}.html`);
run("demo", "--report", "demo.html");
run("demo", "wheel", "--write", "wheel.uff");
fs.writeFileSync(path.join(folder, "wheel.json"), run("solve", "wheel.toml", "wheel.uff", "--json"));
titled("markup.toml", '<script>alert(1)</script> & "quotes" <b>bold</b>');
titled("right-to-left.toml", "\u05de\u05e1\u05d2\u05e8\u05ea \u202e abc \u0625\u0637\u0627\u0631");
titled("long.toml", "W".repeat(4096));
for (const name of ["markup", "right-to-left", "long"]) run("simulate", `${name}.toml`, "--report", `${name}.html`);

const reports = {
  "archive.html": [archive],
  "wheel.html": ["wheel.json", "--layout", "wheel.toml"],
  "both.html": ["test-1.html", "test-2.html"],
};
for (const [page, results] of Object.entries(reports)) {
  const began = process.hrtime.bigint();
  run("report", ...results, "-o", page);
  const seconds = Number(process.hrtime.bigint() - began) / 1e9;
  console.log(`${page} made in ${seconds.toFixed(2)} s`);
  if (seconds > MOST_SECONDS) throw new Error(`${page}: ${seconds} s`);
}
for (const page of fs.readdirSync(folder).filter((name) => name.endsWith(".html"))) {
  const { size } = fs.statSync(path.join(folder, page));
  console.log(`${page}: ${(size / 1e6).toFixed(2)} MB`);
  if (size > MOST_BYTES) throw new Error(`${page}: ${size} bytes`);
}
