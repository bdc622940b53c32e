// Pages of results in a real browser: every chart has its points, charts are linked, nothing is asked of a network, names
// are text, and a page of 20,000 readings opens.
//
//   node report_test.mjs KINETOSTAT
import assert from "node:assert/strict";
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { Browser, requireParts } from "./browser.mjs";
import { lookAt } from "./look_at.mjs";
import { Workshop, slide } from "./workshop.mjs";
import { inPrint } from "../../report/page/words.js";

const program = process.argv[2];
requireParts(program, "report");
const shop = new Workshop(program);
for (const name of ["data", "meshes"]) shop.link(name);
const run = (...words) => shop.run(...words);
const evil = `</script><script>window.broken = 1</script><img src=x onerror="window.broken = 2"> <b>bold</b>`;

/** Loads up and down along three axes at some poses of the Orthoglide; noise from a fixed stream. */
function writeCampaign() {
  const lines = ["id,cycle,step,role,x,y,z,fx,fy,fz"];
  const poses = [
    [0, 0, 0],
    [40, 40, 40],
    [-40, -40, -40],
    [40, -40, 0],
  ];
  let cycle = 0;
  poses.forEach((pose, p) =>
    ["fx", "fy", "fz"].forEach((_, axis) => {
      cycle += 1;
      [0, 100, 200, 100, 0, -100, -200, -100, 0].forEach((load, step) => {
        const force = [0, 0, 0];
        force[axis] = load;
        lines.push(
          [
            `<i>r${lines.length}</i>`,
            cycle,
            step + 1,
            p === 3 ? "confirm" : "fit",
            ...pose,
            ...force,
          ].join(","),
        );
      });
    }),
  );
  shop.write("plan.csv", lines);
  const robot = readFileSync(shop.path("data/robots/orthoglide.yaml"), "utf8");
  writeFileSync(
    shop.path("robot.yaml"),
    `${robot}\nuncertain:\n  - {stiffness: x.rho}\n  - {stiffness: leg}\n`,
  );
  run(
    "simulate",
    "robot.yaml",
    "--plan",
    "plan.csv",
    "--components",
    "dx,dy,dz",
    "--noise-translation",
    "3um",
    "--effect",
    "clearance",
    "--at",
    "x.rho",
    "--size",
    "40 um",
    "--out",
    "campaign",
  );
  const file = shop.path("campaign/campaign.yaml");
  writeFileSync(file, readFileSync(file, "utf8").replace(/^campaign: .*$/m, `campaign: '${evil}'`));
  return lines.length - 1;
}

const look = (browser, name, how) => lookAt(browser, shop.address(name), how);

const phone = { width: 390, height: 800 };

async function comparison(browser) {
  const readings = writeCampaign();
  run("compare", "robot.yaml", "campaign/campaign.yaml", "--html", "compare.html");
  const points = await look(browser, "compare.html");
  assert.equal(points.parity, readings);
  assert.equal(points.waterfall, 3); // nominal, fitted, noise floor
  assert.equal(points["pose-map"], 4 * 6);
  assert.equal(points.arrows, 3 * 0 + 2 * readings); // both ends of every arrow
  assert.equal(points["four-plot"], 4 * readings - 1);
  assert.equal(points["against-load"], readings / 3);
  assert.equal(await browser.evaluate("window.broken"), undefined, "a name was taken for markup");
  assert.equal(await browser.evaluate("document.querySelector('h2').textContent"), evil);
  // A pose chosen in one place is seen in all.
  const chosen = (id) =>
    `document.getElementById("${id}").figure.plot.data.find((t) => t.name === "chosen pose").x.length`;
  await browser.evaluate(`document.getElementById("parity").scrollIntoView()`);
  await browser.evaluate(
    `document.getElementById("parity").figure.spec.choose({ customdata: 30 })`,
  );
  await browser.until(`${chosen("parity")} === ${readings / 4}`);
  assert.equal(await browser.evaluate("document.querySelectorAll('.tools select')[2].value"), "1");
  await browser.evaluate(`document.getElementById("four-plot").scrollIntoView()`);
  await browser.until(`${chosen("four-plot")} === ${readings / 4}`);
  // By keyboard alone: Tab comes to a chart, an arrow key goes to the next pose.
  await browser.evaluate(`document.querySelectorAll(".tools select")[2].focus()`);
  for (
    let k = 0;
    k < 40 &&
    !(await browser.evaluate(
      `document.activeElement.closest("figure")?.id === "parity" && document.activeElement.className.includes("plot")`,
    ));
    ++k
  )
    await browser.key("Tab");
  await browser.key("ArrowRight");
  await browser.until("document.querySelectorAll('.tools select')[2].value === '2'");
  // Axes stay when the model changes.
  const range = `JSON.stringify(document.getElementById("against-load").figure.plot.layout.yaxis.range)`;
  await browser.evaluate(`document.getElementById("against-load").scrollIntoView()`);
  const before = await browser.evaluate(range);
  await browser.evaluate(
    `(() => { const s = document.querySelectorAll(".tools select")[0]; s.value = "0"; s.dispatchEvent(new Event("change")); })()`,
  );
  assert.equal(await browser.evaluate(range), before);
  // From JSON alone the same charts, but for the robot among the arrows.
  run("compare", "robot.yaml", "campaign/campaign.yaml", "--json", "compare.json");
  run("report", "compare.json", "-o", "from_json.html");
  assert.deepEqual(await look(browser, "from_json.html"), points);
  await look(browser, "compare.html", { dark: true });
  await look(browser, "compare.html", phone);
}

/** A slide with a gap that its model lacks, in readings of a few seconds' diagnosis. */
async function diagnosis(browser) {
  shop.write("slide.yaml", slide);
  const rows = ["cycle,step,fz"];
  for (let cycle = 1; cycle <= 3; ++cycle)
    [0, 100, 200, 300, 100, 0, -100, -200, -300, -100, 0].forEach((load, k) =>
      rows.push([cycle, k + 1, load].join(",")),
    );
  shop.write("cycles.csv", rows);
  const hidden = ["--effect", "clearance", "--at", "drive", "--size", "20 um"];
  const noise = ["--components", "dz", "--noise-translation", "2um"];
  run("simulate", "slide.yaml", "--plan", "cycles.csv", ...noise, ...hidden, "--out", "slide");
  const diagnose = ["diagnose", "slide.yaml", "slide/campaign.yaml", "--draws", "99"];
  run(...diagnose, "--effects", "clearance,friction", "--html", "diagnose.html");
  const points = await look(browser, "diagnose.html");
  assert.equal(points.waterfall, 5); // nominal, fitted, with the clearance, as adopted, noise floor
  assert.equal(points["profile-1"], 13);
  assert.equal(points["profile-2"], 13);
  assert.equal(points["ranking-1"], 2);
  assert.equal(points["confusion-1"], 4);
  // The first screen says what is missing, and shows the error fall.
  await browser.evaluate("scrollTo(0, 0)");
  const first = await browser.evaluate(
    `({ verdict: document.querySelector(".verdict").innerText, title: document.querySelector("#waterfall h3").textContent,
        end: document.querySelector("#waterfall .plot").getBoundingClientRect().bottom, height: innerHeight })`,
  );
  assert.ok(first.verdict.includes("identified") && first.verdict.includes("clearance at arm.drive"));
  assert.equal(first.title, "The error falls");
  assert.ok(first.end <= first.height, `the chart ends at ${first.end} of ${first.height}`);
  await look(browser, "diagnose.html", phone);
  // From JSON alone, the page says how to come by what is not there.
  run(...diagnose, "--effects", "clearance", "--json", "diagnose.json");
  run("report", "diagnose.json", "-o", "short.html");
  const short = await look(browser, "short.html");
  assert.equal(short["profile-1"], undefined);
  assert.ok((await browser.evaluate("document.body.innerText")).includes("compare --json"));
}

/** All of it on one page: six stations, the joint's curve, the robot, and behind one line every step. */
async function study(browser) {
  run("study", "slide.yaml", "slide/campaign.yaml", "-o", "study");
  const points = await look(browser, "study/index.html");
  assert.equal(points["joint-curve"], 33);
  assert.equal(points["extra-deflection"], 33);
  assert.ok(points["skeleton-study"] > 0);
  const said = JSON.parse(readFileSync(shop.path("study/study.json"), "utf8"));
  const stations = await browser.evaluate(
    `[...document.querySelectorAll("nav.stations a")].map((a) => [a.className, a.textContent])`,
  );
  assert.equal(stations.length, 6);
  said.stations.forEach((station, k) => {
    assert.equal(stations[k][0], station.light);
    assert.ok(stations[k][1].includes(inPrint(station.sentence)), stations[k][1]);
  });
  // One headline: in the JSON of the study, of its diagnosis, and over the page.
  const diagnosis = JSON.parse(readFileSync(shop.path("study/diagnosis.json"), "utf8"));
  assert.equal(diagnosis.headline, said.headline);
  assert.equal(await browser.evaluate("document.querySelector('h1').textContent"), inPrint(said.headline));
  for (const link of await browser.evaluate(
    `[...document.querySelectorAll("nav.stations a")].map((a) => a.getAttribute("href").slice(1))`,
  ))
    assert.ok(await browser.evaluate(`Boolean(document.getElementById(${JSON.stringify(link)}))`), link);
  for (const how of [{ dark: true }, { width: 800 }, phone])
    await look(browser, "study/index.html", how);
}

/** Of a printed page: its sheets, and for each chart whether something is drawn in it. */
async function printed(browser, name) {
  await browser.open(shop.address(name), { dark: true });
  await browser.evaluate(`addEventListener("beforeprint", () => {
    window.onPaper = [...document.querySelectorAll("figure")].map((f) => ({
      id: f.id, points: Number(f.dataset.points ?? 0), width: f.getBoundingClientRect().width,
      drawn: f.querySelectorAll(".plot path, .plot .still").length, still: f.querySelectorAll(".still").length,
      solid: f.querySelectorAll(".gl-container canvas").length, theme: document.documentElement.dataset.theme }));
  })`);
  const sheets = await browser.sheets();
  return { sheets, figures: await browser.evaluate("window.onPaper") };
}

/** What is saved: of every chart its numbers, of one that is flat and one that is solid a picture, too. */
async function savedFiles(browser) {
  await browser.open(shop.address("all.html"));
  const saved = await browser.evaluate(`(async () => {
    const made = new Map();
    const create = URL.createObjectURL;
    URL.createObjectURL = (blob) => { const url = create(blob); made.set(url, blob); return url; };
    const files = [];
    HTMLAnchorElement.prototype.click = function () { files.push([this.download, made.get(this.href) ?? this.href]); };
    for (const figure of document.querySelectorAll("figure")) [...figure.querySelectorAll("button")].find((b) => b.textContent === "CSV").click();
    for (const id of ["path", "skeleton-stiffness"])
      for (const format of ["png", "svg"]) await document.getElementById(id).figure.save(format);
    return Promise.all(files.map(async ([name, what]) => [name, what instanceof Blob ? (await what.text()).slice(0, 400) : what.slice(0, 400)]));
  })()`);
  const csv = saved.filter(([name]) => name.endsWith(".csv"));
  assert.equal(csv.length, await browser.evaluate("document.querySelectorAll('figure').length"));
  for (const [name, text] of csv) {
    const [about, head, row] = text.split("\n");
    assert.ok(about.startsWith("# ") && head.includes(",") && row.length > 2, `${name}: ${text}`);
  }
  const pictures = saved.filter(([name]) => /\.(png|svg)$/.test(name));
  assert.equal(pictures.length, 4, saved.map(([name]) => name).join());
  for (const [name, what] of pictures) assert.ok(what.length > 100, `${name} is empty`);
}

async function paper(browser) {
  for (const [name, most] of [
    ["diagnose.html", 8],
    ["all.html", 20],
  ]) {
    const { sheets, figures } = await printed(browser, name);
    assert.ok(sheets.length >= 3 && sheets.length <= most, `${name}: ${sheets.length} sheets`);
    assert.ok(figures.length > 5);
    for (const f of figures) {
      assert.ok(f.points > 0 && f.drawn > 0, `${name}: ${f.id} is not on paper`);
      assert.ok(f.width <= 700, `${name}: ${f.id} is wider than paper`);
      assert.equal(f.theme, "light");
      if (/posture|skeleton/.test(f.id)) assert.equal(f.still, 1, `${f.id} would be empty`);
    }
    // Back on the screen as before.
    assert.equal(await browser.evaluate("document.documentElement.dataset.theme"), undefined);
    assert.equal(await browser.evaluate("document.querySelectorAll('.still').length"), 0);
  }
  assert.deepEqual(browser.problems, []);
}

async function manipulators(browser) {
  run(
    "stiffness",
    "data/robots/orthoglide.yaml",
    "--at",
    "0,0,0",
    "--wrench",
    "100,0,0",
    "--html",
    "stiffness.html",
  );
  run("assemble", "data/robots/orthoglide_errors.yaml", "--at", "0,0,0", "--html", "assemble.html");
  run(
    "trace",
    "data/robots/urrs_c.yaml",
    "--along",
    "-150,0,0",
    "--segments",
    "1",
    "--html",
    "trace.html",
  );
  run(
    "map",
    "data/robots/orthoglide.yaml",
    "--grid",
    "x=-60:60:7,y=-60:60:7,z=-40:40:3",
    "--index",
    "weakest-translation",
    "--html",
    "map.html",
  );
  run(
    "compensate",
    "data/robots/orthoglide_errors.yaml",
    "--path",
    "data/paths/orthoglide_milling.csv",
    "--html",
    "compensate.html",
  );
  run(
    "report",
    "stiffness.html",
    "assemble.html",
    "trace.html",
    "map.html",
    "compensate.html",
    "data/links/foot.link.json",
    "--title",
    evil,
    "-o",
    "all.html",
  );
  const points = await look(browser, "all.html");
  for (const how of [{ width: 800 }, phone]) await look(browser, "all.html", how);
  const path = JSON.parse(
    run(
      "trace",
      "data/robots/urrs_c.yaml",
      "--along",
      "-150,0,0",
      "--segments",
      "1",
      "--json",
      "-",
    ),
  ).path;
  assert.ok(points.path >= path.branches[0].points.length);
  assert.equal(points["map-slice"], 7 * 7);
  assert.equal(points["map-space"], 7 * 7 * 3);
  assert.equal(points["unloaded-stiffness-stiffness"], 36);
  assert.equal(points["link-compliance"], 36);
  assert.equal(points["compensation-position"], 2 * 21);
  assert.equal(await browser.evaluate("window.broken"), undefined, "a title was taken for markup");
  // The posture follows the cursor.
  await browser.evaluate(`document.getElementById("path-posture").scrollIntoView()`);
  await browser.evaluate(`document.getElementById("path").figure.spec.step(20)`);
  await browser.until(`document.getElementById("path-posture").figure.view.get("at")[1] === 20`);
}

async function uncertainty(browser) {
  run("stiffness", "data/robots/gantry.yaml", "--html", "uncertain.html");
  await look(browser, "uncertain.html");
  await look(browser, "uncertain.html", phone);
  const captions = await browser.evaluate(
    `[...document.querySelectorAll("caption")].map((c) => c.textContent).join(" ")`,
  );
  assert.match(captions, /What the stiffness along the softest direction is uncertain by/);
}

/** A click on a face copies its selector: what is copied picks that face of the block, and is shown as chosen. */
async function faces(browser) {
  await browser.open(shop.address("link.html"));
  await browser.evaluate(`document.getElementById("surface").scrollIntoView()`);
  const copied = await browser.evaluate(`(async () => {
    const node = document.getElementById("surface");
    for (let k = 0; k < 100 && !node.figure.drawn; ++k) await new Promise((r) => setTimeout(r, 100));
    let text = "";
    Object.defineProperty(navigator, "clipboard", { value: { writeText: async (t) => { text = t; } }, configurable: true });
    const clicked = node.figure.plot.data.filter((t) => t.name.startsWith("loaded"));
    node.figure.plot.emit("plotly_click", { points: [{ data: clicked[0] }] });
    await new Promise((r) => setTimeout(r, 300));
    return { text, traces: clicked.length, said: node.querySelector("output.selector").textContent,
             chosen: node.querySelector(".faces select").selectedOptions[0].textContent };
  })()`);
  assert.equal(copied.text, "plane: {point: [60, 0, 0], normal: [1, 0, 0]}");
  assert.equal(copied.said, `copied: ${copied.text}`);
  assert.equal(copied.chosen, copied.text);
  assert.equal(copied.traces, 1);
}

async function link(browser) {
  run("identify", "meshes/block.yaml", "--no-cache", "--html", "link.html");
  const points = await look(browser, "link.html");
  await look(browser, "link.html", phone);
  assert.ok(points.surface > 100);
  assert.equal(points.bracket, 12);
  await faces(browser);
}

/** A box whose lid has a hole: the page says so, and shows beside which facets. */
async function brokenMesh(browser) {
  const at = (i) => [i & 4 ? 40 : 0, i & 2 ? 30 : 0, i & 1 ? 20 : 0].join(" ");
  const facets = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7]];
  const written = facets.map((f) => `facet normal 0 0 0\nouter loop\n${f.map((i) => `vertex ${at(i)}`).join("\n")}\nendloop\nendfacet`);
  shop.write("broken.stl", ["solid box", ...written, "endsolid box"]);
  assert.throws(() => run("mesh", "check", "broken.stl", "--unit", "mm", "--html", "broken.html"), /does not bound a solid/);
  await look(browser, "broken.html");
  await look(browser, "broken.html", phone);
  const drawn = await browser.evaluate(
    `document.getElementById("surface").figure.plot.data.map((t) => [t.name, t.i.length])`,
  );
  assert.deepEqual(drawn.filter(([name]) => name === "open edge"), [["open edge", 3]]);
  assert.equal(drawn.filter(([name]) => name === "sound facets").reduce((sum, [, count]) => sum + count, 0), 8);
}

async function assembly(browser) {
  run("identify", "meshes/cad/post_on_plate.yaml", "--no-cache", "--html", "assembly.html");
  await look(browser, "assembly.html");
  await look(browser, "assembly.html", phone);
  assert.match(
    await browser.evaluate("document.body.textContent"),
    /plate and post: an elastic layer over 707 mm²\./,
  );
}

async function large(browser) {
  const lines = ["id,fz,dz"];
  for (let k = 0; k < 20000; ++k) {
    const load = 100 * (k % 200);
    lines.push(
      `${k},${load},${(load / 1.37e6 + 1e-5 * Math.sin(12.9898 * k) * Math.cos(78.233 * k)).toPrecision(8)}`,
    );
  }
  shop.write("readings.csv", lines);
  writeFileSync(
    shop.path("large.yaml"),
    "kinetostat: 1\ncampaign: many readings\nunits: {length: mm, force: N}\ndisplacement: difference\nwrench_point: reference\nnoise: {translation: 5 nm}\nreadings: readings.csv\n",
  );
  run("compare", "data/robots/bench.yaml", "large.yaml", "--html", "large.html");
  const size = statSync(shop.path("large.html")).size;
  assert.ok(size < 6e6, `a page of 20,000 readings has ${size} bytes`);
  const begin = Date.now();
  await browser.open(shop.address("large.html"));
  const seconds = (Date.now() - begin) / 1000;
  const points = await look(browser, "large.html");
  assert.equal(points.parity, 20000);
  assert.equal(points["four-plot"], 4 * 20000 - 1);
  const turn = Date.now();
  await browser.evaluate(`document.getElementById("parity").scrollIntoView()`);
  await browser.evaluate(
    `document.getElementById("parity").figure.spec.choose({ customdata: 30 })`,
  );
  console.log(
    `20,000 readings: ${(size / 1e6).toFixed(2)} MB, open after ${seconds.toFixed(2)} s, a choice takes ${Date.now() - turn} ms`,
  );
}

const browser = new Browser();
try {
  const steps = [comparison, diagnosis, study, manipulators, uncertainty, paper, savedFiles, link, brokenMesh, assembly, large];
  for (const step of steps) await browser.take(step);
} finally {
  await browser.close();
  shop.remove();
}
