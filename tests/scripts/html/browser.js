// Opens a page in Chromium without a network, uses it, and prints what happened as JSON.
// Arguments: path of chromium, path of the page.
const { chromium } = require("playwright-core");

async function use(page) {
  const state = () => page.evaluate(() => ({
    arm: [...document.querySelectorAll(".arm")].map((one) => one.getAttribute("points")),
    marks: [...document.querySelectorAll(".mark")].map((one) => [one.getAttribute("cx"), one.getAttribute("cy")]),
    output: document.querySelector("output")?.textContent,
  }));
  const found = { states: [] };
  if (await page.$(".player")) {
    found.states.push(await state());
    await page.focus(".player input");
    for (let i = 0; i < 8; i++) await page.keyboard.press("ArrowRight");
    found.states.push(await state());
    await page.selectOption(".player select", { index: (await page.$$(".player option")).length - 1 });
    found.states.push(await state());
    await page.click(".player .play");
    await page.waitForFunction(() => document.querySelector(".play").textContent === "Play"
      && Number(document.querySelector(".player input").value) > 8);
    found.states.push(await state());
  }
  const header = await page.$("table.sortable thead th:nth-child(2) button");
  if (header) {
    const column = () => page.evaluate(() => {
      const table = document.querySelector("table.sortable");
      return { sort: table.tHead.rows[0].cells[1].getAttribute("aria-sort"),
        cells: [...table.tBodies[0].rows].map((row) => row.cells[1].textContent) };
    });
    await header.focus();
    await page.keyboard.press("Enter");
    found.up = await column();
    await page.keyboard.press("Space");
    found.down = await column();
  }
  return found;
}

(async () => {
  const [executablePath, file] = process.argv.slice(2);
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
  const results = {};
  for (const [width, colorScheme] of [[1280, "light"], [390, "dark"]]) {
    const context = await browser.newContext({ viewport: { width, height: 800 }, colorScheme, offline: true });
    const page = await context.newPage();
    const complaints = [], requests = [];
    page.on("console", (one) => ["error", "warning"].includes(one.type()) && complaints.push(one.text()));
    page.on("pageerror", (one) => complaints.push(String(one)));
    page.on("request", (one) => requests.push(one.url().slice(0, 5)));
    await page.goto(`file://${file}`);
    const used = await use(page);
    results[width] = { ...used, complaints, requests, ...await page.evaluate(() => ({
      hacked: window.hacked, text: document.body.innerText,
      plots: [...document.querySelectorAll(".plot")].map((one) => one.querySelectorAll(".main-svg").length),
      legend: [...document.querySelectorAll(".legendtext")].map((one) => one.textContent),
      background: getComputedStyle(document.documentElement).backgroundColor,
      onPaper: (() => {
        dispatchEvent(new Event("beforeprint"));
        return [...new Set([...document.querySelectorAll(".legendtext")].map((one) => one.style.fill))];
      })(),
      overflow: document.documentElement.scrollWidth - innerWidth })) };
    await context.close();
  }
  await browser.close();
  console.log(JSON.stringify(results));
})();
