// The pictures of docs/tutorial/what-effects-look-like.md: what the spring of one joint does not explain, for each hidden effect.
// usage: node effects.mjs PICTURE TITLE=PAGE ...
import { readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "../../tests/browser/browser.mjs";

const [picture, ...named] = process.argv.slice(2);
const wait = (seconds) => `new Promise((resolve) => setTimeout(resolve, ${1000 * seconds}))`;
const bare = `(() => {
  const style = document.createElement("style");
  style.textContent = ".modebar, .save, figcaption, h3, .say { display: none !important } figure { width: 460px !important }";
  document.head.append(style);
  document.getElementById("extra-deflection").scrollIntoView();
  window.dispatchEvent(new Event("resize"));
})()`;

const browser = new Browser();
const cells = [];
for (const [k, [title, page]] of named.map((pair) => pair.split("=")).entries()) {
  await browser.open(pathToFileURL(page).href, { width: 1000, height: 900 });
  await browser.evaluate(bare);
  await browser.evaluate(wait(2));
  const file = join(tmpdir(), `kinetostat-effect-${k}.png`);
  await browser.screenshot(file, "#extra-deflection .plot");
  cells.push(`<figure><figcaption>${title}</figcaption><img src="data:image/png;base64,${readFileSync(file, "base64")}"></figure>`);
}
const together = join(tmpdir(), "kinetostat-effects.html");
const style = "body { margin: 8px; display: grid; grid-template-columns: repeat(2, 470px); gap: 8px; font: 600 15px system-ui, sans-serif; background: white } figure { margin: 0 } img { width: 460px }";
writeFileSync(together, `<!doctype html><meta charset="utf-8"><style>${style}</style><body id="page" data-ready="yes">${cells.join("")}</body>`);
await browser.open(pathToFileURL(together).href, { width: 980, height: 900 });
await browser.evaluate(wait(1));
await browser.screenshot(picture, "body");
await browser.close();
