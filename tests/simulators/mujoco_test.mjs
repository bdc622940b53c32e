// MuJoCo itself loads exported robots: the tool is where it should be, static answer and frequencies are those of
// 'stiffness' and 'modes'. Exit code 77 means that MuJoCo is not installed: scripts/install-packages test.
//
// usage: mujoco_test.mjs PROGRAM
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

let load;
try {
  load = (await import("@mujoco/mujoco")).default;
} catch {
  console.log("MuJoCo is not installed");
  process.exit(77);
}
const program = process.argv[2];
const source = new URL("../..", import.meta.url).pathname;
const folder = mkdtempSync(join(tmpdir(), "kinetostat_mujoco_"));
const mujoco = await load();
let failures = 0;

function expect_near(found, exact, tolerance, what) {
  if (Math.abs(found - exact) <= tolerance) return;
  console.log(`${what}: ${found}, not ${exact}`);
  ++failures;
}

function kinetostat(...options) {
  const file = join(folder, "result.json");
  execFileSync(program, [...options, "-q", "--json", file], { cwd: source, stdio: ["ignore", "ignore", "inherit"] });
  return JSON.parse(readFileSync(file, "utf8"));
}

// Eigenvalues of a symmetric matrix by Jacobi's rotations, ascending.
function eigenvalues(given) {
  const a = given.map((row) => [...row]), n = a.length;
  for (let sweep = 0; sweep < 100; ++sweep)
    for (let p = 0; p < n; ++p)
      for (let q = p + 1; q < n; ++q) {
        if (a[p][q] === 0) continue;
        const half = 0.5 * Math.atan2(2 * a[p][q], a[q][q] - a[p][p]), c = Math.cos(half), s = Math.sin(half);
        for (let k = 0; k < n; ++k) [a[k][p], a[k][q]] = [c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]];
        for (let k = 0; k < n; ++k) [a[p][k], a[q][k]] = [c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]];
      }
  return a.map((row, i) => row[i]).sort((x, y) => x - y);
}

// Rows for all joints, columns for those that follow no other one by a linear equality.
function couplings(model) {
  const n = model.nv, rows = [...Array(n).keys()].map((i) => [...Array(n).keys()].map((j) => (i === j ? 1 : 0)));
  const size = model.eq_data.length / model.neq, followers = [];
  for (let e = 0; e < model.neq; ++e) {
    const follower = model.eq_obj1id[e];
    rows[follower][model.eq_obj2id[e]] = model.eq_data[size * e + 1];
    followers.push(follower);
  }
  return rows.map((row) => row.filter((_, j) => !followers.includes(j)));
}

const product = (a, b) => a.map((row) => b[0].map((_, j) => row.reduce((sum, x, k) => sum + x * b[k][j], 0)));
const transposed = (a) => a[0].map((_, j) => a.map((row) => row[j]));
const rows_of = (flat, n) => [...Array(flat.length / n).keys()].map((i) => flat.slice(n * i, n * (i + 1)));

// What MuJoCo makes of the file at its keyframe, in terms of the joints that follow none.
function loaded(file) {
  const model = mujoco.MjModel.from_xml_string(readFileSync(file, "utf8")), data = new mujoco.MjData(model);
  mujoco.mj_resetDataKeyframe(model, data, 0);
  mujoco.mj_forward(model, data);
  const n = model.nv, mass = new mujoco.DoubleBuffer(n * n);
  mujoco.mj_fullM(model, data, mass);
  const position = new mujoco.DoubleBuffer(3 * n), rotation = new mujoco.DoubleBuffer(3 * n);
  mujoco.mj_jacSite(model, data, position, rotation, 0);
  const view = (buffer) => Array.from(buffer.GetView()), t = couplings(model), free = t[0].length;
  const springs = Array.from(model.jnt_stiffness);
  const k = product(transposed(t), t.map((row, i) => row.map((x) => x * springs[i])));
  return { n: free, tool: Array.from(data.site_xpos), stiffness: k.map((row, i) => row[i]),
    mass: product(product(transposed(t), rows_of(view(mass), n)), t).flat(),
    jacobian: product(rows_of([...view(position), ...view(rotation)], n), t).flat() };
}

// omega^2 of K x = omega^2 M x with a diagonal K: those of the inverse of K^-1/2 M K^-1/2.
function frequencies({ n, stiffness, mass }) {
  const scaled = [...Array(n).keys()].map((i) => [...Array(n).keys()].map((j) =>
    mass[n * i + j] / Math.sqrt(stiffness[i] * stiffness[j])));
  return eigenvalues(scaled).reverse().map((theta) => 1 / (2 * Math.PI * Math.sqrt(theta)));
}

function imported(...options) {
  const robot = join(folder, "robot.yaml");
  kinetostat("import", ...options, "-o", robot);
  return robot;
}

// A slide on a screw, and a joint that turns against the first.
function with_couplings() {
  const robot = join(folder, "coupled.yaml");
  writeFileSync(robot, `kinetostat: 1
name: coupled
units: {length: m, force: N, angle: rad}
links:
  a:
    rigid: {point: [0.3, 0.1, 0.2], rpy: [0.4, -0.5, 0.6]}
    mass: {mass: 5, center: [0.1, 0.05, 0.1], inertia: [0.3, 0, 0, 0.4, 0, 0.5]}
chain_types:
  arm:
    - actuator: {name: q, axis: Rz, stiffness: 3e4}
    - link: a
    - actuator: {name: s, axis: Rx, stiffness: 2e3}
    - coupled: {to: s, axis: Tx, factor: 0.02 m/rad}
    - link: a
    - coupled: {to: q, axis: Ry, factor: -0.5}
    - link: a
manipulator: {chain: arm}
`);
  return robot;
}

function check(name, robot, joints, modes) {
  const exported = join(folder, "robot.xml");
  kinetostat("export", robot, "--joints", joints, "-o", exported);
  const found = loaded(exported), still = kinetostat("stiffness", robot, "--joints", joints);
  still.posture.position.forEach((x, i) => expect_near(found.tool[i], x, 1e-9, `${name}: tool ${i}`));
  const compliance = still.unloaded.compliance.matrix, size = Math.max(...compliance.flat().map(Math.abs));
  for (let i = 0; i < 6; ++i)
    for (let j = 0; j < 6; ++j) {
      let sum = 0;
      for (let k = 0; k < found.n; ++k)
        sum += found.jacobian[found.n * i + k] * found.jacobian[found.n * j + k] / found.stiffness[k];
      expect_near(sum, compliance[i][j], 1e-6 * size, `${name}: compliance ${i} ${j}`);
    }
  const exact = kinetostat("modes", robot, "--joints", joints, "--modes", `${modes}`).modes.map((m) => m.frequency);
  if (exact.length !== modes) throw new Error(`${name}: ${exact.length} modes`);
  exact.forEach((f, k) => expect_near(frequencies(found)[k], f, 1e-6 * f, `${name}: frequency ${k}`));
}

try {
  // The last axis of this arm has no inertia about itself.
  const arm = ["data/urdf/six_axis.urdf", "--tip", "flange", "--joint-stiffness", "1e5,2e5,3e5,4e4,5e4,6e4"];
  check("six axes", imported(...arm),
    "joint_1=0.3,joint_2=-0.5,joint_3=1.2,joint_4=0.4,joint_5=-0.7,joint_6=1.0", 5);
  check("MJCF, there and back", imported("data/urdf/arm.xml", "--tip", "flange", "--joint-stiffness", "1e5,2e5,3e4"),
    "turn=0.4,lift=-0.3,bend=1.1", 3);
  check("joints that follow others", with_couplings(), "q=0.4,s=0.8", 2);
} finally {
  rmSync(folder, { recursive: true });
}
console.log(failures === 0 ? "MuJoCo agrees" : `${failures} disagree`);
process.exit(failures === 0 ? 0 : 1);
