// A folder of its own for a test of pages, and the program run in it.
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const crcTable = Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});
const crc32 = (bytes) =>
  (bytes.reduce((c, byte) => crcTable[(c ^ byte) & 255] ^ (c >>> 8), 0xffffffff) ^ 0xffffffff) >>> 0;

/** A zip archive of texts by name, not compressed (APPNOTE.TXT of PKWARE, 4.3). */
function zip(files) {
  const [bodies, heads] = [[], []];
  let at = 0;
  for (const [name, text] of Object.entries(files)) {
    const [path, content] = [Buffer.from(name), Buffer.from(text)];
    const shared = Buffer.alloc(26);
    shared.writeUInt16LE(20, 0);
    shared.writeUInt32LE(crc32(content), 10);
    shared.writeUInt32LE(content.length, 14);
    shared.writeUInt32LE(content.length, 18);
    shared.writeUInt16LE(path.length, 22);
    const tail = Buffer.alloc(14);
    tail.writeUInt32LE(at, 10);
    heads.push(Buffer.from([0x50, 0x4b, 1, 2, 20, 0]), shared, tail, path);
    const body = Buffer.concat([Buffer.from([0x50, 0x4b, 3, 4]), shared, path, content]);
    bodies.push(body);
    at += body.length;
  }
  const directory = Buffer.concat(heads);
  const end = Buffer.alloc(22);
  end.writeUInt32LE(0x06054b50, 0);
  end.writeUInt16LE(Object.keys(files).length, 8);
  end.writeUInt16LE(Object.keys(files).length, 10);
  end.writeUInt32LE(directory.length, 12);
  end.writeUInt32LE(at, 16);
  return Buffer.concat([...bodies, directory, end]);
}

const escaped = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
const cellOf = (value) =>
  value !== "" && Number.isFinite(Number(value))
    ? `<c><v>${value}</v></c>`
    : `<c t="inlineStr"><is><t>${escaped(value)}</t></is></c>`;

/** A workbook of one sheet with these rows of texts and numbers, as spreadsheets write it (ECMA-376). */
export function xlsx(rows) {
  const head = '<?xml version="1.0" encoding="UTF-8"?>';
  const main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
  const relations = "http://schemas.openxmlformats.org/package/2006/relationships";
  const office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
  const types = "application/vnd.openxmlformats-officedocument.spreadsheetml";
  const part = (name, type) => `<Override PartName="${name}" ContentType="${types}.${type}+xml"/>`;
  const sheet = rows.map((row) => `<row>${row.map(cellOf).join("")}</row>`).join("");
  return zip({
    "[Content_Types].xml": `${head}<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>${part("/xl/workbook.xml", "sheet.main")}${part("/xl/worksheets/sheet1.xml", "worksheet")}</Types>`,
    "_rels/.rels": `${head}<Relationships xmlns="${relations}"><Relationship Id="r1" Type="${office}/officeDocument" Target="xl/workbook.xml"/></Relationships>`,
    "xl/workbook.xml": `${head}<workbook xmlns="${main}" xmlns:r="${office}"><sheets><sheet name="Readings" sheetId="1" r:id="r1"/></sheets></workbook>`,
    "xl/_rels/workbook.xml.rels": `${head}<Relationships xmlns="${relations}"><Relationship Id="r1" Type="${office}/worksheet" Target="worksheets/sheet1.xml"/></Relationships>`,
    "xl/worksheets/sheet1.xml": `${head}<worksheet xmlns="${main}"><sheetData>${sheet}</sheetData></worksheet>`,
  });
}

/** The source tree. */
const root = join(dirname(fileURLToPath(import.meta.url)), "../..");

/** The robot file of one drive that slides. */
export const slide = [
  "kinetostat: 1",
  "name: slide",
  "units: {length: mm, force: N, angle: deg}",
  "chain_types:",
  "  arm:",
  "    - actuator: {name: drive, axis: Tz, stiffness: 1000}",
  "manipulator: {chain: arm}",
  "uncertain:",
  "  - {stiffness: drive}",
];

export class Workshop {
  constructor(program) {
    this.program = program;
    this.folder = mkdtempSync(join(tmpdir(), "kinetostat-pages-"));
  }
  /** A file or folder of the tree, under its own name. */
  link(name) {
    symlinkSync(join(root, name), this.path(name));
  }
  path(name) {
    return join(this.folder, name);
  }
  address(name) {
    return `file://${this.path(name)}`;
  }
  write(name, lines) {
    writeFileSync(this.path(name), `${lines.join("\n")}\n`);
  }
  /** What the program prints; throws with what it complains of. */
  run(...words) {
    return execFileSync(this.program, words, {
      cwd: this.folder,
      env: { ...process.env, XDG_CACHE_HOME: this.path("cache") },
      encoding: "utf8",
      stdio: ["ignore", "pipe", "pipe"],
    });
  }
  remove() {
    rmSync(this.folder, { recursive: true });
  }
}
