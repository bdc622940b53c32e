// Text, JSON and page of a diagnosis quote one probability: over the campaigns that
// scripts/hidden-effects has diagnosed in a folder.
import assert from "node:assert/strict";
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { probabilityInWords, verdictInWords } from "../../report/page/words.js";

const folder = `${process.argv[2]}/cases`;
const wanted = 50;
const literal = (text) => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");

/** A probability as a headline has it. */
const inShort = (p) => (p > 0.999 ? "over 99.9 %" : p >= 0.1 ? `${(100 * p).toFixed(0)} %` : null);
const squeezed = (text) => text.replace(/\s+/g, " ");

let compared = 0;
for (const name of existsSync(folder) ? readdirSync(folder) : []) {
  const [json, text] = ["json", "txt"].map((type) => `${folder}/${name}/diagnosis.${type}`);
  if (!existsSync(json) || !existsSync(text)) continue;
  const said = JSON.parse(readFileSync(json, "utf8"));
  const printed = readFileSync(text, "utf8");
  assert.ok(printed.includes(`Verdict: ${verdictInWords(said.verdict)}\n`), name);
  assert.ok(squeezed(printed).includes(squeezed(said.headline)), `${name}: ${said.headline}`);
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
console.log(`${compared} diagnoses quote one probability`);
