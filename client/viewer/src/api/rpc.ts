// Calls over HTTP: a JSON object in, an object (or one per line) out. The token is in a cookie that
// scripts cannot read.
import {released} from '../press';
import {num, obj, str, type JsonObject} from './json';

export class RpcError extends Error {
  // `code` is gRPC's, by name, or UNAVAILABLE where nobody answered.
  constructor(readonly code: string, message: string, readonly retryAfterS = 0) {
    super(message);
  }
}

export function isAbort(error: unknown): boolean {
  return error instanceof DOMException && error.name === 'AbortError';
}

export function message(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

// Answers come when no control is being pressed, see press.ts.
export class Rpc {
  // `site`: empty for the server's own.
  constructor(readonly site: string) {}

  async call(method: string, request: JsonObject, signal?: AbortSignal): Promise<JsonObject> {
    const response = await this.post(method, request, signal);
    const answer = (await response.json()) as JsonObject;
    await released();
    return answer;
  }

  // Each response of a server's stream as it comes.
  async *stream(method: string, request: JsonObject, signal?: AbortSignal):
      AsyncGenerator<JsonObject> {
    const response = await this.post(method, request, signal);
    if (!response.body) return;
    for await (const line of lines(response.body)) {
      await released();
      yield line;
    }
  }

  // All responses of a list.
  async list(method: string, request: JsonObject, signal?: AbortSignal): Promise<JsonObject[]> {
    const responses: JsonObject[] = [];
    for await (const one of this.stream(method, request, signal)) responses.push(one);
    return responses;
  }

  // GET; the caller looks at the status 304.
  async get(path: string, headers: Record<string, string>, signal?: AbortSignal):
      Promise<Response> {
    const response = await reach(this.url(path), {headers, ...(signal ? {signal} : {})});
    if (!response.ok && response.status !== 304) throw await failure(response);
    return response;
  }

  url(path: string): string {
    if (!this.site) return path;
    return `${path}${path.includes('?') ? '&' : '?'}site=${encodeURIComponent(this.site)}`;
  }

  async login(token: string): Promise<void> {
    const response = await reach('/login', post({token}, this.site));
    if (!response.ok) throw await failure(response);
  }

  async logout(): Promise<void> {
    await reach('/logout', post({}, this.site));
  }

  private async post(method: string, request: JsonObject, signal?: AbortSignal):
      Promise<Response> {
    const init = post(request, this.site);
    if (signal) init.signal = signal;
    const response = await reach(`/rpc/isthmus.v1.${method}`, init);
    if (!response.ok) throw await failure(response);
    return response;
  }
}

function post(body: JsonObject, site: string): RequestInit {
  const headers: Record<string, string> = {'Content-Type': 'application/json'};
  if (site) headers['isthmus-site'] = site;
  return {method: 'POST', headers, body: JSON.stringify(body)};
}

async function reach(url: string, init: RequestInit): Promise<Response> {
  try {
    return await fetch(url, init);
  } catch (error) {
    if (isAbort(error)) throw error;
    throw new RpcError('UNAVAILABLE', 'The server does not answer.');
  }
}

async function failure(response: Response): Promise<RpcError> {
  const retry = num(response.headers.get('Retry-After') ?? 0);
  let code = response.status === 401 ? 'UNAUTHENTICATED' : 'UNKNOWN';
  if (response.status === 502 || response.status === 503) code = 'UNAVAILABLE';
  let text = `The server answered with HTTP ${response.status}.`;
  try {
    const body = obj(await response.json());
    code = str(body['code']) || code;
    text = str(body['message']) || text;
  } catch {
    // Not from the server itself, but from something in front of it: the status has to do.
  }
  return new RpcError(code, text, Number.isFinite(retry) ? retry : 0);
}

// Objects, one per line; a last line {"error": ...} ends them with what it says.
export async function* lines(body: ReadableStream<Uint8Array>): AsyncGenerator<JsonObject> {
  const reader = body.getReader();
  const decoder = new TextDecoder();
  let rest = '';
  try {
    for (;;) {
      const {done, value} = await read(reader);
      rest += done ? decoder.decode() : decoder.decode(value, {stream: true});
      const complete = rest.split('\n');
      rest = done ? '' : (complete.pop() ?? '');
      for (const line of complete) if (line.trim()) yield parseLine(line);
      if (done) return;
    }
  } finally {
    reader.cancel().catch(() => undefined);
  }
}

// The server writes an empty line every 5 s where it has nothing to say: who is silent for longer is
// gone, though the connection may not know it yet.
const SILENCE_MS = 20_000;

async function read(reader: ReadableStreamDefaultReader<Uint8Array>) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const silence = new Promise<never>((_, reject) => {
    timer = setTimeout(
        () => reject(new RpcError('UNAVAILABLE', 'The server has gone silent.')), SILENCE_MS);
  });
  try {
    return await Promise.race([reader.read(), silence]);
  } catch (error) {
    if (isAbort(error) || error instanceof RpcError) throw error;
    throw new RpcError('UNAVAILABLE', 'The connection to the server broke.');
  } finally {
    clearTimeout(timer);
  }
}

function parseLine(line: string): JsonObject {
  let parsed: JsonObject;
  try {
    parsed = obj(JSON.parse(line));
  } catch {
    throw new RpcError('UNAVAILABLE', 'The connection to the server broke in the middle.');
  }
  const error = parsed['error'];
  if (error === undefined) return parsed;
  throw new RpcError(str(obj(error)['code']) || 'UNKNOWN', str(obj(error)['message']));
}
