// Evaluates the networks that judge_networks.cpp wrote into the present folder, and compares with what it computed.
//
// Tolerance: a sum of n products in float32 is off by about sqrt(n) u S, where u = 2^-24 and S is the sum of
// their sizes (Higham and Mary, A New Approach to Probabilistic Rounding Error Analysis, 2019). Here n <= 128,
// S <= sqrt(n) / 2 as weights are within 1 / sqrt(n) of 0 and inputs within 1, so 4e-6 for each of the two
// programs; the layers before contribute less, as weights contract. Networks of others have more of both: their
// differences are also printed relative to max(1, |value|), and the bound is the same.
import {readFileSync, readdirSync} from 'node:fs';
import {Tensor, InferenceSession} from 'onnxruntime-node';

const kTolerance = 1e-5;
let worst = 0;
let bad = 0;
for (const file of readdirSync('.').filter(name => name.endsWith('.onnx')).sort()) {
  const floats = ending => {
    const bytes = readFileSync(file.replace('.onnx', ending));
    return new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
  };
  const ports = JSON.parse(readFileSync(file.replace('.onnx', '.json'), 'utf8'));
  const [given, expected] = [floats('.in'), floats('.out')];
  const session = await InferenceSession.create(file, {intraOpNumThreads: 1, logSeverityLevel: 3});
  let [read, compared, largest, relative, count] = [0, 0, 0, 0, 0];
  while (read < given.length) {
    const feeds = {};
    for (const {name, shape} of ports.inputs) {
      const size = shape.reduce((a, b) => a * b, 1);
      feeds[name] = new Tensor('float32', given.slice(read, read + size), shape);
      read += size;
    }
    const results = await session.run(feeds);
    for (const {name} of ports.outputs)
      for (const value of results[name].data) {
        const off = Math.abs(value - expected[compared++]);
        const part = off / Math.max(1, Math.abs(value));
        largest = off <= largest ? largest : off;  // NaN is not small
        relative = part <= relative ? relative : part;
      }
    ++count;
  }
  if (compared !== expected.length) throw Error(`${file}: ${compared} values, expected ${expected.length}`);
  console.log(`${file.padEnd(18)} ${count} observations, largest difference ${largest.toExponential(2)}, ` +
    `relative to max(1, |value|) ${relative.toExponential(2)}`);
  if (!(largest <= kTolerance)) ++bad;
  worst = largest <= worst ? worst : largest;
}
console.log(`largest of all ${worst.toExponential(2)}, allowed ${kTolerance}`);
process.exit(bad === 0 && worst > 0 ? 0 : 1);
