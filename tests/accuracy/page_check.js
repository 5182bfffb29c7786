// Runs in the lab's page after its own script: uses every control and writes what it found into the document's title.
(function () {
  const problems = [];
  const expect = (condition, text) => { if (!condition) problems.push(text); };
  const get = (id) => document.getElementById(id);
  const inked = (canvas) => {
    const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    let inks = 0;
    for (let i = 3; i < pixels.length; i += 4) inks += pixels[i] > 0;
    return inks;
  };
  const choose = (select, index) => { select.value = index; select.dispatchEvent(new Event('change')); };
  const press = (box) => box.click();
  try {
    const canvases = document.querySelectorAll('canvas');
    expect(canvases.length > 8, `${canvases.length} charts`);
    canvases.forEach((c, i) => expect(inked(c) > 500, `chart ${i} is empty`));
    expect(document.querySelectorAll('.card .says').length === canvases.length - 1, 'a sentence a knob');
    expect(document.querySelectorAll('#front tbody tr').length > 0, 'no row of the front');
    const all = Chart.getChart(get('all'));
    const before = JSON.stringify(all.data.datasets[1].data.map((p) => p.y));
    choose(get('metric'), 1);
    expect(before !== JSON.stringify(all.data.datasets[1].data.map((p) => p.y)), 'the error does not change');
    expect(all.options.scales.y.title.text.includes('PSNR'), 'the axis keeps its name');
    choose(get('time'), 1);
    expect(all.options.scales.x.title.text.includes('ms'), 'the time does not change');
    press(get('logarithmic'));
    expect(all.options.scales.y.type === 'logarithmic', 'no logarithmic axis');
    press(get('logarithmic-time'));
    expect(all.options.scales.x.type === 'linear', 'the time stays logarithmic');
    choose(get('metric'), 0);
    const test = get('test'), source = test.src;
    expect(source.startsWith('data:image/jpeg;base64,'), 'no picture');
    expect(test.complete && test.naturalWidth > 0, 'the picture does not load');
    choose(get('case'), Array.from(get('case').options).findIndex((o) => o.text.includes('resolution')));
    expect(test.src !== source, 'the setting does not change');
    const picture = test.src;
    press(get('map'));
    expect(test.src !== picture, 'no error map');
    const slider = get('slider');
    slider.value = 25;
    slider.dispatchEvent(new Event('input'));
    expect(getComputedStyle(get('reference-half')).clipPath.includes('75%'), 'the slider moves nothing');
    expect(!document.documentElement.outerHTML.match(/(src|href)="https?:/), 'the page asks the network');
    expect(document.documentElement.scrollWidth <= window.innerWidth, 'wider than the window');
  } catch (error) {
    problems.push(String(error));
  }
  document.title = problems.length === 0 ? 'all controls work' : 'problems: ' + problems.join('; ');
})();
