"use strict";
// Sorts tables, draws charts with plotly where it is in the page, and moves the arm with its loops.

const dataOf = (figure) => JSON.parse(figure.querySelector("script").textContent);

// Tables: a column is sorted by its numbers if its cells begin with numbers, else by its texts.
const numberOf = (cell) => {
  const found = cell.textContent.trim().replace("−", "-").match(/^[-+]?\d[\d,]*\.?\d*(e[-+]?\d+)?/i);
  return found ? Number(found[0].replaceAll(",", "")) : NaN;
};

function sortBy(table, column, header) {
  const down = header.getAttribute("aria-sort") === "ascending";
  for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
  header.setAttribute("aria-sort", down ? "descending" : "ascending");
  const rows = [...table.tBodies[0].rows];
  const cell = (row) => row.cells[column];
  const known = rows.filter((row) => !["", "-"].includes(cell(row).textContent.trim()));
  const numeric = known.every((row) => !Number.isNaN(numberOf(cell(row))));
  const order = numeric
    ? (one, other) => numberOf(cell(one)) - numberOf(cell(other))
    : (one, other) => cell(one).textContent.localeCompare(cell(other).textContent);
  known.sort((one, other) => (down ? -1 : 1) * order(one, other));
  const unknown = rows.filter((row) => !known.includes(row)); // cells without a value stay last
  table.tBodies[0].append(...known, ...unknown);
}

for (const table of document.querySelectorAll("table.sortable")) {
  [...table.tHead.rows[0].cells].forEach((header, column) => {
    header.querySelector("button")?.addEventListener("click", () => sortBy(table, column, header));
  });
}

// Charts: their colors are those of the page, also after a change between light and dark. On paper
// they are dark on white; styles for paper do not hold yet when a browser says that it will print.
const PAPER = { "--ink": "#000", "--soft": "#444", "--line": "#bbb" };

function themed(layout, printing) {
  const style = getComputedStyle(document.documentElement);
  const color = (name) => printing ? PAPER[name] : style.getPropertyValue(name).trim();
  const axis = { gridcolor: color("--line"), zerolinecolor: color("--soft"), linecolor: color("--line"),
    automargin: true };
  const found = { ...layout, font: { color: color("--ink"), family: style.fontFamily, size: 12 },
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
    margin: { l: 56, r: 12, t: 8, b: 44 },
    legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 }, hovermode: "closest",
    hoverlabel: { namelength: -1 } };
  for (const name of Object.keys(layout)) {
    if (/^[xy]axis/.test(name)) found[name] = { ...layout[name], ...axis };
  }
  return found;
}

const charts = typeof Plotly === "undefined" ? [] : [...document.querySelectorAll("figure.chart")].map(
  (figure) => ({ plot: figure.querySelector(".plot"), ...dataOf(figure) }));

for (const { plot, data, layout } of charts) {
  Plotly.newPlot(plot, data, themed(layout, false), { displaylogo: false, responsive: true });
}

const repaint = (printing) => charts.forEach(
  ({ plot, data, layout }) => Plotly.react(plot, data, themed(layout, printing)));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => repaint(false));
addEventListener("beforeprint", () => repaint(true));
addEventListener("afterprint", () => repaint(false));

// The player: one slider moves the arm in both views and a marker on each loop.
function player(figure) {
  const { motions } = dataOf(figure);
  const [select, play, slider, output] =
    ["select", ".play", "input", "output"].map((one) => figure.querySelector(one));
  const views = [...figure.querySelectorAll(".view")];
  const loops = [...figure.querySelectorAll(".loops")];
  let motion = motions[0], started = null;

  function show() {
    const i = Number(slider.value);
    output.textContent = `${motion.time[i].toFixed(2)} s`;
    slider.setAttribute("aria-valuetext", output.textContent);
    views.forEach((view, v) => {
      view.querySelector(".arm").setAttribute("points", motion.arm[v][i]);
      view.querySelector(".intended").setAttribute("points", motion.intended[v][i]);
    });
    loops.forEach((loop, l) => loop.querySelectorAll(".mark").forEach((mark, m) => {
      const [x, y] = motion.loops[l].marks[m][i];
      mark.setAttribute("cx", x);
      mark.setAttribute("cy", y);
    }));
  }

  function choose() {
    motion = motions[Number(select.value)];
    slider.max = motion.time.length - 1;
    views.forEach((view, v) => {
      view.querySelector(".trunk").setAttribute("points", motion.body[v]);
      ["cx", "cy", "r"].forEach((name, i) => view.querySelector(".head").setAttribute(name, motion.head[v][i]));
    });
    loops.forEach((loop, l) => loop.querySelectorAll(".loop").forEach((line, i) =>
      line.setAttribute("points", motion.loops[l].lines[i])));
    show();
  }

  function stop() {
    started = null;
    play.textContent = "Play";
  }

  function step(now) {
    if (started === null) return;
    const time = (now - started.now) / 1000 + started.time;
    const next = motion.time.findIndex((one) => one > time);
    slider.value = next < 0 ? motion.time.length - 1 : Math.max(next - 1, 0);
    show();
    if (next < 0) stop();
    else requestAnimationFrame(step);
  }

  play.addEventListener("click", () => {
    if (started !== null) return stop();
    if (Number(slider.value) >= motion.time.length - 1) slider.value = 0;
    started = { now: performance.now(), time: motion.time[Number(slider.value)] };
    play.textContent = "Pause";
    requestAnimationFrame(step);
  });
  slider.addEventListener("input", () => { stop(); show(); });
  select.addEventListener("change", () => { stop(); choose(); });
}

document.querySelectorAll("figure.player").forEach(player);
