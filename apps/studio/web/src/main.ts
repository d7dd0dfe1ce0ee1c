import { followKey, takeKey } from "./core/key";
import { SocketLink } from "./core/socket_link";
import { start } from "./shell/start";

const key = takeKey();
followKey(() => location.reload());
if (key !== "") {
  start(new SocketLink({ key }));
} else {
  const note = document.createElement("p");
  note.className = "cg-no-key";
  note.dataset.testid = "no-key";
  note.textContent =
    "This is CogRSim's studio, which needs a key: open the whole address, with its token, that `cogrsim studio` printed in the terminal.";
  document.body.append(note);
}
