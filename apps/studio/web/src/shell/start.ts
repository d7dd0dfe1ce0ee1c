import type { Link } from "../core/link";
import { wire } from "../core/wire";
import { App } from "./app";
import { recall } from "./memory";
import { showStartPage } from "./start_page";
import "./shell.css";

/** Lays out the page; all it shows comes over `link`. */
export function start(link: Link): App {
  const app = new App(link, new URLSearchParams(location.search).get("panel") ?? "");
  const chosen = recall("theme");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  app.state.theme.value = chosen === "dark" || chosen === "light" ? chosen : dark.matches ? "dark" : "light";
  dark.addEventListener("change", () => {
    if (recall("theme") === null) app.state.theme.value = dark.matches ? "dark" : "light";
  });
  wire(
    link,
    app.state,
    (message) => app.notify(message, "error"),
    () => app.renew(),
    () => showStartPage(link),
  );
  app.show();
  addEventListener("pagehide", ({ persisted }) => {
    if (!persisted) app.services.dispose();
  });
  return app;
}
