// The studio: what it refuses, that it survives malformed requests, and that an effect switched on lowers the error.
//
//   node studio_test.mjs KINETOSTAT
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { existsSync, readFileSync, symlinkSync, unlinkSync, writeFileSync } from "node:fs";
import http from "node:http";
import net from "node:net";
import { accessibilityFaults } from "./accessibility.mjs";
import { Browser, requireParts } from "./browser.mjs";
import { Workshop, slide } from "./workshop.mjs";

const program = process.argv[2];
requireParts(program, "studio");
const shop = new Workshop(program);
const run = (...words) => shop.run(...words);

function writeFiles() {
  shop.write("robot.yaml", slide);
  const rows = ["cycle,step,fz"];
  for (let cycle = 1; cycle <= 4; ++cycle)
    [0, 100, 200, 300, 200, 100, 0, -100, -200, -300, -200, -100, 0].forEach((load, k) =>
      rows.push(`${cycle},${k + 1},${load}`),
    );
  shop.write("plan.csv", rows);
  const simulated = ["simulate", "robot.yaml", "--plan", "plan.csv", "--components", "dz"];
  const noise = ["--noise-translation", "2um"];
  const hidden = ["--effect", "clearance", "--at", "drive", "--size", "50 um"];
  run(...simulated, ...noise, ...hidden, "--out", "campaign");
  run(...simulated, ...noise, "--noise-force", "20 N", "--out", "noisy");
}

/** The running program and the address that it printed. */
function start(campaign) {
  const studio = spawn(program, ["studio", "robot.yaml", `${campaign}/campaign.yaml`, "-q"], {
    cwd: shop.folder,
  });
  return new Promise((resolve, reject) => {
    let text = "";
    studio.on("exit", (code) => reject(new Error(`ended with ${code}: ${text}`)));
    for (const stream of [studio.stdout, studio.stderr])
      stream.on("data", (chunk) => {
        text += chunk;
        const address = text.match(/http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{32}\//);
        if (address) resolve({ studio, address: new URL(address[0]) });
      });
  });
}

function request(address, path, { method = "GET", headers = {}, body } = {}) {
  return new Promise((resolve, reject) => {
    const call = http.request(
      { host: "127.0.0.1", port: address.port, path, method, headers, agent: false },
      (response) => {
        let text = "";
        response
          .on("data", (chunk) => {
            text += chunk;
          })
          .on("end", () => resolve({ status: response.statusCode, text }));
      },
    );
    call.on("error", reject);
    call.end(body);
  });
}

async function refusals(address) {
  const token = address.pathname;
  const ok = await request(address, token);
  assert.equal(ok.status, 200);
  const json = {
    method: "POST",
    body: JSON.stringify({ effects: [] }),
    headers: { "Content-Type": "application/json" },
  };
  const status = async (path, options = {}) => (await request(address, path, options)).status;
  assert.equal(await status(`${token}fit`, json), 200);
  // Without the token, with another one, with a part of it.
  for (const path of [
    "/",
    "/fit",
    `/${"0".repeat(32)}/`,
    token.slice(0, -2),
    `${token.slice(0, 10)}/`,
  ])
    assert.equal(await status(path), 403, path);
  // From another origin, or under another host name.
  assert.equal(
    await status(`${token}fit`, { ...json, headers: { Origin: "http://example.org" } }),
    403,
  );
  assert.equal(
    await status(`${token}fit`, {
      ...json,
      headers: { Origin: `http://127.0.0.1:${Number(address.port) + 1}` },
    }),
    403,
  );
  assert.equal(await status(token, { headers: { Host: "example.org" } }), 403);
  assert.equal(await status(token, { headers: { "Sec-Fetch-Site": "cross-site" } }), 403);
  // Too large.
  assert.equal(
    await status(`${token}fit`, {
      ...json,
      body: JSON.stringify({ effects: ["x".repeat(70000)] }),
    }),
    413,
  );
  // So large that it is not even read: cut off, or answered.
  const huge = { ...json, body: Buffer.alloc(20e6, " ") };
  const answer = await status(`${token}fit`, huge).catch((error) => error.code);
  assert.ok([413, "ECONNRESET", "EPIPE"].includes(answer), `20 MB: ${answer}`);
  assert.equal(
    await status(`${token}fit`, { ...json, headers: { "Transfer-Encoding": "chunked" } }),
    411,
  );
  // Outside the folder, over what is there, and nothing of the disk.
  assert.equal(
    await status(`${token}fit`, {
      ...json,
      body: JSON.stringify({ effects: ["clearance at arm.drive"] }),
    }),
    200,
  );
  for (const file of [
    "../out.yaml",
    "/tmp/out.yaml",
    "a/b.yaml",
    ".hidden.yaml",
    "out.txt",
    "..\\out.yaml",
    "out.yaml\u0000",
    "robot.yaml",
    "",
  ])
    assert.equal(
      await status(`${token}save`, { ...json, body: JSON.stringify({ file }) }),
      422,
      file,
    );
  for (const path of ["robot.yaml", "../robot.yaml", "%2e%2e/robot.yaml", "/etc/passwd"])
    assert.ok([403, 404].includes(await status(token + path)), path);
  // What is no request for a fit.
  for (const body of [
    "",
    "[]",
    "{",
    "null",
    '{"effects": 3}',
    '{"effects": [3]}',
    '{"effects": ["nothing at all"]}',
    '{"effects": ["clearance at arm.drive", "clearance at arm.drive"]}',
  ])
    assert.ok([400, 422].includes(await status(`${token}fit`, { ...json, body })), body);
}

/** However many parts of the page are asked for, the page is sent once. */
async function ranges(address) {
  const whole = await request(address, address.pathname);
  for (const parts of [1, 3, 1000, 2600]) {
    const headers = { Range: `bytes=${Array(parts).fill("0-").join(",")}` };
    const answer = await request(address, address.pathname, { headers });
    // A header that the library cannot take apart is refused.
    assert.ok([200, 206, 400, 416].includes(answer.status), `${parts} parts: ${answer.status}`);
    assert.ok(answer.text.length <= whole.text.length, `${parts} parts: ${answer.text.length}`);
  }
  assert.equal((await request(address, address.pathname)).status, 200, "it no longer answers");
}

/** Whoever may write to the folder may put links there: nothing is written through them. */
async function links(address) {
  const post = async (what, body) =>
    (
      await request(address, `${address.pathname}${what}`, {
        method: "POST",
        body: JSON.stringify(body),
        headers: { "Content-Type": "application/json" },
      })
    ).status;
  const victim = `${shop.folder}/victim`;
  const kept = () => assert.equal(readFileSync(victim, "utf8"), "kept");
  writeFileSync(victim, "kept");
  assert.equal(await post("fit", { effects: ["clearance at arm.drive"] }), 200);
  symlinkSync("victim", `${shop.folder}/linked.yaml`);
  assert.equal(await post("save", { file: "linked.yaml" }), 422);
  symlinkSync("victim", `${shop.folder}/fresh.yaml.trial.yaml`);
  assert.equal(await post("save", { file: "fresh.yaml" }), 200);
  kept();
  unlinkSync(`${shop.folder}/fresh.yaml`);
  symlinkSync("victim", `${shop.folder}/fresh.yaml`);
  assert.equal(await post("save", { file: "fresh.yaml" }), 200);
  kept();
  assert.ok(readFileSync(`${shop.folder}/fresh.yaml`, "utf8").includes("clearance"));
}

/** A thousand requests of noise, of halves of requests, and of requests with something wrong in them. */
async function malformed(address) {
  let state = 1;
  const random = (n) => {
    state = (Math.imul(state, 1103515245) + 12345) >>> 0;
    return (state >>> 8) % n;
  };
  const good = `POST ${address.pathname}fit HTTP/1.1\r\nHost: 127.0.0.1:${address.port}\r\nContent-Length: 14\r\n\r\n{"effects":[]}`;
  const spoiled = (kind) => {
    const bytes = Buffer.from(good);
    if (kind === 0) return Buffer.from(Array.from({ length: 1 + random(300) }, () => random(256)));
    if (kind === 1) return bytes.subarray(0, random(bytes.length));
    if (kind === 2) {
      for (let k = 0; k < 5; ++k) bytes[random(bytes.length)] = random(256);
      return bytes;
    }
    if (kind === 3)
      return Buffer.from(
        good.replace("14", String(["-1", "99999999999999999999", "abc", "0x10"][random(4)])),
      );
    return Buffer.from(
      `GET /${"a/".repeat(random(6000))} HTTP/1.1\r\n${"X: y\r\n".repeat(random(400))}\r\n`,
    );
  };
  const one = (bytes) =>
    new Promise((resolve) => {
      const socket = net.connect(address.port, "127.0.0.1", () => {
        socket.end(bytes);
      });
      socket.setTimeout(20000, () => socket.destroy());
      socket
        .on("data", () => {})
        .on("error", () => {})
        .on("close", resolve);
    });
  for (let k = 0; k < 1000; k += 10)
    await Promise.all(Array.from({ length: 10 }, (_, i) => one(spoiled((k + i) % 5))));
  assert.equal((await request(address, address.pathname)).status, 200, "it no longer answers");
}

/** Readings under a load of which the cell knows little are weighed by what that does to them. */
async function loadCellsHaveNoise() {
  const { studio, address } = await start("noisy");
  try {
    const { status, text } = await request(address, `${address.pathname}fit`, {
      method: "POST",
      body: JSON.stringify({ effects: [] }),
      headers: { "Content-Type": "application/json" },
    });
    assert.equal(status, 200, text);
    const { squared_error, degrees_of_freedom, model } = JSON.parse(text);
    const share = squared_error / degrees_of_freedom;
    assert.ok(share > 0.5 && share < 1.7, `chi-square per degree of freedom ${share}`);
    assert.ok(model.residual.dz.length > 0);
  } finally {
    studio.removeAllListeners("exit");
    studio.kill("SIGKILL");
  }
}

async function inBrowser(address) {
  const browser = new Browser();
  try {
    await browser.open(address.href);
    const error = "document.getElementById('waterfall').figure.spec.numbers().rows.at(-2)";
    const [, before] = await browser.evaluate(error);
    await browser.evaluate(
      `(() => { const k = document.getElementById("studio-kind"); k.value = "clearance"; k.dispatchEvent(new Event("change")); document.getElementById("studio-place").value = "clearance at arm.drive"; document.getElementById("studio-add").click(); })()`,
    );
    await browser.until(
      `document.getElementById("studio-status").textContent.startsWith("Chi-square")`,
    );
    const [name, after] = await browser.evaluate(error);
    assert.equal(name, "with clearance at arm.drive");
    assert.deepEqual(await accessibilityFaults(browser), []);
    assert.ok(after < 0.5 * before && after < 1.3, `the error fell from ${before} to ${after}`);
    await browser.evaluate(
      `(() => { document.getElementById("studio-file").value = "better.yaml"; document.getElementById("studio-save").click(); })()`,
    );
    await browser.until(`document.getElementById("studio-status").textContent.startsWith("Saved")`);
    await browser.evaluate(`document.querySelector("#studio-effects button").click()`);
    await browser.until(
      `document.getElementById("studio-status").textContent.startsWith("No effect")`,
    );
    assert.equal((await browser.evaluate(error))[1], before);
    assert.deepEqual(browser.problems, []);
  } finally {
    await browser.close();
  }
}

writeFiles();
const { studio, address } = await start("campaign");
try {
  await refusals(address);
  await malformed(address);
  await ranges(address);
  await links(address);
  await inBrowser(address);
  await loadCellsHaveNoise();
  assert.ok(
    existsSync(shop.path("better.yaml")) &&
      readFileSync(shop.path("better.yaml"), "utf8").includes("clearance"),
  );
  // The stiffness that was fitted beside it is saved with it.
  assert.match(readFileSync(shop.path("better.yaml"), "utf8"), /fitted:[^]*stiffness: drive[^]*factor:/);
  // What was saved explains the readings, as it is and fitted once more.
  const compared = JSON.parse(run("compare", "better.yaml", "campaign/campaign.yaml", "--json", "-"));
  assert.equal(compared.adequacy, "adequate");
  assert.ok(compared.as_designed.error_over_noise < 1.2, `${compared.as_designed.error_over_noise}`);
  const ended = new Promise((resolve) => {
    studio.removeAllListeners("exit");
    studio.on("exit", resolve);
  });
  studio.kill("SIGINT");
  assert.equal(await ended, 0, "Ctrl-C is its proper end");
} finally {
  studio.kill("SIGKILL");
  shop.remove();
}
