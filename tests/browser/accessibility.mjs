// What every page owes to readers who do not use a mouse, do not see, or see little: in words what is wrong with the page that is
// open, by the rules of WCAG 2.1 (level AA) that a program can check.
import { existsSync, readFileSync } from "node:fs";

/** Runs in the page. */
function faults() {
  const found = [];
  const name = (node) =>
    (
      node.getAttribute("aria-label") ??
      node.labels?.[0]?.textContent ??
      (node.matches("input, select") ? "" : node.textContent)
    ).trim();
  const shown = (node) => node.getClientRects().length > 0;
  const all = (selector) => [...document.querySelectorAll(selector)].filter(shown);
  // Landmarks and language.
  for (const landmark of ["main", "header"])
    if (all(landmark).length !== 1) found.push(`${all(landmark).length} elements <${landmark}>`);
  if (!document.documentElement.lang) found.push("no language is stated");
  if (document.querySelector("a.skip")?.getAttribute("href") !== "#page")
    found.push("no link leads past the head of the page");
  // Headings: one of the first level, and none that skips a level.
  const levels = all("h1, h2, h3, h4").map((h) => Number(h.tagName[1]));
  if (levels.filter((level) => level === 1).length !== 1 || levels[0] !== 1)
    found.push(`headings ${levels.join(" ")}`);
  levels.forEach((level, k) => {
    if (k > 0 && level > levels[k - 1] + 1) found.push(`heading ${k} skips a level: ${levels}`);
  });
  for (const heading of all("h1, h2, h3")) if (!name(heading)) found.push("an empty heading");
  // Names, once each.
  for (const node of all("button, select, input, a, summary, [role=region], [role=toolbar], .plot"))
    if (!name(node)) found.push(`no name: ${node.outerHTML.slice(0, 120)}`);
  for (const node of all(".plot"))
    if (node.getAttribute("role") !== "group") found.push("a chart is nothing to screen readers");
  const ids = [...document.querySelectorAll("[id]")].map((node) => node.id);
  const twice = ids.filter((id, k) => ids.indexOf(id) !== k);
  if (twice.length) found.push(`ids used twice: ${[...new Set(twice)]}`);
  // Everything that scrolls or does something is reached by Tab.
  for (const node of all("button, select, input, summary, .plot, .scroll, pre"))
    if (node.tabIndex < 0 && !node.disabled) found.push(`Tab skips ${node.className || node.tagName}`);
  for (const table of all("table"))
    if (!table.caption || !table.querySelector("th[scope=col]")) found.push("a table has no heads");
  return found;
}

/** Runs in the page: text that stands out less than 4.5 to 1 (3 to 1 where it is large). */
function faint() {
  const numbers = (text) => (text.match(/[\d.]+/g) ?? []).map(Number);
  const luminance = ([r, g, b]) =>
    [r, g, b]
      .map((v) => (v / 255 <= 0.03928 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4))
      .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const ratio = (a, b) => {
    const [high, low] = [luminance(a), luminance(b)].sort((x, y) => y - x);
    return (high + 0.05) / (low + 0.05);
  };
  const behind = (node) => {
    for (let at = node; at; at = at.parentElement) {
      const colour = numbers(getComputedStyle(at).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour;
    }
    return [255, 255, 255];
  };
  const found = new Set();
  const check = (words, colour, ground, large) => {
    if (ratio(colour, ground) < (large ? 3 : 4.5))
      found.add(`${ratio(colour, ground).toFixed(2)}: ${words.slice(0, 60)}`);
  };
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let text = walker.nextNode(); text; text = walker.nextNode()) {
    const node = text.parentElement;
    if (!text.data.trim() || node.closest("script, style, noscript, .skip, svg")) continue;
    if (node.getClientRects().length === 0) continue;
    const style = getComputedStyle(node);
    const large = parseFloat(style.fontSize) >= 24;
    check(text.data.trim(), numbers(style.color), behind(node), large);
  }
  // Of charts: writing on the paper, on bars and on coloured cells; lines and points by which they are read.
  const root = getComputedStyle(document.documentElement);
  const colour = (name) => {
    const hex = root.getPropertyValue(`--${name}`).trim();
    return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
  };
  const grounds = { paper: ["ink", "bad"], ink: ["noise", "panel", "cold", "hot", "warm", "hottest"] };
  for (const [a, others] of Object.entries(grounds))
    for (const b of others) check(`${b} and ${a} in charts`, colour(a), colour(b));
  for (const bar of ["nominal", "fitted", "final", "held"])
    check(`writing on bars: ${bar}`, colour("paper"), colour(bar));
  for (const line of ["noise", "chosen", "good", "accent"])
    check(`line: ${line}`, colour(line), colour("paper"), true);
  return [...found];
}

/** What axe-core finds by its rules for WCAG 2.1, levels A and AA, and its good practice. */
export async function axeFaults(browser) {
  const file = new URL("node_modules/axe-core/axe.min.js", import.meta.url);
  if (!existsSync(file))
    throw new Error("axe-core is not there: 'scripts/install-packages test' fetches it");
  if (!(await browser.evaluate("typeof axe === 'object'")))
    await browser.evaluate(`${readFileSync(file, "utf8")}; true`);
  // Its time grows with the square of the rows, and those behind the first look like them.
  await browser.evaluate(`for (const body of document.querySelectorAll(".save tbody")) while (body.rows.length > 12) body.rows[12].remove()`);
  const rules = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"];
  return browser.evaluate(
    `axe.run(document, { runOnly: ${JSON.stringify(rules)} }).then(({ violations }) => violations.flatMap((v) => v.nodes.map((n) => v.id + ": " + n.html.slice(0, 160) + " " + n.failureSummary.slice(0, 200))))`,
  );
}

/** All that is wrong with the page that is open in this browser, in its colours of now. */
export async function accessibilityFaults(browser) {
  return [
    ...(await browser.evaluate(`(${faults})()`)),
    ...(await browser.evaluate(`(${faint})()`)),
  ];
}
