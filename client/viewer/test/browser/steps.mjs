// The steps that a person takes; each goes on where the one before has left the page.
import assert from 'node:assert/strict';
import {writeFile} from 'node:fs/promises';

const live = "isthmus.model.live.connection.value.state === 'live'";
const points = 'isthmus.drawn.value.points > 1000 && isthmus.drawn.value.pending === 0';
const revision = 'isthmus.model.revisions.value[0]?.revision';

async function firstMatch(page) {
  await page.click('Graph');
  await page.until('isthmus.model.matches.value.length > 0');
  await page.value('isthmus.match.set(isthmus.model.matches.value[0])');
}

async function confirm(page, action) {
  await page.type('Why (optional)', 'browser test', 'dialog');
  await page.click(action, 'dialog');
  await page.until("!document.querySelector('dialog')");
}

export const steps = [
  ['an empty map says what to do', async (page, server) => {
    await page.goto(server.url);
    await page.until(live);
    await page.text('No points yet');
    await page.shot('empty');
  }],

  ['robots appear while they drive, and are joined', async (page, server) => {
    await server.run('simulate', '--world', 'museum', '--robots', '2', '--seconds', '45', '--seed', '1',
                     '-o', server.path('sim'));
    const pushed = ['alice', 'bob'].map((robot, i) => server.run(
        'push', '--robot', robot, '--sensor', 'vlp16', server.path(`sim/robot_${i}`)));
    await page.until('isthmus.model.robots.value.some((robot) => robot.tMapSensor)', 180_000);
    await page.shot('driving');
    await Promise.all(pushed);
    await server.run('status', '--wait', 'merged', '--timeout', '240');
    await page.until('isthmus.model.info.value?.components.length === 1', 60_000);
    await page.until('isthmus.model.info.value.components[0].robots.length === 2');
    await page.until(points);
    await page.until('isthmus.trails.paths.value.size === 2');
    await page.shot('merged');
  }],

  ['whoever opens the page soon sees the map', async (page, server) => {
    const began = Date.now();
    await page.goto(server.url);
    await page.until('isthmus.drawn.value.points > 1000');
    console.log(`    the first picture took ${Date.now() - began} ms`);
    await page.until(points);
    await page.until('isthmus.trails.paths.value.size === 2');
    // Sessions are what matches join: a robot may have several.
    await page.until(`/(alice-1 ~ bob-1|bob-1 ~ alice-1) 1?\\d\\d %/.test(
        document.querySelector('.labels').textContent)`);
  }],

  ['every control has a name, and says why it lies still', async (page) => {
    for (const tab of ['Robots', 'Graph', 'History', 'Events', 'Map']) {
      await page.click(tab, '[role=tablist]');
      assert.deepEqual(await page.nameless(), []);
      assert.deepEqual(await page.dead(), []);
    }
  }],

  ['colours', async (page) => {
    for (const by of ['intensity', 'robot', 'time', 'age', 'class', 'height', 'robot']) {
      await page.choose('Colour by', by);
      await page.text(`coloured by ${by}`, 'footer');
    }
    await page.shot('by-robot');
  }],

  ['points: their size, detail and number', async (page) => {
    const end = async (name, key) => {
      await (await page.find(name, '#page-map', 'slider')).focus();
      await page.key(key);
    };
    await end('Size', 'End');
    assert.equal(await page.value('isthmus.view.uniforms.pointPx.value'), 6);
    await end('Size', 'Home');
    await end('At most', 'Home');
    assert.equal(await page.value('isthmus.look.budget'), 500_000);
    // From here on fewer points, as they are drawn without a graphics card.
    const before = await page.value('isthmus.drawn.value.points');
    await end('Detail', 'End');
    await page.until(`isthmus.drawn.value.points < ${before}`);
  }],

  ['what is shown is switched', async (page) => {
    for (const set of ['Robots', 'Trails', 'Submaps', 'Match graph', 'Loop closures', 'Anchors']) {
      await page.click(set, '#page-map');
      await page.click(set, '#page-map');
    }
    await page.key('u');
    await page.until("document.querySelectorAll('.label').length > 4");
    await page.until(`(() => {
      const shown = [...document.querySelectorAll('.label:not([hidden])')]
          .map((label) => label.getBoundingClientRect());
      return shown.length > 0 && shown.every((a, i) => shown.every((b, j) => i >= j ||
          a.right <= b.left + 1 || b.right <= a.left + 1 ||
          a.bottom <= b.top + 1 || b.bottom <= a.top + 1));
    })()`);
    await page.key('u');
  }],

  ['a floor slice', async (page) => {
    await page.click('Only one floor');
    assert.equal(await page.value('isthmus.view.uniforms.clipOn.value'), true);
    await page.click('Floor up');
    await page.key('PageDown');
    await page.click('Only one floor');
    assert.equal(await page.value('isthmus.region.state.value.slice'), false);
  }],

  ['a robot is hidden, and gone to', async (page) => {
    await page.click('Robots', '[role=tablist]');
    await page.click('Show alice');
    assert.deepEqual(await page.value('[...isthmus.hidden.value]'), ['alice']);
    await page.click('Show alice');
    await page.text('finished · alice-1', '#page-robots');
    await page.shot('robots');
    // The view goes to the robot's last submap.
    await page.click('Go to alice');
    const mapped = "isthmus.model.submaps.value.filter((s) => s.session === 'alice-1' && s.tMapSubmap)";
    await page.until(`Math.abs(isthmus.view.controls.target.x -
        ${mapped}.at(-1).tMapSubmap.translation.x) < 0.01`);
    await page.key('f');
  }],

  ['a robot that is localised is in the list and on the map while it is', async (page, server) => {
    await page.click('Robots', '[role=tablist]');
    const asking = server.run('push', '--localise', '--robot', 'guest', '--sensor', 'vlp16', '--rate',
                              '10', '--to', '150', server.path('sim/robot_0'));
    await page.until("isthmus.model.robots.value.some((one) => one.robot === 'guest' && one.tMapSensor)",
                     60_000);
    await page.text('located', '#page-robots');
    await page.until("document.querySelector('.labels').textContent.includes('guest · localised')");
    await page.shot('localised');
    await asking;
    await page.until("!document.querySelector('#page-robots').textContent.includes('guest')");
    assert.equal((await server.run('robots')).includes('guest'), false);
  }],

  ['from above, and back; keys move', async (page) => {
    await page.click('Top');
    await page.until(points);
    await page.shot('top');
    const before = await page.value('isthmus.view.camera.position.x');
    await page.key('d');
    await page.until(`isthmus.view.camera.position.x > ${before}`);
    await page.click('3D');
    await page.key('f');
    await page.until(points);
  }],

  ['measuring', async (page) => {
    await page.click('Top');
    await page.key('f');
    await page.until(points);
    await page.click('Measure');
    assert.deepEqual(await page.dead(), []);
    await page.page.mouse.click(420, 420);
    await page.page.mouse.click(560, 470);
    await page.until("document.querySelector('.tool').innerText.length > 20");
    await page.shot('measure');
    await page.key('Escape');
    await page.until("!document.querySelector('.tool')");
  }],

  ['a box is drawn, clips and is downloaded', async (page) => {
    await page.click('Box');
    assert.deepEqual(await page.dead(), []);
    await page.drag([420, 300], [620, 520]);
    await page.until('isthmus.region.state.value.box !== undefined');
    await page.click('Show only what is in it');
    assert.equal(await page.value('isthmus.view.uniforms.clipOn.value'), true);
    await page.type('Box z from, metres', '-1');
    assert.equal(await page.value('isthmus.region.state.value.box.min.z'), -1);
    await page.click('Download the box');
    await page.text('The download has begun');
    await page.shot('box');
    await page.click('Remove');
    await page.key('Escape');
    await page.click('3D');
  }],

  ['news neither swallow a press nor take the focus', async (page) => {
    await firstMatch(page);
    const reject = await page.find('Reject', '#page-graph');
    await reject.evaluate((element) => element.scrollIntoView({block: 'center'}));
    const box = await reject.boundingBox();
    await page.page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.page.mouse.down();
    await page.value('void isthmus.model.refreshNow()');
    await new Promise((resolve) => setTimeout(resolve, 500));
    await page.page.mouse.up();
    await page.find('Cancel', 'dialog');
    await page.click('Cancel', 'dialog');
    await (await page.find('Reject', '#page-graph')).focus();
    await page.value('isthmus.model.matches.set([...isthmus.model.matches.value])');
    assert.equal(await page.value('document.activeElement.textContent'), 'Reject');
  }],

  ['a match is rejected, laid by hand and withdrawn', async (page) => {
    await firstMatch(page);
    await page.click('Reject', '#page-graph');
    await confirm(page, 'Reject');
    await page.until("isthmus.model.matches.value[0].manualDecision?.kind === 'REJECT'");
    await page.until('isthmus.model.info.value.components.length === 2');
    await page.shot('rejected');
    const other = 1 - await page.value('isthmus.model.component.value');
    const elsewhere = await page.value(
        `isthmus.model.info.value.components.find((c) => c.component === ${other})`);
    await page.until(`document.querySelector('[aria-label="Which map"]').textContent
        .includes('Map ${other} (${elsewhere.referenceSession}): ${elsewhere.robots[0]}')`);
    await page.click('Robots', '[role=tablist]');
    await page.text(`in map ${other}`, '#page-robots');
    await page.click(`Go to ${elsewhere.robots[0]}`);
    await page.until(`isthmus.model.component.value === ${other}`);
    assert.deepEqual(await page.dead(), []);
    // The preview shows what would be accepted, until the person cancels.
    await firstMatch(page);
    await page.click('Accept', '#page-graph .card');
    await page.until('isthmus.laid.layer?.shownPoints > 0');
    await page.shot('preview');
    await page.click('Cancel', 'dialog');
    await page.until('isthmus.laid.layer === undefined && isthmus.match.value === undefined');
    await page.value(`isthmus.match.set(isthmus.model.matches.value[0]);
        isthmus.model.matches.set(isthmus.model.matches.value.map(
            (match) => ({...match, manualDecision: undefined, state: 'AMBIGUOUS'})))`);
    await page.until('isthmus.laid.layer !== undefined');
    await page.key('Escape');
    await page.until('isthmus.laid.layer === undefined');
    await page.value('void isthmus.model.refreshNow()');
    await page.until("isthmus.model.matches.value[0].manualDecision?.kind === 'REJECT'");
    await firstMatch(page);
    await page.click('Lay by hand', '#page-graph .card');
    await page.until("isthmus.tool.value?.name === 'align'");
    await page.drag([560, 420], [600, 440]);
    await page.key('ArrowLeft');
    await page.key('Comma');
    await page.shot('align');
    await page.click('As it was');
    await page.click('Set this');
    await confirm(page, 'Set');
    await page.until("isthmus.model.matches.value[0].manualDecision?.kind === 'SET'");
    await page.until('isthmus.model.info.value.components.length === 1');
    await firstMatch(page);
    await page.click('Withdraw', '#page-graph');
    await confirm(page, 'Withdraw');
    await page.until("isthmus.model.matches.value[0].manualDecision === undefined");
    await page.shot('graph');
  }],

  ['an anchor is put and taken away', async (page) => {
    await page.click('Graph', '[role=tablist]');
    const submap = await page.value(
        "(({session, index}) => session + '/' + index)(isthmus.model.submaps.value[0])");
    await page.choose('Submap', submap);
    await page.click('Place on map');
    await page.drag([520, 400], [560, 400]);
    await page.key('Escape');
    await page.choose('Submap', submap);
    await page.type('Anchor note', 'browser test');
    await page.click('Anchor', '#page-graph .card');
    await page.until('isthmus.model.anchors.value.length === 1');
    await page.click('Remove', '#page-graph .card');
    await page.until('isthmus.model.anchors.value.length === 0');
  }],

  ['the history shows what moved, and a revision is undone', async (page) => {
    await page.click('History', '[role=tablist]');
    await page.until(`${revision} > 0`);
    const undoable = await page.value(
        'isthmus.model.revisions.value.findIndex((one) => one.matches.length > 0)');
    await page.value(`document.querySelectorAll('#page-history .row')[${undoable}].click()`);
    await page.text('farthest', '#page-history');
    await page.shot('history');
    const before = await page.value(revision);
    const undo = await page.page.$('#page-history button.bad');
    if (undo) {
      await undo.click();
      await confirm(page, 'Undo');
      await page.until(`${revision} > ${before} ||
          document.querySelector('.toasts').innerText.includes('accepted')`);
    }
    await page.value("document.querySelectorAll('.toast button').forEach((b) => b.click())");
    await page.click('Changes since');
  }],

  ['the event log is there, and follows', async (page, server) => {
    await page.click('Events', '[role=tablist]');
    await page.text('Match decided', '#page-events');
    await page.choose('Kind', 'SERVER_STARTED');
    await page.shot('events');
    await page.choose('Kind', '');
    await server.run('anchor', 'set', 'alice', '--position', '0', '0', '0', '--sigma-xy', '1');
    await page.text('Anchor set', '#page-events');
  }],

  ['dark and light, help, the folded panel, a small screen', async (page) => {
    await page.click('Dark or light');
    await page.shot('other-theme');
    await page.click('Dark or light');
    await page.click('Help');
    await page.text('Keys and pointer', 'dialog');
    await page.click('Close', 'dialog');
    await page.key('p');
    await page.until("document.querySelector('aside').hidden");
    await page.key('p');
    await page.page.setViewport({width: 600, height: 900, hasTouch: true, isMobile: true});
    await page.until(points);
    await page.shot('tablet');
    await page.page.setViewport({width: 1280, height: 800});
  }],

  ['a server that was started again is found again', async (page, server) => {
    await page.until(live);
    await server.stop();
    await page.text('Connection lost', '.notice');
    await page.shot('lost');
    await server.start();
    await page.click('Try now').catch(() => undefined);
    await page.until(live);
    await page.until(points);
    await page.until("document.querySelector('.notice').hidden");
  }],

  ['a token is asked for, a wrong one refused', async (page, server) => {
    page.expected.push(/status of 401/);
    assert.equal(await page.value(
        "[...document.querySelectorAll('header button')].at(-1).hidden"), true);
    const secret = (await server.run('token', 'create', '--role', 'admin', '--name', 'chief')).trim();
    server.chief = secret;
    await page.page.reload();
    await page.text('asks for a token', 'dialog');
    const asked = await page.value("document.querySelector('dialog').innerText");
    assert.doesNotMatch(asked, /authorization/);
    await page.shot('login');
    await page.type('Token', 'nonsense', 'dialog');
    await page.click('Log in', 'dialog');
    await page.until("document.querySelector('dialog .poor').textContent !== ''");
    await page.type('Token', secret, 'dialog');
    await page.click('Log in', 'dialog');
    await page.until(live);
    await page.until(points);
    await page.click('Events', '[role=tablist]');
    await page.text('Match decided', '#page-events');
    await page.click('Log out');
    await page.text('asks for a token', 'dialog');
    // The next person at this page sees nothing of the map, its robots and its events.
    await page.until("!document.querySelector('#page-robots').textContent.includes('alice')");
    await page.until("!document.querySelector('#page-events [role=log]').textContent.includes('decided')");
    await page.until("document.querySelector('.labels').textContent === ''");
    await page.shot('logged-out');
  }],

  ['a reader is not offered what the server would refuse', async (page, server) => {
    const chief = server.path('chief.token');
    await writeFile(chief, server.chief, {mode: 0o600});
    const reader = (await server.run('--token-file', chief, 'token', 'create', '--role', 'reader',
                                     '--name', 'guest')).trim();
    await page.type('Token', reader, 'dialog');
    await page.click('Log in', 'dialog');
    await page.until(live);
    await page.until("isthmus.model.status.value?.refused.some((one) => one.method === 'DecideMatch')");
    await firstMatch(page);
    for (const name of ['Accept', 'Lay by hand']) {
      const control = await page.find(name, '#page-graph .card');
      assert.equal(await control.evaluate((element) => element.matches(':disabled')), true, name);
    }
    const why = await page.value("document.querySelector('#page-graph .card fieldset').title");
    assert.match(why, /operator.*role is reader/);
    await page.shot('reader');
    await page.click('Measure');
    await page.until("isthmus.tool.value?.name === 'measure'");
    await page.key('Escape');
  }],
];
