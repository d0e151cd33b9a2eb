import {defineConfig} from 'vite';

// The folder that the build goes to, the server that `npm run dev` passes calls on to.
const out = process.env['ISTHMUS_VIEWER_OUT'] ?? 'dist';
const server = process.env['ISTHMUS_WEB'] ?? 'http://127.0.0.1:8180';
const proxied = ['/rpc', '/tiles', '/export', '/login', '/logout', '/healthz'];

export default defineConfig({
  base: './',
  build: {
    outDir: out,
    emptyOutDir: true,
    target: 'es2022',
    // The server forbids inline scripts and styles: nothing is inlined, nothing polyfilled.
    assetsInlineLimit: 0,
    modulePreload: {polyfill: false},
    chunkSizeWarningLimit: 1000,
  },
  server: {
    // The host stays as the page has it: the server takes calls of its own pages alone.
    proxy: Object.fromEntries(proxied.map((path) => [path, {target: server}])),
  },
});
