// FOR DEVELOPMENT ONLY: a stand-in for isthmus-server that makes up a building and two robots in it,
// so that the page can be worked on without one. It speaks what the page asks for and no more.
// Usage: node dev/mock.mjs [--port 8180] [--folder dist] [--token SECRET] [--empty]
import {createServer} from 'node:http';
import {readFile} from 'node:fs/promises';
import {extname, join, normalize} from 'node:path';
import {parseArgs} from 'node:util';
import {World} from './mock_world.mjs';

const {values: options} = parseArgs({options: {
  port: {type: 'string', default: '8180'}, folder: {type: 'string', default: 'dist'},
  token: {type: 'string', default: ''}, empty: {type: 'boolean', default: false},
}});
const world = new World(options.empty, options.token);
const CSP = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; " +
    "connect-src 'self'; worker-src 'self' blob:; base-uri 'none'; form-action 'none'; " +
    "frame-ancestors 'none'";
const TYPES = {'.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css',
               '.svg': 'image/svg+xml'};

function fail(response, status, code, message) {
  response.writeHead(status, {'Content-Type': 'application/json'});
  response.end(JSON.stringify({code, message}));
}

async function body(request) {
  const parts = [];
  for await (const part of request) parts.push(part);
  return JSON.parse(Buffer.concat(parts).toString() || '{}');
}

function rpc(method, asked, response) {
  const answer = world.call(method, asked);
  if (answer.error) return fail(response, answer.status, answer.error, answer.message);
  if (answer.one) {
    response.writeHead(200, {'Content-Type': 'application/json'});
    return response.end(JSON.stringify(answer.one));
  }
  response.writeHead(200, {'Content-Type': 'application/x-ndjson'});
  for (const line of answer.lines) response.write(JSON.stringify(line) + '\n');
  if (!answer.follow) return response.end();
  const beat = setInterval(() => response.write('\n'), 5000);
  const stop = answer.follow((line) => response.write(JSON.stringify(line) + '\n'));
  response.on('close', () => (clearInterval(beat), stop()));
}

function tile(path, request, response) {
  const [component, level, x, y] = path.slice(7, -4).split('/').map(Number);
  const found = world.tile(component, level, x, y);
  if (!found) return fail(response, 404, 'NOT_FOUND', 'no such tile');
  const etag = `"${found.version}"`;
  if (request.headers['if-none-match'] === etag) return response.writeHead(304).end();
  response.writeHead(200, {ETag: etag, 'Cache-Control': 'no-cache, private',
                           'Isthmus-Robots': JSON.stringify(found.robots)});
  response.end(found.bytes);
}

async function file(path, response) {
  const name = normalize(path === '/' ? '/index.html' : path);
  try {
    const bytes = await readFile(join(options.folder, name));
    response.writeHead(200, {'Content-Type': TYPES[extname(name)] ?? 'application/octet-stream',
                             'Content-Security-Policy': CSP});
    response.end(bytes);
  } catch {
    fail(response, 404, 'NOT_FOUND', 'no such file');
  }
}

createServer(async (request, response) => {
  const path = new URL(request.url, 'http://localhost').pathname;
  if (path === '/login') {
    const {token} = await body(request);
    if (token !== options.token) {
      return fail(response, 401, 'UNAUTHENTICATED', 'This token does not hold: it is not known here.');
    }
    response.setHeader('Set-Cookie', `isthmus_token=${token}; HttpOnly; SameSite=Strict; Path=/`);
    return response.writeHead(200).end('{}');
  }
  if (path === '/logout') {
    response.setHeader('Set-Cookie', 'isthmus_token=; Max-Age=0; Path=/');
    return response.writeHead(200).end('{}');
  }
  const served = /^\/(rpc|tiles|export)\//.test(path);
  if (!served) return file(path, response);
  const known = (request.headers.cookie ?? '').includes(`isthmus_token=${options.token}`);
  if (options.token && !known) {
    return fail(response, 401, 'UNAUTHENTICATED', 'This call needs a token.');
  }
  if (path.startsWith('/tiles/')) return tile(path, request, response);
  if (path.startsWith('/export/')) {
    response.setHeader('Content-Disposition', 'attachment');
    return response.end('# .PCD v0.7\n');
  }
  rpc(path.slice('/rpc/isthmus.v1.'.length), await body(request), response);
}).listen(Number(options.port), '127.0.0.1',
          () => console.log(`mock server on http://127.0.0.1:${options.port}`));
