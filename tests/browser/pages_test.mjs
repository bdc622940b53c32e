// The page of every command: its heading is what the command says first, in text and JSON; nothing is cut off, too wide or hard to
// reach, by axe-core's rules, too; terms lead to the glossary, and lengths follow the units that were chosen.
//
//   node pages_test.mjs KINETOSTAT
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { axeFaults } from "./accessibility.mjs";
import { Browser, requireParts } from "./browser.mjs";
import { lookAt } from "./look_at.mjs";
import { Workshop } from "./workshop.mjs";
import { sketchOf } from "../../report/page/studio/sketches.js";
import { inPrint } from "../../report/page/words.js";

const program = process.argv[2];
requireParts(program, "report");
const shop = new Workshop(program);
for (const name of ["data", "meshes"]) shop.link(name);

const arm = "data/measurements/arm_hysteresis";
const pages = {
  identify: ["identify", "meshes/block.yaml", "--no-cache"],
  beam: ["beam", "meshes/foot.yaml", "--fea", "data/links/foot.link.json"],
  mesh: ["mesh", "check", "meshes/foot.stl", "--unit", "mm"],
  modes: ["modes", "meshes/block.yaml"],
  robot_modes: ["modes", "data/robots/heavy_arm.yaml", "--response", "1:200", "--damping", "0.02"],
  stiffness: ["stiffness", "data/robots/six_axis.yaml"],
  uncertain: ["deflect", "data/robots/gantry.yaml", "--wrench=0,0,-200"],
  map: ["map", "data/robots/orthoglide.yaml", "--grid", "x=-60:60:3,y=-60:60:3,z=0", "--index", "weakest-translation"],
  fleet: ["fleet", "data/fleet/fleet.yaml"],
  compensate: ["compensate", "data/robots/orthoglide_errors.yaml", "--path", "data/paths/orthoglide_milling.csv"],
  assemble: ["assemble", "data/robots/orthoglide_errors.yaml", "--at", "0,0,0"],
  readings: ["readings", `${arm}/campaign.yaml`],
  check: ["measure", "check", `${arm}/campaign.yaml`],
  compare: ["compare", `${arm}/campaign.yaml`],
  diagnose: ["diagnose", `${arm}/campaign.yaml`, "-o", "diagnosis.json"],
  calibrate: ["calibrate", "data/measurements/ur10_tracker/campaign.yaml"],
  plan: ["plan", `${arm}/campaign.yaml`],
  adopt: ["adopt", `${arm}/robot.yaml`, "diagnosis.json", "-o", "calibrated.yaml"],
};
const squeezed = (text) => text.replace(/\s+/g, " ").trim();

async function page(browser, name, words) {
  const text = squeezed(shop.run(...words, "--html", `${name}.html`, "--json", `${name}.json`));
  await lookAt(browser, shop.address(`${name}.html`));
  const heading = await browser.evaluate("document.querySelector('h1').textContent");
  const said = JSON.parse(readFileSync(shop.path(`${name}.json`), "utf8"));
  const headline = said.headline ?? (name === "beam" ? `${said.link}: ${said.verdict}` : undefined);
  if (headline) {
    assert.equal(heading, inPrint(headline), name);
    assert.ok(text.includes(squeezed(headline).replace(/\.$/, "")), `${name}: ${text} has no ${headline}`);
  }
  assert.ok(heading.length > 20 && inPrint(text).startsWith(heading.replace(/\.$/, "").slice(0, 60)), `${name}: ${heading}`);
  await lookAt(browser, shop.address(`${name}.html`), { width: 390, height: 800, dark: true, again: true });
  assert.deepEqual(await axeFaults(browser), [], name);
}

/** Each term is linked once in a section, to a line that is there and says more. */
async function terms(browser) {
  await browser.open(shop.address("compare.html"));
  const links = await browser.evaluate(
    `[...document.querySelectorAll("a.term")].map((a) => [a.textContent, a.title, document.querySelector(a.hash)?.nextSibling.textContent ?? ""])`,
  );
  assert.ok(links.length >= 4, `${links.length} terms`);
  const bySection = await browser.evaluate(
    `[...document.querySelectorAll("#page section")].map((s) => [...s.querySelectorAll("a.term")].filter((a) => a.closest("section") === s).map((a) => a.hash))`,
  );
  for (const hashes of bySection) assert.equal(new Set(hashes).size, hashes.length, hashes.join());
  for (const [word, meaning, line] of links) assert.ok(meaning && line.startsWith(meaning), word);
  const glossary = readFileSync(new URL("../../docs/reference/glossary.md", import.meta.url), "utf8");
  for (const [word, meaning] of links) assert.ok(glossary.includes(meaning), word);
}

/** The largest reading of dx of the parity chart in mm, as it is shown. */
const shownLength = `(() => { const f = document.getElementById("parity"); f.scrollIntoView(); f.figure.sight(true); return [Math.max(...f.figure.plot.data[0].y.filter((v) => v !== null).map(Math.abs)), f.figure.plot.layout.yaxis.title.text]; })()`;

async function units(browser) {
  await browser.open(shop.address("compare.html"));
  const choose = (units) =>
    browser.evaluate(
      `(() => { const s = document.querySelector(".page-tools select"); s.value = ${JSON.stringify(units)}; s.dispatchEvent(new Event("change")); })()`,
    );
  const shown = {};
  for (const units of ["mm", "µm", "inch"]) {
    await choose(units);
    shown[units] = await browser.evaluate(shownLength);
  }
  const near = (a, b) => assert.ok(Math.abs(a / b - 1) < 1e-9, `${a} is not ${b}`);
  near(shown["µm"][0], 1000 * shown.mm[0]);
  near(shown.mm[0], 25.4 * shown.inch[0]);
  for (const [unit, [, title]] of Object.entries({ mm: shown.mm, "µm": shown["µm"], in: shown.inch }))
    assert.ok(title.includes(`[${unit}]`), `${title} is not in ${unit}`);
  // Sentences, too: every number that a length closes, and those in brackets behind it.
  await browser.open(shop.address("uncertain.html"));
  await choose("");
  const said = await browser.evaluate("document.querySelector('h1').textContent");
  await choose("inch");
  const inInches = await browser.evaluate("document.querySelector('h1').textContent");
  const numbersOf = (text) => text.match(/moves (\S+) .*?\((\S+), (\S+), (\S+)\)/).slice(1).map(Number);
  assert.match(inInches, /^45 lbf along -z: the platform moves \S+ µin ± /);
  assert.match(said, /^200 N along -z: the platform moves \S+ µm ± /);
  numbersOf(said).forEach((um, k) => assert.ok(Math.abs(numbersOf(inInches)[k] - (1e3 * um) / 25.4) <= 0.006 * Math.abs((1e3 * um) / 25.4), inInches));
  // It is kept for the next page.
  await browser.open(shop.address("stiffness.html"));
  assert.equal(await browser.evaluate("document.querySelector('.page-tools select').value"), "inch");
  assert.match(await browser.evaluate("document.getElementById('unloaded-stiffness-stiffness').textContent"), /lbf\/in/);
  await choose("");
  assert.deepEqual(browser.problems, []);
}

/** A pose that is picked in one chart of a map is shown by all: the others, the robot and the choice of poses. */
async function picked(browser) {
  await browser.open(shop.address("map.html"));
  const poses = JSON.parse(readFileSync(shop.path("map.json"), "utf8")).poses;
  const inSight = (id) => `(() => { const n = document.getElementById("${id}"); n.scrollIntoView(); n.figure.sight(true); })()`;
  const sign = (id) =>
    `(() => { const t = document.getElementById("${id}").figure.plot.data.find((d) => d.meta === "guide"); return t && [t.x[0], t.y[0]]; })()`;
  const choice = `document.querySelector(".tools label:last-child select")`;
  for (const id of ["map-space", "map-robot", "map-slice"]) await browser.evaluate(inSight(id));
  await browser.evaluate(`document.getElementById("map-slice").figure.spec.choose({ x: 55, y: -60 })`);
  for (const id of ["map-slice", "map-space"]) {
    await browser.evaluate(inSight(id));
    assert.deepEqual(await browser.evaluate(sign(id)), [60, -60], id);
  }
  assert.match(await browser.evaluate(`${choice}.selectedOptions[0].textContent`), /60, -60, 0 mm$/);
  const platform = `(() => { const f = document.getElementById("map-robot").figure; ${inSight("map-robot")}; return f.plot.data.filter((d) => d.mode === "lines" && d.name.startsWith("chain")).map((d) => [d.x.at(-1), d.y.at(-1)]); })()`;
  const ends = await browser.evaluate(platform);
  assert.ok(ends.length === 3 && ends.every(([x, y]) => Math.abs(x - 60) < 40 && Math.abs(y + 60) < 40), JSON.stringify(ends));
  // From the robot on to the next pose, seen in the map.
  const before = Number(await browser.evaluate(`${choice}.value`));
  await browser.evaluate(`document.getElementById("map-robot").figure.spec.step(1)`);
  assert.equal(Number(await browser.evaluate(`${choice}.value`)), (before + 1) % poses);
  await browser.evaluate(`${choice}.value = "4"; ${choice}.dispatchEvent(new Event("change"))`);
  for (const id of ["map-slice", "map-space"]) {
    await browser.evaluate(inSight(id));
    assert.deepEqual(await browser.evaluate(sign(id)), [0, 0], id);
  }
  assert.deepEqual(browser.problems, []);
}

/** Every effect of the catalogue has its picture in the studio; it is not that of no effect. */
function sketched() {
  shop.run("effect", "list", "--json", "effects.json");
  for (const { name } of JSON.parse(readFileSync(shop.path("effects.json"), "utf8")).effects) {
    const found = sketchOf(name);
    assert.ok(found && found.points.every((p) => p.every(Number.isFinite)), name);
    const without = (x) => (found.axis === "load" ? x : 0);
    assert.ok(Math.max(...found.points.map(([x, y]) => Math.abs(y - without(x)))) > 0.2, name);
  }
}

/** The response at its lowest frequency is near the compliance at rest; a mode moves while "Play" is pressed. */
async function vibrations(browser) {
  await browser.open(shop.address("robot_modes.html"));
  const seen = (id) => `(() => { const n = document.getElementById("${id}"); n.scrollIntoView(); n.figure.sight(true); return n.figure.plot.data; })()`;
  shop.run("stiffness", "data/robots/heavy_arm.yaml", "--json", "still.json");
  const still = JSON.parse(readFileSync(shop.path("still.json"), "utf8")).unloaded.compliance.matrix;
  const curves = await browser.evaluate(`${seen("frequency-response")}.map((d) => d.y[0])`);
  curves.forEach((v, k) => assert.ok(Math.abs(v / (1e6 * still[k][k]) - 1) < 0.05, `${v} um/N, at rest ${still[k][k]} m/N`));
  const tip = `${seen("mode-shape")}[0] && document.getElementById("mode-shape").figure.plot.data.slice(0, 4).map((d) => d.z.at(-1)).join()`;
  const resting = await browser.evaluate(tip);
  await browser.evaluate(`[...document.querySelectorAll("#mode-shape button")].find((b) => b.textContent === "Play").click()`);
  await browser.until(`${tip} !== ${JSON.stringify(resting)}`);
  await browser.evaluate(`[...document.querySelectorAll("#mode-shape button")].find((b) => b.textContent === "Stop").click()`);
  assert.deepEqual(browser.problems, []);
}

const browser = new Browser();
try {
  for (const [name, words] of Object.entries(pages)) await browser.take(() => page(browser, name, words));
  sketched();
  for (const step of [terms, units, picked, vibrations]) await browser.take(step);
} finally {
  await browser.close();
  shop.remove();
}
