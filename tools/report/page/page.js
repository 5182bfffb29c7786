'use strict';
// Draws the runs: data is {"inputs": [..], "runs": [{"file", "kind", "title", "frames", "pictures", "limits"}]}.
const data = JSON.parse(document.getElementById('data').textContent);
const element = (id) => document.getElementById(id);
const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const palette = ['#1d6fb8', '#d1495b', '#2e8b57', '#b8860b', '#7b5ea7', '#00889b', '#c2571a', '#8a8d3a', '#b0457b',
  '#4a6fa5', '#6b8e23', '#a0522d', '#5f9ea0', '#9370db', '#cd853f', '#708090'];
// As the overlay's legend orders and colours them.
const sourceColors = {near: '#d95f02', sky: '#7fb3e6', panorama: '#66a61e', verified: '#1b9e77', cast_hit: '#7570b3',
  cast_miss: '#c9c4e3'};
const state = {run: 0, beside: -1, cursor: null};
const charts = {};

function add(parent, tag, text, className) {
  const child = document.createElement(tag);
  if (text !== undefined) child.textContent = text;
  if (className) child.className = className;
  parent.append(child);
  return child;
}

const number = (value, digits = 2) => value === null || value === undefined ? 'no bound' : value.toFixed(digits);
const words = (name) => name.replaceAll('_', ' ');
const finite = (values) => values.filter((v) => v !== null);
const mean = (values) => values.length ? values.reduce((a, b) => a + b, 0) / values.length : 0;
function quantile(values, share) {
  const sorted = finite(values).sort((a, b) => a - b);
  return sorted[Math.max(0, Math.ceil(share * sorted.length) - 1)];
}
const warmUp = 4;  // frames of a lap that do not count
const steady = (values) => values.length > warmUp ? values.slice(warmUp) : values;
const nameOf = (run) => `${run.title}, ${run.file}`;

function showHead() {
  for (const input of data.inputs) {
    const parts = [input.file];
    if (input.scene) parts.push(input.scene.name);
    if (input.recording) parts.push(input.recording);
    if (input.kind === 'replay') parts.push(`${input.game} in ${input.pack.split('/').pop()}`);
    if (input.settings?.walk) parts.push(`walk ${input.settings.walk}`);
    if (input.settings?.width) parts.push(`${input.settings.width}x${input.settings.height}`);
    if (input.settings?.budget_ms) parts.push(`a budget of ${input.settings.budget_ms} ms`);
    if (input.settings?.laps) parts.push(`${input.settings.laps} laps`);
    if (input.machine) parts.push(`${input.machine.cpu}, ${input.machine.threads} threads`);
    add(element('about'), 'p', parts.join(' · '));
  }
}

function showRuns() {
  const table = element('runs');
  const head = add(add(table, 'thead'), 'tr');
  for (const title of ['run', 'frames', 'median, ms', 'p99, ms', 'worst, ms', 'rays a frame', 'allocations a frame', 'limits'])
    add(head, 'th', title);
  const body = add(table, 'tbody');
  for (const run of data.runs) {
    const ms = steady(run.frames.ms), row = add(body, 'tr');
    const missed = run.limits.filter((l) => !l.held).length;
    const cells = [nameOf(run), run.frames.ms.length, number(quantile(ms, 0.5)), number(quantile(ms, 0.99)),
      number(Math.max(...ms)), number(mean(steady(run.frames.work.rays ?? [])), 0),
      number(mean(steady(run.frames.work.allocations ?? [])), 2),
      run.limits.length === 0 ? '–' : missed === 0 ? `${run.limits.length} held` : `${missed} of ${run.limits.length} missed`];
    for (const cell of cells) add(row, 'td', cell);
  }
}

function showLimits() {
  const runs = data.runs.filter((run) => run.limits.length > 0);
  element('limits-section').hidden = runs.length === 0;
  for (const run of runs) {
    const panel = add(element('limits'), 'div', undefined, 'panel');
    const scale = run.calibration ? `; times allowed are ${number(run.calibration.scale, 3)} of the file's, by calibration` : '';
    add(panel, 'h3', nameOf(run) + scale);
    for (const limit of run.limits) {
      const row = add(panel, 'div', undefined, limit.held ? 'limit' : 'limit missed');
      add(row, 'span', limit.name);
      const track = add(row, 'div', undefined, 'track');
      const widest = 1.25, share = limit.allowed > 0 ? limit.measured / limit.allowed : limit.measured > 0 ? widest : 0;
      add(track, 'div', undefined, 'fill').style.width = `${100 * Math.min(share, widest) / widest}%`;
      add(track, 'div', undefined, 'mark').style.left = `${100 / widest}%`;
      const digits = limit.unit === 'ms' ? 3 : 0;
      add(row, 'span', `${number(limit.measured, digits)} of ${number(limit.allowed, digits)}` +
        `${limit.unit === 'ms' ? ' ms' : ''}${limit.held ? '' : `, missed, frame ${limit.worst_frame}`}`);
    }
  }
  element('limits-about').textContent = 'A bar that passes the mark is a limit missed.';
}

/** A vertical line in every chart at the frame that is pointed at. */
const cursorLine = {
  id: 'cursorLine',
  afterDatasetsDraw(chart) {
    if (state.cursor === null) return;
    const x = chart.scales.x.getPixelForValue(state.cursor), {top, bottom, left, right} = chart.chartArea;
    if (x < left || x > right) return;
    chart.ctx.save();
    chart.ctx.strokeStyle = style('--soft');
    chart.ctx.beginPath();
    chart.ctx.moveTo(x, top);
    chart.ctx.lineTo(x, bottom);
    chart.ctx.stroke();
    chart.ctx.restore();
  },
};

function pointAt(frame) {
  const count = data.runs[state.run].frames.ms.length;
  state.cursor = Math.max(0, Math.min(count - 1, Math.round(frame)));
  for (const chart of Object.values(charts)) chart.draw();
  drawPlan();
  drawMap();
  readOut();
}

function readOut() {
  const {frames} = data.runs[state.run], f = state.cursor;
  if (f === null) {
    element('readout').textContent = 'Point at a frame.';
    return;
  }
  const slowest = Object.entries(frames.pass_ms).map(([name, ms]) => [ms[f], name]).sort((a, b) => b[0] - a[0]).slice(0, 4);
  const active = Object.entries(frames.effect_state).filter(([, s]) => s[f] === 2).map(([name]) => words(name));
  element('readout').textContent = `Frame ${f}: ${number(frames.ms[f])} ms; ` +
    slowest.map(([ms, name]) => `${name} ${number(ms)}`).join(', ') +
    `; effects: ${active.join(', ') || 'none'}; at (${frames.position_m[f].map((v) => number(v, 1)).join(', ')}) m`;
}

function makeChart(id, sets, {stacked = false, most, fromZero = true} = {}) {
  charts[id]?.destroy();
  charts[id] = new Chart(element(id), {
    type: 'line',
    data: {datasets: sets},
    plugins: [cursorLine],
    options: {
      animation: false, responsive: true, maintainAspectRatio: false, parsing: false, normalized: true,
      interaction: {mode: 'nearest', axis: 'x', intersect: false},
      onHover: (event, items, chart) => {
        const x = chart.scales.x.getValueForPixel(event.x);
        if (Math.round(x) !== state.cursor) pointAt(x);
      },
      elements: {point: {radius: 0, hitRadius: 4}, line: {borderWidth: stacked ? 0.5 : 1.4}},
      scales: {
        x: {type: 'linear', min: 0, max: Math.max(data.runs[state.run].frames.ms.length, ...sets.map((s) => s.data.length)) - 1, grid: {display: false},
          ticks: {color: style('--soft'), maxRotation: 0}},
        y: {stacked, max: most, beginAtZero: fromZero, grid: {color: style('--line')}, ticks: {color: style('--soft')},
          afterFit: (axis) => { axis.width = 46; }},
      },
      plugins: {
        legend: {display: sets.length > 1 || id !== 'time', position: 'bottom',
          labels: {boxWidth: 10, boxHeight: 10, color: style('--ink'), font: {size: 11}}},
        tooltip: {filter: (item) => item.parsed.y > 0, itemSort: (a, b) => b.parsed.y - a.parsed.y,
          callbacks: {title: (items) => items.length ? `frame ${items[0].parsed.x}` : ''}},
      },
    },
  });
}

const points = (values) => values.map((y, x) => ({x, y}));

function areas(table, colors) {
  return Object.entries(table).map(([name, values], i) => {
    const color = colors?.[name] ?? palette[i % palette.length];
    return {label: words(name), data: points(values), fill: i === 0 ? 'origin' : '-1', borderColor: color, backgroundColor: color + 'cc'};
  });
}

function drawCharts() {
  const run = data.runs[state.run], {frames} = run;
  const line = (r, color, dash) => ({label: nameOf(r), data: points(r.frames.ms), borderColor: color, backgroundColor: color, borderDash: dash});
  const times = [line(run, style('--accent'))];
  if (state.beside >= 0) times.push(line(data.runs[state.beside], style('--bad'), [4, 3]));
  // The frames of the warm-up may be ten times as long: what does not count shall not flatten what does.
  const top = Math.max(...times.map((set) => Math.max(...finite(steady(set.data.map((p) => p.y))))));
  makeChart('time', times, {most: 1.1 * top});
  makeChart('passes', areas(frames.pass_ms), {stacked: true, most: 1.1 * Math.max(...steady(frames.ms))});
  makeChart('effects', Object.entries(frames.effect_ms).map(([name, values], i) => ({label: words(name), data: points(values),
    borderColor: palette[i], backgroundColor: palette[i]})), {});
  const sources = Object.fromEntries(Object.keys(sourceColors).filter((k) => frames.pixels[k]).map((k) => [k, frames.pixels[k]]));
  const all = frames.ms.map((_, f) => Object.values(sources).reduce((sum, v) => sum + v[f], 0));
  const shares = Object.fromEntries(Object.entries(sources).map(([k, v]) => [k, v.map((n, f) => all[f] ? 100 * n / all[f] : 0)]));
  makeChart('pixels', areas(shares, sourceColors), {stacked: true, most: 100});
  makeChart('work', Object.entries(frames.work).map(([name, values], i) => {
    const most = Math.max(...values);
    return {label: `${words(name)}, most ${most.toLocaleString('en')}`, data: points(values.map((v) => v / most)),
      borderColor: palette[i % palette.length], backgroundColor: palette[i % palette.length]};
  }), {});
}

/** Rows of the plan strip: numbers as bars of their share, effects as bands. */
function planRows({plan, effect_state: effects}) {
  const rows = [];
  const numbers = {resolution: 'resolution', near_m: 'near distance, m', ray_budget: 'ray budget'};
  for (const [key, title] of Object.entries(numbers)) {
    if (!plan[key]) continue;
    const known = finite(plan[key]), most = Math.max(1e-9, ...known);
    const isSame = plan[key].every((v) => v === plan[key][0]);
    const value = plan[key][0] === null ? 'no bound' : Number(plan[key][0].toFixed(3)).toLocaleString('en');
    rows.push({title: isSame ? `${title}: ${value}` : `${title}, to ${Number(most.toFixed(3)).toLocaleString('en')}`,
      values: plan[key].map((v) => v === null ? 1 : v / most), color: '#4a6fa5'});
  }
  for (const [name, states] of Object.entries(effects))
    rows.push({title: words(name), values: states.map(() => 1), states, color: '#2e8b57'});
  return rows;
}

function drawPlan() {
  const canvas = element('plan'), {frames} = data.runs[state.run], rows = planRows(frames);
  const rowHeight = 22, area = charts.time.chartArea, width = canvas.parentElement.clientWidth - 32;
  const ratio = window.devicePixelRatio || 1;
  canvas.width = width * ratio;
  canvas.height = rows.length * rowHeight * ratio;
  canvas.style.height = `${rows.length * rowHeight}px`;
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  context.font = '11px system-ui, sans-serif';
  const count = frames.ms.length, axis = charts.time.scales.x, x = (f) => axis.getPixelForValue(f);
  rows.forEach((row, i) => {
    const top = i * rowHeight + 4, height = rowHeight - 6;
    for (let f = 0; f < count; ++f) {
      const bar = Math.max(1, row.values[f] * height);
      context.globalAlpha = row.states ? [0.05, 0.28, 0.75][row.states[f]] : 0.45;
      context.fillStyle = row.color;
      context.fillRect(x(f), top + height - bar, Math.max(1, x(f + 1) - x(f)) + 0.3, bar);
    }
    context.globalAlpha = 1;
    context.fillStyle = style('--ink');
    context.fillText(row.title, area.left + 6, top + height - 4);
  });
  if (state.cursor === null) return;
  context.strokeStyle = style('--soft');
  context.beginPath();
  context.moveTo(x(state.cursor), 0);
  context.lineTo(x(state.cursor), rows.length * rowHeight);
  context.stroke();
}

/** Blue over yellow to red, for [0, 1]. */
function heat(share) {
  const s = Math.max(0, Math.min(1, share));
  return `hsl(${220 - 220 * s}, 80%, ${52 - 8 * Math.abs(s - 0.5)}%)`;
}

function drawMap() {
  const canvas = element('map'), {frames} = data.runs[state.run], ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  const at = frames.position_m, xs = at.map((p) => p[0]), zs = at.map((p) => p[2]);
  const low = [Math.min(...xs), Math.min(...zs)], high = [Math.max(...xs), Math.max(...zs)];
  const span = Math.max(1, high[0] - low[0]), depth = Math.max(1, high[1] - low[1]);
  const scale = 0.88 * Math.min(width / span, height / depth);
  const place = (p) => [width / 2 + (p[0] - (low[0] + high[0]) / 2) * scale, height / 2 + (p[2] - (low[1] + high[1]) / 2) * scale];
  const slow = quantile(steady(frames.ms), 0.99), fast = quantile(steady(frames.ms), 0.01);
  context.lineWidth = 5;
  context.lineCap = 'round';
  const stands = span + depth < 3;  // on the spot: a fan of directions instead of a way
  for (let f = warmUp; f < at.length; ++f) {
    const [x, y] = place(at[f]);
    context.strokeStyle = context.fillStyle = heat((frames.ms[f] - fast) / Math.max(1e-9, slow - fast));
    context.beginPath();
    if (stands) {
      const yaw = (frames.yaw_deg?.[f] ?? 0) * Math.PI / 180, far = 0.4 * Math.min(width, height);
      context.moveTo(x + 0.3 * far * Math.sin(yaw), y - 0.3 * far * Math.cos(yaw));
      context.lineTo(x + far * Math.sin(yaw), y - far * Math.cos(yaw));
    } else {
      const [x0, y0] = place(at[Math.max(warmUp, f - 1)]);
      context.moveTo(x0, y0);
      context.lineTo(x, y);
    }
    context.stroke();
  }
  element('scale-low').textContent = `${number(fast)} ms`;
  element('scale-high').textContent = `${number(slow)} ms`;
  const bar = element('scale-bar').getContext('2d');
  for (let i = 0; i < 200; ++i) {
    bar.fillStyle = heat(i / 199);
    bar.fillRect(i, 0, 1, 10);
  }
  // A length to read the map by, of one, two or five times a power of ten.
  if (!stands) {
    const wanted = 0.2 * width / scale, power = 10 ** Math.floor(Math.log10(wanted));
    const length = [5, 2, 1].map((n) => n * power).find((n) => n <= wanted);
    context.lineWidth = 2;
    context.strokeStyle = context.fillStyle = style('--soft');
    context.beginPath();
    context.moveTo(14, height - 14);
    context.lineTo(14 + length * scale, height - 14);
    context.stroke();
    context.font = '12px system-ui, sans-serif';
    context.fillText(`${length} m`, 14, height - 20);
  }
  drawMap.place = place;
  if (state.cursor === null) return;
  const [x, y] = place(at[state.cursor]);
  context.fillStyle = style('--ink');
  context.beginPath();
  context.arc(x, y, 6, 0, 2 * Math.PI);
  context.fill();
}

/** The frame whose place on the map is nearest to a point of the canvas. */
function frameAt(mouseX, mouseY) {
  const {frames} = data.runs[state.run];
  let best = 0, least = Infinity;
  frames.position_m.forEach((p, f) => {
    const [x, y] = drawMap.place(p), d = (x - mouseX) ** 2 + (y - mouseY) ** 2;
    if (d < least) { least = d; best = f; }
  });
  return best;
}

function showWorst() {
  const {pictures} = data.runs[state.run], box = element('worst');
  box.replaceChildren();
  element('worst-section').hidden = pictures.length === 0;
  for (const picture of [...pictures].sort((a, b) => b.ms - a.ms)) {
    const figure = add(box, 'figure');
    const image = add(figure, 'img');
    image.src = picture.url;
    image.alt = `Frame ${picture.frame}`;
    const caption = add(figure, 'figcaption');
    add(caption, 'button', `frame ${picture.frame}, ${number(picture.ms)} ms`).onclick = () => {
      pointAt(picture.frame);
      element('frames-title').scrollIntoView({behavior: 'smooth'});
    };
    add(caption, 'pre', picture.plan);
  }
}

function showCompare() {
  const compared = data.inputs.filter((input) => input.kind === 'compare');
  element('compare-section').hidden = compared.length === 0;
  for (const input of compared) {
    const about = document.createElement('p');
    about.textContent = `${input.file}: second over first ${number(input.ratio.median, 3)} in the median, ` +
      `${number(input.ratio.p99, 3)} in the 99th percentile; images ${number(input.image.psnr_db_mean, 1)} dB in the mean, ` +
      `${number(input.image.psnr_db_min, 1)} dB in frame ${input.image.worst_frame}` +
      (input.parted_tick === null ? '.' : `; the sessions part after tick ${input.parted_tick}.`);
    element('compare').before(about);
    for (const [key, title] of [['a', 'first'], ['b', 'second'], ['difference', 'difference']]) {
      const figure = add(element('compare'), 'figure'), image = add(figure, 'img');
      image.src = input.image[key];
      image.alt = title;
      add(figure, 'figcaption', `${title}, frame ${input.image.worst_frame}`);
    }
  }
}

function choose() {
  state.cursor = null;
  drawCharts();
  drawPlan();
  drawMap();
  showWorst();
  readOut();
}

function begin() {
  showHead();
  showRuns();
  showLimits();
  showCompare();
  add(element('beside'), 'option', 'nothing').value = -1;
  data.runs.forEach((run, i) => {
    add(element('run'), 'option', nameOf(run)).value = i;
    add(element('beside'), 'option', nameOf(run)).value = i;
  });
  element('run').onchange = () => { state.run = Number(element('run').value); choose(); };
  element('beside').onchange = () => { state.beside = Number(element('beside').value); choose(); };
  element('map').onmousemove = (event) => pointAt(frameAt(event.offsetX, event.offsetY));
  element('plan').onmousemove = (event) => pointAt(charts.time.scales.x.getValueForPixel(event.offsetX));
  // A comparison's second pack stands beside its first.
  if (data.runs.length === 2 && data.runs[0].kind === 'compare') {
    state.beside = 1;
    element('beside').value = 1;
  }
  choose();
  window.addEventListener('resize', () => { drawPlan(); drawMap(); });
}

begin();
