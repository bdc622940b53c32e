// What a page owes to everybody who looks at it: no writing over other writing, none cut off, nothing wider than the screen.

/** Runs in the page: what is wrong with the charts that are drawn, and with the page itself. */
function faults() {
  const found = [];
  const width = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth > width)
    found.push(`the page is ${document.documentElement.scrollWidth} wide, the screen ${width}`);
  const shown = (node) => {
    const style = getComputedStyle(node);
    return style.visibility !== "hidden" && Number(style.opacity) > 0.05 && style.display !== "none";
  };
  const isInk = (node) => {
    for (let at = node; at && !at.matches("figure"); at = at.parentElement) if (!shown(at)) return false;
    return node.textContent.trim() !== "";
  };
  // Writing that is turned has a box far larger than itself.
  const isLevel = (node) => {
    const matrix = node.getScreenCTM();
    return matrix && (Math.abs(matrix.b) < 0.02 || Math.abs(matrix.a) < 0.02);
  };
  const overlap = (a, b) => {
    const w = Math.min(a.right, b.right) - Math.max(a.left, b.left);
    const h = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
    return w > 0 && h > 0 ? (w * h) / Math.min(a.width * a.height, b.width * b.height) : 0;
  };
  for (const figure of document.querySelectorAll("figure")) {
    const plot = figure.querySelector(".plot");
    if (!plot?.querySelector("svg")) continue;
    const name = figure.id;
    const frame = plot.getBoundingClientRect();
    const texts = [...plot.querySelectorAll("svg text")].filter(
      (node) => !node.closest(".hoverlayer, .modebar, .annotation-text-math-group") && isInk(node) && isLevel(node),
    );
    const boxes = texts.map((node) => ({ words: node.textContent.trim(), box: node.getBoundingClientRect() }));
    for (const { words, box } of boxes)
      if (box.left < frame.left - 2 || box.right > frame.right + 2 || box.top < frame.top - 2 || box.bottom > frame.bottom + 2)
        found.push(`${name}: '${words}' is cut off`);
    boxes.forEach((a, k) => {
      for (const b of boxes.slice(k + 1))
        if (overlap(a.box, b.box) > 0.15) found.push(`${name}: '${a.words}' and '${b.words}' overlap`);
    });
  }
  return found;
}

/** All that is wrong with how the page that is open is laid out, at its width of now. */
export const layoutFaults = (browser) => browser.evaluate(`(${faults})()`);
