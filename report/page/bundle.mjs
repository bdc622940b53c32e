// Makes the page into which results are put: style, script and Plotly in one HTML file.
//
//   node bundle.mjs PLOTLY.js OUT.html
//
// The modules of this folder are joined in the order in which they import each other, without their
// imports and exports: a name is used once in all of them. Plotly is deflated, which the page undoes.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { deflateSync } from "node:zlib";

const folder = dirname(fileURLToPath(import.meta.url));
const importLine = /^import [^;]* from "(\.\.?\/.*)";\n/gm;

/** The text of a module and of what it imports, each once, what is needed first. */
function joined(name, done = new Set()) {
  if (done.has(name)) return "";
  done.add(name);
  const text = readFileSync(join(folder, name), "utf8");
  const before = [...text.matchAll(importLine)].map((match) => joined(join(dirname(name), match[1]), done)).join("");
  const own = text
    .replace(importLine, "")
    .replace(/^export (?=(async )?(function|const|let|class) )/gm, "");
  if (/^(import|export) /m.test(own))
    throw new Error(`${name}: an import or export that is not understood`);
  return `${before}// ---- ${name}\n${own}\n`;
}

/** Rows of the tables of the glossary, for the page to link its terms to. */
const glossary = readFileSync(join(folder, "../../docs/reference/glossary.md"), "utf8")
  .split("\n")
  .filter((line) => line.startsWith("| ") && !line.startsWith("| term "))
  .map((line) => line.split("|").slice(1, 4).map((cell) => cell.trim().replace(/\[([^\]]*)\]\([^)]*\)/g, "$1").replace(/[*`]/g, "")))
  .map(([term, meaning, source]) => ({ term, meaning, source }));

const [plotly, out] = process.argv.slice(2);
const script = joined("main.js");
if (/<\/script|<!--/i.test(script)) throw new Error("the script would end its own element");
// Says where a name is used twice, now and not in somebody's browser.
execFileSync(process.execPath, ["--check", "--input-type=module", "-"], { input: script });
const parts = {
  "@STYLE@": ["page.css", "studio/studio.css"]
    .map((name) => readFileSync(join(folder, name), "utf8"))
    .join(""),
  "@SCRIPT@": script,
  "@GLOSSARY@": JSON.stringify(glossary).replaceAll("<", "\\u003c"),
  "@PLOTLY@": deflateSync(readFileSync(plotly), { level: 9 }).toString("base64"),
};
let page = readFileSync(join(folder, "page.html"), "utf8");
for (const [placeholder, text] of Object.entries(parts)) page = page.replace(placeholder, () => text);
writeFileSync(out, page);
