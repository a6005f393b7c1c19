// node use_report.cjs PAGE PROFILE: opens a report in headless Chromium, uses it by keys alone, and prints as JSON
// what it showed after each step, and all errors that were logged.
const { start } = require("./chromium.cjs");

const [page, profile] = process.argv.slice(2);
const { send, open, value, press, run, errors } = start(profile, ["--disable-gpu", "--disable-3d-apis"]);

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
  no_viewer: document.getElementById("viewer-absent").getClientRects().length > 0
    ? document.getElementById("viewer-absent").textContent : "",
  broken: [...document.images].filter((i) => i.naturalWidth === 0).length,
  overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  }); })()`);

async function use() {
  const steps = {};
  await open(page);
  // The viewer's program is unpacked after the page has loaded.
  await value(`new Promise((done) => {
    const absent = document.getElementById("viewer-absent");
    (function look() { if (/unpacked/.test(absent.textContent)) setTimeout(look, 20); else done(); })();
  })`);
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
  await open(page);
  steps.without_scripts = await state();
  return { steps, errors };
}

run(use);
