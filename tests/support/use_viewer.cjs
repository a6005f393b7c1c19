// node use_viewer.cjs PAGE PROFILE FOLDER: uses the viewer and the plots of a report in headless Chromium, and prints as JSON what
// they showed after each step, all errors that were logged, and what was asked from elsewhere. Pictures of the canvas are written
// to FOLDER by their step's name.
const { writeFileSync } = require("node:fs");
const { join } = require("node:path");
const { start } = require("./chromium.cjs");

const [page, profile, folder] = process.argv.slice(2);
const { send, open, value, press, run, errors, requests } = start(profile, ["--use-gl=angle", "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader", "--hide-scrollbars", "--window-size=700,700"]);

const steps = {};

// Waits until what the controls ask for is unpacked, drawn, and on the screen.
async function drawn() {
  await value(`new Promise((done) => {
    const canvas = document.getElementById("viewer-canvas");
    const look = (frames) => {
      const ready = canvas.getAttribute("aria-busy") === "false";
      if (ready && frames === 0) done(); else requestAnimationFrame(() => look(ready ? frames - 1 : 2));
    };
    look(2);
  })`);
}

async function look(step, with_picture = false) {
  await drawn();
  steps[step] = await value(`(() => {
    const text = (name) => document.getElementById("viewer-" + name).textContent.replaceAll("\u202f", "");
    const seen = (name) => document.getElementById(name).getClientRects().length > 0;
    return {
      shown: text("shown"), at: text("at"), left: text("left"), right: text("right"), most: text("most"), seen: seen("viewer"),
      absent: seen("viewer-absent"), legend: seen("viewer-legend"),
      distance: 10 ** document.getElementById("viewer-distance").valueAsNumber,
      follows: document.getElementById("viewer-follow").checked,
      unlabelled: [...document.querySelectorAll("#viewer input, #viewer button, #viewer canvas")]
        .filter((e) => !(e.labels?.length || e.textContent || e.getAttribute("aria-label"))).length,
    };
  })()`);
  if (!with_picture) return;
  const clip = await value(`(() => {
    const { x, y, width, height } = document.getElementById("viewer-canvas").getBoundingClientRect();
    return { x: x + scrollX, y: y + scrollY, width, height, scale: 1 };
  })()`);
  const { data } = await send("Page.captureScreenshot", { clip, captureBeyondViewport: true });
  writeFileSync(join(folder, step + ".png"), Buffer.from(data, "base64"));
}

const set = (name, number) => value(`(() => {
  const input = document.getElementById("viewer-${name}");
  input.value = ${number};
  input.dispatchEvent(new Event("input"));
})()`);
const click = (name) => value(`document.getElementById("viewer-${name}").click()`);

async function use() {
  await open(page);
  await look("opened", true);
  const levels = await value(`document.getElementById("viewer-level").max`);
  for (let i = 0; i <= levels; ++i) {
    await set("level", i);
    await look("level-" + i, true);
  }
  await click("wireframe");
  await look("wireframe", true);
  await click("wireframe");
  await click("error");
  await look("error", true);
  await click("error");
  await click("beside");
  await look("beside", true);
  await click("beside");
  await look("again", true);
  await value(`document.getElementById("viewer-canvas").focus()`);
  await press("ArrowRight");
  await look("turned", true);
  await value(`document.getElementById("viewer-canvas").dispatchEvent(new KeyboardEvent("keydown", { key: "+" }))`);
  await look("zoomed", true);
  const box = await value(`(() => {
    const canvas = document.getElementById("viewer-canvas");
    canvas.scrollIntoView();
    const { x, y, width, height } = canvas.getBoundingClientRect();
    return { x, y, width, height };
  })()`);
  const mouse = (type, x, y, more) => send("Input.dispatchMouseEvent", { type, x: box.x + x * box.width, y: box.y + y * box.height, button: "left", ...more });
  await mouse("mousePressed", 0.5, 0.5, { buttons: 1, clickCount: 1 });
  await mouse("mouseMoved", 0.6, 0.6, { buttons: 1 });
  await mouse("mouseReleased", 0.6, 0.6, { buttons: 0, clickCount: 1 });
  await look("dragged", true);
  await click("reset");
  await look("reset", true);
  await click("follow");
  for (const share of [0, 0.4, 0.7, 1]) {
    await value(`(() => {
      const input = document.getElementById("viewer-distance");
      input.value = Number(input.min) + ${share} * (input.max - input.min);
      input.dispatchEvent(new Event("input"));
    })()`);
    await look("distance-" + share);
  }
  await click("size");
  await look("true-size", true);

  const tip = () => value(`[...document.querySelectorAll(".plot .tip")].filter((tip) => tip.getAttribute("visibility") === "visible")
    .map((tip) => tip.textContent.replaceAll("\u202f", ""))`);
  const plots = {};
  await value(`document.activeElement.blur()`);
  const point = await value(`(() => {
    document.querySelector(".plot").scrollIntoView();
    const { x, y, width, height } = document.querySelector(".plot .point").getBoundingClientRect();
    return { x: x + width / 2, y: y + height / 2 };
  })()`);
  await send("Input.dispatchMouseEvent", { type: "mouseMoved", x: point.x + 2, y: point.y - 2 });
  plots.pointer = await tip();
  await send("Input.dispatchMouseEvent", { type: "mouseMoved", x: 1, y: 1 });
  plots.away = await tip();
  // The first key makes the focus one of the keyboard.
  await press("Tab");
  await value(`document.querySelector(".plot svg").focus()`);
  plots.focus = await tip();
  await press("ArrowRight");
  plots.right = await tip();
  await press("End");
  plots.end = await tip();
  plots.spoken = await value(`document.getElementById("plot-values").textContent.replaceAll("\u202f", "")`);
  return { steps, plots, errors, requests: requests.filter((url) => url !== page && !url.startsWith("data:")) };
}

run(use);
