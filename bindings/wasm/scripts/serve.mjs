// Serves a folder, without one that of the package, to the same machine: node scripts/serve.mjs [PORT] [FOLDER]. Nothing else is needed
// for the demo page.
import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("..", import.meta.url));
const TYPES = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript",
  ".mjs": "text/javascript",
  ".css": "text/css",
  ".wasm": "application/wasm",
  ".glb": "model/gltf-binary",
};

/** A server of the folder on a port of 127.0.0.1; 0 takes a free one. */
export async function serve(port = 0, folder = root) {
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://x").pathname));
    let file = join(folder, path);
    try {
      if (path.endsWith("/")) file = join(file, "index.html");
      if (!(await stat(file)).isFile()) throw new Error("no file");
      response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
      createReadStream(file).pipe(response);
    } catch {
      response.writeHead(404, { "content-type": "text/plain" }).end("not found");
    }
  });
  await new Promise((resolve) => server.listen(port, "127.0.0.1", resolve));
  return { url: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const folder = process.argv[3];
  const { url } = await serve(Number(process.argv[2] ?? 8080), folder && resolve(folder));
  console.log(folder ? `${url}/` : `${url}/demo/`);
}
