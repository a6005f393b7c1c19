// Headless Chromium without a network, driven over the DevTools protocol: JSON texts, each ended by a zero byte.
const { spawn } = require("node:child_process");

// `flags` are Chromium's. What the browser logs or asks the network for is found in `errors` and `requests`.
function start(profile, flags = []) {
  const chromium = spawn("chromium", [
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-component-update",
    "--disable-background-networking", "--disable-sync", "--remote-debugging-pipe", "--window-size=1200,1000",
    ...flags, "--user-data-dir=" + profile, "about:blank",
  ], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
  const waiting = new Map(), errors = [], requests = [];
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
    if (method === "Runtime.consoleAPICalled") errors.push(`console.${params.type}: ${params.args.map((arg) => arg.value)}`);
    if (method === "Log.entryAdded") errors.push(params.entry.text);
    if (method === "Network.requestWillBeSent") requests.push(params.request.url.slice(0, 200));
  }

  function send(method, params = {}) {
    const id = ++last;
    chromium.stdio[3].write(JSON.stringify({ id, method, params, sessionId: session }) + "\0");
    return new Promise((resolve, reject) => waiting.set(id, { resolve, reject }));
  }

  async function open_tab() {
    const { targetId } = await send("Target.createTarget", { url: "about:blank" });
    session = (await send("Target.attachToTarget", { targetId, flatten: true })).sessionId;
    for (const domain of ["Page", "Runtime", "Log", "Network"]) await send(domain + ".enable");
  }

  async function open(url) {
    const done = new Promise((resolve) => { loaded = resolve; });
    await send("Page.navigate", { url });
    await done;
  }

  async function value(expression) {
    const { result, exceptionDetails } = await send("Runtime.evaluate", { expression, returnByValue: true, awaitPromise: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception.description);
    return result.value;
  }

  async function press(key, code = key, text = undefined) {
    const number = { ArrowRight: 39, ArrowLeft: 37, ArrowUp: 38, ArrowDown: 40, End: 35, Home: 36, " ": 32, Tab: 9, Enter: 13 }[key];
    const event = { key, code, windowsVirtualKeyCode: number, text };
    await send("Input.dispatchKeyEvent", { type: text ? "keyDown" : "rawKeyDown", ...event });
    await send("Input.dispatchKeyEvent", { type: "keyUp", ...event });
  }

  // Runs `use` in a tab and prints what it answers as JSON. A browser that stops answering fails the test instead of
  // holding it up.
  function run(use) {
    setTimeout(() => { chromium.kill(); console.error("no answer"); process.exit(1); }, 240_000).unref();
    open_tab().then(use)
      .then((found) => { console.log(JSON.stringify(found)); }, (error) => { console.error(error); process.exitCode = 1; })
      .finally(() => chromium.kill());
  }

  return { send, open, value, press, run, errors, requests };
}

module.exports = { start };
