// The module of PhysX. Its package refuses Node.js: it runs in a context that looks like a page.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import vm from 'node:vm';

/** `adapter`: the folder of the built backend, with the package. */
export async function loadPhysx(adapter) {
  const engine = join(adapter, 'node_modules/physx-js-webidl/physx-js-webidl');
  const page = vm.createContext({ console, WebAssembly, TextDecoder, performance, setTimeout, URL,
    location: { href: 'http:' }, navigator: { languages: ['en'] }, document: { currentScript: null } });
  page.window = page.self = page;
  vm.runInContext(
    readFileSync(`${engine}.mjs`, 'utf8')
      .replace(/export default PhysX;?/, 'globalThis.PhysX = PhysX;')
      .replace(/import\.meta\.url/g, '"file:///page"'),
    page,
  );
  return page.PhysX({ wasmBinary: readFileSync(`${engine}.wasm`) });
}
