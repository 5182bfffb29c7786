// Runs in the report's page after its own script: uses every control and writes what it found into the document's title.
(async function () {
  const problems = [];
  const expect = (condition, text) => { if (!condition) problems.push(text); };
  const get = (id) => document.getElementById(id);
  const inks = (canvas) => {
    const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    let count = 0;
    for (let i = 3; i < pixels.length; i += 4) count += pixels[i] > 0;
    return count;
  };
  const hash = (canvas) => canvas.toDataURL().length + canvas.toDataURL().slice(-400);
  const choose = (select, value) => { select.value = value; select.dispatchEvent(new Event('change')); };
  try {
    for (const id of ['time', 'passes', 'pixels', 'work', 'plan', 'map', 'scale-bar'])
      expect(inks(get(id)) > 300, `${id} is empty`);
    expect(document.querySelectorAll('#runs tbody tr').length === 5, 'a row a run: bench 2, budget, compare 2');
    expect(document.querySelectorAll('.limit').length > 5, 'no limits');
    expect(document.querySelectorAll('.limit.missed').length === 1, 'one limit is missed');
    const before = hash(get('map'));
    get('map').dispatchEvent(new MouseEvent('mousemove', {clientX: get('map').getBoundingClientRect().left + 300,
      clientY: get('map').getBoundingClientRect().top + 200}));
    expect(/^Frame \d+: [\d.]+ ms; .+; at \(/.test(get('readout').textContent), 'no readout: ' + get('readout').textContent);
    expect(before !== hash(get('map')), 'the map does not show the place');
    const budget = Array.from(get('run').options).find((o) => o.textContent.startsWith('budget')).value;
    const time = hash(get('time'));
    choose(get('run'), budget);
    expect(time !== hash(get('time')), 'the run does not change');
    expect(document.querySelectorAll('#worst figure').length > 0, 'no slow frames');
    for (const image of document.querySelectorAll('#worst img, #compare img'))
      await image.decode().catch(() => expect(false, `${image.alt} does not load`));
    expect(document.querySelectorAll('#compare img').length === 3, 'no pictures of the comparison');
    expect(document.querySelector('#worst pre').textContent.includes('mode hybrid'), 'no plan');
    document.querySelector('#worst button').click();
    const frame = document.querySelector('#worst button').textContent.match(/\d+/)[0];
    expect(get('readout').textContent.startsWith(`Frame ${frame}:`), 'the slow frame is not pointed at');
    choose(get('beside'), 0);
    expect(Chart.getChart(get('time')).data.datasets.length === 2, 'no run beside');
    expect(!document.documentElement.outerHTML.match(/(src|href)="https?:/), 'the page asks the network');
    expect(document.documentElement.scrollWidth <= window.innerWidth, 'wider than the window');
  } catch (error) {
    problems.push(String(error) + error.stack);
  }
  document.title = problems.length === 0 ? 'all controls work' : 'problems: ' + problems.join('; ');
})();
