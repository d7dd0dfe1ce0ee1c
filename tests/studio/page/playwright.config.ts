import { defineConfig } from "@playwright/test";

export default defineConfig({
  testDir: ".",
  testMatch: "*.spec.mjs",
  outputDir: `${process.env.STUDIO_OUT}/results`,
  // Software rendering on few cores: what takes a person's second may take ten here.
  timeout: 120_000,
  expect: { timeout: 20_000 },
  workers: 1,
  retries: 0,
  reporter: [["list"]],
  use: {
    viewport: { width: 1500, height: 950 },
    screenshot: "only-on-failure",
    // Tracing takes a picture of every change on the page, with software rendering a large part of the whole time.
    trace: process.env.STUDIO_TRACE ? "retain-on-failure" : "off",
    actionTimeout: 20_000,
    launchOptions: {
      executablePath: process.env.CHROMIUM,
      args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
    },
  },
});
