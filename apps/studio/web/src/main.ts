import { start } from "./shell/start";
import { SocketLink } from "./core/socket_link";

start(new SocketLink());
