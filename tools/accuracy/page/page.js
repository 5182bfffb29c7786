'use strict';
// Draws the lab's report: data is accuracy.json and, beside it, "cases" and "images" of the worst frames.
const data = JSON.parse(document.getElementById('data').textContent);
const element = (id) => document.getElementById(id);

const metrics = [
  {key: 'flip_mean', name: 'FLIP, mean', digits: 4},
  {key: 'psnr_exact_db_min', name: 'PSNR against exact frames, worst frame, dB', digits: 1, moreIsBetter: true},
  {key: 'psnr_db', name: 'PSNR against 16 samples, dB', digits: 2, moreIsBetter: true},
  {key: 'ssim', name: 'SSIM', digits: 4, moreIsBetter: true},
  {key: 'wrong_pixels_pct', name: 'Pixels that show another primitive, %', digits: 3},
  {key: 'displacement_px', name: 'Displacement, p99 of the worst frame, px', digits: 0},
  {key: 'flicker', name: 'Flicker beyond the reference, levels of 255', digits: 2},
];
const times = [
  {name: 'median, share of exact frames', of: (p) => p.frame_ms_median / p.exact_frame_ms_median, digits: 2},
  {name: 'median, ms', of: (p) => p.frame_ms_median, digits: 2},
  {name: '99th percentile, ms', of: (p) => p.frame_ms_p99, digits: 2},
];
const palette = ['#1d6fb8', '#d1495b', '#2e8b57', '#b8860b', '#7b5ea7', '#00889b', '#c2571a', '#8a8d3a', '#b0457b',
  '#4a6fa5', '#6b8e23', '#a0522d', '#5f9ea0', '#9370db', '#cd853f', '#708090'];
const state = {metric: metrics[0], time: times[0], logarithmic: false, logarithmicTime: true};
const charts = [];

function add(parent, tag, text, className) {
  const child = document.createElement(tag);
  if (text !== undefined) child.textContent = text;
  if (className) child.className = className;
  parent.append(child);
  return child;
}

/** The point that a chart shows for a measured setting. */
function place(point) {
  return {x: state.time.of(point), y: point[state.metric.key], point};
}

function style(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Writes each point's value beside it. */
const valueLabels = {
  id: 'valueLabels',
  afterDatasetsDraw(chart) {
    const context = chart.ctx;
    context.save();
    context.font = '11px system-ui, sans-serif';
    context.fillStyle = style('--soft');
    chart.data.datasets.forEach((set, i) => {
      if (!set.labelled) return;
      chart.getDatasetMeta(i).data.forEach((mark, j) => {
        const text = set.data[j].point.text;
        const right = mark.x > chart.chartArea.right - 60;
        context.textAlign = right ? 'right' : 'left';
        context.fillText(text, mark.x + (right ? -7 : 7), mark.y - 6);
      });
    });
    context.restore();
  },
};

function makeChart(canvas, sets) {
  const chart = new Chart(canvas, {
    type: 'scatter',
    data: {datasets: sets},
    plugins: [valueLabels],
    options: {
      animation: false,
      responsive: true,
      maintainAspectRatio: false,
      layout: {padding: {top: 12, right: 12}},
      scales: {
        x: {title: {display: true, color: style('--soft')}, grid: {color: style('--line')}, ticks: {color: style('--soft')}},
        y: {title: {display: true, color: style('--soft')}, grid: {color: style('--line')}, ticks: {color: style('--soft')}},
      },
      plugins: {
        legend: {display: sets.length > 2, position: 'bottom', labels: {boxWidth: 10, color: style('--ink')}},
        tooltip: {callbacks: {label: (item) => {
          const p = item.raw.point;
          return `${p.label}: ${state.time.of(p).toFixed(state.time.digits)} (${state.time.name}), ` +
            `${p[state.metric.key].toFixed(state.metric.digits)}`;
        }}},
      },
    },
  });
  chart.measured = sets.map((set) => set.points);
  charts.push(chart);
}

function refresh() {
  for (const chart of charts) {
    chart.data.datasets.forEach((set, i) => { set.data = chart.measured[i].map(place); });
    chart.options.scales.x.title.text = state.time.name;
    chart.options.scales.x.type = state.logarithmicTime && chart.canvas.id === 'all' ? 'logarithmic' : 'linear';
    const y = chart.options.scales.y;
    y.title.text = state.metric.name;
    // Where nothing differs, say so by a flat line in the middle instead of magnified rounding.
    const values = chart.measured.flat().map((p) => p[state.metric.key]);
    const low = Math.min(...values), high = Math.max(...values), margin = 0.1 * Math.abs(high);
    const isFlat = high - low < 0.02 * Math.abs(high) || high === low;
    y.suggestedMin = isFlat ? low - margin : undefined;
    y.suggestedMax = isFlat ? high + margin + 1e-6 : undefined;
    y.reverse = Boolean(state.metric.moreIsBetter);
    y.type = state.logarithmic ? 'logarithmic' : 'linear';
    chart.update();
  }
}

const number = (value, digits) => value.toFixed(digits);

function fillTable(table, points, isUsual) {
  table.replaceChildren();
  const head = add(add(table, 'thead'), 'tr');
  const columns = ['setting', 'ms', 'p99', 'exact, ms', 'FLIP', 'PSNR exact, dB', 'PSNR, dB', 'SSIM', 'wrong, %', 'off, px', 'flicker'];
  for (const title of columns) add(head, 'th', title);
  const body = add(table, 'tbody');
  for (const p of points) {
    const row = add(body, 'tr', undefined, isUsual(p) ? 'usual' : '');
    const cells = [p.label, number(p.frame_ms_median, 2), number(p.frame_ms_p99, 2), number(p.exact_frame_ms_median, 2),
      number(p.flip_mean, 4), number(p.psnr_exact_db_min, 1), number(p.psnr_db, 2), number(p.ssim, 4),
      number(p.wrong_pixels_pct, 3), number(p.displacement_px, 0), number(p.flicker, 2)];
    for (const cell of cells) add(row, 'td', cell);
  }
}

function labelPoints() {
  for (const knob of data.knobs)
    for (const p of knob.points) p.label = `${knob.name} ${p.text}`;
  const say = (p) => { p.label = p.text || 'exact'; };
  data.pareto.forEach(say);
  data.pairs.forEach(say);
  say(data.exact);
}

function showHead() {
  const {scene, machine, reference} = data;
  element('about').textContent = `${scene.name}, walk ${scene.walk}, ${reference.width}x${reference.height}, ` +
    `${reference.counted_frames} frames; ${machine.cpu}, ${machine.threads} threads, OpenGL: ${machine.gl_renderer}. ` +
    `Errors are against ${reference.samples_per_pixel} samples a pixel, every one cast and shaded; an exact frame has one, ` +
    `takes ${number(data.exact.frame_ms_median, 1)} ms here and is off by ${number(data.exact.flip_mean, 4)} FLIP itself. ` +
    `Each setting was timed in turn with exact frames.`;
}

function showCharts() {
  const front = {label: 'beaten by none', points: data.pareto, showLine: true, pointRadius: 5, borderWidth: 2,
    borderColor: style('--ink'), backgroundColor: style('--ink'), order: -1, labelled: false};
  const sets = [front];
  data.knobs.forEach((knob, i) => sets.push({label: knob.name, points: knob.points, pointRadius: 4,
    backgroundColor: palette[i % palette.length], borderColor: palette[i % palette.length]}));
  sets.push({label: 'pairs', points: data.pairs, pointRadius: 4, pointStyle: 'rect', backgroundColor: style('--soft')});
  makeChart(element('all'), sets);

  data.knobs.forEach((knob, i) => {
    const card = add(element('knobs'), 'article', undefined, 'card');
    add(card, 'h3', knob.name);
    add(card, 'p', knob.about);
    const box = add(card, 'div', undefined, 'chart');
    const color = palette[i % palette.length];
    makeChart(add(box, 'canvas'), [{label: knob.name, points: knob.points, showLine: true, labelled: true, pointRadius: 4,
      borderWidth: 1.5, borderColor: color, backgroundColor: color}]);
    add(card, 'p', knob.says, 'says');
    const details = add(card, 'details');
    add(details, 'summary', 'Figures');
    const table = add(add(details, 'div', undefined, 'scroll'), 'table');
    fillTable(table, knob.points, (p) => p.value === knob.default);
  });
  fillTable(element('front'), data.pareto, (p) => p.label === 'exact');
}

function showCase() {
  const chosen = data.cases[Number(element('case').value)];
  const map = element('map').checked;
  element('reference').src = data.images[chosen.reference];
  element('test').src = data.images[map ? chosen.map : chosen.test];
  element('right-tag').textContent = map ? 'FLIP: black is equal, white is worst' : 'this setting';
  element('case-about').textContent = `Frame ${chosen.walk_frame}: ${number(chosen.flip, 4)} FLIP.`;
}

function moveDivider() {
  const share = Number(element('slider').value);
  element('reference-half').style.clipPath = `inset(0 ${100 - share}% 0 0)`;
  element('divider').style.left = `${share}%`;
}

function choices(select, names) {
  names.forEach((name, i) => { add(select, 'option', name).value = i; });
}

choices(element('metric'), metrics.map((m) => m.name));
choices(element('time'), times.map((t) => t.name));
choices(element('case'), data.cases.map((c) => c.title));
element('metric').addEventListener('change', (e) => { state.metric = metrics[e.target.value]; refresh(); });
element('time').addEventListener('change', (e) => { state.time = times[e.target.value]; refresh(); });
element('logarithmic').addEventListener('change', (e) => { state.logarithmic = e.target.checked; refresh(); });
element('logarithmic-time').addEventListener('change', (e) => { state.logarithmicTime = e.target.checked; refresh(); });
element('case').addEventListener('change', showCase);
element('map').addEventListener('change', showCase);
element('slider').addEventListener('input', moveDivider);
labelPoints();
showHead();
showCharts();
refresh();
if (data.cases.length > 0) showCase();
moveDivider();
