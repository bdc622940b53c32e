// Headless Chromium over its debugging pipe: no port, no library.
import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const program = ["/usr/bin/chromium", "/usr/bin/chromium-browser"].find(existsSync);
const notInstalled = 77;
const patience = 150; // for the answer to one command [s]

const skip = (why) => {
  console.log(`${why}: not checked`);
  process.exit(notInstalled);
};

/** Ends the test as skipped when there is no Chromium, or the program has no pages or no such command. */
export function requireParts(kinetostat, command) {
  if (!program) skip("chromium is not installed ('scripts/install-packages test' installs it)");
  const parts = execFileSync(kinetostat, ["--version"], { encoding: "utf8" });
  if (/Plotly +not built/.test(parts)) skip("the program was built without pages");
  const help = execFileSync(kinetostat, ["--help"], { encoding: "utf8" });
  if (!help.includes(`\n  ${command} `)) skip(`the program has no command ${command}`);
}

/** Chromium does not answer: now and then, on busy machines, its processes lose each other, whatever the page. */
class Stuck extends Error {}

export class Browser {
  constructor() {
    this.start();
  }

  start() {
    this.folder = mkdtempSync(join(tmpdir(), "kinetostat-browser-"));
    this.process = spawn(
      program,
      [
        "--headless=new",
        "--no-sandbox",
        "--remote-debugging-pipe",
        `--user-data-dir=${this.folder}`,
        "--disable-gpu",
        "--enable-unsafe-swiftshader",
        "--use-angle=swiftshader",
        "--hide-scrollbars",
        "--disable-background-networking",
        "--no-first-run",
        // A page that counts as hidden gets no frames, and who waits for one waits for ever.
        "--disable-backgrounding-occluded-windows",
        "--disable-renderer-backgrounding",
        "--disable-background-timer-throttling",
        // Drawing without a graphics card on a busy machine is slow, not stuck.
        "--disable-gpu-watchdog",
        "--enable-logging=stderr",
        "about:blank",
      ],
      { detached: true, stdio: ["ignore", "ignore", "pipe", "pipe", "pipe"] }, // a group of processes that end together
    );
    this.session = this.ended = undefined;
    this.complaints = []; // the last lines that Chromium itself wrote
    this.process.stdio[2].setEncoding("utf8").on("data", (chunk) => {
      this.complaints = [...this.complaints, ...chunk.trim().split("\n")].slice(-20);
    });
    this.next = 1;
    this.waiting = new Map();
    this.problems = []; // errors of pages, in words
    this.requests = []; // addresses that pages asked for
    this.process.on("exit", (code, signal) => {
      this.ended = new Error(`chromium ended (${signal ?? `exit code ${code}`})\n${this.complaints.join("\n")}`);
      this.waiting.forEach(({ reject }) => reject(this.ended));
    });
    for (const pipe of this.process.stdio.slice(3)) pipe.on("error", () => {}); // it has ended: said there
    let text = "";
    this.process.stdio[4].setEncoding("utf8").on("data", (chunk) => {
      text += chunk;
      const parts = text.split("\0");
      text = parts.pop();
      parts.forEach((part) => this.receive(JSON.parse(part)));
    });
  }

  receive(message) {
    if (message.id) {
      const { resolve, reject } = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      return message.error ? reject(new Error(message.error.message)) : resolve(message.result);
    }
    const { method, params } = message;
    if (method === "Runtime.exceptionThrown")
      this.problems.push(
        params.exceptionDetails.exception?.description ?? params.exceptionDetails.text,
      );
    if (method === "Runtime.consoleAPICalled" && ["error", "assert"].includes(params.type))
      this.problems.push(params.args.map((a) => a.value ?? a.description).join(" "));
    if (method === "Log.entryAdded" && params.entry.level === "error")
      this.problems.push(params.entry.text);
    if (method === "Network.requestWillBeSent") this.requests.push(params.request.url);
  }

  send(method, params = {}) {
    if (this.ended) return Promise.reject(this.ended);
    const id = this.next++;
    this.process.stdio[3].write(
      `${JSON.stringify({ id, method, params, sessionId: this.session })}\0`,
    );
    return new Promise((resolve, reject) => {
      const stuck = () =>
        new Stuck(
          `${method} ${params.expression ?? ""}: chromium did not answer for ${patience} s\n${this.complaints.join("\n")}`,
        );
      const late = setTimeout(() => reject(stuck()), 1000 * patience);
      const settled = (settle) => (value) => {
        clearTimeout(late);
        settle(value);
      };
      this.waiting.set(id, { resolve: settled(resolve), reject: settled(reject) });
    });
  }

  /** `again`: the page that is open stays, and is made as wide and as dark as that. */
  async open(address, { width = 1280, height = 900, dark = false, again = false } = {}) {
    if (!this.session) {
      const { targetId } = await this.send("Target.createTarget", { url: "about:blank" });
      this.session = (
        await this.send("Target.attachToTarget", { targetId, flatten: true })
      ).sessionId;
      for (const domain of ["Page", "Runtime", "Log", "Network"])
        await this.send(`${domain}.enable`);
      await this.send("Page.bringToFront");
    }
    await this.send("Emulation.setDeviceMetricsOverride", {
      width,
      height,
      deviceScaleFactor: 1,
      mobile: width < 600,
    });
    await this.send("Emulation.setEmulatedMedia", {
      features: [{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }],
    });
    if (again) {
      await this.evaluate("new Promise((next) => setTimeout(next, 50))");
      return this.frames();
    }
    this.requests = [];
    await this.send("Page.navigate", { url: address });
    await this.until("document.getElementById('page')?.dataset.ready === 'yes'");
  }

  async evaluate(expression) {
    const { result, exceptionDetails } = await this.send("Runtime.evaluate", {
      expression,
      awaitPromise: true,
      returnByValue: true,
    });
    if (exceptionDetails)
      throw new Error(
        `${expression}: ${exceptionDetails.exception?.description ?? exceptionDetails.text}`,
      );
    return result.value;
  }

  /** Returns when what was changed before has been drawn. */
  async frames() {
    await this.evaluate("new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(next)))");
  }

  async until(expression, seconds = 60) {
    const end = Date.now() + 1000 * seconds;
    while (!(await this.evaluate(expression))) {
      if (Date.now() > end)
        throw new Error(`never came true: ${expression}; ${this.problems.join("; ")}`);
      await new Promise((resolve) => setTimeout(resolve, 50));
    }
  }

  /** The sheets of what a printer would get; into a PDF file, too, when one is named. */
  async sheets(file) {
    const { data } = await this.send("Page.printToPDF", { preferCSSPageSize: true });
    const pdf = Buffer.from(data, "base64");
    if (file) writeFileSync(file, pdf);
    return [...pdf.toString("latin1").matchAll(/\/Type\s*\/Page\b/g)];
  }

  async key(key) {
    for (const type of ["keyDown", "keyUp"])
      await this.send("Input.dispatchKeyEvent", {
        type,
        key,
        code: key,
        windowsVirtualKeyCode: { Tab: 9, ArrowRight: 39, Enter: 13 }[key] ?? 0,
      });
  }

  /** Of the whole page, or of the element that a selector names. */
  async screenshot(file, selector) {
    const box = await this.evaluate(
      selector
        ? `(() => { const r = document.querySelector(${JSON.stringify(selector)}).getBoundingClientRect(); return { x: r.x + scrollX, y: r.y + scrollY, width: r.width, height: r.height }; })()`
        : "({ x: 0, y: 0, width: document.documentElement.clientWidth, height: document.documentElement.scrollHeight })",
    );
    const { data } = await this.send("Page.captureScreenshot", {
      format: "png",
      captureBeyondViewport: true,
      clip: { ...box, scale: 1 },
    });
    writeFileSync(file, Buffer.from(data, "base64"));
  }

  /** Takes a step that opens its pages itself; once more in another Chromium if this one is stuck. */
  async take(step) {
    try {
      await step(this);
    } catch (error) {
      if (!(error instanceof Stuck)) throw error;
      console.log(`${error.message}\nOnce more in another chromium.`);
      await this.close();
      this.start();
      await step(this);
    }
  }

  async close() {
    if (!this.ended) {
      const ended = new Promise((resolve) => this.process.on("exit", resolve));
      process.kill(-this.process.pid, "SIGKILL");
      await ended;
    }
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 5 });
  }
}
