// A headless Chromium for tests.
import assert from "node:assert/strict";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

const program = process.env.CHROMIUM ?? ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find(existsSync);

/** Runs a function with a browser that has a folder of its own, and goes afterwards. */
export async function withBrowser(use) {
  const folder = mkdtempSync(join(tmpdir(), "overcoat-browser-"));
  const browser = await chromium.launchPersistentContext(folder, {
    executablePath: program,
    headless: true,
    viewport: { width: 1200, height: 850 },
    args: [
      "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
      "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
    ],
  });
  try {
    return await use(browser);
  } finally {
    await browser.close();
    rmSync(folder, { recursive: true, force: true });
  }
}

/** Runs a function with a page of a server; fails if the page asks another one, or an error is not handled. */
export function withPageOf(server, use) {
  return withBrowser(async (browser) => {
    const page = await browser.newPage();
    const trouble = [];
    page.on("pageerror", (error) => trouble.push(error.stack));
    page.on("request", (request) => {
      const url = request.url();
      if (!url.startsWith(server.url) && !/^(blob|data):/.test(url)) trouble.push(`asks for ${url}`);
    });
    await use(page);
    assert.deepEqual(trouble, []);
  });
}
