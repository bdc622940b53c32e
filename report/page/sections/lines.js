// Lines that two texts share, and those that only one has.

/** Lines of two texts: ["-", old], ["+", new], [" ", both], by the longest common subsequence. */
export function lineChanges(before, after) {
  const [a, b] = [before, after].map((text) => text.split("\n"));
  let first = 0;
  while (first < a.length && first < b.length && a[first] === b[first]) first += 1;
  let last = 0;
  while (last < a.length - first && last < b.length - first && a.at(-1 - last) === b.at(-1 - last)) last += 1;
  const [x, y] = [a, b].map((lines) => lines.slice(first, lines.length - last));
  const longest = Array.from({ length: x.length + 1 }, () => new Uint32Array(y.length + 1));
  for (let i = x.length - 1; i >= 0; --i)
    for (let j = y.length - 1; j >= 0; --j)
      longest[i][j] =
        x[i] === y[j] ? longest[i + 1][j + 1] + 1 : Math.max(longest[i + 1][j], longest[i][j + 1]);
  const changed = [];
  for (let i = 0, j = 0; i < x.length || j < y.length; ) {
    if (i < x.length && j < y.length && x[i] === y[j]) changed.push([" ", x[i++], j++]);
    else if (i < x.length && (j >= y.length || longest[i + 1][j] >= longest[i][j + 1])) changed.push(["-", x[i++]]);
    else changed.push(["+", y[j++]]);
  }
  const same = (lines) => lines.map((line) => [" ", line]);
  return [
    ...same(a.slice(0, first)),
    ...changed.map(([sign, line]) => [sign, line]),
    ...same(a.slice(a.length - last)),
  ];
}

/** What changed with two lines around it, as diff shows it. */
export function shownChanges(changes, around = 2) {
  const near = changes.map((_, k) =>
    changes.slice(Math.max(0, k - around), k + around + 1).some(([sign]) => sign !== " "),
  );
  return changes.flatMap(([sign, line], k) =>
    near[k] ? [`${sign} ${line}`] : near[k - 1] ? ["  ..."] : [],
  );
}
