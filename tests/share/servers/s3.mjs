// An S3 store for the tests: s3rver keeps the objects, and in front of it every request is signed
// again by the signer of Amazon's own SDK. A request with another signature is refused, and so is a
// body that is not what its hash says; s3rver itself does not look at version 4 signatures.
//
// node s3.mjs FOLDER BUCKET SECRET REGION [no-conditions]
// Prints "port N" when it is ready. The key is S3RVER, the one that s3rver knows.
import { createHash } from "node:crypto";
import http from "node:http";
import { Sha256 } from "@aws-crypto/sha256-js";
import { SignatureV4 } from "@smithy/signature-v4";
import S3rver from "s3rver";

const [folder, bucket, secret, region, ...options] = process.argv.slice(2);
const store = new S3rver({
  address: "127.0.0.1",
  port: 0,
  silent: true,
  directory: folder,
  configureBuckets: [{ name: bucket }],
});
const { port: storePort } = await store.run();

function refuse(response, status, code, message) {
  response.writeHead(status, { "content-type": "application/xml" });
  response.end(`<?xml version="1.0"?><Error><Code>${code}</Code><Message>${message}</Message></Error>`);
}

// Empty, or what is wrong with the signature.
async function judge(request, body) {
  const authorization = request.headers.authorization ?? "";
  const match =
    /^AWS4-HMAC-SHA256 Credential=([^/]+)\/(\d{8})\/([^/]+)\/s3\/aws4_request, ?SignedHeaders=([^,]+), ?Signature=([0-9a-f]{64})$/.exec(
      authorization,
    );
  if (!match) return ["AccessDenied", "the request is not signed"];
  const [, key, , signedRegion, names, signature] = match;
  if (key !== "S3RVER") return ["InvalidAccessKeyId", "there is no such key"];
  if (signedRegion !== region) return ["AuthorizationHeaderMalformed", `the region is ${region}`];
  const date = request.headers["x-amz-date"] ?? "";
  const when = new Date(
    date.replace(/^(\d{4})(\d\d)(\d\d)T(\d\d)(\d\d)(\d\d)Z$/, "$1-$2-$3T$4:$5:$6Z"),
  );
  if (!(Math.abs(Date.now() - when) < 900e3)) return ["RequestTimeTooSkewed", "look at the clock"];
  const hash = createHash("sha256").update(body).digest("hex");
  if (request.headers["x-amz-content-sha256"] !== hash) {
    return ["XAmzContentSHA256Mismatch", "the body is not what its hash says"];
  }
  const signed = names.split(";");
  for (const name of Object.keys(request.headers)) {
    if ((name.startsWith("x-amz-") || name === "host") && !signed.includes(name)) {
      return ["AccessDenied", `the header ${name} is not signed`];
    }
  }
  const url = new URL(request.url, `http://${request.headers.host}`);
  const signer = new SignatureV4({
    credentials: { accessKeyId: key, secretAccessKey: secret },
    region,
    service: "s3",
    sha256: Sha256,
    uriEscapePath: false,
    applyChecksum: false,
  });
  const query = {};
  for (const [name, value] of url.searchParams) query[name] = value;
  const again = await signer.sign(
    {
      method: request.method,
      protocol: "http:",
      hostname: url.hostname,
      path: request.url.split("?")[0],
      query,
      headers: Object.fromEntries(signed.map((name) => [name, request.headers[name] ?? ""])),
    },
    { signingDate: when, signableHeaders: new Set(signed), unsignableHeaders: new Set() },
  );
  if (again.headers.authorization.split("Signature=")[1] !== signature) {
    return ["SignatureDoesNotMatch", "the signature is another one"];
  }
  return null;
}

const server = http.createServer((request, response) => {
  const pieces = [];
  request.on("error", () => {});
  request.on("data", (piece) => pieces.push(piece));
  request.on("end", async () => {
    const body = Buffer.concat(pieces);
    const fault = await judge(request, body);
    if (fault) return refuse(response, 403, ...fault);
    if (options.includes("no-conditions") && request.headers["if-none-match"]) {
      return refuse(response, 501, "NotImplemented", "a header is not implemented");
    }
    const headers = { ...request.headers, "content-length": body.length };
    delete headers["transfer-encoding"];
    delete headers.expect;
    const onward = http.request(
      { host: "127.0.0.1", port: storePort, method: request.method, path: request.url, headers },
      (answer) => {
        response.writeHead(answer.statusCode, answer.headers);
        answer.pipe(response);
      },
    );
    onward.on("error", () => response.destroy());
    onward.end(body);
  });
});
server.listen(0, "127.0.0.1", () => console.log(`port ${server.address().port}`));
