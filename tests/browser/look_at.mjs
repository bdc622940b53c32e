// All that every page owes, checked in one look.
import assert from "node:assert/strict";
import { basename } from "node:path";
import { accessibilityFaults } from "./accessibility.mjs";
import { layoutFaults } from "./layout.mjs";

const figures = `Object.fromEntries([...document.querySelectorAll("figure")].map((f) => [f.id, Number(f.dataset.points)]))`;
/** Scrolls down the whole page: a chart is drawn in the frame in which it comes near. */
async function scrollThrough(browser) {
  for (let y = 0; y < (await browser.evaluate("document.documentElement.scrollHeight")); y += 600) {
    await browser.evaluate(`scrollTo(0, ${y})`);
    await browser.frames();
  }
}

/** Opens a page and looks at all of it: points by chart. Every chart must be drawn, and nothing may go wrong. */
export async function lookAt(browser, address, how) {
  const name = `${basename(address)} ${JSON.stringify(how ?? {})}`;
  browser.problems = [];
  await browser.open(address, how);
  await browser.evaluate(`for (const d of document.querySelectorAll("details")) d.open = true`);
  await scrollThrough(browser);
  await browser.until(`[...document.querySelectorAll("figure")].every((f) => f.dataset.points)`);
  const points = await browser.evaluate(figures);
  assert.deepEqual(browser.problems, [], `${name}: errors in the console`);
  const outside = browser.requests.filter((url) => !/^(file|data|blob):/.test(url));
  assert.deepEqual(outside, [], `${name}: asks a network`);
  for (const [id, count] of Object.entries(points))
    assert.ok(count > 0, `${name}: chart ${id} has no points`);
  assert.deepEqual(await accessibilityFaults(browser), [], name);
  assert.deepEqual(await layoutFaults(browser), [], name);
  return points;
}
