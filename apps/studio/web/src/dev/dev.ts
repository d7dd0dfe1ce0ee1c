// The page with a made-up run: node build.mjs --dev --out DIR, then serve DIR and open dev.html[?recording].
import { start } from "../shell/start";
import { DemoLink } from "./demo_link";

start(new DemoLink(new URLSearchParams(location.search).has("recording")));
