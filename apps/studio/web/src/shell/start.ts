import type { Link } from "../core/link";
import { wire } from "../core/wire";
import { App } from "./app";
import "./shell.css";

/** Lays out the page; all it shows comes over `link`. */
export function start(link: Link): void {
  const app = new App(link);
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  app.state.theme.value = dark ? "dark" : "light";
  document.documentElement.dataset.theme = app.state.theme.value;
  wire(link, app.state, (message) => app.notify(message, "error"));
  app.show();
}
