// A proxy in front of a store, with one fault.
//
// node faults.mjs TARGET_PORT FAULT [KEY CERTIFICATE]
//   none                    hands everything on
//   busy:N                  the first N requests get 503
//   cut:BYTES:N             the first N packages that are fetched break off after BYTES
//   die:BYTES               when a package is put, the server is gone after BYTES
//   lose:N                  the first N PUTs arrive, but the answer does not
//   change                  one byte of every package that is fetched is another
//   grow                    every answer to a GET has no length and does not end
//   redirect                sends everybody elsewhere
//   silent                  takes requests and says nothing
// With KEY and CERTIFICATE it speaks TLS. Prints "port N" when it is ready, and at the end of its
// input it ends.
import { readFileSync } from "node:fs";
import http from "node:http";
import https from "node:https";

const [target, fault, key, certificate] = process.argv.slice(2);
const [kind, ...numbers] = fault.split(":");
let left = Number(numbers.at(-1));

function handle(request, response) {
  request.on("error", () => {});
  response.on("error", () => {});
  const isPackage = request.url.endsWith(".cogrsim.zip");
  if (kind === "silent") return;
  if (kind === "redirect") {
    response.writeHead(302, { location: "http://127.0.0.1:1/" });
    return response.end();
  }
  if (kind === "busy" && left-- > 0) {
    request.resume();
    response.writeHead(503, { "retry-after": "0" });
    return response.end("busy");
  }
  if (kind === "grow" && request.method === "GET") {
    response.writeHead(200);
    const piece = Buffer.alloc(1 << 20, 0x20);
    const more = () => {
      while (!response.destroyed && response.write(piece));
    };
    response.on("drain", more);
    return more();
  }
  if (kind === "die" && request.method === "PUT" && isPackage) {
    let got = 0;
    request.on("data", (piece) => {
      got += piece.length;
      if (got >= Number(numbers[0])) process.exit(1);
    });
    return;
  }
  const onward = http.request(
    {
      host: "127.0.0.1",
      port: Number(target),
      method: request.method,
      path: request.url,
      headers: request.headers,
    },
    (answer) => {
      if (kind === "lose" && request.method === "PUT" && left-- > 0) {
        answer.resume();
        return answer.on("end", () => request.socket.destroy());
      }
      const pieces = [];
      answer.on("data", (piece) => pieces.push(piece));
      answer.on("end", () => {
        const body = Buffer.concat(pieces);
        const whole = request.method === "GET" && isPackage && answer.statusCode === 200;
        if (whole && kind === "change") body[body.length >> 1] ^= 0x40;
        response.writeHead(answer.statusCode, { ...answer.headers, "content-length": body.length });
        if (whole && kind === "cut" && left-- > 0) {
          return response.write(body.subarray(0, Number(numbers[0])), () =>
            request.socket.destroy(),
          );
        }
        response.end(body);
      });
    },
  );
  onward.on("error", () => response.destroy());
  request.pipe(onward);
}

const server = key
  ? https.createServer({ key: readFileSync(key), cert: readFileSync(certificate) }, handle)
  : http.createServer(handle);
server.on("checkContinue", (request, response) => {
  response.writeContinue();
  handle(request, response);
});
server.listen(0, "127.0.0.1", () => console.log(`port ${server.address().port}`));
process.stdin.on("end", () => process.exit(0));
process.stdin.resume();
