// The picture of the README: what the page of `kinetostat demo` shows first, in one wide row.
// usage: node overview.mjs PAGE PICTURE
import { pathToFileURL } from "node:url";
import { Browser } from "../../tests/browser/browser.mjs";

const [page, picture] = process.argv.slice(2);
const wait = (seconds) => `new Promise((resolve) => setTimeout(resolve, ${1000 * seconds}))`;
const arrange = `(() => {
  const row = document.createElement("div");
  row.style.cssText = "display: grid; grid-template-columns: 1fr 0.8fr 1.1fr; gap: 1.5rem";
  row.append(...["extra-deflection", "skeleton-study", "waterfall"].map((id) => document.getElementById(id)));
  const section = document.querySelector("section.study");
  section.replaceChildren(section.querySelector(".stations"), row);
  document.querySelector("main").replaceChildren(section);
  document.querySelectorAll("footer").forEach((node) => node.remove());
  const style = document.createElement("style");
  style.textContent = ".modebar, .save, figcaption, button, label { display: none !important } .plot { height: 380px !important }";
  document.head.append(style);
  window.dispatchEvent(new Event("resize"));
})()`;

const browser = new Browser();
await browser.open(pathToFileURL(page).href, { width: 1500, height: 1600 });
await browser.evaluate(wait(4));
await browser.evaluate(arrange);
await browser.evaluate(wait(4));
await browser.screenshot(picture, "body");
await browser.close();
