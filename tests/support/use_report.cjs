// node use_report.cjs PAGE PROFILE: opens a report in headless Chromium, uses it by keys alone, and prints as JSON
// what it showed after each step, and all errors that were logged.
const { spawn } = require("node:child_process");

const [page, profile] = process.argv.slice(2);
const chromium = spawn("chromium", [
  "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-component-update",
  "--disable-background-networking", "--disable-sync", "--remote-debugging-pipe", "--window-size=1200,1000",
  "--user-data-dir=" + profile, "about:blank",
], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });

// Chromium's DevTools protocol: JSON texts, each ended by a zero byte.
const waiting = new Map(), errors = [];
let last = 0, rest = "", session, loaded = () => {};
chromium.stdio[4].setEncoding("utf8");
chromium.stdio[4].on("data", (data) => {
  const texts = (rest + data).split("\0");
  rest = texts.pop();
  for (const text of texts) take(JSON.parse(text));
});

function take(message) {
  if (message.id) {
    const { resolve, reject } = waiting.get(message.id);
    waiting.delete(message.id);
    if (message.error) reject(new Error(message.error.message)); else resolve(message.result);
  }
  const { method, params } = message;
  if (method === "Page.loadEventFired") loaded();
  if (method === "Runtime.exceptionThrown") errors.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
  if (method === "Runtime.consoleAPICalled") errors.push("console." + params.type);
  if (method === "Log.entryAdded") errors.push(params.entry.text);
}

function send(method, params = {}) {
  const id = ++last;
  chromium.stdio[3].write(JSON.stringify({ id, method, params, sessionId: session }) + "\0");
  return new Promise((resolve, reject) => waiting.set(id, { resolve, reject }));
}

async function open() {
  const done = new Promise((resolve) => { loaded = resolve; });
  await send("Page.navigate", { url: page });
  await done;
}

async function value(expression) {
  const { result, exceptionDetails } = await send("Runtime.evaluate", { expression, returnByValue: true, awaitPromise: true });
  if (exceptionDetails) throw new Error(exceptionDetails.exception.description);
  return result.value;
}

async function press(key, code = key, text = undefined) {
  const number = { ArrowRight: 39, ArrowLeft: 37, End: 35, Home: 36, " ": 32, Tab: 9, Enter: 13 }[key];
  const event = { key, code, windowsVirtualKeyCode: number, text };
  await send("Input.dispatchKeyEvent", { type: text ? "keyDown" : "rawKeyDown", ...event });
  await send("Input.dispatchKeyEvent", { type: "keyUp", ...event });
}

// Titles of the sections that can be seen, and what the slider says.
const state = () => value(`(() => {
  const plain = (text) => text.replaceAll("\u202f", "");
  return ({
  titles: [...document.querySelectorAll("section.level")].filter((s) => s.getClientRects().length > 0)
            .map((s) => plain(s.querySelector("h3").textContent)),
  slider: document.getElementById("slider").getClientRects().length > 0,
  value: document.getElementById("level").value,
  text: plain(document.getElementById("shown-level").textContent),
  spoken: plain(document.getElementById("level").getAttribute("aria-valuetext") ?? ""),
  focus: document.activeElement.id,
  broken: [...document.images].filter((i) => i.naturalWidth === 0).length,
  overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  }); })()`);

async function use() {
  const { targetId } = await send("Target.createTarget", { url: "about:blank" });
  session = (await send("Target.attachToTarget", { targetId, flatten: true })).sessionId;
  for (const domain of ["Page", "Runtime", "Log"]) await send(domain + ".enable");
  const steps = {};
  await open();
  steps.opened = await state();
  // The links of the table come first; the slider is the first control after them.
  for (let i = 0; i < 50 && await value("document.activeElement.id") !== "level"; ++i) await press("Tab");
  steps.reached = await state();
  await press("ArrowRight");
  steps.right = await state();
  await press("Home");
  steps.home = await state();
  await press("End");
  steps.end = await state();
  await press("Tab");
  await press(" ", "Space", " ");
  steps.all = await state();
  await press(" ", "Space", " ");
  await value(`document.querySelector('a[href="#level-1"]').focus()`);
  // Keys may overtake other messages, so the page must listen before the key is sent.
  await value(`followed = new Promise((done) => addEventListener("hashchange", () => done(1), { once: true })); 0`);
  await press("Enter", "Enter", "\r");
  await value("followed");
  steps.link = await state();
  await send("Emulation.setEmulatedMedia", { media: "print" });
  steps.printed = await state();
  await send("Emulation.setEmulatedMedia", { media: "" });
  await send("Emulation.setScriptExecutionDisabled", { value: true });
  await open();
  steps.without_scripts = await state();
  return { steps, errors };
}

// A browser that stops answering fails the test instead of holding it up.
setTimeout(() => { chromium.kill(); console.error("no answer"); process.exit(1); }, 120_000).unref();

use().then((found) => { console.log(JSON.stringify(found)); }, (error) => { console.error(error); process.exitCode = 1; })
  .finally(() => chromium.kill());
