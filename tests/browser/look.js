// Opens every page of a folder in Chromium: look.js CHROMIUM PAGES PICTURES
"use strict";
const fs = require("node:fs");
const path = require("node:path");
const { pathToFileURL } = require("node:url");
const { chromium } = require("playwright-core");

const [executablePath, pages, pictures] = process.argv.slice(2);
const WIDTHS = [1280, 390];
const SCHEMES = ["light", "dark"];
/** The first page of this report is the picture of the README. */
const FIRST = { file: "test-1.html", width: 1180, height: 1100 };

function must(holds, what) {
  if (!holds) throw new Error(what);
}

/** Opens a page; it may ask for nothing but itself and must log nothing. */
async function opened(context, file) {
  const page = await context.newPage();
  const asked = [];
  page.on("request", (request) => asked.push(request.url()));
  page.on("console", (message) => asked.push(`console: ${message.text()}`));
  page.on("pageerror", (error) => asked.push(`error: ${error.message}`));
  page.on("dialog", (dialog) => asked.push(`dialog: ${dialog.message()}`));
  const address = pathToFileURL(path.join(pages, file)).href;
  await page.goto(address, { waitUntil: "load" });
  // What is folded is opened as well, and a script may only run after that.
  await page.evaluate(() => document.querySelectorAll("details").forEach((of) => { of.open = true; }));
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  must(asked.length === 1 && asked[0] === address, `${file}: ${asked.join("\n")}`);
  return page;
}

async function look(browser, file, width, colorScheme) {
  const context = await browser.newContext({ viewport: { width, height: 900 }, colorScheme });
  const page = await opened(context, file);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  must(wide <= width, `${file}: ${wide} pixels wide on a window of ${width}`);
  const name = `${path.basename(file, ".html")}-${width}-${colorScheme}`;
  await page.screenshot({ path: path.join(pictures, `${name}.png`), fullPage: true });
  await context.close();
}

async function print(browser, file) {
  const context = await browser.newContext();
  const page = await opened(context, file);
  const target = path.join(pictures, `${path.basename(file, ".html")}.pdf`);
  await page.pdf({ path: target, format: "A4" });
  must(fs.statSync(target).size > 10000, `${file}: nothing is printed`);
  await context.close();
}

(async () => {
  fs.mkdirSync(pictures, { recursive: true });
  const args = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"];
  const browser = await chromium.launch({ executablePath, args });
  const files = fs.readdirSync(pages).filter((name) => name.endsWith(".html"));
  for (const file of files) {
    for (const width of WIDTHS) for (const scheme of SCHEMES) await look(browser, file, width, scheme);
    await print(browser, file);
  }
  const { file, width, height } = FIRST;
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: "light" });
  const page = await context.newPage();
  await page.goto(pathToFileURL(path.join(pages, file)).href);
  await page.screenshot({ path: path.join(pictures, "first-page.png") });
  await browser.close();
  console.log(`${files.length} pages: each at ${WIDTHS.join(" and ")} pixels, ${SCHEMES.join(" and ")}, and printed: nothing asked for, nothing logged`);
})().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
