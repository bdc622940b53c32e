// The arithmetic of pages, without a browser.
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { framed } from "../../report/page/look.js";
import { likelihoodProfile } from "../../report/page/profiles.js";
import { magnified } from "../../report/page/skeleton.js";
import {
  deviation,
  groups,
  normalQuantile,
  quantile,
  rms,
  rmsInterval,
  stream,
} from "../../report/page/numbers.js";
import { Readings, columnsFromResult } from "../../report/page/readings.js";
import { oddEven } from "../../report/page/odd_even.js";
import { firstTerm } from "../../report/page/glossary.js";
import { lineChanges, shownChanges } from "../../report/page/sections/lines.js";
import { asChosen, chooseUnits, number, quantity, sentenceAsChosen, statedWithError, unitFor } from "../../report/page/units.js";
import { worthInWords } from "../../report/page/studio/cards.js";
import { effectsAt, otherPlaces, sliderRange } from "../../report/page/studio/effects_panel.js";
import { largestMove, screenAxes } from "../../report/page/studio/robot_view.js";
import { stagesOfReadings } from "../../report/page/waterfall.js";
import { roundFactor } from "../../report/page/workspace.js";

const near = (a, b, tolerance) => assert.ok(Math.abs(a - b) <= tolerance, `${a} is not ${b}`);

// Sentences in the units that were chosen: what one unit closes goes together, directions and other units stay.
const sentences = {
  "moves 0.162 mm (-0.0601, 0, -0.15) and turns 0.0105 deg": "moves 162 µm (-60.1, 0, -150) and turns 0.0105 deg",
  "along (0.54, 0, 0.84): 1060 N/mm.": "along (0.54, 0, 0.84): 1.06 N/µm.",
  "1277 to 3540 N/mm at (-60, 5.5, 0) mm": "1.277 to 3.54 N/µm at (-60, 5.5, 0) mm",
  "play 0.0032 ± 0.0001 mm, friction 0.57 ± 0.04 N m": "play 3.2 ± 0.1 µm, friction 0.57 ± 0.04 N m",
  "0.00303 mm ± 11 % (0, -0.00134, -0.00272)": "3.03 µm ± 11 % (0, -1.34, -2.72)",
  "base (8.9 ± 0.7)e-08 rad/(N m); at (1, 2)": "base (8.9 ± 0.7)e-08 rad/(N m); at (1, 2)",
  "Tz2 mm of x_2 N": "Tz2 mm of x_2 N",
};
for (const [text, expected] of Object.entries(sentences)) {
  chooseUnits("");
  assert.equal(sentenceAsChosen(text), text);
  chooseUnits("µm");
  assert.equal(sentenceAsChosen(text), expected);
}
chooseUnits("inch");
assert.equal(sentenceAsChosen("100 lb, 25.4 mm and 44.48 N"), "100 lb, 1 in and 10 lbf");
chooseUnits("");

// Units as people write them.
assert.equal(quantity(13.3e-6, "length"), "13.3 µm");
assert.equal(quantity(0.999e-3, "length"), "0.999 mm");
assert.equal(quantity(-2.5e-3, "angle"), "-2.5 mrad");
assert.equal(quantity(3.54e6, "stiffness"), "3.54 N/µm");
assert.equal(quantity(0, "length"), "0 nm");
assert.equal(statedWithError(13.3e-6, 3.2e-7, "m"), "13.3 ± 0.32 µm");
assert.equal(statedWithError(2, 0.5, ""), "2 ± 0.5");
assert.deepEqual(unitFor("force", 2500), { factor: 1e3, unit: "kN" });
assert.equal(number(1234), "1230");
assert.equal(number(1.2e-7), "1.2e-7");
assert.equal(number(100), "100");
assert.equal(number(null), "-");
assert.equal(roundFactor(734), 500);
assert.equal(roundFactor(0.0021), 0.002);

// Units that were chosen: an inch is 25.4 mm, a pound-force 4.4482216152605 N, both by definition.
chooseUnits("inch");
assert.equal(quantity(0.0254, "length"), "1 in");
assert.equal(quantity(1e-6, "length"), "39.4 µin");
near(unitFor("stiffness", 1e6).factor, 175.12683524647, 1e-9);
assert.deepEqual(asChosen([25.4, null], "mm"), { values: [1, null], unit: "in" });
chooseUnits("µm");
assert.equal(quantity(1.5e-3, "length"), "1500 µm");
assert.equal(quantity(0.8, "length"), "800 mm");
assert.deepEqual(asChosen([953], "N/mm"), { values: [0.953], unit: "N/µm" });
chooseUnits("");
assert.deepEqual(asChosen([953], "N/mm"), { values: [953], unit: "N/mm" });

// Terms as they are written, not parts of words.
const rows = [{ term: "backlash" }, { term: "signature" }];
assert.equal(firstTerm("Signatures of clearances", rows).row.term, "signature");
assert.equal(firstTerm("two clearances", rows).length, "clearances".length);
assert.equal(firstTerm("biased_clearance, unsignatured", rows), null);

// What was taken out and put in, whatever stays beside it.
const changes = lineChanges("a\nb\nc\nd", "a\nx\nc\nd\ne");
assert.deepEqual(changes, [[" ", "a"], ["-", "b"], ["+", "x"], [" ", "c"], [" ", "d"], ["+", "e"]]);
assert.deepEqual(shownChanges(lineChanges("1\n2\n3\n4\n5", "1\n2\n3\n4\n6"), 1), ["  4", "- 5", "+ 6"]);
// Either text follows from the other and the changes.
const letters = stream(7);
for (let k = 0; k < 50; ++k) {
  const [a, b] = [0, 1].map(() => Array.from({ length: 12 }, () => "abc"[Math.floor(3 * letters())]).join("\n"));
  const both = lineChanges(a, b);
  assert.equal(both.filter(([sign]) => sign !== "+").map(([, line]) => line).join("\n"), a);
  assert.equal(both.filter(([sign]) => sign !== "-").map(([, line]) => line).join("\n"), b);
}

// Statistics with known answers.
assert.equal(rms([3, -4]), Math.sqrt(12.5));
near(deviation([1, 2, 3, 4]), Math.sqrt(5 / 3), 1e-15);
assert.equal(quantile([0, 1, 2, 3, 4], 0.5), 2);
assert.equal(quantile([0, 10], 0.95), 9.5);
// Quantiles of the normal distribution (Abramowitz and Stegun, table 26.5).
for (const [p, z] of [
  [0.5, 0],
  [0.975, 1.959963984540054],
  [0.99, 2.326347874040841],
  [0.001, -3.090232306167814],
])
  near(normalQuantile(p), z, 1e-8);
assert.deepEqual(
  [...groups([0, 1, 2, 3], (i) => i % 2)],
  [
    [0, [0, 2]],
    [1, [1, 3]],
  ],
);

// The bootstrap interval holds the true value about as often as it says: 60 campaigns of 20 groups of unit noise.
const random = stream(7);
const normal = () => Math.sqrt(-2 * Math.log(1 - random())) * Math.cos(2 * Math.PI * random());
let held = 0;
for (let k = 0; k < 60; ++k) {
  const [low, high] = rmsInterval(
    Array.from({ length: 20 }, () => Array.from({ length: 8 }, normal)),
  );
  if (low <= 1 && 1 <= high) held += 1;
}
assert.ok(held >= 49 && held <= 60, `the interval holds the truth in ${held} of 60`);
assert.equal(rmsInterval([[1], [2]]), null);

// Residuals of a gap: odd, and the same at every load; of an offset: even.
const load = [-200, -100, 0, 100, 200];
const columns = (residual, cycle = load.map((_, i) => i)) => ({
  id: load.map(String),
  pose: load.map(() => 0),
  session: load.map(() => 0),
  role: load.map((_, i) => (i === 4 ? 2 : 0)),
  masked: load.map(() => 0),
  cycle,
  cycles: [""],
  load: { fz: load },
  measured: { dz: load },
  sigma: { dz: load.map(() => 2) },
  models: [{ name: "as designed", residual: { dz: residual } }],
  poses: [{ label: "", position: [0, 0, 0] }],
});
const gap = new Readings(columns(load.map((f) => 3 * Math.sign(f))));
assert.deepEqual(
  oddEven(gap, "dz", 0, "fz").map(([level, odd, , even]) => [level, odd, even]),
  [
    [100, 3, 0],
    [200, 3, 0],
  ],
);
const offset = new Readings(columns(load.map(() => 5)));
assert.deepEqual(
  oddEven(offset, "dz", 0, "fz").map(([level, odd, , even]) => [level, odd, even]),
  [
    [100, 0, 5],
    [200, 0, 5],
  ],
);
assert.equal(gap.direction(0), "-fz");
assert.equal(gap.direction(2), "none");
assert.deepEqual(
  new Readings(
    columns(
      load,
      load.map(() => 0),
    ),
  ).branch,
  [0, 2, 2, 1, 1],
); // of one cycle, by its order
// Only what was kept out counts in the falling error, and in units of the noise.
const { stages } = stagesOfReadings(offset);
assert.deepEqual(
  stages.map((s) => [s.name, s.whitened]),
  [
    ["nominal", 2.5],
    ["noise floor", 1],
  ],
);

// From JSON alone: what was not measured is left out, and so are loads that no reading has.
const alone = columnsFromResult({
  noise: "stated",
  components: ["dx", "dz"],
  refitted: null,
  readings: [
    {
      id: "a",
      session: "s",
      role: "fit",
      masked: false,
      measured: [null, 1],
      residual: [null, 0.5],
      whitened: [null, 0.25],
      sigma: [null, 2],
      cycle: "up",
      direction: "unloading",
      configuration: 1,
      load: { force: [0, 0, -5], moment: [0, 0, 0] },
    },
  ],
  configurations: [
    { label: "home", position: [0, 0, 0] },
    { label: "far", position: [1, 0, 0] },
  ],
});
assert.deepEqual(Object.keys(alone.measured), ["dz"]);
assert.equal(alone.sigma.dz[0], 2);
assert.deepEqual(alone.load, { fz: [-5] });
assert.equal(new Readings(alone).poseText(alone.pose[0]), "far");
assert.deepEqual(new Readings(alone).branch, [2]);

// A stiffness is fitted by the logarithm of its factor, and shown as what it is; the parabola is 1 at one standard deviation.
const profile = likelihoodProfile(
  {
    parameter: "drive",
    log_factor: 0.1,
    standard_error_of_log_factor: 0.05,
    designed: 2e6,
    unit: "N/m",
    points: [0.05, 0.1, 0.15].map((value) => ({ value, rise: value === 0.1 ? 0 : 1.2 })),
    interval: [null, 0.2],
    ended: "its range ends",
  },
  1,
  "Source: test.",
);
const [below, best, above] = profile.numbers().rows;
near(best[0], 2 * Math.exp(0.1), 1e-12); // [N/µm]
near(above[0] / below[0], Math.exp(0.1), 1e-12);
for (const [row, parabola] of [
  [below, 1],
  [best, 0],
  [above, 1],
])
  near(row[2], parabola, 1e-9);
assert.ok(profile.say.includes("beyond to 2.44 N/µm") && profile.say.includes("its range ends"));
// An effect's value is shown in the unit that suits it.
const gapProfile = likelihoodProfile(
  {
    parameter: "gap of clearance at x",
    fitted: 2e-6,
    standard_error: 1e-7,
    unit: "m",
    points: [
      { value: 1.9e-6, rise: 1 },
      { value: 2e-6, rise: 0 },
    ],
    interval: [null, null],
    ended: "",
  },
  1,
  "",
);
near(gapProfile.numbers().rows[0][0], 1.9, 1e-12);
assert.equal(gapProfile.numbers().columns[0], "value [µm]");

// What is slender fills its picture, to the same scale along all axes, and nothing of it is cut off.
const rod = framed({}, [{ type: "scatter3d", x: [0, 400], y: [1, 1], z: [-2, 2] }]);
const spans = ["xaxis", "yaxis", "zaxis"].map((name) => rod[name].range[1] - rod[name].range[0]);
assert.ok(rod.xaxis.range[0] < 0 && rod.xaxis.range[1] > 400);
near(rod.aspectratio.x / spans[0], rod.aspectratio.y / spans[1], 1e-12);
near(rod.aspectratio.x / spans[0], rod.aspectratio.z / spans[2], 1e-12);
assert.ok(rod.aspectratio.x <= 1.6);

// A posture is moved away from another by so many times what they differ.
const state = (x) => ({
  chains: [
    {
      points: [
        [0, 0, 0],
        [x, 0, 0],
      ],
      joints: [{ at: [x, 0, 0] }],
    },
  ],
  bodies: [{ position: [x, 0, 0] }],
});
assert.deepEqual(magnified(state(1), state(1.5), 10).chains[0].points[1], [6, 0, 0]);
assert.deepEqual(magnified(state(1), state(1.5), 10).bodies[0].position, [6, 0, 0]);

// The studio: the screen's axes are orthonormal from wherever the robot is seen, up is up.
for (const [azimuth, elevation] of [[0, 0], [-1, 0.35], [2.5, -1.2]]) {
  const { right, up } = screenAxes(azimuth, elevation);
  const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
  near(dot(right, right), 1, 1e-12);
  near(dot(up, up), 1, 1e-12);
  near(dot(right, up), 0, 1e-12);
  assert.ok(up[2] > 0);
}
{
  const state = (x) => ({ bodies: [{ position: [0, 0, x / 2] }], chains: [{ points: [[0, 0, 0], [x, 0, 0]] }] });
  near(largestMove(state(1), state(1.25)), 0.25, 1e-15);
}
// A slider never leaves what is possible, and reaches the value that it starts at.
for (const [parameter, value] of [
  [{ usual: 1e-4, none: 0, lower: 0, upper: 1e-2 }, 5e-5],
  [{ usual: 2, none: 1, lower: 0.1, upper: 10 }, 8],
  [{ usual: 0, none: 0, lower: null, upper: null }, 0],
]) {
  const [from, to] = sliderRange(parameter, value);
  assert.ok(from <= value && value <= to && from < to);
  assert.ok(from >= (parameter.lower ?? -Infinity) && to <= (parameter.upper ?? Infinity));
}
// Every effect is found at some place, whether or not it is a joint of the picture.
{
  const effects = [
    { name: "a", at: "q1", places: ["arm.q1"] },
    { name: "b", at: "all", places: ["arm.q1", "arm.q2"] },
    { name: "c", at: "platform", places: ["arm."], where: "platform" },
    { name: "d", at: "sensor", places: [], where: "sensor" },
  ];
  const joints = new Set(["arm.q1", "arm.q2"]);
  const places = [...joints, ...otherPlaces(effects, joints).keys()];
  assert.deepEqual(
    [...new Set(places.flatMap((place) => effectsAt(effects, place)).map((e) => e.name))].sort(),
    ["a", "b", "c", "d"],
  );
  assert.deepEqual(effectsAt(effects, "arm.q1").map((e) => e.name), ["a", "b"]);
}
assert.match(worthInWords({ nothing: true, probability: 0.9 }), /no better than without/);
assert.match(worthInWords({ nothing: false, probability: 0.3 }), /no better than without/);
assert.match(worthInWords({ nothing: false, probability: 0.9 }), /^better than without: 90 %/);

// A parameter with the name of an import hides it: what is called then is no function.
{
  const folder = new URL("../../report/page/", import.meta.url);
  const names = (text) => text.replace(/\w+\s*:|=[^,]*|\/\*.*?\*\//g, " ").match(/[A-Za-z_$][\w$]*/g) ?? [];
  const modules = readdirSync(folder, { recursive: true }).filter((file) => file.endsWith(".js") && !file.includes("node_modules"));
  assert.ok(modules.length > 40, `${modules.length} modules`);
  for (const file of modules) {
    const text = readFileSync(new URL(file, folder), "utf8");
    const imported = [...text.matchAll(/^import \{([^}]*)\} from/gm)].flatMap((match) => match[1].split(",").map((one) => one.trim().split(" as ").at(-1)));
    for (const [whole, ofFunction, ofArrow] of text.matchAll(/function\s*\w*\s*\(([^()]*)\)|\(([^()]*)\)\s*=>/g))
      for (const name of names(ofFunction ?? ofArrow ?? ""))
        assert.ok(!imported.includes(name), `${file}: a parameter hides the imported '${name}': ${whole}`);
  }
}
