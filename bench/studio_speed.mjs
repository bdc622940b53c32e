// How long one waits in the studio: for the bent robot on the page, for an effect that is added, for a slider, for a reload.
//
//   node bench/studio_speed.mjs KINETOSTAT [CAMPAIGN ...]      campaign files that name their robot; the shipped arms unless given
//
// Prints a line for each campaign [s]: the median and the largest of all effects that can be added. "cpu" is what the program itself took,
// which others on the machine do not change.
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { Browser } from "../tests/browser/browser.mjs";

const [program, ...given] = process.argv.slice(2);
const root = join(dirname(fileURLToPath(import.meta.url)), "..");
const shipped = ["arm_backlash_soft_base", "arm_hysteresis", "arm_thermal_day", "six_axis_balancer"];
const campaigns = given.length ? given : shipped.map((name) => `data/measurements/${name}/campaign.yaml`);

const pause = (milliseconds) => new Promise((next) => setTimeout(next, milliseconds));
/** Seconds of all threads of a process until now (proc(5)). */
function cpuOf(pid) {
  const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
  return (Number(fields[11]) + Number(fields[12])) / 100;
}
async function ask(address, action, body = {}) {
  const response = await fetch(address + action, { method: "POST", body: JSON.stringify(body) });
  return response.json();
}
async function job(address, name, body) {
  await ask(address, name, body);
  for (;;) {
    const now = await ask(address, "progress");
    if (!now.running) return now;
    await pause(5);
  }
}
function start(campaign, folder) {
  const studio = spawn(program, ["studio", campaign, "--folder", folder, "-q"], {
    cwd: root,
    env: { ...process.env, XDG_CACHE_HOME: folder },
  });
  return new Promise((resolve, reject) => {
    let text = "";
    studio.on("exit", (code) => reject(new Error(`ended with ${code}: ${text}`)));
    for (const stream of [studio.stdout, studio.stderr])
      stream.on("data", (chunk) => {
        text += chunk;
        const address = text.match(/http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{32}\//);
        if (address) resolve([studio, address[0]]);
      });
  });
}
async function timed(pid, act) {
  const [wall, cpu] = [performance.now(), cpuOf(pid)];
  const value = await act();
  return { value, wall: (performance.now() - wall) / 1000, cpu: cpuOf(pid) - cpu };
}
const seconds = (value) => value.toFixed(2).padStart(6);
function spread(times) {
  const sorted = [...times].sort((a, b) => a - b);
  return `${seconds(sorted[sorted.length >> 1])} ${seconds(sorted.at(-1))}`;
}

/** From the start of the page until the bent robot is drawn, as the page itself counts. */
async function drawn(browser, address) {
  await browser.open(address);
  await browser.until("document.querySelector('.bench')?.dataset.drawn", 60);
  return (await browser.evaluate("Number(document.querySelector('.bench').dataset.drawn)")) / 1000;
}

async function one(campaign, browser) {
  const folder = mkdtempSync(join(tmpdir(), "kinetostat-speed-"));
  const [studio, address] = await start(campaign, folder);
  try {
    const opened = await timed(studio.pid, () => job(address, "open", {}));
    const first = await drawn(browser, address);
    const { project } = await ask(address, "state");
    const fits = [];
    for (const { name } of project.effects)
      fits.push({ name, ...(await timed(studio.pid, () => job(address, "fit", { effects: [name] }))) });
    const sliders = [];
    for (const { name, value } of fits) {
      if (!value.result) continue;
      const values = [value.result.card.effects[0].parameters.map((p) => 0.9 * p.value)];
      sliders.push(await timed(studio.pid, () => ask(address, "try", { effects: [name], values })));
    }
    const slowest = fits.reduce((a, b) => (b.wall > a.wall ? b : a));
    const of = (list, key) => spread(list.map((time) => time[key]));
    console.log(
      `${campaign}: open ${seconds(opened.wall)}, bent robot ${seconds(first)}, again ${seconds(await drawn(browser, address))}; ${fits.length} effects ${of(fits, "wall")} (${slowest.name}), cpu ${of(fits, "cpu")}; slider ${of(sliders, "wall")}`,
    );
  } finally {
    studio.removeAllListeners("exit");
    studio.kill("SIGINT");
    await new Promise((resolve) => studio.on("exit", resolve));
    rmSync(folder, { recursive: true });
  }
}

const browser = new Browser();
try {
  for (const campaign of campaigns) await one(campaign, browser);
} finally {
  await browser.close();
}
