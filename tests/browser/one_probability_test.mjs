// Text, JSON, page and chart of a diagnosis quote one headline, one error and one probability: over the campaigns that
// scripts/hidden-effects has diagnosed in a folder.
//
//   node one_probability_test.mjs FOLDER KINETOSTAT
import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { resolve } from "node:path";
import { inPrint, modelInWords, probabilityInWords, verdictInWords } from "../../report/page/words.js";
import { Browser, requireParts } from "./browser.mjs";
import { Workshop } from "./workshop.mjs";

const folder = resolve(process.argv[2], "cases");
const wanted = 50;
const literal = (text) => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");

/** A probability as a headline has it. */
const inShort = (p) =>
  p > 0.999 ? "over 99.9 %" : p >= 0.1 ? `${(100 * p).toFixed(p >= 0.995 ? 1 : 0)} %` : null;
const squeezed = (text) => text.replace(/\s+/g, " ");

/** An error as the first screen has it. */
const times = (error) => error.toFixed(error < 10 ? 2 : error < 100 ? 1 : 0);

/** The bars of the first screen have the errors of the JSON. */
function barsAgree(said, printed, name) {
  const bars = [...printed.matchAll(/^  (\S.*?) +#+ +(\S+) {2}\(/gm)].map(([, , error]) => error);
  const errors = said.waterfall.filter((s) => !["as adopted", "noise floor"].includes(s.name));
  assert.deepEqual(bars, errors.map((s) => times(s.whitened)), `${name}: bars of the text`);
}

/** What the page says first, its verdict, and the numbers that its chart of the falling error draws. */
const shown = `(() => {
  const figure = document.getElementById("waterfall")?.figure;
  if (figure) figure.sight(true);
  const rankings = [...document.querySelectorAll("figure[id^='ranking-']")].map((node) => {
    node.figure.sight(true);
    return { id: node.id, rows: node.figure.spec.numbers().rows, texts: node.figure.plot.data[0].text };
  });
  return { rankings, heading: document.querySelector("h1").textContent, verdict: document.querySelector(".verdict strong").textContent,
    rows: figure?.spec.numbers().rows ?? [], bars: figure?.plot.data[0].y ?? [], colours: figure?.plot.data[0].marker.color ?? [], title: figure?.spec.title };
})()`;

/** What the chart and the table of a round give the laws of one class and place is, together, what the verdict gives it. */
function rankingAgrees(said, { id, rows, texts }, name) {
  const answers = said.found[Number(id.split("-")[1]) - 1]?.decision.answers ?? [];
  const given = new Map(rows.map((row) => [row[0].replaceAll("_", " "), row[4]]));
  for (const { probability, laws } of answers) {
    const parts = laws.map((law) => given.get(`${law.effect} at ${law.at}`.replaceAll("_", " ")));
    if (parts.includes(undefined)) continue;
    const sum = parts.reduce((all, one) => all + one, 0);
    assert.ok(Math.abs(sum - probability) < 1e-9, `${name}, ${id}: ${sum} is not ${probability}`);
    rankingsCompared += 1;
  }
  const drawn = rows.filter((row) => row[1] === "yes").slice(0, texts.length);
  drawn.forEach((row, k) => {
    if (texts[k] !== "not fitted") assert.equal(texts[k] === "over 99.9 %", row[4] > 0.999, `${name}, ${id}: ${texts[k]} for ${row[4]}`);
  });
}

async function pageAgrees(browser, shop, json, said, name) {
  shop.run("report", json, "-o", "page.html");
  await browser.open(shop.address("page.html"));
  const page = await browser.evaluate(shown);
  assert.equal(page.heading, inPrint(said.headline), name);
  assert.equal(page.verdict, verdictInWords(said.verdict), name);
  const errors = said.waterfall.map((s) => s.whitened);
  assert.deepEqual(page.rows.map((row) => row[0]), said.waterfall.map((s) => modelInWords(s.name)), name);
  assert.deepEqual(page.rows.map((row) => row[1]), errors, name);
  assert.deepEqual(page.bars, errors, name);
  // An error that rises is not said to fall, and its bar is not drawn as one that falls.
  const rising = (k) => k > 0 && said.waterfall[k].name !== "noise floor" && errors[k] > 1.005 * errors[k - 1];
  const orange = page.colours.filter((_, k) => rising(k));
  assert.ok(page.colours.every((colour, k) => rising(k) || !orange.includes(colour)), name);
  page.rankings.forEach((ranking) => rankingAgrees(said, ranking, name));
  const models = errors.filter((_, k) => said.waterfall[k].name !== "noise floor");
  if (models.length > 1)
    assert.equal(page.title, models.at(-1) < models[0] ? "The error falls" : "The error does not fall", name);
}

const [, , , program] = process.argv;
const cases = [];
let compared = 0;
let rankingsCompared = 0;
for (const name of existsSync(folder) ? readdirSync(folder) : []) {
  const [json, text] = ["json", "txt"].map((type) => `${folder}/${name}/diagnosis.${type}`);
  if (!existsSync(json) || !existsSync(text)) continue;
  const said = JSON.parse(readFileSync(json, "utf8"));
  const printed = readFileSync(text, "utf8");
  assert.ok(printed.includes(`Verdict: ${verdictInWords(said.verdict)}\n`), name);
  assert.ok(squeezed(printed).includes(squeezed(said.headline)), `${name}: ${said.headline}`);
  barsAgree(said, printed, name);
  cases.push([name, json, said]);
  for (const found of said.found) {
    const { answers, unexplained } = found.decision;
    if (said.verdict === "unexplained" || answers.length === 0) continue;
    compared += 1;
    const named = said.verdict !== "inconclusive";
    const short = named ? inShort(answers[0].probability) : null;
    if (short) assert.ok(said.headline.includes(short), `${name}: ${said.headline} has no ${short}`);
    for (const answer of answers) {
      const words = probabilityInWords(answer.probability);
      const line = new RegExp(`${literal(answer.class)} at [^(]*\\(${literal(words)}\\)`);
      assert.match(printed, line, `${name}: ${answer.class} with ${words}`);
    }
    const own = answers.find((a) =>
      a.laws.some((law) => law.effect === found.effect && law.at === found.at),
    );
    if (own) assert.equal(own.probability, found.probability, name);
    assert.ok(unexplained >= 0 && unexplained <= 1, name);
  }
}
if (compared < wanted) {
  console.log(`${compared} diagnoses with something found in ${folder}: run scripts/hidden-effects first`);
  process.exit(77);
}
requireParts(program, "report");
const shop = new Workshop(program);
const browser = new Browser();
try {
  // Evenly over all of them.
  const step = Math.max(1, Math.floor(cases.length / wanted));
  const opened = cases.filter((_, k) => k % step === 0).slice(0, wanted);
  for (const [name, json, said] of opened) await browser.take(() => pageAgrees(browser, shop, json, said, name));
  assert.deepEqual(browser.problems, []);
  assert.ok(rankingsCompared >= wanted, `${rankingsCompared} answers in rankings`);
  console.log(`${compared} diagnoses quote one probability, ${opened.length} pages the same as their JSON`);
} finally {
  await browser.close();
  shop.remove();
}
