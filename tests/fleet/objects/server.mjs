// s3rver behind a check of signatures: it takes any of version 4, so another implementation (aws4)
// signs each request anew, and compares. Usage: node server.mjs PORT FOLDER; 0: a free port.
import {createHash} from 'node:crypto';
import http from 'node:http';
import {createRequire} from 'node:module';

const fromWork = createRequire(process.cwd() + '/');
const aws4 = fromWork('aws4');
const S3rver = fromWork('s3rver');
const key = {accessKeyId: 'S3RVER', secretAccessKey: 'S3RVER'};
const [port, directory] = process.argv.slice(2);

function whatIsWrong(request, body) {
  const given = request.headers.authorization ?? '';
  const parts = /Credential=[^/]+\/\d+\/([^/]+)\/s3\/aws4_request, *SignedHeaders=([^,]+), *Signature=/i.exec(given);
  if (!parts) return 'AccessDenied';
  const hash = createHash('sha256').update(body).digest('hex');
  if (request.headers['x-amz-content-sha256'] !== hash) return 'XAmzContentSHA256Mismatch';
  const headers = {};
  for (const name of parts[2].split(';')) headers[name] = request.headers[name];
  const signed = aws4.sign({service: 's3', region: parts[1], method: request.method,
    host: request.headers.host, path: request.url, headers: {...headers}}, key);
  const signature = /Signature=(\w+)/.exec(signed.headers.Authorization)[1];
  return given.endsWith('Signature=' + signature) ? null : 'SignatureDoesNotMatch';
}

function refuse(response, code) {
  response.writeHead(403, {'content-type': 'application/xml'});
  response.end(`<Error><Code>${code}</Code><Message>refused</Message></Error>`);
}

const inner = new S3rver({address: '127.0.0.1', port: 0, directory, silent: true,
  vhostBuckets: false, configureBuckets: [{name: 'maps'}]});
const {port: innerPort} = await inner.run();
const server = http.createServer((request, response) => {
  const chunks = [];
  request.on('data', chunk => chunks.push(chunk));
  request.on('end', () => {
    const body = Buffer.concat(chunks);
    const wrong = whatIsWrong(request, body);
    if (wrong) return refuse(response, wrong);
    const {method, url: path, headers} = request;
    const passed = http.request({host: '127.0.0.1', port: innerPort, method, path, headers},
      answer => {
        response.writeHead(answer.statusCode, answer.headers);
        answer.pipe(response);
      });
    passed.on('error', () => response.destroy());
    passed.end(body);
  });
});
server.listen(Number(port), '127.0.0.1',
  () => console.log(`listening on 127.0.0.1:${server.address().port}`));
