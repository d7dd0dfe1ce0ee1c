// Scenes of an engine in another process: positions of bodies after a second in steps of 1 ms, by a raw program and by
// the backend, are equal bit for bit.
//   node ENGINE.mjs COGRSIM ADAPTERS SCRATCH
import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';

const [cogrsim, folderOfAdapters, scratch] = process.argv.slice(2).map((path) => resolve(path));
export const adapters = folderOfAdapters;

/**
 * Ends the process, with the status 1 if a body is elsewhere. `cases`: by name { gravity: 'x y z', scene: what the scene has,
 * … }. `raw`: positions by body of a case.
 */
export function beside(backend, cases, raw) {
  mkdirSync(scratch, { recursive: true });
  let same = true;
  for (const [name, it] of Object.entries(cases)) {
    const file = join(scratch, `${name}.scene.xml`);
    writeFileSync(
      file,
      `<scene name="${name}" version="1">
  <physics backend="${backend}" step="1 ms" duration="1 s" gravity="${it.gravity}"/>
  ${it.scene}
</scene>
`,
    );
    const json = execFileSync(cogrsim, ['run', file, '--plugin-path', adapters, '--json', '-'], {
      encoding: 'utf8',
      cwd: scratch,
      stdio: ['ignore', 'pipe', 'ignore'],
    });
    const { bodies } = JSON.parse(json);
    for (const [body, position] of Object.entries(raw(it))) {
      const [alone, ours] = [position, bodies[body].position].map((p) => JSON.stringify(p));
      console.log(body, '\n  raw    ', alone, '\n  adapter', ours);
      same &&= alone === ours;
    }
  }
  process.exit(same ? 0 : 1);
}
