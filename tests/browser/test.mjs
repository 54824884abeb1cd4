// Opens the pages that `simrun report` writes in a browser, through file://, and asks of each what its readers will do with it.
// `node test.mjs REPORTS SHOTS`: REPORTS holds pages, NAME.html, to which comes fixture.html, whose drives are made up; pictures of what
// was seen go to SHOTS. SIMRUN is the program that drives episodes of the pages again.

import assert from "node:assert/strict";
import { execSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";
import { episodes, fixture } from "./fixture.mjs";

const [reports, shots] = [resolve(process.argv[2] ?? "reports"), resolve(process.argv[3] ?? "shots")];
mkdirSync(shots, { recursive: true });
const WIDE = { viewport: { width: 1600, height: 1000 } };
const NARROW = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true };

const browser = await chromium.launch({
  executablePath: process.env.SIMRUN_CHROMIUM ?? "/usr/bin/chromium",
  args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});

/** Opens a page, does something with it, and asserts that nothing was complained of or asked of the network. */
async function visit(file, { fragment = "", ...options }, act) {
  const context = await browser.newContext({ reducedMotion: "reduce", ...options });
  const page = await context.newPage();
  const complaints = [];
  page.on("console", (message) => {
    // Chromium minds that the tests read pixels back; the page reads none.
    if (["error", "warning"].includes(message.type()) && !message.text().includes("willReadFrequently")) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(error.stack));
  const address = pathToFileURL(file).href;
  page.on("request", (request) => { if (request.url().split("#")[0] !== address) complaints.push(`asked for ${request.url().slice(0, 200)}`); });
  await page.goto(address + fragment);
  await page.waitForSelector("#replay canvas");
  await settled(page);
  await act(page);
  assert.deepEqual(complaints, [], `${file}${fragment}`);
  await context.close();
}

/** Two frames later all that was asked for has been drawn. */
const settled = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
const time = (page) => page.evaluate(() => Number(document.getElementById("replay").dataset.time));
const shown = (page) => page.evaluate(() => document.querySelector(".replay-episode").value);
const hash = (page) => page.evaluate(() => decodeURIComponent(location.hash));
const press = async (page, key) => { await page.keyboard.press(key); await settled(page); };
const close = (found, expected, most, what) => assert.ok(Math.abs(found - expected) <= most, `${what}: ${found}, expected ${expected}`);
const turn = (a, b) => Math.atan2(Math.sin(a - b), Math.cos(a - b));
const focusCanvas = (page) => page.evaluate(() => document.querySelector("#replay canvas").focus());
const entriesOf = (page) => page.evaluate(() => JSON.parse(document.getElementById("episodes").textContent).filter(({ data }) => data).map(({ data, ...entry }) => entry));

/** Every pose of an episode as the page shows it. */
const poses = (page, id, count) => page.evaluate(async ([one, ticks]) => {
  const all = [];
  for (let tick = 0; tick < ticks; tick++) all.push(await SimrunReplay.frame(one, tick));
  return all;
}, [id, count]);

function comparePoses(found, truth, what) {
  found.forEach(({ x_m, y_m, heading_rad }, tick) => {
    close(x_m, truth.x[tick], 0.0005 + 1e-9, `${what}, x at tick ${tick}`);
    close(y_m, truth.y[tick], 0.0005 + 1e-9, `${what}, y at tick ${tick}`);
    close(turn(heading_rad, truth.heading[tick]), 0, 0.0005 + 1e-9, `${what}, heading at tick ${tick}`);
  });
}

/** Where the robot truly was, from the trace of the drive that a page's command names. */
function driveAgain(command) {
  const folder = mkdtempSync(join(tmpdir(), "simrun-trace-"));
  const [program, ...words] = command.split(" ");
  assert.equal(program, "simrun", command);
  words[0] = "run";
  execSync([process.env.SIMRUN, ...words, "--trace", "--out", folder].join(" "), { cwd: new URL("../..", import.meta.url), stdio: ["ignore", "ignore", "inherit"] });
  const [file, ...others] = readdirSync(join(folder, "traces")).filter((name) => !name.endsWith(".lidar.csv"));
  assert.deepEqual(others, [], command);
  const [header, ...rows] = readFileSync(join(folder, "traces", file), "utf8").trim().split("\n").filter((line) => !line.startsWith("#")).map((line) => line.split(","));
  rmSync(folder, { recursive: true });
  const column = (name) => rows.map((row) => Number(row[header.indexOf(name)]));
  return { x: column("x_m"), y: column("y_m"), heading: column("theta_rad") };
}

/** Pixels of the first picture: how many colours, and the middle of those in the robot's own colour, CSS pixels. */
const look = (page) => page.evaluate(() => {
  const canvas = document.querySelector(".replay-world canvas");
  const { data, width } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const colour = getComputedStyle(document.getElementById("replay")).getPropertyValue("--replay-robot").trim();
  const [r, g, b] = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  const colours = new Set();
  let [x, y, count, light, painted] = [0, 0, 0, 0, 0];
  for (let i = 0; i < data.length; i += 4) {
    colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    if (data[i + 3] === 255) [light, painted] = [light + data[i] + data[i + 1] + data[i + 2], painted + 3];
    if (data[i] !== r || data[i + 1] !== g || data[i + 2] !== b) continue;
    [x, y, count] = [x + ((i / 4) % width), y + Math.floor(i / 4 / width), count + 1];
  }
  return { colours: colours.size, light: light / painted, x: x / count / devicePixelRatio, y: y / count / devicePixelRatio, count };
});

const steps = [];
const step = (what, does) => steps.push([what, does]);

/** What holds of every report. */
function everyReport(name, file) {
  step(`${name}: at both widths, light and dark, nothing is wider than the screen`, async () => {
    for (const [size, options] of [["1600", WIDE], ["390", NARROW]]) {
      for (const colorScheme of ["light", "dark"]) {
        await visit(file, { ...options, colorScheme }, async (page) => {
          const [wide, inner] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
          assert.ok(wide <= inner, `${wide} px on a screen of ${inner} px`);
          const { colours, light } = await look(page);
          assert.ok(colours > 5, "the picture is blank");
          assert.ok(colorScheme === "dark" ? light < 128 : light > 128, `${colorScheme}: the picture's mean is ${light}`);
          await page.screenshot({ path: join(shots, `${name}-${size}-${colorScheme}.png`), fullPage: true });
        });
      }
    }
  });

  step(`${name}: plays, pauses, scrubs and steps`, () => visit(file, WIDE, async (page) => {
    assert.equal(await time(page), 0, "without being asked nothing plays");
    await page.click(".replay-play");
    await page.waitForFunction(() => Number(document.getElementById("replay").dataset.time) > 0.25);
    await page.click(".replay-play");
    const at = await time(page);
    await page.waitForTimeout(150);
    assert.equal(await time(page), at, "paused");
    await focusCanvas(page);
    await press(page, "Home");
    assert.equal(await time(page), 0);
    await press(page, "ArrowRight");
    const dt = await time(page);
    assert.ok(dt > 0);
    await press(page, "ArrowRight");
    close(await time(page), 2 * dt, 1e-9, "two ticks");
    await press(page, "ArrowLeft");
    close(await time(page), dt, 1e-9, "one back");
    await press(page, "Home");
    await press(page, "Shift+ArrowRight");
    const end = await page.evaluate(() => Number(document.querySelector(".replay-time").value.split("/")[1].replace(" s", "")));
    close(await time(page), Math.min(1, end), dt / 2, "one second");
    await press(page, "End");
    close(await time(page), end, 0.05, "the end");
    await press(page, "ArrowRight");
    close(await time(page), end, 0.05, "nothing after the end");
    await page.fill(".replay-scrub", "3");
    await settled(page);
    close(await time(page), Math.min(3 * dt, end), dt, "scrubbed");
    await focusCanvas(page);
    await press(page, " ");
    await page.waitForFunction(() => document.getElementById("replay").dataset.playing === "true" || Number(document.getElementById("replay").dataset.time) > 0);
  }));

  step(`${name}: keys and gallery choose episodes, and the fragment remembers`, () => visit(file, WIDE, async (page) => {
    const entries = await entriesOf(page);
    const length = await page.evaluate(() => history.length);
    const first = await shown(page);
    assert.equal(first, entries[0].id);
    if (entries.length > 1) {
      await focusCanvas(page);
      await page.keyboard.press("j");
      await page.waitForFunction((id) => document.querySelector(".replay-episode").value === id, entries[1].id);
      assert.ok((await hash(page)).startsWith(`#${entries[1].id}`), await hash(page));
      await page.keyboard.press("ArrowUp");
      await page.waitForFunction((id) => document.querySelector(".replay-episode").value === id, first);
    }
    const link = page.locator("a.episode").last();
    if (await link.count()) {
      const id = decodeURIComponent((await link.getAttribute("href")).slice(1));
      await link.evaluate((element) => element.click());
      await page.waitForFunction((one) => document.querySelector(".replay-episode").value === one, id);
      assert.equal(await page.evaluate(() => document.activeElement === document.querySelector("#replay canvas")), true, "the picture has the focus");
    }
    await focusCanvas(page);
    for (let i = 0; i < 2; i++) await press(page, "ArrowRight");
    const [id, at] = [await shown(page), await time(page)];
    assert.ok((await hash(page)).startsWith(`#${id}&t=`), await hash(page));
    assert.equal(await page.evaluate(() => history.length), length, "no step of the history");
    await page.reload();
    await page.waitForSelector("#replay canvas");
    await settled(page);
    assert.deepEqual([await shown(page), await time(page)], [id, at], "restored by the permalink");
  }));

  step(`${name}: side by side under one clock`, () => visit(file, WIDE, async (page) => {
    const entries = await entriesOf(page);
    const pair = entries.find((entry) => entry.world && entries.some((other) => other.world === entry.world && other.id !== entry.id));
    if (!pair) return;
    await page.selectOption(".replay-episode", pair.id);
    await page.waitForFunction((id) => document.querySelector(".replay-episode").value === id, pair.id);
    await focusCanvas(page);
    await page.keyboard.press("s");
    await page.waitForFunction(() => document.querySelectorAll(".replay-pane").length === 2);
    for (let i = 0; i < 5; i++) await press(page, "Shift+ArrowRight");
    const clocks = await page.locator(".replay-now b").allTextContents();
    const ends = await page.evaluate(() => document.querySelector(".replay-time").value);
    assert.ok(clocks.some((clock) => Math.abs(parseFloat(clock) - parseFloat(ends)) < 0.06), `${clocks} under ${ends}`);
    const fragment = await hash(page);
    assert.ok(fragment.includes("&vs="), fragment);
    await page.screenshot({ path: join(shots, `${name}-side-by-side.png`), fullPage: true });
    await page.reload();
    await page.waitForFunction(() => document.querySelectorAll(".replay-pane").length === 2);
    assert.equal(await hash(page), fragment);
    await page.setViewportSize(NARROW.viewport);
    await settled(page);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "narrow");
  }));

  step(`${name}: zooms, pans, and shows the whole map again`, () => visit(file, WIDE, async (page) => {
    const picture = () => page.evaluate(() => document.querySelector(".replay-world canvas").toDataURL());
    const whole = await picture();
    await page.locator(".replay-world canvas").first().scrollIntoViewIfNeeded();
    const box = await page.locator(".replay-world canvas").first().boundingBox();
    const [x, y] = [box.x + box.width / 3, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.wheel(0, -200);
    await settled(page);
    assert.equal(await picture(), whole, "the wheel scrolls the page until the picture has the focus");
    await focusCanvas(page);
    const at = await page.locator(".replay-world canvas").first().boundingBox();
    await page.mouse.move(at.x + 200, at.y + 100);
    await page.mouse.wheel(0, -200);
    await page.waitForTimeout(50);
    await settled(page);
    const near = await picture();
    assert.notEqual(near, whole, "zoomed");
    await page.mouse.down();
    await page.mouse.move(at.x + 260, at.y + 140, { steps: 3 });
    await page.mouse.up();
    await settled(page);
    assert.notEqual(await picture(), near, "panned");
    await press(page, "f");
    assert.equal(await picture(), whole, "fitted");
    await page.locator(".replay-layers input:visible").first().uncheck();
    await press(page, "End");
    const bare = await picture();
    await page.locator(".replay-layers input:visible").first().check();
    await settled(page);
    assert.notEqual(await picture(), bare, "a layer is seen or not");
  }));

  step(`${name}: prints what is shown, light`, () => visit(file, { ...WIDE, colorScheme: "dark" }, async (page) => {
    await page.emulateMedia({ media: "print", colorScheme: "dark" });
    await settled(page);
    const { colours, light } = await look(page);
    assert.ok(colours > 5 && light > 128, `${colours} colours, mean ${light}`);
    assert.equal(await page.locator(".replay-transport").isVisible(), false);
    await page.screenshot({ path: join(shots, `${name}-print.png`), fullPage: true });
    const pdf = await page.pdf({ printBackground: true });
    writeFileSync(join(shots, `${name}.pdf`), pdf);
    assert.ok(pdf.includes("/Subtype /Image"), "the paper has no picture");
  }));

  step(`${name}: every control has a name, and the focus is seen`, () => visit(file, WIDE, async (page) => {
    const nameless = await page.evaluate(() => [...document.querySelectorAll("#replay button, #replay select, #replay input, #replay canvas")]
      .filter((one) => !(one.getAttribute("aria-label") || one.labels?.[0]?.textContent || one.textContent).trim()).map((one) => one.outerHTML));
    assert.deepEqual(nameless, []);
    await page.focus(".replay-play");
    await page.keyboard.press("Tab");
    const outline = await page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);
    assert.notEqual(outline, "none");
  }));

  step(`${name}: the poses are those of the traces`, () => visit(file, WIDE, async (page) => {
    const made = name === "fixture" && Object.fromEntries(episodes().map(({ entry, truth }) => [entry.id, truth]));
    const outcomes = new Map();
    let compared = 0;
    for (const entry of await entriesOf(page)) {
      // Two of each outcome are driven again, by the page's own command.
      outcomes.set(entry.outcome, (outcomes.get(entry.outcome) ?? 0) + 1);
      if (!made && outcomes.get(entry.outcome) > 2) continue;
      const truth = made ? made[entry.id] : driveAgain(entry.command);
      comparePoses(await poses(page, entry.id, truth.x.length), truth, entry.id);
      compared += 1;
    }
    console.log(`    ${compared} drives compared`);
    assert.ok(compared > 0, "no drive to compare with");
  }));
}

const made = join(reports, "fixture.html");
mkdirSync(reports, { recursive: true });
writeFileSync(made, fixture());
for (const file of readdirSync(reports).sort()) if (file.endsWith(".html")) everyReport(file.slice(0, -5), join(reports, file));

step("fixture: the robot is drawn where it was", () => visit(made, WIDE, async (page) => {
  const { truth } = episodes()[0];
  for (const box of await page.locator(".replay-layers input:visible").all()) await box.uncheck();
  // The middle of the footprint is 0.05 m before its origin; the goal and start are no part of it, being black.
  const places = [];
  for (const tick of [60, 140, 260]) {
    await page.fill(".replay-scrub", String(tick));
    await settled(page);
    const { x, y, count } = await look(page);
    assert.ok(count > 100, "the robot is not seen");
    places.push({ px: x, py: y, x: truth.x[tick] + 0.05 * Math.cos(truth.heading[tick]), y: truth.y[tick] + 0.05 * Math.sin(truth.heading[tick]) });
  }
  const [a, b, c] = places;
  const scale = Math.hypot(c.px - a.px, c.py - a.py) / Math.hypot(c.x - a.x, c.y - a.y);
  for (const [one, other] of [[a, b], [a, c]]) {
    close(other.px - one.px, scale * (other.x - one.x), 2, "to the right");
    close(other.py - one.py, -scale * (other.y - one.y), 2, "upwards");
  }
}));

step("fixture: a click into the strips goes to that time", () => visit(made, WIDE, async (page) => {
  const box = await page.locator(".replay-strips canvas").boundingBox();
  await page.mouse.click(box.x + 44 + (box.width - 56) / 3, box.y + 60);
  await settled(page);
  close(await time(page), 10, 0.11, "a third of 30 s");
  assert.match(await hash(page), /&t=(9\.9|10|10\.1)$/);
}));

step("fixture: a drive that a contact cut short ends at its moment", () => visit(made, { ...WIDE, fragment: "#p0-e0-theta_star+dwa&t=99" }, async (page) => {
  assert.equal(await time(page), 21.96);
}));

step("fixture: an unknown fragment shows the first drive, a changed one another", () => visit(made, { ...WIDE, fragment: "#nothing" }, async (page) => {
  assert.equal(await shown(page), "p0-e0-a_star+dwa");
  await page.evaluate(() => { location.hash = "#p0-e1-a_star%2Bdwa&t=12.3"; });
  await page.waitForFunction(() => document.querySelector(".replay-episode").value === "p0-e1-a_star+dwa");
  await settled(page);
  assert.equal(await time(page), 12.3);
}));

step("fixture: the command is copied", () => visit(made, WIDE, async (page) => {
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await page.click(".replay-command button");
  await page.waitForFunction(() => document.querySelector(".replay-command button").textContent === "Copied");
  assert.match(await page.evaluate(() => navigator.clipboard.readText()), /^simrun run scenarios\/hall\.yaml/);
}));

step("fixture: a chosen drive plays by itself unless less motion is wished for", async () => {
  for (const [reducedMotion, playing] of [["reduce", "false"], ["no-preference", "true"]]) {
    await visit(made, { ...WIDE, reducedMotion }, async (page) => {
      await page.locator("a.episode").nth(2).click();
      await page.waitForFunction(() => document.querySelector(".replay-episode").value === "p0-e1-a_star+dwa");
      await settled(page);
      assert.equal(await page.evaluate(() => document.getElementById("replay").dataset.playing), playing, reducedMotion);
    });
  }
});

step("fixture: a drive that cannot be read is said, and the others go on", async () => {
  const torn = join(shots, "torn.html");
  writeFileSync(torn, readFileSync(made, "utf8").replace(/("id":"p0-e0-a_star\+dwa".*?"data":")[^"]{40}/, "$1"));
  const page = await browser.newPage();
  await page.goto(pathToFileURL(torn).href);
  await page.waitForSelector(".replay-unable:visible");
  assert.match(await page.locator(".replay-unable").textContent(), /^p0-e0-a_star\+dwa could not be read/);
  await page.click(".replay-choice .replay-step");
  await page.waitForSelector("#replay canvas");
  assert.equal(await page.locator(".replay-unable").isVisible(), false);
  await page.close();
});

step("fixture: a browser that cannot unpack says so", async () => {
  const page = await browser.newPage();
  await page.addInitScript(() => { delete window.DecompressionStream; });
  await page.goto(pathToFileURL(made).href);
  assert.match(await page.locator(".replay-unable").textContent(), /DecompressionStream/);
  await page.close();
});

let failed = 0;
for (const [what, does] of steps) {
  try {
    await does();
    console.log(`ok      ${what}`);
  } catch (error) {
    failed += 1;
    console.log(`FAILED  ${what}\n${error.stack}`);
  }
}
await browser.close();
console.log(failed ? `${failed} of ${steps.length} failed` : `all ${steps.length} pass; pictures in ${shots}`);
process.exit(failed ? 1 : 0);
