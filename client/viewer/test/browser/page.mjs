// A page of the viewer in a browser without a screen: its controls by the names that they have for
// everybody, and what goes wrong in it.
import puppeteer from 'puppeteer-core';

const WAIT_MS = 60_000;  // Software rendering on a busy machine.

// Errors that a browser logs for a server that was stopped on purpose, and for a tile that left the
// map between the news of it and the request, which TileLoader takes as such.
const EXPECTED =
    /ERR_CONNECTION_REFUSED|ERR_INCOMPLETE_CHUNKED|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE|status of 404.*\/tiles\//;

export class Page {
  problems = [];
  expected = [];  // Patterns of what a step provokes.

  static async open(chromium, folder) {
    const page = new Page();
    page.folder = folder;
    page.browser = await puppeteer.launch({
      executablePath: chromium,
      args: ['--use-angle=swiftshader', '--use-gl=angle', '--enable-unsafe-swiftshader', '--no-sandbox',
             '--lang=en'],
      defaultViewport: {width: 1280, height: 800},
      protocolTimeout: 3 * WAIT_MS,
    });
    page.page = await page.browser.newPage();
    page.page.setDefaultTimeout(WAIT_MS);
    page.page.on('pageerror', (error) => page.problems.push(error.stack ?? error.message));
    page.page.on('console', (message) => {
      const text = `${message.text()} ${message.location()?.url ?? ''}`;
      const fine = EXPECTED.test(text) || page.expected.some((pattern) => pattern.test(text));
      if (['error', 'warn'].includes(message.type()) && !fine) page.problems.push(text);
    });
    return page;
  }

  goto(url) {
    return this.page.goto(url);
  }

  // By accessible name, within what `scope` selects. One that news took away before it was pressed
  // is looked for again.
  async click(name, scope = '') {
    for (let tries = 0; ; ++tries) {
      const target = await this.find(name, scope);
      try {
        await target.evaluate((element) => element.scrollIntoView({block: 'center'}));
        return await target.click();
      } catch (error) {
        if (tries === 5 || !/detached|not clickable/.test(error.message)) throw error;
      }
    }
  }

  async find(name, scope = '', role = '') {
    const aria = `::-p-aria([name="${name}"]${role ? `[role="${role}"]` : ''})`;
    return this.page.waitForSelector(scope ? `${scope} ${aria}` : aria, {visible: true});
  }

  async choose(name, value) {
    const select = await this.find(name, '', 'combobox');
    await select.select(value);
  }

  async type(name, text, scope = '') {
    const field = await this.find(name, scope);
    await field.evaluate((element) => (element.value = ''));
    await field.type(text);
    await field.evaluate((element) => element.dispatchEvent(new Event('change')));
  }

  key(code) {
    return this.page.keyboard.press(code);
  }

  async drag(from, to) {
    const {mouse} = this.page;
    await mouse.move(...from);
    await mouse.down();
    await mouse.move((from[0] + to[0]) / 2, (from[1] + to[1]) / 2);
    await mouse.move(...to);
    await mouse.up();
  }

  // Waits until `condition`, an expression of the page, holds.
  until(condition, ms = WAIT_MS) {
    return this.page.waitForFunction(condition, {timeout: ms, polling: 200});
  }

  value(expression) {
    return this.page.evaluate(expression);
  }

  async text(text, scope = 'body') {
    await this.until(`document.querySelector(${JSON.stringify(scope)})?.innerText
        .toLowerCase().includes(${JSON.stringify(text.toLowerCase())})`);
  }

  async shot(name) {
    if (this.folder) await this.page.screenshot({path: `${this.folder}/${name}.png`});
  }

  // The roles of controls that have no name.
  async nameless() {
    const tree = await this.page.accessibility.snapshot({interestingOnly: false});
    const roles = ['button', 'checkbox', 'combobox', 'textbox', 'spinbutton', 'slider', 'tab'];
    const found = [];
    const walk = (node) => {
      if (roles.includes(node.role) && !node.name) found.push(node.role);
      (node.children ?? []).forEach(walk);
    };
    walk(tree);
    return found;
  }

  // The texts of disabled buttons that do not say why.
  dead() {
    return this.value(`[...document.querySelectorAll('button:disabled')].filter((button) =>
        !button.title && !button.closest('fieldset[title]')).map((button) => button.textContent)`);
  }

  close() {
    return this.browser.close();
  }
}
