// A real server with its web address, on a folder of its own, and the commands that ask it.
import {spawn} from 'node:child_process';
import {once} from 'node:events';
import {mkdtemp, rm, writeFile} from 'node:fs/promises';
import {createServer} from 'node:net';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

async function freePort() {
  const server = createServer().listen(0, '127.0.0.1');
  await once(server, 'listening');
  const {port} = server.address();
  server.close();
  await once(server, 'close');
  return port;
}

export class Server {
  static async make(bin) {
    const server = new Server();
    server.bin = bin;
    server.folder = await mkdtemp(join(tmpdir(), 'isthmus-viewer-'));
    server.address = `127.0.0.1:${await freePort()}`;
    server.url = `http://127.0.0.1:${await freePort()}`;
    await writeFile(join(server.folder, 'server.yaml'),
                    `web: {listen: '${server.url.slice(7)}'}\n`);
    return server;
  }

  async start() {
    this.process = spawn(join(this.bin, 'isthmus-server'), [
      '--data', join(this.folder, 'map'), '--config', join(this.folder, 'server.yaml'),
      '--listen', this.address,
    ], {stdio: ['ignore', 'ignore', 'pipe']});
    this.log = '';
    this.process.stderr.on('data', (data) => (this.log = (this.log + data).slice(-4000)));
    for (let i = 0; i < 150; i++) {
      if (this.process.exitCode !== null) throw new Error(`the server ended:\n${this.log}`);
      const up = await fetch(`${this.url}/healthz`).catch(() => undefined);
      if (up?.ok) return;
      await new Promise((resolve) => setTimeout(resolve, 200));
    }
    throw new Error(`the server does not answer:\n${this.log}`);
  }

  async stop() {
    if (!this.process || this.process.exitCode !== null) return;
    this.process.kill('SIGTERM');
    await once(this.process, 'exit');
  }

  // Runs `isthmus`; its answer.
  async run(...args) {
    const child = spawn(join(this.bin, 'isthmus'), args, {
      env: {...process.env, ISTHMUS_SERVER: this.address}, stdio: ['ignore', 'pipe', 'pipe'],
    });
    let out = '';
    let err = '';
    child.stdout.on('data', (data) => (out += data));
    child.stderr.on('data', (data) => (err += data));
    const [code] = await once(child, 'close');
    if (code !== 0) throw new Error(`isthmus ${args.join(' ')} ended with ${code}:\n${err}`);
    return out;
  }

  path(name) {
    return join(this.folder, name);
  }

  async remove() {
    await this.stop();
    await rm(this.folder, {recursive: true, force: true});
  }
}
